"""CSV tables in and out: named columns, errors with file and line."""

import csv
import io
import math
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TextIO

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError, ResultError
from octant.geometries.files import refuse_overwrite, whole_file
from octant.geometries.names import nearest_name
from octant.reader_design.study_file.errors import unit_of
from octant.reader_design.study_file.quantities import Angle, Coordinate, limits, range_text

RANGES = {"m": limits(Coordinate), "degrees": limits(Angle)}
"""Type and limits of the columns that are read, by their unit."""


def read_columns(path: Path, columns: Sequence[str]) -> npt.NDArray[np.float64]:
    """Return named columns of a CSV file, (m, k), in the units that their names carry.

    Parameters
    ----------
    path : A CSV file whose first line names its columns; further columns are left alone, empty
        lines skipped.
    columns : The names wanted, for example ``x_m``.
    """
    try:
        text = path.read_text("utf-8-sig")
    except (OSError, UnicodeDecodeError) as exc:
        reason = exc.strerror if isinstance(exc, OSError) else "it is not UTF-8 text"
        msg = f"{path} cannot be read ({reason}); give a CSV file with {','.join(columns)}."
        raise ConfigError(msg) from exc
    reader = csv.reader(io.StringIO(text), skipinitialspace=True)
    header = [name.strip() for name in next(reader, [])]
    places = [_place(path, header, name) for name in columns]
    rows = [
        [
            _number(path, reader.line_num, name, row, i)
            for name, i in zip(columns, places, strict=True)
        ]
        for row in reader
        if any(cell.strip() for cell in row)
    ]
    if not rows:
        msg = f"{path} has no rows below its header; give at least one."
        raise ConfigError(msg)
    return np.array(rows, dtype=np.float64)


def put_table(
    target: str | None, header: Sequence[str], rows: Iterable[Sequence[object]], *, force: bool
) -> None:
    """Write a CSV table to a file or to stdout, row by row.

    Parameters
    ----------
    target : A file's path; None or ``-``: stdout.
    header : Column names, with their units.
    rows : Values; floats get the digits that read back to the same number, NaN an empty cell.
    force : Replace a file that exists.
    """
    if target is None or target == "-":
        _write_rows(sys.stdout, header, rows)
        return
    path = Path(target)
    refuse_overwrite(path, force=force)
    with whole_file(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        _write_rows(file, header, rows)


def csv_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a CSV table as text.

    Parameters
    ----------
    header : Column names, with their units.
    rows : Values; floats get the digits that read back to the same number, NaN an empty cell.
    """
    text = io.StringIO(newline="")
    _write_rows(text, header, rows)
    return text.getvalue()


def _write_rows(file: TextIO, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(header)
    for row in rows:
        writer.writerow(
            [
                _cell(v, name) if isinstance(v, float) else v
                for v, name in zip(row, header, strict=True)
            ]
        )


def _cell(value: float, column: str) -> str:
    """Return a number's text: none for NaN, -inf for the level of no power; refuse infinity."""
    if math.isinf(value) and (value > 0.0 or "_db" not in column):
        msg = f"{column} is {value}, so that the table is not written; report it with the study."
        raise ResultError(msg)
    return "" if math.isnan(value) else repr(float(value))


def _place(path: Path, header: Sequence[str], name: str) -> int:
    if name in header:
        return header.index(name)
    near = nearest_name(name, header, least_likeness=0.5)
    hint = f"; the nearest is {near!r}" if near else ""
    msg = f"{path}:1: has no column {name!r}, but the header must name it{hint}."
    raise ConfigError(msg)


def _number(path: Path, line: int, name: str, row: Sequence[str], place: int) -> float:
    cell = row[place].strip() if place < len(row) else ""
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    found = RANGES.get(unit_of((name,)))
    wanted = range_text(*found, unit_of((name,))) if found else "a finite number"
    low, high = (found[1].ge, found[1].le) if found else (None, None)
    if (
        not math.isfinite(value)
        or (low is not None and value < low)
        or (high is not None and value > high)
    ):
        shown = cell if len(cell) <= 60 else f"{cell[:57]}..."
        msg = f"{path}:{line}: {name} is {shown!r}, but {wanted} is needed."
        raise ConfigError(msg)
    return value
