"""Whether errors are Gaussian, as the Kalman filters take them to be."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError

_LEAST_SAMPLES = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class Gaussianity:
    """The moments of a sample and the probability that a Gaussian gives such.

    Parameters
    ----------
    mean : float
        Mean, in the unit of the sample [any].
    standard_deviation : float
        Standard deviation, in the unit of the sample [any].
    skewness : float
        Third standardised moment [-]; 0 for a Gaussian.
    excess_kurtosis : float
        Fourth standardised moment less 3 [-]; 0 for a Gaussian.
    p_value : float
        Probability of moments as unusual as these if the sample is Gaussian [-].
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
    sample : (n,) array_like
        Independent errors [any unit], 20 or more. Errors of one filter at successive times are not
        independent: take one time of many runs.
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
