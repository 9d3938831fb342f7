"""The one CSV of logs: a row a reading, its columns named with their units; written, and read back.

A row with an id says that this source was listened for: at the level ``rss_dbm``, or, where that is
``-inf``, empty or ``-``, that it was not heard. A source that nobody listened for has no row. A row
without an id carries time, pose or odometry only.
"""

from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.geometries.names import nearest_name
from octant.navigation.csv_files import number_text, write_csv
from octant.navigation.logs.records import NO_SOURCE, NOT_HEARD_DBM, Log
from octant.navigation.logs.text_tables import ABSENT, TextTable, read_text_table
from octant.navigation.logs.units import (
    HIGHEST_DBM,
    LOWEST_DBM,
    exact_degrees,
    suspected_unit,
)

LOG_COLUMNS = (
    "time_s",
    "x_m",
    "y_m",
    "heading_deg",
    "distance_m",
    "turn_deg",
    "id",
    "antenna",
    "rss_dbm",
    "frequency_hz",
)
"""Columns of a log: time [s], place [m], heading [deg], odometry [m], [deg], source, antenna, level
[dBm], frequency [Hz]. Source and level must be there; what else is lacking is unknown."""

_NEEDED = ("id", "rss_dbm")
_SAME_QUANTITY = 0.75


def write_log(path: Path, log: Log) -> None:
    """Write a log as CSV, whole or not at all; `read_log` returns it to the bit.

    The threshold is no column: who reads gives it.

    Parameters
    ----------
    path : File to write; an existing one is replaced in one move.
    log : The log. Its angles come back to the bit where they were read from degrees.
    """
    for name in log.ids:
        if name.casefold() in ABSENT or name != name.strip():
            msg = f"a source is called {name!r}, which a CSV file cannot tell from none; rename it."
            raise ConfigError(msg)
    heading_deg, turn_deg = exact_degrees(log.poses[:, 2]), exact_degrees(log.turn_rad)
    names = tuple(log.kept)
    rows = (
        (
            number_text(log.time_s[i]),
            number_text(log.poses[i, 0]),
            number_text(log.poses[i, 1]),
            number_text(heading_deg[i]),
            number_text(log.distance_m[i]),
            number_text(turn_deg[i]),
            "-" if log.sources[i] == NO_SOURCE else log.ids[log.sources[i]],
            int(log.antennas[i]) or "-",
            "-inf" if log.rss_dbm[i] == NOT_HEARD_DBM else number_text(log.rss_dbm[i]),
            number_text(log.frequency_hz[i]),
            *(log.kept[name][i] for name in names),
        )
        for i in range(len(log))
    )
    write_csv(path, (*LOG_COLUMNS, *names), rows)


def read_log(path: Path, *, threshold_dbm: float | None = None) -> Log:
    """Return the log of a CSV file with the columns `LOG_COLUMNS`, further ones kept as text.

    Parameters
    ----------
    path : The file; commas, semicolons with decimal commas, or tabs.
    threshold_dbm : Level below which the receiver hears nothing [dBm]; None: unknown.

    Raises
    ------
    ConfigError
        The file cannot be read, lacks a column, or a cell is wrong; file and line are named.
    """
    table = read_text_table(path)
    _check_header(table)

    def column(name: str) -> npt.NDArray[np.float64]:
        return table.numbers(name) if name in table.header else np.full(len(table), np.nan)

    ids, sources = source_indices(table.texts("id"))
    kept = tuple(name for name in table.header if name not in LOG_COLUMNS)
    return Log(
        ids=ids,
        time_s=column("time_s"),
        poses=np.column_stack([column("x_m"), column("y_m"), np.radians(column("heading_deg"))]),
        sources=sources,
        antennas=antenna_numbers(table, "antenna" if "antenna" in table.header else None),
        rss_dbm=_levels(table, sources),
        frequency_hz=_frequencies(table, column("frequency_hz")),
        distance_m=column("distance_m"),
        turn_rad=np.radians(column("turn_deg")),
        threshold_dbm=threshold_dbm,
        kept={name: table.columns[table.place(name)] for name in kept},
    )


def source_indices(names: tuple[str, ...]) -> tuple[tuple[str, ...], npt.NDArray[np.int64]]:
    """Return the sources in the order of their first reading, and each row's index, (n,) [-].

    Parameters
    ----------
    names : Id of each row; an absent one gives -1.
    """
    known: dict[str, int] = {}
    found = [
        NO_SOURCE if name.casefold() in ABSENT else known.setdefault(name, len(known))
        for name in names
    ]
    return tuple(known), np.array(found, dtype=np.int64)


def antenna_numbers(table: TextTable, name: str | None) -> npt.NDArray[np.int64]:
    """Return the antennas' numbers of a column, (n,), 0 where it holds nothing [-].

    Parameters
    ----------
    table : The table.
    name : The column; None: there is none.
    """
    if name is None:
        return np.zeros(len(table), dtype=np.int64)
    numbers = np.nan_to_num(table.numbers(name))
    given = np.array([cell.casefold() not in ABSENT for cell in table.texts(name)])
    good = ~given | ((numbers >= 1.0) & (numbers <= 10_000.0) & (numbers == np.round(numbers)))
    table.check(name, good, "a whole number from 1, or - for the only antenna, is needed")
    return numbers.astype(np.int64)


def _check_header(table: TextTable) -> None:
    for name in _NEEDED:
        table.place(name)
    for name in table.header:
        if name in LOG_COLUMNS:
            continue
        near = nearest_name(name, LOG_COLUMNS, least_likeness=_SAME_QUANTITY)
        same = next((c for c in LOG_COLUMNS if c.split("_")[0] == name.split("_")[0]), near)
        if same and same not in table.header:
            msg = (
                f"{table.path}:{table.header_line}: has the column {name!r}, but none called "
                f"{same!r}; name columns and units as a log does, or describe the file in [log]."
            )
            raise ConfigError(msg)


def _levels(table: TextTable, sources: npt.NDArray[np.int64]) -> npt.NDArray[np.float64]:
    """Return the levels, (n,) [dBm]: -inf where a source was not heard, NaN without a source."""
    level = table.numbers("rss_dbm", special=lambda text: -np.inf if text == "-inf" else None)
    there = sources != NO_SOURCE
    table.check("rss_dbm", there | np.isnan(level), "the row has no id; name the source")
    why = suspected_unit(level, "dbm")
    if why:
        raise ConfigError(f"{table.path}: the levels in rss_dbm {why}.")
    good = ~np.isfinite(level) | ((level >= LOWEST_DBM) & (level <= HIGHEST_DBM))
    wanted = f"a level from {LOWEST_DBM:g} to {HIGHEST_DBM:g} dBm, or -inf, is needed"
    table.check("rss_dbm", good, wanted)
    return np.where(there & np.isnan(level), NOT_HEARD_DBM, level)


def _frequencies(
    table: TextTable, frequency_hz: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Return the frequencies once each is positive, (n,) [Hz]."""
    good = np.isnan(frequency_hz) | (frequency_hz > 0.0)
    if "frequency_hz" in table.header:
        table.check("frequency_hz", good, "a frequency above 0 Hz is needed")
    return frequency_hz
