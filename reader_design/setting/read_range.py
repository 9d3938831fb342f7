"""How far a passive tag is read in the open: computed, and by the closed-form link budget."""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.antennas.kinds import Antenna
from octant.em.power.backscatter import BackscatterLink
from octant.reader_design.setting.placing import PlacedTag, alike_from_all_sides
from octant.reader_design.setting.rfid import (
    antenna_pattern,
    peak_gain,
    rfid_table,
    single_response,
    study_tag,
    transmitters,
)
from octant.reader_design.setting.setting import Setting

FloatArray = npt.NDArray[np.float64]

DISTANCES, HEADINGS, SIDES = 150, 72, 24
"""Distances, headings of the robot, and directions from which it comes [-] that are tried."""
HALVINGS = 48
"""Steps that find the farthest distance between two of them [-]."""
WAKING, DECODING = "wake-up", "decoding"
"""What ends a range."""
ITERATIONS = 200
"""Steps of the closed form to the distance at which gains and distance agree [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadRange:
    """How far a tag is read in the open, the robot turned to it in the best way.

    Parameters
    ----------
    slant_m, floor_m : Farthest distance from tag to reader that the radio model finds, along the
        ray and along the floor [m]; 0 where the tag is not even read from below.
    closed_form_m : The same by Friis' equation both ways, with the gains that the antennas have
        towards each other there [m].
    peak_m : The same with the greatest gains of both antennas, as data sheets give them [m].
    limit : What ends the range: ``wake-up`` of the tag or ``decoding`` by the reader.
    """

    slant_m: float
    floor_m: float
    closed_form_m: float
    peak_m: float
    limit: str


def read_range(setting: Setting, tag: PlacedTag) -> ReadRange | None:
    """Return the read range of a tag that hangs as high as here, without any room [m].

    At the first frequency. None where the transmitter stands in the room, so that there is no one
    distance.

    Parameters
    ----------
    setting, tag : The reader; one of its tags that is not active.
    """
    rfid = rfid_table(setting.study)
    if rfid.transmitter == "separate" and rfid.transmitter_position_m is not None:
        return None
    link = setting.woken_open_link(tag)
    link = replace(link, ways=link.ways[:1], separate=link.separate[:1])
    response, antenna = setting.responses[0], tag.antennas[0]
    separate = [single_response(one) for one in transmitters(rfid, [antenna.frequency_hz])]
    budget = _Friis(
        link=link,
        antenna=antenna,
        response=response,
        sender=separate[0] if separate else response,
        sender_up_m=rfid.transmitter_height_m if separate else 0.0,
    )
    peak_m = budget.peak_m()
    sides = 1 if alike_from_all_sides(study_tag(setting.study, tag)) else SIDES
    best = _farthest(budget, 1.001 * (peak_m + budget.sender_up_m), sides)
    if best is None:
        return ReadRange(slant_m=0.0, floor_m=0.0, closed_form_m=0.0, peak_m=peak_m, limit=WAKING)
    floor_m, side, azimuth = best
    slant_m = math.hypot(floor_m, budget.up_m)
    closed_m, limit = budget.closed_form(slant_m, side, azimuth)
    return ReadRange(
        slant_m=slant_m, floor_m=floor_m, closed_form_m=closed_m, peak_m=peak_m, limit=limit
    )


def _farthest(budget: "_Friis", most_m: float, count: int) -> tuple[float, float, float] | None:
    """Return distance along the floor [m], side and azimuth [rad] at which the tag is read last.

    Of sides that are equal to a `DISTANCES`-th of ``most_m`` the first is taken. None: nowhere.
    """
    if most_m <= abs(budget.up_m):
        return None
    azimuths = 2.0 * math.pi * np.arange(HEADINGS) / HEADINGS

    def reads(floors_m: FloatArray, side_rad: float) -> npt.NDArray[np.bool_]:
        places = floors_m[:, None] * np.array([math.cos(side_rad), math.sin(side_rad)])
        headings = side_rad + 1.5 * math.pi - azimuths
        read = budget.link.answers_by_heading(places, headings).read
        return np.asarray(read.any(axis=-1))

    floors_m = np.linspace(0.0, math.sqrt(most_m**2 - budget.up_m**2), DISTANCES)
    sides = (2.0 * math.pi * np.arange(count) / count).tolist()
    rows = np.arange(DISTANCES)
    last = [int(np.where(reads(floors_m, s).any(axis=1), rows, -1).max()) for s in sides]
    farthest = int(np.argmax(last))
    if last[farthest] < 0:
        return None
    side = sides[farthest]
    low, high = floors_m[last[farthest]], floors_m[min(last[farthest] + 1, DISTANCES - 1)]
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if reads(np.array([middle]), side).any() else (low, middle)
    azimuth = azimuths[int(np.argmax(reads(np.array([low]), side)[0]))]
    return float(low), side, float(azimuth)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Friis:
    """The link budget of two antennas in the open, without the path solver."""

    link: BackscatterLink
    antenna: Antenna  # of the tag
    response: ReaderResponse
    sender: ReaderResponse  # the reader's own antennas, or the separate one
    sender_up_m: float  # height of the sending antenna above the reader's centre

    @property
    def up_m(self) -> float:
        """Return the tag's height above the reader's centre [m]."""
        return float(self.link.tag_position_m[2]) - self.link.reader_z_m

    def peak_m(self) -> float:
        """Return the range with the greatest gains of all antennas [m]."""
        budget, at_tag = self.link.budget, peak_gain(antenna_pattern(self.antenna))
        sent = budget.sent_w * peak_gain(self.sender.pattern) * at_tag
        forward = sent * budget.forward / budget.wakes_w
        backward = sent * budget.backward * peak_gain(self.response.pattern) * at_tag
        returns: float = (backward / budget.decodes_w) ** 0.25
        return self._step_m * min(math.sqrt(forward), returns)

    def closed_form(self, start_m: float, side_rad: float, azimuth_rad: float) -> tuple[float, str]:
        """Return the distance [m] at which power and distance agree, and what limits it."""
        slant_m, limit = start_m, WAKING
        for _ in range(ITERATIONS):
            reach, limit = self._reach(slant_m, side_rad, azimuth_rad)
            slant_m = max(slant_m * math.sqrt(reach), abs(self.up_m))
        return slant_m, limit

    @property
    def _step_m(self) -> float:
        return self.antenna.wavelength_m / (4.0 * math.pi)

    def _reach(self, slant_m: float, side_rad: float, azimuth_rad: float) -> tuple[float, str]:
        """Return by which factor the tag could be farther, were the gains the same, and the limit.

        Friis' equation with the vector fields of both antennas towards each other: P = P' (λ/4πr)²
        |F_θ F'_θ - F_φ F'_φ|², for φ^ is reversed from one end to the other.
        """
        budget = self.link.budget
        floor_m = math.sqrt(max(slant_m**2 - self.up_m**2, 0.0))

        def gains(response: ReaderResponse, up_m: float) -> FloatArray:
            theta = math.atan2(floor_m, up_m)
            ours = response.far_field(theta, azimuth_rad)
            tags = self.antenna.far_field(math.pi - theta, side_rad)
            coupling = np.abs(ours[:, 0] * tags[0] - ours[:, 1] * tags[1]) ** 2
            return np.asarray((self._step_m / math.hypot(floor_m, up_m)) ** 2 * coupling)

        back = gains(self.response, self.up_m)
        there = back
        if self.link.sender == "separate":
            there = np.broadcast_to(gains(self.sender, self.up_m - self.sender_up_m), back.shape)
        elif self.link.sender == "strongest":
            there = np.full_like(back, back.max())
        wakes = np.sqrt(budget.sent_w * budget.forward * there / budget.wakes_w)
        decodes = (budget.sent_w * budget.backward * there * back / budget.decodes_w) ** 0.25
        best = int(np.argmax(np.minimum(wakes, decodes)))
        limit = WAKING if wakes[best] <= decodes[best] else DECODING
        return float(min(wakes[best], decodes[best])), limit
