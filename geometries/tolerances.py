"""Lengths below which two places, or two lengths, count as the same: one home for all layers."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class LengthTolerances:
    """Tolerances of lengths: absolute, per extent of a scene, and as a share of a length.

    Parameters
    ----------
    same_m : Difference that only rounding in float64 explains [m].
    joined_m : Distance within which corners of a reader's own mesh are one corner [m]: far below
        its shortest edge, far above what turning the corners about the axis rounds off.
    place_m : Distance that no wave of this package can tell from zero [m]: flatness of a plane, a
        place at a region's rim, two antennas at one place.
    weld_m : Distance within which vertices of a mesh file, or two image points, are one [m];
        float32 keeps 0.5 µm at 5 m.
    step_m : Step off a floor, a face or an obstacle after which a place is clearly beside it [m].
    facet_per_extent : Distance per extent of the scene within which a point lies on a facet, and a
        hit is the end of its own segment [-].
    weld_per_extent : Distance per extent of the scene within which vertices of its bodies are one
        [-].
    plane_per_extent : Distance per extent of the scene within which a corner stands on another
        triangle's edge and a point on a wall [-]: ten times what float32 mesh files round off, a
        thousandth of a degree of phase per metre at 2.4 GHz.
    hiding_per_extent : Margin per extent of the scene within which a facet hides nothing at its rim
        or surface [-].
    step_per_extent : Step off a face, per extent of the scene, that shows on which side of it the
        room is [-].
    same_share : Relative difference of two lengths that only rounding explains [-]: r_a = 0.1 m on
        a ground plane of 0.2 m is at its edge although cos and sin are rounded.
    turned_share : The same for a length that was turned and searched for, such as the place of a
        mesh's corner in the next sector of the reader [-].
    """

    same_m: float = 1e-9
    joined_m: float = 1e-8
    place_m: float = 1e-6
    weld_m: float = 1e-5
    step_m: float = 1e-3
    facet_per_extent: float = 1e-9
    weld_per_extent: float = 1e-7
    plane_per_extent: float = 1e-6
    hiding_per_extent: float = 1e-5
    step_per_extent: float = 1e-3
    same_share: float = 1e-9
    turned_share: float = 1e-7


LENGTHS = LengthTolerances()
"""The tolerances in force."""
