"""Polar coordinates of a robot about its goal, in which the docking and posture laws are written.

The goal frame has its x axis along the heading wanted at the goal. The goal is e away, at the angle
α from the robot's front and φ in the goal frame: x = -e cos φ, y = -e sin φ and θ = φ - α.
"""

import numpy as np
import numpy.typing as npt

from octant.navigation.angles import wrap_angle

FloatArray = npt.NDArray[np.float64]


def polar_state(pose: npt.ArrayLike, *, previous: npt.ArrayLike | None = None) -> FloatArray:
    """Return e [m], α [rad] and φ [rad] of a pose in the goal frame.

    Docking paper, the isomorphism before (30), with atan2 for its atan; the textbook's ρ, γ, δ are
    the same. A law that sees φ jump by a full turn turns the long way round: wrap once and then
    keep φ continuous. At the goal itself both angles are undefined.

    Parameters
    ----------
    pose : (..., 3) array_like — x [m], y [m], heading θ [rad] in the goal frame.
    previous : (..., 3) array_like or None — State before [m], [rad], from which α and φ are
        continued by less than half a turn. None: both in (-π, π].
    """
    given = np.asarray(pose, dtype=np.float64)
    x, y, heading = given[..., 0], given[..., 1], given[..., 2]
    to_goal = np.arctan2(-y, -x)
    alpha, phi = wrap_angle(to_goal - heading), wrap_angle(to_goal)
    if previous is not None:
        before = np.asarray(previous, dtype=np.float64)
        alpha = before[..., 1] + wrap_angle(alpha - before[..., 1])
        phi = before[..., 2] + wrap_angle(phi - before[..., 2])
    return np.stack([np.hypot(x, y), alpha, phi], axis=-1)


def pose_of_polar(polar: npt.ArrayLike) -> FloatArray:
    """Return x [m], y [m], heading in (-π, π] [rad] in the goal frame of a polar state.

    Parameters
    ----------
    polar : (..., 3) array_like — e [m], α [rad], φ [rad].
    """
    state = np.asarray(polar, dtype=np.float64)
    e, alpha, phi = state[..., 0], state[..., 1], state[..., 2]
    return np.stack([-e * np.cos(phi), -e * np.sin(phi), wrap_angle(phi - alpha)], axis=-1)


def polar_rate(polar: npt.ArrayLike, twist: npt.ArrayLike) -> FloatArray:
    """Return ė = -v cos α [m/s], α̇ = -ω + v sin α / e [rad/s] and φ̇ = v sin α / e [rad/s].

    Docking paper (30). It ends at e = 0, which a law must not reach in finite time.

    Parameters
    ----------
    polar : (..., 3) array_like — e [m], α [rad], φ [rad]; e above zero.
    twist : (..., 2) array_like — Forward speed v [m/s], turn rate ω [rad/s].
    """
    state, command = np.asarray(polar, dtype=np.float64), np.asarray(twist, dtype=np.float64)
    e, alpha = state[..., 0], state[..., 1]
    speed, turn_rate = command[..., 0], command[..., 1]
    swing = speed * np.sin(alpha) / e
    return np.stack([-speed * np.cos(alpha), swing - turn_rate, swing], axis=-1)


def pose_in_goal_frame(pose: npt.ArrayLike, goal: npt.ArrayLike) -> FloatArray:
    """Return a pose of the room, seen from a goal: x [m], y [m], heading in (-π, π] [rad].

    Parameters
    ----------
    pose : (..., 3) array_like — x [m], y [m], heading [rad] in the room.
    goal : (..., 3) array_like — x [m], y [m], wanted heading [rad] of the goal in the room.
    """
    here, there = np.asarray(pose, dtype=np.float64), np.asarray(goal, dtype=np.float64)
    dx, dy = here[..., 0] - there[..., 0], here[..., 1] - there[..., 1]
    cos, sin = np.cos(there[..., 2]), np.sin(there[..., 2])
    heading = wrap_angle(here[..., 2] - there[..., 2])
    return np.stack([cos * dx + sin * dy, cos * dy - sin * dx, heading], axis=-1)


def pose_from_goal_frame(pose: npt.ArrayLike, goal: npt.ArrayLike) -> FloatArray:
    """Return in the room a pose seen from a goal: x [m], y [m], heading in (-π, π] [rad].

    Parameters
    ----------
    pose : (..., 3) array_like — x [m], y [m], heading [rad] in the goal frame.
    goal : (..., 3) array_like — x [m], y [m], wanted heading [rad] of the goal in the room.
    """
    seen, there = np.asarray(pose, dtype=np.float64), np.asarray(goal, dtype=np.float64)
    x, y = seen[..., 0], seen[..., 1]
    cos, sin = np.cos(there[..., 2]), np.sin(there[..., 2])
    heading = wrap_angle(seen[..., 2] + there[..., 2])
    place = (there[..., 0] + cos * x - sin * y, there[..., 1] + sin * x + cos * y)
    return np.stack([*place, heading], axis=-1)
