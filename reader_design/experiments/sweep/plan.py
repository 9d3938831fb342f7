"""What a sweep will compute: every combination of its values as a study of its own, and its name.

Nothing is meshed and no field is computed; rooms are built, each different one once, because a
cell's name holds every vertex that the radio model sees.
"""

import itertools
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import msgspec

from octant.geometries.errors import InfeasibleDesignError, OctantError
from octant.reader_design.keeping.keys import case_keys
from octant.reader_design.setting.evaluation import Cell, scored_cell
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.study_file.loading import vary
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.schema import Study
from octant.reader_design.study_file.sweep import (
    expanded,
    parameter_paths,
    parameter_unit,
    put,
)

IN_EVERY_LABEL = ("antenna", "antenna_radius_m", "plate_height_m")
"""Parameters that a design's own label names."""

SHOWN = {"m": (100.0, "cm"), "Hz": (1e-9, "GHz")}
"""Factor and unit in which labels show a reader's lengths, and frequencies."""


LEFT_OUT = (
    "PlannedCell.values",
    "PlannedCell.label",
    "PlannedCell.key",
    "Setting.layout",
    "Setting.notes",
    "Setting.map_z_m",
    *(
        f"Study.{table}"
        for table in (
            "name", "sweep", "choice", "map", "mission", "sensor", "track", "dock", "optimise",
            "tolerance", "layouts", "report",
        )
    ),
)  # fmt: skip
"""What cannot change a cell, so that its key does not contain it. Of the mission only the first tag
matters: it is ``PlannedCell.reference``."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedCell:
    """One cell that a sweep will compute.

    Attributes
    ----------
    values : Value of every swept parameter, in the unit of its key ([m], [Hz], ...).
    label : Human name, with every swept parameter.
    key : Hash of its full input.
    design : The reader.
    setting : The reader in its room, and the sampling; those of the whole sweep where the cell was
        refused.
    reference : Id of the tag that the scores in free space use; empty without one.
    reason : Why these values cannot be together; empty when they can.
    """

    values: Mapping[str, Any]
    label: str
    key: str = ""
    design: Reader
    setting: Setting
    reference: str = ""
    reason: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepPlan:
    """What a sweep will compute.

    Attributes
    ----------
    setting : The study as it stands, its room and the sampling.
    cells : Every combination; the first parameter varies slowest.
    """

    setting: Setting
    cells: tuple[PlannedCell, ...]

    @property
    def designs(self) -> tuple[Reader, ...]:
        """The reader of each cell, lengths in [m]."""
        return tuple(cell.design for cell in self.cells)

    @property
    def keys(self) -> tuple[str, ...]:
        """The name of each cell."""
        return tuple(cell.key for cell in self.cells)


def combinations(study: Study) -> tuple[dict[str, Any], ...]:
    """Return every combination of a sweep's values [m], [Hz]; the first parameter varies slowest.

    Parameters
    ----------
    study : With its sweep; without one, the only combination is empty.
    """
    lists = expanded(study.sweep)
    return tuple(
        dict(zip(lists, values, strict=True)) for values in itertools.product(*lists.values())
    )


def plan_sweep(setting: Setting) -> SweepPlan:
    """Return the cells that a study asks for; lengths in [m].

    Parameters
    ----------
    setting : Study, room and sampling.
    """
    rooms: dict[bytes, Setting | OctantError] = {}
    rooms[_room_inputs(setting.study)] = setting
    cells = [_planned(setting, values, rooms) for values in combinations(setting.study)]
    keys = case_keys(compute_cell, cells, context=None, leave_out=LEFT_OUT)
    named = (replace(cell, key=key) for cell, key in zip(cells, keys, strict=True))
    return SweepPlan(setting=setting, cells=tuple(named))


def compute_cell(_context: None, planned: PlannedCell) -> Cell:
    """Return the scores and RSS [W] of a planned cell, or refuse it with an OctantError.

    Cells share no context: a sweep may vary the room too.

    Parameters
    ----------
    planned : The cell.
    """
    if planned.reason:
        raise InfeasibleDesignError(planned.reason)
    return scored_cell(planned.setting)


def _planned(
    setting: Setting,
    values: dict[str, Any],
    rooms: dict[bytes, Setting | OctantError],
) -> PlannedCell:
    design = _design(setting.study, values)
    label = cell_label(design, values)
    try:
        study = vary(setting.study, values, shapes=False) if values else setting.study
        there = replace(
            _room(study, rooms),
            study=study,
            sampling=setting.sampling,
            usable_dbm=setting.usable_dbm,
        )
    except OctantError as exc:
        return PlannedCell(
            values=values, label=label, design=design, setting=setting, reason=str(exc)
        )
    return PlannedCell(
        values=values,
        label=label,
        design=design,
        setting=there,
        reference=there.reference_tag.id if there.tags else "",
    )


def _design(study: Study, values: dict[str, Any]) -> Reader:
    return msgspec.convert(put(study, values), Study).reader


def _room_inputs(study: Study) -> bytes:
    heights_m = (study.reader.height_m, study.map.height_m)
    return msgspec.json.encode([study.radio, study.room, study.tags, study.solver, heights_m])


def _room(study: Study, rooms: dict[bytes, Setting | OctantError]) -> Setting:
    """Return a study's room, built once for all cells that share it."""
    inputs = _room_inputs(study)
    if inputs not in rooms:
        try:
            # Where a mission starts does not matter to scores.
            rooms[inputs] = build_setting(msgspec.structs.replace(study, mission=None))
        except OctantError as exc:
            rooms[inputs] = exc
    known = rooms[inputs]
    if isinstance(known, OctantError):
        raise known
    return known


def cell_label(design: Reader, values: Mapping[str, Any]) -> str:
    """Return a cell's human name, such as ``dipole r_a = 10 cm h_p = 8 cm gap = 0.5 cm``.

    Parameters
    ----------
    design : Names antenna, r_a and h_p.
    values : Swept parameters, in the units of their keys ([m], [Hz], ...); the others are named.
    """
    paths = parameter_paths()
    parts = [
        _parameter_text(name, value)
        for name, value in values.items()
        if paths[name][-1] not in IN_EVERY_LABEL or paths[name][0] != "reader"
    ]
    return " ".join([design.label(), *parts])


def _parameter_text(name: str, value: Any) -> str:  # noqa: ANN401  any value of a study
    unit = parameter_unit(name)
    factor, shown = SHOWN.get(unit, (1.0, unit))
    if unit == "m" and parameter_paths()[name][0] != "reader":
        factor, shown = 1.0, unit
    word = name.removeprefix("reader.")
    for ending in (f"_{unit}", f"_{unit.lower()}"):
        word = word.removesuffix(ending)
    return f"{word.replace('_', ' ')} = {_value_text(value, factor)} {shown}".rstrip()


def _value_text(value: Any, factor: float) -> str:  # noqa: ANN401  any value of a study
    if isinstance(value, bool) or not isinstance(value, int | float | list):
        return value if isinstance(value, str) else json.dumps(value, sort_keys=True)
    if isinstance(value, list):
        return "(" + ", ".join(_value_text(item, factor) for item in value) + ")"
    return f"{factor * value:.6g}"
