"""How a foreign file says what a log says: columns, units, and what 'not heard' looks like."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.logs.units import (
    METRES,
    AngleUnit,
    LengthUnit,
    LevelUnit,
    TimeUnit,
    radians,
)

FloatArray = npt.NDArray[np.float64]

Empty = Literal["not_heard", "no_reading"]
"""What an empty cell of a level says."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Columns:
    """Names of a file's columns, or of a message's fields; None: it has none.

    Parameters
    ----------
    time, x, y, heading : When and where the robot was.
    qx, qy, qz, qw : Its orientation as a quaternion, in place of ``heading``; qx and qy may lack.
    distance, turn : Odometry since the row before.
    id, antenna : Source, and the robot's antenna.
    rss : Level. With ``{id}`` in it, and ``{antenna}`` if need be, it is a pattern of the names of
        many columns, one a source: ``rssi_{id}``; ``{id}`` alone means every column that has no
        other name here.
    frequency : Carrier frequency [Hz].
    """

    time: str | None = None
    x: str | None = None
    y: str | None = None
    heading: str | None = None
    qx: str | None = None
    qy: str | None = None
    qz: str | None = None
    qw: str | None = None
    distance: str | None = None
    turn: str | None = None
    id: str | None = None
    antenna: str | None = None
    rss: str | None = None
    frequency: str | None = None

    @property
    def wide(self) -> bool:
        """Return whether there is one column a source."""
        return self.rss is not None and "{id}" in self.rss

    def named(self) -> frozenset[str]:
        """Return the names that are given, the pattern of a wide table left out."""
        names = (getattr(self, name) for name in self.__dataclass_fields__)
        return frozenset(name for name in names if name and "{id}" not in name)


@dataclass(frozen=True, slots=True, kw_only=True)
class TableForm:
    """Everything that a reader of foreign tables must be told.

    Parameters
    ----------
    columns : Their names.
    time_unit, length_unit, angle_unit, rss_unit : Units of times, places, angles and levels.
    heading_zero_deg : Direction of heading 0, counter-clockwise from the file's +x [deg].
    clockwise : Whether headings and turns grow clockwise, as those of a compass do.
    not_heard : Numbers that stand for a source that was not heard, in the file's unit: 100 often.
    empty : Whether an empty cell of a level says ``not_heard``, or that there was ``no_reading``.
    ids : Name in the log by name in the file; others keep theirs.
    only : Sources that are read, by their names in the log; None: all.
    separator, header : As of `read_text_table`.
    threshold_dbm : Level below which the receiver hears nothing [dBm]; None: unknown.
    """

    columns: Columns
    time_unit: TimeUnit = "s"
    length_unit: LengthUnit = "m"
    angle_unit: AngleUnit = "deg"
    rss_unit: LevelUnit = "dbm"
    heading_zero_deg: float = 0.0
    clockwise: bool = False
    not_heard: tuple[float, ...] = ()
    empty: Empty = "not_heard"
    ids: Mapping[str, str] = field(default_factory=dict)
    only: frozenset[str] | None = None
    separator: str | None = None
    header: bool = True
    threshold_dbm: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "ids", dict(self.ids))
        twice = [name for name in self.ids.values() if list(self.ids.values()).count(name) > 1]
        if twice:
            msg = f"ids gives the name {twice[0]!r} to two sources; name each by itself."
            raise NavigationError(msg)

    @property
    def metres(self) -> float:
        """Return the length of the file's unit [m]."""
        return METRES[self.length_unit]

    def headings_rad(self, headings: FloatArray) -> FloatArray:
        """Return headings counter-clockwise from +x [rad].

        Parameters
        ----------
        headings : (n,) float64 — As in the file [unit].
        """
        return np.asarray(np.radians(self.heading_zero_deg) + self.turns_rad(headings))

    def turns_rad(self, turns: FloatArray) -> FloatArray:
        """Return turns counter-clockwise [rad].

        Parameters
        ----------
        turns : (n,) float64 — As in the file [unit].
        """
        found = radians(turns, self.angle_unit)
        return -found if self.clockwise else found


def quaternion_heading_rad(
    *, x: FloatArray, y: FloatArray, z: FloatArray, w: FloatArray
) -> FloatArray:
    """Return the heading of orientations given as quaternions, in [-π, π] [rad]; NaN for zeros.

    Parameters
    ----------
    x, y, z, w : (n,) float64 — Parts of the quaternions, of any length [-].
    """
    sine, cosine = 2.0 * (w * z + x * y), w**2 + x**2 - y**2 - z**2
    found = np.arctan2(sine, cosine)
    return np.asarray(np.where((sine == 0.0) & (cosine == 0.0), np.nan, found))


def name_pattern(pattern: str, numbers: frozenset[str] = frozenset()) -> re.Pattern[str]:
    """Return the expression that names of a pattern such as ``rssi_{id}`` match, case aside.

    Parameters
    ----------
    pattern : Text with names in braces, each once.
    numbers : Names of those that are numbers.
    """
    parts = re.split(r"\{(\w+)\}", pattern)
    names = parts[1::2]
    if len(set(names)) < len(names):
        raise NavigationError(f"the pattern {pattern!r} has a name twice; give each once.")
    text = re.escape(parts[0])
    for name, after in zip(names, parts[2::2], strict=True):
        kind = r"[-+]?\d+(?:[.,]\d+)?" if name in numbers else ".+?"
        text += f"(?P<{name}>{kind}){re.escape(after)}"
    return re.compile(text, re.IGNORECASE)
