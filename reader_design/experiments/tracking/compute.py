"""``octant track``: its cases, computed once each and kept, and the files made of them."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import msgspec
import numpy as np

from octant.geometries.errors import OctantError
from octant.geometries.files import write_text
from octant.navigation.estimators.ekf_slam import SlamRecord
from octant.navigation.tracking.closed_loop import TrackingRecord
from octant.navigation.tracking.neighbouring import StabilityReport
from octant.reader_design.drives.export import OUTPUTS
from octant.reader_design.experiments.tracking.chapters import (
    FEEDBACK_TASKS,
    NOMINAL_RUNS,
    SLAM_WHEEL_SIGMAS_RAD_PER_S,
    WHEEL_SIGMAS_RAD_PER_S,
    NominalRun,
    RssFits,
    feedback_run,
    fit_samples,
    neighbouring_runs,
    nominal_run,
    slam_record,
    trained_over_many,
    wheel_noise_run,
)
from octant.reader_design.experiments.tracking.cost_scalings import CostScaling, cost_scalings
from octant.reader_design.experiments.tracking.costs import (
    COST_COLUMNS,
    CostRow,
    cost_rows,
    with_errors,
)
from octant.reader_design.experiments.tracking.further import FURTHER
from octant.reader_design.experiments.tracking.parts import Part, PartRecord, Records
from octant.reader_design.experiments.tracking.results import (
    COLUMNS,
    SLAM_COLUMNS,
    Outcome,
    slam_row,
    tracking_dataset,
)
from octant.reader_design.experiments.tracking.room import (
    RoomRuns,
    check_room,
    meshes,
    room_runs,
)
from octant.reader_design.experiments.tracking.settings import (
    RESERVED_NAMES,
    Settings,
    settings_of,
)
from octant.reader_design.keeping.keeper import RecordCodec, kept_cases, map_cases
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.results import refuse_another, write_once
from octant.reader_design.setting.cost import Cost, tracking_cost
from octant.reader_design.showing.netcdf import write_dataset
from octant.reader_design.showing.tables import put_table
from octant.reader_design.study_file.loading import to_toml
from octant.reader_design.study_file.schema import Study

FILES = ("results.nc", "tracking.csv", "report.html", "study.toml")
"""What is always written; costs.csv and slam.csv where their chapters are."""
CASES = "cases"
_NO_EFFECT = ("Study.name", "Track.chapters")


def parts_of(settings: Settings) -> tuple[Part, ...]:
    """Return the parts of a study's chapters, but for the costs; those are timed alone.

    Parameters
    ----------
    settings : The study.
    """
    own = [one.curve.name for one in settings.own]
    noisy = [Part(chapter="wheel noise", sigma=sigma) for sigma in WHEEL_SIGMAS_RAD_PER_S]
    parts = {
        "rss": [Part(chapter="rss")],
        "feedback": [
            *(
                Part(chapter="feedback", task=task, run=run)
                for task in ("line", "sine")
                for run in range(settings.track.runs)
            ),
            *(Part(chapter="feedback", task=task, method="many") for task in FEEDBACK_TASKS),
        ],
        "nominal": [Part(chapter="nominal", task=t, method=m) for t, m in NOMINAL_RUNS],
        "neighbouring": [
            *(Part(chapter="neighbouring", task=task) for task in (*RESERVED_NAMES, *own)),
            *noisy,
        ],
        "slam": [Part(chapter="slam", sigma=sigma) for sigma in SLAM_WHEEL_SIGMAS_RAD_PER_S],
        "room": [Part(chapter="room", run=mesh) for mesh in meshes(settings)],
    }
    named = settings.track.chapters
    return (
        *(part for name, some in parts.items() if name in named for part in some),
        *(part for name, one in FURTHER.items() if name in named for part in one.parts(settings)),
    )


def compute_part(study: Study, part: Part) -> PartRecord:
    """Return the record of a part ([m], [rad], [s]).

    Parameters
    ----------
    study, part : A study with a table ``[track]``, and one of its `parts_of`.
    """
    return _CHAPTERS[part.chapter](settings_of(study), part)


def _feedback(settings: Settings, part: Part) -> PartRecord:
    if part.method:
        return PartRecord(outcomes=trained_over_many(settings, part.task))
    return PartRecord(outcomes=feedback_run(settings, part.task, part.run))


def _neighbouring(settings: Settings, part: Part) -> PartRecord:
    outcomes, stability = neighbouring_runs(settings, part.task)
    return PartRecord(outcomes=outcomes, stability=stability)


_CHAPTERS: dict[str, Callable[[Settings, Part], PartRecord]] = {
    "rss": lambda settings, _: PartRecord(fits=fit_samples(settings)),
    "feedback": _feedback,
    "nominal": lambda s, part: PartRecord(nominal=nominal_run(s, part.task, part.method)),
    "neighbouring": _neighbouring,
    "wheel noise": lambda s, part: PartRecord(outcomes=(wheel_noise_run(s, part.sigma),)),
    "slam": lambda s, part: PartRecord(slam=slam_record(s, part.sigma)),
    "room": lambda s, part: PartRecord(room=room_runs(s, part.run)),
    "costs": lambda s, _: PartRecord(costs=cost_rows(s), scalings=cost_scalings(s)),
    **{name: one.compute for name, one in FURTHER.items()},
}


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackingContent:
    """Everything that a tracking study computed.

    Parameters
    ----------
    settings, study_toml : The study, as settings and as the resolved file.
    parts : All parts, in the order of `parts_of`, then the costs.
    """

    settings: Settings
    study_toml: str
    parts: tuple[tuple[Part, PartRecord], ...] = field(default=())

    def records(self, chapter: str) -> Iterator[tuple[Part, PartRecord]]:
        """Yield the parts of a chapter.

        Parameters
        ----------
        chapter : As in `Part`.
        """
        return ((part, record) for part, record in self.parts if part.chapter == chapter)

    @property
    def fits(self) -> RssFits | None:
        """The fits of Table 6.1; None when that chapter was left out."""
        return next((record.fits for _, record in self.records("rss")), None)

    @property
    def feedback(self) -> tuple[Outcome, ...]:
        """The outcomes of chapter 6, the runs of each put together ([m], [rad])."""
        found: dict[tuple[str, str], list[Outcome]] = {}
        for _, record in self.records("feedback"):
            for outcome in record.outcomes:
                found.setdefault((outcome.task, outcome.method), []).append(outcome)
        return tuple(_joined(outcomes) for outcomes in found.values())

    @property
    def nominal(self) -> tuple[NominalRun, ...]:
        """The nominal problems of thesis 7.2 ([m], [rad])."""
        found = (record.nominal for _, record in self.records("nominal"))
        return tuple(run for run in found if run is not None)

    @property
    def neighbouring(self) -> tuple[Outcome, ...]:
        """The outcomes of thesis 7.3 ([m], [rad])."""
        return tuple(o for _, record in self.records("neighbouring") for o in record.outcomes)

    @property
    def stability(self) -> dict[str, StabilityReport]:
        """What the theory of 7.3 says, by task."""
        found = ((part.task, record.stability) for part, record in self.records("neighbouring"))
        return {task: report for task, report in found if report is not None}

    @property
    def wheel_noise(self) -> tuple[tuple[float, Outcome], ...]:
        """The lemniscate at several wheel noises [rad/s]."""
        return tuple((part.sigma, r.outcomes[0]) for part, r in self.records("wheel noise"))

    @property
    def slam(self) -> tuple[tuple[float, SlamRecord], ...]:
        """Wheel noise [rad/s] and runs of EKF SLAM."""
        found = ((part.sigma, record.slam) for part, record in self.records("slam"))
        return tuple((sigma, slam) for sigma, slam in found if slam is not None)

    @property
    def room(self) -> tuple[RoomRuns, ...]:
        """The room solver's part, mesh by mesh."""
        found = (record.room for _, record in self.records("room"))
        return tuple(runs for runs in found if runs is not None)

    @property
    def outcomes(self) -> tuple[Outcome, ...]:
        """The outcomes of all chapters ([m], [rad])."""
        nominal = (run.outcome for run in self.nominal)
        room = (outcome for runs in self.room for outcome in runs.outcomes)
        further = (o for records in self.further.values() for _, r in records for o in r.outcomes)
        return (*self.feedback, *nominal, *self.neighbouring, *room, *further)

    @property
    def further(self) -> dict[str, Records]:
        """What the chapters of `FURTHER` left, of those that the study names."""
        found = {name: tuple(self.records(name)) for name in FURTHER}
        return {name: records for name, records in found.items() if records}

    @property
    def costs(self) -> tuple[CostRow, ...]:
        """Table 8.1 with its errors."""
        found = (record.costs for _, record in self.records("costs"))
        return with_errors(next(found, ()), self.outcomes)

    @property
    def scalings(self) -> tuple[CostScaling, ...]:
        """How costs grow."""
        return next((record.scalings for _, record in self.records("costs")), ())


