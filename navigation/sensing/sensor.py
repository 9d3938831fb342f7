"""What the robot reads: the RSS of every antenna for the tag it asks for, with the device's errors.

To the field of a `PowerLink` the sensor adds the way driven between the antennas' readings, the
receiver's errors (`rss_detector`) and what is lost.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.geometries.names import nearest_name
from octant.navigation.robot.motion import AT_REST, Motion
from octant.navigation.sensing.bearing import checked_azimuths
from octant.navigation.sensing.device import Device
from octant.navigation.sensing.inventory import ReadRates
from octant.navigation.sensing.rss_detector import RssQuantiser, ThermalNoise


class PowerLink(Protocol):
    """The power that one tag delivers to the reader's antennas, free of noise."""

    def rss_w(self, poses: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Return the received power of each antenna, (m, n) [W]; zero where nothing arrives.

        Parameters
        ----------
        poses : (m, 3) float64 — x [m], y [m], heading [rad] of the robot in the room.
        """
        ...


class AnsweringLink(PowerLink, Protocol):
    """The same of a tag that answers only where the reader wakes it."""

    def reads(self, poses: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        """Return at which poses the tag answers which antenna, (m, n).

        Parameters
        ----------
        poses : (m, 3) float64 — x [m], y [m], heading [rad] of the robot in the room.
        """
        ...


class RssSensor(Protocol):
    """What a navigator may know of the world: the reader's RSS for a named tag."""

    @property
    def antennas(self) -> int:
        """Return the number n of antennas."""
        ...

    @property
    def azimuths_rad(self) -> npt.NDArray[np.float64]:
        """Return the (n,) azimuths of the antennas in the reader frame [rad]."""
        ...

    @property
    def tag_ids(self) -> tuple[str, ...]:
        """Return the tags that can be asked for."""
        ...

    def read(
        self,
        pose: npt.NDArray[np.float64],
        tag_id: str,
        rng: np.random.Generator,
        *,
        motion: Motion = AT_REST,
    ) -> npt.NDArray[np.float64]:
        """Return one reading of all antennas, (n,) [W]; zero where nothing is received.

        Parameters
        ----------
        pose : (3,) float64 — x [m], y [m], heading [rad] in the room, when the reading ends.
        tag_id : Which tag to ask for.
        rng : Source of the reading's random errors.
        motion : How the robot has driven since its last reading, on whose way antennas are read one
            after another. By default, and for the next tag after an arrival, it has stood still.
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldSensor:
    """A sensor that reads the radio model's field as a device does.

    Errors come in the order of the device: thermal noise, log-normal error, sensitivity, codes,
    then what is lost. In turn, antenna i is read (n - 1 - i) dwell times before the given pose.
    Every reading draws the log-normal errors from the generator itself and everything else from a
    child of its own, so that sensors that differ in one of these settings err alike in all others.

    Parameters
    ----------
    links : One link for each tag that the robot may ask for.
    azimuths_rad : (n,) float64 — Azimuths of the reader's antennas in the reader frame [rad].
    noise_db : Standard deviation of the log-normal error of each antenna [dB].
    sensitivity_w : RSS below this is not received and reads zero [W].
    quantiser, thermal : The detector's codes; the receiver's own noise; None for none.
    dwell_s : Time from one antenna's reading to the next one's [s]; zero reads all at once.
    drop_out_probability : Probability that an antenna's reading is lost and reads zero [-].
    read_probability : Probability that a tag within reach answers; otherwise all read zero [-].
    crowd, rates : Links of all tags whose answers collide, and how probably one of so many is read
        in the dwell time [-]; None: none collide.
    """

    links: Mapping[str, PowerLink]
    azimuths_rad: npt.NDArray[np.float64]
    noise_db: float = 0.0
    sensitivity_w: float = 0.0
    quantiser: RssQuantiser | None = None
    dwell_s: float = 0.0
    thermal: ThermalNoise | None = None
    drop_out_probability: float = 0.0
    read_probability: float = 1.0
    crowd: Mapping[str, AnsweringLink] = field(default_factory=dict)
    rates: ReadRates | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "links", dict(self.links))
        object.__setattr__(self, "crowd", dict(self.crowd))
        object.__setattr__(self, "azimuths_rad", checked_azimuths(self.azimuths_rad, least=1))
        if not self.links:
            msg = "the sensor has no link to any tag; give at least one."
            raise NavigationError(msg)
        for name, unit in (("noise_db", "dB"), ("sensitivity_w", "W"), ("dwell_s", "s")):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                msg = f"{name} is {value} {unit}, but it must be finite and not negative: raise it."
                raise NavigationError(msg)
        for name in ("drop_out_probability", "read_probability"):
            value = getattr(self, name)
            if not 0.0 <= value <= 1.0:
                msg = f"{name} is {value}, but a probability lies between 0 and 1: change it."
                raise NavigationError(msg)

    @property
    def antennas(self) -> int:
        """Return the number n of antennas."""
        return int(self.azimuths_rad.size)

    @property
    def tag_ids(self) -> tuple[str, ...]:
        """Return the tags that can be asked for."""
        return tuple(self.links)

    def read(
        self,
        pose: npt.NDArray[np.float64],
        tag_id: str,
        rng: np.random.Generator,
        *,
        motion: Motion = AT_REST,
    ) -> npt.NDArray[np.float64]:
        """Return one reading of all antennas with the device's errors, (n,) [W].

        Parameters
        ----------
        pose, tag_id, rng, motion : As for `RssSensor.read` [m], [rad].
        """
        poses = self._poses(np.asarray(pose, dtype=np.float64), motion)
        rss = self._field_w(poses, tag_id)
        # The thermal noise draws last: how many numbers its gamma variables take is not fixed.
        own = rng.spawn(1)[0]
        answers = float(own.random()) < self.read_probability
        arrives = own.random(rss.shape) >= self.drop_out_probability
        if self.rates is not None and tag_id in self.crowd:
            others = [link for other, link in self.crowd.items() if other != tag_id]
            awake = (rss > 0.0) + sum(self._each(link.reads(poses)) for link in others)
            arrives &= own.random(rss.shape) < self.rates.of(awake)
        device = Device(
            noise_db=self.noise_db,
            sensitivity_w=self.sensitivity_w,
            quantiser=self.quantiser,
            thermal=self.thermal,
        )
        return np.where(arrives & answers, device.measured(rss, rng, own), 0.0)

    def _poses(self, pose: npt.NDArray[np.float64], motion: Motion) -> npt.NDArray[np.float64]:
        """Return the poses at which the antennas are read [m], [rad]: one, or one for each."""
        one_pose = self.dwell_s == 0.0 or motion.rests
        times_s = np.zeros(1) if one_pose else self.dwell_s * np.arange(1 - self.antennas, 1)
        return motion.poses(pose, times_s)

    def _field_w(self, poses: npt.NDArray[np.float64], tag_id: str) -> npt.NDArray[np.float64]:
        """Return the (n,) powers at the places where the antennas are read [W]."""
        if tag_id not in self.links:
            raise unknown_tag(tag_id, self.tag_ids)
        rss = self.links[tag_id].rss_w(poses)
        if rss.shape[1] != self.antennas:
            msg = (
                f"the link of tag {tag_id!r} gives {rss.shape[1]} RSS values, but the reader has "
                f"{self.antennas} antennas: build both from one reader."
            )
            raise NavigationError(msg)
        return self._each(rss)

    def _each(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return each antenna's value (n,) at the pose where it is read, of (1 or n, n)."""
        return values[0] if len(values) == 1 else values.diagonal()


def unknown_tag(tag_id: str, known: tuple[str, ...]) -> NavigationError:
    """Return the error for an unknown tag, naming the nearest known one.

    Parameters
    ----------
    tag_id : The tag asked for.
    known : The tags there are.
    """
    near = nearest_name(tag_id, known)
    return NavigationError(
        f"tag {tag_id!r} is unknown, the tags are {list(known)}: did you mean {near!r}?"
        if near
        else f"tag {tag_id!r} is unknown and there are no tags: add it."
    )
