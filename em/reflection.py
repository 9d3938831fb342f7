"""Fresnel reflection at half-spaces, and reflection and transmission of finite slabs."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from octant.em import _reflection_kernels
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.materials import Material

ComplexArray = npt.NDArray[np.complex128]


class WallCoefficients(NamedTuple):
    """Field coefficients of a wall, each (n,) complex128 [-].

    TE is perpendicular to the plane of incidence. The TM reference directions turn with the wave,
    so that a perfect conductor has -1 for TE and +1 for TM.
    """

    reflection_te: ComplexArray
    reflection_tm: ComplexArray
    transmission_te: ComplexArray
    transmission_tm: ComplexArray


def half_space_reflection(
    material: Material, frequency_hz: float, incidence_rad: npt.ArrayLike
) -> tuple[ComplexArray, ComplexArray]:
    """Return the TE and TM reflection coefficients [-] of a half-space.

    Parameters
    ----------
    material : Material
        The wall; its thickness does not count here.
    frequency_hz : float
        Frequency [Hz].
    incidence_rad : (n,) float64
        Angle from the wall's normal [rad], 0 to pi/2.

    Returns
    -------
    tuple of (n,) complex128
        TE and TM coefficients [-].

    Raises
    ------
    MaterialRangeError
        When the frequency is outside the material's range.

    References
    ----------
    .. [1] ITU-R P.2040-3 (2023), equations 31a and 31b with air on the near side.
    """
    cosine = np.atleast_1d(np.cos(np.asarray(incidence_rad, dtype=np.float64)))
    te, tm = np.empty(len(cosine), np.complex128), np.empty(len(cosine), np.complex128)
    eps_r = material.relative_permittivity(frequency_hz)
    _reflection_kernels.fill_half_space(eps_r, cosine, te, tm)
    return te, tm


def wall_coefficients(
    material: Material, frequency_hz: float, incidence_rad: npt.ArrayLike
) -> WallCoefficients:
    """Return what a wall reflects and lets through, as its material says: slab or half-space.

    Parameters
    ----------
    material : Material
        The wall. Without a thickness it is a half-space, which lets nothing through.
    frequency_hz : float
        Frequency [Hz].
    incidence_rad : (n,) float64
        Angle from the wall's normal [rad], 0 to pi/2.

    Returns
    -------
    WallCoefficients
        All multiple reflections inside the slab included; the transmission carries the phase of
        the slab in place of the air that it displaces, from face to face along the normal.

    Raises
    ------
    MaterialRangeError
        When the frequency is outside the material's range.

    References
    ----------
    .. [1] ITU-R P.2040-3 (2023), equations 43 and 44.
    """
    cosine = np.atleast_1d(np.cos(np.asarray(incidence_rad, dtype=np.float64)))
    if material.thickness_m is None:
        te, tm = half_space_reflection(material, frequency_hz, incidence_rad)
        return WallCoefficients(te, tm, np.zeros_like(te), np.zeros_like(te))
    out = np.empty((4, len(cosine)), np.complex128)
    thickness_wavelengths = material.thickness_m * frequency_hz / SPEED_OF_LIGHT_M_PER_S
    eps_r = material.relative_permittivity(frequency_hz)
    _reflection_kernels.fill_slab(eps_r, cosine, thickness_wavelengths, out)
    return WallCoefficients(*out)
