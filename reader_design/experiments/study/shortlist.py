"""The missions of the best designs of a study, so that the ranking can be held against them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from octant.reader_design.experiments.missions.stage import RoomMission, mission_stage
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.workers import Crew
from octant.reader_design.setting.evaluation import Cell
from octant.reader_design.setting.ranking import Candidate, Choice, after_missions
from octant.reader_design.setting.setting import Setting
from octant.reader_design.study_file.schema import Study

NamedRoom = tuple[str, str, Setting]
"""A room's name, the same fit for file names, and the room with its reader."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DrivenDesign:
    """A design of the short list with its missions.

    Attributes
    ----------
    index, missions : Its place among the candidates; one for each room, none without a mission.
    """

    index: int
    missions: tuple[RoomMission, ...]


def candidates_of(study: Study, cells: Sequence[Cell]) -> tuple[Candidate, ...]:
    """Return the scored cells, in their order, as candidates of the choice, sizes in [m].

    Parameters
    ----------
    study, cells : Its carrier sizes resonant antennas [Hz]; all cells.
    """
    out = []
    for cell in cells:
        if cell.free is None:
            continue
        width_m, height_m = cell.design.size_m(study.radio.frequency_hz)
        out.append(
            Candidate(
                label=cell.label,
                key=cell.key,
                free=cell.free,
                room=cell.room,
                width_m=width_m,
                height_m=height_m,
            )
        )
    return tuple(out)


def drive_shortlist(
    rooms: Callable[[Cell], Sequence[NamedRoom]],
    scored: Sequence[Cell],
    choice: Choice,
    *,
    most_runs: int | None,
    folder: Path,
    progress: Progress,
    crew: Crew | None = None,
) -> tuple[DrivenDesign, ...]:
    """Return the best designs' missions, chosen first, same seeds ([s], [m], [rad], [W]).

    Parameters
    ----------
    rooms : Returns the rooms of a cell, with its reader in them.
    scored, choice : The candidates' cells, in their order, and the ranking.
    most_runs : Runs in each room at most; None: as many as the study says.
    folder, progress : Where stages are kept; shows runs.
    crew : Workers that share the runs; None: this process drives.
    """
    driven = []
    for index in choice.ranking[: choice.rules.missions]:
        cell = scored[index]
        missions: list[RoomMission] = []
        for name, slug, setting in rooms(cell):
            if setting.study.mission is not None:
                runs = setting.study.mission.runs
                missions.append(
                    mission_stage(
                        setting,
                        name=name,
                        slug=slug,
                        runs=runs if most_runs is None else min(runs, most_runs),
                        folder=folder,
                        progress=progress,
                        crew=crew,
                    )
                )
        driven.append(DrivenDesign(index=index, missions=tuple(missions)))
    return tuple(driven)


def ranked_by_missions(
    choice: Choice, candidates: Sequence[Candidate], driven: Sequence[DrivenDesign]
) -> tuple[Choice, tuple[DrivenDesign, ...]]:
    """Return the choice by the missions of the designs that drove, and these in its order.

    Both stay as they are without the rule ``by_missions``. A room in which a design could not
    drive counts as runs of which none reached every tag.

    Parameters
    ----------
    choice, candidates, driven : By the scores ([-], [rad], [dB], [dBm]); of what; its first ones.
    """
    if not choice.rules.by_missions:
        return choice, tuple(driven)
    reached, runs = {}, 0
    for one in driven:
        found = [m.data["success"].values for m in one.missions if m.data is not None]
        reached[one.index] = sum(int(success.sum()) for success in found)
        runs = max(runs, sum(success.size for success in found))
    choice = after_missions(choice, candidates, reached, runs=runs)
    return choice, tuple(sorted(driven, key=lambda one: choice.ranking.index(one.index)))
