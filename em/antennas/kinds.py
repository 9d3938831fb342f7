"""Antennas: closed-form patterns (thin dipole, monopole, patch, isotropic in theta) and tables."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from octant.em.antennas import _antenna_kernels
from octant.em.antennas._response_kernels import PAD
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.directions import POLE_MISMATCH
from octant.em.records import AntennaArrays, AntennaChannels, PatternArrays, PatternChannels
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import AntennaError

AntennaKind = Literal["dipole", "monopole", "patch", "conical_patch", "isotropic_theta"]
"""Kinds of antenna with a closed-form pattern."""

_KERNEL_KINDS = {
    "isotropic_theta": _antenna_kernels.ISOTROPIC_THETA,
    "dipole": _antenna_kernels.DIPOLE,
    "monopole": _antenna_kernels.MONOPOLE,
    "patch": _antenna_kernels.PATCH,
    "conical_patch": _antenna_kernels.CONICAL_PATCH,
}

PATCHES = ("patch", "conical_patch")
"""Kinds that face one way, and by default down [-]."""

_J1_ZERO = 3.8317059702075125
"""First zero of J1, where the disc of a conical patch resonates: k times its radius [-]."""
_LARGEST_DISC_RAD = 8.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Antenna:
    """An antenna: the complex vector far field that it sends, and by reciprocity receives.

    Parameters
    ----------
    kind : ``dipole``: centre-fed and thin, sinusoidal current; ``monopole``: half of it on an
        infinite conducting plane, nothing below; ``patch``: square microstrip on such a plane;
        ``conical_patch``: centre-fed disc there, cone-shaped beam polarised along theta;
        ``isotropic_theta``: unit gain, polarised so; ``pattern``: a table.
    length_m : Dipole's tip to tip, monopole's height, patch's side, disc's diameter [m]; else 0.
    frequency_hz : Frequency [Hz].
    axis : (3,) float64 — Unit vector [-] in the room: wire, patch's facing, table's z axis.
    azimuth_rad : Turn about the axis [rad] of the patch's resonant side or the table's x axis, from
        +x as far as it is across the axis (+y where the axis is along x).
    pattern : (2, T, P) complex128 or None — F_theta and F_phi [-] of a table, |F|^2 = gain: theta
        over T values from 0 to pi, phi over P, an even number, from 0 to below 2 pi.
    steps : (T - 1, P) bool or None — Cells of the table that are interpolated along straight lines,
        since a step runs through them [-].
    """

    kind: str
    length_m: float
    frequency_hz: float
    axis: npt.NDArray[np.float64]
    azimuth_rad: float = 0.0
    pattern: npt.NDArray[np.complex128] | None = None
    steps: npt.NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        axis = frozen_array(self.axis, name="axis", shape=(3,), error=AntennaError)
        norm = float(np.linalg.norm(axis))
        if norm == 0.0:
            msg = "axis = (0, 0, 0) has no direction; give a vector such as (0, 0, 1)."
            raise AntennaError(msg)
        unit = frozen_array(axis / norm, name="axis", shape=(3,))
        object.__setattr__(self, "axis", unit)
        if not math.isfinite(self.azimuth_rad):
            msg = f"azimuth_rad = {self.azimuth_rad} is not an angle; give a finite number of rad."
            raise AntennaError(msg)
        if (self.kind == "pattern") != (self.pattern is not None):
            msg = f"antenna {self.kind!r} and its table do not fit; only 'pattern' has one."
            raise AntennaError(msg)
        if self.pattern is not None:
            object.__setattr__(self, "pattern", _checked_pattern(self.pattern))
            object.__setattr__(self, "steps", checked_steps(self.steps, self.pattern.shape))

    @property
    def wavelength_m(self) -> float:
        """Wavelength in air [m]."""
        return SPEED_OF_LIGHT_M_PER_S / self.frequency_hz

    @property
    def side(self) -> npt.NDArray[np.float64]:
        """Unit vector [-] across the axis from which azimuth counts, (3,), in the room's frame."""
        along = np.array([1.0, 0.0, 0.0])
        if abs(self.axis[0]) > 1.0 - 1e-9:
            along = np.array([0.0, 1.0, 0.0])
        x = along - (along @ self.axis) * self.axis
        x = x / np.linalg.norm(x)
        side: npt.NDArray[np.float64] = math.cos(self.azimuth_rad) * x + math.sin(
            self.azimuth_rad
        ) * np.cross(self.axis, x)
        return side

    def kernel_arrays(self) -> AntennaArrays | PatternArrays:
        """Return the antenna as the kernels take it, lengths in radians [rad]."""
        if self.pattern is not None:
            return PatternArrays(
                padded_table(self.pattern[None]),
                linear_cells(self.pattern[None], self.steps),
                math.pi / (self.pattern.shape[1] - 1),
                2.0 * math.pi / self.pattern.shape[2],
                *self.axis,
                *self.side,
            )
        half_length_rad = math.pi * self.length_m / self.wavelength_m
        half_width_rad, amplitude = 0.0, 1.0
        if self.kind == "patch":
            half_width_rad = half_length_rad
            amplitude = _patch_amplitude(half_length_rad, half_width_rad)
        elif self.kind == "conical_patch":
            amplitude = _disc_amplitude(half_length_rad)  # k l / 2 is k times the radius
        elif self.kind != "isotropic_theta":
            if self.kind == "monopole":  # the image makes it a dipole of twice its height
                half_length_rad *= 2.0
            amplitude = math.sqrt(2.0 / _radiation_integral(half_length_rad))
            if self.kind == "monopole":  # the same field, half the power
                amplitude *= math.sqrt(2.0)
        kind = _KERNEL_KINDS[self.kind]
        return AntennaArrays(
            kind, half_length_rad, half_width_rad, amplitude, *self.axis, *self.side
        )

    def far_field(
        self, theta_rad: npt.ArrayLike, phi_rad: npt.ArrayLike
    ) -> npt.NDArray[np.complex128]:
        """Return (..., 2) F_theta, F_phi [-] towards directions; |F|^2 is the gain.

        Phase is that of the dipole's or patch's centre, the monopole's foot, the table's origin.
        Between the points of a table by cubic Lagrange interpolation, at its steps linear.

        The patch is the cavity model's dominant mode on thin air over an infinite plane: two
        in-phase magnetic currents of its width, its length apart; on a dielectric a real one is
        smaller, its beam wider, its gain lower. The conical patch is a disc in mode TM02 on air: a
        ring of magnetic current, F_theta ~ J1(k a sin) over the angle to its axis. At resonance (k
        a = 3.83) it is silent on the axis and the horizon and strongest 29 degrees off the axis.
        Sources: C. A. Balanis, Antenna Theory, 3rd ed. (2005), equations 4-62, 4-68, 14-43 with
        14-44 for a substrate of height zero, 14-72 with n = 0 for the disc.

        Parameters
        ----------
        theta_rad, phi_rad : Angle from +z and azimuth from +x [rad], broadcast.
        """
        theta, phi = np.broadcast_arrays(
            np.asarray(theta_rad, dtype=np.float64), np.asarray(phi_rad, dtype=np.float64)
        )
        st, ct, sp, cp = np.sin(theta), np.cos(theta), np.sin(phi), np.cos(phi)
        direction = np.stack((st * cp, st * sp, ct), axis=-1).reshape(-1, 3)
        vector = np.empty(direction.shape, dtype=np.complex128)
        _antenna_kernels.fill_far_field(self.kernel_arrays(), direction, vector)
        vector = vector.reshape(*theta.shape, 3)
        theta_hat = np.stack((ct * cp, ct * sp, -st), axis=-1)
        phi_hat = np.stack((-sp, cp, np.zeros_like(sp)), axis=-1)
        parts = (np.sum(vector * theta_hat, axis=-1), np.sum(vector * phi_hat, axis=-1))
        return np.stack(parts, axis=-1)


