"""RSS measured by the tags, thesis 4.6.2: 8-bit codes in 24-bit frames, one tag after another."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.checks import check_positive
from octant.navigation.sensing.tag_layouts import tag_distances_m

FloatArray = npt.NDArray[np.float64]

ID_BITS = 16
"""Bits of a tag's identity [-]. Section 6.2 prints identities such as 0xFFFF9, which have twenty;
those of 7.6.1, 0x5001 to 0x5004, have sixteen."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RssCodes:
    """The codes in which a tag answers; the defaults are those of the XBee that emulated it.

    Its byte is the RSS in whole decibels below 1 mW, so that 255 is -255 dBm and 0 is 0 dBm. Here
    codes rise with the power. What lies outside is cut to the last code: unlike a receiver that
    hears nothing (`RssQuantiser`), a tag within its range always answers.

    Parameters
    ----------
    bits : Length of a code.
    floor_dbm, full_scale_dbm : Powers of the lowest and of the highest code [dBm].
    """

    bits: int = 8
    floor_dbm: float = -255.0
    full_scale_dbm: float = 0.0

    def __post_init__(self) -> None:
        if not (1 <= self.bits <= 16 and self.floor_dbm < self.full_scale_dbm):
            msg = (
                f"the tags' codes have {self.bits} bits from {self.floor_dbm} to "
                f"{self.full_scale_dbm} dBm, but they need 1 to 16 bits and must rise: give the "
                "floor first."
            )
            raise NavigationError(msg)

    @property
    def step_db(self) -> float:
        """Return the distance of two codes [dB]."""
        codes: int = 2**self.bits
        return (self.full_scale_dbm - self.floor_dbm) / (codes - 1)

    def codes(self, rss_dbm: npt.ArrayLike) -> npt.NDArray[np.int64]:
        """Return the codes of readings, any shape.

        Parameters
        ----------
        rss_dbm : (...) float64 — RSS [dBm], finite.
        """
        steps = (np.asarray(rss_dbm, dtype=np.float64) - self.floor_dbm) / self.step_db
        return np.clip(np.rint(steps), 0, 2**self.bits - 1).astype(np.int64)

    def rss_dbm(self, codes: npt.ArrayLike) -> FloatArray:
        """Return the RSS that codes stand for, any shape [dBm].

        Parameters
        ----------
        codes : (...) int — From `codes`.
        """
        rss: FloatArray = self.floor_dbm + self.step_db * np.asarray(codes, dtype=np.float64)
        return rss

    def coded(self, rss_dbm: FloatArray) -> FloatArray:
        """Return readings as they arrive, rounded and cut [dBm]; those not heard stay NaN.

        Parameters
        ----------
        rss_dbm : (...) float64 — What the tags measure [dBm]; NaN: not heard.
        """
        lost = np.isnan(rss_dbm)
        return np.where(lost, np.nan, self.rss_dbm(self.codes(np.where(lost, 0.0, rss_dbm))))

    def frame(self, tag_id: int, code: int) -> int:
        """Return a frame: the identity, then the code.

        Parameters
        ----------
        tag_id, code : Identity of `ID_BITS` bits, and a code.
        """
        if not (0 <= tag_id < 1 << ID_BITS and 0 <= code < 1 << self.bits):
            msg = (
                f"the identity is {tag_id:#x} and the code {code}, but they have {ID_BITS} and "
                f"{self.bits} bits: give less."
            )
            raise NavigationError(msg)
        return tag_id << self.bits | code

    def parts(self, frame: int) -> tuple[int, int]:
        """Return identity and code of a frame.

        Parameters
        ----------
        frame : From `frame`.
        """
        return frame >> self.bits, frame & ((1 << self.bits) - 1)


@dataclass(frozen=True, slots=True, kw_only=True)
class Polling:
    """When each tag answers: the reader asks all with its identity, each replies in its turn.

    Parameters
    ----------
    tags : Number of tags.
    bit_rate_hz : Bits in a second [Hz].
    turnaround_s : Pause before every reply [s].
    code_bits : Bits of the code that follows a tag's identity.
    """

    tags: int
    bit_rate_hz: float
    turnaround_s: float = 0.0
    code_bits: int = 8

    def __post_init__(self) -> None:
        check_positive(self.bit_rate_hz, name="bit_rate_hz", unit="Hz")
        check_positive(self.turnaround_s, name="turnaround_s", unit="s", allow_zero=True)

    @property
    def query_s(self) -> float:
        """Return how long the reader's question takes [s]."""
        return ID_BITS / self.bit_rate_hz

    @property
    def reply_s(self) -> float:
        """Return how long a tag's reply takes, with the pause before it [s]."""
        return self.turnaround_s + (ID_BITS + self.code_bits) / self.bit_rate_hz

    @property
    def round_s(self) -> float:
        """Return the time from one question to the next [s]."""
        return self.query_s + self.tags * self.reply_s

    def replies(self, time_s: float) -> npt.NDArray[np.int64]:
        """Return how many replies of each tag are complete at a time, (tags,).

        Parameters
        ----------
        time_s : Since the first question began [s].
        """
        first = self.query_s + self.reply_s * np.arange(1, self.tags + 1)
        done = np.floor((time_s - first) / self.round_s + 1e-9).astype(np.int64) + 1
        replies: npt.NDArray[np.int64] = np.maximum(done, 0)
        return replies

    def heard(self, begin_s: float, end_s: float) -> npt.NDArray[np.bool_]:
        """Return which tags' replies arrive in a period, (tags,).

        Parameters
        ----------
        begin_s, end_s : The period [s]; a reply belongs to the period in which it ends.
        """
        return np.asarray(self.replies(end_s) > self.replies(begin_s))


@dataclass(frozen=True, slots=True, kw_only=True)
class Hearing:
    """What the reader hears of the tags; what it does not hear is NaN.

    Parameters
    ----------
    tags_m : (s, 3) float64 — The tags, heights above the antenna [m].
    range_m : Distance from which on a tag is not heard [m].
    codes : Codes in which tags answer; None: readings are not rounded.
    polling : When each tag answers; None: all in every reading.
    """

    tags_m: FloatArray
    range_m: float = np.inf
    codes: RssCodes | None = None
    polling: Polling | None = None

    def heard(self, poses: FloatArray, rss_dbm: FloatArray) -> FloatArray:
        """Return readings as they arrive, (r, s) [dBm]; NaN beyond the range.

        Parameters
        ----------
        poses : (r, 3) float64 — True x [m], y [m], heading [rad].
        rss_dbm : (r, s) float64 — What the tags measure, with its noise [dBm].
        """
        within = tag_distances_m(poses, self.tags_m) <= self.range_m
        rss = np.where(within, rss_dbm, np.nan)
        return rss if self.codes is None else self.codes.coded(rss)
