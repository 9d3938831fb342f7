"""Where a robot is, from one reading of several tags whose places it knows: localisation proper.

The counterpart of navigation in thesis 5.4.3, which sets its 9 to 20 cm beside the 30 to 40 cm of
an RSS-based localisation.
"""

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

FloatArray = npt.NDArray[np.float64]

_LEAST_TAGS = {"distances": 3, "bearings": 2}


def place_by_distances(distances_m: FloatArray, tags_m: FloatArray) -> FloatArray:
    """Return the place (2,) of least squared errors of the distances [m]; NaN below three of them.

    Parameters
    ----------
    distances_m : (k,) float64 — Distances along the floor from the tags' points, or NaN [m].
    tags_m : (k, 2) float64 — These points, not all on one line [m].
    """
    known = np.isfinite(distances_m)
    if int(known.sum()) < _LEAST_TAGS["distances"]:
        return np.full(2, np.nan)
    reach, tags = distances_m[known], tags_m[known]
    # Differences of the circles are linear in the place; exact distances are solved already.
    square = reach**2 - (tags**2).sum(axis=1)
    first = np.linalg.lstsq(2.0 * (tags[0] - tags[1:]), square[1:] - square[0], rcond=None)[0]
    fit = least_squares(lambda place: np.linalg.norm(place - tags, axis=1) - reach, first)
    return np.asarray(fit.x)


def place_by_bearings(bearings_rad: FloatArray, tags_m: FloatArray) -> FloatArray:
    """Return the place (2,) nearest to all lines of sight [m]; NaN below two of them.

    Parameters
    ----------
    bearings_rad : (k,) float64 — Directions in the room from the robot to the tags, or NaN [rad].
    tags_m : (k, 2) float64 — Their points on the floor [m].
    """
    known = np.isfinite(bearings_rad)
    if int(known.sum()) < _LEAST_TAGS["bearings"]:
        return np.full(2, np.nan)
    across = np.column_stack([-np.sin(bearings_rad[known]), np.cos(bearings_rad[known])])
    offsets = (across * tags_m[known]).sum(axis=1)
    return np.asarray(np.linalg.lstsq(across, offsets, rcond=None)[0])
