"""A scene at one frequency: its walls' electrical properties as arrays for the kernels."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.materials import Material, material
from octant.geometries._arrays import frozen_array
from octant.geometries.scene import Scene


@dataclass(frozen=True, slots=True, kw_only=True)
class RadioScene:
    """A scene whose materials are resolved at one frequency.

    Parameters
    ----------
    scene : Scene
        Geometry.
    materials : tuple of Material
        One for each of ``scene.material_names``.
    frequency_hz : float
        Frequency [Hz].
    facet_permittivity : (f,) complex128
        Complex relative permittivity [-] of each facet; imaginary part -inf for PEC.
    facet_thickness_m : (f,) float64
        Thickness [m] of each facet's slab; infinity for a half-space.
    """

    scene: Scene
    materials: tuple[Material, ...]
    frequency_hz: float
    facet_permittivity: npt.NDArray[np.complex128]
    facet_thickness_m: npt.NDArray[np.float64]

    def __post_init__(self) -> None:
        n = len(self.scene.facets.facet_plane)
        eps = frozen_array(
            self.facet_permittivity,
            name="facet_permittivity",
            shape=(n,),
            dtype=np.complex128,
            finite=False,
        )
        thickness = frozen_array(
            self.facet_thickness_m, name="facet_thickness_m", shape=(n,), finite=False
        )
        object.__setattr__(self, "facet_permittivity", eps)
        object.__setattr__(self, "facet_thickness_m", thickness)

    @property
    def wavelength_m(self) -> float:
        """Wavelength in air [m]."""
        return SPEED_OF_LIGHT_M_PER_S / self.frequency_hz


def radio_scene(
    scene: Scene, frequency_hz: float, materials: Mapping[str, Material] | None = None
) -> RadioScene:
    """Return the scene with its material labels resolved at a frequency.

    Parameters
    ----------
    scene : Scene
        Geometry with material labels.
    frequency_hz : float
        Frequency [Hz].
    materials : mapping of str to Material, optional
        Meaning of labels; the others are looked up in the P.2040 table.

    Returns
    -------
    RadioScene
        Scene ready for tracing.

    Raises
    ------
    MaterialRangeError
        For an unknown label, or a frequency outside a material's range.
    """
    given = materials or {}
    resolved = tuple(
        given[name] if name in given else material(name) for name in scene.material_names
    )
    index = scene.facets.facet_material
    eps = np.array([m.relative_permittivity(frequency_hz) for m in resolved], dtype=np.complex128)
    thickness = np.array([np.inf if m.thickness_m is None else m.thickness_m for m in resolved])
    return RadioScene(
        scene=scene,
        materials=resolved,
        frequency_hz=frequency_hz,
        facet_permittivity=eps[index] if len(index) else np.zeros(0, np.complex128),
        facet_thickness_m=thickness[index] if len(index) else np.zeros(0),
    )
