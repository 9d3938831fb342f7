"""The main job, end to end: sweep, choice, maps, missions, figures, report; it can be resumed.

Everything that takes time is kept in the output folder, in files named by the hash of their input
(``cells/`` and ``stages/``). Running the same study again in the same folder therefore goes on
where the last run stopped, however that ended.
"""

import re
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from threading import Thread

import msgspec

from octant.em.blocks import cores, one_blas_thread
from octant.em.reader.comparison import ResponseDifference
from octant.geometries.errors import SweepStateError
from octant.geometries.files import write_text
from octant.reader_design.experiments.choice.thesis_claims import claim_sentence
from octant.reader_design.experiments.choice.thesis_setup import thesis_setup
from octant.reader_design.experiments.missions.stage import collected_warnings
from octant.reader_design.experiments.study.approximations import approximation_errors
from octant.reader_design.experiments.study.content import StudyContent
from octant.reader_design.experiments.study.map_stage import MapCase, map_stage
from octant.reader_design.experiments.study.mission_sections import mission_sentence
from octant.reader_design.experiments.study.publish import publish
from octant.reader_design.experiments.study.shortlist import (
    NamedRoom,
    candidates_of,
    drive_shortlist,
    ranked_by_missions,
)
from octant.reader_design.experiments.study.tolerance_stage import tolerance_stage
from octant.reader_design.experiments.sweep.cells import run_sweep
from octant.reader_design.experiments.sweep.cost import cell_cost
from octant.reader_design.experiments.sweep.cost import plan_lines as sweep_lines
from octant.reader_design.experiments.sweep.plan import PlannedCell, plan_sweep
from octant.reader_design.experiments.sweep.table import (
    CELLS_FOLDER,
    known_rows,
    missing_cells,
)
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.results import refuse_another
from octant.reader_design.keeping.workers import Crew, begun, open_crew
from octant.reader_design.setting.cost import (
    Cost,
    counted,
    field_cost,
    floor_m2,
    mission_cost,
    sweep_cost,
)
from octant.reader_design.setting.evaluation import Cell
from octant.reader_design.setting.ranking import choose
from octant.reader_design.setting.setting import (
    Sampling,
    Setting,
    build_setting,
    check_navigator,
)
from octant.reader_design.study_file.loading import layout_study, to_toml
from octant.reader_design.study_file.schema import Layout, Study

WORTH_PROCESSES_S = 20.0
"""Expected time of a sweep [s] above which worker processes are worth starting."""
QUICK_RUNS = 3
"""Runs of a mission in a quick look [-]."""
QUICK_SPACING_M = 0.2
"""Least spacing of the map in a quick look [m]."""
QUICK_LINE = "# A quick look: coarse sampling and few runs (octant study --quick).\n"
OUTPUTS = (
    "results.nc",
    "report.html",
    "designs.csv",
    "missions*.csv",
    "trajectory*.csv",
    "figures/*.png",
)
"""What a study writes for people, besides study.toml; --force clears it for another study."""
OWN_ROOM = "the study's room"


@dataclass(frozen=True, slots=True, kw_only=True)
class StudyOutcome:
    """What a study leaves.

    Attributes
    ----------
    content, folder, report : Cells, choice and missions; where everything lies; the report.
    """

    content: StudyContent
    folder: Path
    report: Path

    @property
    def failed(self) -> tuple[tuple[str, str], ...]:
        """Designs without scores and the reason of each."""
        return tuple((c.label, c.reason) for c in self.content.cells if c.reason)

    def lines(self) -> tuple[str, ...]:
        """Return what a person wants to read at the end; numbers carry their units [m, dB, deg]."""
        failed = [f"No scores for {label}: {reason}" for label, reason in self.failed]
        claims, verdict = self.content.claims, self.content.verdict
        judged = ", ".join(f"{n.name} {n.text} ({n.grade})" for n in verdict.numbers)
        advice = () if verdict.advice is None else tuple(verdict.advice.text().splitlines())
        return (
            verdict.sentence,
            f"{judged[0].upper()}{judged[1:]}.",
            *advice,
            *self.content.choice.reason,
            *([claim_sentence(claims)] if claims else []),
            *failed,
            *(() if self.content.as_built is None else self.content.as_built.paragraphs),
            *(mission_sentence(m) for m in self.content.missions),
            f"Report: {self.report}",
        )


