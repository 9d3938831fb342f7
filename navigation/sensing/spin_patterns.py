"""Patterns of the antennas as the robot itself can measure them: by turning on the spot.

A table of gains over the bearing of a tag, by antenna, from readings of whatever level: only their
differences count. How gains depend on the elevation of the tag no turn on a floor can say.
"""

import math

import numpy as np
import numpy.typing as npt

from octant.em.decibels import decibels
from octant.geometries.errors import NavigationError
from octant.navigation.checks import check_positive
from octant.navigation.sensing.pattern_match import PowerTable

FloatArray = npt.NDArray[np.float64]

BEARINGS = 72
"""Bearings of a table [-]: every 5 degrees."""
HARMONICS = 4
"""Highest harmonic over the bearing that is fitted to readings [-]."""
_WIDEST_GAP_RAD = math.radians(75.0)
_DISTANCES = 61
_LOWEST_DB = -40.0


def spin_gains_db(
    bearings_rad: npt.ArrayLike,
    rss_dbm: npt.ArrayLike,
    *,
    antennas: npt.ArrayLike,
    stands: npt.ArrayLike,
    count: int,
) -> FloatArray:
    """Return the gain of each antenna over the bearing, (b, n) [dB], 0 dB in the mean over all.

    Least squares of level = pattern of the antenna + level of the stand, where a stand is one place
    of the robot with one tag: a Fourier series in the bearing for each antenna, and one number for
    each stand. Bearings are those of `BEARINGS`, from the robot's front.

    Parameters
    ----------
    bearings_rad : (k,) float64 — Bearing of the tag from the robot's front [rad].
    rss_dbm : (k,) float64 — Levels that were heard [dBm].
    antennas, stands : (k,) int64 — Antenna, from 0, and stand of each reading [-].
    count : Number n of antennas [-].

    Raises
    ------
    NavigationError
        An antenna was not heard all around: a gap of more than 75 degrees is left.
    """
    bearing, level = (np.asarray(v, dtype=np.float64) for v in (bearings_rad, rss_dbm))
    antenna, stand = (np.asarray(v, dtype=np.int64) for v in (antennas, stands))
    order = HARMONICS
    for number in range(count):
        seen = np.sort(np.mod(bearing[antenna == number], 2.0 * np.pi))
        gap = 2.0 * np.pi
        if len(seen) > 1:
            gap = float(np.diff(np.append(seen, seen[0] + 2.0 * np.pi)).max())
        if gap > _WIDEST_GAP_RAD:
            msg = (
                f"antenna {number + 1} was heard over the bearings with a gap of "
                f"{math.degrees(gap):.0f} deg, but a pattern needs a turn on the spot all around; "
                "turn farther, or give the patterns as a file."
            )
            raise NavigationError(msg)
        order = min(order, int(np.pi / max(gap, 1e-6)), (len(np.unique(seen)) - 1) // 2)
    waves = _waves(bearing, max(order, 1))
    size, kinds = waves.shape[1], np.unique(stand)
    design = np.zeros((len(bearing), count * size + len(kinds)))
    for number in range(count):
        rows = antenna == number
        design[rows, number * size : (number + 1) * size] = waves[rows]
    design[np.arange(len(bearing)), count * size + np.searchsorted(kinds, stand)] = 1.0
    found = np.linalg.lstsq(design, level, rcond=None)[0][: count * size].reshape(count, size)
    gains = _waves(2.0 * np.pi * np.arange(BEARINGS) / BEARINGS, max(order, 1)) @ found.T
    return np.asarray(gains - gains.mean())


def gain_table(gains_db: npt.ArrayLike, *, height_m: float, reach_m: float) -> PowerTable:
    """Return the RSS of antennas for relative places of a tag, by gains over the bearing [W].

    Distance counts as in free space to a tag at a height; gains are those of the bearing whatever
    the elevation, and the level is arbitrary: estimators must take it as unknown.

    Parameters
    ----------
    gains_db : (b, n) float64 — Gain over evenly spaced bearings from the front [dB].
    height_m : Height of the tag over the antennas, at least 0.1 m counts [m].
    reach_m : Largest distance along the floor [m].
    """
    check_positive(reach_m, name="reach_m", unit="m")
    gains = np.asarray(gains_db, dtype=np.float64)
    rho = reach_m * (np.arange(_DISTANCES) / (_DISTANCES - 1.0)) ** 2
    law_db = -decibels(rho**2 + max(abs(height_m), 0.1) ** 2)
    level = law_db[:, None, None] + np.maximum(gains, gains.max() + _LOWEST_DB)[None]
    return PowerTable(reach_m=reach_m, power_w=10.0 ** (level[:, :, None, :] / 10.0 - 6.0))


def _waves(bearing_rad: FloatArray, order: int) -> FloatArray:
    angles = bearing_rad[:, None] * np.arange(1, order + 1)
    return np.hstack([np.ones((len(bearing_rad), 1)), np.cos(angles), np.sin(angles)])