def antenna_channels(antennas: Sequence[Antenna]) -> AntennaChannels | PatternChannels:
    """Return an antenna at several frequencies as the kernels take it, lengths in radians [rad].

    Parameters
    ----------
    antennas : One or more, all of closed form or all tables of one grid.
    """
    arrays = [antenna.kernel_arrays() for antenna in antennas]
    if isinstance(arrays[0], PatternArrays):
        tables, linear = (np.stack([one[k] for one in arrays]) for k in (0, 1))
        return PatternChannels(tables, linear, np.array([one[2:] for one in arrays], np.float64))
    numbers = np.array([one[1:] for one in arrays], dtype=np.float64)
    return AntennaChannels(np.array([one[0] for one in arrays], dtype=np.int64), numbers)


@lru_cache(maxsize=256)  # asked again for every block of receivers
def _radiation_integral(half_length_rad: float) -> float:
    """Return the integral of (cos(h cos t) - cos h)^2 / sin t over t from 0 to pi.

    Gauss-Legendre in cos t; equal to Balanis 4-68, whose integrals cancel for short antennas.
    """
    nodes, weights = np.polynomial.legendre.leggauss(40 + math.ceil(2.0 * half_length_rad))
    plus = np.sin(0.5 * half_length_rad * (1.0 + nodes))
    minus = np.sin(0.5 * half_length_rad * (1.0 - nodes))
    return float(weights @ (4.0 * plus**2 * minus**2 / (1.0 - nodes**2)))