def plan_lines(
    study: Study, out_dir: Path, *, quick: bool = False, workers: int | None = None
) -> tuple[str, ...]:
    """Return what a study would do: its sweep with time [s] and memory [GB], maps and missions.

    Parameters
    ----------
    study, out_dir : What would be studied; its folder, where cells may be kept already.
    quick, workers : Coarse sampling and map, few runs; processes, None: one for each core.
    """
    plan = plan_sweep(_setting(study, quick=quick))
    rows = known_rows(plan, out_dir, progress=Progress())
    rooms = 1 + len(study.layouts)
    runs = 0 if study.mission is None else study.mission.runs
    runs = min(runs, QUICK_RUNS) if quick else runs
    built = 0 if study.tolerance is None or quick else study.tolerance.samples
    return (
        *sweep_lines(plan, rows, workers=workers),
        f"then, with the chosen reader: maps of {len(study.tags)} tags",
        f"missions: {counted(runs * study.choice.missions, 'run')} in {counted(rooms, 'room')}",
        *([f"readers built with errors: {built} of each of 2 designs"] if built else ()),
    )


def study_cost(study: Study, *, quick: bool = False) -> Cost:
    """Return what a study takes: its sweep, the maps of its tags and its missions.

    Parameters
    ----------
    study, quick : What would be studied; coarse sampling and map, few runs.
    """
    sampling = Sampling().coarser() if quick else Sampling()
    swept = sweep_cost(
        study, room_spacing_m=sampling.room_spacing_m, room_azimuths=sampling.room_azimuths
    )
    places = floor_m2(study.room) / study.map.spacing_m**2
    mapped = field_cost(study, places, tags=len(study.tags), causes=("map.spacing_m",))
    driven = Cost(counts=(), seconds=0.0)
    if study.mission is not None:
        runs = min(study.mission.runs, QUICK_RUNS) if quick else study.mission.runs
        rooms = (1 + len(study.layouts)) * study.choice.missions
        driven = mission_cost(study, rooms * runs)
    return swept.and_then(mapped).and_then(driven)


def run_study(
    study: Study,
    out_dir: Path,
    *,
    quick: bool = False,
    force: bool = False,
    progress: Progress | None = None,
    workers: int | None = 1,
    cluster: str | None = None,
    approve: Callable[[Cost], None] | None = None,
) -> StudyOutcome:
    """Return the outcome of a study and leave its files; refuses when no design has scores.

    Parameters
    ----------
    study, out_dir, quick, progress : As for `plan_lines`; shows what happens.
    force : Replace the results of another study in that folder, which is refused otherwise.
    workers : Processes; 1: this one; None: one for each core if the sweep is long enough to gain. A
        script that starts some must guard its main part by ``if __name__ == "__main__"``.
    cluster : Address of a dask scheduler that computes them instead, or ``local:N``.
    approve : Refuses what takes too long or too much memory, before anything is written.
    """
    began = time.perf_counter()
    progress = progress or Progress()
    text = (QUICK_LINE if quick else "") + to_toml(study, relative_to=out_dir)
    refuse_another(out_dir, text, force=force, outputs=OUTPUTS)
    with ExitStack() as stack:
        stack.enter_context(one_blas_thread())  # its matrices are small: threads would only wait
        with collected_warnings() as warned:
            first = _setting(study, quick=quick)
            rooms = list(_rooms(first))
            for note in dict.fromkeys(note for _, _, there in rooms for note in there.notes):
                progress.say(note)
            if study.mission is not None:
                check_navigator(study)
            if approve is not None:
                approve(study_cost(study, quick=quick))
            write_text(out_dir / "study.toml", text)
            plan = plan_sweep(first)
            missing = missing_cells(plan, known_rows(plan, out_dir, progress=Progress()))
            crew = stack.enter_context(_crew(missing, workers=workers, cluster=cluster))
            cells = run_sweep(
                plan,
                out_dir / CELLS_FOLDER,
                crew=crew if len(missing) > 1 or cluster else None,
                progress=progress,
            )
            scored = [c for c in cells if c.free is not None]
            _refuse_nothing_scored(cells)
            candidates = candidates_of(study, cells)
            choice = choose(candidates, model=study.reader.response, rules=study.choice)
            settings = {p.key: p.setting for p in plan.cells}

            def rooms_of(cell: Cell) -> list[NamedRoom]:
                own = settings[cell.key]
                if own.scene is not first.scene or own.study.room != study.room:
                    return list(_rooms(own))
                return [(name, slug, _standing(there, own)) for name, slug, there in rooms]

            _import_meanwhile(crew)
            stages = out_dir / "stages"
            driven = drive_shortlist(
                rooms_of,
                scored,
                choice,
                most_runs=QUICK_RUNS if quick else None,
                folder=stages,
                progress=progress,
                crew=crew,
            )
            choice, driven = ranked_by_missions(choice, candidates, driven)
            chosen = scored[choice.chosen]
            progress.say(choice.reason[0])
            setting = settings[chosen.key]
            approximated = None if quick else begun(crew, approximation_errors, setting)
            room_map = map_stage(MapCase(setting=setting, progress=progress, crew=crew), stages)
            thesis = None
            if study.report.thesis and all(cell.label == cell.design.label() for cell in cells):
                # the thesis varies antenna, r_a and h_p alone
                with progress.during("the set-up of the thesis"):
                    thesis = thesis_setup(cells, study.radio, stages, progress)
            approximations = _waited_for(approximated, progress)
            as_built = None
            if not quick:
                second = scored[choice.ranking[1]] if len(scored) > 1 else None
                as_built = tolerance_stage(
                    setting.study,
                    second,
                    folder=out_dir / "tolerance",
                    progress=progress,
                    workers=workers,
                )
            rooms = rooms_of(chosen)
            for mission in driven[0].missions:
                progress.say(mission_sentence(mission))
        content = StudyContent(
            setting=setting,
            cells=cells,
            candidates=candidates,
            choice=choice,
            driven=driven,
            notes=tuple(dict.fromkeys((*(n for _, _, b in rooms for n in b.notes), *warned))),
            study_toml=text,
            quick=quick,
            seconds=time.perf_counter() - began,
            approximations=approximations,
            as_built=as_built,
            thesis=thesis,
        )
        publish(content, room_map, rooms, out_dir, force=force, progress=progress, crew=crew)
    return StudyOutcome(content=content, folder=out_dir, report=out_dir / "report.html")


