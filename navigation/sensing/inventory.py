"""How soon a reader reads tags that answer together: framed slotted Aloha as in EPC Gen2.

Tags draw a slot of a frame each; one alone in its slot is read, several collide and draw again. The
reader chooses the frame's size by the Q algorithm. EPC UHF Gen2 Air Interface Protocol 2.1 (ISO/IEC
18000-63), sections 6.3.1.2 (bits), 6.3.1.6 (link timing) and Annex D (Q algorithm).
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError

FloatArray = npt.NDArray[np.float64]

DELIMITER_S = 12.5e-6
"""Begin of every command of the reader [s]."""
POWER_UP_S = 1.5e-3
"""From the reader's wave to a tag that listens [s], at most (6.3.1.3.4): a tag that the reader's
next antenna wakes anew needs it."""
QUERY_BITS, REPEAT_BITS, ADJUST_BITS, ACK_BITS = 22, 4, 9, 18
"""Lengths of the reader's commands [bit]."""
RN16_BITS, AROUND_EPC_BITS = 16, 32
"""A tag's first answer; what its second has besides the EPC: protocol control and CRC [bit]."""
MOST_Q = 15
"""Exponent of the largest frame [-]."""
READINGS = 4000
"""Tags that are read in simulations for one read probability [-]: 0.8 percentage points at most."""
INVENTORY_STREAM = 7_451
"""Keeps the random numbers of inventories apart from those of other parts [-]."""


