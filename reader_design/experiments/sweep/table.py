"""All cells of a sweep in one table: ``sweep.nc`` for programs, ``sweep.csv`` for people.

The table is also the index of the folder: it holds the hash of every cell's file, so that a later
run knows a file for whole, and its scores, without opening it.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.reader_design.experiments.sweep.cells import (
    BothScores,
    ScoreCodec,
    stored_scores,
    stored_surroundings,
)
from octant.reader_design.experiments.sweep.plan import (
    LEFT_OUT,
    PlannedCell,
    SweepPlan,
    compute_cell,
)
from octant.reader_design.keeping.folder import put_bytes
from octant.reader_design.keeping.keeper import Kept, kept_cases
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.small_netcdf import Stored, netcdf_bytes, read_netcdf
from octant.reader_design.keeping.versions import versions
from octant.reader_design.showing.tables import csv_text
from octant.reader_design.study_file.schema import Study
from octant.reader_design.study_file.scores import (
    SCORE_NAMES,
    Scores,
)
from octant.reader_design.study_file.sweep import parameter_unit

TABLE_FILE = "sweep.nc"
CSV_FILE = "sweep.csv"
CELLS_FOLDER = "cells"

DONE, INFEASIBLE, FAILED, MISSING = "done", "infeasible", "failed", "missing"
"""A cell has scores; cannot be built; failed for another reason; is not computed yet."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CellRow:
    """What the table says about one cell.

    Attributes
    ----------
    key : Name of the cell.
    status : ``done``, ``infeasible``, ``failed`` (tried again by the next run) or ``missing``.
    reason : Why there are no scores; empty when there are.
    seconds : Time that it took [s]; NaN when missing.
    free, room : Scores in free space and in the room.
    sha256 : Hash of its file's content; empty when missing.
    """

    key: str
    status: str
    reason: str = ""
    seconds: float = np.nan
    free: Scores | None = None
    room: Scores | None = None
    sha256: str = ""


def row_of(planned: PlannedCell, kept: Kept[tuple[str, BothScores]]) -> CellRow:
    """Return the row of a cell.

    Parameters
    ----------
    planned, kept : The cell, and what became of it, read with a `ScoreCodec`.
    """
    if kept.record is None:
        status = FAILED if kept.unexpected else INFEASIBLE
        return CellRow(key=planned.key, status=status, reason=kept.reason, seconds=kept.seconds)
    sha256, (free, room) = kept.record
    return CellRow(
        key=planned.key, status=DONE, seconds=kept.seconds, free=free, room=room, sha256=sha256
    )


def known_rows(plan: SweepPlan, folder: Path, *, progress: Progress) -> dict[str, CellRow]:
    """Return the rows of all cells whose files are there and whole, by key.

    Files are read, but opened only where the table does not know their hash.

    Parameters
    ----------
    plan, folder : The sweep and its folder.
    progress : Shows which files are damaged.
    """
    kept = kept_cases(
        compute_cell,
        plan.cells,
        context=None,
        folder=folder / CELLS_FOLDER,
        codec=score_codec(folder),
        leave_out=LEFT_OUT,
        progress=progress,
    )
    pairs = zip(plan.cells, kept, strict=True)
    return {planned.key: row_of(planned, one) for planned, one in pairs if one is not None}


def score_codec(folder: Path) -> ScoreCodec:
    """Return a codec that knows the files in a sweep's table.

    Parameters
    ----------
    folder : Folder of the sweep.
    """
    return ScoreCodec(_index(folder / TABLE_FILE))


def missing_cells(plan: SweepPlan, rows: Mapping[str, CellRow]) -> list[PlannedCell]:
    """Return the cells to compute: those without a file, and those whose failure may pass.

    Parameters
    ----------
    plan, rows : The sweep; what is there, by key.
    """
    there = {key for key, row in rows.items() if row.status != FAILED}
    return [cell for cell in plan.cells if cell.key not in there]


def _index(path: Path) -> dict[str, BothScores]:
    """Return the scores in a table by hash; none where there is no table, or a damaged one."""
    try:
        arrays, _ = read_netcdf(path.read_bytes())
        scores = np.stack([arrays[name] for name in SCORE_NAMES], axis=-1)
        there = arrays["scored"]
        return {
            sha256: (
                _scores(scores[i, 0], there=bool(there[i, 0])),
                _scores(scores[i, 1], there=bool(there[i, 1])),
            )
            for i, sha256 in enumerate(arrays["file_sha256"].tolist())
            if sha256
        }
    except (OSError, KeyError, ValueError, TypeError, RuntimeError, IndexError):
        return {}


