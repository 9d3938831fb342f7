"""Which figures a tracking study leaves, with the sentence that says what to see in each."""

from collections.abc import Iterator

import numpy as np

from octant.reader_design.experiments.tracking.chapter7 import (
    EKF,
    IGNORED,
    ILQR,
    MPC,
    PRINTED,
    SLAM_TAGS_M,
)
from octant.reader_design.experiments.tracking.estimation_figures import (
    cost_figure,
    room_figure,
    slam_figure,
)
from octant.reader_design.experiments.tracking.figures import (
    convergence_figure,
    eight_poses_figure,
    rss_fit_figure,
    tracking_figure,
)
from octant.reader_design.experiments.tracking.run import TrackingContent
from octant.reader_design.showing.style import NamedFigure

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
    content : TrackingContent
        What was computed.
    """
    if content.fits is not None:
        yield NamedFigure(
            file="fig_6_3_rss.png",
            section="rss",
            title="RSS samples and fits (thesis Fig. 6.3)",
            caption="Left, Table 6.1 with the law (6.2) as printed and as fitted, and the "
            "log-distance law; right, one noisy record, its mean, and the printed noisy fit, "
            "which lies far below it.",
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
            caption="Range and bearing are so noisy that the tags are found no better than some "
            "decimetres; the pose, in millimetres, is that of the wheels.",
            figure=slam_figure(record, np.array(SLAM_TAGS_M), wheel_sigma=sigma),
        )
    if content.room is not None:
        yield NamedFigure(
            file="room_estimators.png",
            section="room",
            title="RSS from the room solver",
            caption="Left, the coherent field of one tag at the robot's height; right, how well "
            "each estimator keeps the lemniscate.",
            figure=room_figure(content.room),
        )
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
            caption="Gains trained on one noise record know it by heart: its replay is close to "
            "the way, fresh noise is not; gains trained over many records are in between."
            if published
            else "Trained over many records and driven through fresh noise, for Table 8.1.",
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
                " The printed update has had 20 000 iterations, iLQR some tens."
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
    if content.neighbouring is None:
        return
    outcomes = content.neighbouring.outcomes
    tags = content.settings.mesh.tags_m
    for index, task in enumerate(dict.fromkeys(o.task for o in outcomes)):
        shown = [o for o in outcomes if o.task == task and o.method in (EKF, MPC, IGNORED)]
        file, number = FIGURES.get(task, ("", "")) if index < 2 else ("", "")
        yield NamedFigure(
            file=file or f"own_{index - 1}.png",
            section="neighbouring",
            title=f"Neighbouring control: {task}" + (f" (thesis Fig. {number})" if number else ""),
            caption="From noisy RSS of the tags on the ceiling; the noise's mean must be "
            "estimated with the pose, or it pulls the robot off its way.",
            figure=tracking_figure(shown, title=f"Neighbouring control: {task}", tags_m=tags),
        )
