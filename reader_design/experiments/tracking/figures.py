"""The figures of a tracking study, and the sentence that says what to see in each."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.navigation.angles import wrap_angle
from octant.navigation.estimators.ekf_slam import SlamRecord
from octant.navigation.sensing.rss_models import RssNoise
from octant.reader_design.experiments.tracking.chapters import (
    EKF,
    IGNORED,
    ILQR,
    MPC,
    PRINTED,
    PUBLISHED_FIT,
    PUBLISHED_NOISY_FIT,
    RssFits,
    laboratory_tags_m,
)
from octant.reader_design.experiments.tracking.compute import TrackingContent
from octant.reader_design.experiments.tracking.cost_scalings import CostScaling
from octant.reader_design.experiments.tracking.further import FURTHER
from octant.reader_design.experiments.tracking.results import Outcome
from octant.reader_design.experiments.tracking.room import RoomRuns
from octant.reader_design.experiments.tracking.task_figure import (
    COLOURS,
    WANTED,
    draw_arrow,
    tracking_figure,
)
from octant.reader_design.showing.style import NamedFigure, figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]


FIGURES = {
    "line": ("fig_6_4_line.png", "6.4"),
    "sine": ("fig_6_5_sine.png", "6.5"),
    "lemniscate": ("fig_7_7_lemniscate.png", "7.7"),
    "point": ("fig_7_6_stabilisation.png", "7.6"),
}
NOMINAL_FIGURES = {
    "point": ("fig_7_3_point.png", "7.3(a), (c), (d)"),
    "sigmoid": ("fig_7_4_sigmoid.png", "7.4(a), (c), (e)"),
    "parabola": ("fig_7_4_parabola.png", "7.4(b), (d), (f)"),
    "ellipse": ("fig_7_5_ellipse.png", "7.5"),
}


def tracking_figures(content: TrackingContent) -> Iterator[NamedFigure]:
    """Yield the figures of a tracking study, chapter by chapter; axes in [m], [s], [°], [dBm].

    Parameters
    ----------
    content : What was computed.
    """
    if content.fits is not None:
        yield NamedFigure(
            file="fig_6_3_rss.png",
            section="rss",
            title="RSS samples and fits (thesis Fig. 6.3)",
            caption="Left, the samples (Table 6.1 unless the study has its own) with the law (6.2) "
            "as printed and as fitted, and the log-distance law; right, one noisy record, its "
            "mean, and the printed noisy fit, which lies far below it.",
            figure=rss_fit_figure(content.fits, seed=content.settings.study.seed),
        )
    yield from _feedback(content)
    yield from _nominal(content)
    yield from _neighbouring(content)
    if content.slam:
        sigma, record = content.slam[0]
        yield NamedFigure(
            file="fig_7_15_slam.png",
            section="slam",
            title="EKF SLAM (thesis Fig. 7.15)",
            caption="Range and bearing are so noisy that the tags are located to some decimetres "
            "only; the pose, exact to millimetres, comes from the wheels.",
            figure=slam_figure(
                record, laboratory_tags_m(content.settings)[:, :2], wheel_sigma=sigma
            ),
        )
    if content.room:
        yield NamedFigure(
            file="room_estimators.png",
            section="room",
            title="RSS from the room solver",
            caption="Left, the coherent field of one tag at the robot's height; right, how well "
            "each estimator follows the lemniscate.",
            figure=room_figure(content.room),
        )
    for name, records in content.further.items():
        yield from FURTHER[name].figures(content.settings, records)
    if content.scalings:
        yield NamedFigure(
            file="costs.png",
            section="costs",
            title="Measured cost (Table 8.1)",
            caption="How the time of a control step and of a training iteration grows; the "
            "exponent is fitted to the three largest sizes.",
            figure=cost_figure(content.scalings),
        )


def _feedback(content: TrackingContent) -> Iterator[NamedFigure]:
    tags = content.settings.feedback_tags_m
    for task in dict.fromkeys(o.task for o in content.feedback):
        shown = [o for o in content.feedback if o.task == task]
        file, number = FIGURES[task]
        published = task != "lemniscate"
        yield NamedFigure(
            file=file if published else "feedback_lemniscate.png",
            section="feedback",
            title=f"Measurement feedback: {task}"
            + (f" (thesis Fig. {number})" if published else ""),
            caption="Gains trained on one noise record fit that record only: with the same noise "
            "the robot stays close to the trajectory, with fresh noise it does not; gains trained "
            "over many records are in between."
            if published
            else "Trained over many records and tested with fresh noise, for Table 8.1.",
            figure=tracking_figure(shown, title=f"Measurement feedback: {task}", tags_m=tags),
        )


def _nominal(content: TrackingContent) -> Iterator[NamedFigure]:
    for task, (file, number) in NOMINAL_FIGURES.items():
        runs = [r for r in content.nominal if r.outcome.task == task]
        shown = [r.outcome for r in runs if r.outcome.method in (ILQR, PRINTED)]
        if not shown:
            continue
        yield NamedFigure(
            file=file,
            section="nominal",
            title=f"Nominal control: {task} (thesis Fig. {number})",
            caption="Without noise and with the whole state known."
            + (
                " The printed update ran for 20 000 iterations, iLQR for some tens."
                if len(shown) > 1
                else ""
            ),
            figure=tracking_figure(shown, title=f"Nominal optimal control: {task}"),
        )
        if task == "ellipse":
            solvers = [(r.outcome.method, r.solution.costs) for r in runs]
            yield NamedFigure(
                file="nominal_convergence.png",
                section="nominal",
                title="Convergence of three solvers",
                caption="Lowest cost so far on the ellipse, by iteration.",
                figure=convergence_figure(solvers, task=task),
            )
    for run in content.nominal:
        if run.outcome.task == "eight poses":
            yield NamedFigure(
                file="fig_7_3_eight_poses.png",
                section="nominal",
                title="Eight poses (thesis Fig. 7.3(b))",
                caption="From every side the robot reaches the goal and its heading.",
                figure=eight_poses_figure(run.outcome),
            )


def _neighbouring(content: TrackingContent) -> Iterator[NamedFigure]:
    outcomes = content.neighbouring
    tags = content.settings.mesh.tags_m
    for index, task in enumerate(dict.fromkeys(o.task for o in outcomes)):
        shown = [o for o in outcomes if o.task == task and o.method in (EKF, MPC, IGNORED)]
        file, number = FIGURES.get(task, ("", "")) if index < 2 else ("", "")
        yield NamedFigure(
            file=file or f"own_{index - 1}.png",
            section="neighbouring",
            title=f"Neighbouring control: {task}" + (f" (thesis Fig. {number})" if number else ""),
            caption="From noisy RSS of the tags on the ceiling; the noise's mean must be "
            "estimated with the pose, otherwise it pulls the robot off its trajectory.",
            figure=tracking_figure(shown, title=f"Neighbouring control: {task}", tags_m=tags),
        )


def rss_fit_figure(fits: RssFits, *, seed: int) -> "Figure":
    """Return the samples of Table 6.1 with their fits, and a noisy record: thesis Fig. 6.3 [dBm].

    Parameters
    ----------
    fits, seed : The fits, and the seed of the noisy record.
    """
    ends = float(fits.distance_m.min()), float(fits.distance_m.max())
    distance = np.linspace(min(3.0, ends[0]), max(6.2, ends[1]), 200)
    noise, rng = RssNoise(), np.random.default_rng([seed, 3])
    noisy = PUBLISHED_FIT.rss_dbm(distance) + noise.draw(distance.shape, rng)
    with figure_style():
        figure, axes = new_figure(
            width_in=9.6, height_in=3.9, title="RSS of a tag against distance", columns=2
        )
        left, right = axes[0]
        left.plot(fits.distance_m, fits.rss_dbm, "o", color="#222222", label="samples")
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


def eight_poses_figure(outcome: Outcome) -> "Figure":
    """Return the paths from eight poses to one, and their errors: thesis Fig. 7.3(b) [m].

    Parameters
    ----------
    outcome : One run for each pose.
    """
    with figure_style():
        figure, (axes,) = new_figure(
            width_in=9.6, height_in=4.5, title="Point stabilisation from eight poses", columns=2
        )
        for number, (poses, errors) in enumerate(
            zip(outcome.runs.poses, outcome.runs.errors_m, strict=True)
        ):
            colour = COLOURS[number % len(COLOURS)]
            dash = "-" if number < len(COLOURS) else "--"
            label = f"from {45 * number}°"
            axes[0].plot(*poses[:, :2].T, color=colour, linestyle=dash, label=label)
            draw_arrow(axes[0], poses[0], colour=colour, face="white")
            axes[1].semilogy(
                outcome.runs.desired.time_s, np.maximum(errors, 1e-4), color=colour, linestyle=dash
            )
        draw_arrow(axes[0], outcome.runs.desired.poses[-1], colour="#222222", face="#222222")
        axes[0].margins(0.12)
        axes[0].set_aspect("equal", adjustable="datalim")
        axes[0].set_title("path; hollow: start, solid: goal")
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
    solvers, task : Names and costs J after every iteration [-], and what was solved.
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


ELLIPSE_SCALE = 50.0
"""The pose's one-sigma ellipse is millimetres wide: it is drawn this much larger [-]."""


