"""Fresnel reflection at half-spaces; reflection and transmission of slabs and layered walls."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.medium import _reflection_kernels
from octant.em.medium.materials import Material

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
    material : The wall; its thickness does not count here.
    frequency_hz : Frequency [Hz].
    incidence_rad : (n,) float64 — Angle from the wall's normal [rad], 0 to pi/2.

    Returns
    -------
    tuple of (n,) complex128
        TE and TM coefficients [-].

    References
    ----------
    .. [1] ITU-R P.2040-4 (2025), section 2.2.1, with air on the near side.
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
    """Return what a wall reflects and lets through, as its material says.

    Parameters
    ----------
    material : The wall: half-space, slab, or layers. One that fills all that lies behind lets
        nothing through.
    frequency_hz : Frequency [Hz].
    incidence_rad : (n,) float64 — Angle from the wall's normal [rad], 0 to pi/2.
    from_front : Whether the wave comes from the side of the first layer. A wall whose last layer
        fills all that lies behind is seen from its front in either case.

    Returns
    -------
    WallCoefficients
        All multiple reflections between the layers' faces included; the transmission carries the
        phase of the wall in place of the air that it displaces, from face to face along the normal.

    Notes
    -----
    Each layer is put before what stands behind it: with r the Fresnel coefficient of its face, and
    R, T what a wave meets just inside, (r + R) / (1 + r R) and (1 + r) T / (1 + r R). This equals
    the recommendation's recursion and its ABCD matrices, and never overflows. It holds for plane
    faces much wider than a wavelength, and does not move the wave along the wall.

    References
    ----------
    .. [1] ITU-R P.2040-4 (2025), section 2.2.2 (equations 43 and 44 for one layer) and Attachment 1
       to Annex 1.
    """
    cosine = _cosine(incidence_rad)
    out = np.empty((4, len(cosine)), np.complex128)
    permittivity, thickness_m = material.layer_stack(frequency_hz)
    thickness_wavelengths = thickness_m * (frequency_hz / SPEED_OF_LIGHT_M_PER_S)
    _reflection_kernels.fill_wall(permittivity, thickness_wavelengths, cosine, from_front, out)
    return WallCoefficients(*out)


def _cosine(incidence_rad: npt.ArrayLike) -> npt.NDArray[np.float64]:
    return np.atleast_1d(np.cos(np.asarray(incidence_rad, dtype=np.float64)))
