"""Docking as a task: from across the room to a pose in front of a landmark, with named results.

A robot that hears the tag first turns on the spot, in case that it stands in the dock already.
Coarse: the bearing-sensitive reader and odometry bring the robot under the tag over the staging
place. Fine: it turns until its camera sees the landmark, looks closely, and follows the docking law
on the filter's estimate. A try that fails goes back to the staging place.
"""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.checks import check_positive
from octant.navigation.control.docking_law import DockingLaw, TwistLimits
from octant.navigation.control.polar import pose_in_goal_frame
from octant.navigation.estimators.landmark_filters import (
    LandmarkFilter,
    LandmarkNoise,
    checked_period,
)
from octant.navigation.estimators.tag_place import TagPlaceFilter
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.floor import Blocked, WheelSlip
from octant.navigation.robot.motion import Integration
from octant.navigation.robot.odometry import Rolling
from octant.navigation.sensing.landmark_sensor import Landmark, LandmarkSensor
from octant.navigation.sensing.sensor import RssSensor

FloatArray = npt.NDArray[np.float64]

Phase = Literal["approach", "search", "refine", "dock", "back off"]
"""What the robot is doing."""

DockingOutcome = Literal[
    "docked",
    "tag not found",
    "landmark not found",
    "missed",
    "stalled",
    "collision",
    "left the room",
]
"""How a mission ends."""

