"""Far fields of surface currents, exact in any direction, from the currents themselves."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.blocks import run_blocks
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave import _far_kernels
from octant.em.reader.fullwave.basis import THREE_POINTS, SurfaceBasis
from octant.em.reader.fullwave.rwg import VACUUM_IMPEDANCE_OHM
from octant.geometries._arrays import frozen_array

ROWS_PER_BLOCK = 64
"""Directions that a thread takes at a time [-]."""

ROWS_PER_PRODUCT = 512
"""Directions whose phases are held at a time [-]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CurrentSamples:
    """Current moments at points, from which far fields follow.

    Parameters
    ----------
    points_m : (p, 3) float64 — Places [m].
    moments_a_m : (k, p, 3) complex128 — Current density times area of k cases [A m].
    frequency_hz : Frequency [Hz].
    """

    points_m: npt.NDArray[np.float64]
    moments_a_m: npt.NDArray[np.complex128]
    frequency_hz: float

    def __post_init__(self) -> None:
        points = frozen_array(self.points_m, name="points_m", shape=(None, 3))
        moments = frozen_array(
            self.moments_a_m,
            name="moments_a_m",
            shape=(None, len(points), 3),
            dtype=np.complex128,
        )
        object.__setattr__(self, "points_m", points)
        object.__setattr__(self, "moments_a_m", moments)

    def far_field(
        self, theta_rad: npt.ArrayLike, phi_rad: npt.ArrayLike
    ) -> npt.NDArray[np.complex128]:
        """Return the far fields E R exp(jkR) towards directions [V].

        Parameters
        ----------
        theta_rad, phi_rad : array_like — Directions [rad], broadcast against each other.

        Returns
        -------
        (k, ..., 2) complex128
            E_theta and E_phi times distance, the factor exp(-jkR) / R dropped [V], phase referred
            to the origin.

        Notes
        -----
        E = -j w mu / (4 pi) sum of the moments' transverse parts times exp(jk r.r').
        """
        theta, phi = np.broadcast_arrays(
            np.asarray(theta_rad, dtype=np.float64), np.asarray(phi_rad, dtype=np.float64)
        )
        st, ct, sp, cp = np.sin(theta), np.cos(theta), np.sin(phi), np.cos(phi)
        direction = np.ascontiguousarray(np.stack((st * cp, st * sp, ct), axis=-1).reshape(-1, 3))
        wavenumber = 2.0 * math.pi * self.frequency_hz / SPEED_OF_LIGHT_M_PER_S
        points = np.ascontiguousarray(wavenumber * self.points_m.T)
        cases = len(self.moments_a_m)
        moments = np.ascontiguousarray(np.moveaxis(self.moments_a_m, 1, 0).reshape(-1, 3 * cases))
        total = np.empty((len(direction), 3 * cases), dtype=np.complex128)

        # Phases on all threads, then one product on BLAS's own threads: the two do not mix well.
        rows = min(ROWS_PER_PRODUCT, len(direction))
        phase = np.empty((rows, points.shape[1]), dtype=np.complex128)
        for first in range(0, len(direction), rows):
            last = min(first + rows, len(direction))

            def work(begin: int, end: int, first: int = first) -> None:
                _far_kernels.fill_phases(
                    direction, points, first + begin, first + end, phase[begin:end]
                )

            run_blocks(work, last - first, block_size=ROWS_PER_BLOCK)
            np.matmul(phase[: last - first], moments, out=total[first:last])
        vector = total.reshape(*theta.shape, cases, 3)
        theta_hat = np.stack((ct * cp, ct * sp, -st), axis=-1)[..., None, :]
        phi_hat = np.stack((-sp, cp, np.zeros_like(sp)), axis=-1)[..., None, :]
        field = np.stack(((vector * theta_hat).sum(-1), (vector * phi_hat).sum(-1)), axis=-1)
        scale = -1j * wavenumber * VACUUM_IMPEDANCE_OHM / (4.0 * math.pi)
        return np.moveaxis(scale * field, -2, 0)


def current_samples(
    basis: SurfaceBasis,
    halves: npt.NDArray[np.complex128],
    *,
    frequency_hz: float,
) -> CurrentSamples:
    """Return the current moments of half-functions at three points of every triangle [A m].

    Parameters
    ----------
    basis : Functions.
    halves : (k, f, 3) complex128 — Factors of all half-functions [A/m], as
        `SurfaceBasis.half_coefficients` gives them.
    frequency_hz : Frequency [Hz].
    """
    corners = basis.corners_m
    points = np.einsum("ab,fbc->fac", THREE_POINTS, corners)
    # l / (2A) (r - corner) times A / 3
    scaled = halves * (basis.edge_lengths_m / 6.0)
    moments = scaled.sum(axis=2)[:, :, None, None] * points
    moments -= np.einsum("kfi,fic->kfc", scaled, corners)[:, :, None, :]
    return CurrentSamples(
        points_m=points.reshape(-1, 3),
        moments_a_m=moments.reshape(len(halves), -1, 3),
        frequency_hz=frequency_hz,
    )


def sphere_rule(
    wavenumber_per_m: float, radius_m: float, *, multiple_of: int = 1
) -> tuple[npt.NDArray[np.float64], int, npt.NDArray[np.float64]]:
    """Return a grid of directions and weights for means of power over the sphere [-].

    Parameters
    ----------
    wavenumber_per_m : Wavenumber [rad/m].
    radius_m : Radius of a sphere about the origin that holds all currents [m].
    multiple_of : Number that the steps of phi shall be a multiple of.

    Returns
    -------
    theta_rad : (t,) float64
        Gauss-Legendre nodes in cos(theta) [rad].
    columns : int
        Number of even steps of phi from 0 [-].
    weights : (t,) float64
        Weight of each direction of a row [-]; all add up to 1. A power pattern of these currents
        is integrated to about 1e-8.
    """
    order = math.ceil(wavenumber_per_m * radius_m) + 12
    nodes, weights = np.polynomial.legendre.leggauss(order + 1)
    columns = multiple_of * math.ceil((2 * order + 2) / multiple_of)
    return np.arccos(nodes), columns, (0.5 / columns) * weights