def _scores(values: npt.NDArray[np.float64], *, there: bool) -> Scores | None:
    return Scores(**dict(zip(SCORE_NAMES, values.tolist(), strict=True))) if there else None


def write_table(plan: SweepPlan, rows: Mapping[str, CellRow], folder: Path, toml: str) -> bool:
    """Write ``sweep.nc`` and ``sweep.csv`` unless they say just this; return whether they changed.

    Parameters
    ----------
    plan, folder : The sweep and its folder.
    rows : By key; cells without one are missing.
    toml : The resolved study.
    """
    ordered = [rows.get(p.key) or CellRow(key=p.key, status=MISSING) for p in plan.cells]
    header, lines = _csv_rows(plan.cells, ordered)
    contents = {
        TABLE_FILE: _table_bytes(plan, ordered, toml),
        CSV_FILE: csv_text(header, lines).encode(),
    }
    changed = False
    for name, content in contents.items():
        path = folder / name
        if not path.is_file() or path.read_bytes() != content:
            put_bytes(path, content)
            changed = True
    return changed


def _table_bytes(plan: SweepPlan, rows: Sequence[CellRow], toml: str) -> bytes:
    stored: dict[str, Stored] = {
        "cell": (["cell"], np.arange(len(rows)), "1", "number of the cell, in the sweep's order"),
        "surrounding": stored_surroundings(),
    }
    parameters = list(plan.cells[0].values)
    for name in parameters:
        values = [cell.values[name] for cell in plan.cells]
        stored[name] = ["cell"], column(values), parameter_unit(name) or "1", f"swept: {name}"
    labels = [cell.label for cell in plan.cells]
    there = [[row.free is not None, row.room is not None] for row in rows]
    stored |= {
        "label": (["cell"], labels, "1", "the cell's name"),
        "cell_key": (["cell"], [row.key for row in rows], "1", "hash of the cell's input"),
        "status": (["cell"], [row.status for row in rows], "1", "how the cell ended"),
        "failed_because": (["cell"], [row.reason for row in rows], "1", "why it has no scores"),
        "seconds": (["cell"], [row.seconds for row in rows], "s", "time that it took"),
        "file_sha256": (["cell"], [row.sha256 for row in rows], "1", "hash of the cell's file"),
        "scored": (["cell", "surrounding"], np.array(there, dtype=np.int8), "1", "1 with scores"),
        **stored_scores([(row.free, row.room) for row in rows], dim="cell"),
    }
    study: Study = plan.setting.study
    attributes: dict[str, str | int | float] = {
        "title": f"Octant sweep {study.name}",
        "study": toml,
        "seed": study.seed,
        **versions(),
        "parameters": json.dumps(parameters),
        "coordinates": " ".join(parameters),
    }
    return netcdf_bytes(stored, attributes)


def column(values: Sequence[Any]) -> npt.NDArray[Any]:
    """Return a parameter's values as a column: numbers where all are, else `parameter_text`.

    Parameters
    ----------
    values : As a study file holds them, in the parameter's unit; true and false become 1 and 0.
    """
    if all(isinstance(value, bool) for value in values):
        return np.array(values, dtype=np.int8)
    if all(isinstance(value, int | float) for value in values):
        return np.array(values)
    return np.array([parameter_text(value) for value in values], dtype=np.str_)


def parameter_text(value: Any) -> str:  # noqa: ANN401  any value of a study
    """Return a parameter's value as the table writes it: text as it is, anything else as JSON.

    Parameters
    ----------
    value : As a study file holds it, in the parameter's unit.
    """
    return value if isinstance(value, str) else json.dumps(value, sort_keys=True)


def _csv_rows(
    cells: Sequence[PlannedCell], rows: Sequence[CellRow]
) -> tuple[tuple[str, ...], list[list[object]]]:
    parameters = tuple(cells[0].values)
    scores = tuple(f"{place}_{name}" for place in ("free", "room") for name in SCORE_NAMES)
    header = ("cell", "label", *parameters, "status", "reason", "seconds", *scores, "key")
    lines: list[list[object]] = []
    for i, (cell, row) in enumerate(zip(cells, rows, strict=True)):
        given = [cell.values[name] for name in parameters]
        line: list[object] = [i, cell.label]
        line += [v if isinstance(v, float) else parameter_text(v) for v in given]
        line += [row.status, row.reason, "" if row.status == MISSING else row.seconds]
        for one in (row.free, row.room):
            line += [""] * len(SCORE_NAMES) if one is None else list(one.as_dict().values())
        lines.append([*line, row.key])
    return header, lines
