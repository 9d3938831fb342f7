"""Antennas with exact closed-form patterns: thin dipole, monopole, isotropic in theta."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from octant.em import _antenna_kernels
from octant.em._antenna_kernels import AntennaArrays
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import AntennaError

AntennaKind = Literal["dipole", "monopole", "isotropic_theta"]
"""Kinds of antenna with a closed-form pattern."""

_KERNEL_KINDS = {
    "isotropic_theta": _antenna_kernels.ISOTROPIC_THETA,
    "dipole": _antenna_kernels.DIPOLE,
    "monopole": _antenna_kernels.MONOPOLE,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Antenna:
    """An antenna: the complex vector far field that it sends, and by reciprocity receives.

    Parameters
    ----------
    kind : {"dipole", "monopole", "isotropic_theta"}
        A centre-fed thin dipole with sinusoidal current; half of it on an infinite perfectly
        conducting plane, which gives nothing below the plane; or unit gain everywhere, polarised
        along theta.
    length_m : float
        Tip to tip for the dipole, height for the monopole [m]; 0 for ``isotropic_theta``.
    frequency_hz : float
        Frequency [Hz].
    axis : (3,) float64
        Unit vector [-] along the antenna, in the room's frame.
    """

    kind: AntennaKind
    length_m: float
    frequency_hz: float
    axis: npt.NDArray[np.float64]

    def __post_init__(self) -> None:
        axis = frozen_array(self.axis, name="axis", shape=(3,), error=AntennaError)
        norm = float(np.linalg.norm(axis))
        if norm == 0.0:
            msg = "axis = (0, 0, 0) has no direction; give a vector such as (0, 0, 1)."
            raise AntennaError(msg)
        unit = frozen_array(axis / norm, name="axis", shape=(3,))
        object.__setattr__(self, "axis", unit)

    @property
    def wavelength_m(self) -> float:
        """Wavelength in air [m]."""
        return SPEED_OF_LIGHT_M_PER_S / self.frequency_hz

    def kernel_arrays(self) -> AntennaArrays:
        """Return the antenna as the kernels take it, lengths in radians [rad]."""
        half_length_rad, amplitude = 0.0, 1.0
        if self.kind != "isotropic_theta":
            height_m = self.length_m if self.kind == "monopole" else 0.5 * self.length_m
            half_length_rad = 2.0 * math.pi * height_m / self.wavelength_m
            amplitude = math.sqrt(2.0 / _radiation_integral(half_length_rad))
            if self.kind == "monopole":  # the same field, half the power
                amplitude *= math.sqrt(2.0)
        return AntennaArrays(_KERNEL_KINDS[self.kind], half_length_rad, amplitude, *self.axis)

    def far_field(
        self, theta_rad: npt.ArrayLike, phi_rad: npt.ArrayLike
    ) -> npt.NDArray[np.complex128]:
        """Return the far field (F_theta, F_phi) [-] towards directions; |F|^2 is the gain.

        Parameters
        ----------
        theta_rad, phi_rad : array_like
            Angle from +z and azimuth from +x [rad], broadcast against each other.

        Returns
        -------
        (..., 2) complex128
            F_theta and F_phi [-], phase referred to the dipole's centre (the monopole's foot).

        References
        ----------
        .. [1] C. A. Balanis, Antenna Theory, 3rd ed. (2005), equations 4-62 and 4-68.
        """
        theta, phi = np.broadcast_arrays(
            np.asarray(theta_rad, dtype=np.float64), np.asarray(phi_rad, dtype=np.float64)
        )
        st, ct, sp, cp = np.sin(theta), np.cos(theta), np.sin(phi), np.cos(phi)
        direction = np.stack((st * cp, st * sp, ct), axis=-1).reshape(-1, 3)
        vector = np.empty_like(direction)
        _antenna_kernels.fill_far_field(self.kernel_arrays(), direction, vector)
        vector = vector.reshape(*theta.shape, 3)
        theta_hat = np.stack((ct * cp, ct * sp, -st), axis=-1)
        phi_hat = np.stack((-sp, cp, np.zeros_like(sp)), axis=-1)
        parts = (np.sum(vector * theta_hat, axis=-1), np.sum(vector * phi_hat, axis=-1))
        return np.stack(parts, axis=-1).astype(np.complex128)


@lru_cache(maxsize=256)  # asked again for every block of receivers
def _radiation_integral(half_length_rad: float) -> float:
    """Return the integral of (cos(h cos t) - cos h)^2 / sin t over t from 0 to pi.

    Gauss-Legendre in cos t, where the integrand is entire; equal to Balanis 4-68, whose sine and
    cosine integrals cancel for short antennas.
    """
    nodes, weights = np.polynomial.legendre.leggauss(40 + math.ceil(2.0 * half_length_rad))
    plus = np.sin(0.5 * half_length_rad * (1.0 + nodes))
    minus = np.sin(0.5 * half_length_rad * (1.0 - nodes))
    return float(weights @ (4.0 * plus**2 * minus**2 / (1.0 - nodes**2)))


def make_antenna(
    kind: str,
    frequency_hz: float,
    *,
    length_m: float | None = None,
    axis: npt.ArrayLike = (0.0, 0.0, 1.0),
) -> Antenna:
    """Return an antenna, half a wavelength (dipole) or a quarter (monopole) long unless told.

    Parameters
    ----------
    kind : str
        ``dipole``, ``monopole`` or ``isotropic_theta``.
    frequency_hz : float
        Frequency [Hz].
    length_m : float, optional
        Length [m], > 0.
    axis : (3,) float
        Direction of the antenna [-], of any length; vertical by default.

    Returns
    -------
    Antenna
        The antenna.

    Raises
    ------
    AntennaError
        For an unknown kind, or a length, frequency or axis that cannot be.
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
        length_m = wavelength_m / (2.0 if kind == "dipole" else 4.0)
    elif not (math.isfinite(length_m) and length_m > 0.0):
        msg = f"length_m = {length_m} is not a length; give a number above 0 m."
        raise AntennaError(msg)
    return Antenna(
        kind=kind,  # type: ignore[arg-type]  # checked against the Literal above
        length_m=length_m,
        frequency_hz=frequency_hz,
        axis=np.asarray(axis, dtype=np.float64),
    )
