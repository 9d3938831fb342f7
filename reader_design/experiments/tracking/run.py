"""``octant track``, end to end: the chapters, the figures, the tables and the report."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from octant.geometries.errors import ConfigError
from octant.geometries.files import refuse_overwrite, write_text
from octant.navigation.estimators.ekf_slam import SlamRecord
from octant.reader_design.experiments.tracking.chapter6 import (
    RssFits,
    feedback_outcomes,
    fit_samples,
)
from octant.reader_design.experiments.tracking.chapter7 import (
    NeighbouringResults,
    NominalRun,
    neighbouring_results,
    nominal_runs,
    slam_records,
)
from octant.reader_design.experiments.tracking.costs import (
    CostRow,
    CostScaling,
    cost_rows,
    cost_scalings,
)
from octant.reader_design.experiments.tracking.outcomes import COLUMNS, Outcome
from octant.reader_design.experiments.tracking.results import (
    COST_COLUMNS,
    SLAM_COLUMNS,
    cost_row,
    slam_row,
    tracking_dataset,
)
from octant.reader_design.experiments.tracking.room import RoomResults, room_results
from octant.reader_design.experiments.tracking.settings import Settings, settings_of
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.showing.netcdf import write_dataset
from octant.reader_design.showing.tables import put_table
from octant.reader_design.study_file.loading import to_toml
from octant.reader_design.study_file.schema import Study

FILES = ("results.nc", "tracking.csv", "report.html", "study.toml")
"""What is always written; costs.csv and slam.csv where their chapters are."""
TRAININGS = 2
"""Trajectories that are trained once a run [-]."""
Value = TypeVar("Value")


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackingContent:
    """Return everything that a tracking study computed; None or empty for chapters left out.

    Parameters
    ----------
    settings : Settings
        The study.
    fits : RssFits or None
        Fits of Table 6.1.
    feedback : tuple of Outcome
        Chapter 6.
    nominal : tuple of NominalRun
        Chapter 7.2.
    neighbouring : NeighbouringResults or None
        Chapter 7.3.
    slam : tuple of (float, SlamRecord)
        Wheel noise [rad/s] and runs of chapter 7.4.
    room : RoomResults or None
        The room solver's part.
    costs : tuple of CostRow
        Table 8.1.
    scalings : tuple of CostScaling
        How costs grow.
    study_toml : str
        The resolved study.
    """

    settings: Settings
    fits: RssFits | None
    feedback: tuple[Outcome, ...]
    nominal: tuple[NominalRun, ...]
    neighbouring: NeighbouringResults | None
    slam: tuple[tuple[float, SlamRecord], ...]
    room: RoomResults | None
    costs: tuple[CostRow, ...]
    scalings: tuple[CostScaling, ...]
    study_toml: str

    @property
    def outcomes(self) -> tuple[Outcome, ...]:
        """Return the outcomes of all chapters ([m], [rad])."""
        near = () if self.neighbouring is None else self.neighbouring.outcomes
        room = () if self.room is None else self.room.outcomes
        return (*self.feedback, *(run.outcome for run in self.nominal), *near, *room)


def run_tracking(
    study: Study, out_dir: Path, *, force: bool = False, progress: Progress | None = None
) -> TrackingContent:
    """Return the content of a tracking study and leave its files.

    Parameters
    ----------
    study : Study
        With a table ``[track]``.
    out_dir : Path
        Folder of the results; made when missing.
    force : bool
        Replace results that are there.
    progress : Progress, optional
        Told what happens.
    """
    progress = progress or Progress()
    if out_dir.exists() and not out_dir.is_dir():
        msg = f"{out_dir} is a file, but the results need a folder; give another --out."
        raise ConfigError(msg)
    refuse_overwrite(*(out_dir / name for name in FILES), force=force)
    settings = settings_of(study)
    text = to_toml(study, relative_to=out_dir)
    content = _computed(settings, text, progress)
    _publish(content, out_dir, progress)
    return content


def _computed(settings: Settings, text: str, progress: Progress) -> TrackingContent:
    chapters = settings.track.chapters
    began = time.perf_counter()

    def told(name: str, value: Value) -> Value:
        progress.say(f"{name}: done after {time.perf_counter() - began:.0f} s")
        return value

    fits = told("rss", fit_samples(settings)) if "rss" in chapters else None
    room = told("room", room_results(settings)) if "room" in chapters else None
    nominal = told("nominal", nominal_runs(settings)) if "nominal" in chapters else ()
    neighbouring = (
        told("neighbouring", neighbouring_results(settings)) if "neighbouring" in chapters else None
    )
    slam = told("slam", slam_records(settings)) if "slam" in chapters else ()
    feedback: tuple[Outcome, ...] = ()
    if "feedback" in chapters:
        total = TRAININGS * settings.track.runs
        with progress.count(total, label="measurement feedback") as done:
            feedback = feedback_outcomes(settings, progress=done)
    near = () if neighbouring is None else neighbouring.outcomes
    costs: tuple[CostRow, ...] = ()
    scalings: tuple[CostScaling, ...] = ()
    if "costs" in chapters:
        costs = cost_rows(settings, (*feedback, *near))
        scalings = told("costs", cost_scalings(settings))
    return TrackingContent(
        settings=settings,
        fits=fits,
        feedback=feedback,
        nominal=nominal,
        neighbouring=neighbouring,
        slam=slam,
        room=room,
        costs=costs,
        scalings=scalings,
        study_toml=text,
    )


def _publish(content: TrackingContent, out_dir: Path, progress: Progress) -> None:
    from octant.reader_design.experiments.tracking.page import tracking_report
    from octant.reader_design.experiments.tracking.study_figures import tracking_figures
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
    write_dataset(data, out_dir / "results.nc", force=True)
    _table(out_dir / "tracking.csv", COLUMNS, [o.row() for o in content.outcomes])
    if content.slam:
        _table(out_dir / "slam.csv", SLAM_COLUMNS, [slam_row(s, r) for s, r in content.slam])
    if content.costs:
        _table(out_dir / "costs.csv", COST_COLUMNS, [cost_row(row) for row in content.costs])
    entries: dict[str, list[tuple[str, str, Path]]] = {}
    for one in progress.track(tracking_figures(content), label="figures"):
        path = out_dir / "figures" / one.file
        save_figure(one.figure, path)
        entries.setdefault(one.section, []).append((one.title, one.caption, path))
    write_text(out_dir / "study.toml", content.study_toml)
    write_text(out_dir / "report.html", render_report(tracking_report(content, entries)))


def _table(path: Path, header: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    put_table(str(path), header, iter(rows), force=True)
