"""Diffraction at the edges of wedges and sheets: the uniform theory (UTD)."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from octant.em.medium import _transition_kernels, _wedge_kernels
from octant.geometries.errors import GeometryError

IntArray = npt.NDArray[np.int64]
FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]

CONDUCTOR = complex(1.0, -np.inf)
"""Relative permittivity [-] of a perfect conductor, as the coefficients here understand it."""


class WedgeFaces(NamedTuple):
    """What the two faces of a wedge are made of; face 0 first.

    Parameters
    ----------
    permittivity : Relative permittivity [-] of each face's layers, from the air inwards.
    thickness_wavelengths : Their thickness [wavelengths]; infinity: all that lies behind.
    transparent : Whether faces of finite thickness let waves through.
    """

    permittivity: tuple[complex | Sequence[complex], complex | Sequence[complex]] = (
        CONDUCTOR,
        CONDUCTOR,
    )
    thickness_wavelengths: tuple[float | Sequence[float], float | Sequence[float]] = (
        np.inf,
        np.inf,
    )
    transparent: bool = False

    def kernel_arrays(self) -> tuple[IntArray, ComplexArray, FloatArray]:
        """Return the faces (1, 2, 4), and permittivity and thickness of all layers, for kernels."""
        permittivity = [np.atleast_1d(np.asarray(p, complex)) for p in self.permittivity]
        thickness = [np.atleast_1d(np.asarray(d, float)) for d in self.thickness_wavelengths]
        first, both = len(thickness[0]), len(thickness[0]) + len(thickness[1])
        passes = [
            self.transparent and bool(np.isfinite(d).all() and np.isfinite(p).all())
            for p, d in zip(permittivity, thickness, strict=True)
        ]
        faces = np.array([[[0, first, 1, passes[0]], [first, both, 1, passes[1]]]], np.int64)
        return faces, np.concatenate(permittivity), np.concatenate(thickness)


def transition_function(x: npt.ArrayLike) -> ComplexArray:
    r"""Return the transition function F(x) [-] of the uniform theory of diffraction.

    :math:`F(x) = 2j\sqrt{x}\,e^{jx}\int_{\sqrt x}^\infty e^{-jt^2}dt
    = \sqrt{\pi x}\,e^{j\pi/4}\,w(j e^{j\pi/4}\sqrt x)` for time e^{+jwt}:
    0 at 0, towards 1 at infinity, relative error below 1e-13 up to 1e14. w is the Faddeeva function
    by the midpoint rule of M. Al Azah et al., Numer. Math. 128 (2014); from x = 100 on, 12 terms of
    the asymptotic series. R. Kouyoumjian and P. Pathak, Proc. IEEE 62 (1974), equation 26; the
    first row of their table (x = 0.3), which many books copy, is off by 5e-3.

    Parameters
    ----------
    x : Argument k L a [-], 0 or more.
    """
    values = np.asarray(x, dtype=np.float64)
    if not (values >= 0.0).all():
        raise GeometryError(
            f"x = {values.min()} was given to the transition function, which is defined for x >= 0;"
            " pass k L a."
        )
    out = np.empty(values.size, np.complex128)
    _transition_kernels.fill_transition(values.ravel(), out)
    return out.reshape(values.shape)


def wedge_coefficients(
    incidence_rad: npt.ArrayLike,
    observation_rad: npt.ArrayLike,
    *,
    air_angle_rad: float,
    wavenumber_rad_per_m: float,
    before_m: npt.ArrayLike,
    after_m: npt.ArrayLike,
    skew_rad: float = np.pi / 2.0,
    faces: WedgeFaces | None = None,
) -> ComplexArray:
    r"""Return the (..., 2, 2) diffraction dyads [sqrt(m)] of one straight wedge.

    Diffracted over incident components along b (E along the edge, ``[0, 0]``: a conductor's soft
    coefficient) and h (H along the edge, ``[1, 1]``: hard). With the edge's axis a = t0 x n0 and a
    ray d, b = (a - (a.d) d) / sin(skew) and h = (a x d) / sin(skew).

    Four terms cot(x/2n) F(X) and their next order in 1/kL, each the boundary x = 0 of one image, X
    its detour over the edge times k (2kL sin^2(x/2) for a plane wave), weighted with the image's
    dyad of reflections (or of one minus the transmission); see docs/evidence/diffraction.md.
    Exactly on a boundary an image of reflections counts as lit and the source itself as hidden, as
    in the search for paths; of the two that coincide in a wedge of pi / m one counts, and half of
    the difference is left out. The formula is asymptotic: finite and smooth at any distance, a
    solution of the wave equation only for k L well above 1. Sources: R. Kouyoumjian and P. Pathak,
    Proc. IEEE 62 (1974), equations 25 to 30; R. Luebbers, IEEE Trans. Antennas Propag. 32 (1984),
    pages 70 to 76; P. Holm, ibid. 48 (2000), pages 1211 to 1219.

    Parameters
    ----------
    incidence_rad, observation_rad : Azimuths phi' of the source and phi of the observer about the
        edge [rad], from face 0 through the air, 0 to air_angle_rad; broadcast with the distances.
    air_angle_rad : Angle that the air fills [rad]: n pi, above 0 and up to 2 pi (a half-plane).
    wavenumber_rad_per_m : Wavenumber k in air [rad/m].
    before_m, after_m : Lengths s' before and s after the edge [m] along the unfolded ray, above 0;
        infinite for a plane wave.
    skew_rad : Angle beta_0 between the incident ray and the edge [rad], above 0 and below pi.
    faces : Materials; perfect conductors if left out.
    """
    n = air_angle_rad / np.pi
    given = faces or WedgeFaces()
    given_arrays = np.broadcast_arrays(incidence_rad, observation_rad, before_m, after_m)
    shape = given_arrays[0].shape
    angles_in, angles_out, before, after = (
        np.asarray(a, dtype=np.float64).flatten() for a in given_arrays
    )
    _check_wedge(
        n=n,
        skew_rad=skew_rad,
        wavenumber=wavenumber_rad_per_m,
        angles_in=angles_in,
        angles_out=angles_out,
        distances=np.minimum(before, after),
    )
    out = np.empty((angles_in.size, 2, 2), np.complex128)
    _wedge_kernels.fill_wedge_dyads(
        angles_in,
        angles_out,
        before,
        after,
        n,
        skew_rad,
        *given.kernel_arrays(),
        wavenumber_rad_per_m,
        out,
    )
    return out.reshape(*shape, 2, 2)


def _check_wedge(
    *,
    n: float,
    skew_rad: float,
    wavenumber: float,
    angles_in: FloatArray,
    angles_out: FloatArray,
    distances: FloatArray,
) -> None:
    """Raise GeometryError for a wedge or ray that the coefficients do not describe."""
    if not 0.0 < n <= 2.0:
        raise GeometryError(
            f"air_angle_rad = {n * np.pi:.6g} rad; a wedge's air angle lies above 0 and up to 2 pi."
        )
    if not 0.0 < skew_rad < np.pi:
        raise GeometryError(
            f"skew_rad = {skew_rad:.6g} rad; a ray meets an edge at an angle above 0 and below pi."
        )
    if not (wavenumber > 0.0 and (distances > 0.0).all()):
        raise GeometryError(
            f"wavenumber_rad_per_m = {wavenumber:.6g} rad/m and the least distance ="
            f" {distances.min():.6g} m; both must be positive."
        )
    both = np.concatenate([angles_in, angles_out])
    if not ((both >= 0.0) & (both <= n * np.pi)).all():
        raise GeometryError(
            f"An azimuth is outside the air, 0 to {n * np.pi:.6g} rad; measure it from face 0."
        )
