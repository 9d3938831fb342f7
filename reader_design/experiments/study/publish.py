"""What a study leaves for people: results, tables, figures and the report."""

from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from octant.geometries.files import whole_file, write_text
from octant.reader_design.experiments.missions.stage import RoomMission
from octant.reader_design.experiments.study.content import StudyContent
from octant.reader_design.experiments.study.page import study_report
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.results import write_once
from octant.reader_design.keeping.workers import Crew
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.drawing import DrawnFigure, Group, drawn_figures
from octant.reader_design.showing.netcdf import write_dataset
from octant.reader_design.showing.pages import render_report
from octant.reader_design.showing.tables import put_table

if TYPE_CHECKING:
    import xarray as xr


def publish(
    content: StudyContent,
    room_map: "xr.Dataset",
    rooms: Sequence[tuple[str, str, Setting]],
    out_dir: Path,
    *,
    force: bool,
    progress: Progress,
    crew: Crew | None = None,
) -> None:
    """Write results, tables, figures and report, unless these are there already.

    Parameters
    ----------
    content, room_map : What was found, units as there; maps of the chosen reader [W].
    rooms : Name, file name and scene of the study's room and of its layouts [m].
    out_dir, force, progress : Folder of the results; write all the same; shows figures.
    crew : Workers that share the figures; None: this process draws.
    """

    def write() -> list[Path]:
        drawn = drawn_figures(_groups(content, room_map, rooms), crew)
        written = _results(content, room_map, out_dir)
        written += _tables(content.missions, out_dir)
        figures = _figures(drawn, out_dir, progress)
        written += [path for entries in figures.values() for _, _, path in entries]
        report = out_dir / "report.html"
        with progress.during("report"):
            write_text(report, render_report(study_report(content, room_map, figures)))
        return [*written, report]

    write_once(
        out_dir / "stages" / "finished.json",
        {
            "cells": [[c.key, c.reason] for c in content.cells],
            "missions": [[m.folder.name, m.reason] for d in content.driven for m in d.missions],
            "map": content.setting.study.map.spacing_m,
            "as_built": None if content.as_built is None else list(content.as_built.paragraphs),
            "study": content.study_toml,
        },
        write,
        force=force,
        progress=progress,
    )


def _results(content: StudyContent, room_map: "xr.Dataset", out_dir: Path) -> list[Path]:
    """Write the results file and the table of designs."""
    from octant.reader_design.experiments.study.results import design_table, study_dataset

    written = [out_dir / "results.nc", out_dir / "designs.csv"]
    write_dataset(study_dataset(content, room_map), written[0], force=True)
    header, rows = design_table(content)
    put_table(str(written[1]), header, rows, force=True)
    return written


def _tables(missions: Sequence[RoomMission], out_dir: Path) -> list[Path]:
    """Copy the tables of the missions: missions.csv for the study's room, others by layout."""
    written = []
    for mission in missions:
        if mission.data is None:
            continue
        ending = ".csv" if mission.slug == "room" else f"-{mission.slug}.csv"
        for stem in ("missions", "trajectory"):
            target = out_dir / f"{stem}{ending}"
            with whole_file(target) as part:
                part.write_bytes((mission.folder / f"{stem}.csv").read_bytes())
            written.append(target)
    return written


def _figures(
    drawn: Iterable[DrawnFigure], out_dir: Path, progress: Progress
) -> dict[str, list[tuple[str, str, Path]]]:
    """Write all figures; return title, caption and file of each by section."""
    entries: dict[str, list[tuple[str, str, Path]]] = {}
    with progress.track(drawn, label="figures") as figures:
        for one in figures:
            path = out_dir / "figures" / one.file
            with whole_file(path) as part:
                part.write_bytes(one.png)
            entries.setdefault(one.section, []).append((one.title, one.caption, path))
    return entries


def _groups(
    content: StudyContent, room_map: "xr.Dataset", rooms: Sequence[tuple[str, str, Setting]]
) -> list[Group]:
    """Return what makes the figures of each part of the report, in its order.

    A quick look draws what stands first in each part.
    """
    from octant.reader_design.experiments.study import figures, sweep_figures
    from octant.reader_design.experiments.study.rfid_section import rfid_figures
    from octant.reader_design.experiments.study.thesis_plots import thesis_figures
    from octant.reader_design.showing.plan import plan_of

    study, setting, cell = content.setting.study, content.setting, content.chosen_cell
    elements = cell.design.body().element_azimuths_rad
    plans = [plan_of(built.scene, built.reader_z_m) for _, _, built in rooms]
    pairs = list(zip(content.missions, plans, strict=False))
    floor = figures.FloorData.of(setting, room_map)
    first: list[Group] = [
        partial(figures.scene_figures, setting),
        partial(
            sweep_figures.comparison_figures, content.cells, content.candidates, content.choice
        ),
        partial(figures.pattern_figures, cell, elements),
        partial(figures.level_figures, floor),
        *([partial(rfid_figures, setting, room_map)] if "wake_margin_db" in room_map else []),
        partial(figures.way_figures, setting, pairs, label=cell.label),
    ]
    if content.quick:
        return first
    hertz = study.radio.frequency_hz
    thesis = () if content.thesis is None else (content.thesis,)
    return [
        *first,
        partial(sweep_figures.antenna_figures, content.cells, frequency_hz=hertz),
        *(partial(thesis_figures, one, content.cells) for one in thesis),
        partial(figures.error_figures, study, cell, elements, figures.room_samples(room_map)),
        partial(figures.tag_level_figures, floor),
        partial(figures.heading_error_figures, floor, elements),
        partial(figures.all_headings_figures, floor),
        partial(figures.capture_figures, floor),
        partial(figures.drive_figures, setting, pairs),
    ]
