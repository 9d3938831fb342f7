"""The mean of received power over a small disc: the local mean that a moved antenna would measure.

The other local mean, the power sum over paths, takes the phases of all paths as independent; this
one averages the coherent power itself.
"""

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import GeometryError

FloatArray = npt.NDArray[np.float64]

RINGS = 3
"""Rings of places on a disc [-]."""
PLACES_PER_RING = 12
"""Places on each ring [-]. On a disc of one wavelength, where opposite waves turn against each
other by two whole turns, 3 x 12 places average their interference to 1 % of its amplitude."""

DISC_PLACES = RINGS * PLACES_PER_RING
"""Places on a disc [-]."""


def disc_rule_m(diameter_m: float) -> tuple[FloatArray, FloatArray]:
    """Return places on a horizontal disc about the origin [m], and the share of the disc of each.

    Parameters
    ----------
    diameter_m : Diameter [m].

    Returns
    -------
    (k, 2) float64
        x and y [m]: Gauss-Legendre in the square of the radius, equal steps around, every second
        ring turned by half a step.
    (k,) float64
        Shares [-], which add up to 1.
    """
    if not (math.isfinite(diameter_m) and diameter_m > 0.0):
        msg = f"{diameter_m} m is no diameter of a disc; give a diameter above 0 m."
        raise GeometryError(msg)
    node, weight = np.polynomial.legendre.leggauss(RINGS)
    radius = 0.5 * diameter_m * np.sqrt(0.5 * (node + 1.0))[:, None]
    turn = 0.5 * (np.arange(RINGS) % 2)[:, None]
    angle = 2.0 * math.pi / PLACES_PER_RING * (np.arange(PLACES_PER_RING) + turn)
    share = np.repeat(0.5 * weight / PLACES_PER_RING, PLACES_PER_RING)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    return np.column_stack((x.ravel(), y.ravel())), share


def mean_over_disc(
    power_w: Callable[[FloatArray], FloatArray],
    places_m: npt.ArrayLike,
    *,
    diameter_m: float,
    usable: Callable[[FloatArray], npt.NDArray[np.bool_]],
    progress: Callable[[int], None] | None = None,
) -> FloatArray:
    """Return the mean power [W] over a horizontal disc about each of many places.

    Parameters
    ----------
    power_w : Coherent power [W], (k,) or (k, n), at (k, 3) places [m].
    places_m : (m, 3) float — Centres of the discs [m].
    diameter_m : Diameter of the discs [m]; one wavelength is usual.
    usable : Whether an antenna can be at each of (k, 3) places [m]: beyond a wall or inside a
        cabinet there is nothing to average.
    progress : Called with how many of the `DISC_PLACES` places are done [-].

    Returns
    -------
    (m,) or (m, n) float64
        Power [W]; NaN where no place of the disc is usable.
    """
    places = np.asarray(places_m, dtype=np.float64)
    total: FloatArray | None = None
    weight = np.zeros(len(places))
    for done, (offset, share) in enumerate(zip(*disc_rule_m(diameter_m), strict=True), start=1):
        moved = places + np.append(offset, 0.0)
        inside = np.flatnonzero(usable(moved))
        power = power_w(moved[inside])
        if total is None:
            total = np.zeros((len(places), *power.shape[1:]))
        total[inside] += share * power
        weight[inside] += share
        if progress is not None:
            progress(done)
    assert total is not None  # noqa: S101  a disc has at least one place
    with np.errstate(invalid="ignore"):
        mean: FloatArray = total / weight.reshape(-1, *(1,) * (total.ndim - 1))
    return mean