def _joined(outcomes: Sequence[Outcome]) -> Outcome:
    first = outcomes[0]
    runs = TrackingRecord(
        desired=first.runs.desired,
        poses=np.concatenate([o.runs.poses for o in outcomes]),
        estimates=np.concatenate([o.runs.estimates for o in outcomes]),
        wheel_rates=np.concatenate([o.runs.wheel_rates for o in outcomes]),
    )
    return Outcome(chapter=first.chapter, task=first.task, method=first.method, runs=runs)


def with_repetitions(study: Study, *, runs: int | None, seed: int | None) -> Study:
    """Return a study with other repetitions of every drive, of SLAM too, and another seed.

    Parameters
    ----------
    study, runs, seed : None leaves what the study says.
    """
    replace = msgspec.structs.replace
    if seed is not None:
        study = replace(study, seed=seed)
    if runs is not None and study.track is not None:
        study = replace(study, track=replace(study.track, runs=runs, slam_runs=runs))
    return study


def run_tracking(
    study: Study,
    out_dir: Path,
    *,
    workers: int | None = 1,
    cluster: str | None = None,
    force: bool = False,
    progress: Progress | None = None,
    approve: Callable[[Cost], None] | None = None,
) -> TrackingContent:
    """Return the content of a tracking study and write its files, unless they are there already.

    Parameters
    ----------
    study, out_dir : With a table ``[track]``; folder of the results, whose parts are read.
    workers, cluster : Who shares the parts, as in `map_cases`.
    force, progress : Replace results that are there; shows how many parts are done.
    approve : Refuses what takes too long or too much memory, before anything is written.
    """
    progress = progress or Progress()
    settings = settings_of(study)
    if {"room", "reader"} & set(settings.track.chapters):
        check_room(settings)
    if approve is not None:
        approve(tracking_cost(settings.track))
    text = to_toml(study, relative_to=out_dir)
    refuse_another(out_dir, text, force=force, outputs=(*FILES, "*.csv", "figures/*.png", OUTPUTS))
    write_text(out_dir / "study.toml", text)
    content = _computed(
        settings, text, out_dir, workers=workers, cluster=cluster, progress=progress
    )
    write_once(
        out_dir / CASES / "finished.json",
        [study, content.parts],
        lambda: publish(content, out_dir, progress),
        force=force,
        progress=progress,
    )
    return content