def aloha_throughput(tags: npt.ArrayLike, slots: npt.ArrayLike) -> FloatArray:
    """Return the mean share of a frame's slots in which one tag alone answers [-].

    N/L (1 - 1/L)^(N - 1): greatest for a frame of as many slots as tags, 1/e for many. F. C.
    Schoute, IEEE Trans. Commun. 31(4), 1983, p. 565.

    Parameters
    ----------
    tags, slots : Number N of tags that answer, and L of slots, at least 1 [-].
    """
    n, size = np.broadcast_arrays(np.asarray(tags, float), np.asarray(slots, float))
    return np.asarray(n / size * (1.0 - 1.0 / size) ** (n - 1.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class Gen2:
    """The air interface of an inventory, and what its slots take.

    The reader's bits are taken as half zeros, half ones. T2, from a tag's answer to the next
    command, and T3, the further wait for an answer that does not come, are 10 periods of the
    backscatter link frequency each; the protocol allows T2 from 3 to 20 and any T3.

    Parameters
    ----------
    tari_s : Length of the reader's zero [s].
    one_per_zero : Length of its one by that of its zero [-], 1.5 to 2.
    blf_hz : Backscatter link frequency [Hz].
    miller : Subcarrier cycles of a tag's bit [-]: 1 (FM0), 2, 4 or 8.
    pilot : Whether tags send the long preamble (TRext).
    epc_bits : Length of a tag's number [bit].
    q : First exponent of the frame size 2^Q [-].
    q_step : Constant C of the Q algorithm [-], 0.1 to 0.5.
    """

    tari_s: float = 12.5e-6
    one_per_zero: float = 2.0
    blf_hz: float = 250e3
    miller: int = 4
    pilot: bool = False
    epc_bits: int = 96
    q: int = 4
    q_step: float = 0.3

    def __post_init__(self) -> None:
        if not (0.1 <= self.q_step <= 0.5 and 0 <= self.q <= MOST_Q):
            msg = (
                f"q is {self.q} and q_step {self.q_step}, but an inventory needs 0 to {MOST_Q} and "
                "0.1 to 0.5: change them."
            )
            raise NavigationError(msg)
        low, high = 1.1 * self.calibration_s, 3.0 * self.calibration_s
        if not any(low <= ratio / self.blf_hz <= high for ratio in (8.0, 64.0 / 3.0)):
            msg = (
                f"a backscatter link frequency of {self.blf_hz / 1e3:g} kHz cannot be asked for "
                f"with zeros of {self.tari_s * 1e6:g} µs: 8 or 64/3 of its periods must last "
                f"{low * 1e6:.4g} to {high * 1e6:.4g} µs; change one of the two."
            )
            raise NavigationError(msg)

    @property
    def calibration_s(self) -> float:
        """Return RTcal, a zero and a one of the reader [s]."""
        return self.tari_s * (1.0 + self.one_per_zero)

    @property
    def _tag_calibration_s(self) -> float:
        """Return TRcal [s], by the divide ratio that the protocol allows here; 64/3 first."""
        long_s = 64.0 / 3.0 / self.blf_hz
        fits = 1.1 * self.calibration_s <= long_s <= 3.0 * self.calibration_s
        return long_s if fits else 8.0 / self.blf_hz

    def command_s(self, bits: int, *, first: bool = False) -> float:
        """Return what a command takes, frame-sync or preamble included [s].

        Parameters
        ----------
        bits, first : Its length [bit]; whether it opens a round (Query, with its preamble).
        """
        start_s = DELIMITER_S + self.tari_s + self.calibration_s
        if first:
            start_s += self._tag_calibration_s
        return start_s + 0.5 * bits * self.calibration_s

    def answer_s(self, bits: int) -> float:
        """Return what a tag's answer takes, preamble and closing bit included [s].

        Parameters
        ----------
        bits : Its length [bit].
        """
        preamble = (18 if self.pilot else 6) if self.miller == 1 else (22 if self.pilot else 10)
        return (preamble + bits + 1) * self.miller / self.blf_hz

    @property
    def turn_s(self) -> float:
        """Return T1, from a command to the tag's answer [s]."""
        return max(self.calibration_s, 10.0 / self.blf_hz)

    @property
    def pause_s(self) -> float:
        """Return T2, and T3 [s]."""
        return 10.0 / self.blf_hz

    def slot_s(self, answering: int) -> float:
        """Return what a slot takes besides the command that opens it [s].

        Parameters
        ----------
        answering : Tags that answer in it: none, one that is read, more that collide.
        """
        if answering == 0:
            return self.turn_s + self.pause_s
        heard_s = self.turn_s + self.answer_s(RN16_BITS) + self.pause_s
        if answering > 1:
            return heard_s
        epc_s = self.turn_s + self.answer_s(self.epc_bits + AROUND_EPC_BITS) + self.pause_s
        return heard_s + self.command_s(ACK_BITS) + epc_s

    def read_times_s(self, tags: int, rng: np.random.Generator) -> FloatArray:
        """Return when each tag is read after the wave begins in one simulated inventory [s].

        In the order of reading. After an empty slot Q falls by C, after a collision it rises by C;
        where its rounded value changes the reader begins a new frame (QueryAdjust), as at the end
        of a frame that leaves tags (Query). Tags that are read stay silent.

        Parameters
        ----------
        tags, rng : Number of tags that answer; source of their slots.
        """
        query_s = self.command_s(QUERY_BITS, first=True)
        repeat_s, adjust_s = self.command_s(REPEAT_BITS), self.command_s(ADJUST_BITS)
        slot_s = [self.slot_s(k) for k in range(3)]
        level, size_q, left = float(self.q), self.q, tags
        now_s = POWER_UP_S + query_s
        times: list[float] = []
        while left:
            slots = np.bincount(rng.integers(2**size_q, size=left), minlength=2**size_q)
            adjusted = False
            for number, answering in enumerate(np.minimum(slots, 2).tolist()):
                now_s += slot_s[answering] + (repeat_s if number else 0.0)
                if answering == 1:
                    times.append(now_s)
                    left -= 1
                    if left == 0:
                        break
                    continue
                step = self.q_step if answering else -self.q_step
                level = min(max(level + step, 0.0), float(MOST_Q))
                if round(level) != size_q:
                    size_q, adjusted = round(level), True
                    break
            now_s += adjust_s if adjusted else query_s
        return np.array(times)


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadRates:
    """The probability that a tag is read within the time that the reader gives each antenna.

    Parameters
    ----------
    probability : (k,) float64 — For one of the known tags that answers, for two, ... [-].
    """

    probability: FloatArray

    def __post_init__(self) -> None:
        value = frozen_array(
            self.probability, name="probability", shape=(None,), error=NavigationError
        )
        object.__setattr__(self, "probability", value)

    def of(self, tags: npt.ArrayLike) -> FloatArray:
        """Return the probability for numbers of tags that answer [-]; 0 for none.

        Parameters
        ----------
        tags : (...) int — Tags that answer, the wanted one among them [-].
        """
        return np.concatenate(([0.0], self.probability))[np.asarray(tags, dtype=np.int64)]


@lru_cache(maxsize=64)
def _simulated_s(protocol: Gen2, tags: int) -> tuple[FloatArray, ...]:
    """Return read times of many inventories [s]; the same for the same arguments."""
    rng = np.random.default_rng((INVENTORY_STREAM, tags))
    return tuple(protocol.read_times_s(tags, rng) for _ in range(math.ceil(READINGS / tags)))


def round_s(protocol: Gen2, tags: int) -> float:
    """Return the mean time until all tags of an inventory are read [s].

    Parameters
    ----------
    protocol, tags : The air interface; number of tags that answer, at least 1.
    """
    return float(np.mean([times[-1] for times in _simulated_s(protocol, tags)]))


def read_probability(protocol: Gen2, tags: int, within_s: float) -> float:
    """Return the probability that a tag is read within a time of the wave's begin [-].

    Parameters
    ----------
    protocol, tags : As in `round_s`; all tags are alike.
    within_s : Time that an antenna is given [s].
    """
    times = np.concatenate(_simulated_s(protocol, tags))
    return float((times <= within_s).mean())


def read_rates(protocol: Gen2, tags: int, within_s: float, *, others: int = 0) -> ReadRates:
    """Return the read probabilities for one answering tag up to all, others always answering [-].

    Parameters
    ----------
    protocol, tags, within_s : The air interface; tags that may answer; time of an antenna [s].
    others : Further tags that answer always.
    """
    counts = range(others + 1, others + tags + 1)
    return ReadRates(
        probability=np.array([read_probability(protocol, k, within_s) for k in counts])
    )
