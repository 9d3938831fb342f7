"""Ways on a floor plan: from anywhere on the free floor to given goals, round what stands there."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.robot.floor import Blocked

FloatArray = npt.NDArray[np.float64]

SPACING_M = 0.1
"""Step of the grid [m], unless the robot is smaller."""

OCCUPANCY_M = 0.025
"""Step of the occupancy grid [m]."""

_SIGHT_M = 1.5
_POINTS = 2000
_STEP_M = 0.02
_SIGHT_STEP_M = 0.03
_NEAR_WALL = 1.0
_NEIGHBOURS = tuple(
    (i, j) for i in (-2, -1, 0, 1, 2) for j in (-2, -1, 0, 1, 2) if math.gcd(abs(i), abs(j)) == 1
)


@dataclass(frozen=True, slots=True, kw_only=True)
class OccupancyGrid:
    """Where a robot's centre cannot be, as squares that are looked up; outside them it cannot.

    Parameters
    ----------
    low_m : (2,) float64 — Middle of the first square [m].
    step_m : Side of the squares [m].
    taken : (nx, ny) bool — Whether the centre cannot be in the middle of a square [-].
    """

    low_m: FloatArray
    step_m: float
    taken: npt.NDArray[np.bool_]

    def __post_init__(self) -> None:
        low = frozen_array(self.low_m, name="low_m", shape=(2,), error=NavigationError)
        object.__setattr__(self, "low_m", low)
        taken = frozen_array(self.taken, name="taken", shape=(None, None), dtype=np.bool_)
        object.__setattr__(self, "taken", taken)

    def __call__(self, points_m: FloatArray) -> npt.NDArray[np.bool_]:
        """Return at which points (m, 2) [m] the robot's centre cannot be, (m,)."""
        i, j = np.rint((np.asarray(points_m) - self.low_m) / self.step_m).astype(np.int64).T
        nx, ny = self.taken.shape
        inside = (i >= 0) & (i < nx) & (j >= 0) & (j < ny)
        found: npt.NDArray[np.bool_] = np.ones(len(i), dtype=np.bool_)
        found[inside] = self.taken[i[inside], j[inside]]
        return found


def occupancy(
    low_m: npt.ArrayLike, high_m: npt.ArrayLike, fits: Blocked, *, step_m: float = OCCUPANCY_M
) -> OccupancyGrid:
    """Return where in a rectangle a robot's centre cannot be.

    Parameters
    ----------
    low_m, high_m : (2,) array_like — Corners of the rectangle [m].
    fits : (m, 2) points [m] -> (m,) bool: where the robot can stand.
    step_m : Side of the squares [m].
    """
    low, high = np.asarray(low_m, dtype=np.float64), np.asarray(high_m, dtype=np.float64)
    x, y = (np.arange(low[i], high[i] + 0.5 * step_m, step_m) for i in range(2))
    gx, gy = np.meshgrid(x, y, indexing="ij")
    points = np.column_stack([gx.ravel(), gy.ravel()])
    free = [fits(points[k : k + _POINTS]) for k in range(0, len(points), _POINTS)]
    return OccupancyGrid(low_m=low, step_m=step_m, taken=~np.concatenate(free).reshape(gx.shape))


@dataclass(frozen=True, slots=True, kw_only=True)
class FloorPlan:
    """The free floor as a graph, with the least way from each of its points to each goal.

    Parameters
    ----------
    x_m, y_m : (nx,), (ny,) float64 — Coordinates of the grid [m].
    free : (nx, ny) bool — Whether the robot's centre can stand there [-].
    goals_m : (g, 2) float64 — Where to [m].
    ends_m : (g, 2) float64 — Free places nearest to them [m]: the goals, if the robot fits there.
    to_go_m : (g, nx, ny) float64 — Way to the goals, longer beside obstacles; inf: none [m].
    following : (g, nx, ny) int64 — Number of the next point on the way to each goal; negative:
        there is none, or the goal is nearest here [-].
    blocked : Where the robot's centre cannot be; None: nowhere.
    """

    x_m: FloatArray
    y_m: FloatArray
    free: npt.NDArray[np.bool_]
    goals_m: FloatArray
    ends_m: FloatArray
    to_go_m: FloatArray
    following: npt.NDArray[np.int64]
    blocked: Blocked | None

    def __post_init__(self) -> None:
        nx, ny, goals = len(self.x_m), len(self.y_m), len(self.goals_m)
        for name, shape, dtype in (
            ("x_m", (nx,), np.float64),
            ("y_m", (ny,), np.float64),
            ("free", (nx, ny), np.bool_),
            ("goals_m", (goals, 2), np.float64),
            ("ends_m", (goals, 2), np.float64),
            ("to_go_m", (goals, nx, ny), np.float64),
            ("following", (goals, nx, ny), np.int64),
        ):
            array = frozen_array(
                getattr(self, name),
                name=name,
                shape=shape,
                dtype=dtype,
                finite=name != "to_go_m",
                error=NavigationError,
            )
            object.__setattr__(self, name, array)

    def towards(self, place_m: FloatArray, goal: int) -> FloatArray:
        """Return a point in free sight on the least way from a place to a goal, (2,) [m].

        Of a place that is not on free floor, from the nearest one that is.

        Parameters
        ----------
        place_m : (2,) float64 — Where the robot is [m].
        goal : Which goal.
        """
        end: FloatArray = self.ends_m[goal]
        if self.sees(place_m, end):
            return end
        to_go = self.to_go_m[goal]
        i, j = self._nearest(place_m, np.isfinite(to_go))
        found = np.array([self.x_m[i], self.y_m[j]])
        while True:
            number = int(self.following[goal, i, j])
            if number < 0:
                return found
            i, j = divmod(number, len(self.y_m))
            point = np.array([self.x_m[i], self.y_m[j]])
            if math.dist(point, place_m) > _SIGHT_M or not self.sees(place_m, point):
                return found if math.dist(found, place_m) > _STEP_M else point
            found = point

    def length_m(self, place_m: FloatArray, goal: int) -> float:
        """Return how long the way from a place to a goal is, by the grid [m]; inf: there is none.

        Parameters
        ----------
        place_m : (2,) float64 — A place [m].
        goal : Which goal.
        """
        i, j = self._nearest(place_m, self.free)
        return float(self.to_go_m[goal, i, j])

    def _nearest(self, place_m: FloatArray, allowed: npt.NDArray[np.bool_]) -> tuple[int, int]:
        away = (self.x_m[:, None] - place_m[0]) ** 2 + (self.y_m - place_m[1]) ** 2
        number = int(np.argmin(np.where(allowed, away, np.inf)))
        return number // len(self.y_m), number % len(self.y_m)

    def sees(self, start_m: FloatArray, end_m: FloatArray) -> bool:
        """Return whether the robot can drive straight from a place to another.

        Parameters
        ----------
        start_m, end_m : (2,) float64 — The places [m].
        """
        if self.blocked is None:
            return True
        parts = max(1, math.ceil(math.dist(start_m, end_m) / _SIGHT_STEP_M))
        share = np.arange(1, parts + 1)[:, None] / parts
        return not bool(self.blocked(start_m + share * (end_m - start_m)).any())


