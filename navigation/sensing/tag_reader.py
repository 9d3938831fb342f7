"""What a robot's reader measures of many tags at once: their RSS, or their ranges and bearings."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.navigation.angles import wrap_angle
from octant.navigation.robot.motion import Motion
from octant.navigation.sensing.bearing import FRONT_AZIMUTH_RAD, vector_sum_bearing
from octant.navigation.sensing.rss_models import LogDistanceLaw
from octant.navigation.sensing.sensor import RssSensor

MOST_DECADES = 3.0
"""Ranges from 1 mm to 1 km are inverted from a law; a flat one would give any."""
FloatArray = npt.NDArray[np.float64]


class BoardReader(Protocol):
    """What reads on board of a set of robots, each with its own random numbers."""

    def read(
        self, poses: FloatArray, twists: FloatArray, rngs: Sequence[np.random.Generator]
    ) -> FloatArray:
        """Return the readings of every run, (r, m); NaN where nothing is received.

        Parameters
        ----------
        poses : (r, 3) float64 — True x [m], y [m], heading [rad] when the reading ends.
        twists : (r, 2) float64 — Forward speed [m/s] and turn rate [rad/s] until then.
        rngs : One for each run.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class TagReader:
    """The RSS of all tags by a designed reader: the powers of its antennas added up.

    One number for each tag is what controllers and filters of chapters 6 and 7 take. The sum over a
    ring of antennas hardly depends on the heading (0.2 dB for eight dipoles), and fades less than
    one antenna, since the antennas stand apart.

    Parameters
    ----------
    sensor : The reader with its errors.
    low_m, high_m : (2,) float64 — Rectangle in which it reads [m]; a robot that has left it reads
        what it would at its rim.
    """

    sensor: RssSensor
    low_m: FloatArray
    high_m: FloatArray

    def powers_w(
        self, poses: FloatArray, twists: FloatArray, rngs: Sequence[np.random.Generator]
    ) -> FloatArray:
        """Return the power at every antenna of every tag in every run, (r, s, n) [W].

        Parameters
        ----------
        poses, twists, rngs : As for `BoardReader.read` [m], [rad], [m/s], [rad/s].
        """
        inside = np.array(poses)
        inside[:, :2] = np.clip(inside[:, :2], self.low_m, self.high_m)
        return np.array(
            [
                [
                    self.sensor.read(
                        pose,
                        tag,
                        rng,
                        motion=Motion(speed_m_per_s=twist[0], turn_rate_rad_per_s=twist[1]),
                    )
                    for tag in self.sensor.tag_ids
                ]
                for pose, twist, rng in zip(inside, twists.tolist(), rngs, strict=True)
            ]
        )

    def read(
        self, poses: FloatArray, twists: FloatArray, rngs: Sequence[np.random.Generator]
    ) -> FloatArray:
        """Return the RSS of all tags, (r, s) [dBm]; NaN where no antenna receives a tag."""
        return summed_dbm(self.powers_w(poses, twists, rngs))


def summed_dbm(powers_w: FloatArray) -> FloatArray:
    """Return powers added up over the last axis [dBm]; NaN where that is zero.

    Parameters
    ----------
    powers_w : (..., n) float64 — Powers of the antennas [W].
    """
    total = powers_w.sum(axis=-1)
    return np.where(total > 0.0, power_dbm(np.where(total > 0.0, total, 1.0)), np.nan)


@dataclass(frozen=True, slots=True, kw_only=True)
class RangeBearingReader(TagReader):
    """The same reader's range and bearing of every tag, as EKF SLAM takes them (7.47).

    Parameters
    ----------
    sensor, low_m, high_m : As of `TagReader` [m].
    law : RSS, summed over the antennas, against distance; the range is its inverse.
    height_m : How high the tags hang above the antennas [m].
    """

    law: LogDistanceLaw
    height_m: float

    def read(
        self, poses: FloatArray, twists: FloatArray, rngs: Sequence[np.random.Generator]
    ) -> FloatArray:
        """Return range [m] and bearing [rad] of every tag in turn, (r, 2 s); NaN: not received."""
        powers = self.powers_w(poses, twists, rngs)
        return self.measured(powers, self.sensor.azimuths_rad).reshape(len(poses), -1)

    def measured(self, powers_w: FloatArray, azimuths_rad: FloatArray) -> FloatArray:
        """Return the horizontal range [m] and the bearing from the front [rad], (..., 2).

        Parameters
        ----------
        powers_w : (..., n) float64 — Powers of the antennas [W].
        azimuths_rad : (n,) float64 — Their azimuths in the reader's frame [rad].
        """
        level = summed_dbm(powers_w)
        decades = (self.law.rss_1m_dbm - level) / (10.0 * self.law.exponent)
        distance = 10.0 ** np.clip(decades, -MOST_DECADES, MOST_DECADES)
        along = np.sqrt(np.maximum(distance**2 - self.height_m**2, 0.0))
        bearing = wrap_angle(vector_sum_bearing(powers_w, azimuths_rad) - FRONT_AZIMUTH_RAD)
        return np.stack([along, np.where(np.isnan(level), np.nan, bearing)], axis=-1)
