"""The one results file of a study: scores, RSS of all designs, maps and missions, with names."""

import json
from dataclasses import asdict
from typing import TYPE_CHECKING

import msgspec
import numpy as np
import numpy.typing as npt

from octant.reader_design.experiments.missions.stage import RoomMission
from octant.reader_design.experiments.study.content import StudyContent
from octant.reader_design.experiments.sweep.cells import stored_scores, stored_surroundings
from octant.reader_design.keeping.small_netcdf import Stored
from octant.reader_design.setting.design import canonical_json
from octant.reader_design.setting.samples import grid_azimuths_rad
from octant.reader_design.showing.netcdf import dataset, variable
from octant.reader_design.study_file.scores import SCORE_NAMES

if TYPE_CHECKING:
    import xarray as xr

FloatArray = npt.NDArray[np.float64]

PER_RUN = (
    "success",
    "captured",
    "collided",
    "time_s",
    "path_m",
    "rmse_m",
    "p90_position_m",
    "p90_heading_rad",
    "arrival_error_m",
)
"""Variables of a mission by run; in the results they have a dimension ``place`` before it."""
PER_STEP = (
    "t_s",
    "x_m",
    "y_m",
    "heading_rad",
    "target",
    "position_error_m",
    "heading_error_rad",
    "rss_w",
)
"""Variables of run 0 by step; shorter runs are filled with NaN."""


def study_dataset(content: StudyContent, room_map: "xr.Dataset") -> "xr.Dataset":
    """Return everything that a study computed, each variable with its unit ([W], [m], [rad],).

    Dimensions: design, surrounding, distance, azimuth, travel, antenna, tag, x, y, place, run,
    step.

    Parameters
    ----------
    content, room_map : Cells, choice and missions; maps of the chosen reader.
    """
    maps = room_map
    coordinates = {
        **_sweep_coordinates(content),
        **{name: maps[name].variable for name in ("x", "y", "tag")},
    }
    renamed = {"rss_w": "map_rss_w", "local_mean_rss_w": "map_local_mean_rss_w"}
    variables = {
        **_sweep_variables(content),
        **{
            renamed.get(str(name), f"map_{name}"): maps[name].variable
            for name in maps.data_vars
            if name != "sample_rss_w" and not str(name).startswith("turned_")
        },
    }
    if "sample_rss_w" in maps:
        variables["sample_rss_w"] = maps["sample_rss_w"].variable
        coordinates["sample_azimuth"] = maps["sample_azimuth"].variable
    if content.missions:
        variables |= _mission_variables(content.missions, content.chosen_cell.design.antennas)
        coordinates["place"] = variable(
            ["place"], [m.name for m in content.missions], units="1", long_name="room of missions"
        )
    return dataset(
        variables,
        coordinates=coordinates,
        study_toml=content.study_toml,
        seed=content.setting.study.seed,
        title=f"Octant study {content.setting.study.name}",
        attributes={
            "chosen_design": content.chosen.label,
            "verdict": msgspec.json.encode(content.verdict).decode(),
            "reason": json.dumps(content.choice.reason),
            "notes": json.dumps(content.notes),
            "map_heading_deg": float(maps.attrs["heading_deg"]),
            "quick": int(content.quick),
            "response": content.setting.study.reader.response,
            "approximations": json.dumps([asdict(e) for e in content.approximations]),
            "thesis_claims": json.dumps([asdict(c) for c in content.claims]),
        },
    )


def design_table(
    content: StudyContent,
) -> tuple[tuple[str, ...], tuple[tuple[object, ...], ...]]:
    """Return header, with units, and rows of designs.csv in the sweep's order; no value: empty.

    Parameters
    ----------
    content : Cells and choice.
    """
    ranks = {
        content.candidates[index].key: place
        for place, index in enumerate(content.choice.ranking, 1)
    }
    parameters = tuple(content.cells[0].design.as_dict())
    scores = tuple(f"{place}_{name}" for place in ("free", "room") for name in SCORE_NAMES)
    header = ("rank", *parameters, "failed_because", *scores)
    rows = []
    for cell in content.cells:
        given = cell.design.as_dict()
        values: list[object] = [ranks.get(cell.key, ""), *(given[name] for name in parameters)]
        values.append(cell.reason)
        for one in (cell.free, cell.room):
            values += [""] * len(SCORE_NAMES) if one is None else list(one.as_dict().values())
        rows.append(tuple("" if value is None else value for value in values))
    return header, tuple(rows)


