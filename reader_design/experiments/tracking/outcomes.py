"""What a tracked task leaves: errors of every run, and one run to draw."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.tracking.closed_loop import TrackingRecord
from octant.navigation.tracking.trajectories import DesiredTrajectory

FloatArray = npt.NDArray[np.float64]

COLUMNS = (
    "chapter",
    "task",
    "method",
    "runs",
    "average_m_median",
    "average_m_90",
    "within_m_90_of_time_median",
    "within_m_90_of_time_90",
    "final_m_median",
    "final_m_90",
    "final_heading_deg_median",
    "final_heading_deg_90",
)
"""Columns of tracking.csv: medians and 90 % quantiles over the runs [m, deg]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """Return how one method did in one task.

    Parameters
    ----------
    chapter : str
        ``feedback``, ``nominal``, ``neighbouring`` or ``room``.
    task : str
        Name of the trajectory, or of the tags.
    method : str
        Controller and estimator.
    desired : DesiredTrajectory
        What was to be followed.
    poses : (r, k + 1, 3) float64
        True x [m], y [m], heading [rad] of every run.
    example_rates : (k, 2) float64
        Wheel rates of run 0 [rad/s].
    example_estimates : (k + 1, 3) float64 or None
        Estimated poses of run 0 [m, rad].
    """

    chapter: str
    task: str
    method: str
    desired: DesiredTrajectory
    poses: FloatArray
    example_rates: FloatArray
    example_estimates: FloatArray | None = None

    def __post_init__(self) -> None:
        samples = self.desired.steps + 1
        poses = frozen_array(
            self.poses, name="poses", shape=(None, samples, 3), error=NavigationError
        )
        object.__setattr__(self, "poses", poses)
        rates = frozen_array(
            self.example_rates, name="example_rates", shape=(samples - 1, 2), error=NavigationError
        )
        object.__setattr__(self, "example_rates", rates)

    @property
    def record(self) -> TrackingRecord:
        """Return the runs as a record, for its error measures ([m], [rad])."""
        rates = np.tile(self.example_rates, (len(self.poses), 1, 1))
        return TrackingRecord(
            desired=self.desired, poses=self.poses, estimates=self.poses, wheel_rates=rates
        )

    def measures(self) -> dict[str, FloatArray]:
        """Return the measures of every run, (r,) each.

        Returns
        -------
        dict of str to (r,) float64
            ``average_m`` of (3.11), ``within_m_90_of_time``, ``final_m`` [m], and
            ``final_heading_deg`` [deg].
        """
        record = self.record
        return {
            "average_m": record.average_error_m,
            "within_m_90_of_time": record.share_within_m(0.9),
            "final_m": record.final_error_m,
            "final_heading_deg": np.degrees(record.final_heading_error_rad),
        }

    def row(self) -> tuple[object, ...]:
        """Return the row of tracking.csv, as `COLUMNS` [m, deg]."""
        numbers: list[float] = []
        for values in self.measures().values():
            numbers += [float(np.median(values)), float(np.quantile(values, 0.9))]
        return self.chapter, self.task, self.method, len(self.poses), *numbers


def outcome_of(record: TrackingRecord, *, chapter: str, task: str, method: str) -> Outcome:
    """Return the outcome of a record of the closed loop.

    Parameters
    ----------
    record : TrackingRecord
        The runs [m, rad].
    chapter, task, method : str
        What they are.
    """
    return Outcome(
        chapter=chapter,
        task=task,
        method=method,
        desired=record.desired,
        poses=record.poses,
        example_rates=record.wheel_rates[0],
        example_estimates=record.estimates[0],
    )


def find(outcomes: Sequence[Outcome], *, task: str, method: str | None = None) -> Outcome:
    """Return the first outcome of a task, by a method where one is named.

    Parameters
    ----------
    outcomes : sequence of Outcome
        Where to look.
    task : str
        Its task.
    method : str or None
        Its method.
    """
    return next(o for o in outcomes if o.task == task and method in (None, o.method))
