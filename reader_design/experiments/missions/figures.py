"""Figures of single runs, of the fuzzy controller, and of comparisons."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.navigation.control.fuzzy import FuzzyVariable, RuleBase
from octant.reader_design.experiments.missions.comparison import CellOutcome, layouts_of
from octant.reader_design.experiments.missions.drive_figures import PATH_COLOUR, Drive
from octant.reader_design.showing.plan import Plan, draw_plan, draw_tags
from octant.reader_design.showing.style import (
    ANTENNA_COLOURS,
    antenna_legend,
    draw_antennas,
    figure_style,
    new_figure,
)
from octant.reader_design.study_file.mission import Mission
from octant.reader_design.study_file.rules import mission_rules

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]


SPAN_DB = 60.0
"""Range of RSS that is shown below the greatest value [dB]."""


def run_figure(drive: Drive, plan: Plan, tags: Mapping[str, FloatArray], *, title: str) -> "Figure":
    """Return path [m], errors [cm], [deg] and RSS [dBm] of one run, as thesis Figs. 5.12 to 5.14.

    Parameters
    ----------
    drive, plan, tags, title : Run, walls and objects, points to visit in order [m], text above.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with figure_style():
        figure = Figure(figsize=(9.8, 4.4), layout="constrained")
        FigureCanvasAgg(figure)
        figure.suptitle(title, x=0.012, ha="left", fontsize=12, fontweight="bold", color="#222222")
        grid = figure.add_gridspec(3, 2, width_ratios=(1.0, 1.25), height_ratios=(1.0, 1.0, 1.8))
        _draw_path(figure.add_subplot(grid[:, 0]), drive, plan, tags)
        position = figure.add_subplot(grid[0, 1])
        heading = figure.add_subplot(grid[1, 1], sharex=position)
        _draw_error(position, drive, 100.0 * drive.position_error_m, unit="cm", what="position")
        degrees = np.degrees(np.abs(drive.heading_error_rad))
        _draw_error(heading, drive, degrees, unit="°", what="heading")
        rss = figure.add_subplot(grid[2, 1], sharex=position)
        _draw_rss(rss, drive)
        for axes in (position, heading):
            axes.tick_params(labelbottom=False)
        for axes in (position, heading, rss):
            _mark_legs(axes, drive)
        _name_legs(rss, drive, list(tags))
        antenna_legend(figure, rss)
    return figure


def _draw_path(axes: "Axes", drive: Drive, plan: Plan, tags: Mapping[str, FloatArray]) -> None:
    points = np.array(list(tags.values())).reshape(-1, 2)
    draw_plan(axes, plan, extra_m=np.concatenate([points, drive.path_m]))
    wanted = np.concatenate([drive.path_m[:1], points])
    axes.plot(*wanted.T, "--", color="#777777", linewidth=1.2, label="desired", zorder=3)
    axes.plot(*drive.path_m.T, color=PATH_COLOUR, label="driven", zorder=4)
    axes.plot(*drive.path_m[0], "o", color=PATH_COLOUR, label="start", zorder=5)
    axes.plot(*drive.path_m[-1], "s", color=PATH_COLOUR, label="end", zorder=5)
    draw_tags(axes, tags)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=4, fontsize=8)


def _draw_error(axes: "Axes", drive: Drive, error: FloatArray, *, unit: str, what: str) -> None:
    axes.plot(drive.time_s, error, color=PATH_COLOUR, linewidth=1.2)
    known = error[np.isfinite(error)]
    if known.size:
        level = float(np.percentile(known, 90.0))
        axes.axhline(level, color="#cc6677", linestyle="--", linewidth=1.1)
        axes.annotate(
            f"90 %: {level:.3g}{'' if unit == '°' else ' '}{unit}",
            (1.0, level),
            xycoords=("axes fraction", "data"),
            xytext=(-3, 3),
            textcoords="offset points",
            ha="right",
            fontsize=8,
            color="#882233",
        )
        axes.set_ylim(0.0, max(1.05 * float(known.max()), 1.4 * level, 1e-6))
    axes.set_ylabel(f"{what} [{unit}]")


def _draw_rss(axes: "Axes", drive: Drive) -> None:
    level = power_dbm(np.maximum(drive.rss_w, 0.0))
    draw_antennas(axes, drive.time_s, level)
    finite = level[np.isfinite(level)]
    if finite.size:
        axes.set_ylim(max(float(finite.min()), float(finite.max()) - SPAN_DB) - 1, finite.max() + 6)
    axes.set_xlim(float(drive.time_s[0]), max(float(drive.time_s[-1]), 1e-9))
    axes.set_xlabel("time [s]")
    axes.set_ylabel("RSS [dBm]")


def _leg_starts(drive: Drive) -> npt.NDArray[np.int64]:
    return np.concatenate([[0], np.flatnonzero(np.diff(drive.target)) + 1])


def _mark_legs(axes: "Axes", drive: Drive) -> None:
    for start in _leg_starts(drive)[1:]:
        axes.axvline(drive.time_s[start], color="#555555", linewidth=0.9, linestyle=":")


def _name_legs(axes: "Axes", drive: Drive, names: Sequence[str]) -> None:
    upper = axes.get_ylim()[1]
    for start in _leg_starts(drive):
        axes.annotate(
            f"to {names[int(drive.target[start])]}",
            (float(drive.time_s[start]), upper),
            xytext=(3, -3),
            textcoords="offset points",
            va="top",
            fontsize=8,
            color="#444444",
        )


