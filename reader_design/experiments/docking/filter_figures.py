"""Figures of the landmark filters' experiments, figures 6 to 17 of the docking paper."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.navigation.angles import wrap_angle
from octant.navigation.control.polar import pose_in_goal_frame
from octant.navigation.estimators.kalman import consistency_band
from octant.navigation.estimators.landmark_filters import ATTITUDE, SLIP, SPIN
from octant.navigation.estimators.landmark_trials import Drives, Estimates
from octant.navigation.statistics import gaussianity
from octant.reader_design.experiments.docking.published import (
    FilterExperiment,
)
from octant.reader_design.showing.style import figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]


def filter_figures(experiment: FilterExperiment, straight: FilterExperiment) -> dict[str, "Figure"]:
    """Return the figures of the landmark filters, figures 6 to 17 of the paper [m], [s], [rad].

    Parameters
    ----------
    experiment, straight : Many drives and the simpler one, from `landmark_filters`.
    """
    drives, made = experiment.drives, experiment.estimates
    return {
        "dock_filter_path": filter_path_figure(
            drives,
            {"estimate": made["slips"], "estimate 2 (wrong start)": made["wrong start"]},
            title="Ground truth and estimates (Fig. 6)",
        ),
        "dock_filter_no_slips": filter_states_figure(
            drives, made["no slips"], title="Slips not estimated (Fig. 7 to 9)"
        ),
        "dock_filter_slips": filter_states_figure(
            drives, made["slips"], title="Slips estimated (Fig. 11 to 13)"
        ),
        "dock_slips": slips_figure(
            drives, made["slips"], title="Estimated slips, b = -0.01 m/s (Fig. 14 to 16)"
        ),
        "dock_filter_straight": filter_path_figure(
            straight.drives,
            {
                "estimate (no slips)": straight.estimates["no slips"],
                "estimate 2 (slips)": straight.estimates["slips"],
            },
            title="A drive at constant speed (Fig. 17)",
        ),
        "dock_histograms": error_histogram_figure(
            drives,
            {"slips": made["slips"], "no slips": made["no slips"]},
            at_s=float(drives.time_s[drives.blackout_end(30.0).max()]),
        ),
        "dock_consistency": consistency_figure(
            drives, {"coupled filter": made["slips"], "the paper's pair": made["pair"]}
        ),
    }


TRUTH, WITH, WITHOUT = "#222222", "#332288", "#cc6677"
_MARGIN_M = 0.4
_STATES = ((0, "e_x", "m"), (1, "e_y", "m"), (ATTITUDE, "ψ", "rad"))


def filter_path_figure(
    drives: Drives, estimates: dict[str, Estimates], *, title: str, run: int = 0
) -> "Figure":
    """Return the robot's true and estimated path in the landmark's frame [m], figures 6 and 17.

    Parameters
    ----------
    drives, estimates, run : Truth, paths to draw by the label of each, and which repetition.
    title : Above the figure.
    """
    with figure_style():
        figure, axes = new_figure(width_in=7.6, height_in=4.8, title=title)
        ax = axes[0, 0]
        ax.plot(*_way(drives.truth[:, run]).T, color=TRUTH, linewidth=2.2, label="ground truth")
        for name, made in estimates.items():
            ax.plot(*_way(made.mean[:, run]).T, linewidth=1.1, label=name)
        unseen = ~np.isfinite(drives.detections[:, run, 0])
        way = _way(drives.truth[:, run])
        ax.plot(*way[unseen].T, ".", color="#bbbbbb", markersize=3, label="landmark out of view")
        ax.plot(0.0, 0.0, "x", color="#222222", markersize=9, label="landmark")
        ax.set_aspect("equal")
        shown = np.vstack([way, [[0.0, 0.0]]])
        low, high = shown.min(axis=0), shown.max(axis=0)
        ax.set_xlim(low[0] - _MARGIN_M, high[0] + _MARGIN_M)  # a wrong start may lie far outside
        ax.set_ylim(low[1] - _MARGIN_M, high[1] + _MARGIN_M)
        ax.set_xlabel("x in the landmark's frame [m]")
        ax.set_ylabel("y in the landmark's frame [m]")
        figure.legend(*ax.get_legend_handles_labels(), loc="outside right center")
    return figure


def filter_states_figure(
    drives: Drives, estimates: Estimates, *, title: str, run: int = 0
) -> "Figure":
    """Return states, errors and their two sigma, figures 7 to 9 and 11 to 13 [m], [rad], [s].

    Parameters
    ----------
    drives, estimates, run : Truth, estimates of a filter, and which repetition.
    title : Above the figure; grey is where the landmark was out of view.
    """
    with figure_style():
        figure, axes = new_figure(width_in=10.0, height_in=6.6, title=title, rows=3, columns=2)
        time = drives.time_s
        for row, (state, name, unit) in zip(axes, _STATES, strict=True):
            truth, mean = drives.truth[:, run, state], estimates.mean[:, run, state]
            error, sd = mean - truth, np.sqrt(estimates.variance[:, run, state])
            if state == ATTITUDE:
                error = wrap_angle(error)
            row[0].plot(time, truth, color=TRUTH, linewidth=2.2, label="ground truth")
            row[0].plot(time, mean, color=WITH, linewidth=1.1, label="estimate")
            row[1].fill_between(
                time, -2 * sd, 2 * sd, color=WITH, alpha=0.15, linewidth=0, label="two sigma"
            )
            row[1].plot(time, error, color=WITHOUT, linewidth=1.1, label="error")
            row[0].set_ylabel(f"{name} [{unit}]")
            row[1].set_ylabel(f"error of {name} [{unit}]")
            for ax in row:
                _shade(ax, drives, run)
        for ax in axes[-1]:
            ax.set_xlabel("time [s]")
        legend_below(figure, axes[0, 0], axes[0, 1])
    return figure


def slips_figure(drives: Drives, estimates: Estimates, *, title: str) -> "Figure":
    """Return slips of run 0, and the range of 80 % of the runs, figures 14 to 16 [m/s], [rad/s].

    Parameters
    ----------
    drives, estimates : Truth and estimates; grey where run 0 did not see the landmark.
    title : Above the figure.
    """
    with figure_style():
        figure, axes = new_figure(width_in=10.0, height_in=3.8, title=title, columns=2)
        for ax, state, name, unit in (
            (axes[0, 0], SPIN, "angular slip s", "rad/s"),
            (axes[0, 1], SLIP, "linear slip b", "m/s"),
        ):
            low, high = np.quantile(estimates.mean[:, :, state], [0.1, 0.9], axis=1)
            ax.fill_between(
                drives.time_s, low, high, color=WITH, alpha=0.15, linewidth=0, label="80 % of runs"
            )
            ax.plot(drives.time_s, estimates.mean[:, 0, state], color=WITH, label="estimate")
            ax.plot(drives.time_s, drives.truth[:, 0, state], color=TRUTH, label="ground truth")
            centre = float(drives.truth[0, 0, state])
            ax.set_ylim(centre - 0.03, centre + 0.03)
            ax.set_xlabel("time [s]")
            ax.set_ylabel(f"{name} [{unit}]")
            _shade(ax, drives, 0)
        legend_below(figure, axes[0, 0])
    return figure


def error_histogram_figure(
    drives: Drives, estimates: dict[str, Estimates], *, at_s: float
) -> "Figure":
    """Return histograms of the errors at one time with a test for a Gaussian, figure 10.

    Parameters
    ----------
    drives, estimates : Truth, and estimates by label.
    at_s : Time [s]; runs are independent there, unlike the samples of one run.
    """
    step = int(np.searchsorted(drives.time_s, at_s))
    runs = drives.truth.shape[1]
    with figure_style():
        figure, axes = new_figure(
            width_in=10.0,
            height_in=1.2 + 2.6 * len(estimates),
            title=f"Errors of {runs} runs, {at_s:.0f} s after the start (Fig. 10)",
            rows=len(estimates),
            columns=3,
        )
        for row, (label, made) in zip(axes, estimates.items(), strict=True):
            for ax, (state, name, unit) in zip(row, _STATES, strict=True):
                error = (made.mean - drives.truth)[step, :, state]
                if state == ATTITUDE:
                    error = wrap_angle(error)
                test = gaussianity(error)
                ax.hist(error, bins=15, density=True, color=WITH, alpha=0.35, label="errors")
                x = np.linspace(error.min(), error.max(), 200)
                z = (x - test.mean) / test.standard_deviation
                bell = np.exp(-0.5 * z**2) / (test.standard_deviation * np.sqrt(2.0 * np.pi))
                ax.plot(x, bell, color=WITHOUT, label="Gaussian")
                ax.set_xlabel(f"error of {name} [{unit}]")
                ax.set_title(
                    f"{label}: σ = {test.standard_deviation:.3f} {unit}, p = {test.p_value:.2f}",
                    fontsize=9,
                )
            row[0].set_ylabel("density [1/unit]")
        legend_below(figure, axes[0, 0])
    return figure


def consistency_figure(drives: Drives, estimates: dict[str, Estimates]) -> "Figure":
    """Return the mean NEES over the runs and its band of 95 %.

    Parameters
    ----------
    drives, estimates : Times, and estimates by label.
    """
    low, high = consistency_band(degrees=5, samples=drives.truth.shape[1])
    with figure_style():
        figure, axes = new_figure(
            width_in=8.2, height_in=3.8, title="Consistency: normalised estimation error squared"
        )
        ax = axes[0, 0]
        ax.axhspan(low, high, color="#117733", alpha=0.18, linewidth=0, label="95 % band")
        for name, made in estimates.items():
            ax.semilogy(drives.time_s, made.nees.mean(axis=1), label=name)
        ax.set_xlabel("time [s]")
        ax.set_ylabel("mean NEES of 5 states [-]")
        figure.legend(*ax.get_legend_handles_labels(), loc="outside right center")
    return figure


def _way(state: FloatArray) -> FloatArray:
    """Return the robot's (n, 2) places in the landmark's frame from (n, 5) states."""
    return pose_in_goal_frame(np.zeros(3), state[:, [0, 1, ATTITUDE]])[:, :2]


def _shade(axes: "Axes", drives: Drives, run: int) -> None:
    unseen = drives.unseen_s[:, run] > 1.0
    axes.fill_between(
        drives.time_s,
        0.0,
        1.0,
        where=unseen.tolist(),
        transform=axes.get_xaxis_transform(),
        color="#999999",
        alpha=0.2,
        linewidth=0,
        label="landmark out of view",
    )


def legend_below(figure: "Figure", *axes: "Axes", columns: int = 5) -> None:
    """Draw one legend of several panels below them, each label once.

    Parameters
    ----------
    figure, axes, columns : The figure, its panels, and the columns of the legend.
    """
    entries = {
        label: handle
        for ax in axes
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True)
    }
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=columns)
