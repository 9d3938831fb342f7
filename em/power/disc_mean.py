"""The mean of received power over a small disc: the local mean that a moved antenna would measure.

The power sum over paths, the other local mean, takes all phases as independent.
"""

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import GeometryError

FloatArray = npt.NDArray[np.float64]

RINGS = 3
PLACES_PER_RING = 12
"""Places on each ring [-]. On a disc of one wavelength, where opposite waves turn against each
other by two whole turns, 3 x 12 places average their interference to 1 % of its amplitude."""

DISC_PLACES = RINGS * PLACES_PER_RING


def disc_rule_m(diameter_m: float) -> tuple[FloatArray, FloatArray]:
    """Return (k, 2) places on a disc about the origin [m], and the share of the disc of each [-].

    Gauss-Legendre in the radius squared; even steps around, every second ring turned half a step.

    Parameters
    ----------
    diameter_m : Diameter [m].
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
    """Return the mean power on horizontal discs, (m,) or (m, n) [W]; NaN where none is usable.

    Parameters
    ----------
    power_w : Coherent power [W], (k,) or (k, n), at (k, 3) places [m].
    places_m, diameter_m : (m, 3), () float — Centres and diameter, often lambda, of discs [m].
    usable : Whether an antenna can be at (k, 3) places [m], not beyond a wall or in a cabinet.
    progress : Called with how many of the `DISC_PLACES` places are done [-].
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
