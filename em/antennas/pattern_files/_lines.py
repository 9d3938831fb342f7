"""Lines of a pattern file and the numbers in them; what is wrong is refused with file and line.

In all of them ``path`` and ``line`` are the file and the line's number, from 1, for messages.
"""

import math
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from octant.em.antennas.pattern_files.common import DBI_FLOOR
from octant.geometries.errors import PatternFileError

HERTZ = {"HZ": 1.0, "KHZ": 1e3, "MHZ": 1e6, "GHZ": 1e9}
"""Units of frequency in capitals [Hz]."""

_LARGEST = 1e30
_MOST_SAMPLES = 20_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Numbers of one line of a file, in its own units, with the line's number from 1."""

    line: int
    values: tuple[float, ...]


def refusal(path: Path, line: int, what: str) -> PatternFileError:
    """Return the error that names file and line; ``what``: what is wrong, and what to do."""
    return PatternFileError(f"{path}, line {line}: {what}")


def read_lines(path: Path) -> list[str]:
    """Return the lines of a text file, UTF-8 or else Latin-1, without their ends."""
    try:
        data = path.read_bytes()
    except OSError as exc:
        msg = f"{path} cannot be read ({exc.strerror}); give a file that can."
        raise PatternFileError(msg) from exc
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    text = text.replace("\r\n", "\n").replace("\r", "\n").replace("\f", "\n")
    lines = text.split("\n")
    for number, line in enumerate(lines, start=1):
        if re.search(r"[\x00-\x08\x0b\x0e-\x1f\x7f-\x9f]", line):
            raise refusal(path, number, "the line is not text; give a text file of a known format.")
    if not text.strip():
        raise refusal(path, 1, "the file is empty; give one with a pattern in it.")
    return lines


def number(path: Path, line: int, token: str) -> float:
    """Return a finite number in the file's unit; a Fortran exponent ``D`` is understood."""
    value = math.nan
    try:
        value = float(token)
    except ValueError:
        with suppress(ValueError):
            value = float(re.sub("[dD]", "e", token, count=1))
    # an underscore is Python's own digit separator and no number elsewhere
    if not abs(value) < _LARGEST or "_" in token:
        what = f"{token[:40]!r} is not a finite number where one is needed; correct it."
        raise refusal(path, line, what)
    return value


def numbers(path: Path, line: int, tokens: Sequence[str], count: int) -> Row:
    """Return the numbers of a line's columns, which must be ``count``."""
    if len(tokens) != count:
        what = f"{len(tokens)} columns where {count} are needed; correct the line."
        raise refusal(path, line, what)
    return Row(line=line, values=tuple(number(path, line, token) for token in tokens))


def whole_number(path: Path, line: int, token: str) -> int:
    """Return a number of samples, at least 1."""
    value = number(path, line, token)
    if value != int(value) or not 1 <= value <= _MOST_SAMPLES:
        what = f"{token[:40]!r} is not a number of samples; give a whole number of 1 or more."
        raise refusal(path, line, what)
    return int(value)


def checked_gain_dbi(path: Path, line: int, value: float) -> float:
    """Return a gain that can be one, not below ``DBI_FLOOR`` [dBi]."""
    if value > 100.0:
        raise refusal(
            path, line, f"{value:g} dBi is not a gain that an antenna can have; correct it."
        )
    return max(value, DBI_FLOOR)