def slam_figure(record: SlamRecord, tags_m: FloatArray, *, wheel_sigma: float) -> "Figure":
    """Return path, map and errors of EKF SLAM: thesis Fig. 7.15.

    Parameters
    ----------
    record, wheel_sigma : Runs, of which run 0 is drawn, and their noise of the wheels [rad/s].
    tags_m : (s, 2) float64 — True tags [m].
    """
    from matplotlib.gridspec import GridSpec

    with figure_style():
        figure, axes = new_figure(
            width_in=11.0,
            height_in=5.2,
            title=f"EKF SLAM along 3 m, wheel noise {wheel_sigma:g} rad/s",
            columns=1,
        )
        axes[0, 0].remove()
        grid = GridSpec(3, 2, figure=figure)
        plan = figure.add_subplot(grid[:, 0])
        plan.plot(*tags_m.T, "x", color="#222222", label="tags")
        plan.plot(*record.true_poses[0, :, :2].T, color=WANTED, linewidth=4, label="true path")
        plan.plot(*record.poses[0, :, :2].T, color=COLOURS[0], label="estimated path")
        mean, covariance = record.final.mean[0], record.final.covariance[0]
        label: str | None = f"pose, one sigma x {ELLIPSE_SCALE:g}"
        _ellipse(plan, mean[:2], ELLIPSE_SCALE**2 * covariance[:2, :2], COLOURS[0], label)
        for tag in range(len(tags_m)):
            at = slice(3 + 2 * tag, 5 + 2 * tag)
            label = "tags by SLAM, one sigma" if tag == 0 else None
            _ellipse(plan, mean[at], covariance[at, at], COLOURS[1], label)
        plan.set_aspect("equal", adjustable="datalim")
        plan.set_title("plan (run 0)")
        plan.set_xlabel("x [m]")
        plan.set_ylabel("y [m]")
        plan.legend(loc="upper center", bbox_to_anchor=(0.5, -0.11), ncols=3)
        error = record.poses - record.true_poses
        error[..., 2] = wrap_angle(error[..., 2])
        names = (("x", 1000.0, "mm"), ("y", 1000.0, "mm"), ("heading", np.degrees(1.0), "°"))
        for row, (name, scale, unit) in enumerate(names):
            ax = figure.add_subplot(grid[row, 1])
            ax.plot(record.time_s, scale * error[:, :, row].T, color="#bbbbbb", linewidth=0.4)
            ax.plot(record.time_s, scale * error[0, :, row], color=COLOURS[0], linewidth=1.3)
            for sign in (-1.0, 1.0):
                sigma = sign * scale * record.sigmas[0, :, row]
                ax.plot(record.time_s, sigma, color=COLOURS[1], linestyle="--", linewidth=1.2)
            ax.set_ylabel(f"{name} error [{unit}]")
        figure.axes[1].set_title("errors: run 0, all runs (grey), ± one sigma (dashed)")
        figure.axes[-1].set_xlabel("time [s]")
    return figure


