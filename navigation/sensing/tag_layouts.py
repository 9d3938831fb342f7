"""Where tags hang: meshes, lines, circles, and at random; and how many of them a robot hears."""

import math

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.checks import check_choice, check_positive
from octant.navigation.sensing.rss_models import tag_grid

FloatArray = npt.NDArray[np.float64]

PATTERNS = ("mesh", "line", "circle", "random")


def patterned_tags(
    pattern: str, count: int, *, field_m: float, height_m: float, rng: np.random.Generator
) -> FloatArray:
    """Return tags around the origin, (count, 3), heights above the robot's antenna [m].

    Parameters
    ----------
    pattern : ``mesh`` (a square one), ``line`` (along x), ``circle``, or ``random`` (uniform).
    count : Number of tags; of a mesh a square number.
    field_m : Side of the square that they fill: from the first to the last tag of a line, across
        the circle [m].
    height_m : Height above the robot's antenna [m].
    rng : Source of the random places.
    """
    check_choice(pattern, PATTERNS, name="the pattern of tags")
    check_positive(field_m, name="the field of the tags", unit="m")
    check_positive(height_m, name="the height of the tags", unit="m")
    if count < 1:
        msg = f"{count} tags are asked for, but at least one is needed: raise the number."
        raise NavigationError(msg)
    if pattern == "mesh":
        side = math.isqrt(count)
        if side**2 != count:
            msg = (
                f"a mesh of {count} tags is asked for, but a square mesh has a square number of "
                f"them: give {side**2} or {(side + 1) ** 2}, or another pattern."
            )
            raise NavigationError(msg)
        return tag_grid(side, spacing_m=field_m / max(side - 1, 1), height_m=height_m)
    if pattern == "random":
        places = rng.uniform(-0.5 * field_m, 0.5 * field_m, (count, 2))
    elif pattern == "line":
        along = field_m * (np.arange(count) / max(count - 1, 1) - 0.5 * (count > 1))
        places = np.column_stack([along, np.zeros(count)])
    else:
        angle = 2.0 * np.pi * np.arange(count) / count
        places = 0.5 * field_m * np.column_stack([np.cos(angle), np.sin(angle)])
    return np.column_stack([places, np.full(count, height_m)])


def tag_distances_m(places_m: npt.ArrayLike, tags_m: FloatArray) -> FloatArray:
    """Return the distances of places of the robot's antenna to tags, (m, s) [m].

    Parameters
    ----------
    places_m : (m, 2 or more) float64 — x, y [m]; what follows, such as the heading, is not read.
    tags_m : (s, 3) float64 — Places, heights above the antenna [m].
    """
    offset = np.asarray(places_m, dtype=np.float64)[:, None, :2] - tags_m[:, :2]
    distance: FloatArray = np.sqrt(np.sum(offset**2, axis=-1) + tags_m[:, 2] ** 2)
    return distance


def tags_heard(
    places_m: npt.ArrayLike, tags_m: FloatArray, *, range_m: float
) -> npt.NDArray[np.int64]:
    """Return how many tags are within their range of each place, (m,).

    Thesis 6.5.5 wants at least nine everywhere, each within the distances of its calibration, which
    end at 6.18 m (Table 6.1), and says that a mesh of nine, 3 m apart and 3 m high, ensures that.
    It does not: from its own start of the line, (-3.5, -4) m, five of the nine are farther.

    Parameters
    ----------
    places_m, tags_m : As for `tag_distances_m` [m].
    range_m : Range of a tag [m].
    """
    return np.asarray(np.sum(tag_distances_m(places_m, tags_m) <= range_m, axis=1))
