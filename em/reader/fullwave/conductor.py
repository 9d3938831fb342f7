"""Metal that is not perfect: the surface impedance of sheets and of round wires."""

import cmath
import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave.rwg import VACUUM_PERMEABILITY
from octant.geometries._checks import positive_number
from octant.geometries.errors import AntennaError

THIN = 0.2
"""Thickness over the nearest distance [-] up to which sheets count as thin."""

DEEP = 1e-3
"""Skin depth over wavelength [-] up to which metal counts as a good conductor."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Conductor:
    """Non-magnetic metal of which sheets and wires are made.

    Parameters
    ----------
    conductivity_s_per_m : Conductivity [S/m].
    thickness_m : Thickness of sheets [m].
    roughness_factor : Resistance over that of a smooth surface [-], 1 or more.

    Notes
    -----
    A wave enters metal with gamma = (1 + j) / d, d the skin depth, over a surface impedance
    gamma / sigma, its resistance R_s = 1 / (sigma d) (Leontovich). The solver knows one current for
    both sides of a sheet. Where both carry half of it, as on a strip or a plate that stands free,
    the sheet has half of coth(gamma t / 2) gamma / sigma [1]_: R_s / 2 where it is thick, both
    sides in parallel, and 1 / (sigma t) where it is thin. Where one side carries everything, as on
    a plane close below an antenna, the heat is up to twice that: the true loss of sheets lies
    between what is found and twice as much. A wire of radius a has gamma I0(gamma a) / (2 pi a
    sigma I1(gamma a)) along each metre [2]_, which its strip of width 4 a is given.

    It holds where metal is a good conductor, where surfaces bend little within a skin depth (d
    much less than a sheet's radius of curvature; wires are exact), and where sheets are thin
    against the wavelength and against their distance from others: their edges and their thickness
    as a body are not solved. Roughness multiplies the resistance alone: Hammerstad's factor, from 1
    to 2 for one scale of roughness.

    References
    ----------
    .. [1] A. C. Polycarpou et al., IEEE Trans. Microw. Theory Tech. 44 (1996) 1063: sheets of
       finite thickness; S. A. Schelkunoff, Bell Syst. Tech. J. 13 (1934) 532, equation 82.
    .. [2] S. Ramo, J. R. Whinnery, T. Van Duzer, Fields and Waves in Communication Electronics,
       3rd ed. (1994), section 4.5, equation 12 in terms of J0 and J1.
    """

    conductivity_s_per_m: float
    thickness_m: float = 0.001
    roughness_factor: float = 1.0

    def __post_init__(self) -> None:
        positive_number(self.conductivity_s_per_m, name="conductivity_s_per_m", unit="S/m")
        positive_number(self.thickness_m, name="thickness_m")
        if not 1.0 <= self.roughness_factor < math.inf:
            msg = (
                f"roughness_factor is {self.roughness_factor}, but a rough surface resists at "
                "least as much as a smooth one; give 1 or more."
            )
            raise AntennaError(msg)

    def skin_depth_m(self, frequency_hz: float) -> float:
        """Return the depth at which fields have fallen to 1/e [m].

        Parameters
        ----------
        frequency_hz : Frequency [Hz].
        """
        return 1.0 / math.sqrt(
            math.pi * frequency_hz * VACUUM_PERMEABILITY * self.conductivity_s_per_m
        )

    def sheet_ohm(self, frequency_hz: float) -> complex:
        """Return the field over the current of both sides of a sheet [ohm].

        Parameters
        ----------
        frequency_hz : Frequency [Hz].
        """
        gamma = (1.0 + 1.0j) / self.skin_depth_m(frequency_hz)
        half = cmath.tanh(0.5 * gamma * self.thickness_m)
        return self._rough(0.5 * gamma / (self.conductivity_s_per_m * half))

    def wire_ohm(self, frequency_hz: float, radius_m: float) -> complex:
        """Return the same of a strip of width 4 a that stands for a wire of radius a [ohm].

        Parameters
        ----------
        frequency_hz, radius_m : Frequency [Hz]; radius a [m].
        """
        from scipy.special import ive

        gamma = (1.0 + 1.0j) / self.skin_depth_m(frequency_hz)
        ratio = complex(ive(0, gamma * radius_m) / ive(1, gamma * radius_m))
        return self._rough(2.0 / math.pi * gamma / self.conductivity_s_per_m * ratio)

    def doubts(self, frequency_hz: float, *, apart_m: float = math.inf) -> tuple[str, ...]:
        """Return what makes results with such metal doubtful, one sentence each.

        Parameters
        ----------
        frequency_hz : Frequency [Hz].
        apart_m : Least distance between metal and metal that it does not touch [m].
        """
        wavelength_m = SPEED_OF_LIGHT_M_PER_S / frequency_hz
        least_m = min(apart_m, 0.1 * wavelength_m)
        found = []
        if self.thickness_m > THIN * least_m * (1.0 + 1e-9):
            found.append(
                f"sheets {1e3 * self.thickness_m:.3g} mm thick are not thin against "
                f"{1e3 * least_m:.3g} mm, the nearest metal or a tenth of a wavelength: they are "
                "solved as if they had no thickness"
            )
        depth_m = self.skin_depth_m(frequency_hz)
        if depth_m > DEEP * wavelength_m:
            found.append(
                f"a skin depth of {1e3 * depth_m:.3g} mm is not small against the wavelength: a "
                "surface impedance is for good conductors"
            )
        return tuple(found)

    def _rough(self, smooth_ohm: complex) -> complex:
        return complex(self.roughness_factor * smooth_ohm.real, smooth_ohm.imag)


def surface_impedance(
    conductor: Conductor | None,
    frequency_hz: float,
    *,
    wire_radius_m: npt.NDArray[np.float64],
    perfect: npt.NDArray[np.bool_],
) -> npt.NDArray[np.complex128]:
    """Return (f,) the surface impedance of triangles [ohm].

    Parameters
    ----------
    conductor : What they are made of; None: perfect metal.
    frequency_hz : Frequency [Hz].
    wire_radius_m : (f,) float64 — Radius of the wire that a triangle's strip stands for; 0 on
        sheets [m].
    perfect : (f,) bool — Triangles that are perfect all the same [-].
    """
    ohm = np.zeros(len(wire_radius_m), dtype=np.complex128)
    if conductor is None:
        return ohm
    ohm[:] = conductor.sheet_ohm(frequency_hz)
    for radius_m in np.unique(wire_radius_m[wire_radius_m > 0.0]).tolist():
        ohm[wire_radius_m == radius_m] = conductor.wire_ohm(frequency_hz, radius_m)
    ohm[perfect] = 0.0
    return ohm