def floor_plan(
    low_m: npt.ArrayLike,
    high_m: npt.ArrayLike,
    goals_m: npt.ArrayLike,
    *,
    blocked: Blocked | None,
    margin_m: float = 0.1,
    spacing_m: float = SPACING_M,
) -> FloorPlan:
    """Return the ways to goals over the free floor of a rectangle.

    Steps lead to the 16 nearest points that a knight or a king reaches, so that a way is at most
    2.7 % longer than the shortest one; a point whose surroundings are not free costs up to twice.

    Parameters
    ----------
    low_m, high_m : (2,) array_like — Corners of the rectangle [m].
    goals_m : (g, 2) array_like — Where to [m].
    blocked : Where the robot's centre cannot be; None: nowhere.
    margin_m : Distance that ways keep from obstacles where there is room [m].
    spacing_m : Step of the grid [m].
    """
    from scipy.ndimage import distance_transform_edt
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    goals = frozen_array(goals_m, name="goals_m", shape=(None, 2), error=NavigationError)
    low, high = np.asarray(low_m, dtype=np.float64), np.asarray(high_m, dtype=np.float64)
    x, y = (np.arange(low[i], high[i] + 0.5 * spacing_m, spacing_m) for i in range(2))
    gx, gy = np.meshgrid(x, y, indexing="ij")
    points = np.column_stack([gx.ravel(), gy.ravel()])
    free = np.ones(gx.shape, dtype=np.bool_)
    if blocked is not None:
        free = ~blocked(points).reshape(gx.shape)
    if not free.any():
        msg = (
            f"nowhere between {low.tolist()} and {high.tolist()} m does the robot fit: make it "
            "smaller, or check what stands on the floor."
        )
        raise NavigationError(msg)
    clear_m = spacing_m * np.asarray(distance_transform_edt(np.pad(free, 1)))[1:-1, 1:-1]
    price = 1.0 + _NEAR_WALL * np.clip(1.0 - clear_m / (margin_m + spacing_m), 0.0, 1.0)
    number = np.arange(free.size).reshape(free.shape)
    rows, columns, lengths = [], [], []
    for di, dj in _NEIGHBOURS:
        a = (slice(max(0, -di), free.shape[0] - max(0, di)),
             slice(max(0, -dj), free.shape[1] - max(0, dj)))  # fmt: skip
        b = (slice(max(0, di), free.shape[0] + min(0, di)),
             slice(max(0, dj), free.shape[1] + min(0, dj)))  # fmt: skip
        both = free[a] & free[b]
        start, end = points[number[a][both]], points[number[b][both]]
        if blocked is not None and len(start):
            middle = np.zeros(len(start), dtype=np.bool_)
            for share in (0.25, 0.5, 0.75):
                middle |= blocked(start + share * (end - start))
            keep = ~middle
        else:
            keep = np.ones(len(start), dtype=np.bool_)
        rows.append(number[a][both][keep])
        columns.append(number[b][both][keep])
        step = spacing_m * math.hypot(di, dj)
        lengths.append(step * 0.5 * (price[a][both] + price[b][both])[keep])
    graph = csr_array(
        (np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns))),
        shape=(free.size, free.size),
    )
    ends, nodes = [], []
    for goal in goals:
        away = np.where(free, (gx - goal[0]) ** 2 + (gy - goal[1]) ** 2, np.inf)
        node = int(np.argmin(away))
        fits = blocked is None or not bool(blocked(goal[None])[0])
        ends.append(goal if fits else points[node])
        nodes.append(node)
    to_go, following = dijkstra(graph, directed=False, indices=nodes, return_predecessors=True)
    return FloorPlan(
        x_m=x,
        y_m=y,
        free=free,
        goals_m=goals,
        ends_m=np.array(ends),
        to_go_m=to_go.reshape(len(goals), *free.shape),
        following=following.reshape(len(goals), *free.shape),
        blocked=blocked,
    )
