"""Backscatter: the reader's wave wakes a tag without a transmitter, and comes back modulated.

By reciprocity a channel's gain is the same both ways, so that the gains of a `ReaderLink` give the
forward link, reader to chip, and the backward link, chip to reader, through the same paths.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from octant.em.blocks import Progress
from octant.em.power.received_power import ReaderLink, ReceivedPower
from octant.em.search.ray_share import RayShare
from octant.geometries.errors import AntennaError

FloatArray = npt.NDArray[np.float64]

Sender = Literal["each", "strongest", "separate"]
"""Which antenna sends: each while it is read, the one that the tag hears best, or one of its own.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class BackscatterBudget:
    """What happens to the reader's power besides the channel's gain.

    J. D. Griffin and G. D. Durgin, Complete link budgets for backscatter-radio and RFID systems,
    IEEE Antennas Propag. Mag. 51(2), 2009, equations 1 (power-up) and 5 (backscatter): chip_w = P g
    forward and RSS = P g g' backward, with the gains g, g' of the way there and back, which hold
    both antennas' gains and the polarisation of all paths.

    Parameters
    ----------
    sent_w : Power P that the reader's transmitter offers its antenna [W].
    forward : Share [-] that the chip takes of what a matched tag antenna of the same polarisation
        would deliver: power transmission coefficient, further polarisation loss.
    backward : Share [-] of that power that comes back modulated: the modulation factor |Γ1 - Γ2|²/4
        of the chip's two states, so that the differential radar cross section is λ² G² /(4π) times
        it; further losses of backscatter and of polarisation, there and back.
    wakes_w : Power at the chip from which it works [W].
    decodes_w : RSS from which the reader decodes the answer [W].
    """

    sent_w: float
    forward: float = 1.0
    backward: float = 1.0
    wakes_w: float = 0.0
    decodes_w: float = 0.0

    def __post_init__(self) -> None:
        sound = math.isfinite(self.sent_w) and self.sent_w > 0.0
        shares = (self.forward, self.backward)
        if not (sound and all(0.0 < share <= 1.0 for share in shares)):
            msg = (
                f"a backscatter link sends {self.sent_w} W with shares {shares}, but it needs "
                "power above 0 W and shares between 0 and 1; check the losses."
            )
            raise AntennaError(msg)

    def least_gain(self) -> float:
        """Return the gain [-] from which one antenna that sends and receives reads the tag."""
        forward = self.wakes_w / (self.sent_w * self.forward)
        return max(forward, math.sqrt(self.decodes_w / (self.sent_w * self.backward)))


class Answers(NamedTuple):
    """What becomes of the reader's questions; the last axis counts the antenna that is read."""

    rss: ReceivedPower  # RSS [W] of what comes back, 0 while the tag sleeps or is not decoded
    chip_w: FloatArray  # power at the chip while that antenna is read, mean over channels [W]
    chip_mean_w: FloatArray  # the same of the power sums over paths [W]
    margin: FloatArray  # chip's power over what wakes it, on the best channel [-]
    read: npt.NDArray[np.bool_]  # whether the tag wakes and is decoded, on any channel


def answers(
    gains: Sequence[ReceivedPower],
    budget: BackscatterBudget,
    *,
    sender: Sender = "each",
    separate: Sequence[ReceivedPower] = (),
) -> Answers:
    """Return what a tag takes [W] and answers, for the gains of one or more channels.

    On each channel the tag answers, or not; RSS is the mean over those on which it does. The local
    mean is the product of both ways' power sums over paths: where k equal paths arrive, the mean of
    the product over their phases is (2 - 1/k) times that.

    Parameters
    ----------
    gains : (..., n) — Gains of the reader's antennas, a channel each, in place of powers [-].
    budget, sender : Losses and thresholds; which antenna sends.
    separate : (..., 1) — Gains of the separate antenna, likewise.
    """
    shape = gains[0].coherent_w.shape
    rss, mean, chip, chip_mean = (np.zeros(shape) for _ in range(4))
    margin = np.zeros(shape)
    heard = np.zeros(shape, dtype=np.int64)
    for number, back in enumerate(gains):
        there = _there(back, sender, separate[number] if separate else None)
        at_chip = budget.sent_w * budget.forward * there.coherent_w
        returned = budget.sent_w * budget.backward * there.coherent_w * back.coherent_w
        with np.errstate(divide="ignore", invalid="ignore"):
            over = np.where(at_chip > 0.0, at_chip / budget.wakes_w, 0.0)
        read = (at_chip > 0.0) & (over >= 1.0) & (returned >= budget.decodes_w)
        read &= returned > 0.0
        rss += np.where(read, returned, 0.0)
        product = budget.sent_w * budget.backward * there.local_mean_w * back.local_mean_w
        mean += np.where(read, product, 0.0)
        heard += read
        chip += at_chip / len(gains)
        chip_mean += budget.sent_w * budget.forward * there.local_mean_w / len(gains)
        margin = np.maximum(margin, over)
    count = np.maximum(heard, 1)
    return Answers(
        rss=ReceivedPower(rss / count, mean / count, gains[0].path_count),
        chip_w=chip,
        chip_mean_w=chip_mean,
        margin=margin,
        read=heard > 0,
    )


