"""Error against number, spacing and range of the tags, thesis 6.5.5: the chapter ``tags``."""

import math
from collections.abc import Iterator
from dataclasses import replace

import msgspec
import numpy as np

from octant.navigation.sensing.rss_models import XBEE_DISTANCES_M
from octant.navigation.sensing.tag_layouts import tags_heard
from octant.reader_design.experiments.tracking.chapters import (
    EKF,
    driven,
    neighbouring_setup,
    thesis_filter,
)
from octant.reader_design.experiments.tracking.parts import (
    ChapterTable,
    FurtherChapter,
    Part,
    PartRecord,
    Records,
    middle_and_90,
    rows_of,
)
from octant.reader_design.experiments.tracking.settings import (
    Settings,
)
from octant.reader_design.showing.style import NamedFigure, figure_style, new_figure

SPACING, FIELD, RANGE = "spacing kept", "field kept", "range"
"""The mesh grows with the number of tags; or it does not; or the tags' range is what changes."""
CALIBRATED_M = max(XBEE_DISTANCES_M)
"""Largest distance of the calibration, thesis Table 6.1 [m]."""
COLUMNS = (
    "trajectory",
    "layout",
    "tags",
    "field_m",
    "range_m",
    "average_m_median",
    "average_m_90",
    "heard_range_m",
    "heard_least_on_way",
    "heard_least_in_field",
    "share_of_way_with_least_tags",
)
"""Columns of tags.csv [m]; range_m is empty where tags are heard everywhere; heard_range_m, within
which tags are counted, is then the largest distance of the calibration."""


def parts(settings: Settings) -> list[Part]:
    """Return a part for each trajectory with each number and each range of the tags.

    Parameters
    ----------
    settings : The study.
    """
    track, given = settings.track, settings.given_tags_m
    most = math.inf if given is None else len(given)
    counts = [count for count in track.tag_counts if count <= most]
    # Without a spacing to keep: given tags, those on a circle, and those of a field that is given.
    ways = (SPACING, FIELD) if _has_spacing(settings) else (FIELD,)
    names = tuple(settings.tasks)
    return [
        *(
            Part(chapter="tags", task=way, method=name, run=count)
            for name in names
            for way in ways
            for count in counts
        ),
        *(
            Part(chapter="tags", task=RANGE, method=name, sigma=range_m)
            for name in names
            for range_m in track.tag_ranges_m
        ),
    ]


def _has_spacing(settings: Settings) -> bool:
    track = settings.track
    return (
        settings.given_tags_m is None and track.tag_field_m is None and track.tag_pattern == "mesh"
    )


def _with(settings: Settings, part: Part) -> Settings:
    """Return the settings of a part: other tags, or another range of theirs."""
    track, given = settings.track, settings.given_tags_m
    if part.task == RANGE:
        return replace(settings, track=msgspec.structs.replace(track, tag_range_m=part.sigma))
    field_m = track.tag_field_m
    if part.task == FIELD and _has_spacing(settings):
        field_m = track.tag_spacing_m * (track.tags - 1 or 1)
    return replace(
        settings,
        track=msgspec.structs.replace(track, tag_count=part.run, tag_field_m=field_m),
        given_tags_m=None if given is None else given[: part.run],
    )


def compute(settings: Settings, part: Part) -> PartRecord:
    """Return one trajectory driven among the tags of a part.

    Parameters
    ----------
    settings, part : The study, and one of its `parts`.
    """
    task = settings.tasks[part.method]
    changed = _with(settings, part)
    tags_m, track = changed.mesh.tags_m, changed.track
    setup = neighbouring_setup(changed, task.curve, task.start, weights=task.weights)
    what = f"{part.sigma:g} m range" if part.task == RANGE else f"{part.run} tags, {part.task}"
    outcome = driven(
        changed,
        setup,
        EKF,
        setup.control,
        thesis_filter(changed),
        chapter="tags",
        task=f"{part.method}, {what}",
    )
    range_m = track.tag_range_m or CALIBRATED_M
    on_way = tags_heard(setup.desired.poses, tags_m, range_m=range_m)
    field_m = float(np.ptp(tags_m[:, :2], axis=0).max())
    corners = [np.linspace(tags_m[:, axis].min(), tags_m[:, axis].max(), 41) for axis in range(2)]
    floor = np.stack(np.meshgrid(*corners), axis=-1).reshape(-1, 2)
    row = (
        part.method,
        part.task,
        len(tags_m),
        field_m,
        track.tag_range_m,
        *middle_and_90(outcome.measures()["average_m"]),
        range_m,
        int(on_way.min()),
        int(tags_heard(floor, tags_m, range_m=range_m).min()),
        float(np.mean(on_way >= track.least_tags)),
    )
    return PartRecord(outcomes=(outcome,), rows=(row,))


