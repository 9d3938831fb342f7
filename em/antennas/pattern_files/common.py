"""What every pattern format shares: the table, its grid, its scale, and how a line is refused."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import PatternFileError

PatternKind = Literal["directivity", "gain", "realised_gain"]
"""Power that |F|^2 is referred to: radiated, accepted, or available from the matched source."""

WAVE_IMPEDANCE_OHM = 376.730313668
"""Impedance of free space [ohm]."""

VOLT_PER_ROOT_WATT = math.sqrt(WAVE_IMPEDANCE_OHM / (2.0 * math.pi))
"""Peak far field r|E| [V] that unit gain gives at 1 W: G = 4 pi r^2 |E|^2 / (2 eta P)."""

DBI_FLOOR = -300.0
"""Gain [dBi] below which a file's number stands for nothing at all."""

NO_PHASE_WARNING = (
    "{source} holds no phase: its pattern is taken as real and positive about the antenna's own "
    "phase centre, so interference between paths from different directions is a guess"
)

_LARGEST = 1e30
_MOST_SAMPLES = 20_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class PatternTable:
    """Far field of one antenna at one frequency on a grid of directions.

    Parameters
    ----------
    frequency_hz : Frequency [Hz]; None where the file names none.
    theta_rad : (T,) float64 — Angles from +z [rad], ascending within 0..pi.
    phi_rad : (P,) float64 — Azimuths from +x towards +y [rad], ascending from 0 to below 2 pi.
    field : (2, T, P) complex128 — F_theta and F_phi [-], |F|^2 = gain over isotropic of the stated
        kind; time e^{+j w t}, wave e^{-j k r} / r taken out.
    kind : {"directivity", "gain", "realised_gain"} — What |F|^2 is.
    phase_known : False: amplitudes only, real and not negative.
    name : Name of the antenna, the request or the file.
    source : File and line that the table starts at, for messages.
    origin_m : (3,) float64 — Point [m] of the file's frame that the phase is referred to.
    impedance_ohm : Input impedance [ohm] where the file gives it.
    warnings : Doubts about the file's content.
    """

    frequency_hz: float | None
    theta_rad: npt.NDArray[np.float64]
    phi_rad: npt.NDArray[np.float64]
    field: npt.NDArray[np.complex128]
    kind: PatternKind
    phase_known: bool = True
    name: str = ""
    source: str = ""
    origin_m: npt.NDArray[np.float64] | Sequence[float] = (0.0, 0.0, 0.0)
    impedance_ohm: complex | None = None
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        where = self.source or self.name or "The pattern"
        theta = self._axis("theta_rad", math.pi * (1.0 + 1e-12), where)
        phi = self._axis("phi_rad", 2.0 * math.pi * (1.0 - 1e-12), where)
        field = frozen_array(
            self.field,
            name=f"{where}: field",
            shape=(2, len(theta), len(phi)),
            dtype=np.complex128,
            error=PatternFileError,
        )
        origin = frozen_array(
            self.origin_m, name=f"{where}: origin_m", shape=(3,), error=PatternFileError
        )
        if self.kind not in get_args(PatternKind):
            allowed = ", ".join(get_args(PatternKind))
            msg = f"{where}: kind {self.kind!r} is unknown; allowed are {allowed}."
            raise PatternFileError(msg)
        frequency = self.frequency_hz
        if frequency is not None and not (math.isfinite(frequency) and frequency > 0.0):
            msg = f"{where}: frequency {frequency} Hz is not a frequency; give a number above 0 Hz."
            raise PatternFileError(msg)
        for name, value in (("theta_rad", theta), ("phi_rad", phi), ("field", field)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "origin_m", origin)

    def _axis(self, name: str, top: float, where: str) -> npt.NDArray[np.float64]:
        """Return a checked, read-only axis of the grid."""
        axis = frozen_array(
            getattr(self, name), name=f"{where}: {name}", shape=(None,), error=PatternFileError
        )
        if len(axis) < 1 or axis[0] < 0.0 or axis[-1] > top or (np.diff(axis) <= 0.0).any():
            msg = f"{where}: {name} must ascend from 0 rad to at most {top:.6g} rad."
            raise PatternFileError(msg)
        return axis

    @property
    def gain(self) -> npt.NDArray[np.float64]:
        """Gain over isotropic [-] of both components together, (T, P)."""
        power: npt.NDArray[np.float64] = np.sum(np.abs(self.field) ** 2, axis=0)
        return power


def amplitude(gain_db: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return the amplitudes |F| of gains [-].

    Parameters
    ----------
    gain_db : array_like — Gains [dBi]; ``DBI_FLOOR`` and less count as nothing.
    """
    gain = np.asarray(gain_db, dtype=np.float64)
    return np.where(gain > DBI_FLOOR, 10.0 ** (np.maximum(gain, DBI_FLOOR) / 20.0), 0.0)


def mean_over_sphere(
    theta_rad: npt.NDArray[np.float64],
    phi_rad: npt.NDArray[np.float64],
    values: npt.NDArray[np.float64],
) -> float:
    """Return the mean of a quantity over all directions, in the quantity's unit [-].

    Exact for band-limited patterns on a uniform grid with both poles, else trapezoidal.

    Parameters
    ----------
    theta_rad, phi_rad : (T,), (P,) float64 — Grid [rad]; theta beyond its ends counts as nothing.
    values : (T, P) float64 — The quantity, in its own unit [-].
    """
    around = np.append(phi_rad, phi_rad[0] + 2.0 * math.pi)
    widths = 0.5 * (np.diff(around) + np.roll(np.diff(around), 1))
    ring = values @ (widths / (2.0 * math.pi))
    n = len(theta_rad)
    if n > 2 and np.allclose(theta_rad, np.linspace(0.0, math.pi, n), atol=1e-9):
        # a ring mean is even in theta: fit cosines, whose integrals against sin theta are known
        order = np.arange(n)
        even = order % 2 == 0
        moments = np.where(even, 2.0 / (1.0 - np.where(even, order, 0.0) ** 2), 0.0)
        weights = np.linalg.solve(np.cos(np.outer(order, theta_rad)), moments)
        return float(0.5 * weights @ ring)
    return float(0.5 * np.trapezoid(ring * np.sin(theta_rad), theta_rad))
