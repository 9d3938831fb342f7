"""Comparisons: layouts x links x readers x controllers, each combination a study of its own."""

import itertools
import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from octant.geometries.errors import ConfigError
from octant.geometries.files import write_text
from octant.navigation.statistics import Interval, bootstrap, bootstrap_rng, wilson
from octant.reader_design.experiments.missions.comparison_table import (
    OWN,
    Comparison,
    LayoutEntry,
    LinkEntry,
)
from octant.reader_design.experiments.missions.sensitivity import broke_before, sweeps
from octant.reader_design.experiments.missions.stage import RoomMission, mission_stage
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.results import STUDY_FILE, refuse_another, write_once
from octant.reader_design.keeping.workers import Crew, open_crew
from octant.reader_design.setting.setting import build_setting, check_navigator, mission_table
from octant.reader_design.setting.solving import solved
from octant.reader_design.showing.tables import put_table
from octant.reader_design.study_file.loading import load_study, vary
from octant.reader_design.study_file.schema import Map, Study
from octant.reader_design.study_file.tables_read import check_tables
from octant.reader_design.study_file.toml import toml_text
from octant.reader_design.study_file.truth import Truth

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonCell:
    """One combination of a comparison.

    Attributes
    ----------
    layout, link, reader, controller, world : Names.
    study : What is driven: the layout's study with the keys of the other four.
    published_rmse_m : Published RMSE of the layout [m].
    error, value : The swept error, and its value in the unit of its key; without one ``""`` and
        NaN.
    """

    layout: str
    link: str
    reader: str
    controller: str
    study: Study
    published_rmse_m: float | None
    world: str = OWN
    error: str = ""
    value: float = math.nan

    @property
    def driven(self) -> str:
        """What drives: controller, link and reader."""
        names = (self.link, self.reader)
        return "; ".join((self.controller, *(name for name in names if name != OWN)))

    @property
    def label(self) -> str:
        """What distinguishes the cell from the others of its layout."""
        return self.driven if self.world == OWN else f"{self.driven}; {self.world}"


def plan_comparison(comparison: Comparison) -> tuple[ComparisonCell, ...]:
    """Return the cells of a comparison, layouts outermost, controllers innermost; lengths in [m].

    Parameters
    ----------
    comparison : From `load_comparison`.
    """
    cells: list[ComparisonCell] = []
    for layout in comparison.layouts:
        found = list(_cells_of(comparison, layout))
        if any(cell.layout == found[0].layout for cell in cells):
            msg = (
                f"the study {layout.study} is called {found[0].layout!r} as another layout is; "
                "give each study file a name of its own."
            )
            raise ConfigError(msg)
        cells += found
    return tuple(cells)


def _cells_of(comparison: Comparison, layout: LayoutEntry) -> Iterator[ComparisonCell]:
    study = load_study(layout.study)
    check_tables(study, "navigate")
    check_navigator(study)
    worlds = comparison.every_world()
    entries = itertools.product(
        comparison.links, comparison.readers, comparison.controllers, worlds
    )
    for link, reader, controller, (world, error, value) in entries:
        source = (
            f"{Path(layout.study).name} with link {link.name!r}, reader {reader.name!r}, "
            f"controller {controller.name!r} and world {world.name!r}"
        )
        cell = ComparisonCell(
            layout=study.name,
            link=link.name,
            reader=reader.name,
            controller=controller.name,
            study=_combined(
                msgspec.structs.replace(study, seed=comparison.seed),
                link,
                {
                    "reader": reader.reader,
                    "mission": {**controller.mission, "runs": comparison.runs},
                    "robot": controller.robot,
                    "truth": world.truth,
                },
                source=source,
            ),
            published_rmse_m=layout.published_rmse_m,
            world=world.name,
            error=error,
            value=value,
        )
        check_navigator(cell.study)
        yield cell


def _combined(
    study: Study, link: LinkEntry, others: dict[str, dict[str, Any]], *, source: str
) -> Study:
    """Return a study with keys of its tables replaced."""
    # What no mission looks at goes, for it may contradict the new keys.
    plain = msgspec.structs.replace(study, map=Map(), layouts=(), track=None, dock=None)
    if others["truth"] and plain.truth is None:
        plain = msgspec.structs.replace(plain, truth=Truth())
    tables = {"radio": link.radio, "sensor": link.sensor, "solver": link.solver, "tag": link.tag}
    tables |= others
    values: dict[str, Any] = {"tag.axis": None} if "antenna" in link.tag else {}
    for table, keys in tables.items():
        values |= {f"{table}.{key}": value for key, value in keys.items()}
    try:
        return vary(plain, values)
    except ConfigError as exc:
        msg = f"{source}: {exc}"
        raise ConfigError(msg) from exc


