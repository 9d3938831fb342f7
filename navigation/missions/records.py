"""What a mission asks for and what a run of it leaves behind."""

import warnings
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError, PhysicsWarning
from octant.geometries.tolerances import LENGTHS
from octant.navigation.navigators.arrival import ArrivalTest
from octant.navigation.navigators.learned import Learned
from octant.navigation.robot.floor import Contact, MotionStep
from octant.navigation.robot.odometry import Rolling

MissionOutcome = Literal[
    "completed", "time-out", "no signal", "collision", "stuck", "left the room"
]
"""Why a run ended."""

_ORBIT_STEPS = 0.8


@dataclass(frozen=True, slots=True, kw_only=True)
class Mission:
    """A mission: where the robot starts, which tags it visits, and in what manner.

    Warns (`PhysicsWarning`) where an arrival radius is below 0.8 of the cruise step: the robot can
    then step over the disc in which the test fires, and orbit the tag.

    Parameters
    ----------
    start_m, heading_rad : Start on the floor (2,) [m] and heading there [rad].
    tag_ids : Tags in the order of the visit.
    tag_points_m : (k, 2) float64 — Floor points under them [m]; the robot does not know them.
    arrivals : One for each tag.
    sample_time_s : Period T [s].
    cruise_step_m : Distance driven straight ahead in one period [m].
    max_time_s : Time-out [s]; None: 60 s and four times what the straight legs take.
    motion : {"euler", "arc"} — How a period moves the robot.
    silent_limit : Readings in a row without any signal after which the run ends.
    contact : {"end", "slide"} — Whether the run ends on contact, or the robot slides along.
    contact_limit : Contacts on one leg after which a sliding robot counts as stuck.
    rolling : Slip of the wheels and resolution of their encoders.
    """

    start_m: npt.NDArray[np.float64]
    heading_rad: float
    tag_ids: tuple[str, ...]
    tag_points_m: npt.NDArray[np.float64]
    arrivals: tuple[ArrivalTest, ...]
    sample_time_s: float = 1.0
    cruise_step_m: float = 0.09
    max_time_s: float | None = None
    motion: MotionStep = "euler"
    silent_limit: int = 5
    contact: Contact = "end"
    contact_limit: int = 60
    rolling: Rolling = field(default_factory=Rolling)

    def __post_init__(self) -> None:
        object.__setattr__(self, "tag_ids", tuple(self.tag_ids))
        object.__setattr__(self, "arrivals", tuple(self.arrivals))
        tags = len(self.tag_ids)
        for name, shape in (("start_m", (2,)), ("tag_points_m", (tags, 2))):
            array = frozen_array(getattr(self, name), name=name, shape=shape, error=NavigationError)
            object.__setattr__(self, name, array)
        self._check_numbers()
        self._check_way()

    def _check_numbers(self) -> None:
        if not np.isfinite(self.heading_rad):
            msg = f"heading_rad is {self.heading_rad} rad, but it must be finite: give an angle."
            raise NavigationError(msg)
        for name, unit in (
            ("sample_time_s", "s"),
            ("cruise_step_m", "m"),
            ("max_time_s", "s"),
            ("silent_limit", "readings"),
            ("contact_limit", "contacts"),
        ):
            value = getattr(self, name)
            if value is not None and not (np.isfinite(value) and value > 0):
                msg = f"{name} is {value} {unit}, but it must be positive and finite: raise it."
                raise NavigationError(msg)
        for name, allowed in (("motion", get_args(MotionStep)), ("contact", get_args(Contact))):
            value = getattr(self, name)
            if value not in allowed:
                msg = f"{name} is {value!r}, but it must be one of {list(allowed)}: choose one."
                raise NavigationError(msg)

    def _check_way(self) -> None:
        if not self.tag_ids or len(self.arrivals) != len(self.tag_ids):
            msg = (
                f"the mission has {len(self.tag_ids)} tags and {len(self.arrivals)} arrival tests, "
                "but it needs at least one tag and one test for each: complete the lists."
            )
            raise NavigationError(msg)
        way = self.waypoints_m
        short = np.flatnonzero(np.linalg.norm(np.diff(way, axis=0), axis=1) < LENGTHS.same_m)
        if short.size:
            msg = (
                f"the way stands still at ({way[short[0], 0]:g}, {way[short[0], 1]:g}) m before "
                f"tag {self.tag_ids[short[0]]!r}, but every leg needs a length: remove one point."
            )
            raise NavigationError(msg)
        smallest = min(test.radius_m for test in self.arrivals)
        if smallest < _ORBIT_STEPS * self.cruise_step_m:
            msg = (
                f"the arrival radius of {smallest:g} m is below {_ORBIT_STEPS} of the cruise step "
                f"of {self.cruise_step_m:g} m, so the robot may orbit the tag: take smaller steps."
            )
            warnings.warn(msg, PhysicsWarning, stacklevel=4)

    @property
    def waypoints_m(self) -> npt.NDArray[np.float64]:
        """Return the (k + 1, 2) corners of the wanted way: the start and the tags' points [m]."""
        return np.vstack([self.start_m, self.tag_points_m])

    @property
    def cruise_speed_m_per_s(self) -> float:
        """Return the speed of straight driving [m/s]."""
        return self.cruise_step_m / self.sample_time_s

    @property
    def time_limit_s(self) -> float:
        """Return the time-out in force [s]."""
        if self.max_time_s is not None:
            return self.max_time_s
        legs_m = np.linalg.norm(np.diff(self.waypoints_m, axis=0), axis=1)
        return 60.0 + 4.0 * float(legs_m.sum()) / self.cruise_speed_m_per_s


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionResult:
    """The record of one run, one row a period: the state at time kT and what was read then.

    Parameters
    ----------
    mission : What was asked for.
    outcome, reason : Why the run ended; the same in a sentence.
    time_s : (s,) float64 — Time [s].
    poses : (s, 3) float64 — x [m], y [m], heading in (-π, π] [rad].
    modes : "rotation", "navigation", "search", "evade" or "stopped" in the period that begins then.
    targets : (s,) int64 — Index of the tag that was read [-].
    rss_w : (s, n) float64 — The reading [W]; where a tag was reached the next one's, in a completed
        run's last row the last tag's; zeros where the robot has left the room.
    arrival_times_s, arrival_points_m : (k,), (k, 2) float64 — Of the arrivals [s], [m], or NaN.
    contacts : Periods in which the robot touched something.
    believed_points_m : (s, 2) float64 or None — Where the navigator believed the tag [m], or NaN.
    commands : (s, 2) float64 or None — Commanded speed [m/s] and turn rate [rad/s] of the period
        that begins then; None, as the next two: the run was kept without them.
    reckoned : (s, 3) float64 or None — Pose by the wheels' encoders alone from the mission's start,
        x, y [m], heading [rad].
    believed_poses : (s, 3) float64 or None — Where the navigator believed the robot, x, y [m],
        heading [rad]; NaN where it says nothing of it.
    learned : What the navigator can use in its next mission; None: nothing, or it does not learn.
    """

    mission: Mission
    outcome: MissionOutcome
    reason: str
    time_s: npt.NDArray[np.float64]
    poses: npt.NDArray[np.float64]
    modes: tuple[str, ...]
    targets: npt.NDArray[np.int64]
    rss_w: npt.NDArray[np.float64]
    arrival_times_s: npt.NDArray[np.float64]
    arrival_points_m: npt.NDArray[np.float64]
    contacts: int = 0
    believed_points_m: npt.NDArray[np.float64] | None = None
    commands: npt.NDArray[np.float64] | None = None
    reckoned: npt.NDArray[np.float64] | None = None
    believed_poses: npt.NDArray[np.float64] | None = None
    learned: Learned | None = None

    def __post_init__(self) -> None:
        rows, tags = len(self.modes), len(self.mission.tag_ids)
        if self.believed_points_m is None:
            object.__setattr__(self, "believed_points_m", np.full((rows, 2), np.nan))
        for name, shape, dtype in (
            ("time_s", (rows,), np.float64),
            ("poses", (rows, 3), np.float64),
            ("targets", (rows,), np.int64),
            ("rss_w", (rows, None), np.float64),
            ("arrival_times_s", (tags,), np.float64),
            ("arrival_points_m", (tags, 2), np.float64),
            ("believed_points_m", (rows, 2), np.float64),
            ("commands", (rows, 2), np.float64),
            ("reckoned", (rows, 3), np.float64),
            ("believed_poses", (rows, 3), np.float64),
        ):
            if getattr(self, name) is None:
                continue
            array = frozen_array(
                getattr(self, name),
                name=name,
                shape=shape,
                dtype=dtype,
                finite=not name.startswith(("arrival", "believed")),
                error=NavigationError,
            )
            object.__setattr__(self, name, array)
