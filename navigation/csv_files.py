"""CSV files written whole or not at all, with numbers that read back to the same bits."""

import csv
import io
import math
from collections.abc import Iterable, Sequence
from pathlib import Path

from octant.geometries.errors import ResultError
from octant.geometries.files import write_text


def number_text(value: float) -> str:
    """Return a number as the shortest text that reads back to the same bits; of NaN none.

    Parameters
    ----------
    value : Any number, in the unit of its column [any]; NaN: there is none.
    """
    if math.isinf(value):
        msg = f"a value is {value}, so that the table is not written; report it with the study."
        raise ResultError(msg)
    return "" if math.isnan(value) else repr(float(value))


def write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table whole.

    Parameters
    ----------
    path : File to write; an existing one is replaced in one move.
    header : Names of the columns, with their units.
    rows : Cells.
    """
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    write_text(path, text.getvalue())
