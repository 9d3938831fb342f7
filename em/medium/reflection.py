"""Fresnel reflection at half-spaces; reflection and transmission of slabs and layered walls."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.medium import _reflection_kernels
from octant.em.medium.materials import Material

ComplexArray = npt.NDArray[np.complex128]


class WallCoefficients(NamedTuple):
    """Field coefficients of a wall, each (n,) complex128 [-]; TE is across the plane of incidence.

    TM's reference directions turn with the wave: a perfect conductor has TE -1, TM +1.
    """

    reflection_te: ComplexArray
    reflection_tm: ComplexArray
    transmission_te: ComplexArray
    transmission_tm: ComplexArray


def half_space_reflection(
    material: Material, frequency_hz: float, incidence_rad: npt.ArrayLike
) -> tuple[ComplexArray, ComplexArray]:
    """Return the (n,) TE and TM reflection coefficients [-] of a half-space in air.

    After ITU-R P.2040-4 (2025), section 2.2.1.

    Parameters
    ----------
    material : The wall; its thickness does not count here.
    frequency_hz : Frequency [Hz].
    incidence_rad : (n,) float64 — Angle from the wall's normal [rad], 0 to pi/2.
    """
    cosine = _cosine(incidence_rad)
    te, tm = np.empty(len(cosine), np.complex128), np.empty(len(cosine), np.complex128)
    eps_r = material.relative_permittivity(frequency_hz)
    _reflection_kernels.fill_half_space(eps_r, cosine, te, tm)
    return te, tm


def wall_coefficients(
    material: Material,
    frequency_hz: float,
    incidence_rad: npt.ArrayLike,
    *,
    from_front: bool = True,
) -> WallCoefficients:
    """Return what a wall reflects and lets through, multiple reflections between faces included.

    Transmission carries the phase of the wall in place of the air, from face to face along the
    normal. Each layer is put before what stands behind it: with r the Fresnel coefficient of its
    face, and R, T what a wave meets just inside, (r + R) / (1 + r R) and (1 + r) T / (1 + r R).
    This equals the recursion and the ABCD matrices of ITU-R P.2040-4 (2025), section 2.2.2
    (equations 43, 44 for one layer) and Attachment 1 to Annex 1, and never overflows. For plane
    faces much wider than a wavelength; the wave is not moved along the wall.

    Parameters
    ----------
    material : Half-space, slab or layers; what fills all that lies behind lets nothing through.
    frequency_hz : Frequency [Hz].
    incidence_rad : (n,) float64 — Angle from the wall's normal [rad], 0 to pi/2.
    from_front : Whether the wave comes from the first layer's side; always so where the last layer
        fills all that lies behind.
    """
    cosine = _cosine(incidence_rad)
    out = np.empty((4, len(cosine)), np.complex128)
    permittivity, thickness_m = material.layer_stack(frequency_hz)
    thickness_wavelengths = thickness_m * (frequency_hz / SPEED_OF_LIGHT_M_PER_S)
    _reflection_kernels.fill_wall(permittivity, thickness_wavelengths, cosine, from_front, out)
    return WallCoefficients(*out)


def _cosine(incidence_rad: npt.ArrayLike) -> npt.NDArray[np.float64]:
    return np.atleast_1d(np.cos(np.asarray(incidence_rad, dtype=np.float64)))
