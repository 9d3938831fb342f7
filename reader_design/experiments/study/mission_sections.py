"""What a report says about missions: of the chosen reader, and of the short list."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from octant.navigation.missions.summary import length_text
from octant.navigation.statistics import wilson
from octant.reader_design.experiments.missions.stage import RoomMission
from octant.reader_design.experiments.study.shortlist import DrivenDesign
from octant.reader_design.setting.ranking import Candidate, Choice
from octant.reader_design.setting.robot import study_robot
from octant.reader_design.showing.drive_view import drive_widget
from octant.reader_design.showing.pages import (
    FigureFiles,
    ReportSection,
    ReportTable,
    embedded_figures,
)
from octant.reader_design.showing.plan import plan_of
from octant.reader_design.study_file.mission import Mission

if TYPE_CHECKING:
    import xarray as xr


WAYS = "^trajectory"
"""Figure that the playback stands for."""


def mission_sentence(mission: RoomMission) -> str:
    """Return how the runs in one room ended, in one sentence with [m] and [s].

    Parameters
    ----------
    mission : The runs.
    """
    if mission.data is None:
        return f"Mission in {mission.name}: it could not be driven: {mission.reason}"
    data = mission.data
    success = data["success"].values.astype(bool)
    text = f"Mission in {mission.name}: "
    if success.any():
        rmse_m, within_m = (
            float(np.median(data[name].values[success])) for name in ("rmse_m", "p90_position_m")
        )
        text += (
            f"{int(success.sum())} of {success.size} runs reached every tag, "
            f"{length_text(rmse_m)} (rms) from the straight way and 90 % of the time within "
            f"{length_text(within_m)} (medians over these runs)"
        )
    if mission.advice is None:
        return f"{text}."
    said = mission.advice.sentence
    return f"{text}. {said}" if success.any() else f"{text}{said[0].lower()}{said[1:]}"


def _medians(data: "xr.Dataset", name: str, digits: int) -> str:
    """Return a median over the runs that reached every tag, and over all."""
    values, success = data[name].values, data["success"].values.astype(bool)
    good = f"{np.median(values[success]):.{digits}f}" if success.any() else "–"
    return f"{good} / {np.median(values):.{digits}f}"


def mission_section(
    missions: Sequence[RoomMission],
    table: Mission | None,
    figures: FigureFiles,
) -> ReportSection | None:
    """Return what the chosen reader's missions came to ([m], [s], [deg]); None: nothing driven.

    Parameters
    ----------
    missions, table, figures : Of the chosen design; the study's mission; figures by section.
    """
    if table is None or not missions:
        return None
    header = (
        "room",
        "runs",
        "reached every tag",
        "at a wrong place, or held there",
        "touched something",
        "RMSE [m]",
        "worst RMSE [m]",
        "90 % position [m]",
        "90 % heading [°]",
        "arrival error [m]",
        "time [s]",
        "way [m]",
    )
    rows = []
    for mission in missions:
        if mission.data is None:
            rows.append((mission.name, "0", *["–"] * (len(header) - 2)))
            continue
        d = mission.data
        arrivals = d["arrival_error_m"].values
        good = arrivals[d["success"].values.astype(bool)]
        arrival = " / ".join(
            f"{np.nanmedian(some):.2f}" if np.isfinite(some).any() else "–"
            for some in (good, arrivals)
        )
        rows.append(
            (
                mission.name,
                str(d.sizes["run"]),
                *(str(int(d[n].values.sum())) for n in ("success", "captured", "collided")),
                _medians(d, "rmse_m", 3),
                f"{np.max(d['rmse_m'].values):.3f}",
                _medians(d, "p90_position_m", 3),
                _medians(d.assign(deg=np.degrees(d["p90_heading_rad"])), "deg", 1),
                arrival,
                _medians(d, "time_s", 0),
                _medians(d, "path_m", 2),
            )
        )
    return ReportSection(
        heading="Missions",
        paragraphs=(
            (
                f"The robot visits {len(table.tags)} tag{'s' if len(table.tags) > 1 else ''} with "
                f"the navigator “{table.navigator}” and {table.noise_db:g} dB of noise on each "
                "reading."
            ),
            *(mission_sentence(m) for m in missions),
        ),
        widgets=tuple(
            drive_widget(
                m.setting,
                plan_of(m.setting.scene, m.setting.reader_z_m),
                m.results,
                radius_m=study_robot(m.setting.study, "mission").radius_m,
                name="" if len(missions) == 1 else m.name,
                fallback=embedded_figures(figures, "mission", only=WAYS) if k == 0 else (),
            )
            for k, m in enumerate(missions)
            if m.results and m.setting is not None
        ),
        tables=(
            ReportTable(
                caption="All runs, room by room. Errors are distances to the straight segment "
                "between consecutive tags; medians over the runs that reached every tag / over "
                "all, unless the column says otherwise.",
                header=header,
                rows=tuple(rows),
                first=8,
            ),
        ),
        figures=embedded_figures(figures, "mission", without=WAYS),
    )


def driven_texts(
    candidates: Sequence[Candidate], driven: Sequence[DrivenDesign]
) -> dict[str, tuple[str, ...]]:
    """Return how many runs of each candidate reached every tag, by the heading of the room.

    Parameters
    ----------
    candidates, driven : Scored designs, and those that drove the missions.
    """
    missions = {d.index: d.missions for d in driven}
    names = [m.name for m in driven[0].missions] if driven else []
    return {
        f"every tag reached, {name}": tuple(
            _reached(missions.get(index, ()), k) for index in range(len(candidates))
        )
        for k, name in enumerate(names)
    }


def _reached(missions: Sequence[RoomMission], number: int) -> str:
    if not missions:
        return "not driven"
    data = missions[number].data
    if data is None:
        return "could not drive"
    success = data["success"].values
    return f"{int(success.sum())} of {success.size}"


def shortlist_table(
    candidates: Sequence[Candidate], choice: Choice, driven: Sequence[DrivenDesign]
) -> ReportTable:
    """Return the best designs with size, scores, missions and reason ([cm], [%], [deg], [m]).

    Parameters
    ----------
    candidates, choice, driven : Scored designs, ranking, those that drove the missions.
    """
    missions = {d.index: d.missions for d in driven}
    names = [m.name for m in driven[0].missions] if driven else []
    rows = []
    for rank, index in enumerate(choice.shortlist):
        one = candidates[index]
        place = one.free if one.room is None else one.room
        rows.append(
            (
                f"{rank + 1}. {one.label}",
                f"{100 * one.width_m:.3g} x {100 * one.height_m:.3g}",
                _pair_deg(place.vector_median_rad, place.vector_p90_rad),
                f"{100 * place.vector_beyond_90_share:.1f} %",
                f"{100 * place.captured_share:.1f} %",
                f"{100 * place.read_right_share:.1f} %",
                *(_driven_text(missions.get(index, ()), k) for k in range(len(names))),
                choice.comparisons[rank],
            )
        )
    where = "in free space" if candidates[choice.chosen].room is None else "in the room"
    return ReportTable(
        caption=f"The short list; errors and shares are those {where}. Missions: runs that reached "
        "every tag (95 % interval after Wilson), median RMSE to the straight segments over these "
        "runs / over all; "
        "choice.missions in the study says how many designs drive.",
        header=(
            "design",
            "width x height [cm]",
            "vector sum: median / 90 % [°]",
            "beyond 90°",
            "captured by a reflection",
            "right antenna as read",
            *(f"mission, {name}" for name in names),
            "why it stands here",
        ),
        rows=tuple(rows),
        words=True,
        best=0,
    )


def _pair_deg(first_rad: float, second_rad: float) -> str:
    return f"{math.degrees(first_rad):.1f} / {math.degrees(second_rad):.1f}"


def _driven_text(missions: Sequence[RoomMission], number: int) -> str:
    """Return how a design's missions in one room went, in a few words."""
    if not missions:
        return "not driven"
    data = missions[number].data
    if data is None:
        return "could not be driven"
    success = data["success"].values
    interval = wilson(int(success.sum()), success.size)
    return (
        f"{int(success.sum())} of {success.size} ({100 * interval.low:.0f} % to "
        f"{100 * interval.high:.0f} %), "
        f"RMSE {_medians(data, 'rmse_m', 2)} m"
    )
