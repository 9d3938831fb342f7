"""What the robot reads: the RSS of every antenna for the tag it asks for, with the device's errors.

The field comes from a `PowerLink` (the radio model's link between one tag and the reader); this
module adds multiplicative noise, a sensitivity limit and the quantisation of an RSS detector.
"""

import difflib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.bearing import checked_azimuths


class PowerLink(Protocol):
    """The power that one tag delivers to the reader's antennas, free of noise."""

    def rss_w(self, poses: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Return the received power of each antenna [W].

        Parameters
        ----------
        poses : (m, 3) float64
            x [m], y [m], heading [rad] of the robot in the room.

        Returns
        -------
        (m, n) float64
            Received power, zero where nothing arrives [W].
        """
        ...


class Sensor(Protocol):
    """What a navigator may know of the world: the reader's RSS for a named tag."""

    @property
    def antennas(self) -> int:
        """Return the number n of antennas [-]."""
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
        self, pose: npt.NDArray[np.float64], tag_id: str, rng: np.random.Generator
    ) -> npt.NDArray[np.float64]:
        """Return one reading of all antennas [W].

        Parameters
        ----------
        pose : (3,) float64
            x [m], y [m], heading [rad] of the robot in the room.
        tag_id : str
            Which tag to ask for.
        rng : numpy.random.Generator
            Source of the reading's random errors.

        Returns
        -------
        (n,) float64
            RSS, zero where nothing is received [W].
        """
        ...


def log_normal_rss(
    rss_w: npt.ArrayLike, noise_db: float, rng: np.random.Generator
) -> npt.NDArray[np.float64]:
    """Return RSS with an independent log-normal factor on every value [W].

    Parameters
    ----------
    rss_w : (...) float64
        RSS free of noise [W].
    noise_db : float
        Standard deviation of the factor in decibels [dB], zero for none.
    rng : numpy.random.Generator
        Source of the noise; nothing is drawn when `noise_db` is zero.

    Returns
    -------
    (...) float64
        RSS times 10^(N(0, noise_db)/10) [W].

    Notes
    -----
    The thesis writes additive noise, z = z^d Γ(δ) + ζ (5.2.2.1), without its size; errors of RSS
    detectors are specified in decibels, hence the factor. Its median is one; its mean is not
    (+0.1 dB for 1 dB, +1 dB for 3 dB).
    """
    rss = np.asarray(rss_w, dtype=np.float64)
    if noise_db == 0.0:
        return rss.copy()
    noisy: npt.NDArray[np.float64] = rss * 10.0 ** (rng.normal(0.0, noise_db, rss.shape) / 10.0)
    return noisy


@dataclass(frozen=True, slots=True, kw_only=True)
class RssQuantiser:
    """Return an RSS detector with evenly spaced codes in decibels.

    Parameters
    ----------
    bits : int
        Length of the code [bit], 1 to 16.
    floor_dbm : float
        Power of the lowest code [dBm]; more than half a step below it nothing is received.
    full_scale_dbm : float
        Power of the highest code [dBm]; what is stronger reads as this.

    Raises
    ------
    NavigationError
        When the code length or the range is not allowed.

    Notes
    -----
    The thesis fixes 8 bits for its tags (4.6.1) but neither range nor law; a logarithmic law is
    what RSSI detectors have. -100 to 0 dBm on 8 bits makes steps of 0.39 dB.
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
        """Return RSS as the detector reports it [W].

        Parameters
        ----------
        rss_w : (...) float64
            Received power, not negative [W].

        Returns
        -------
        (...) float64
            The nearest code's power, zero below the lowest code [W].
        """
        rss = np.asarray(rss_w, dtype=np.float64)
        level_dbm = 10.0 * np.log10(np.maximum(rss, np.finfo(np.float64).tiny)) + 30.0
        code = np.rint((level_dbm - self.floor_dbm) / self.step_db)
        power_dbm = self.floor_dbm + self.step_db * np.minimum(code, 2**self.bits - 1)
        return np.where(code < 0.0, 0.0, 10.0 ** ((power_dbm - 30.0) / 10.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldSensor:
    """Return a sensor that reads the radio model's field.

    Parameters
    ----------
    links : mapping of str to PowerLink
        One link for each tag that the robot may ask for.
    azimuths_rad : (n,) float64
        Azimuths of the reader's antennas in the reader frame [rad].
    noise_db : float
        Standard deviation of the log-normal error of each antenna [dB].
    sensitivity_w : float
        RSS below this is not received and reads zero [W].
    quantiser : RssQuantiser or None
        The detector's codes; None for none.

    Raises
    ------
    NavigationError
        When there is no link, the antennas are too few, or a number is negative or not finite.

    Notes
    -----
    All antennas are read at one pose: the multiplexer's delay is not modelled.
    """

    links: Mapping[str, PowerLink]
    azimuths_rad: npt.NDArray[np.float64]
    noise_db: float = 0.0
    sensitivity_w: float = 0.0
    quantiser: RssQuantiser | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "links", dict(self.links))
        object.__setattr__(self, "azimuths_rad", checked_azimuths(self.azimuths_rad))
        if not self.links:
            msg = "the sensor has no link to any tag; give at least one."
            raise NavigationError(msg)
        for name, unit in (("noise_db", "dB"), ("sensitivity_w", "W")):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                msg = f"{name} is {value} {unit}, but it must be finite and not negative: raise it."
                raise NavigationError(msg)

    @property
    def antennas(self) -> int:
        """Return the number n of antennas [-]."""
        return int(self.azimuths_rad.size)

    @property
    def tag_ids(self) -> tuple[str, ...]:
        """Return the tags that can be asked for."""
        return tuple(self.links)

    def read(
        self, pose: npt.NDArray[np.float64], tag_id: str, rng: np.random.Generator
    ) -> npt.NDArray[np.float64]:
        """Return one noisy reading of all antennas [W].

        Parameters
        ----------
        pose : (3,) float64
            x [m], y [m], heading [rad] of the robot in the room.
        tag_id : str
            Which tag to ask for.
        rng : numpy.random.Generator
            Source of the noise.

        Returns
        -------
        (n,) float64
            RSS, zero where nothing is received [W].

        Raises
        ------
        NavigationError
            When the sensor has no link to that tag, or the link has another number of antennas.
        """
        if tag_id not in self.links:
            raise unknown_tag(tag_id, self.tag_ids)
        clean = self.links[tag_id].rss_w(np.asarray(pose, dtype=np.float64).reshape(1, 3))[0]
        if clean.shape != self.azimuths_rad.shape:
            msg = (
                f"the link of tag {tag_id!r} gives {clean.size} RSS values, but the reader has "
                f"{self.antennas} antennas: build both from one reader."
            )
            raise NavigationError(msg)
        rss = log_normal_rss(clean, self.noise_db, rng)
        rss = np.where(rss < self.sensitivity_w, 0.0, rss)
        return rss if self.quantiser is None else self.quantiser.quantise(rss)


def unknown_tag(tag_id: str, known: tuple[str, ...]) -> NavigationError:
    """Return the error for a tag that nobody knows, naming the nearest one.

    Parameters
    ----------
    tag_id : str
        The tag asked for.
    known : tuple of str
        The tags there are.

    Returns
    -------
    NavigationError
        To be raised by the caller.
    """
    near = difflib.get_close_matches(tag_id, known, n=1, cutoff=0.0)
    return NavigationError(
        f"tag {tag_id!r} is unknown, the tags are {list(known)}: did you mean {near[0]!r}?"
        if near
        else f"tag {tag_id!r} is unknown and there are no tags: add it."
    )