def _ellipse(
    ax: "Axes", centre: FloatArray, covariance: FloatArray, colour: str, label: str | None
) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 100)
    root = np.linalg.cholesky(covariance + 1e-15 * np.eye(2))
    points = centre[:, None] + root @ np.stack([np.cos(angle), np.sin(angle)])
    ax.plot(*centre, "+", color=colour)
    ax.plot(*points, color=colour, linewidth=1.0, label=label)


def room_figure(rooms: Sequence[RoomRuns]) -> "Figure":
    """Return the field of one tag with the path of run 0, and the errors of all estimators.

    Parameters
    ----------
    rooms : The room solver's part, mesh by mesh ([m], [dBm]); the map is that of the first.
    """
    outcomes = [outcome for runs in rooms for outcome in runs.outcomes]
    tasks = tuple(dict.fromkeys(o.task for o in outcomes))
    methods = tuple(dict.fromkeys(o.method for o in outcomes))
    first, best = rooms[0], outcomes[0]
    with figure_style():
        figure, (axes,) = new_figure(
            width_in=12.0,
            height_in=4.8,
            title="Tracking the lemniscate with RSS from the room solver",
            columns=2,
        )
        ax = axes[0]
        ax.grid(visible=False)
        mesh = ax.pcolormesh(
            first.map_x_m, first.map_x_m, first.map_dbm.T, shading="nearest", rasterized=True
        )
        figure.colorbar(mesh, ax=ax, label="RSS of the middle tag [dBm]")
        ax.plot(*best.runs.desired.poses[:, :2].T, color="white", linewidth=3, label="desired")
        ax.plot(*best.runs.poses[0, :, :2].T, color=COLOURS[1], linewidth=1.3, label=best.method)
        ax.set_aspect("equal")
        ax.set_title(f"coherent field, and run 0 with {best.task}")
        ax.set_xlabel("x [m]")
        ax.set_ylabel("y [m]")
        ax.legend(loc="lower left", frameon=True, fontsize=7.5)
        _draw_averages(axes[1], outcomes, tasks, methods)
    return figure