def _sweep_coordinates(content: StudyContent) -> "dict[str, xr.Variable]":
    cell = content.chosen_cell
    count = cell.free_rss_w.shape[1]
    labels = [c.label for c in content.cells]
    return {
        "design": variable(["design"], labels, units="1", long_name="design"),
        **_variables({"surrounding": stored_surroundings()}),
        "distance": variable(
            ["distance"], cell.distances_m, units="m", long_name="horizontal distance to the tag"
        ),
        "azimuth": variable(
            ["azimuth"],
            np.degrees(grid_azimuths_rad(1, count)),
            units="deg",
            long_name="azimuth of the tag in the reader frame",
        ),
        "travel": variable(
            ["travel"], cell.travel_m, units="m", long_name="horizontal distance to the tag"
        ),
        "antenna": variable(
            ["antenna"],
            np.arange(1, content.chosen_cell.design.antennas + 1),
            units="1",
            long_name="number of the antenna",
        ),
    }


def _sweep_variables(content: StudyContent) -> "dict[str, xr.Variable]":
    cells = content.cells
    rank = np.full(len(cells), -1, dtype=np.int64)
    place = {c.key: i for i, c in enumerate(cells)}
    for position, index in enumerate(content.choice.ranking):
        rank[place[content.candidates[index].key]] = position + 1

    def filled(name: str) -> FloatArray:
        shape = getattr(content.chosen_cell, name).shape
        rows = [getattr(c, name) for c in cells]
        return np.array([row if row.shape == shape else np.full(shape, np.nan) for row in rows])

    return {
        "antenna_radius_m": variable(
            ["design"], [c.design.antenna_radius_m for c in cells], units="m", long_name="r_a"
        ),
        "plate_height_m": variable(
            ["design"], [c.design.plate_height_m for c in cells], units="m", long_name="h_p"
        ),
        "antenna_kind": variable(
            ["design"], [c.design.antenna_kind for c in cells], units="1", long_name="antenna type"
        ),
        "design_parameters": variable(
            ["design"],
            [canonical_json(c.design.as_dict()) for c in cells],
            units="1",
            long_name="all parameters of the design, as JSON",
        ),
        "cell_key": variable(
            ["design"], [c.key for c in cells], units="1", long_name="hash of the cell's input"
        ),
        "failed_because": variable(
            ["design"], [c.reason for c in cells], units="1", long_name="why there are no scores"
        ),
        "rank": variable(["design"], rank, units="1", long_name="place in the ranking, -1 if none"),
        "free_rss_w": variable(
            ["design", "distance", "azimuth", "antenna"],
            filled("free_rss_w"),
            units="W",
            long_name="RSS in free space, of designs with as many antennas as the chosen one",
            missing="failed, or another number of antennas",
        ),
        "travel_rss_w": variable(
            ["design", "travel", "antenna"],
            filled("travel_rss_w"),
            units="W",
            long_name="RSS in free space, antenna 1 towards the tag",
            missing="failed, or another number of antennas",
        ),
        **_variables(stored_scores([(c.free, c.room) for c in cells], dim="design")),
    }


def _variables(stored: dict[str, Stored]) -> "dict[str, xr.Variable]":
    return {
        name: variable(dims, values, units=units, long_name=long_name, missing="no score")
        for name, (dims, values, units, long_name) in stored.items()
    }


def _mission_variables(
    missions: tuple[RoomMission, ...], antennas: int
) -> "dict[str, xr.Variable]":
    driven = [m.data for m in missions if m.data is not None]
    if not driven:
        return {}
    out = {}
    for name in (*PER_RUN, *PER_STEP):
        first = driven[0][name]
        axis = "run" if name in PER_RUN else "step"
        length = max(d.sizes[axis] for d in driven)
        rest = [antennas if dim == "antenna" else first.sizes[dim] for dim in first.dims[1:]]
        table = np.full((len(missions), length, *rest), np.nan)
        for row, mission in zip(table, missions, strict=True):
            if mission.data is not None:
                values = mission.data[name].values
                row[: len(values)] = values
        out[f"mission_{name}"] = variable(
            ["place", axis, *map(str, first.dims[1:])],
            table,
            units=str(first.attrs["units"]),
            long_name=str(first.attrs["long_name"]),
            missing="not driven, already ended, or without such a value",
        )
    return out
