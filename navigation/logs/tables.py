"""Logs out of tables of other people: one row a reading, or one column a source."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.navigation.logs.forms import TableForm, name_pattern, quaternion_heading_rad
from octant.navigation.logs.log_csv import antenna_numbers, source_indices
from octant.navigation.logs.records import NO_SOURCE, NOT_HEARD_DBM, Log, taken
from octant.navigation.logs.text_tables import TextTable, read_text_table
from octant.navigation.logs.units import (
    HIGHEST_DBM,
    LOWEST_DBM,
    SECONDS,
    levels_dbm,
    suspected_unit,
)

FloatArray = npt.NDArray[np.float64]

_FEW = 5


def read_table(path: Path, form: TableForm) -> Log:
    """Return the log of a table in a file; columns without a name in the form are kept as text.

    Parameters
    ----------
    path : The file.
    form : Its columns and units.

    Raises
    ------
    ConfigError
        A column is not there, a cell is wrong or the unit of levels cannot be what the form says;
        file and line are named.
    """
    table = read_text_table(path, separator=form.separator, header=form.header)
    return log_of_table(table, form)


def log_of_table(table: TextTable, form: TableForm) -> Log:
    """Return the log of a table that has been read.

    Parameters
    ----------
    table, form : Its cells; its columns and units.
    """
    if form.columns.rss is None:
        msg = (
            f"{table.path}: no column of levels is named; give columns.rss, such as "
            f"{_likely(table)} (it has {', '.join(table.header[:8])})."
        )
        raise ConfigError(msg)
    return _wide(table, form) if form.columns.wide else _long(table, form)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Motion:
    """What rows say of time and motion; (m,) [s], (m, 3) [m], [rad], (m,) [m], (m,) [rad], [Hz]."""

    time_s: FloatArray
    poses: FloatArray
    distance_m: FloatArray
    turn_rad: FloatArray
    frequency_hz: FloatArray


def _motion(table: TextTable, form: TableForm) -> _Motion:
    names, none = form.columns, np.full(len(table), np.nan)

    def column(name: str | None) -> FloatArray:
        return none if name is None else table.numbers(name)

    time_s = none
    if names.time is not None:
        time_s = (
            table.times(names.time)
            if form.time_unit == "iso"
            else table.numbers(names.time) * SECONDS[form.time_unit]
        )
    heading = form.headings_rad(column(names.heading))
    if names.qz is not None and names.qw is not None:
        zero = np.zeros(len(table))
        x, y = (zero if name is None else column(name) for name in (names.qx, names.qy))
        turn = quaternion_heading_rad(x=x, y=y, z=column(names.qz), w=column(names.qw))
        heading = np.asarray(
            np.radians(form.heading_zero_deg) + (-turn if form.clockwise else turn)
        )
    frequency = column(names.frequency)
    if names.frequency is not None:
        good = np.isnan(frequency) | (frequency > 0.0)
        table.check(names.frequency, good, "a frequency above 0 Hz is needed")
    return _Motion(
        time_s=time_s,
        poses=np.column_stack(
            [form.metres * column(names.x), form.metres * column(names.y), heading]
        ),
        distance_m=form.metres * column(names.distance),
        turn_rad=form.turns_rad(column(names.turn)),
        frequency_hz=frequency,
    )


def _long(table: TextTable, form: TableForm) -> Log:
    names, motion = form.columns, _motion(table, form)
    if names.id is None or names.rss is None:
        msg = f"{table.path}: no column names the sources; give columns.id, or ids by a pattern."
        raise ConfigError(msg)
    given = table.texts(names.id)
    found, sources = source_indices(given)
    ids = tuple(form.ids.get(name, name) for name in found)
    values = _values(table, names.rss, form)
    _check_unit(table, names.rss, values, form)
    level = _levels(table, names.rss, values, form)
    there = (sources != NO_SOURCE) & (~np.isnan(level) | (form.empty == "not_heard"))
    level = np.where(there & np.isnan(level), NOT_HEARD_DBM, level)
    kept = tuple(name for name in table.header if name and name not in names.named())
    log = Log(
        ids=ids,
        time_s=motion.time_s,
        poses=motion.poses,
        sources=np.where(there, sources, NO_SOURCE),
        antennas=antenna_numbers(table, names.antenna),
        rss_dbm=np.where(there, level, np.nan),
        frequency_hz=motion.frequency_hz,
        distance_m=motion.distance_m,
        turn_rad=motion.turn_rad,
        threshold_dbm=form.threshold_dbm,
        kept={name: table.columns[table.place(name)] for name in kept},
    )
    return log if form.only is None else _restricted(log, form.only)


def _restricted(log: Log, only: frozenset[str]) -> Log:
    wanted = np.array([name in only for name in log.ids] + [True])
    ids = tuple(name for name in log.ids if name in only)
    new = np.array(
        [ids.index(name) if name in only else NO_SOURCE for name in log.ids] + [NO_SOURCE]
    )
    part = taken(log, wanted[log.sources])
    return Log(
        ids=ids,
        time_s=part.time_s,
        poses=part.poses,
        sources=new[part.sources],
        antennas=part.antennas,
        rss_dbm=part.rss_dbm,
        frequency_hz=part.frequency_hz,
        distance_m=part.distance_m,
        turn_rad=part.turn_rad,
        threshold_dbm=part.threshold_dbm,
        kept=part.kept,
    )


def _wide(table: TextTable, form: TableForm) -> Log:
    """Return a row for each cell of a source; a row of the table without any is one of motion."""
    columns = wide_columns(table, form)
    motion = _motion(table, form)
    ids = tuple(dict.fromkeys(source for source, _ in columns.values()))
    values = np.column_stack([_values(table, name, form) for name in columns])
    _check_unit(table, str(form.columns.rss), values.ravel(), form)
    level = np.column_stack(
        [_levels(table, name, values[:, j], form) for j, name in enumerate(columns)]
    )
    if form.empty == "not_heard":
        level[np.isnan(level)] = NOT_HEARD_DBM
    there = ~np.isnan(level)
    there[:, 0] |= ~there.any(axis=1)  # a row without a reading stays as one of motion
    row, column = np.nonzero(there)
    first = np.r_[True, np.diff(row) > 0]
    order = np.array([ids.index(source) for source, _ in columns.values()])
    antenna = np.array([number for _, number in columns.values()])
    rss = level[row, column]
    pattern = name_pattern(str(form.columns.rss), frozenset({"antenna"}))
    others = {name for name in table.header if pattern.fullmatch(name)} if form.only else set()
    named = form.columns.named() | set(columns) | others
    kept = tuple(name for name in table.header if name and name not in named)

    def once(values: FloatArray) -> FloatArray:
        """Return odometry at the first reading of a row, and none since at the others."""
        return np.where(first | np.isnan(values[row]), values[row], 0.0)

    return Log(
        ids=ids,
        time_s=motion.time_s[row],
        poses=motion.poses[row],
        sources=np.where(np.isnan(rss), NO_SOURCE, order[column]),
        antennas=antenna[column],
        rss_dbm=rss,
        frequency_hz=motion.frequency_hz[row],
        distance_m=once(motion.distance_m),
        turn_rad=once(motion.turn_rad),
        threshold_dbm=form.threshold_dbm,
        kept={name: tuple(map(table.columns[table.place(name)].__getitem__, row)) for name in kept},
    )


def wide_columns(table: TextTable, form: TableForm) -> Mapping[str, tuple[str, int]]:
    """Return source and antenna, 0 for the only one, of each column of levels, by its name [-].

    Parameters
    ----------
    table, form : The table; its form, whose columns are wide.
    """
    pattern = name_pattern(str(form.columns.rss), frozenset({"antenna"}))
    taken_names, found = form.columns.named(), {}
    bare = form.columns.rss == "{id}"
    for name in table.header:
        match = pattern.fullmatch(name)
        if not name or match is None or name in taken_names:
            continue
        parts = match.groupdict()
        if bare and form.ids and parts["id"] not in form.ids:
            continue
        source = form.ids.get(parts["id"], parts["id"])
        if form.only is None or source in form.only:
            found[name] = (source, int(float(parts.get("antenna") or 0)))
    lacking = sorted(set(form.ids) - {_name_id(pattern, name) for name in table.header})
    if lacking:
        msg = (
            f"{table.path}:{max(table.header_line, 1)}: has no column of the source {lacking[0]!r} "
            f"by the pattern {form.columns.rss!r}; its columns are {', '.join(table.header[:8])}."
        )
        raise ConfigError(msg)
    if not found:
        there = any(pattern.fullmatch(name) for name in table.header)
        known = _listed(sorted(form.only)) if form.only else "none"
        why = f"of the tags {known} by the pattern" if there and form.only is not None else "like"
        msg = (
            f"{table.path}:{max(table.header_line, 1)}: has no column {why} {form.columns.rss!r}; "
            f"its columns are {_listed(table.header)}."
        )
        raise ConfigError(msg)
    return found


def _name_id(pattern: re.Pattern[str], name: str) -> str | None:
    match = pattern.fullmatch(name)
    return None if match is None else str(match.groupdict()["id"])


def _values(table: TextTable, name: str, form: TableForm) -> FloatArray:
    """Return levels as the file has them, (n,) [unit]: -inf for not heard, NaN for none."""
    try:
        values = table.numbers(name)
    except ConfigError:
        values = table.numbers(name, special=lambda text: -np.inf if text == "-inf" else None)
    for number in form.not_heard:
        values = np.where(values == number, -np.inf, values)
    return values


def _check_unit(table: TextTable, name: str, values: FloatArray, form: TableForm) -> None:
    why = suspected_unit(values, form.rss_unit)
    if why:
        raise ConfigError(f"{table.path}: the levels in {name} {why}.")


def _levels(table: TextTable, name: str, values: FloatArray, form: TableForm) -> FloatArray:
    """Return levels, (n,) [dBm]: -inf for not heard, NaN for none."""
    silent = np.isneginf(values)
    negative = values < 0.0
    if form.rss_unit in {"w", "mw", "uw", "nw"}:
        table.check(name, silent | ~negative, f"a power in {form.rss_unit} is not negative")
    level = np.where(silent, -np.inf, levels_dbm(np.where(silent, np.nan, values), form.rss_unit))
    good = ~np.isfinite(level) | ((level >= LOWEST_DBM) & (level <= HIGHEST_DBM))
    wanted = (
        f"a level from {LOWEST_DBM:g} to {HIGHEST_DBM:g} dBm is needed, or name it in not_heard"
    )
    table.check(name, good, wanted)
    return level


def _likely(table: TextTable) -> str:
    """Return the most likely name of the levels, or a pattern of their names, for a message."""
    hits = [
        n for n in table.header if any(w in n.casefold() for w in ("rss", "dbm", "wap", "beacon"))
    ]
    if len(hits) == 1:
        return f'"{hits[0]}"'
    stems = {n.rstrip("0123456789") for n in hits}
    return f'"{stems.pop()}{{id}}"' if len(stems) == 1 and hits else '"rssi" or "rssi_{id}"'


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - _FEW} more" if len(names) > _FEW else ""
    return ", ".join(repr(name) for name in names[:_FEW]) + more
