"""One cell of a sweep: computed, kept in a netCDF file with units, and read back."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.reader_design.experiments.sweep.plan import (
    LEFT_OUT,
    PlannedCell,
    SweepPlan,
    compute_cell,
)
from octant.reader_design.keeping.keeper import Kept, map_cases
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.small_netcdf import Stored, netcdf_bytes, read_netcdf
from octant.reader_design.keeping.versions import versions
from octant.reader_design.keeping.workers import Crew
from octant.reader_design.setting.design import canonical_json
from octant.reader_design.setting.evaluation import Cell, failed_cell
from octant.reader_design.setting.samples import grid_azimuths_rad
from octant.reader_design.study_file.loading import to_toml
from octant.reader_design.study_file.scores import SCORE_NAMES, Scores, score_unit

SUFFIX = ".nc"
SURROUNDINGS = ("free_space", "room")
"""Where a design is scored; the coordinate ``surrounding`` of every score."""

BothScores = tuple[Scores | None, Scores | None]
"""Scores in free space and in the room."""


def stored_scores(rows: list[BothScores], *, dim: str | None) -> dict[str, Stored]:
    """Return one variable for each score, by design and surrounding, in the score's own unit.

    Parameters
    ----------
    rows : Scores in free space and in the room; None becomes NaN.
    dim : Name of the rows' dimension; None for one row without it.
    """
    out: dict[str, Stored] = {}
    for name in SCORE_NAMES:
        table: npt.NDArray[np.float64] = np.array(
            [[np.nan if s is None else getattr(s, name) for s in row] for row in rows]
        ).reshape(-1, 2)
        long_name = name.rsplit("_" + score_unit(name), 1)[0].replace("_", " ")
        dims = ["surrounding"] if dim is None else [dim, "surrounding"]
        out[name] = dims, table[0] if dim is None else table, score_unit(name), long_name
    return out


def stored_surroundings() -> Stored:
    """Return the coordinate that names where scores hold: ``free_space`` and ``room``."""
    return ["surrounding"], list(SURROUNDINGS), "1", "where the design is scored"


class CellCodec:
    """Keeps a cell as netCDF that xarray opens; powers in [W]."""

    suffix = SUFFIX

    def encode(self, record: Cell, case: PlannedCell) -> bytes:
        """Return the content of a cell's file, the study among its attributes."""
        _, count, antennas = record.free_rss_w.shape
        azimuths = np.degrees(grid_azimuths_rad(1, count)) if count else np.zeros(0)
        away = "horizontal distance to the tag"
        facing = "RSS in free space, antenna 1 towards the tag"
        over = ["distance", "azimuth", "antenna"]
        stored: dict[str, Stored] = {
            "distance": (["distance"], record.distances_m, "m", away),
            "azimuth": (["azimuth"], azimuths, "deg", "azimuth of the tag in the reader frame"),
            "travel": (["travel"], record.travel_m, "m", away),
            "antenna": (["antenna"], np.arange(1, antennas + 1), "1", "number of the antenna"),
            "surrounding": stored_surroundings(),
            "free_rss_w": (over, record.free_rss_w, "W", "RSS in free space"),
            "travel_rss_w": (["travel", "antenna"], record.travel_rss_w, "W", facing),
            **stored_scores([(record.free, record.room)], dim=None),
        }
        study = case.setting.study
        attributes: dict[str, str | int | float] = {
            "title": f"sweep cell: {case.label}",
            "study": to_toml(study),
            "seed": study.seed,
            **versions(),
            "design": canonical_json(case.design.as_dict()),
            "has_free_scores": int(record.free is not None),
            "has_room_scores": int(record.room is not None),
            "notes": json.dumps(record.notes),
        }
        return netcdf_bytes(stored, attributes)

    def decode(self, content: bytes, case: PlannedCell) -> Cell:
        """Return the cell of a file, bit by bit as it was computed."""
        arrays, attributes = read_netcdf(content)
        free, room = scores_of(arrays, attributes)
        return Cell(
            key=case.key,
            label=case.label,
            design=case.design,
            free=free,
            room=room,
            distances_m=arrays["distance"],
            free_rss_w=arrays["free_rss_w"],
            travel_m=arrays["travel"],
            travel_rss_w=arrays["travel_rss_w"],
            notes=tuple(json.loads(attributes["notes"])),
        )


class ScoreCodec(CellCodec):
    """Reads only the scores of a cell, and opens no file whose hash is known already.

    Parameters
    ----------
    known : Scores by the SHA-256 of the file's content.
    """

    def __init__(self, known: Mapping[str, BothScores]) -> None:
        self._known = known

    def decode(self, content: bytes, case: PlannedCell) -> tuple[str, BothScores]:  # type: ignore[override]
        """Return the hash of the content, and the scores."""
        del case
        sha256 = hashlib.sha256(content).hexdigest()
        return sha256, self._known.get(sha256) or scores_of(*read_netcdf(content))


def scores_of(arrays: Mapping[str, npt.NDArray[Any]], attributes: Mapping[str, Any]) -> BothScores:
    """Return the scores in a cell's file, in their own units.

    Parameters
    ----------
    arrays, attributes : Variables and attributes of the file.
    """
    free, room = (
        Scores(**{name: float(arrays[name][i]) for name in SCORE_NAMES})
        if int(attributes[flag])
        else None
        for i, flag in enumerate(("has_free_scores", "has_room_scores"))
    )
    return free, room


def run_sweep(
    plan: SweepPlan, folder: Path, *, crew: Crew | None = None, progress: Progress | None = None
) -> tuple[Cell, ...]:
    """Return the cells of a plan in its order, read from their files or computed and kept.

    A cell without scores carries the reason. A design that cannot be built is a result; any other
    failure is tried again by the next run.

    Parameters
    ----------
    plan : From :func:`octant.reader_design.experiments.sweep.plan.plan_sweep`.
    folder : Where the cells' files lie; made when missing.
    crew : Computes them; None: this process.
    progress : Shows cells and failures.
    """
    kept = map_cases(
        compute_cell,
        plan.cells,
        context=None,
        folder=folder,
        codec=CellCodec(),
        leave_out=LEFT_OUT,
        crew=crew,
        progress=progress,
        label="designs",
        name=label_of,
    )
    return tuple(_cell(planned, one) for planned, one in zip(plan.cells, kept, strict=True))


def label_of(planned: PlannedCell) -> str:
    """Return a cell's human name.

    Parameters
    ----------
    planned : The cell.
    """
    return planned.label


def _cell(planned: PlannedCell, kept: Kept[Cell]) -> Cell:
    if kept.record is not None:
        return replace(kept.record, key=planned.key, label=planned.label, seconds=kept.seconds)
    failed = failed_cell(planned.design, planned.key, kept.reason, unexpected=kept.unexpected)
    return replace(failed, label=planned.label, seconds=kept.seconds)
