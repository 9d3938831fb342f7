"""What a receiver makes of the powers that arrive: its noise, its sensitivity, its codes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.navigation.checks import check_positive
from octant.navigation.sensing.rss_detector import RssQuantiser, ThermalNoise, log_normal_rss

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """A receiver, in the order in which its errors come.

    Parameters
    ----------
    noise_db : Standard deviation of the log-normal error of each reading [dB].
    sensitivity_w : RSS below this is not received and reads zero [W].
    quantiser, thermal : The detector's codes; the receiver's own noise; None for none.
    """

    noise_db: float = 0.0
    sensitivity_w: float = 0.0
    quantiser: RssQuantiser | None = None
    thermal: ThermalNoise | None = None

    def __post_init__(self) -> None:
        check_positive(self.noise_db, name="noise_db", unit="dB", allow_zero=True)
        check_positive(self.sensitivity_w, name="sensitivity_w", unit="W", allow_zero=True)

    def measured(
        self, rss_w: FloatArray, rng: np.random.Generator, own: np.random.Generator
    ) -> FloatArray:
        """Return what is read of powers of any shape [W]; zero: nothing.

        Parameters
        ----------
        rss_w : (...) float64 — Power that arrives [W].
        rng, own : Sources of the log-normal error, and of everything else.
        """
        rss = rss_w if self.thermal is None else self.thermal.reading_w(rss_w, own)
        rss = log_normal_rss(rss, self.noise_db, rng)
        rss = np.where(rss < self.sensitivity_w, 0.0, rss)
        return rss if self.quantiser is None else self.quantiser.quantise(rss)


@dataclass(frozen=True, slots=True, kw_only=True)
class TagReceiver:
    """A receiver of one antenna that reads many tags, each answering by itself.

    Parameters
    ----------
    device : What it makes of the power.
    lost_probability : Probability that a tag's reading is lost [-].
    """

    device: Device
    lost_probability: float = 0.0

    def heard(self, rss_dbm: FloatArray, rngs: Sequence[np.random.Generator]) -> FloatArray:
        """Return readings as they arrive, (r, s) [dBm]; NaN: nothing.

        Parameters
        ----------
        rss_dbm : (r, s) float64 — RSS of the tags, errors of the channel included [dBm].
        rngs : One for each run.
        """
        read = np.empty(rss_dbm.shape)
        for row, (levels, rng) in enumerate(zip(rss_dbm, rngs, strict=True)):
            own = rng.spawn(1)[0]
            lost = own.random(len(levels)) < self.lost_probability
            rss = self.device.measured(10.0 ** ((levels - 30.0) / 10.0), rng, own)
            read[row] = np.where(lost | (rss <= 0.0), np.nan, power_dbm(np.maximum(rss, 1e-300)))
        return read
