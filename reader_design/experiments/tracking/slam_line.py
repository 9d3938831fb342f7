"""EKF SLAM beside the filter on RSS, on the same line, thesis 7.7: the chapter ``slam line``."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from octant.navigation.estimators.ekf_slam import SlamRecord
from octant.navigation.estimators.pose_filters import DeadReckoning, PoseEstimator
from octant.navigation.estimators.rss_kalman import ExtendedKalman
from octant.navigation.sensing.rss_models import TagMesh
from octant.navigation.tracking.closed_loop import World, read_tags, run_seeds
from octant.reader_design.experiments.tracking.chapters import (
    SLAM_WHEEL_SIGMAS_RAD_PER_S,
    laboratory_tags_m,
    slam_record,
    slam_task,
)
from octant.reader_design.experiments.tracking.parts import (
    ChapterTable,
    FloatArray,
    FurtherChapter,
    Part,
    PartRecord,
    Records,
    Row,
    middle_and_90,
    rows_of,
)
from octant.reader_design.experiments.tracking.settings import Settings
from octant.reader_design.experiments.tracking.task_figure import COLOURS
from octant.reader_design.showing.style import NamedFigure, figure_style, new_figure

SLAM, RSS, DEAD = "EKF SLAM", "EKF on RSS (neighbouring)", "dead reckoning"
COLUMNS = (
    "estimator",
    "wheel_sigma_rad_per_s",
    "runs",
    "average_m_median",
    "average_m_90",
    "final_m_median",
    "final_m_90",
    "second_half_over_first",
)
"""Columns of slam_line.csv [rad/s], [m]; errors of the estimated place."""


def parts(settings: Settings) -> list[Part]:
    """Return a part for each noise of the wheels.

    Parameters
    ----------
    settings : The study.
    """
    del settings
    return [Part(chapter="slam line", sigma=sigma) for sigma in SLAM_WHEEL_SIGMAS_RAD_PER_S]


def compute(settings: Settings, part: Part) -> PartRecord:
    """Return the errors of SLAM, of the filter on RSS and of dead reckoning on the same drives.

    Parameters
    ----------
    settings, part : The study, and one of its `parts`.
    """
    slam = slam_record(settings, part.sigma)
    task = slam_task(settings, part.sigma)
    motion, rates = task.motion, task.wheel_rates_rad_per_s
    mesh = TagMesh(tags_m=laboratory_tags_m(settings), law=settings.law)
    ekf: PoseEstimator[Any] = ExtendedKalman(motion=motion, sensor=mesh, noise=settings.assumptions)
    estimates: dict[str, FloatArray] = {
        SLAM: slam.poses,
        **{
            name: along(
                estimator,
                slam,
                rates_rad_per_s=rates,
                world=settings.world(mesh, tags_m=mesh.tags_m),
                seeds=run_seeds(settings.study.seed, settings.track.slam_runs),
            )
            for name, estimator in ((RSS, ekf), (DEAD, DeadReckoning(motion=motion)))
        },
    }
    return PartRecord(
        slam=slam,
        rows=tuple(
            _row(name, part.sigma, _errors_m(slam, poses)) for name, poses in estimates.items()
        ),
    )


def along(
    estimator: PoseEstimator[Any],
    drives: SlamRecord,
    *,
    rates_rad_per_s: FloatArray,
    world: World,
    seeds: Sequence[np.random.SeedSequence],
) -> FloatArray:
    """Return an estimator's poses along drives that have been made, (r, k + 1, 3) [m, rad].

    Parameters
    ----------
    estimator : What estimates; its start is exact, as that of SLAM.
    drives : The true poses [m, rad].
    rates_rad_per_s : (2,) float64 — Commanded right and left [rad/s].
    world : Tags, noise and receiver: what is read in every period [dBm].
    seeds : Of the drives; the readings have random numbers of their own.
    """
    true = drives.true_poses
    rngs = [
        np.random.default_rng(
            np.random.SeedSequence(entropy=seed.entropy, spawn_key=(*seed.spawn_key, 2))
        )
        for seed in seeds
    ]
    belief = estimator.begin(true[:, 0].copy(), np.zeros((3, 3)), rngs)
    poses = np.empty_like(true)
    poses[:, 0] = true[:, 0]
    commanded = np.tile(rates_rad_per_s, (len(true), 1))
    twists = world.robot.twist(commanded)
    for k in range(1, true.shape[1]):
        rss = read_tags(world, true[:, k], twists, rngs)
        belief = estimator.step(belief, commanded, rss, rngs)
        poses[:, k] = estimator.poses(belief)
    return poses


def _errors_m(slam: SlamRecord, poses: FloatArray) -> FloatArray:
    errors: FloatArray = np.linalg.norm(poses[..., :2] - slam.true_poses[..., :2], axis=-1)
    return errors


def _row(name: str, sigma: float, errors: FloatArray) -> Row:
    half = errors.shape[1] // 2
    grown = float(np.median(errors[:, half:].mean(axis=1) / errors[:, 1:half].mean(axis=1)))
    return (
        name,
        sigma,
        len(errors),
        *middle_and_90(errors.mean(axis=1)),
        *middle_and_90(errors[:, -1]),
        grown,
    )


def said(settings: Settings, records: Records) -> tuple[str, ...]:
    """Return the sentences on the page.

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    del settings
    words = [
        f"{float(row[1] or 0.0):g} rad/s, {row[0]}: {1000.0 * float(row[5] or 0.0):.1f} mm"
        for row in rows_of(records)
    ]
    return (
        (
            "The thesis finds that SLAM diverges towards the end of the line and fails above "
            "0.01 rad/s of wheel noise, and that the neighbouring control does not (7.7). Both "
            "filters estimate here the same drives, from readings with the printed noises. Median "
            f"error of the place at the end: {'; '.join(words)}. Over 3 m both hardly correct the "
            "wheels, so noisy are their readings, and the errors of both grow; neither fails."
        ),
    )


