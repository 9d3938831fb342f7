"""The distribution of bearing errors: mean, rms, percentiles, and the shares that mislead."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.navigation.angles import wrap_angle
from octant.reader_design.setting.measures import vector_sum_bearing_rad

FloatArray = npt.NDArray[np.float64]

ASIDE_RAD = math.pi / 4.0
"""An error beyond this [rad] points past the neighbour of the right one of eight antennas."""
ASTRAY_RAD = math.pi / 2.0
"""An error beyond this [rad] sends the robot away from the tag."""
_ROUNDING_RAD = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorSummary:
    """The distribution of absolute bearing errors.

    Attributes
    ----------
    mean_rad, rms_rad, median_rad, p90_rad, max_rad : Mean, root mean square, 50th and 90th
        percentile and greatest [rad]. A percentile is the least error that at least this share of
        the weight does not exceed.
    beyond_45_share, beyond_90_share : Shares of the weight [-] with errors beyond 45 and 90
        degrees.
    """

    mean_rad: float
    rms_rad: float
    median_rad: float
    p90_rad: float
    max_rad: float
    beyond_45_share: float
    beyond_90_share: float


def summarise_errors(error_rad: FloatArray, weight: FloatArray | None = None) -> ErrorSummary:
    """Return the distribution of bearing errors [rad].

    Sums run in a fixed order: the same bits at any number of threads, which BLAS would not give.

    Parameters
    ----------
    error_rad : (...) float64 — Errors [rad], of either sign; at least one.
    weight : (...) float64, optional — Weight of each [-], not negative, not all zero; default:
        equal.
    """
    size = np.abs(error_rad).ravel()
    share = np.ones(size.size) if weight is None else weight.ravel()
    size, share = size[share > 0.0], share[share > 0.0]
    order = np.argsort(size, kind="stable")
    size, share = size[order], share[order]
    cumulative, total = np.cumsum(share), share.sum()

    def percentile(level: float) -> float:
        index = int(np.searchsorted(cumulative, (level - 1e-12) * total))
        return float(size[min(index, size.size - 1)])

    def beyond(limit_rad: float) -> float:
        return float(share[size > limit_rad + _ROUNDING_RAD].sum() / total)

    return ErrorSummary(
        mean_rad=float((share * size).sum() / total),
        rms_rad=float(np.sqrt((share * size**2).sum() / total)),
        median_rad=percentile(0.5),
        p90_rad=percentile(0.9),
        max_rad=float(size[-1]),
        beyond_45_share=beyond(ASIDE_RAD),
        beyond_90_share=beyond(ASTRAY_RAD),
    )


def vector_errors_rad(
    rss_w: FloatArray, azimuths_rad: FloatArray, element_azimuths_rad: FloatArray
) -> FloatArray:
    """Return the (d, a) bearing errors of the RSS-weighted vector sum, estimate minus truth [rad].

    They lie in (-pi, pi]; pi where there is no bearing (nothing received, or all antennas equally
    strong).

    Parameters
    ----------
    rss_w : (d, a, n) float64 — RSS [W] by distance or place, azimuth of the tag, antenna.
    azimuths_rad : (a,) or (d, a) float64 — Azimuths of the tag in the reader frame [rad].
    element_azimuths_rad : (n,) float64 — Azimuths of the antennas [rad].
    """
    error = wrap_angle(vector_sum_bearing_rad(rss_w, element_azimuths_rad) - azimuths_rad)
    return np.where(np.isnan(error), np.pi, error)
