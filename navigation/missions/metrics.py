"""How well a run went: errors to the straight way, arrivals, and what went wrong.

The error is measured to the nearest point of the current straight segment, from the previous tag's
point (at first the start) to the current one's. A reference that moves with time would add the
robot's delay, about 20 cm, and cannot be meant by the published 9 cm.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.missions.records import MissionOutcome, MissionResult

REACHED = "reached every tag"
"""Verdict on a success."""

_SUCCESS_RADII = 2.0
_HOLD_SAMPLES = 30


def local_pose_error(pose: npt.ArrayLike, reference_pose: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return wanted minus actual pose in the robot's frame, thesis (5.3), (..., 3).

    Along the robot's heading [m], to its left [m], turn in (-π, π] [rad]. Its length in x and y is
    the position error e, the same in both frames.

    Parameters
    ----------
    pose, reference_pose : (..., 3) float64 — Robot's and wanted x [m], y [m], heading [rad].
    """
    actual = np.asarray(pose, dtype=np.float64)
    error = np.asarray(reference_pose, dtype=np.float64) - actual
    cosine, sine = np.cos(actual[..., 2]), np.sin(actual[..., 2])
    along = cosine * error[..., 0] + sine * error[..., 1]
    left = -sine * error[..., 0] + cosine * error[..., 1]
    return np.stack([along, left, wrap_angle(error[..., 2])], axis=-1)


def nearest_on_segment(
    points_m: npt.ArrayLike, starts_m: npt.ArrayLike, ends_m: npt.ArrayLike
) -> npt.NDArray[np.float64]:
    """Return the nearest points on straight segments, not beyond their ends, (..., 2) [m].

    Parameters
    ----------
    points_m : (..., 2) float64 — Points [m].
    starts_m, ends_m : (..., 2) float64 — Ends of the segments, not the same point [m].
    """
    points, start = np.asarray(points_m, dtype=np.float64), np.asarray(starts_m, dtype=np.float64)
    along = np.asarray(ends_m, dtype=np.float64) - start
    part = np.sum((points - start) * along, axis=-1) / np.sum(along**2, axis=-1)
    return np.asarray(start + np.clip(part, 0.0, 1.0)[..., None] * along)


def root_mean_square(errors: npt.ArrayLike) -> float:
    """Return the root mean square of errors, in their unit.

    Thesis (5.4) sums k_f + 1 samples and divides by k_f; the mean over all samples is meant.

    Parameters
    ----------
    errors : (s,) float64 — One error a sample, at least one [m] or [rad].
    """
    values = np.asarray(errors, dtype=np.float64)
    return float(np.sqrt(np.mean(values**2)))


