"""A scene at one frequency: its walls' electrical properties as arrays for the kernels."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.medium.materials import Material, material
from octant.em.medium.reflection import wall_coefficients
from octant.geometries._arrays import frozen_array
from octant.geometries._bvh_kernels import BvhArrays
from octant.geometries.occlusion import build_bvh
from octant.geometries.scene import Scene
from octant.geometries.wedges import Wedges, no_wedges

OPAQUE_TRANSMISSION = 1e-10
"""Transmission [-] at normal incidence up to which sheets are opaque (-200 dB), as metal is."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RadioScene:
    """A scene whose materials are resolved at one frequency.

    Parameters
    ----------
    scene : Geometry.
    materials : One for each of ``scene.material_names``.
    frequency_hz : Frequency [Hz].
    layer_permittivity : (l,) complex128 — Relative permittivity [-] of all layers; PEC: - j inf.
    layer_thickness_m : (l,) float64 — Thickness [m] of all layers; infinity: all that lies behind.
    facet_layers : (f, 2) int64 — First layer of each facet and the one after its last, from the
        side that its normal points to.
    facet_transmits : (f,) bool — Whether waves pass straight through the facet [-].
    wedges : Edges that diffract; none when diffraction is left out.
    opaque_bvh, opaque_inner_bvh : Hierarchies of what blocks (no facet that transmits): all
        triangles, and those off the supporting planes.
    sheet_bvh : Hierarchy of the facets that transmit, its triangles numbered by facet.
    """

    scene: Scene
    materials: tuple[Material, ...]
    frequency_hz: float
    layer_permittivity: npt.NDArray[np.complex128]
    layer_thickness_m: npt.NDArray[np.float64]
    facet_layers: npt.NDArray[np.int64]
    facet_transmits: npt.NDArray[np.bool_]
    wedges: Wedges
    opaque_bvh: BvhArrays
    opaque_inner_bvh: BvhArrays
    sheet_bvh: BvhArrays

    def __post_init__(self) -> None:
        n, layers = len(self.scene.facets.facet_plane), len(self.layer_permittivity)
        eps = frozen_array(
            self.layer_permittivity,
            name="layer_permittivity",
            shape=(layers,),
            dtype=np.complex128,
            finite=False,
        )
        thickness = frozen_array(
            self.layer_thickness_m, name="layer_thickness_m", shape=(layers,), finite=False
        )
        ranges = frozen_array(self.facet_layers, name="facet_layers", shape=(n, 2), dtype=np.int64)
        through = frozen_array(
            self.facet_transmits, name="facet_transmits", shape=(n,), dtype=np.bool_
        )
        object.__setattr__(self, "layer_permittivity", eps)
        object.__setattr__(self, "layer_thickness_m", thickness)
        object.__setattr__(self, "facet_layers", ranges)
        object.__setattr__(self, "facet_transmits", through)

    @property
    def wavelength_m(self) -> float:
        """Wavelength in air [m]."""
        return SPEED_OF_LIGHT_M_PER_S / self.frequency_hz

    @property
    def opaque_facets(self) -> npt.NDArray[np.bool_]:
        """Whether each facet lets nothing through [-], (f,): what a search may count on."""
        opaque: npt.NDArray[np.bool_] = ~self.facet_transmits
        return opaque

    @property
    def transmits(self) -> bool:
        """Whether any facet lets waves through."""
        return bool(self.facet_transmits.any())


def radio_scene(
    scene: Scene,
    frequency_hz: float,
    materials: Mapping[str, Material] | None = None,
    *,
    transmission: bool = False,
    wedges: Wedges | None = None,
) -> RadioScene:
    """Return the scene with its material labels resolved at a frequency.

    A sheet is where its mesh is: waves go straight on, without the sideways shift of a thick slab,
    and get the slab's phase in place of the air's along the normal. Good for walls thin against the
    distances.

    Parameters
    ----------
    scene : Geometry with material labels.
    frequency_hz : Frequency [Hz].
    materials : Meaning of labels; the others are looked up in the P.2040 table.
    transmission : Whether sheets with a thickness let waves through; otherwise they only reflect.
    wedges : Edges that diffract, from :func:`octant.geometries.wedges.find_wedges`. Default: none.
    """
    given = materials or {}
    resolved = tuple(
        given[name] if name in given else material(name) for name in scene.material_names
    )
    stacks = [m.layer_stack(frequency_hz) for m in resolved]
    ends = np.cumsum([0, *(len(eps) for eps, _ in stacks)])
    index = scene.facets.facet_material
    passes = np.zeros(len(index), dtype=np.bool_)
    if transmission and len(index):
        passes = np.array([_lets_through(m, frequency_hz) for m in resolved])[index]
    opaque, opaque_inner, sheets = _hierarchies(scene, passes)
    none = np.zeros(0)
    return RadioScene(
        scene=scene,
        materials=resolved,
        frequency_hz=frequency_hz,
        layer_permittivity=np.concatenate([none, *(eps for eps, _ in stacks)]),
        layer_thickness_m=np.concatenate([none, *(d for _, d in stacks)]),
        facet_layers=np.column_stack((ends[index], ends[index + 1])).astype(np.int64),
        facet_transmits=passes,
        wedges=no_wedges() if wedges is None else wedges,
        opaque_bvh=opaque,
        opaque_inner_bvh=opaque_inner,
        sheet_bvh=sheets,
    )


def _lets_through(wall: Material, frequency_hz: float) -> bool:
    normal = wall_coefficients(wall, frequency_hz, 0.0)
    return bool(abs(normal.transmission_te[0]) > OPAQUE_TRANSMISSION)


def _hierarchies(
    scene: Scene, passes: npt.NDArray[np.bool_]
) -> tuple[BvhArrays, BvhArrays, BvhArrays]:
    """Return hierarchies of what blocks, of that off the supporting planes, and of what lets by."""
    facet, extent_m = scene.triangle_facet, scene.extent_m
    if not passes.any():
        nothing = build_bvh(np.zeros((0, 3, 3)), np.zeros(0, np.int64), extent_m=extent_m)
        return scene.bvh, scene.inner_bvh, nothing
    plane = scene.facets.facet_plane[facet]
    blocks = ~passes[facet]
    inner = blocks & (scene.supporting_side[plane] == 0)
    corners = scene.triangle_corners_m
    return (
        build_bvh(corners[blocks], plane[blocks], extent_m=extent_m),
        build_bvh(corners[inner], plane[inner], extent_m=extent_m),
        build_bvh(corners[~blocks], facet[~blocks], extent_m=extent_m),
    )
