"""CSV files written whole or not at all, with numbers that read back to the same bits."""

import csv
import io
import os
from collections.abc import Iterable, Sequence
from pathlib import Path


def number_text(value: float) -> str:
    """Return a number as text that reads back to the same bits.

    Parameters
    ----------
    value : float
        Any number, in the unit of its column [any].

    Returns
    -------
    str
        Shortest text.
    """
    return repr(float(value))


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table; return nothing.

    Parameters
    ----------
    path : Path
        File to write; an existing one is replaced in one move, never left half written.
    header : sequence of str
        Names of the columns, with their units.
    rows : iterable of sequence
        Cells.
    """
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with part.open("w", encoding="utf-8", newline="") as file:
            file.write(text.getvalue())
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