COLUMNS = (
    "layout",
    "link",
    "reader",
    "controller",
    "runs",
    "successes",
    "success_low",
    "success_high",
    "captured",
    "collided",
    "rmse_median_m",
    "rmse_low_m",
    "rmse_high_m",
    "published_rmse_m",
    "arrival_median_m",
    "arrival_p90_m",
    "time_median_s",
    "path_median_m",
    "cell",
    "failed_because",
    "rmse_success_median_m",
    "rmse_success_low_m",
    "rmse_success_high_m",
    "arrival_success_median_m",
    "p90_position_median_m",
    "p90_heading_median_deg",
    "world",
    "error",
    "value",
    "failures",
    "contacts_mean",
    "untouched",
)
"""Columns of compare.csv: 95 % intervals after Wilson (shares) and by the bootstrap (medians)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CellOutcome:
    """One cell and what its runs showed; NaN where nothing was driven or no tag was reached.

    Attributes
    ----------
    cell, mission : The combination and its runs.
    runs, successes, captured, collided : Number of runs, and of those that ended so.
    success_interval : 95 % interval of the probability of success [-].
    rmse_m, rmse_interval_m : Median RMSE to the straight segments, and its 95 % interval [m].
    arrival_m, arrival_p90_m : Distance from the tags on arrival: median, 90th percentile [m].
    success_rmse_m, success_rmse_interval_m, success_arrival_m : The same over the runs that reached
        every tag [m].
    p90_position_m, p90_heading_deg : Medians of the errors that 90 % of a run's samples do not
        exceed, thesis Figs. 5.12 to 5.14 (b) [m], [deg].
    time_s, path_m : Median duration [s] and way [m].
    failures : Kinds of the runs that did not reach every tag, and how often each.
    contacts_mean, untouched : Contacts of a run in the mean [-]; runs without any.
    """

    cell: ComparisonCell
    mission: RoomMission
    runs: int
    successes: int
    captured: int
    collided: int
    success_interval: tuple[float, float]
    rmse_m: float
    rmse_interval_m: tuple[float, float]
    arrival_m: float
    arrival_p90_m: float
    time_s: float
    path_m: float
    success_rmse_m: float = math.nan
    success_rmse_interval_m: tuple[float, float] = (math.nan, math.nan)
    success_arrival_m: float = math.nan
    p90_position_m: float = math.nan
    p90_heading_deg: float = math.nan
    failures: tuple[tuple[str, int], ...] = ()
    contacts_mean: float = math.nan
    untouched: int = 0

    def row(self) -> tuple[object, ...]:
        """Return the cell's line of compare.csv: `COLUMNS`, empty where there is no value."""
        cell = self.cell
        values = (
            cell.layout,
            cell.link,
            cell.reader,
            cell.controller,
            self.runs,
            self.successes,
            *self.success_interval,
            self.captured,
            self.collided,
            self.rmse_m,
            *self.rmse_interval_m,
            math.nan if cell.published_rmse_m is None else cell.published_rmse_m,
            self.arrival_m,
            self.arrival_p90_m,
            self.time_s,
            self.path_m,
            self.mission.folder.name,
            self.mission.reason,
            self.success_rmse_m,
            *self.success_rmse_interval_m,
            self.success_arrival_m,
            self.p90_position_m,
            self.p90_heading_deg,
            cell.world,
            cell.error,
            cell.value,
            "; ".join(f"{count} {kind}" for kind, count in self.failures),
            self.contacts_mean,
            self.untouched,
        )
        return tuple("" if isinstance(v, float) and math.isnan(v) else v for v in values)