def _import_meanwhile(crew: Crew | None) -> None:
    """Import what this process needs next while it waits for workers."""
    if crew is not None:
        Thread(target=import_module, args=("xarray",), daemon=True).start()


def _waited_for(
    approximated: Callable[[], tuple[ResponseDifference, ...]] | None, progress: Progress
) -> tuple[ResponseDifference, ...]:
    """Return the errors of the approximations; none of those that nobody asked for."""
    if approximated is None:
        return ()
    with progress.during("errors of the approximations"):
        return approximated()


def _crew(
    missing: Sequence[PlannedCell], *, workers: int | None, cluster: str | None
) -> AbstractContextManager[Crew | None]:
    """Return the workers of a whole study; processes only where the sweep is worth their start."""
    if workers is None:
        long = sum(cell_cost(cell).seconds for cell in missing) > WORTH_PROCESSES_S
        workers = cores() if long else 1
    return open_crew(workers=workers, cluster=cluster if missing else None)


def _standing(there: Setting, own: Setting) -> Setting:
    """Return a room with the reader of another setting, its response too where it is the same."""
    study = layout_study(own.study, there.layout)
    moved = replace(there, study=study)
    known = dict(zip(own.study.radio.frequencies_hz, own.responses, strict=True))
    wanted = study.radio.frequencies_hz
    return moved.with_responses([known[f] for f in wanted]) if set(wanted) <= set(known) else moved


def _setting(study: Study, *, quick: bool) -> Setting:
    if quick:
        spacing = max(study.map.spacing_m, QUICK_SPACING_M)
        study = msgspec.structs.replace(
            study, map=msgspec.structs.replace(study.map, spacing_m=spacing)
        )
    sampling = Sampling().coarser() if quick else Sampling()
    return build_setting(study, sampling=sampling)


def _rooms(own: Setting) -> Iterator[NamedRoom]:
    """Yield the study's room and its layouts, all checked."""
    yield OWN_ROOM, "room", own
    layouts: Sequence[Layout] = own.study.layouts
    used = {"room"}
    for number, layout in enumerate(layouts, 1):
        slug = re.sub(r"[^a-z0-9]+", "-", layout.name.lower()).strip("-") or "layout"
        slug = slug if slug not in used else f"{slug}-{number}"
        used.add(slug)
        yield layout.name, slug, build_setting(own.study, layout)


def _refuse_nothing_scored(cells: Sequence[Cell]) -> None:
    """Raise when every cell failed, with the reason of the first."""
    if all(cell.reason for cell in cells):
        first = cells[0]
        reason = first.reason.rstrip(".")
        msg = (
            f"none of the {len(cells)} designs has scores, so none can be chosen: "
            f"{first.label} failed because {reason}; change [sweep] or [reader]."
        )
        raise SweepStateError(msg)