def said(settings: Settings, records: Records) -> tuple[str, ...]:
    """Return the sentences on the page.

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    least = settings.track.least_tags
    short = [row for row in rows_of(records) if float(row[-1] or 0.0) < 1.0]
    heard = (
        f"Of {len(records)} layouts and ranges, {len(short)} leave the robot somewhere on its way "
        f"with fewer than {least} tags in range (thesis 6.5.5 wants at least that many, each "
        "within the distances of its calibration)."
    )
    return (
        (
            "More tags follow better, but less so than it seems: with the spacing kept, the mesh "
            "grows beyond the trajectory, and in the law (6.2) far tags change most with the "
            "place. With the field kept, the error falls more slowly than with the root of their "
            "number: in the bends the robot is off its trajectory whatever it knows of its place."
        ),
        heard,
    )


def tables(settings: Settings, records: Records) -> tuple[ChapterTable, ...]:
    """Return the chapter's table.

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    caption = (
        f"Average error, median and 90 % over {settings.track.runs} runs, and how many tags are in "
        "range."
    )
    return (ChapterTable(file="tags.csv", caption=caption, header=COLUMNS, rows=rows_of(records)),)


def figures(settings: Settings, records: Records) -> Iterator[NamedFigure]:
    """Yield the error against the number of tags, and against their range [m].

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    colours = ("#332288", "#cc6677", "#117733", "#ddaa33", "#88ccee", "#aa4499")
    names = tuple(dict.fromkeys(part.method for part, _ in records))
    with figure_style():
        figure, (axes,) = new_figure(
            width_in=10.4, height_in=4.0, title="Error against number and range of tags", columns=2
        )
        lines = [(name, task) for name in names for task in (SPACING, FIELD, RANGE)]
        for i, (name, task) in enumerate(lines):
            rows = [
                row
                for part, one in records
                if (part.method, part.task) == (name, task)
                for row in one.rows
            ]
            if not rows:
                continue
            numbers = np.array([[row[2], row[4] or 0.0, row[5], row[6]] for row in rows], float)
            x = numbers[:, 1 if task == RANGE else 0]
            ax = axes[1 if task == RANGE else 0]
            colour = colours[i % len(colours)]
            label = name if task == RANGE else f"{name}, {task}"
            ax.plot(x, numbers[:, 2], "o-", color=colour, label=label)
            ax.plot(x, numbers[:, 3], "_", color=colour, markersize=9)
        axes[0].set_xscale("log")
        axes[0].set_xticks(
            list(settings.track.tag_counts), list(map(str, settings.track.tag_counts))
        )
        axes[0].minorticks_off()
        axes[0].set_xlabel("number of tags")
        axes[1].set_xlabel("range of a tag [m]")
        for ax, title in zip(axes, ("number", "range"), strict=True):
            ax.set_ylabel("average error [m]")
            ax.set_title(f"{title} of tags: median (dots), 90 % (dashes)")
            if ax.get_legend_handles_labels()[1]:
                ax.legend()
    yield NamedFigure(
        file="tags.png",
        section="tags",
        title="Number and range of tags (thesis 6.5.5)",
        caption="Left, the average error against the number of tags, with the spacing or the field "
        "of the mesh kept; right, against the range of a tag.",
        figure=figure,
    )


CHAPTER = FurtherChapter(
    heading="Number and range of the tags (6.5.5)",
    parts=parts,
    compute=compute,
    said=said,
    tables=tables,
    figures=figures,
)
