"""Figures of tracking: the way, the pose, the errors and the wheels of runs; thesis 6.3 to 7.7."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.navigation.missions.metrics import percentile_curve
from octant.navigation.sensing.rss_models import XBEE_DISTANCES_M, XBEE_RSS_DBM, RssNoise
from octant.reader_design.experiments.tracking.chapter6 import (
    PUBLISHED_FIT,
    PUBLISHED_NOISY_FIT,
    RssFits,
)
from octant.reader_design.experiments.tracking.outcomes import Outcome
from octant.reader_design.showing.style import figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

COLOURS = ("#332288", "#cc6677", "#117733", "#ddaa33", "#88ccee", "#aa4499")
"""Colour of each method in a figure."""
WANTED = "#999999"
"""Colour of what was desired."""
ARROW_M = 0.35
"""Length of the arrows at start and end [m]."""


def rss_fit_figure(fits: RssFits, *, seed: int) -> "Figure":
    """Return the samples of Table 6.1 with their fits, and a noisy record: thesis Fig. 6.3 [dBm].

    Parameters
    ----------
    fits : RssFits
        The fits.
    seed : int
        Of the noisy record that is drawn.
    """
    distance = np.linspace(3.0, 6.2, 200)
    noise, rng = RssNoise(), np.random.default_rng([seed, 3])
    noisy = PUBLISHED_FIT.rss_dbm(distance) + noise.draw(distance.shape, rng)
    with figure_style():
        figure, axes = new_figure(
            width_in=9.6, height_in=3.9, title="RSS of a tag against distance", columns=2
        )
        left, right = axes[0]
        left.plot(XBEE_DISTANCES_M, XBEE_RSS_DBM, "o", color="#222222", label="samples, Table 6.1")
        curves = (
            (PUBLISHED_FIT.rss_dbm(distance), "(6.2) as printed", COLOURS[1], "--"),
            (fits.exponential.rss_dbm(distance), "(6.2), least squares", COLOURS[0], "-"),
            (fits.distance.rss_dbm(distance), "log-distance, least squares", COLOURS[2], "-."),
        )
        for values, label, colour, dash in curves:
            left.plot(distance, values, color=colour, linestyle=dash, label=label)
        left.set_title("fits to the samples")
        right.plot(distance, noisy, ".", color="#bbbbbb", markersize=4, label="a noisy record")
        right.plot(
            distance,
            PUBLISHED_FIT.rss_dbm(distance) + noise.mean_db,
            color=COLOURS[0],
            label="mean of the noisy signal",
        )
        right.plot(
            distance,
            PUBLISHED_NOISY_FIT.rss_dbm(distance),
            color=COLOURS[1],
            linestyle="--",
            label="noisy fit as printed",
        )
        right.set_title(f"noise of {noise.mean_db:g} dB mean, {noise.sigma_db:g} dB deviation")
        for ax in (left, right):
            ax.set_xlabel("distance between tag and reader [m]")
            ax.set_ylabel("RSS [dBm]")
            ax.legend()
    return figure


def tracking_figure(
    outcomes: Sequence[Outcome], *, title: str, tags_m: FloatArray | None = None
) -> "Figure":
    """Return six panels of a task: way, place, heading, error, its percentiles, wheel rates.

    Parameters
    ----------
    outcomes : sequence of Outcome
        The methods; ways, poses and wheels are those of run 0, errors the median over the runs.
    title : str
        Above the figure.
    tags_m : (s, 2) float64, optional
        Tags on the plan [m].
    """
    with figure_style():
        figure, axes = new_figure(width_in=12.4, height_in=7.2, title=title, rows=2, columns=3)
        _draw_ways(axes[0, 0], outcomes, tags_m)
        _draw_poses(axes[0, 1], axes[0, 2], outcomes)
        _draw_errors(axes[1, 0], axes[1, 1], outcomes)
        _draw_wheels(axes[1, 2], outcomes[0])
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


def _draw_ways(ax: "Axes", outcomes: Sequence[Outcome], tags_m: FloatArray | None) -> None:
    desired = outcomes[0].desired.poses
    if tags_m is not None:
        ax.plot(*tags_m[:, :2].T, "x", color="#666666", markersize=5, label="tags", linestyle="")
    ax.plot(*desired[:, :2].T, color=WANTED, linewidth=4, alpha=0.5, label="desired")
    for outcome, colour in zip(outcomes, COLOURS, strict=False):
        poses = outcome.poses[0]
        ax.plot(*poses[:, :2].T, color=colour, label=outcome.method, linewidth=1.2)
        for pose, face in ((poses[0], "white"), (poses[-1], colour)):
            _arrow(ax, pose, colour=colour, face=face)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_title("way (run 0); hollow: start")
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")


def _arrow(ax: "Axes", pose: FloatArray, *, colour: str, face: str) -> None:
    ax.annotate(
        "",
        xy=(pose[0] + ARROW_M * np.cos(pose[2]), pose[1] + ARROW_M * np.sin(pose[2])),
        xytext=(pose[0], pose[1]),
        arrowprops={"arrowstyle": "simple", "facecolor": face, "edgecolor": colour},
    )


def _draw_poses(place: "Axes", heading: "Axes", outcomes: Sequence[Outcome]) -> None:
    time = outcomes[0].desired.time_s
    desired = outcomes[0].desired.poses
    for axis, dash in ((0, "-"), (1, "--")):
        place.plot(time, desired[:, axis], color=WANTED, linewidth=3.5, alpha=0.5, linestyle=dash)
    heading.plot(time, np.degrees(desired[:, 2]), color=WANTED, linewidth=3.5, alpha=0.5)
    for outcome, colour in zip(outcomes, COLOURS, strict=False):
        for axis, dash in ((0, "-"), (1, "--")):
            place.plot(time, outcome.poses[0][:, axis], color=colour, linestyle=dash, linewidth=1)
        # Whole turns aside, next to the desired heading.
        turns = np.round((outcome.poses[0][:, 2] - desired[:, 2]) / (2.0 * np.pi))
        angle = outcome.poses[0][:, 2] - 2.0 * np.pi * turns
        heading.plot(time, np.degrees(angle), color=colour, linewidth=1)
    place.set_title("place (run 0): x solid, y dashed")
    place.set_ylabel("x, y [m]")
    heading.set_title("heading (run 0)")
    heading.set_ylabel("heading [°]")
    for ax in (place, heading):
        ax.set_xlabel("time [s]")


def _draw_errors(error: "Axes", share: "Axes", outcomes: Sequence[Outcome]) -> None:
    time = outcomes[0].desired.time_s
    for outcome, colour in zip(outcomes, COLOURS, strict=False):
        errors = outcome.record.errors_m
        middle = np.median(errors, axis=0)
        error.plot(time, middle, color=colour, linewidth=1.2)
        if len(errors) > 1:
            low, high = np.quantile(errors, [0.1, 0.9], axis=0)
            error.fill_between(time, low, high, color=colour, alpha=0.15, linewidth=0)
        percent, values = percentile_curve(errors.ravel())
        share.plot(percent, values, color=colour, linewidth=1.2)
    largest = max(float(np.quantile(o.record.errors_m, 0.97)) for o in outcomes)
    for ax in (error, share):
        ax.set_ylabel("distance to the desired place [m]")
        ax.set_ylim(0.0, 1.25 * largest)
    many = len(outcomes[0].poses) > 1
    error.set_title("error" + (": median, 10 to 90 % of the runs" if many else ""))
    error.set_xlabel("time [s]")
    share.set_title("error not exceeded" + (", all runs" if many else ""))
    share.set_xlabel("share of the time [%]")


def _draw_wheels(ax: "Axes", outcome: Outcome) -> None:
    time = outcome.desired.time_s[:-1]
    for wheel, (name, colour) in enumerate((("right", COLOURS[3]), ("left", COLOURS[2]))):
        ax.step(
            time, outcome.example_rates[:, wheel], where="post", color=colour, label=name, lw=0.9
        )
    ax.set_title(f"wheels (run 0): {outcome.method}")
    ax.set_xlabel("time [s]")
    ax.set_ylabel("wheel rate [rad/s]")
    ax.legend()


def eight_poses_figure(outcome: Outcome) -> "Figure":
    """Return the ways from eight poses to one, and their errors: thesis Fig. 7.3(b) [m].

    Parameters
    ----------
    outcome : Outcome
        One run for each pose.
    """
    with figure_style():
        figure, (axes,) = new_figure(
            width_in=9.6, height_in=4.5, title="Point stabilisation from eight poses", columns=2
        )
        for number, (poses, errors) in enumerate(
            zip(outcome.poses, outcome.record.errors_m, strict=True)
        ):
            colour = COLOURS[number % len(COLOURS)]
            dash = "-" if number < len(COLOURS) else "--"
            label = f"from {45 * number}°"
            axes[0].plot(*poses[:, :2].T, color=colour, linestyle=dash, label=label)
            _arrow(axes[0], poses[0], colour=colour, face="white")
            axes[1].semilogy(
                outcome.desired.time_s, np.maximum(errors, 1e-4), color=colour, linestyle=dash
            )
        _arrow(axes[0], outcome.desired.poses[-1], colour="#222222", face="#222222")
        axes[0].margins(0.12)
        axes[0].set_aspect("equal", adjustable="datalim")
        axes[0].set_title("way; hollow: start, solid: goal")
        axes[0].set_xlabel("x [m]")
        axes[0].set_ylabel("y [m]")
        axes[1].set_title("distance to the goal")
        axes[1].set_xlabel("time [s]")
        axes[1].set_ylabel("distance [m]")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside right center")
    return figure


def convergence_figure(solvers: Sequence[tuple[str, FloatArray]], *, task: str) -> "Figure":
    """Return the cost of the nominal solvers against the number of iterations.

    Parameters
    ----------
    solvers : sequence of (str, (i,) float64)
        Name and cost J after every iteration [-].
    task : str
        What was solved.
    """
    with figure_style():
        figure, axes = new_figure(
            width_in=6.4, height_in=4.0, title=f"Nominal control of the {task}: three solvers"
        )
        ax = axes[0, 0]
        for (name, costs), colour in zip(solvers, COLOURS, strict=False):
            lowest = np.minimum.accumulate(costs)
            ax.loglog(np.arange(1, len(costs) + 1), lowest, color=colour, label=name)
        ax.set_xlabel("iterations")
        ax.set_ylabel("lowest cost J so far")
        ax.legend()
    return figure
