"""A mission's navigator in a robot's loop, without ROS: poses and readings in, commands out."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import octant

Pose = tuple[float, float, float]
"""x, y [m] and heading [rad]."""


def yaw_rad(x: float, y: float, z: float, w: float) -> float:
    """Return the heading of a quaternion [rad]."""
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def moved(before: Pose, after: Pose) -> octant.Odometry:
    """Return the motion between two poses of one frame: way along the mean heading, and turn."""
    turn = math.remainder(after[2] - before[2], 2.0 * math.pi)
    middle = before[2] + 0.5 * turn
    dx, dy = after[0] - before[0], after[1] - before[1]
    chord = dx * math.cos(middle) + dy * math.sin(middle)
    half = 0.5 * turn
    way = chord if abs(half) < 1e-9 else chord * half / math.sin(half)  # the arc over its chord
    return octant.Odometry(distance_m=way, turn_rad=turn)


@dataclass(frozen=True)
class Wanted:
    """What the robot does until the next tick."""

    speed_m_per_s: float
    turn_rate_rad_per_s: float
    tag_id: str
    state: str
    reached: str | None = None
    done: bool = False


class DriveLoop:
    """A mission, step by step: call ``tick`` once a period with odometry's pose and a reading."""

    def __init__(self, mission: octant.Mission, *, seed: int = 1) -> None:
        self.pilot, self.reader = mission.pilot(seed=seed, progress=False)
        self._before: Pose | None = None

    @property
    def period_s(self) -> float:
        """From one tick to the next [s]."""
        return self.pilot.period_s

    def tick(self, rss_w: Sequence[float], odometry: Pose, *, contact: bool = False) -> Wanted:
        """Return the command of a reading [W] of ``pilot.tag_id`` and the wheels' pose."""
        motion = moved(self._before or odometry, odometry)
        if contact:
            motion = octant.Odometry(
                distance_m=motion.distance_m, turn_rad=motion.turn_rad, contact=True
            )
        self._before = odometry
        step = self.pilot.step(list(rss_w), motion)
        return Wanted(
            speed_m_per_s=step.speed_m_per_s,
            turn_rate_rad_per_s=step.turn_rate_rad_per_s,
            tag_id=self.pilot.tag_id,
            state=step.mode,
            reached=step.reached,
            done=step.done,
        )


def mission_of(study: str) -> octant.Mission:
    """Return the mission of a study file, or of a built-in study by name."""
    return octant.Study.load(study).mission
