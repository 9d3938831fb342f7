"""The file of one sweep cell: netCDF with units, checked when it is read back."""

import hashlib
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError, SweepStateError
from octant.geometries.files import whole_file
from octant.reader_design.keeping.small_netcdf import Stored, netcdf_bytes, read_netcdf
from octant.reader_design.keeping.versions import versions
from octant.reader_design.setting.design import ReaderDesign, canonical_json
from octant.reader_design.setting.evaluation import Cell, SweepContext
from octant.reader_design.setting.samples import grid_azimuths_rad
from octant.reader_design.showing.netcdf import variable
from octant.reader_design.study_file.loading import to_toml
from octant.reader_design.study_file.scores import (
    SCORE_NAMES,
    Scores,
    score_unit,
)

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
    told = [cell.key, cell.reason, cell.unexpected, list(cell.notes), cell.seconds, scores]
    digest.update(canonical_json(told).encode())
    return digest.hexdigest()


def stored_scores(
    rows: list[tuple[Scores | None, Scores | None]], *, dim: str | None
) -> dict[str, Stored]:
    """Return one variable for each score, by design and surrounding, in the score's own unit.

    Parameters
    ----------
    rows : list of (Scores or None, Scores or None)
        Scores in free space and in the room; None becomes NaN.
    dim : str or None
        Name of the dimension of the rows; None when there is one row and no such dimension.

    Returns
    -------
    dict of str to (dimensions, values, units, long name)
        With units and names.
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
    """Return the coordinate that names where scores hold.

    Returns
    -------
    (dimensions, values, units, long name)
        ``free_space`` and ``room``.
    """
    return ["surrounding"], list(SURROUNDINGS), "1", "where the design is scored"


def as_variables(stored: dict[str, Stored]) -> "dict[str, xr.Variable]":
    """Return stored variables as those of xarray, units unchanged.

    Parameters
    ----------
    stored : dict of str to (dimensions, values, units, long name)
        From :func:`stored_scores`, for example.

    Returns
    -------
    dict of str to xarray.Variable
        With ``units`` and ``long_name``.
    """
    return {
        name: variable(dims, values, units=units, long_name=long_name)
        for name, (dims, values, units, long_name) in stored.items()
    }


def cell_bytes(cell: Cell, context: SweepContext) -> bytes:
    """Return the content of a cell's file; powers in [W].

    Parameters
    ----------
    cell : Cell
        The cell.
    context : SweepContext
        Its study, for the attributes.

    Returns
    -------
    bytes
        netCDF4 that xarray opens.
    """
    _, count, antennas = cell.free_rss_w.shape
    azimuths = np.degrees(grid_azimuths_rad(1, count)) if count else np.zeros(0)
    away = "horizontal distance to the tag"
    facing = "RSS in free space, antenna 1 towards the tag"
    stored: dict[str, Stored] = {
        "distance": (["distance"], cell.distances_m, "m", away),
        "azimuth": (["azimuth"], azimuths, "deg", "azimuth of the tag in the reader frame"),
        "travel": (["travel"], cell.travel_m, "m", away),
        "antenna": (["antenna"], np.arange(1, antennas + 1), "1", "number of the antenna"),
        "surrounding": stored_surroundings(),
        "free_rss_w": (
            ["distance", "azimuth", "antenna"],
            cell.free_rss_w,
            "W",
            "RSS in free space",
        ),
        "travel_rss_w": (["travel", "antenna"], cell.travel_rss_w, "W", facing),
        **stored_scores([(cell.free, cell.room)], dim=None),
    }
    attributes: dict[str, str | int | float] = {
        "title": f"sweep cell: {cell.label}",
        "study": to_toml(context.study),
        "seed": context.study.seed,
        **versions(),
        "cell_key": cell.key,
        "design": canonical_json(cell.design.as_dict()),
        "failed_because": cell.reason,
        "unexpected": int(cell.unexpected),
        "has_free_scores": int(cell.free is not None),
        "has_room_scores": int(cell.room is not None),
        "notes": json.dumps(cell.notes),
        "seconds": cell.seconds,
        "digest": _digest(cell),
    }
    return netcdf_bytes(stored, attributes)


def put_bytes(path: Path, content: bytes) -> None:
    """Return nothing; write a file of a sweep whole or not at all.

    Parameters
    ----------
    path : Path
        The file.
    content : bytes
        All of it.

    Raises
    ------
    ConfigError
        When the folder cannot be written to, or the disk is full.
    """
    try:
        with whole_file(path) as part:
            part.write_bytes(content)
    except OSError as exc:
        msg = (
            f"{path} cannot be written ({exc.strerror or exc}); make room for it or give another "
            "folder: what was computed before is kept, and the same command goes on from there."
        )
        raise ConfigError(msg) from exc


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
        content = path.read_bytes()
    except OSError as exc:
        raise SweepStateError(_unreadable(path, exc)) from exc
    return cell_of_bytes(content, path, design, key)


def cell_of_bytes(content: bytes, path: Path, design: ReaderDesign, key: str) -> Cell:
    """Return the cell of a file's content, checked as by :func:`read_cell`; powers in [W].

    Parameters
    ----------
    content : bytes
        All of the file.
    path : Path
        Where it lies, for messages.
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
        As :func:`read_cell`.
    """
    try:
        arrays, attributes = read_netcdf(content)
        cell = _cell(arrays, attributes, design)
        told = str(attributes["digest"])
    except (KeyError, ValueError, TypeError, OSError, RuntimeError) as exc:
        raise SweepStateError(_unreadable(path, exc)) from exc
    if cell.key != key or told != _digest(cell):
        msg = f"the cell file {path} is damaged or another design's; delete it."
        raise SweepStateError(msg)
    return cell


def _cell(
    arrays: dict[str, npt.NDArray[Any]], attributes: dict[str, Any], design: ReaderDesign
) -> Cell:
    free, room = (
        Scores(**{name: float(arrays[name][i]) for name in SCORE_NAMES})
        if int(attributes[flag])
        else None
        for i, flag in enumerate(("has_free_scores", "has_room_scores"))
    )
    return Cell(
        key=str(attributes["cell_key"]),
        design=design,
        reason=str(attributes["failed_because"]),
        free=free,
        room=room,
        distances_m=arrays["distance"],
        free_rss_w=arrays["free_rss_w"],
        travel_m=arrays["travel"],
        travel_rss_w=arrays["travel_rss_w"],
        notes=tuple(json.loads(attributes["notes"])),
        seconds=float(attributes["seconds"]),
        unexpected=bool(int(attributes["unexpected"])),
    )


def _unreadable(path: Path, exc: Exception) -> str:
    what = " ".join(str(exc).split())
    return f"the cell file {path} cannot be read ({what}); delete it, or let it be overwritten."