Failure = tuple[DockingOutcome, str]
"""Why a try failed: outcome and reason."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CoarseStage:
    """How the robot drives to the staging place under the tag.

    Parameters
    ----------
    place_filter : Estimator of the tag's place.
    speed_m_per_s : Speed [m/s].
    period_s : Time between two readings of the tag [s].
    arrival_radius_m : The robot has arrived this near to the estimated place [m].
    arrival_spread_m : Greatest spread of the estimate at which the robot trusts it [m].
    max_time_s : Time after which a try gives up [s].
    """

    place_filter: TagPlaceFilter = field(default_factory=TagPlaceFilter)
    speed_m_per_s: float = 0.25
    period_s: float = 1.0
    arrival_radius_m: float = 0.3
    arrival_spread_m: float = 0.6
    max_time_s: float = 240.0

    def __post_init__(self) -> None:
        checked_period(self.period_s)
        for name, unit in (
            ("speed_m_per_s", "m/s"),
            ("arrival_radius_m", "m"),
            ("arrival_spread_m", "m"),
            ("max_time_s", "s"),
        ):
            check_positive(getattr(self, name), name=name, unit=unit)


def task_filter(*, position_sd_m: float = 0.1, attitude_sd_rad: float = 0.1) -> LandmarkFilter:
    """Return the coupled landmark filter with the paper's noise, for the docking task.

    Initial slips are 5 cm/s and 0.05 rad/s: otherwise a robot that has just stood still takes
    seconds to learn that it does not skid at 1 m/s.

    Parameters
    ----------
    position_sd_m, attitude_sd_rad : Standard deviations of coordinates [m] and attitude [rad].
    """
    noise = LandmarkNoise(
        measured_position_m2=position_sd_m**2,
        measured_attitude_rad2=attitude_sd_rad**2,
        initial_linear_slip_m2_per_s2=2.5e-3,
        initial_angular_slip_rad2_per_s2=2.5e-3,
    )
    return LandmarkFilter(noise=noise)


@dataclass(frozen=True, slots=True, kw_only=True)
class FineStage:
    """How the robot finds the landmark and docks.

    Parameters
    ----------
    law : Feedback.
    limits : Limits of its commands.
    filter : Estimator of the landmark's pose and of the slips.
    compensate_slips : Whether the estimated slips are taken off the commands.
    period_s : Sample time of camera and control [s].
    search_rate_rad_per_s : Turn rate of the search [rad/s].
    look_s : How long the robot stands and looks before it docks [s].
    last_look_m : At this distance from the goal the robot stands and looks once more [m].
    confirmations : Detections that must agree before a landmark is believed.
    latch_radius_m, fade_radius_m : At this distance the robot stops, the goal's direction fades
        [m].
    max_time_s : Time after which a try gives up [s].
    stall_s : A robot that comes no nearer for so long has stalled [s].
    start_error : (3,) tuple or None — The first belief less the truth: place in the body frame [m],
        [m] and attitude [rad], from which the first try drives at once, as from the paper's wrong
        initial estimate (VIII); None: the robot looks first, and drives when detections agree.
    """

    law: DockingLaw = field(default_factory=DockingLaw)
    limits: TwistLimits = field(default_factory=TwistLimits)
    filter: LandmarkFilter = field(default_factory=task_filter)
    compensate_slips: bool = True
    period_s: float = 0.1
    search_rate_rad_per_s: float = 0.5
    look_s: float = 6.0
    last_look_m: float = 0.2
    confirmations: int = 5
    latch_radius_m: float = 0.02
    fade_radius_m: float = 0.08
    max_time_s: float = 180.0
    stall_s: float = 20.0
    start_error: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        checked_period(self.period_s)
        for name, unit in (
            ("search_rate_rad_per_s", "rad/s"),
            ("look_s", "s"),
            ("last_look_m", "m"),
            ("confirmations", "detections"),
            ("latch_radius_m", "m"),
            ("fade_radius_m", "m"),
            ("max_time_s", "s"),
            ("stall_s", "s"),
        ):
            check_positive(getattr(self, name), name=name, unit=unit)


@dataclass(frozen=True, slots=True, kw_only=True)
class DockingTask:
    """A docking mission.

    Parameters
    ----------
    tag_id : Tag over the staging place.
    landmark : At the station.
    stand_off_m : Where the robot docks: so far in front of the landmark [m].
    staging_m : Distance of the staging place from the landmark; a failed try backs off to it [m].
    tolerance_m, tolerance_rad : Greatest errors of place [m] and heading [rad] with contact.
    tries, max_contacts : Tries and touches after which it gives up.
    coarse, fine : The two stages.
    slip : How the robot slips.
    """

    tag_id: str
    landmark: Landmark
    stand_off_m: float = 0.5
    staging_m: float = 2.0
    tolerance_m: float = 0.08
    tolerance_rad: float = 0.2
    tries: int = 4
    max_contacts: int = 12
    coarse: CoarseStage = field(default_factory=CoarseStage)
    fine: FineStage = field(default_factory=FineStage)
    slip: WheelSlip = field(default_factory=WheelSlip)

    def __post_init__(self) -> None:
        for name, unit in (
            ("stand_off_m", "m"),
            ("staging_m", "m"),
            ("tolerance_m", "m"),
            ("tolerance_rad", "rad"),
            ("tries", "tries"),
            ("max_contacts", "contacts"),
        ):
            check_positive(getattr(self, name), name=name, unit=unit)
        if self.staging_m <= self.stand_off_m:
            msg = (
                f"staging_m is {self.staging_m:g} m and stand_off_m {self.stand_off_m:g} m, but "
                "the robot must stage farther from the landmark than it docks: raise staging_m."
            )
            raise NavigationError(msg)

    @property
    def goal(self) -> FloatArray:
        """Return the (3,) docking pose in the room: x [m], y [m], heading [rad].

        A robot that docks in reverse has its back to the landmark.
        """
        x, y, heading = self.landmark.goal(self.stand_off_m)
        return np.array([x, y, heading + np.pi * self.in_reverse])

    @property
    def in_reverse(self) -> bool:
        """Return whether the robot backs into the dock."""
        return self.fine.law.approach == "reverse"


@dataclass(frozen=True, slots=True, kw_only=True)
class DockingSetting:
    """What a docking mission takes place in.

    Parameters
    ----------
    reader : The bearing-sensitive reader; None: the robot starts at the staging place.
    camera : The landmark's detector.
    robot, rolling : Wheels and limits; motors, slip shares and encoders. Filters and odometry get
        what encoders of a resolution count, and without one the commands, as in the paper.
    odometry : {"euler", "rk2", "exact"} — How odometry adds up a period.
    blocked, outside : (m, 2) points on the floor [m] -> (m,) bool: where the robot touches
        something; where it has left the room, whose field is known inside only.
    """

    reader: RssSensor | None
    camera: LandmarkSensor
    robot: DifferentialDrive
    rolling: Rolling = field(default_factory=Rolling)
    odometry: Integration = "exact"
    blocked: Blocked | None = None
    outside: Blocked | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class DockingResult:
    """The record of one docking mission, one row a sample.

    Parameters
    ----------
    task : What was asked for.
    outcome, reason : How it ended; the same in a sentence.
    tries : Tries begun.
    contacts : How often the robot touched something.
    time_s : (n,) float64 — Time [s].
    poses : (n, 3) float64 — True x [m], y [m], heading [rad].
    phases : What the robot was doing.
    twist : (n, 2) float64 — Command v [m/s], ω [rad/s] that follows.
    polar : (n, 3) float64 — Estimated e [m], α [rad], φ [rad] of the law; NaN in other phases.
    slips : (n, 2) float64 — Estimated b [m/s], s [rad/s]; NaN in other phases.
    seen : (n,) bool — Whether the camera reported a landmark [-].
    staged_m : Distance from the tag's point to where the coarse stage first ended [m], or NaN.
    odometry : (n, 3) float64 or None — Pose by the wheels since the start, in the axes of the start
        [m], [rad]; None, as the next: the run was kept without it.
    rss_w : (n, a) float64 or None — The reading on which the command rests [W]; NaN: none was made.
    """

    task: DockingTask
    outcome: DockingOutcome
    reason: str
    tries: int
    contacts: int
    time_s: FloatArray
    poses: FloatArray
    phases: tuple[str, ...]
    twist: FloatArray
    polar: FloatArray
    slips: FloatArray
    seen: npt.NDArray[np.bool_]
    staged_m: float
    odometry: FloatArray | None = None
    rss_w: FloatArray | None = None

    def __post_init__(self) -> None:
        rows = len(self.phases)
        for name, shape, dtype in (
            ("time_s", (rows,), np.float64),
            ("poses", (rows, 3), np.float64),
            ("twist", (rows, 2), np.float64),
            ("polar", (rows, 3), np.float64),
            ("slips", (rows, 2), np.float64),
            ("seen", (rows,), np.bool_),
            ("odometry", (rows, 3), np.float64),
            ("rss_w", (rows, None), np.float64),
        ):
            if getattr(self, name) is None:
                continue
            array = frozen_array(
                getattr(self, name),
                name=name,
                shape=shape,
                dtype=dtype,
                finite=name not in ("polar", "slips", "rss_w"),
                error=NavigationError,
            )
            object.__setattr__(self, name, array)

    @property
    def success(self) -> bool:
        """Return whether the robot is docked."""
        return self.outcome == "docked"

    @property
    def final(self) -> FloatArray:
        """Return the (3,) true final pose in the goal frame: x [m], y [m], heading [rad]."""
        return pose_in_goal_frame(self.poses[-1], self.task.goal)

    @property
    def position_error_m(self) -> float:
        """Return the final distance from the docking place [m]."""
        return float(np.hypot(*self.final[:2]))

    @property
    def lateral_error_m(self) -> float:
        """Return the final offset across the direction of docking [m]."""
        return float(abs(self.final[1]))

    @property
    def path_m(self) -> float:
        """Return the length of the robot's true way [m]."""
        return float(np.linalg.norm(np.diff(self.poses[:, :2], axis=0), axis=1).sum())