def comparison_figure(outcomes: Sequence[CellOutcome], *, title: str) -> "Figure":
    """Return success [%] and median RMSE [m] of every cell with their 95 % intervals.

    Parameters
    ----------
    outcomes, title : Of all cells; text above the figure.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    layouts = layouts_of(outcomes)
    labels = list(dict.fromkeys(outcome.cell.label for outcome in outcomes))
    gap = 1.0
    rows = len(outcomes) + gap * len(layouts)
    with figure_style():
        figure = Figure(figsize=(11.0, 1.6 + 0.2 * rows + 0.2 * len(labels)), layout="constrained")
        FigureCanvasAgg(figure)
        figure.suptitle(title, x=0.012, ha="left", fontsize=12, fontweight="bold", color="#222222")
        success, rmse = figure.subplots(1, 2, sharey=True)
        ticks, place = [], 0.0
        for name, group in layouts.items():
            ticks.append((place + 0.5 * (len(group) - 1), name))
            for outcome in group:
                _draw_cell(success, rmse, outcome, place, labels)
                place += 1.0
            published = group[0].cell.published_rmse_m
            if published is not None:
                middle = place - 0.5 * (len(group) + 1)
                rmse.plot(published, middle, "x", color="#cc3311", markersize=9, zorder=5)
            place += gap
            for axes in (success, rmse):
                axes.axhline(place - 0.5 * (1.0 + gap), color="#dddddd", linewidth=0.8)
        success.set_yticks([at for at, _ in ticks], [name for _, name in ticks])
        success.invert_yaxis()
        success.set_xlim(-2.0, 102.0)
        success.set_xlabel("runs that reached every tag [%]")
        rmse.set_xlim(left=0.0)
        rmse.set_xlabel("median RMSE of the runs that reached every tag [m]; red cross: published")
        handles, texts = success.get_legend_handles_labels()
        unique = dict(zip(texts, handles, strict=True))
        figure.legend(
            [unique[label] for label in labels if label in unique],
            [label for label in labels if label in unique],
            loc="outside lower center",
            ncols=2 if len(labels) > 3 else 1,
            fontsize=8,
        )
    return figure


def _draw_cell(
    success: "Axes", rmse: "Axes", outcome: CellOutcome, place: float, labels: Sequence[str]
) -> None:
    """Draw one cell's two dots with their intervals; nothing where it was not driven."""
    if outcome.runs == 0:
        return
    number = labels.index(outcome.cell.label)
    share = 100.0 * outcome.successes / outcome.runs
    low, high = (100.0 * end for end in outcome.success_interval)
    marks = [(success, share, (low, high))]
    if outcome.successes:
        marks.append((rmse, outcome.success_rmse_m, outcome.success_rmse_interval_m))
    for axes, value, (lower, upper) in marks:
        axes.errorbar(
            value,
            place,
            xerr=[[max(value - lower, 0.0)], [max(upper - value, 0.0)]],
            fmt="os^Dv<>P"[(number // len(ANTENNA_COLOURS)) % 8],
            color=ANTENNA_COLOURS[number % len(ANTENNA_COLOURS)],
            markersize=5,
            capsize=2,
            linewidth=1.1,
            label=outcome.cell.label,
        )


def controller_figure(table: Mission, *, name: str) -> "Figure | None":
    """Return the fuzzy terms and rules of a mission's controller; None: it has no such.

    Parameters
    ----------
    table, name : ``[mission]``; the study's.
    """
    if table.navigator != "thesis" or table.controller != "fuzzy":
        return None
    return membership_figure(
        mission_rules(table),
        title=f"{name}: rules of the fuzzy controller",
        full_scale_nw=table.full_scale_nw if table.steering_input == "nanowatt" else None,
    )


def membership_figure(
    rules: RuleBase, *, title: str, full_scale_nw: float | None = None
) -> "Figure":
    """Return the terms of the input, of a wheel's speed, and the outputs, as in thesis Fig. 5.5.

    Parameters
    ----------
    rules, title : One input, two outputs: right and left wheel; text above.
    full_scale_nw : Full scale of an input in watts [nW]; None: it has no unit.
    """
    scale, unit = (1.0, "-") if full_scale_nw is None else (full_scale_nw, "nW")
    label = f"steering input, right minus left [{unit}]"
    with figure_style():
        figure, axes = new_figure(columns=3, width_in=11.0, height_in=3.6, title=title)
        first, second, third = axes.ravel()
        _draw_terms(first, rules.input_variable, label, scale=scale)
        _draw_terms(second, rules.outputs[0], "wheel speed, 0.5 = cruise [-]")
        low, high = rules.input_variable.low, rules.input_variable.high
        x = np.linspace(low, high, 401)
        speeds = rules.infer(x)
        third.plot(scale * x, speeds[:, 0], color=ANTENNA_COLOURS[0], label="right wheel")
        third.plot(
            scale * x, speeds[:, 1], color=ANTENNA_COLOURS[4], linestyle="--", label="left wheel"
        )
        third.set_xlabel(label)
        third.set_ylabel("wheel speed, 0.5 = cruise [-]")
        third.set_ylim(0.0, 1.0)
        third.legend()
    return figure


def _draw_terms(axes: "Axes", variable: FuzzyVariable, label: str, *, scale: float = 1.0) -> None:
    x = np.linspace(variable.low, variable.high, 801)
    for number, term in enumerate(variable.terms):
        axes.plot(scale * x, term.membership(x), color=ANTENNA_COLOURS[number % 8], label=term.name)
    axes.set_xlabel(label)
    axes.set_ylabel("membership [-]")
    axes.set_ylim(0.0, 1.15)
    axes.legend(ncols=len(variable.terms), loc="upper center", fontsize=7, handlelength=1.0)
