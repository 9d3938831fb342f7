"""The floor: where a robot can stand, how a period moves it, and what it touches."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS
from octant.navigation.angles import wrap_angle
from octant.navigation.checks import check_positive
from octant.navigation.robot.drive import DifferentialDrive

FloatArray = npt.NDArray[np.float64]

Blocked = Callable[[FloatArray], npt.NDArray[np.bool_]]
"""Says for (m, 2) points on the floor [m] whether the robot's centre cannot stand there."""

MotionStep = Literal["euler", "arc"]
"""How a period moves the robot: thesis (5.1), or the exact arc."""

Contact = Literal["end", "slide"]
"""What follows when the robot touches something: the run ends, or it slides along and goes on."""

MANY_EDGES = 2000
"""Segments [-] above which a footprint looks only at those near a point."""

_PAIRS = 1_000_000  # points and segments that are looked at together
_ABOVE_FLOOR_M = 0.01
_LEVELS = (0.1, 0.5, 0.9)
_SPACING_M = 0.01
_SLIPPING_SPACING_M = 0.02
_SLIDES_RAD = np.radians([15.0, 30.0, 45.0, 60.0, 75.0])


@dataclass(frozen=True, slots=True, kw_only=True)
class Footprint:
    """A round robot among obstacles: where its centre cannot stand.

    Segments are the plan of the scene's triangles, cut to the robot's heights. A robot that moves
    in steps shorter than its radius cannot pass one unnoticed; for large objects see `RobotSpace`.

    Parameters
    ----------
    edges_m : (e, 4) float64 — Plan of the obstacles: segments x, y, x, y [m].
    radius_m : Radius of the robot [m].
    """

    edges_m: FloatArray
    radius_m: float
    _near: "_NearEdges | None" = field(init=False, repr=False, compare=False, default=None)

    def __post_init__(self) -> None:
        edges = frozen_array(self.edges_m, name="edges_m", shape=(None, 4), error=NavigationError)
        object.__setattr__(self, "edges_m", edges)
        if len(edges) > MANY_EDGES:
            object.__setattr__(self, "_near", _near_edges(edges))
        check_positive(self.radius_m, name="radius_m", unit="m")

    def clearance_m(self, points_m: npt.ArrayLike) -> FloatArray:
        """Return the free distance to obstacles, (m,); negative on overlap, inf without any [m].

        Parameters
        ----------
        points_m : (m, 2) array_like — Places of the robot's centre [m].
        """
        points = np.asarray(points_m, dtype=np.float64).reshape(-1, 2)
        if not len(self.edges_m):
            return np.full(len(points), np.inf)
        if self._near is not None:
            return self._near.distance_m(points) - self.radius_m
        gap2 = _gap2(points[:, None], self.edges_m)
        return np.asarray(np.sqrt(gap2.min(axis=1)) - self.radius_m)

    def __call__(self, points_m: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        """Return at which centres, points (m, 2) [m], the robot overlaps an obstacle, (m,)."""
        return np.asarray(self.clearance_m(points_m) < 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class _NearEdges:
    """Very many segments, of which only those near a point are looked at.

    Parameters
    ----------
    long_m, short_m : (e, 4) float64 — Segments that are always looked at, and the others [m].
    tree : k-d tree of the middles of the short ones.
    reach_m : Greatest half length of a short one [m].
    """

    long_m: FloatArray
    short_m: FloatArray
    tree: Any
    reach_m: float

    def distance_m(self, points_m: FloatArray) -> FloatArray:
        """Return the distance to the nearest segment of each point (m, 2), exactly [m]."""
        best = np.full(len(points_m), np.inf)
        size = max(1, _PAIRS // max(1, len(self.long_m)))
        for i in range(0, len(points_m) if len(self.long_m) else 0, size):
            here = points_m[i : i + size]
            best[i : i + size] = _gap2(here[:, None], self.long_m).min(axis=1)
        # The nearest middle is no nearer than the nearest segment, whose own middle is no farther
        # than half its length more.
        reach = self.tree.query(points_m)[0] + self.reach_m
        found = self.tree.query_ball_point(points_m, reach, return_sorted=True)
        for i, edges in enumerate(found):
            best[i] = min(best[i], float(_gap2(points_m[i], self.short_m[edges]).min()))
        return np.asarray(np.sqrt(best))


def _near_edges(edges_m: FloatArray) -> _NearEdges:
    from scipy.spatial import cKDTree

    half = 0.5 * np.hypot(*(edges_m[:, 2:] - edges_m[:, :2]).T)
    short = half <= 4.0 * np.median(half)
    middles = 0.5 * (edges_m[short, :2] + edges_m[short, 2:])
    return _NearEdges(
        long_m=edges_m[~short],
        short_m=edges_m[short],
        tree=cKDTree(middles),
        reach_m=float(half[short].max()) + LENGTHS.same_m,
    )


def _gap2(points_m: FloatArray, edges_m: FloatArray) -> FloatArray:
    """Return the squared distances of points to segments (e, 4), broadcast against them [m²]."""
    start, along = edges_m[:, :2], edges_m[:, 2:] - edges_m[:, :2]
    length2 = np.maximum(np.sum(along**2, axis=1), LENGTHS.same_m**2)
    away = points_m - start
    share = np.clip(np.sum(away * along, axis=-1) / length2, 0.0, 1.0)
    gap = away - share[..., None] * along
    return np.asarray(np.sum(gap**2, axis=-1))


def footprint(scene: Scene, *, radius_m: float, height_m: float) -> Footprint:
    """Return the plan of everything between 1 cm above the floor and the robot's top.

    Parameters
    ----------
    scene : Room and objects.
    radius_m, height_m : Of the robot [m]; what hangs higher does not touch it.
    """
    check_positive(height_m, name="height_m", unit="m")
    low, high = scene.floor_height_m + _ABOVE_FLOOR_M, scene.floor_height_m + height_m
    everything = [body.vertices_m[body.faces] for body in scene.bodies]
    corners = np.concatenate(everything) if everything else np.zeros((0, 3, 3))
    in_band = (corners[..., 2].max(axis=1) >= low) & (corners[..., 2].min(axis=1) <= high)
    edges: list[FloatArray] = []
    for triangle in corners[in_band]:
        polygon = _cut(_cut(triangle, low, above=True), high, above=False)
        plan = polygon[:, :2]
        edges.extend(
            np.concatenate([plan[i - 1], plan[i]])
            for i in range(len(plan))
            if np.hypot(*(plan[i] - plan[i - 1])) > LENGTHS.same_m
        )
    found = np.unique(np.round(np.array(edges).reshape(-1, 4), 9), axis=0)
    return Footprint(edges_m=found, radius_m=radius_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotSpace:
    """Where on the floor a robot can stand, large objects and the outside included.

    Parameters
    ----------
    footprint : The robot among the scene's edges.
    scene : Room and objects.
    height_m : Height of the robot [m].
    """

    footprint: Footprint
    scene: Scene
    height_m: float

    def __call__(self, points_m: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        """Return at which points the robot is in the room, in no solid and clear of the edges."""
        free = ~self.footprint(points_m)
        for share in _LEVELS:
            z = np.full(len(free), self.scene.floor_height_m + share * self.height_m)
            column = np.column_stack([points_m, z])
            free &= self.scene.inside_room(column) & ~self.scene.inside_solid(column)
        return free

    def outside(self, points_m: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        """Return at which points the robot has left the room, as through a doorway.

        Parameters
        ----------
        points_m : (m, 2) float64 — Places of its centre [m].
        """
        z = np.full(len(points_m), self.scene.floor_height_m + _LEVELS[1] * self.height_m)
        return ~self.scene.inside_room(np.column_stack([points_m, z]))


def check_start(
    start_m: npt.ArrayLike, blocked: Blocked | None, outside: Blocked | None = None
) -> None:
    """Refuse a start where the robot cannot stand.

    Parameters
    ----------
    start_m : (2,) array_like — Its centre [m].
    blocked, outside : Where it touches something, where it has left the room; None: nowhere.
    """
    point = np.asarray(start_m, dtype=np.float64).reshape(1, 2)
    for where, what in ((blocked, "inside an obstacle"), (outside, "outside the room")):
        if where is not None and bool(where(point)[0]):
            msg = (
                f"the start ({point[0, 0]:g}, {point[0, 1]:g}) m is {what}, but the robot needs "
                "free floor there: move it."
            )
            raise NavigationError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelSlip:
    """How a robot's motion differs from its command, while it moves.

    Parameters
    ----------
    linear_m_per_s : Constant part b of the speed [m/s].
    angular_rad_per_s : Constant part s of the turn rate [rad/s].
    position_m2_per_s, heading_rad2_per_s : Growth of the variances [m²/s], [rad²/s].
    """

    linear_m_per_s: float = -0.01
    angular_rad_per_s: float = 0.008
    position_m2_per_s: float = 4.1e-6
    heading_rad2_per_s: float = 2e-5

    def __post_init__(self) -> None:
        if not (np.isfinite(self.linear_m_per_s) and np.isfinite(self.angular_rad_per_s)):
            msg = (
                f"the slips are {self.linear_m_per_s} m/s and {self.angular_rad_per_s} rad/s, but "
                "both must be finite: give numbers."
            )
            raise NavigationError(msg)
        for name, unit in (("position_m2_per_s", "m²/s"), ("heading_rad2_per_s", "rad²/s")):
            check_positive(getattr(self, name), name=name, unit=unit, allow_zero=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class Floor:
    """The robot on its floor.

    Parameters
    ----------
    robot : Wheels and axle.
    step : {"euler", "arc"} — How a period moves the robot.
    contact : {"end", "slide"} — Whether it slides along what it touches.
    blocked : (m, 2) points [m] -> (m,) bool: where the robot's centre cannot be.
    """

    robot: DifferentialDrive
    step: MotionStep = "arc"
    contact: Contact = "end"
    blocked: Blocked | None = None

    def roll(
        self, pose: FloatArray, rates_rad_per_s: FloatArray, *, period_s: float
    ) -> tuple[FloatArray, bool]:
        """Return the pose (3,) one period later and whether the robot touched something.

        The heading is in (-π, π]. On contact the pose is the last free point of the way. A sliding
        robot goes on from there by the part of the rest of the way along the nearest free
        direction, turned as commanded.

        Parameters
        ----------
        pose : (3,) float64 — x [m], y [m], heading [rad] before.
        rates_rad_per_s : (2,) float64 — Right and left, as if they rolled without slip [rad/s].
        period_s : Sample period T [s].
        """
        step = self.robot.step_euler if self.step == "euler" else self.robot.step_arc
        reached = step(pose, rates_rad_per_s, period_s=period_s)
        length_m = abs(float(self.robot.twist(rates_rad_per_s)[0])) * period_s
        contact = False
        if self.blocked is not None and length_m > 0.0:
            parts = int(np.ceil(length_m / _SPACING_M))
            times_s = period_s * np.arange(1, parts + 1) / parts
            way = [pose, *(step(pose, rates_rad_per_s, period_s=float(t)) for t in times_s)]
            stopped = self._stopped(np.array(way))
            if stopped is not None:
                contact = True
                reached = self._slid(stopped, reached) if self.contact == "slide" else stopped
        reached[2] = wrap_angle(reached[2])
        return reached, contact

    def slip(
        self,
        pose: FloatArray,
        twist: npt.ArrayLike,
        *,
        slip: WheelSlip,
        period_s: float,
        rng: np.random.Generator,
    ) -> tuple[FloatArray, bool]:
        """Return the pose (3,) one period later and whether something was in the way.

        On contact the pose is the last free place of the way, turned as without contact.

        Parameters
        ----------
        pose, period_s : As for `roll` [m, rad], [s].
        twist : (2,) array_like — Commanded v [m/s], ω [rad/s]; without a command the robot stands.
        slip : How its motion differs from the command.
        rng : Source of the random part; three numbers are drawn in any case.
        """
        speed, turn_rate = (float(c) for c in np.asarray(twist))
        noise = rng.standard_normal(3)
        if speed == 0.0 and turn_rate == 0.0:
            return pose, False
        rates = self.robot.saturate(
            self.robot.wheel_rates(
                speed_m_per_s=speed + slip.linear_m_per_s,
                turn_rate_rad_per_s=turn_rate + slip.angular_rad_per_s,
            )
        )
        reached = self.robot.step_arc(pose, rates, period_s=period_s)
        reached[:2] += np.sqrt(slip.position_m2_per_s * period_s) * noise[:2]
        reached[2] = wrap_angle(reached[2] + np.sqrt(slip.heading_rad2_per_s * period_s) * noise[2])
        move = reached[:2] - pose[:2]
        shares = _shares(float(np.hypot(*move)), _SLIPPING_SPACING_M)
        chord = np.vstack([pose[:2], pose[:2] + shares[:, None] * move])
        stopped = self._stopped(np.column_stack([chord, np.full(len(chord), reached[2])]))
        return (reached, False) if stopped is None else (stopped, True)

    def _stopped(self, way: FloatArray) -> FloatArray | None:
        """Return the last pose (3,) of a way that is free at its first one; None: all are free."""
        if self.blocked is None:
            return None
        hits = np.flatnonzero(self.blocked(way[1:, :2]))
        return np.array(way[hits[0]]) if hits.size else None

    def _slid(self, stopped: FloatArray, wanted: FloatArray) -> FloatArray:
        rest = wanted[:2] - stopped[:2]
        for turn in np.stack([_SLIDES_RAD, -_SLIDES_RAD], axis=1).ravel():
            cosine, sine = np.cos(turn), np.sin(turn)
            along = cosine * np.array(
                [cosine * rest[0] - sine * rest[1], sine * rest[0] + cosine * rest[1]]
            )
            shares = np.append(0.0, _shares(float(np.hypot(*along)), _SPACING_M))
            if self._stopped(stopped[:2] + shares[:, None] * along) is None:
                return np.array([*(stopped[:2] + along), wanted[2]])
        return np.array([*stopped[:2], wanted[2]])


def _shares(length_m: float, spacing_m: float) -> FloatArray:
    """Return the ends of equal parts of a way, as shares of it, none longer than a spacing."""
    parts = max(1, int(np.ceil(length_m / spacing_m)))
    return np.asarray(np.arange(1, parts + 1) / parts)


def _cut(polygon: FloatArray, height_m: float, *, above: bool) -> FloatArray:
    """Return the part of a convex polygon above, or below, a height (Sutherland and Hodgman)."""
    side = polygon[:, 2] - height_m if above else height_m - polygon[:, 2]
    kept: list[FloatArray] = []
    for i in range(len(polygon)):
        before, here = side[i - 1], side[i]
        if (before < 0.0) != (here < 0.0):
            share = before / (before - here)
            kept.append(polygon[i - 1] + share * (polygon[i] - polygon[i - 1]))
        if here >= 0.0:
            kept.append(polygon[i])
    return np.array(kept).reshape(-1, 3)
