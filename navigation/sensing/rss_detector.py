"""What a receiver makes of a signal's power: thermal noise, device error, codes."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.constants import BOLTZMANN_J_PER_K
from octant.em.decibels import power_dbm
from octant.geometries.errors import NavigationError

REFERENCE_K = 290.0
"""Temperature [K] that noise figures refer to."""


def log_normal_rss(
    rss_w: npt.ArrayLike, noise_db: float, rng: np.random.Generator
) -> npt.NDArray[np.float64]:
    """Return RSS times 10^(N(0, noise_db)/10), independent for every value [W].

    The thesis writes additive noise, z = z^d Γ(δ) + ζ (5.2.2.1), without its size; RSS detectors'
    errors are specified in decibels. The median is one, the mean +0.1 dB for 1 dB, +1 dB for 3 dB.

    Parameters
    ----------
    rss_w : (...) float64 — RSS free of noise [W].
    noise_db : Standard deviation of the factor [dB], zero for none.
    rng : Source of the noise; as many numbers are drawn whatever `noise_db` is.
    """
    rss = np.asarray(rss_w, dtype=np.float64)
    noisy: npt.NDArray[np.float64] = rss * 10.0 ** (rng.normal(0.0, noise_db, rss.shape) / 10.0)
    return noisy


@dataclass(frozen=True, slots=True, kw_only=True)
class ThermalNoise:
    """The thermal noise of a receiver that measures power.

    Each sample of a constant signal of power P has a circular complex Gaussian voltage of power N =
    k T0 B F, T0 = 290 K. The mean of |sqrt(P) + n|^2 over M samples is N / 2M times a noncentral
    chi-square of 2 M degrees of freedom and noncentrality 2 M P / N: mean P + N, variance (2 P N +
    N^2) / M. N is not subtracted. H. T. Friis, Proc. IRE 32, 1944, p. 419; H. Urkowitz, Proc. IEEE
    55, 1967, p. 523.

    Parameters
    ----------
    bandwidth_hz, noise_figure_db : Noise bandwidth B [Hz] and figure F [dB].
    samples : Independent samples M that a reading averages in power.
    """

    bandwidth_hz: float
    noise_figure_db: float = 0.0
    samples: int = 1

    def __post_init__(self) -> None:
        if not (np.isfinite(self.bandwidth_hz) and self.bandwidth_hz > 0.0):
            msg = (
                f"bandwidth_hz is {self.bandwidth_hz} Hz, but it must be positive and finite: give "
                "the receiver's noise bandwidth."
            )
            raise NavigationError(msg)
        if not (np.isfinite(self.noise_figure_db) and self.noise_figure_db >= 0.0):
            msg = (
                f"noise_figure_db is {self.noise_figure_db} dB, but no receiver is better than "
                "0 dB: give a finite number from there on."
            )
            raise NavigationError(msg)
        if self.samples < 1:
            msg = f"samples is {self.samples}, but a reading needs at least one: raise it."
            raise NavigationError(msg)

    @property
    def power_w(self) -> float:
        """Return the noise power N referred to the antenna [W]."""
        factor: float = 10.0 ** (self.noise_figure_db / 10.0)
        return BOLTZMANN_J_PER_K * REFERENCE_K * self.bandwidth_hz * factor

    def reading_w(self, rss_w: npt.ArrayLike, rng: np.random.Generator) -> npt.NDArray[np.float64]:
        """Return the mean power of signal and noise over the samples [W].

        The noise of samples without the signal is one gamma variable in place of M - 1 draws.

        Parameters
        ----------
        rss_w : (...) float64 — Power of each signal [W].
        rng : Source of the noise.
        """
        rss = np.asarray(rss_w, dtype=np.float64)
        in_phase, quadrature = rng.normal(size=(2, *rss.shape))
        others = rng.standard_gamma(self.samples - 1.0, rss.shape)
        half_w = 0.5 * self.power_w
        one = (np.sqrt(self.samples * rss) + np.sqrt(half_w) * in_phase) ** 2
        total = one + half_w * quadrature**2 + self.power_w * others
        mean: npt.NDArray[np.float64] = total / self.samples
        return mean


@dataclass(frozen=True, slots=True, kw_only=True)
class RssQuantiser:
    """An RSS detector with evenly spaced codes in decibels.

    The thesis fixes 8 bits for its tags (4.6.1) but neither range nor law; RSSI detectors are
    logarithmic. -100 to 0 dBm on 8 bits makes steps of 0.39 dB.

    Parameters
    ----------
    bits : Length of the code [bit], 1 to 16.
    floor_dbm : Power of the lowest code [dBm]; more than half a step below it nothing is received.
    full_scale_dbm : Power of the highest code [dBm]; what is stronger reads as this.
    """

    bits: int = 8
    floor_dbm: float = -100.0
    full_scale_dbm: float = 0.0

    def __post_init__(self) -> None:
        if not 1 <= self.bits <= 16:
            msg = f"bits is {self.bits}, but a detector has 1 to 16 bit: give a whole number there."
            raise NavigationError(msg)
        ends = np.array([self.floor_dbm, self.full_scale_dbm])
        if not (np.isfinite(ends).all() and self.floor_dbm < self.full_scale_dbm):
            msg = (
                f"the detector's range is {self.floor_dbm} to {self.full_scale_dbm} dBm, but it "
                "must rise and be finite: give the floor first."
            )
            raise NavigationError(msg)

    @property
    def step_db(self) -> float:
        """Return the distance of two codes [dB]."""
        codes: int = 2**self.bits
        return (self.full_scale_dbm - self.floor_dbm) / (codes - 1)

    def quantise(self, rss_w: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return the power of the nearest code [W], zero below the lowest code.

        Parameters
        ----------
        rss_w : (...) float64 — Received power, not negative [W].
        """
        rss = np.asarray(rss_w, dtype=np.float64)
        level_dbm = power_dbm(np.maximum(rss, np.finfo(np.float64).tiny))
        code = np.rint((level_dbm - self.floor_dbm) / self.step_db)
        nearest_dbm = self.floor_dbm + self.step_db * np.minimum(code, 2**self.bits - 1)
        return np.where(code < 0.0, 0.0, 10.0 ** ((nearest_dbm - 30.0) / 10.0))
