"""Tables of text as people's programs write them, with the line of every fault."""

import csv
import io
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import NoReturn

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.geometries.names import nearest_name

ABSENT = frozenset({"", "-", "nan", "na", "n/a", "null", "none"})
"""What stands in a cell that holds nothing, in small letters."""

SEPARATORS = {"comma": ",", "semicolon": ";", "tab": "\t", "bar": "|", "space": " "}
"""Separators of cells by their names."""

_SHOWN = 60


@dataclass(frozen=True, slots=True, kw_only=True)
class TextTable:
    """Cells of a file by column, with the line of each row.

    Parameters
    ----------
    path : The file.
    header : Names of the columns.
    columns : Cells of each column, in the header's order.
    lines : Line of each row in the file, from 1.
    header_line : Line of the header; 0: the file has none, and the columns are called 1, 2 ...
    decimal_comma : Whether numbers are written as ``-61,5``.
    """

    path: Path
    header: tuple[str, ...]
    columns: tuple[tuple[str, ...], ...]
    lines: tuple[int, ...]
    header_line: int = 1
    decimal_comma: bool = False

    def __len__(self) -> int:
        return len(self.lines)

    def place(self, name: str) -> int:
        """Return the index of a column; else name the nearest.

        Parameters
        ----------
        name : The column wanted.
        """
        if name in self.header:
            return self.header.index(name)
        near = nearest_name(name, self.header, least_likeness=0.5)
        hint = f"the nearest is {near!r}" if near else f"its columns are {_listed(self.header)}"
        msg = f"{self.path}:{max(self.header_line, 1)}: has no column {name!r}; {hint}."
        raise ConfigError(msg)

    def texts(self, name: str) -> tuple[str, ...]:
        """Return the cells of a column without blanks around them.

        Parameters
        ----------
        name : The column.
        """
        return tuple(cell.strip() for cell in self.columns[self.place(name)])

    def numbers(
        self, name: str, *, special: Callable[[str], float | None] | None = None
    ) -> npt.NDArray[np.float64]:
        """Return a column's numbers, (n,); NaN where a cell holds nothing.

        Parameters
        ----------
        name : The column.
        special : Number of a cell, without blanks and in small letters, that is written in another
            way; None: it is written as a number.
        """
        place = self.place(name)
        if special is None:
            plain = self._plain(place)
            if plain is not None:
                return plain
        found = np.empty(len(self))
        for row, cell in enumerate(self.columns[place]):
            text = cell.strip()
            value = special(text.casefold()) if special else None
            found[row] = self._number(text, row, name) if value is None else value
        return found

    def times(self, name: str) -> npt.NDArray[np.float64]:
        """Return a column of dates and times after ISO 8601 as seconds since 1970, (n,) [s].

        Without a zone they count as UTC.

        Parameters
        ----------
        name : The column.
        """
        found = np.full(len(self), np.nan)
        for row, text in enumerate(self.texts(name)):
            if text.casefold() in ABSENT:
                continue
            try:
                moment = datetime.fromisoformat(text)
            except ValueError:
                self.fault(row, name, "a date and time such as 2024-05-17T09:30:00.250 is needed")
            zone = "" if moment.tzinfo else "+00:00"
            found[row] = datetime.fromisoformat(f"{moment.isoformat()}{zone}").timestamp()
        return found

    def check(self, name: str, good: npt.NDArray[np.bool_], wanted: str) -> None:
        """Refuse the first row of a column that is not good.

        Parameters
        ----------
        name : The column.
        good : (n,) bool — Which rows are.
        wanted : What is needed, for the message.
        """
        bad = np.flatnonzero(~good)
        if bad.size:
            self.fault(int(bad[0]), name, wanted)

    def fault(self, row: int, name: str, wanted: str) -> NoReturn:
        """Refuse a cell by its file and line.

        Parameters
        ----------
        row : The row, from 0.
        name : Its column.
        wanted : What is needed instead, for the message.
        """
        cell = self.columns[self.place(name)][row].strip()
        shown = cell if len(cell) <= _SHOWN else f"{cell[: _SHOWN - 3]}..."
        raise ConfigError(f"{self.path}:{self.lines[row]}: {name} is {shown!r}, but {wanted}.")

    def _plain(self, place: int) -> npt.NDArray[np.float64] | None:
        """Return a column of nothing but finite numbers with points, at once; None: it is not."""
        cells = self.columns[place]
        if not cells or any("_" in cell for cell in (cells[0], cells[-1])):
            return None
        try:
            values = np.array(cells).astype(np.float64)
        except ValueError:
            return None
        return values if np.isfinite(values).all() else None

    def _number(self, text: str, row: int, name: str) -> float:
        if text.casefold() in ABSENT:
            return math.nan
        try:
            value = float(text.replace(",", ".") if self.decimal_comma else text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value) or "_" in text:
            self.fault(row, name, "a finite number is needed, or nothing")
        return value


