"""Lengths below which two places, or two lengths, count as the same: one home for all layers."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class LengthTolerances:
    """Tolerances of lengths: absolute, per extent of a scene, and as a share of a length.

    Parameters
    ----------
    same_m : Difference that only rounding in float64 explains [m].
    joined_m : Distance within which corners of a reader's own mesh are one [m]: far below its
        shortest edge, far above what turning them about the axis rounds off.
    place_m : Distance that no wave of this package can tell from zero [m]: flatness of a plane, a
        place at a region's rim, two antennas at one place.
    weld_m : Distance within which vertices of a mesh file, or two image points, are one [m];
        float32 keeps 0.5 µm at 5 m.
    step_m : Step off a floor, a face or an obstacle after which a place is clearly beside it [m].
    facet_per_extent : Distance within which a point is on a facet, or a hit its segment's end [-].
    weld_per_extent : Distance within which vertices of a scene's bodies are one [-].
    plane_per_extent : Distance within which a corner stands on another triangle's edge and a point
        on a wall [-]: ten times float32's rounding, 0.001 degree of phase per metre at 2.4 GHz.
    hiding_per_extent : Margin within which a facet hides nothing at its rim or surface [-].
    step_per_extent : Step off a face that shows on which side of it the room is [-].
    same_share : Relative difference of two lengths that only rounding explains [-]: r_a = 0.1 m on
        a ground plane of 0.2 m is at its edge although cos and sin are rounded.
    turned_share : The same for a turned length, as a corner's in the reader's next sector [-].
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