def outcome_of(cell: ComparisonCell, mission: RoomMission) -> CellOutcome:
    """Return what a cell's runs showed [m], [s].

    Parameters
    ----------
    cell, mission : The combination and its runs.
    """
    data = mission.data
    if data is None:
        nan = math.nan
        return CellOutcome(
            cell=cell,
            mission=mission,
            runs=0,
            successes=0,
            captured=0,
            collided=0,
            success_interval=(nan, nan),
            rmse_m=nan,
            rmse_interval_m=(nan, nan),
            arrival_m=nan,
            arrival_p90_m=nan,
            time_s=nan,
            path_m=nan,
        )
    runs = int(data.sizes["run"])
    successes, captured, collided = (
        int(data[name].values.sum()) for name in ("success", "captured", "collided")
    )
    good = data.isel(run=np.flatnonzero(data["success"].values))
    metrics = mission.metrics
    success, median, best = wilson(successes, runs), _median_rmse(data), _median_rmse(good)
    return CellOutcome(
        cell=cell,
        mission=mission,
        runs=runs,
        successes=successes,
        captured=captured,
        collided=collided,
        success_interval=(success.low, success.high),
        rmse_m=median.value,
        rmse_interval_m=(median.low, median.high),
        arrival_m=_percentile(data, 50.0),
        arrival_p90_m=_percentile(data, 90.0),
        time_s=float(np.median(data["time_s"].values)),
        path_m=float(np.median(data["path_m"].values)),
        success_rmse_m=best.value,
        success_rmse_interval_m=(best.low, best.high),
        success_arrival_m=_percentile(good, 50.0),
        p90_position_m=float(np.median(data["p90_position_m"].values)),
        p90_heading_deg=math.degrees(np.median(data["p90_heading_rad"].values)),
        failures=tuple(Counter(m.verdict for m in metrics if not m.success).most_common()),
        contacts_mean=float(np.mean([m.contacts for m in metrics])),
        untouched=sum(m.contacts == 0 for m in metrics),
    )


def _median_rmse(data: "xr.Dataset") -> Interval:
    """Return the median RMSE of runs and its 95 % interval [m]; NaN without any."""
    rmse = np.asarray(data["rmse_m"].values, dtype=np.float64)
    if not rmse.size:
        return Interval(value=math.nan, low=math.nan, high=math.nan)
    (median,) = bootstrap(rmse, lambda drawn: np.median(drawn, axis=-1)[None], bootstrap_rng())
    return median


def layouts_of(outcomes: Sequence[CellOutcome]) -> dict[str, list[CellOutcome]]:
    """Return the outcomes by layout.

    Parameters
    ----------
    outcomes : Of all cells.
    """
    found: dict[str, list[CellOutcome]] = {}
    for outcome in outcomes:
        found.setdefault(outcome.cell.layout, []).append(outcome)
    return found


def _percentile(data: "xr.Dataset", percent: float) -> float:
    arrivals = np.asarray(data["arrival_error_m"].values, dtype=np.float64)
    known = arrivals[np.isfinite(arrivals)]
    return float(np.percentile(known, percent)) if known.size else math.nan


CELLS = "cells"
"""Folder of the runs, and of the tables of each cell."""
FILES = ("compare.csv", "report.html")
"""What a comparison leaves beside its figures."""


def run_comparison(
    comparison: Comparison,
    out_dir: Path,
    *,
    force: bool = False,
    progress: Progress | None = None,
    workers: int | None = 1,
    cluster: str | None = None,
) -> tuple[CellOutcome, ...]:
    """Return the outcome of every cell; write compare.csv, report.html and figures.

    Parameters
    ----------
    comparison, progress : What is compared; shows how many cells and runs are done.
    out_dir : Folder for results. Runs that it holds are read, not driven again.
    force : Replace the results of another comparison.
    workers, cluster : Processes, None: one for each core; a dask scheduler in their place.
    """
    progress = progress or Progress()
    cells = plan_comparison(comparison)
    text = _resolved(comparison)
    refuse_another(out_dir, text, force=force, outputs=(*FILES, "figures/*.png"))
    write_text(out_dir / STUDY_FILE, text)
    with open_crew(workers=workers, cluster=cluster) as crew:
        found = _outcomes(comparison, cells, out_dir / CELLS, progress, crew)
        outcomes = []
        with progress.track(found, total=len(cells), label="cells") as tracked:
            for outcome in tracked:
                outcomes.append(outcome)
                progress.say(_sentence(outcome))
    runs = [(o.mission.folder.name, o.mission.reason) for o in outcomes]
    write_once(
        out_dir / CELLS / "finished.json",
        [text, runs],
        lambda: _publish(comparison, outcomes, out_dir),
        force=force,
        progress=progress,
    )
    return tuple(outcomes)


def _resolved(comparison: Comparison) -> str:
    tables = msgspec.to_builtins(comparison)
    tables["layout"] = [
        {key: value for key, value in layout.items() if value is not None}
        for layout in tables["layout"]
    ]
    return toml_text(tables)


