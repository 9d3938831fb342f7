"""Confidence intervals of shares, medians and other quantiles of a few runs; Gaussianity."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError

FloatArray = npt.NDArray[np.float64]

Z_95 = 1.959963984540054
"""Two-sided 95 % point of the normal distribution [-]."""

RESAMPLES = 2000
"""Resamples of the bootstrap."""

_SEED = 20_261_122
_LEAST_SAMPLES = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class Interval:
    """An estimate and its 95 % confidence interval, all in one unit.

    Parameters
    ----------
    value : The estimate [its unit].
    low, high : Ends of the interval [its unit].
    """

    value: float
    low: float
    high: float


def bootstrap_rng() -> np.random.Generator:
    """Return the generator of resamples, the same for every table: equal runs, equal intervals."""
    return np.random.default_rng(_SEED)


def wilson(successes: float, trials: int) -> Interval:
    """Return a share and its 95 % interval after Wilson, within 0 and 1 [-].

    (p + z²/2n ± z sqrt(p(1 - p)/n + z²/4n²)) / (1 + z²/n). Right also for shares of 0 and 1: 100 of
    100 gives 0.963 to 1. E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209-212; R. G. Newcombe, Stat.
    Med. 17 (1998) 857-872, method 3; in whole numbers `scipy.stats.binomtest`.

    Parameters
    ----------
    successes : Number of successes [-]; a tie may count one half.
    trials : Number of independent trials.
    """
    if not (trials > 0 and 0 <= successes <= trials):
        msg = (
            f"{successes:g} successes of {trials} trials is no share: give one trial or more, and "
            "no more successes than trials."
        )
        raise NavigationError(msg)
    share, z2 = successes / trials, Z_95**2
    middle = share + z2 / (2.0 * trials)
    half = Z_95 * math.sqrt(share * (1.0 - share) / trials + z2 / (4.0 * trials**2))
    scale = 1.0 + z2 / trials
    return Interval(
        value=share,
        low=0.0 if successes == 0 else (middle - half) / scale,
        high=1.0 if successes == trials else (middle + half) / scale,
    )


def bootstrap(
    values: npt.ArrayLike,
    statistic: Callable[[FloatArray], FloatArray],
    rng: np.random.Generator,
) -> tuple[Interval, ...]:
    """Return k statistics of a sample and their 95 % intervals by the percentile bootstrap.

    Too narrow below 15 values. Efron and Tibshirani, An Introduction to the Bootstrap (1993), 13.3.

    Parameters
    ----------
    values : (s,) array_like — Sample, in any unit; not empty [its unit].
    statistic : (..., s) values -> (k, ...) statistics [in the same unit].
    rng : Source of the 2000 resamples.
    """
    sample = np.asarray(values, dtype=np.float64)
    if not sample.size:
        msg = "an interval needs values, but there are none: give one or more."
        raise NavigationError(msg)
    drawn = sample[rng.integers(0, sample.size, (RESAMPLES, sample.size))]
    ends = np.quantile(statistic(drawn), (0.025, 0.975), axis=1)
    return tuple(
        Interval(value=float(value), low=float(low), high=float(high))
        for value, low, high in zip(statistic(sample), *ends, strict=True)
    )


def quantiles(
    values: npt.ArrayLike, probabilities: tuple[float, ...], rng: np.random.Generator
) -> tuple[Interval, ...]:
    """Return quantiles of a sample and their 95 % intervals by the percentile bootstrap.

    An interval of the 5 % quantile of fewer than some 60 samples ends at the smallest one.

    Parameters
    ----------
    values, rng : As for `bootstrap` [its unit], one set of resamples for all quantiles.
    probabilities : Wanted quantiles, 0 to 1 [-].
    """
    return bootstrap(values, lambda drawn: np.quantile(drawn, probabilities, axis=-1), rng)


@dataclass(frozen=True, slots=True, kw_only=True)
class Gaussianity:
    """The moments of a sample and the probability that a Gaussian gives such.

    Parameters
    ----------
    mean, standard_deviation : In the unit of the sample [any].
    skewness, excess_kurtosis : Third standardised moment, and fourth less 3 [-]; 0 for a Gaussian.
    p_value : Probability of moments as unusual as these if the sample is Gaussian [-].
    """

    mean: float
    standard_deviation: float
    skewness: float
    excess_kurtosis: float
    p_value: float


def gaussianity(sample: npt.ArrayLike) -> Gaussianity:
    """Return moments of a sample and the probability of D'Agostino and Pearson's test.

    Parameters
    ----------
    sample : (n,) array_like — 20 or more independent errors [any unit], not one filter's in a row.
    """
    from scipy.stats import kurtosis, normaltest, skew

    values = np.asarray(sample, dtype=np.float64).ravel()
    usable = values.size >= _LEAST_SAMPLES and bool(np.isfinite(values).all())
    if not usable or np.ptp(values) == 0.0:
        msg = (
            f"a test for a Gaussian needs at least {_LEAST_SAMPLES} finite values that differ, but "
            f"{values.size} were given: run more seeds."
        )
        raise NavigationError(msg)
    return Gaussianity(
        mean=float(values.mean()),
        standard_deviation=float(values.std(ddof=1)),
        skewness=float(skew(values)),
        excess_kurtosis=float(kurtosis(values)),
        p_value=float(normaltest(values).pvalue),
    )