def percentile_curve(
    errors: npt.ArrayLike, percents: npt.ArrayLike | None = None
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return shares [%] and the errors (p,) not exceeded by them, interpolated, figure 5.12(b).

    Parameters
    ----------
    errors : (s,) float64 — One error a sample, not negative [m] or [rad].
    percents : (p,) float64 or None — Shares of the samples [%]; None for 0 to 100 in steps of 1.
    """
    shares = np.arange(101.0) if percents is None else np.asarray(percents, dtype=np.float64)
    return shares, np.percentile(np.asarray(errors, dtype=np.float64), shares)


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionMetrics:
    """The metrics of one run; made by `measure`.

    Parameters
    ----------
    outcome, reason : Why the run ended; the same in a sentence, which says of a run that declared
        every tag reached which of them it was far from.
    success : All tags were declared reached, each within the success radius.
    captured : A tag declared reached outside the success radius, or a held robot, see `measure`.
    collided : The robot touched an obstacle.
    contacts : Periods in which it did.
    near_miss : A tag missed, or reached elsewhere, was within the success radius as target.
    time_s : Duration [s].
    path_m : Length of the way driven, chord by chord [m].
    rmse_m : Root mean square of the position error, thesis (5.4) [m].
    p90_position_m, p90_heading_rad : Errors that 90 % of the samples do not exceed [m], [rad].
    position_errors_m : (s,) float64 — Distance to the current segment [m].
    heading_errors_rad : (s,) float64 — Angle between heading and segment, 0 to π [rad].
    arrival_errors_m : (k,) float64 — Distance from each tag's point on its arrival [m], or NaN.
    closest_m : (k,) float64 — Least distance from each tag's point as target [m], or NaN.
    """

    outcome: MissionOutcome
    reason: str
    success: bool
    captured: bool
    collided: bool
    contacts: int
    near_miss: bool
    time_s: float
    path_m: float
    rmse_m: float
    p90_position_m: float
    p90_heading_rad: float
    position_errors_m: npt.NDArray[np.float64]
    heading_errors_rad: npt.NDArray[np.float64]
    arrival_errors_m: npt.NDArray[np.float64]
    closest_m: npt.NDArray[np.float64]

    @property
    def verdict(self) -> str:
        """Return how the run went: success, a tag declared reached elsewhere, or why it ended."""
        if self.success:
            return REACHED
        return "declared reached elsewhere" if self.outcome == "completed" else self.outcome

    def __post_init__(self) -> None:
        for name in ("position_errors_m", "heading_errors_rad", "arrival_errors_m", "closest_m"):
            array = frozen_array(
                getattr(self, name), name=name, shape=(None,), finite=False, error=NavigationError
            )
            object.__setattr__(self, name, array)


def pose_errors(result: MissionResult) -> npt.NDArray[np.float64]:
    """Return each sample's `local_pose_error` (s, 3) to the nearest pose of its straight segment.

    Parameters
    ----------
    result : A run of s samples [m, rad].
    """
    way = result.mission.waypoints_m
    starts, ends = way[result.targets], way[result.targets + 1]
    nearest = nearest_on_segment(result.poses[:, :2], starts, ends)
    leg = ends - starts
    reference = np.column_stack([nearest, np.arctan2(leg[:, 1], leg[:, 0])])
    return local_pose_error(result.poses, reference)


def measure(result: MissionResult, *, success_radius_m: float | None = None) -> MissionMetrics:
    """Return the metrics of one run: errors, percentiles, arrivals and flags.

    Held, and so captured, is a run that timed out and whose last 30 samples stay within the success
    radius of their mean place, that place outside the success radius of the tag. One that circles
    the tag without arriving is a near miss, seen in `closest_m`.

    Parameters
    ----------
    result : The run.
    success_radius_m : Distance at which an arrival counts [m]; None: twice the arrival radius.
    """
    if success_radius_m is not None and not success_radius_m > 0.0:
        msg = f"success_radius_m is {success_radius_m} m, but it must be positive: 0.4 is usual."
        raise NavigationError(msg)
    mission = result.mission
    radii_m = np.array(
        [success_radius_m or _SUCCESS_RADII * test.radius_m for test in mission.arrivals]
    )
    errors = pose_errors(result)
    position_m = np.hypot(errors[:, 0], errors[:, 1])
    heading_rad = np.abs(errors[:, 2])
    arrival_m = np.linalg.norm(result.arrival_points_m - mission.tag_points_m, axis=1)
    false_arrival = bool((arrival_m > radii_m).any())
    closest_m = _closest(result, arrival_m)
    # NaN, where the tag never was the target or was not reached, counts as not within.
    near = (closest_m <= radii_m) & ~(arrival_m <= radii_m)
    moves_m = np.linalg.norm(np.diff(result.poses[:, :2], axis=0), axis=1)
    return MissionMetrics(
        outcome=result.outcome,
        reason=_reason(result, arrival_m > radii_m),
        success=bool((arrival_m <= radii_m).all()),
        captured=false_arrival or _held(result, float(radii_m[result.targets[-1]])),
        collided=result.contacts > 0 or result.outcome == "collision",
        contacts=result.contacts,
        near_miss=bool(near.any()),
        time_s=float(result.time_s[-1]),
        path_m=float(moves_m.sum()),
        rmse_m=root_mean_square(position_m),
        p90_position_m=float(np.percentile(position_m, 90.0)),
        p90_heading_rad=float(np.percentile(heading_rad, 90.0)),
        position_errors_m=position_m,
        heading_errors_rad=heading_rad,
        arrival_errors_m=arrival_m,
        closest_m=closest_m,
    )


def _reason(result: MissionResult, elsewhere: npt.NDArray[np.bool_]) -> str:
    if result.outcome != "completed" or not elsewhere.any():
        return result.reason
    return f"tag {result.mission.tag_ids[int(np.argmax(elsewhere))]} was declared reached elsewhere"


def _held(result: MissionResult, radius_m: float) -> bool:
    if result.outcome != "time-out" or len(result.poses) < _HOLD_SAMPLES:
        return False
    last = result.poses[-_HOLD_SAMPLES:, :2]
    middle = last.mean(axis=0)
    stays = bool((np.linalg.norm(last - middle, axis=1) <= radius_m).all())
    tag_point = result.mission.tag_points_m[result.targets[-1]]
    return stays and bool(np.linalg.norm(middle - tag_point) > radius_m)


def _closest(result: MissionResult, arrival_m: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    closest = np.full(len(result.mission.tag_ids), np.inf)
    away = np.linalg.norm(result.poses[:, :2] - result.mission.tag_points_m[result.targets], axis=1)
    np.minimum.at(closest, result.targets, away)
    # The row in which a tag was reached already belongs to the next one.
    closest = np.fmin(closest, arrival_m)
    return np.where(np.isinf(closest), np.nan, closest)