def tables(settings: Settings, records: Records) -> tuple[ChapterTable, ...]:
    """Return the chapter's table.

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    caption = (
        f"Errors of the estimated place over {settings.track.slam_runs} drives along 3 m, the same "
        "for all estimators."
    )
    return (
        ChapterTable(file="slam_line.csv", caption=caption, header=COLUMNS, rows=rows_of(records)),
    )


def figures(settings: Settings, records: Records) -> Iterator[NamedFigure]:
    """Yield the final errors of each estimator by the noise of the wheels [mm].

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    del settings
    with figure_style():
        figure, (axes,) = new_figure(
            width_in=10.0,
            height_in=3.8,
            title="Place after the same 3 m: median (bar) and 90 % (line) of the error",
            columns=len(records),
        )
        for ax, (part, one) in zip(axes, records, strict=True):
            names = [str(row[0]) for row in one.rows]
            middle, most = (
                np.array([1000.0 * float(row[i] or 0.0) for row in one.rows]) for i in (5, 6)
            )
            ax.barh(names, middle, color=COLOURS[: len(names)], alpha=0.75)
            ax.plot(most, names, "|", color="#222222", markersize=14)
            ax.invert_yaxis()
            ax.set_title(f"wheel noise {part.sigma:g} rad/s")
            ax.set_xlabel("error of the place at the end [mm]")
    yield NamedFigure(
        file="slam_line.png",
        section="slam line",
        title="SLAM beside the filter on RSS (thesis 7.7)",
        caption="How far the estimated place is off after 3 m, by what the estimator reads.",
        figure=figure,
    )


CHAPTER = FurtherChapter(
    heading="SLAM beside the filter on RSS (7.7)",
    parts=parts,
    compute=compute,
    said=said,
    tables=tables,
    figures=figures,
)
