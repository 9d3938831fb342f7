"""Anchors out of a table of their own: names and places, with heights or without."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.navigation.logs.forms import TableForm
from octant.navigation.logs.frames import Frame
from octant.navigation.logs.text_tables import ABSENT, TextTable, read_text_table

_NAMES = {
    "id": ("id", "anchor", "anchor_id", "tag", "mac", "bssid", "ap", "beacon", "name"),
    "x": ("x", "x_m", "pos_x", "x_cm", "x_mm"),
    "y": ("y", "y_m", "pos_y", "y_cm", "y_mm"),
    "z": ("z", "z_m", "pos_z", "height", "height_m", "z_cm", "z_mm"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Anchor:
    """A fixed source.

    Parameters
    ----------
    id : Its name in the log.
    position_m : (3,) tuple of float — Its place in the room [m].
    """

    id: str
    position_m: tuple[float, float, float]


def read_anchors(
    path: Path, form: TableForm, frame: Frame, *, height_m: float | None
) -> tuple[Anchor, ...]:
    """Return the anchors of a table, in the room's frame.

    Its columns are found by their usual names, id, x, y and z for example, case aside.

    Parameters
    ----------
    path : A file with a row an anchor.
    form : Unit of lengths, and names in the log, as of the log itself.
    frame : How the log's places lie in the room.
    height_m : Height coordinate of anchors that have none [m]; None: that is refused.
    """
    table = read_text_table(path, separator=form.separator, what="a list of anchors")
    names = {what: _column(table, what, needed=what != "z") for what in _NAMES}
    ids = table.texts(str(names["id"]))
    x, y = (_numbers(table, str(names[what]), form) for what in ("x", "y"))
    z = np.full(len(table), np.nan)
    if names["z"] is not None:
        z = form.metres * table.numbers(names["z"])
    if np.isnan(z).any():
        if height_m is None:
            row = int(np.flatnonzero(np.isnan(z))[0])
            msg = (
                f"{path}:{table.lines[row]}: the anchor {ids[row]!r} has no height; give one for "
                "those without by log.anchor_height_m."
            )
            raise ConfigError(msg)
        z = np.where(np.isnan(z), height_m, z)
    places = frame.places_m(np.column_stack([x, y]))
    found: dict[str, Anchor] = {}
    for row, name in enumerate(ids):
        if name.casefold() in ABSENT or name in found:
            why = "a second time" if name in found else "as none"
            msg = (
                f"{path}:{table.lines[row]}: names the anchor {name!r} {why}; give each its own id."
            )
            raise ConfigError(msg)
        position = (float(places[row, 0]), float(places[row, 1]), float(z[row]))
        found[name] = Anchor(id=form.ids.get(name, name), position_m=position)
    return tuple(found.values())


def _column(table: TextTable, what: str, *, needed: bool) -> str | None:
    folded = {name.casefold(): name for name in table.header}
    hit = next((folded[name] for name in _NAMES[what] if name in folded), None)
    if hit is None and needed:
        table.place(what)  # refuses with the nearest name
    return hit


def _numbers(table: TextTable, name: str, form: TableForm) -> npt.NDArray[np.float64]:
    values = table.numbers(name)
    table.check(name, np.isfinite(values), "a number is needed")
    return form.metres * values
