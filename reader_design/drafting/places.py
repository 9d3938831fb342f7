"""Tags and a start in an unknown room: on free floor, in sight, in no body."""

import itertools
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.geometries.occlusion import segments_blocked
from octant.geometries.scene import Scene
from octant.reader_design.drafting.floor import OpenFloor, surface_above_m

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

USUAL_HEIGHT_M = 2.5
"""Height of tags above the floor where there is no ceiling, or one too high [m]."""
LEAST_HEIGHT_M = 0.8
"""Least height of a tag above the floor: the reader's antennas stand at 0.3 m [m]."""
HIGHEST_CEILING_M = 4.0
"""Height of a ceiling up to which tags hang on it [m]."""
OFF_CEILING_M = 0.05
"""Distance of a tag from the ceiling [m]."""
READER_M = 0.36
"""Height of the antennas of the default reader above the floor [m]."""
WAY_M = (0.8, 2.5, 5.0)
"""Least, best and greatest length of a way between start and tags [m]."""
WANTED_CLEAR_M = 0.4
"""Free distance around the robot on its ways that is wanted [m]."""
TRIED = 24
"""Places among which start and tags are chosen [-]."""
_STEP_M = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class DraftPlaces:
    """Where a draft puts start and tags.

    Parameters
    ----------
    start_m, heading_deg : Where the robot starts, with its front to the first tag [m], [deg].
    tags_m : Places of the tags [m].
    on_ceiling : Whether each hangs on a ceiling.
    """

    start_m: tuple[float, float]
    heading_deg: float
    tags_m: tuple[tuple[float, float, float], ...]
    on_ceiling: tuple[bool, ...]


def choose_places(scene: Scene, floor: OpenFloor) -> DraftPlaces:
    """Return a start and up to two tags such that a robot can drive straight from one to the next.

    Each way is free for the robot and between 0.8 and 5 m long; from its beginning and its end the
    tag is in sight. Among such places those with much free floor around count, and ways of about
    2.5 m. A room that has none is refused.

    Parameters
    ----------
    scene, floor : The room, and where a robot can stand [m].
    """
    chosen = _spread(floor)
    places = floor.places_m[chosen]
    if len(places) < 2:
        raise ConfigError(_no_floor(floor))
    tags, ceiling = _tag_places(scene, floor, places)
    hangs = np.isfinite(tags[:, 2])
    pairs = {
        (i, j): score
        for i, j in itertools.permutations(range(len(places)), 2)
        if hangs[j] and (score := _way_score(scene, floor, places[i], tags[j])) > 0.0
    }
    if not pairs:
        raise ConfigError(_no_floor(floor))
    best = max(pairs, key=lambda pair: (pairs[pair], pair))
    start, first = best
    order = [first]
    triples = [
        (pairs[i, j] + pairs[j, k], (i, j, k))
        for (i, j) in pairs
        for k in range(len(places))
        if (j, k) in pairs and k != i and np.hypot(*(places[k] - places[i])) > WAY_M[0]
    ]
    if triples:
        start, *order = max(triples)[1]
    ahead = places[order[0]] - places[start]
    return DraftPlaces(
        start_m=(_rounded(places[start][0]), _rounded(places[start][1])),
        heading_deg=float(round(np.degrees(np.arctan2(ahead[1], ahead[0])) / 5.0) * 5.0),
        tags_m=tuple((_rounded(x), _rounded(y), _rounded(z)) for x, y, z in tags[order]),
        on_ceiling=tuple(bool(on) for on in ceiling[order]),
    )


def _no_floor(floor: OpenFloor) -> str:
    return (
        f"no way of {WAY_M[0]:g} m over free floor with a place for a tag above its end was found "
        f"(floor at z = {floor.level_m:.3g} m, {len(floor.places_m)} free places); check unit and "
        "axis with octant audit, and write the study by hand where they are right."
    )


def _rounded(value: float) -> float:
    return float(round(value, 2)) + 0.0


def _spread(floor: OpenFloor) -> npt.NDArray[np.int64]:
    """Return places with free floor around, far from each other, about the middle of the floor."""
    places, clear = floor.places_m, np.minimum(floor.clearance_m, WANTED_CLEAR_M)
    good = np.flatnonzero(clear >= min(0.1, float(clear.max(initial=0.0))))
    if len(good) == 0:
        return good
    off_m = np.hypot(*(places - np.median(places[good], axis=0)).T)
    first = int(good[np.lexsort((off_m[good], -clear[good]))[0]])
    near = good[np.hypot(*(places[good] - places[first]).T) <= WAY_M[2]]
    chosen, distance = [first], np.full(len(places), np.inf)
    while len(chosen) < min(TRIED, len(near)):
        distance = np.minimum(distance, np.hypot(*(places - places[chosen[-1]]).T))
        worth = distance * (0.1 + clear)
        worth[chosen] = -1.0
        chosen.append(int(near[int(np.argmax(worth[near]))]))
    return np.array(chosen, dtype=np.int64)


def _tag_places(scene: Scene, floor: OpenFloor, places: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return a tag's place above each place, NaN where there is none, and whether on a ceiling."""
    from_m = np.column_stack((places, np.full(len(places), floor.level_m + READER_M)))
    above = surface_above_m(scene, from_m) - floor.level_m
    on_ceiling = above <= HIGHEST_CEILING_M
    height = np.where(on_ceiling, above - OFF_CEILING_M, np.minimum(above, USUAL_HEIGHT_M))
    if scene.has_room:
        height = np.minimum(height, scene.bounds_m[1, 2] - floor.level_m - OFF_CEILING_M)
    tags = np.column_stack((places, floor.level_m + np.floor(100.0 * height) / 100.0))
    fits = (height >= LEAST_HEIGHT_M) & scene.inside_room(tags) & ~scene.inside_solid(tags)
    tags[~fits, 2] = np.nan
    return tags, on_ceiling


def _way_score(scene: Scene, floor: OpenFloor, start: FloatArray, tag: FloatArray) -> float:
    """Return how good a way is, 0 where it is not possible [m]."""
    along = tag[:2] - start
    length = float(np.hypot(*along))
    least, best, greatest = WAY_M
    if not least <= length <= greatest:
        return 0.0
    shares = np.linspace(0.0, 1.0, 2 + int(length / _STEP_M))
    way = start + shares[:, None] * along
    clear = floor.space.footprint.clearance_m(way)
    if clear.min() <= 0.5 * _STEP_M or not floor.space(way[:: max(1, len(way) // 4)]).all():
        return 0.0
    ends = np.column_stack((way[[0, len(way) // 2]], np.full(2, floor.level_m + READER_M)))
    if segments_blocked(scene.bvh, ends, np.tile(tag, (2, 1))).any():
        return 0.0
    return 1.0 - abs(length - best) / (2.0 * greatest) + min(float(clear.min()), WANTED_CLEAR_M)
