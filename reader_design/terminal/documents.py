"""One JSON document a call: the same keys in every run, no NaN, units in the names."""

import csv
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np


def plain(value: Any) -> Any:  # noqa: ANN401, PLR0911  whatever a result holds
    """Return a value as JSON has it: infinite and undefined numbers are None, complex ones pairs.

    Parameters
    ----------
    value : Mappings, sequences, arrays, numbers, text and paths.
    """
    if isinstance(value, Mapping):
        return {str(key): plain(each) for key, each in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, complex):
        return {"re": plain(value.real), "im": plain(value.imag)}
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, str | int) or value is None:
        return value
    if isinstance(value, Path):
        return str(value)
    return [plain(each) for each in value]


def json_text(document: Mapping[str, Any]) -> str:
    """Return the document as JSON text.

    Parameters
    ----------
    document : What a verb found.
    """
    return json.dumps(plain(document), indent=1, ensure_ascii=False, allow_nan=False)


def rows_of(columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> list[dict[str, Any]]:
    """Return the rows of a table as mappings.

    Parameters
    ----------
    columns, rows : Names with their units, and values in that order.
    """
    return [dict(zip(columns, row, strict=True)) for row in rows]


def csv_rows(path: Path) -> list[dict[str, Any]]:
    """Return the rows of a CSV file: a column whose every cell is a number holds numbers.

    Parameters
    ----------
    path : A file that Octant wrote; an empty cell is None.
    """
    with path.open(encoding="utf-8", newline="") as file:
        reader = csv.reader(file)
        header = next(reader, [])
        rows = list(reader)
    columns = [_numbers([row[i] for row in rows]) for i in range(len(header))]
    return [dict(zip(header, cells, strict=True)) for cells in zip(*columns, strict=True)]


def _numbers(cells: Sequence[str]) -> list[Any]:
    for kind in (int, float):
        try:
            return [None if cell == "" else kind(cell) for cell in cells]
        except ValueError:
            continue
    return [cell or None for cell in cells]