def plan_line(study: Study, out_dir: Path) -> str:
    """Return how many parts a tracking study has, and how many the folder holds.

    Parameters
    ----------
    study, out_dir : A study and the folder of its results.
    """
    settings = settings_of(study)
    parts = parts_of(settings)
    kept = kept_cases(
        compute_part,
        parts,
        context=study,
        folder=out_dir / CASES,
        codec=RecordCodec(PartRecord),
        leave_out=_NO_EFFECT,
    )
    there = sum(one is not None for one in kept)
    costs = ", and the costs" if "costs" in settings.track.chapters else ""
    return f"{len(parts)} parts, of which {there} are computed already{costs}."


def _computed(
    settings: Settings,
    text: str,
    out_dir: Path,
    *,
    workers: int | None,
    cluster: str | None,
    progress: Progress,
) -> TrackingContent:
    study = settings.study
    parts = list(parts_of(settings))
    records = map_cases(
        compute_part,
        parts,
        context=study,
        folder=out_dir / CASES,
        codec=RecordCodec(PartRecord),
        leave_out=_NO_EFFECT,
        workers=workers,
        cluster=cluster,
        progress=progress,
        label="parts",
        raises=(OctantError,),
    )
    found = [(part, kept.value) for part, kept in zip(parts, records, strict=True)]
    if "costs" in settings.track.chapters:  # after the rest: other work would disturb the times
        timed = Part(chapter="costs")
        (kept,) = map_cases(
            compute_part,
            [timed],
            context=study,
            folder=out_dir / CASES,
            codec=RecordCodec(PartRecord),
            leave_out=_NO_EFFECT,
            progress=progress,
            label="costs",
            raises=(OctantError,),
        )
        found.append((timed, kept.value))
    return TrackingContent(settings=settings, study_toml=text, parts=tuple(found))


def publish(content: TrackingContent, out_dir: Path, progress: Progress) -> list[Path]:
    """Return the files of a tracking study, once written.

    Parameters
    ----------
    content, out_dir : What was computed, and the folder of the results.
    progress : Shows how many figures are drawn.
    """
    from octant.reader_design.experiments.tracking.figures import tracking_figures
    from octant.reader_design.experiments.tracking.page import tracking_report
    from octant.reader_design.showing.pages import render_report
    from octant.reader_design.showing.style import save_figure

    study = content.settings.study
    data = tracking_dataset(
        content.outcomes,
        content.slam,
        study_toml=content.study_toml,
        seed=study.seed,
        name=study.name,
    )
    written = [out_dir / name for name in FILES]
    write_dataset(data, out_dir / "results.nc", force=True)
    tables: dict[str, tuple[Sequence[str], Sequence[tuple[object, ...]]]] = {
        "tracking.csv": (COLUMNS, [o.row() for o in content.outcomes]),
        "slam.csv": (SLAM_COLUMNS, [slam_row(s, r) for s, r in content.slam]),
        "costs.csv": (COST_COLUMNS, [row.row() for row in content.costs]),
    }
    for name, records in content.further.items():
        for table in FURTHER[name].tables(content.settings, records):
            tables[table.file] = table.header, table.rows
    for name, (header, rows) in tables.items():
        if rows or name == "tracking.csv":
            put_table(str(out_dir / name), header, iter(rows), force=True)
            written.append(out_dir / name)
    entries: dict[str, list[tuple[str, str, Path]]] = {}
    with progress.track(tracking_figures(content), label="figures") as figures:
        for one in figures:
            path = out_dir / "figures" / one.file
            save_figure(one.figure, path)
            entries.setdefault(one.section, []).append((one.title, one.caption, path))
            written.append(path)
    write_text(out_dir / "report.html", render_report(tracking_report(content, entries)))
    return written