def _patch_amplitude(half_length_rad: float, half_width_rad: float) -> float:
    """Return what makes the patch's gain average 1 over the sphere.

    Gauss-Legendre in the cosine to the axis, trapezoidal around it: both converge fast.
    """
    cosine, weights = np.polynomial.legendre.leggauss(32)
    cosine, weights = 0.5 * (cosine + 1.0)[:, None], 0.5 * weights
    sine = np.sqrt(1.0 - cosine**2)
    phi = np.arange(64) * (2.0 * math.pi / 64)
    along, across = sine * np.cos(phi), sine * np.sin(phi)
    slot = np.sinc(half_width_rad * across / math.pi)
    gain = (1.0 - across**2) * (slot * np.cos(half_length_rad * along)) ** 2
    return math.sqrt(2.0 / float(weights @ gain.mean(axis=1)))


@lru_cache(maxsize=256)
def _disc_amplitude(radius_rad: float) -> float:
    """Return what makes the conical patch's gain average 1 over the sphere, by quadrature."""
    from scipy.special import j1

    cosine, weights = np.polynomial.legendre.leggauss(64)
    gain = j1(radius_rad * np.sqrt(1.0 - (0.5 * (cosine + 1.0)) ** 2)) ** 2
    return math.sqrt(4.0 / float(weights @ gain))


def _checked_pattern(pattern: npt.NDArray[np.complex128]) -> npt.NDArray[np.complex128]:
    """Return a table as a read-only array, once it can be interpolated."""
    table = frozen_array(
        pattern, name="pattern", shape=(2, None, None), dtype=np.complex128, error=AntennaError
    )
    _, rows, columns = table.shape
    if rows < 4 or columns < 4 or columns % 2:
        msg = (
            f"pattern has shape {table.shape}, but at least four values of theta and an even "
            "number of at least four values of phi are needed."
        )
        raise AntennaError(msg)
    return table


