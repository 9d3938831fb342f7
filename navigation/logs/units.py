"""Units of logs: times, lengths, angles and levels, and what betrays a wrong one."""

from typing import Literal

import numpy as np
import numpy.typing as npt

TimeUnit = Literal["s", "ms", "us", "ns", "iso"]
"""Units of time; ``iso`` are dates and times after ISO 8601."""

LengthUnit = Literal["m", "cm", "mm", "ft", "in"]
"""Units of length."""

AngleUnit = Literal["deg", "rad", "turn"]
"""Units of angle."""

LevelUnit = Literal["dbm", "minus_dbm", "w", "mw", "uw", "nw"]
"""Units of received power; ``minus_dbm`` are levels written without their sign."""

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
"""Seconds in a unit of time [s]."""

METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "ft": 0.3048, "in": 0.0254}
"""Metres in a unit of length [m]."""

WATTS = {"w": 1.0, "mw": 1e-3, "uw": 1e-6, "nw": 1e-9}
"""Watts in a unit of power [W]."""

HIGHEST_DBM = 60.0
LOWEST_DBM = -250.0
"""Levels outside which nothing is a reading [dBm]: 1 kW received, and far below any noise."""

_MOST = 0.9
_PLAUSIBLE_DBM = (-115.0, -5.0)


def radians(angles: npt.ArrayLike, unit: AngleUnit) -> npt.NDArray[np.float64]:
    """Return angles in radians [rad].

    Parameters
    ----------
    angles : (...) float64 — Angles [unit].
    unit : Their unit.
    """
    given = np.asarray(angles, dtype=np.float64)
    if unit == "rad":
        return given
    return np.radians(given) if unit == "deg" else given * (2.0 * np.pi)


def exact_degrees(angles_rad: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return angles in degrees that `radians` turns back into the same bits, where there are any.

    Every angle that was read from degrees has some; of others a few have none, and come back with
    another last bit.

    Parameters
    ----------
    angles_rad : (n,) float64 — Angles [rad].
    """
    given = np.asarray(angles_rad, dtype=np.float64)
    nearest = np.degrees(given)
    found = nearest.copy()
    open_ = np.isfinite(given) & (np.radians(found) != given)
    above = below = nearest
    for _ in range(2):
        above, below = np.nextafter(above, np.inf), np.nextafter(below, -np.inf)
        for tried in (above, below):
            hit = open_ & (np.radians(tried) == given)
            found[hit] = tried[hit]
            open_ &= ~hit
    return found


def levels_dbm(values: npt.ArrayLike, unit: LevelUnit) -> npt.NDArray[np.float64]:
    """Return received powers as levels [dBm]; -inf for a power of zero, NaN stays.

    Parameters
    ----------
    values : (...) float64 — Powers or levels [unit].
    unit : Their unit.
    """
    given = np.asarray(values, dtype=np.float64)
    if unit == "dbm":
        return given
    if unit == "minus_dbm":
        return -given
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(10.0 * np.log10(given * (WATTS[unit] * 1e3)))


def suspected_unit(values: npt.ArrayLike, unit: LevelUnit) -> str | None:
    """Return one sentence on why levels cannot be in the unit named; None where they can.

    Parameters
    ----------
    values : (n,) float64 — Levels or powers as the file has them [unit]; not finite ones count not.
    unit : The unit that is said to be theirs.
    """
    given = np.asarray(values, dtype=np.float64)
    given = given[np.isfinite(given)]
    if given.size == 0:
        return None
    if unit in WATTS:
        negative = np.mean(given < 0.0) > 0.5
        dbm = f'are mostly negative, as levels in dBm are; set log.rss_unit = "dbm", not {unit!r}'
        return dbm if negative else None
    return _suspected_of_levels(given if unit == "dbm" else -given)


def _suspected_of_levels(given: npt.NDArray[np.float64]) -> str | None:
    constant = given.max()
    share = float(np.mean(given == constant))
    if constant > 0.0 and share >= 0.05 and np.any(given < 0.0):
        return (
            f"are {constant:g} in {100.0 * share:.0f} % of all cells and negative elsewhere, as "
            f"where that number means 'not heard'; set log.not_heard = [{constant:g}]"
        )
    if np.mean((given >= 0.0) & (given < 1.0)) >= _MOST and np.any(given > 0.0):
        median = float(np.median(given[given > 0.0]))
        tried: tuple[LevelUnit, ...] = ("mw", "w", "uw", "nw")
        likely = next((unit for unit in tried if _plausible(median, unit)), tried[0])
        return (
            f"lie between {given.min():.3g} and {given.max():.3g}, as powers do and levels in dBm "
            f'do not; set log.rss_unit = "{likely}", which makes {median:.3g} a level of '
            f"{float(levels_dbm(median, likely)):.0f} dBm"
        )
    if np.mean((given >= 15.0) & (given <= 130.0)) >= _MOST and given.min() >= 0.0:
        return (
            f"lie between {given.min():.3g} and {given.max():.3g}, as levels without their sign "
            'do; set log.rss_unit = "minus_dbm"'
        )
    return None


def _plausible(value: float, unit: LevelUnit) -> bool:
    return bool(_PLAUSIBLE_DBM[0] <= float(levels_dbm(value, unit)) <= _PLAUSIBLE_DBM[1])
