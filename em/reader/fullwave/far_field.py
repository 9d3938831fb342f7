"""Far fields of surface currents: from the currents, or from few directions that fix all others."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.blocks import one_blas_thread, run_blocks
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave import _far_kernels
from octant.em.reader.fullwave.basis import THREE_POINTS, SurfaceBasis
from octant.em.reader.fullwave.rwg import VACUUM_IMPEDANCE_OHM
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import AntennaError

ROWS_PER_BLOCK = 64
"""Directions that a thread takes at a time [-]."""

DIGITS = 7.0
"""Digits of the formula of the excess bandwidth [-]; it leaves 4e-9 of the greatest field."""

LEAST_ORDER = 12
"""Order that is taken at least [-]: the formula is for sources of some size."""


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

    @one_blas_thread()
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

        # Products of blocks of one shape, each on the thread that made its phases.
        def work(begin: int, end: int) -> None:
            phase = np.empty((end - begin, points.shape[1]), dtype=np.complex128)
            _far_kernels.fill_phases(direction, points, begin, end, phase)
            np.matmul(phase, moments, out=total[begin:end])

        run_blocks(work, len(direction), block_size=ROWS_PER_BLOCK)
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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FarField:
    """Far fields on a grid just fine enough for the size of their source, and so everywhere.

    Parameters
    ----------
    values : (k, rows, columns, 2) complex128 — Components along theta and phi [any unit]; theta
        runs evenly from 0 to pi, phi evenly from 0 to below 2 pi; the columns are even in number.

    Notes
    -----
    Both components are trigonometric polynomials of (theta, phi), theta continued past the poles
    by F(2 pi - theta, phi) = -F(theta, phi + pi), up to a rest that falls faster than exponentially
    with the order once it exceeds k a, for sources within a radius a of the origin [1]_. The order
    taken keeps the rest below 1e-8 of the greatest value.

    References
    ----------
    .. [1] W. C. Chew et al., Fast and Efficient Algorithms in Computational Electromagnetics
       (2001), equation 3.25: excess bandwidth; J. E. Hansen, Spherical Near-Field Antenna
       Measurements (1988), section 4.4.
    """

    values: npt.NDArray[np.complex128]

    def __post_init__(self) -> None:
        values = frozen_array(
            self.values, name="values", shape=(None, None, None, 2), dtype=np.complex128
        )
        if values.shape[1] < 2 or values.shape[2] % 2:
            msg = (
                f"values has shape {values.shape}, but at least two values of theta and an even "
                "number of values of phi are needed."
            )
            raise AntennaError(msg)
        object.__setattr__(self, "values", values)

    @one_blas_thread()
    def on_grid(self, theta_rad: npt.ArrayLike, columns: int) -> npt.NDArray[np.complex128]:
        """Return the fields on another grid [unit of the values].

        Parameters
        ----------
        theta_rad : (t,) array_like — Values of theta [rad].
        columns : Number of even steps of phi from 0 to, not including, 2 pi.

        Returns
        -------
        (k, t, columns, 2) complex128
            Both components.
        """
        phi = 2.0 * math.pi * np.arange(columns) / columns
        spectrum, orders, turns = self._spectrum()
        along = np.exp(1j * np.asarray(theta_rad, dtype=np.float64)[:, None] * orders)
        around = np.exp(1j * turns[:, None] * phi)
        return np.moveaxis(along @ (spectrum @ around), 1, -1)

    @one_blas_thread()
    def towards(
        self, theta_rad: npt.NDArray[np.float64], phi_rad: npt.NDArray[np.float64]
    ) -> npt.NDArray[np.complex128]:
        """Return (k, d, 2) the fields towards single directions [unit of the values].

        Parameters
        ----------
        theta_rad, phi_rad : (d,) float64 — Directions [rad].
        """
        spectrum, orders, turns = self._spectrum()
        along = np.exp(1j * theta_rad[:, None] * orders)
        around = np.exp(1j * phi_rad[:, None] * turns)
        fields = np.einsum("dm,kcmn,dn->kdc", along, spectrum, around, optimize=True)
        return np.asarray(fields)

    def _spectrum(
        self,
    ) -> tuple[npt.NDArray[np.complex128], npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Return the Fourier coefficients (k, 2, orders, turns), and both numbers of waves [-]."""
        _, rows, given, _ = self.values.shape
        beyond = -np.roll(self.values, given // 2, axis=2)[:, rows - 2 : 0 : -1]
        whole = np.concatenate((self.values, beyond), axis=1)
        spectrum = np.fft.fft2(whole, axes=(1, 2)) / (whole.shape[1] * given)
        orders = np.fft.fftfreq(whole.shape[1], 1.0 / whole.shape[1])
        turns = np.fft.fftfreq(given, 1.0 / given)
        return np.moveaxis(spectrum, -1, 1), orders, turns

    @one_blas_thread()
    def power_matrix(self) -> npt.NDArray[np.complex128]:
        """Return (k, k) the means over the sphere of conj(F_i) . F_j [unit of the values squared].

        By Gauss-Legendre nodes in cos(theta), exactly for the order of the fields.
        """
        nodes, weights = np.polynomial.legendre.leggauss(self.values.shape[1])
        columns = 2 * self.values.shape[2]
        fields = self.on_grid(np.arccos(nodes), columns)
        fields = fields * np.sqrt(weights / (2.0 * columns))[:, None, None]
        flat = fields.reshape(len(fields), -1)
        matrix: npt.NDArray[np.complex128] = flat.conj() @ flat.T
        return matrix


def order_of(samples: CurrentSamples) -> int:
    """Return the order of theta that the far field of currents needs [-].

    Parameters
    ----------
    samples : Currents.
    """
    wavenumber = 2.0 * math.pi * samples.frequency_hz / SPEED_OF_LIGHT_M_PER_S
    size = wavenumber * float(np.linalg.norm(samples.points_m, axis=1).max())
    excess = 1.8 * DIGITS ** (2.0 / 3.0) * size ** (1.0 / 3.0)
    order: int = max(LEAST_ORDER, math.ceil(size + excess) + 2)
    return order


def band_limited(
    samples: CurrentSamples, *, sectors: int = 1, port_step: int = 0, order: int | None = None
) -> FarField:
    """Return the far fields of currents [V] by as few directions as their extent asks for.

    Parameters
    ----------
    samples : Currents of k cases.
    sectors, port_step : In a turn by one of so many sectors each case becomes the one ``port_step``
        further; 0 when it does not.
    order : Order of theta [-]; None: `order_of` the currents.
    """
    order = order_of(samples) if order is None else order
    parts = sectors if port_step else 1
    multiple = math.lcm(2, parts)
    columns = multiple * math.ceil((2 * order + 2) / multiple)
    theta = np.linspace(0.0, math.pi, order + 1)
    phi = 2.0 * math.pi * np.arange(columns // parts) / columns
    first = samples.far_field(theta[:, None], phi)
    turned = [np.roll(first, s * port_step, axis=0) for s in range(parts)]
    return FarField(values=np.concatenate(turned, axis=2))
