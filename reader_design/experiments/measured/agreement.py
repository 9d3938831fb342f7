"""How far two sets of levels agree: bias, scatter, correlation and percentiles with intervals."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.navigation.statistics import Interval, bootstrap, bootstrap_rng

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

PERCENTILES = (0.05, 0.5, 0.95)
"""Percentiles of the difference that are given [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Agreement:
    """Measured less predicted levels of some observations, each number with its 95 % interval.

    Parameters
    ----------
    name : Of which observations.
    count : Number of them.
    bias_db, sd_db : Mean difference, and its standard deviation about that mean [dB].
    correlation : Of measured and predicted levels [-]; NaN below three observations.
    percentiles_db : Percentiles `PERCENTILES` of the difference less its mean [dB].
    unheard : Observations without any heard reading that were predicted below the threshold too,
        and how many there are [-].
    """

    name: str
    count: int
    bias_db: Interval
    sd_db: Interval
    correlation: Interval
    percentiles_db: tuple[Interval, ...]
    unheard: tuple[int, int] = (0, 0)


def agreement(
    name: str,
    measured_dbm: FloatArray,
    predicted_dbm: FloatArray,
    *,
    unheard: tuple[int, int] = (0, 0),
) -> Agreement:
    """Return how measured levels agree with predicted ones; intervals by the bootstrap over them.

    Neighbouring cells resemble each other, so that the intervals are rather too narrow.

    Parameters
    ----------
    name : Of which observations.
    measured_dbm, predicted_dbm : (o,) float64 — Levels; not finite ones are left out [dBm].
    unheard : See `Agreement` [-].
    """
    finite = np.isfinite(measured_dbm) & np.isfinite(predicted_dbm)
    measured, predicted = measured_dbm[finite], predicted_dbm[finite]
    n = len(measured)
    if n < 2:
        nan = Interval(value=np.nan, low=np.nan, high=np.nan)
        mean = float(np.mean(measured - predicted)) if n else np.nan
        bias = Interval(value=mean, low=np.nan, high=np.nan)
        return Agreement(
            name=name,
            count=n,
            bias_db=bias,
            sd_db=nan,
            correlation=nan,
            percentiles_db=(nan,) * len(PERCENTILES),
            unheard=unheard,
        )

    def numbers(drawn: FloatArray) -> FloatArray:
        rows = drawn.astype(np.int64)
        y, p = measured[rows], predicted[rows]
        difference = y - p
        mean = difference.mean(axis=-1, keepdims=True)
        y0, p0 = y - y.mean(axis=-1, keepdims=True), p - p.mean(axis=-1, keepdims=True)
        size = np.sqrt((y0**2).sum(axis=-1) * (p0**2).sum(axis=-1))
        with np.errstate(divide="ignore", invalid="ignore"):
            correlation = (y0 * p0).sum(axis=-1) / size
        spread = np.sqrt(((difference - mean) ** 2).sum(axis=-1) / (n - 1))
        parts = np.quantile(difference - mean, PERCENTILES, axis=-1)
        return np.stack([mean[..., 0], spread, np.nan_to_num(correlation), *parts])

    bias, sd, correlation, *percentiles = bootstrap(
        np.arange(n, dtype=np.float64), numbers, bootstrap_rng()
    )
    return Agreement(
        name=name,
        count=n,
        bias_db=bias,
        sd_db=sd,
        correlation=correlation,
        percentiles_db=tuple(percentiles),
        unheard=unheard,
    )


def pooled_sd_db(residual_db: FloatArray, groups: IntArray) -> float:
    """Return the standard deviation of residuals about the mean of each group, pooled [dB].

    The root of the mean square, as of a fit of one number a group: sums are over observations.

    Parameters
    ----------
    residual_db, groups : (o,) float64 — Residuals; not finite ones are left out [dB]. Their groups.
    """
    finite = np.isfinite(residual_db)
    r, (_, g) = residual_db[finite], np.unique(groups[finite], return_inverse=True)
    if not r.size:
        return float("nan")
    g = g.reshape(-1)
    mean = np.bincount(g, r) / np.bincount(g)
    return float(np.sqrt(np.mean((r - mean[g]) ** 2)))