def make_antenna(
    kind: str,
    frequency_hz: float,
    *,
    length_m: float | None = None,
    axis: npt.ArrayLike | None = None,
    azimuth_rad: float = 0.0,
) -> Antenna:
    """Return an antenna, by default resonant: half a wavelength long, a monopole a quarter.

    Parameters
    ----------
    kind : Any kind but ``pattern``.
    frequency_hz : Frequency [Hz].
    length_m : Length, or a disc's diameter [m], > 0; None: resonant (the disc 1.22 wavelengths).
    axis : (3,) float — Direction of the antenna [-], of any length; None: up, patches down.
    azimuth_rad : Turn about the axis [rad], see `Antenna`.
    """
    if kind not in get_args(AntennaKind):
        msg = f"antenna {kind!r} is unknown; allowed are {', '.join(get_args(AntennaKind))}."
        raise AntennaError(msg)
    if not (math.isfinite(frequency_hz) and frequency_hz > 0.0):
        msg = f"frequency_hz = {frequency_hz} is not a frequency; give a number above 0 Hz."
        raise AntennaError(msg)
    wavelength_m = SPEED_OF_LIGHT_M_PER_S / frequency_hz
    if kind == "isotropic_theta":
        length_m = 0.0
    elif length_m is None:
        shares = {"monopole": 0.25, "conical_patch": _J1_ZERO / math.pi}
        length_m = shares.get(kind, 0.5) * wavelength_m
    elif not (math.isfinite(length_m) and length_m > 0.0):
        msg = f"length_m = {length_m} is not a length; give a number above 0 m."
        raise AntennaError(msg)
    if kind == "conical_patch" and math.pi * length_m > _LARGEST_DISC_RAD * wavelength_m:
        most_m = _LARGEST_DISC_RAD * wavelength_m / math.pi
        msg = (
            f"length_m = {length_m:g} m is too wide for a conical patch at "
            f"{frequency_hz / 1e9:g} GHz; give a diameter up to {most_m:.3g} m."
        )
        raise AntennaError(msg)
    if axis is None:
        axis = (0.0, 0.0, -1.0 if kind in PATCHES else 1.0)
    return Antenna(
        kind=kind,
        length_m=length_m,
        frequency_hz=frequency_hz,
        axis=np.asarray(axis, dtype=np.float64),
        azimuth_rad=azimuth_rad,
    )


def padded_table(pattern: npt.NDArray[np.complex128]) -> npt.NDArray[np.complex128]:
    """Return the (T + 2 PAD, P + 2 PAD, n, 2) padded table of patterns on a uniform grid.

    Beyond a pole the grid goes on at the opposite azimuth, where both unit vectors are reversed.

    Parameters
    ----------
    pattern : (n, 2, T, P) complex128 — F_theta and F_phi [-], as in `Antenna`.
    """
    table = np.ascontiguousarray(np.moveaxis(pattern, (0, 1), (2, 3)))
    half = table.shape[1] // 2
    opposite = -np.roll(table, half, axis=1)
    above, below = opposite[PAD:0:-1], opposite[-2 : -2 - PAD : -1]
    table = np.concatenate((above, table, below))
    return np.ascontiguousarray(np.concatenate((table[:, -PAD:], table, table[:, :PAD]), axis=1))


def checked_steps(
    steps: npt.NDArray[np.bool_] | None, shape: tuple[int, ...]
) -> npt.NDArray[np.bool_] | None:
    """Return the steps of a table as a read-only array [-].

    Parameters
    ----------
    steps : (T - 1, P) bool or None — See `Antenna`.
    shape : Shape of the table, ending in T, P.
    """
    if steps is None:
        return None
    size = (shape[-2] - 1, shape[-1])
    return frozen_array(steps, name="steps", shape=size, dtype=np.bool_, error=AntennaError)


def linear_cells(
    pattern: npt.NDArray[np.complex128], steps: npt.NDArray[np.bool_] | None
) -> npt.NDArray[np.bool_]:
    """Return the cells (T - 1, P) in which kernels interpolate patterns along straight lines [-].

    Those of steps, and those at a pole over which a pattern does not go on with both unit vectors
    reversed, such as one of amplitudes: cubic interpolation over the pole would rise above it.

    Parameters
    ----------
    pattern : (n, 2, T, P) complex128 — F_theta and F_phi [-].
    steps : (T - 1, P) bool or None — See `Antenna`.
    """
    rows, columns = pattern.shape[2:]
    cells = np.zeros((rows - 1, columns), dtype=np.bool_)
    if steps is not None:
        cells |= steps
    peak = float(np.abs(pattern).max())
    for row in (0, -1):
        ring = pattern[:, :, row]
        apart = np.abs(ring + np.roll(ring, columns // 2, axis=-1)) > POLE_MISMATCH * peak
        touched = apart.any(axis=(0, 1))
        cells[row] |= touched | np.roll(touched, -1)
    return cells
