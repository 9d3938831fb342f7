"""Ways on a floor plan: from anywhere on the free floor to given goals, round what stands there."""

import math
from dataclasses import dataclass, field

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
_NEAR_WALL = 3.0
_WIDENING = 0.3
_MARGINS = (1.0, 0.5)
_EDGE_SHARES = np.linspace(0.0, 1.0, 5)
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
    _clear_m: FloatArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        from scipy.ndimage import distance_transform_edt

        low = frozen_array(self.low_m, name="low_m", shape=(2,), error=NavigationError)
        object.__setattr__(self, "low_m", low)
        taken = frozen_array(self.taken, name="taken", shape=(None, None), dtype=np.bool_)
        object.__setattr__(self, "taken", taken)
        squares = np.asarray(distance_transform_edt(np.pad(~taken, 1)))[1:-1, 1:-1]
        object.__setattr__(self, "_clear_m", self.step_m * np.maximum(squares - 0.5, 0.0))

    def __call__(self, points_m: FloatArray) -> npt.NDArray[np.bool_]:
        """Return at which points (m, 2) [m] the robot's centre cannot be, (m,)."""
        return np.asarray(self.clearance_m(points_m) == 0.0)

    def clearance_m(self, points_m: FloatArray) -> FloatArray:
        """Return how far the robot may be off points (m, 2) and still stand, to a square, (m,) [m].

        Parameters
        ----------
        points_m : Places of its centre [m].
        """
        i, j = np.rint((np.asarray(points_m) - self.low_m) / self.step_m).astype(np.int64).T
        nx, ny = self.taken.shape
        inside = (i >= 0) & (i < nx) & (j >= 0) & (j < ny)
        found = np.zeros(len(i))
        found[inside] = self._clear_m[i[inside], j[inside]]
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
    blocked: OccupancyGrid | None

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

    def towards(self, place_m: FloatArray, goal: int, *, margin_m: float = 0.0) -> FloatArray:
        """Return a point in free sight on the least way from a place to a goal, (2,) [m].

        Of a place that is not on free floor, from the nearest one that is. Where nothing is to be
        seen that keeps the margin, half of it has to do, or the next point of the way.

        Parameters
        ----------
        place_m : (2,) float64 — Where the robot is [m].
        goal : Which goal.
        margin_m : By how much the robot may miss the straight way [m].
        """
        end: FloatArray = self.ends_m[goal]
        first = self._nearest(place_m, np.isfinite(self.to_go_m[goal]))
        for share in _MARGINS:
            margin = share * margin_m
            if self.sees(place_m, end, margin_m=margin):
                return end
            seen = self._farthest(place_m, goal, first, margin)
            if seen is not None and math.dist(seen, place_m) > _STEP_M:
                return seen
        found = np.array([self.x_m[first[0]], self.y_m[first[1]]])
        number = int(self.following[goal, *first])
        if number < 0:
            return found
        i, j = divmod(number, len(self.y_m))
        after = np.array([self.x_m[i], self.y_m[j]])
        return after if self.sees(place_m, after) or math.dist(found, place_m) <= _STEP_M else found

    def _farthest(
        self, place_m: FloatArray, goal: int, node: tuple[int, int], margin_m: float
    ) -> FloatArray | None:
        """Return the last point after a node that is seen from a place [m]; None: not one."""
        found = None
        while True:
            number = int(self.following[goal, *node])
            if number < 0:
                return found
            node = divmod(number, len(self.y_m))
            point = np.array([self.x_m[node[0]], self.y_m[node[1]]])
            seen = self.sees(place_m, point, margin_m=margin_m)
            if math.dist(point, place_m) > _SIGHT_M or not seen:
                return found
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

    def sees(self, start_m: FloatArray, end_m: FloatArray, *, margin_m: float = 0.0) -> bool:
        """Return whether the robot can drive straight from a place to another.

        The margin need not be kept where the ends themselves are nearer to something: from there it
        grows by 0.3 for each metre of the way.

        Parameters
        ----------
        start_m, end_m : (2,) float64 — The places [m].
        margin_m : By how much it may miss the straight way [m].
        """
        if self.blocked is None:
            return True
        length = math.dist(start_m, end_m)
        parts = max(1, math.ceil(length / _SIGHT_STEP_M))
        share = np.arange(parts + 1) / parts
        clear = self.blocked.clearance_m(start_m + share[:, None] * (end_m - start_m))
        if not bool((clear[1:] > 0.0).all()):
            return False
        from_start = clear[0] + _WIDENING * length * share
        from_end = clear[-1] + _WIDENING * length * (1.0 - share)
        needed = np.minimum(margin_m, np.minimum(from_start, from_end))
        return bool((clear >= needed - 0.5 * self.blocked.step_m).all())

    def clearance_m(self, place_m: FloatArray) -> float:
        """Return how far the robot may be off a place and still stand [m]; inf: nothing stands.

        Parameters
        ----------
        place_m : (2,) float64 — The place [m].
        """
        if self.blocked is None:
            return math.inf
        return float(self.blocked.clearance_m(np.asarray(place_m)[None])[0])


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
    2.7 % longer than the shortest one; where the surroundings are not free they cost up to four
    times as much.

    Parameters
    ----------
    low_m, high_m : (2,) array_like — Corners of the rectangle [m].
    goals_m : (g, 2) array_like — Where to [m].
    blocked : Where the robot's centre cannot be; None: nowhere.
    margin_m : Distance that ways keep from obstacles where there is room [m].
    spacing_m : Step of the grid [m].
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    goals = frozen_array(goals_m, name="goals_m", shape=(None, 2), error=NavigationError)
    low, high = np.asarray(low_m, dtype=np.float64), np.asarray(high_m, dtype=np.float64)
    x, y = (np.arange(low[i], high[i] + 0.5 * spacing_m, spacing_m) for i in range(2))
    gx, gy = np.meshgrid(x, y, indexing="ij")
    points = np.column_stack([gx.ravel(), gy.ravel()])
    if blocked is None or isinstance(blocked, OccupancyGrid):
        taken = blocked
    else:
        taken = occupancy(low, high, lambda places: ~blocked(places))
    free = np.ones(gx.shape, dtype=np.bool_)
    if taken is not None:
        free = ~taken(points).reshape(gx.shape)
    if not free.any():
        msg = (
            f"nowhere between {low.tolist()} and {high.tolist()} m does the robot fit: make it "
            "smaller, or check what stands on the floor."
        )
        raise NavigationError(msg)
    number = np.arange(free.size).reshape(free.shape)
    rows, columns, lengths = [], [], []
    for di, dj in _NEIGHBOURS:
        a = (slice(max(0, -di), free.shape[0] - max(0, di)),
             slice(max(0, -dj), free.shape[1] - max(0, dj)))  # fmt: skip
        b = (slice(max(0, di), free.shape[0] + min(0, di)),
             slice(max(0, dj), free.shape[1] + min(0, dj)))  # fmt: skip
        both = free[a] & free[b]
        start, end = points[number[a][both]], points[number[b][both]]
        price, keep = np.ones(len(start)), np.ones(len(start), dtype=np.bool_)
        if taken is not None and len(start):
            places = start + _EDGE_SHARES[:, None, None] * (end - start)
            clear_m = taken.clearance_m(places.reshape(-1, 2)).reshape(len(_EDGE_SHARES), -1)
            near = np.clip(1.0 - clear_m / (margin_m + spacing_m), 0.0, 1.0)
            price += _NEAR_WALL * near.mean(axis=0)
            keep = np.asarray((clear_m > 0.0).all(axis=0))
        rows.append(number[a][both][keep])
        columns.append(number[b][both][keep])
        lengths.append(spacing_m * math.hypot(di, dj) * price[keep])
    graph = csr_array(
        (np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns))),
        shape=(free.size, free.size),
    )
    ends, nodes = [], []
    for goal in goals:
        away = np.where(free, (gx - goal[0]) ** 2 + (gy - goal[1]) ** 2, np.inf)
        node = int(np.argmin(away))
        fits = taken is None or not bool(taken(goal[None])[0])
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
        blocked=taken,
    )