def read_text_table(
    path: Path, *, separator: str | None = None, header: bool = True, what: str = "a log"
) -> TextTable:
    """Return a file's table; lines that are empty or begin with # are skipped.

    Parameters
    ----------
    path : A file of text in UTF-8, UTF-16 with a mark, or Latin-1.
    separator : A name of `SEPARATORS`; None: found from the first line. A decimal comma is
        understood where the separator is another sign.
    header : Whether the first line names the columns; else they are called 1, 2 and so on.
    what : What the file should hold, for the message.
    """
    lines = _text(path, what).splitlines(keepends=True)
    first = next((i for i, line in enumerate(lines) if not _skipped(line)), None)
    if first is None:
        raise ConfigError(f"{path} is empty, but it should hold {what}; give the right file.")
    sign = SEPARATORS[separator] if separator else _separator(lines[first])
    rows, numbers = _rows("".join(lines[first:]), sign, first)
    names = (
        tuple(cell.strip() for cell in rows[0])
        if header
        else tuple(str(i + 1) for i in range(len(rows[0])))
    )
    twice = next((n for i, n in enumerate(names) if n in names[:i] and n), None)
    if twice:
        raise ConfigError(f"{path}:{numbers[0]}: names the column {twice!r} twice; rename one.")
    body = rows[1:] if header else rows
    body_lines = numbers[1:] if header else numbers
    if not body:
        raise ConfigError(f"{path} has no rows below its header; give at least one reading.")
    for row, line in zip(body, body_lines, strict=True):
        if len(row) > len(names) and any(cell.strip() for cell in row[len(names) :]):
            msg = (
                f"{path}:{line}: has {len(row)} cells, but the header names {len(names)} columns; "
                "check the separator and the quotes."
            )
            raise ConfigError(msg)
    columns = tuple(
        tuple(row[i] if i < len(row) else "" for row in body) for i in range(len(names))
    )
    return TextTable(
        path=path,
        header=names,
        columns=columns,
        lines=tuple(body_lines),
        header_line=numbers[0] if header else 0,
        decimal_comma=sign != ",",
    )


def _text(path: Path, what: str) -> str:
    try:
        data = path.read_bytes()
    except OSError as exc:
        msg = f"{path} cannot be read ({exc.strerror}); give the file of {what}."
        raise ConfigError(msg) from exc
    if b"\0" in data and not data.startswith((b"\xff\xfe", b"\xfe\xff")):
        msg = f"{path} is no text; give {what} as CSV, or name its format."
        raise ConfigError(msg)
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return data.decode("utf-16", "replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _skipped(line: str) -> bool:
    return not line.strip() or line.lstrip().startswith("#")


def _separator(line: str) -> str:
    counts = {sign: line.count(sign) for sign in (";", "\t", "|", ",")}
    best = max(counts, key=lambda sign: counts[sign])
    if counts[best]:
        # A semicolon or a tab beside commas: these are the commas of decimals.
        return next((s for s in (";", "\t", "|") if counts[s]), best)
    return " " if " " in line.strip() else ","


def _rows(text: str, sign: str, skipped: int) -> tuple[list[list[str]], list[int]]:
    rows, lines = [], []
    same: dict[str, str] = {}  # wide tables repeat a few levels in millions of cells
    if sign == " ":
        for number, line in enumerate(text.splitlines(), skipped + 1):
            if not _skipped(line):
                rows.append([same.setdefault(cell, cell) for cell in line.split()])
                lines.append(number)
        return rows, lines
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=sign)
    start = 1
    for row in reader:
        if any(cell.strip() for cell in row) and not row[0].lstrip().startswith("#"):
            rows.append([same.setdefault(cell, cell) for cell in row])
            lines.append(skipped + start)
        start = reader.line_num + 1
    return rows, lines


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(repr(name) for name in names[:8])
    return shown + (f" and {len(names) - 8} more" if len(names) > 8 else "")
