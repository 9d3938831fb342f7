"""Where a round robot touches the walls and objects of a scene."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS
from octant.navigation.checks import check_positive

FloatArray = npt.NDArray[np.float64]

_FLOOR_M = 0.01
_LEVELS = (0.1, 0.5, 0.9)


@dataclass(frozen=True, slots=True, kw_only=True)
class Footprint:
    """Return a round robot among obstacles: where its centre cannot stand.

    Parameters
    ----------
    edges_m : (e, 4) float64
        Plan of the obstacles: segments x, y, x, y [m].
    radius_m : float
        Radius of the robot [m].

    Raises
    ------
    NavigationError
        When the radius is not positive.

    Notes
    -----
    The segments are where the scene's triangles, cut to the heights that the robot fills, end in
    plan. A robot that moves in steps shorter than its radius cannot pass one unnoticed; a start
    inside a large object is told from its solid, see `RobotSpace`.
    """

    edges_m: FloatArray
    radius_m: float

    def __post_init__(self) -> None:
        edges = frozen_array(self.edges_m, name="edges_m", shape=(None, 4), error=NavigationError)
        object.__setattr__(self, "edges_m", edges)
        check_positive(self.radius_m, name="radius_m", unit="m")

    def clearance_m(self, points_m: npt.ArrayLike) -> FloatArray:
        """Return the distance from points to the nearest obstacle, less the radius.

        Parameters
        ----------
        points_m : (m, 2) array_like
            Places of the robot's centre [m].

        Returns
        -------
        (m,) float64
            Free distance [m], negative where the robot would overlap; infinity without obstacles.
        """
        points = np.asarray(points_m, dtype=np.float64).reshape(-1, 2)
        if not len(self.edges_m):
            return np.full(len(points), np.inf)
        start, along = self.edges_m[:, :2], self.edges_m[:, 2:] - self.edges_m[:, :2]
        length2 = np.maximum(np.sum(along**2, axis=1), LENGTHS.same_m**2)
        away = points[:, None] - start
        share = np.clip(np.sum(away * along, axis=2) / length2, 0.0, 1.0)
        gap = away - share[..., None] * along
        return np.asarray(np.sqrt(np.sum(gap**2, axis=2).min(axis=1)) - self.radius_m)

    def __call__(self, points_m: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        """Return at which points the robot touches something [-].

        Parameters
        ----------
        points_m : (m, 2) float64
            Places of its centre [m].

        Returns
        -------
        (m,) bool
            True where it overlaps an obstacle.
        """
        return np.asarray(self.clearance_m(points_m) < 0.0)


def footprint(scene: Scene, *, radius_m: float, height_m: float) -> Footprint:
    """Return a round robot among the walls and objects of a scene.

    Parameters
    ----------
    scene : Scene
        Room and objects.
    radius_m : float
        Radius of the robot [m].
    height_m : float
        Height of the robot [m]; what hangs higher does not touch it.

    Returns
    -------
    Footprint
        With the plan of everything between 1 cm above the floor and the robot's top.

    Raises
    ------
    NavigationError
        When radius or height is not positive.
    """
    check_positive(height_m, name="height_m", unit="m")
    low, high = scene.floor_height_m + _FLOOR_M, scene.floor_height_m + height_m
    edges: list[FloatArray] = []
    for body in scene.bodies:
        for corners in body.vertices_m[body.faces]:
            polygon = _cut(_cut(corners, low, above=True), high, above=False)
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
    """Return where on the floor a robot can stand, large objects and the outside included.

    Parameters
    ----------
    footprint : Footprint
        The robot among the scene's edges.
    scene : Scene
        Room and objects.
    height_m : float
        Height of the robot [m].
    """

    footprint: Footprint
    scene: Scene
    height_m: float

    def __call__(self, points_m: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
        """Return at which points the robot can stand [-].

        Parameters
        ----------
        points_m : (m, 2) float64
            Places of its centre [m].

        Returns
        -------
        (m,) bool
            True inside the room, outside every solid and clear of the obstacles' edges.
        """
        free = ~self.footprint(points_m)
        for share in _LEVELS:
            z = np.full(len(free), self.scene.floor_height_m + share * self.height_m)
            column = np.column_stack([points_m, z])
            free &= self.scene.inside_room(column) & ~self.scene.inside_solid(column)
        return free


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
