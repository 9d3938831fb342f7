"""The experiments of the docking paper and the textbook's two figures, recomputed."""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.navigation.control.closed_loop import ClosedLoop, integrate
from octant.navigation.control.docking_law import DockingLaw, GoalLaw
from octant.navigation.control.polar import pose_of_polar
from octant.navigation.control.regulators import CartesianRegulator, GracefulLaw, posture_regulator
from octant.navigation.docking.run import DockingJob
from octant.navigation.docking.task import DockingSetting, DockingTask
from octant.navigation.estimators.landmark_filters import LandmarkFilter
from octant.navigation.estimators.landmark_trials import (
    Drives,
    Estimates,
    Manoeuvre,
    drive,
    estimate,
    paper_manoeuvre,
)
from octant.navigation.missions.starts import RandomStarts
from octant.navigation.sensing.landmark_sensor import Landmark, LandmarkSensor
from octant.reader_design.study_file.dock import Regulation

FloatArray = npt.NDArray[np.float64]

WRONG_START = (2.0, -1.5, 2.5)
"""First guess less truth in the experiment with a wrong start [m], [m], [rad]."""

BLACKOUT_S = 30.0
"""Length of the blackout after which errors are compared [s]."""

_ASIDE = 0.2
SLIPS = (-0.01, 0.008)
"""Slips of the filter experiments: b is the paper's forced value, s is chosen [m/s], [rad/s]."""


def figure_4_law() -> DockingLaw:
    """Return the docking law with the gains of the paper's figure 4 [1/s],, [1/s]."""
    return DockingLaw(gamma_per_s=3.0, h=1.0, k_per_s=6.0)


def figure_4_loops() -> dict[str, ClosedLoop]:
    """Return the runs of figure 4 by the first bearing α: from 3 m, landmark's attitude zero."""
    times = np.linspace(0.0, 2.5, 300)
    return {
        f"{degrees}°": integrate(
            figure_4_law(), pose_of_polar([3.0, *[np.radians(degrees)] * 2]), times
        )
        for degrees in (0, 45, 90, 135, 180, -45, -90, -135)
    }


def regulator_loops(table: Regulation) -> dict[str, tuple[ClosedLoop, ...]]:
    """Return runs as of figures 11.19 and 11.20, and those of the modern peer, by law [m], [rad].

    Parameters
    ----------
    table : Starts and gains; the defaults are those of the figures.
    """
    starts = [(x, y, math.radians(heading)) for x, y, heading in table.starts]
    farthest_m = max(math.hypot(x, y) for x, y, _ in starts)
    cartesian = CartesianRegulator(k1_per_s=table.k1_per_s, k2_per_s=table.k2_per_s)
    posture = posture_regulator(
        k1_per_s=table.posture_k1_per_s, k2_per_s=table.posture_k2_per_s, k3=table.posture_k3
    )
    laws: dict[str, tuple[GoalLaw, float]] = {
        "Cartesian regulator (Fig. 11.19)": (cartesian, table.duration_s),
        "posture regulator (Fig. 11.20)": (posture, table.duration_s),
        # Its speed has a limit: it needs time in proportion to the way.
        "graceful law (Park and Kuipers)": (GracefulLaw(), max(150.0, 75.0 * farthest_m)),
    }
    return {
        name: tuple(
            integrate(law, start, np.linspace(0.0, seconds, 400), tolerance=1e-10)
            for start in starts
        )
        for name, (law, seconds) in laws.items()
    }


@dataclass(frozen=True, slots=True, kw_only=True)
class FilterExperiment:
    """Repeated drives past a landmark and the estimates of each filter.

    Parameters
    ----------
    drives : Truth and detections.
    estimates : By filter: ``slips``, ``no slips``, ``wrong start``, ``pair`` (the paper's two).
    """

    drives: Drives
    estimates: dict[str, Estimates]


def filter_experiment(*, seed: int, repetitions: int = 100) -> FilterExperiment:
    """Return the experiments of the paper's figures 6 to 16.

    Parameters
    ----------
    seed, repetitions : Of the random drives.
    """
    return _experiment(paper_manoeuvre(), seed=seed, repetitions=repetitions)


def straight_experiment(*, seed: int) -> FilterExperiment:
    """Return the experiment of figure 17: a simpler drive at one constant speed, once.

    Parameters
    ----------
    seed : Seed.
    """
    simple = Manoeuvre(
        start=np.array([-2.5, -0.6, 0.0]),
        legs=np.array([[60.0, 0.06, 0.0]]),
        landmark=Landmark(position_m=np.array([0.0, 0.0, 0.5]), heading_rad=0.0),
    )
    return _experiment(simple, seed=seed, repetitions=1)


def published_job(
    task: DockingTask, setting: DockingSetting, *, compensate_slips: bool
) -> DockingJob:
    """Return closed-loop docking on estimates from beside the staging place, figures 18 and 19.

    From a wrong first estimate the camera faces the station at the start, as the paper's claim for
    it is for a visible landmark (VIII).

    Parameters
    ----------
    task, setting : Station, law and filter, tried once; robot and camera, with nothing in its way.
    compensate_slips : Whether the estimated slips are taken off the commands.
    """
    landmark = Landmark(position_m=np.array([task.stand_off_m, 0.0, 0.6]), heading_rad=0.0)
    back = task.staging_m - task.stand_off_m
    fine = replace(task.fine, compensate_slips=compensate_slips)
    facing = -setting.camera.yaw_rad
    headings = (-np.pi, np.pi) if fine.start_error is None else (facing - _ASIDE, facing + _ASIDE)
    return DockingJob(
        task=replace(task, landmark=landmark, fine=fine, tries=1),
        setting=replace(
            setting,
            reader=None,
            camera=replace(setting.camera, scene=None),
            blocked=None,
            outside=None,
        ),
        starts=RandomStarts(
            low_m=np.array([-back - 0.4, -0.6]),
            high_m=np.array([-back + 0.4, 0.6]),
            fits=Anywhere(),
            headings_rad=headings,
        ),
    )


@dataclass(frozen=True, slots=True)
class Anywhere:
    """Floor on which nothing stands in the way."""

    def __call__(self, points_m: FloatArray) -> npt.NDArray[np.bool_]:
        """Return True for each of (m, 2) places [m]."""
        return np.ones(len(points_m), dtype=np.bool_)


def _experiment(manoeuvre: Manoeuvre, *, seed: int, repetitions: int) -> FilterExperiment:
    coupled = LandmarkFilter()
    drives = drive(
        manoeuvre, LandmarkSensor(), coupled, slips=SLIPS, repetitions=repetitions, seed=seed
    )
    return FilterExperiment(
        drives=drives,
        estimates={
            "slips": estimate(drives, coupled),
            "no slips": estimate(drives, LandmarkFilter(estimate_slips=False)),
            "wrong start": estimate(drives, coupled, start_error=WRONG_START),
            "pair": estimate(drives, LandmarkFilter(coupled=False)),
        },
    )