def _draw_averages(
    ax: "Axes", outcomes: Sequence[Outcome], tasks: Sequence[str], methods: Sequence[str]
) -> None:
    from matplotlib.ticker import LogLocator, NullFormatter

    width = 0.8 / len(tasks)
    for t, task in enumerate(tasks):
        for m, method in enumerate(methods):
            for outcome in outcomes:
                if (outcome.task, outcome.method) != (task, method):
                    continue
                average = outcome.measures()["average_m"]
                row = len(methods) - 1 - m + (0.5 * (len(tasks) - 1) - t) * width
                label = task if m == 0 else None
                median = float(np.median(average))
                ax.barh(row, median, height=0.9 * width, color=COLOURS[t], alpha=0.75, label=label)
                ax.plot(average, np.full(len(average), row), ".", color="#222222", markersize=2)
                right = 1.08 * float(average.max())
                ax.text(right, row, f"{median:.3f}", va="center", fontsize=7.5)
    ax.set_yticks(np.arange(len(methods))[::-1], methods)
    ax.set_xscale("log")
    ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    ax.xaxis.set_major_formatter("{x:g}")
    ax.xaxis.set_minor_formatter(NullFormatter())
    ax.margins(x=0.12)
    ax.set_title("average error: median (bar), every run (dots)")
    ax.set_xlabel("average distance to the desired place [m]")
    ax.legend(loc="upper center", bbox_to_anchor=(0.35, -0.12), ncols=2)


def cost_figure(scalings: Sequence[CostScaling]) -> "Figure":
    """Return measured costs against the size that Table 8.1 calls proportional to them.

    Parameters
    ----------
    scalings : One panel each; times in [µs].
    """
    with figure_style():
        rows = -(-len(scalings) // 3)
        figure, axes = new_figure(
            width_in=12.1,
            height_in=3.8 * rows,
            title="Measured cost against Table 8.1",
            rows=rows,
            columns=3,
        )
        for ax, scaling in zip(axes.ravel(), scalings, strict=False):
            for (name, times), colour in zip(scaling.times_us.items(), COLOURS, strict=False):
                slope = scaling.exponent(name)
                ax.loglog(
                    scaling.sizes, times, "o-", color=colour, label=f"{name}: ∝ n^{slope:.2f}"
                )
            first = next(iter(scaling.times_us.values()))
            sizes = np.asarray(scaling.sizes, dtype=np.float64)
            ax.loglog(
                sizes, first[-1] * sizes / sizes[-1], "--", color=WANTED, label="proportional"
            )
            ax.set_xticks(scaling.sizes, list(map(str, scaling.sizes)))
            ax.tick_params(axis="x", which="minor", bottom=False, labelbottom=False)
            ax.set_xlabel(scaling.quantity)
            ax.set_ylabel("time [µs]")
            ax.set_title(scaling.what)
            ax.legend(fontsize=7.5)
    return figure
