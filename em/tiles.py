"""Orders of many places in which neighbours in the list are neighbours in space."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

TILE = 128
"""Places [-] that stand in a square of their own in `near_each_other`."""


def near_each_other(places_m: npt.NDArray[np.float64]) -> npt.NDArray[np.int64]:
    """Return an order (m,) [-] of places in which those that follow each other are close together.

    Strips across the longest side, each from end to end of the second longest, as wide as
    `TILE` places in a row take of it.

    Parameters
    ----------
    places_m : (m, 3) float64 — Places [m].
    """
    if len(places_m) <= TILE:
        return np.arange(len(places_m))
    extent = np.ptp(places_m, axis=0)
    along, across = np.argsort(-extent, kind="stable")[:2]
    tiles = math.sqrt(len(places_m) / TILE * float(extent[across] / (extent[along] or 1.0)))
    width = float(extent[across]) / max(1, round(tiles)) or 1.0
    strip = (places_m[:, across] - places_m[:, across].min()) // width
    return np.lexsort((places_m[:, along], strip))


def put_back(order: npt.NDArray[np.int64], rows: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return rows [any unit] where they were before `near_each_other` put them in order.

    Parameters
    ----------
    order : (m,) int64 — The order.
    rows : (m, ...) — Results in that order.
    """
    back = np.empty_like(rows)
    back[order] = rows
    return back