def _outcomes(
    comparison: Comparison,
    cells: Sequence[ComparisonCell],
    folder: Path,
    progress: Progress,
    crew: Crew | None,
) -> Iterator[CellOutcome]:
    """Yield each cell's outcome; cells that share room and reader build them once.

    A cell of an error that broke the missions already is not driven.
    """
    known: list[CellOutcome] = []
    for _, group in itertools.groupby(cells, key=lambda c: (c.layout, c.link, c.reader)):
        alike = list(group)
        setting = solved(build_setting(alike[0].study), progress)
        responses = setting.responses
        for cell in alike:
            earlier = sweeps(known).get((cell.layout, cell.error, cell.driven), [])
            broken = broke_before(earlier, comparison.breaks_below)
            if not math.isnan(broken):
                yield outcome_of(cell, _not_driven(cell, folder, broken))
                continue
            mission = mission_stage(
                replace(setting, study=cell.study).with_responses(responses),
                name=cell.layout,
                slug=_slug(cell.layout),
                runs=mission_table(cell.study).runs,
                folder=folder,
                progress=progress,
                crew=crew,
            )
            known.append(outcome_of(cell, mission))
            yield known[-1]


def _not_driven(cell: ComparisonCell, folder: Path, broken: float) -> RoomMission:
    slug = _slug(cell.layout)
    return RoomMission(
        name=cell.layout,
        slug=slug,
        reason=f"{cell.error} broke the missions at {broken:g} already",
        notes=(),
        data=None,
        folder=folder / f"mission-{slug}",
    )


def rmse_text(outcome: CellOutcome) -> str:
    """Return the median RMSE of the runs that reached every tag, and of all [m].

    Parameters
    ----------
    outcome : A driven cell.
    """
    good = outcome.success_rmse_m
    return f"{'-' if math.isnan(good) else f'{good:.3f}'} of these, {outcome.rmse_m:.3f} of all"


def _slug(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-") or "layout"


def _sentence(outcome: CellOutcome) -> str:
    cell = outcome.cell
    if outcome.mission.reason:
        return f"{cell.layout}, {cell.label}: not driven, because {outcome.mission.reason}"
    return (
        f"{cell.layout}, {cell.label}: {outcome.successes} of {outcome.runs} reached every tag, "
        f"median RMSE {rmse_text(outcome)} m"
    )


def _publish(comparison: Comparison, outcomes: Sequence[CellOutcome], out_dir: Path) -> list[Path]:
    """Write the files of a comparison and return them."""
    from octant.reader_design.experiments.missions.comparison_page import comparison_report
    from octant.reader_design.experiments.missions.figures import comparison_figure
    from octant.reader_design.experiments.missions.sensitivity_figure import sensitivity_figure
    from octant.reader_design.showing.pages import render_report
    from octant.reader_design.showing.style import save_figure

    table, page = (out_dir / name for name in FILES)
    put_table(str(table), COLUMNS, [outcome.row() for outcome in outcomes], force=True)
    figures: dict[str, list[tuple[str, str, Path]]] = {}
    for outcome in outcomes:
        drawn = _cell_figure(outcome, out_dir / "figures")
        figures.setdefault(outcome.cell.layout, []).extend(drawn)
    overview = out_dir / "figures" / "overview.png"
    save_figure(comparison_figure(outcomes, title=comparison.name), overview)
    swept: list[Path] = []
    if comparison.errors:
        swept = [out_dir / "figures" / "sensitivity.png"]
        figure = sensitivity_figure(comparison.errors, outcomes, title=comparison.name)
        save_figure(figure, swept[0])
    report = comparison_report(comparison, outcomes, figures, overview, *swept)
    write_text(page, render_report(report))
    return [
        table,
        page,
        overview,
        *swept,
        *(path for some in figures.values() for *_, path in some),
    ]


def _cell_figure(outcome: CellOutcome, folder: Path) -> list[tuple[str, str, Path]]:
    """Draw a driven cell's first run; return title, caption and file."""
    from octant.reader_design.experiments.missions.figures import run_figure
    from octant.reader_design.showing.plan import plan_of
    from octant.reader_design.showing.style import save_figure

    mission = outcome.mission
    drive, setting, data = mission.drive, mission.setting, mission.data
    if drive is None or setting is None or data is None:
        return []
    path = folder / f"{mission.folder.name.removeprefix('mission-')}.png"
    if not path.exists():
        tags = mission_table(outcome.cell.study).tags
        figure = run_figure(
            drive,
            plan_of(setting.scene, setting.reader_z_m),
            {tag_id: setting.tag(tag_id).point_m for tag_id in tags},
            title=f"{outcome.cell.layout}: {outcome.cell.label}",
        )
        save_figure(figure, path)
    caption = (
        f"Run 0 of {outcome.runs}, of which {outcome.successes} reached every tag. It ended "
        f"because {data['ended_because'].values[0]}."
    )
    return [(outcome.cell.label, caption, path)]