def _there(back: ReceivedPower, sender: Sender, separate: ReceivedPower | None) -> ReceivedPower:
    """Return the gains of the way to the tag while each antenna is read."""
    if sender == "each":
        return back
    if sender == "separate":
        if separate is None:
            msg = 'the sender is "separate", but no gains of a separate antenna are given; do so.'
            raise AntennaError(msg)
        coherent = np.broadcast_to(separate.coherent_w, back.coherent_w.shape)
        mean = np.broadcast_to(separate.local_mean_w, back.coherent_w.shape)
        return ReceivedPower(coherent, mean, separate.path_count)
    best = back.coherent_w.argmax(axis=-1)[..., None]
    coherent, mean = (
        np.broadcast_to(np.take_along_axis(power, best, axis=-1), power.shape)
        for power in (back.coherent_w, back.local_mean_w)
    )
    return ReceivedPower(coherent, mean, back.path_count)


class SeparateGain(Protocol):
    """The gain from a separate sending antenna to the tag, for poses of the robot."""

    def power(self, poses: npt.ArrayLike) -> ReceivedPower:
        """Return (m, 1) gains [-].

        Parameters
        ----------
        poses : (m, 3) float — x [m], y [m] and heading [rad] of the robot.
        """
        ...

    def power_by_heading(
        self, places_m: npt.ArrayLike, headings_rad: npt.ArrayLike
    ) -> ReceivedPower:
        """Return (p, h, 1) gains [-].

        Parameters
        ----------
        places_m, headings_rad : (p, 2), (h,) float — x, y [m] of the robot, headings [rad].
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedGain:
    """The gain from an antenna that stands in the room to the tag, wherever the robot is.

    Parameters
    ----------
    coherent, local_mean : Gain, and its power sum over paths [-].
    """

    coherent: float
    local_mean: float

    def power(self, poses: npt.ArrayLike) -> ReceivedPower:
        """Return the gain for each of (m, 3) poses, (m, 1) [-]."""
        return self._everywhere((len(np.asarray(poses)), 1))

    def power_by_heading(
        self, places_m: npt.ArrayLike, headings_rad: npt.ArrayLike
    ) -> ReceivedPower:
        """Return the gain for each of (p, 2) places and (h,) headings, (p, h, 1) [-]."""
        return self._everywhere((len(np.asarray(places_m)), len(np.asarray(headings_rad)), 1))

    def _everywhere(self, shape: tuple[int, ...]) -> ReceivedPower:
        count = np.ones(shape[0], dtype=np.int64)
        return ReceivedPower(np.full(shape, self.coherent), np.full(shape, self.local_mean), count)


@dataclass(frozen=True, slots=True, kw_only=True)
class BackscatterLink:
    """The link of a reader to a passive or semi-passive tag, for any pose of the robot.

    Parameters
    ----------
    ways : Gain of the way between tag and reader, one for each channel: links of 1 W.
    budget, sender : Losses and thresholds; which antenna sends.
    separate : Gain of the way from the separate antenna to the tag, one for each channel.
    """

    ways: tuple[ReaderLink, ...]
    budget: BackscatterBudget
    sender: Sender = "each"
    separate: tuple[SeparateGain, ...] = ()

    @property
    def antennas(self) -> int:
        """Number of antennas."""
        return self.ways[0].antennas

    @property
    def azimuths_rad(self) -> FloatArray:
        """Azimuth of each antenna in the reader's frame, (n,) [rad]."""
        return self.ways[0].azimuths_rad

    @property
    def tag_position_m(self) -> FloatArray:
        """Place of the tag, (3,) [m]."""
        return self.ways[0].tag_position_m

    @property
    def reader_z_m(self) -> float:
        """Height of the reader's centre in the room's frame [m]."""
        return self.ways[0].reader_z_m

    @property
    def rays(self) -> RayShare | None:
        """What share of the power is missing, where rays have found the paths; None: none is."""
        return self.ways[0].rays

    def always_awake(self) -> "BackscatterLink":
        """Return the link to the same tag without thresholds [W]."""
        return replace(self, budget=replace(self.budget, wakes_w=0.0, decodes_w=0.0))

    def answers(self, poses: npt.ArrayLike, *, progress: Progress | None = None) -> Answers:
        """Return the tag's answers to all antennas, (m, n) [W].

        Parameters
        ----------
        poses : (m, 3) float — x [m], y [m] and heading [rad] of the robot.
        progress : Called after every block.
        """
        return self._answers(
            lambda way, shown: way.power(poses, progress=shown),
            [antenna.power(poses) for antenna in self.separate],
            progress,
        )

    def power(self, poses: npt.ArrayLike, *, progress: Progress | None = None) -> ReceivedPower:
        """Return (m, n) RSS of what the tag sends back [W], and (m,) path counts.

        Parameters
        ----------
        poses, progress : As in :meth:`answers`.
        """
        return self.answers(poses, progress=progress).rss

    def power_by_heading(
        self,
        places_m: npt.ArrayLike,
        headings_rad: npt.ArrayLike,
        *,
        progress: Progress | None = None,
    ) -> ReceivedPower:
        """Return (p, h, n) RSS [W]; a place is traced once for all headings.

        Parameters
        ----------
        places_m, headings_rad : (p, 2), (h,) float — x, y [m] of the robot, headings [rad].
        progress : Called after every block.
        """
        return self.answers_by_heading(places_m, headings_rad, progress=progress).rss

    def answers_by_heading(
        self,
        places_m: npt.ArrayLike,
        headings_rad: npt.ArrayLike,
        *,
        progress: Progress | None = None,
    ) -> Answers:
        """Return the tag's answers to all antennas, (p, h, n) [W].

        Parameters
        ----------
        places_m, headings_rad, progress : As in :meth:`power_by_heading` [m], [rad].
        """
        return self._answers(
            lambda way, shown: way.power_by_heading(places_m, headings_rad, progress=shown),
            [antenna.power_by_heading(places_m, headings_rad) for antenna in self.separate],
            progress,
        )

    def rss_w(self, poses: npt.ArrayLike) -> FloatArray:
        """Return the coherent RSS of all antennas at each pose, (m, n) [W]; 0 without an answer."""
        return self.power(poses).coherent_w

    def rss_by_heading_w(self, places_m: npt.ArrayLike, headings_rad: npt.ArrayLike) -> FloatArray:
        """Return the coherent RSS at each place and heading, (p, h, n) [W]; 0 without an answer.

        Parameters
        ----------
        places_m, headings_rad : As in :meth:`power_by_heading` [m], [rad].
        """
        return self.power_by_heading(places_m, headings_rad).coherent_w

    def reads(self, poses: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Return at which poses [m], [rad] the tag answers which antenna, (m, n)."""
        return self.answers(poses).read

    def _answers(
        self,
        gain: Callable[[ReaderLink, Progress | None], ReceivedPower],
        separate: Sequence[ReceivedPower],
        progress: Progress | None,
    ) -> Answers:
        shown = [progress, *[None] * (len(self.ways) - 1)]  # channels share the places to count
        gains = [gain(way, each) for way, each in zip(self.ways, shown, strict=True)]
        return answers(gains, self.budget, sender=self.sender, separate=separate)


Link = ReaderLink | BackscatterLink
"""What gives the RSS of a tag at all antennas of the reader, whatever powers the tag."""
