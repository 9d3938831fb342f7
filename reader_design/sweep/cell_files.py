"""The file of one sweep cell: netCDF with units, checked when it is read back."""

import hashlib
import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError, SweepStateError
from octant.reader_design.config.loading import to_toml
from octant.reader_design.store import dataset, read_dataset, variable, write_dataset
from octant.reader_design.sweep.cells import Cell, SweepContext
from octant.reader_design.sweep.design import ReaderDesign, canonical_json
from octant.reader_design.sweep.samples import grid_azimuths_rad
from octant.reader_design.sweep.scores import SCORE_NAMES, Scores, score_unit

if TYPE_CHECKING:
    import xarray as xr

SURROUNDINGS = ("free_space", "room")
"""Where a design is scored; the coordinate ``surrounding`` of every score."""


def _digest(cell: Cell) -> str:
    """Return a hash of a cell's numbers and words, by which a damaged file is found out."""
    digest = hashlib.sha256()
    for array in (cell.distances_m, cell.free_rss_w, cell.travel_m, cell.travel_rss_w):
        digest.update(np.ascontiguousarray(array).tobytes())
    scores = [s.as_dict() if s is not None else None for s in (cell.free, cell.room)]
    text = canonical_json([cell.key, cell.reason, list(cell.notes), cell.seconds, scores])
    digest.update(text.encode())
    return digest.hexdigest()


def score_variables(
    rows: list[tuple[Scores | None, Scores | None]], *, dim: str | None
) -> "dict[str, xr.Variable]":
    """Return one variable for each score, by design and surrounding, in the score's own unit [-].

    Parameters
    ----------
    rows : list of (Scores or None, Scores or None)
        Scores in free space and in the room; None becomes NaN.
    dim : str or None
        Name of the dimension of the rows; None when there is one row and no such dimension.

    Returns
    -------
    dict of str to xarray.Variable
        With units and names.
    """
    out = {}
    for name in SCORE_NAMES:
        table: npt.NDArray[np.float64] = np.array(
            [[np.nan if s is None else getattr(s, name) for s in row] for row in rows]
        )
        out[name] = variable(
            ["surrounding"] if dim is None else [dim, "surrounding"],
            table[0] if dim is None else table,
            units=score_unit(name),
            long_name=name.rsplit("_" + score_unit(name), 1)[0].replace("_", " "),
        )
    return out


def surrounding_variable() -> "xr.Variable":
    """Return the coordinate that names where scores hold [-].

    Returns
    -------
    xarray.Variable
        ``free_space`` and ``room``.
    """
    return variable(
        ["surrounding"], list(SURROUNDINGS), units="1", long_name="where the design is scored"
    )


def write_cell(path: Path, cell: Cell, context: SweepContext) -> None:
    """Return nothing; write a cell whole or not at all; powers in [W].

    Parameters
    ----------
    path : Path
        Its file.
    cell : Cell
        The cell.
    context : SweepContext
        The study, for the attributes.

    Raises
    ------
    ConfigError
        When the folder cannot be written to.
    """
    count = cell.free_rss_w.shape[1]
    azimuths = np.degrees(grid_azimuths_rad(1, count)) if count else np.zeros(0)
    variables = {
        "free_rss_w": variable(
            ["distance", "azimuth", "antenna"],
            cell.free_rss_w,
            units="W",
            long_name="RSS in free space",
        ),
        "travel_rss_w": variable(
            ["travel", "antenna"],
            cell.travel_rss_w,
            units="W",
            long_name="RSS in free space, antenna 1 towards the tag",
        ),
        **score_variables([(cell.free, cell.room)], dim=None),
    }
    coordinates = {
        "distance": variable(
            ["distance"], cell.distances_m, units="m", long_name="horizontal distance to the tag"
        ),
        "azimuth": variable(
            ["azimuth"], azimuths, units="deg", long_name="azimuth of the tag in the reader frame"
        ),
        "travel": variable(
            ["travel"], cell.travel_m, units="m", long_name="horizontal distance to the tag"
        ),
        "antenna": variable(
            ["antenna"],
            np.arange(1, cell.free_rss_w.shape[2] + 1),
            units="1",
            long_name="number of the antenna",
        ),
        "surrounding": surrounding_variable(),
    }
    data = dataset(
        variables,
        coordinates=coordinates,
        study_toml=to_toml(context.study),
        seed=context.study.seed,
        title=f"sweep cell: {cell.design.label()}",
        attributes={
            "cell_key": cell.key,
            "design": canonical_json(cell.design.as_dict()),
            "failed_because": cell.reason,
            "has_free_scores": int(cell.free is not None),
            "has_room_scores": int(cell.room is not None),
            "notes": json.dumps(cell.notes),
            "seconds": cell.seconds,
            "digest": _digest(cell),
        },
    )
    write_dataset(data, path, force=True)


def read_cell(path: Path, design: ReaderDesign, key: str) -> Cell:
    """Return the cell of a file, checked against the key and its own digest; powers in [W].

    Parameters
    ----------
    path : Path
        Its file.
    design : ReaderDesign
        The design that the key stands for.
    key : str
        Expected name of the cell.

    Returns
    -------
    Cell
        As it was written, bit by bit.

    Raises
    ------
    SweepStateError
        When the file cannot be read, is damaged, or belongs to another cell.
    """
    try:
        data = read_dataset(path)
        scores = [
            Scores(**{name: float(data[name].values[i]) for name in SCORE_NAMES})
            if int(data.attrs[flag])
            else None
            for i, flag in enumerate(("has_free_scores", "has_room_scores"))
        ]
        cell = Cell(
            key=str(data.attrs["cell_key"]),
            design=design,
            reason=str(data.attrs["failed_because"]),
            free=scores[0],
            room=scores[1],
            distances_m=data["distance"].values,
            free_rss_w=data["free_rss_w"].values,
            travel_m=data["travel"].values,
            travel_rss_w=data["travel_rss_w"].values,
            notes=tuple(json.loads(data.attrs["notes"])),
            seconds=float(data.attrs["seconds"]),
        )
        told = str(data.attrs["digest"])
    except (ConfigError, KeyError, ValueError, OSError, RuntimeError) as exc:
        msg = f"the cell file {path} cannot be read ({exc}); delete it, or let it be overwritten."
        raise SweepStateError(msg) from exc
    if cell.key != key or told != _digest(cell):
        msg = f"the cell file {path} is damaged or another design's; delete it."
        raise SweepStateError(msg)
    return cell
