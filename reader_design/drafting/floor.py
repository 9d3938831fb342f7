"""Where the floor of an unknown room lies, and where a robot can drive on it."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.occlusion import segments_blocked
from octant.geometries.scene import Scene
from octant.navigation.robot.floor import RobotSpace, footprint

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

GRID = 48
"""Places along the longer side of a room that are looked at [-]."""
LEAST_STEP_M = 0.1
"""Least distance of these places [m]."""
HEADROOM_M = 1.0
"""Free height above a floor that a robot with a reader needs [m]."""
UNEVEN_M = 0.06
"""How far the surface of a floor may lie from its level, as in a scanned room [m]."""
LEVELS = 12
"""Levels of which it is tried whether they are the floor, the largest surfaces [-]."""
ROBOT_RADIUS_M, ROBOT_HEIGHT_M = 0.15, 0.4
"""The robot of missions [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OpenFloor:
    """Where a robot can stand.

    Parameters
    ----------
    space : The robot in the room.
    places_m : (n, 2) float64 — Free places that hang together, the largest such part [m].
    clearance_m : (n,) float64 — Free distance around the robot at each [m].
    level_m : Height of the floor [m].
    """

    space: RobotSpace
    places_m: FloatArray
    clearance_m: FloatArray
    level_m: float


def floor_level_m(scene: Scene) -> float | None:
    """Return the height of the floor [m]: the lowest level with room above; None: there is none.

    Levels are the heights at which level surface lies. A level counts by the share of places of a
    grid at which surface lies there with `HEADROOM_M` free above; the lowest that has half of the
    best share is the floor, so that a table or an upper floor is not; its height is the middle one
    of its upper surface at these places, as undersides of slabs and of furniture lie close below.

    Parameters
    ----------
    scene : The room [m].
    """
    corners = scene.triangle_corners_m
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(normal, axis=1)
    level = np.abs(normal[:, 2]) > 0.9 * twice
    if not level.any():
        return None
    bins = np.round(corners[level, :, 2].mean(axis=1) / UNEVEN_M).astype(np.int64)
    heights, inverse = np.unique(bins, return_inverse=True)
    area = np.bincount(inverse, weights=0.5 * twice[level])
    low, high = scene.bounds_m[:, :2]
    grid = grid_m(low, high)
    shares: dict[float, float] = {}
    for i in np.argsort(area)[::-1][:LEVELS]:
        here = np.abs(bins - heights[i]) <= 0
        z = float(np.average(corners[level][here, :, 2].mean(axis=1), weights=twice[level][here]))
        shares[z] = float(_standing(scene, grid, z).mean())
    best = max(shares.values())
    if best <= 0.0:
        return None
    lowest = min(z for z, share in shares.items() if share >= 0.5 * best)
    return round(_surface_m(scene, grid[_standing(scene, grid, lowest)], lowest), 3)


def open_floor(scene: Scene, level_m: float) -> OpenFloor:
    """Return where a robot can stand on the floor, the largest part that hangs together.

    Parameters
    ----------
    scene : The room; its ``floor_m`` is the level.
    level_m : Height of the floor [m].
    """
    from scipy.ndimage import label

    low, high = scene.bounds_m[:, :2]
    grid = grid_m(low, high)
    foot = footprint(scene, radius_m=ROBOT_RADIUS_M, height_m=ROBOT_HEIGHT_M)
    space = RobotSpace(footprint=foot, scene=scene, height_m=ROBOT_HEIGHT_M)
    clear = foot.clearance_m(grid)
    free = (clear > 0.0) & _standing(scene, grid, level_m)
    chosen = np.flatnonzero(free)
    free[chosen] = space(grid[chosen])
    count_x = len(np.unique(grid[:, 0]))
    parts, count = label(free.reshape(count_x, -1))
    if count == 0:
        return OpenFloor(space=space, places_m=grid[:0], clearance_m=clear[:0], level_m=level_m)
    sizes = np.bincount(parts.reshape(-1))
    sizes[0] = 0
    part = parts.reshape(-1) == int(np.argmax(sizes))
    return OpenFloor(space=space, places_m=grid[part], clearance_m=clear[part], level_m=level_m)


def grid_m(low: FloatArray, high: FloatArray) -> FloatArray:
    """Return places (n, 2) over a rectangle, in the middles of even cells, x slowest [m].

    Parameters
    ----------
    low, high : (2,) float64 — Its corners [m].
    """
    span = high - low
    step = max(float(span.max()) / GRID, LEAST_STEP_M)
    axes = []
    for start, length in zip(low.tolist(), span.tolist(), strict=True):
        count = max(1, int(length / step))
        axes.append(start + length * (np.arange(count) + 0.5) / count)
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)


def surface_above_m(scene: Scene, points_m: FloatArray) -> FloatArray:
    """Return the height of the first surface above each place (n, 3), infinity without one [m].

    Parameters
    ----------
    scene, points_m : The room, and places [m].
    """
    low, high = points_m[:, 2].copy(), np.full(len(points_m), scene.bounds_m[1, 2] + 1.0)

    def blocked(z_m: FloatArray) -> BoolArray:
        return segments_blocked(scene.bvh, points_m, np.column_stack((points_m[:, :2], z_m)))

    found = blocked(high)
    for _ in range(30):
        middle = 0.5 * (low + high)
        hit = blocked(middle)
        low, high = np.where(hit, low, middle), np.where(hit, middle, high)
    return np.where(found, high, np.inf)


def _surface_m(scene: Scene, places_m: FloatArray, level_m: float) -> float:
    """Return the median height of the surface about a level that is met from above [m]."""
    top = np.column_stack((places_m, np.full(len(places_m), level_m + UNEVEN_M)))
    low, high = np.full(len(top), level_m - UNEVEN_M), top[:, 2].copy()
    for _ in range(20):  # the surface lies between low and high
        middle = 0.5 * (low + high)
        hit = segments_blocked(scene.bvh, top, np.column_stack((places_m, middle)))
        low, high = np.where(hit, middle, low), np.where(hit, high, middle)
    return float(np.median(0.5 * (low + high))) + 0.0


def _standing(scene: Scene, grid: FloatArray, level_m: float) -> BoolArray:
    """Return at which places there is surface at a level and headroom above it."""

    def at(height_m: float) -> FloatArray:
        return np.column_stack((grid, np.full(len(grid), height_m)))

    over, under = at(level_m + UNEVEN_M), at(level_m - UNEVEN_M)
    floor = segments_blocked(scene.bvh, over, under)
    return floor & ~segments_blocked(scene.bvh, at(level_m + HEADROOM_M), over)
