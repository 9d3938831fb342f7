"""Bearings from antennas at any azimuths, and from readings that a turning robot has gathered."""

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle

FloatArray = npt.NDArray[np.float64]

_LEAST_CONDITION = 0.05
_LEAST_GAP_RAD = 1e-3


def strongest_bearing(rss_w: npt.ArrayLike, azimuths_rad: npt.ArrayLike) -> float:
    """Return the azimuth of the strongest reading [rad], in the frame of the azimuths; NaN: none.

    Parameters
    ----------
    rss_w : (k,) float64 — Readings [W]; zero: not heard, NaN: none.
    azimuths_rad : (k,) float64 — Azimuths of the antennas when they were read [rad].
    """
    rss, azimuths = np.asarray(rss_w, dtype=np.float64), np.asarray(azimuths_rad, dtype=np.float64)
    known = np.isfinite(rss)
    if len(np.unique(np.round(wrap_angle(azimuths[known]), 3))) < 2 or not np.any(rss[known] > 0):
        return float("nan")
    return float(wrap_angle(azimuths[known][int(np.argmax(rss[known]))]))


def harmonic_bearing(rss_w: npt.ArrayLike, azimuths_rad: npt.ArrayLike) -> float:
    """Return the direction in which the first harmonic of the RSS is greatest [rad]; NaN: unknown.

    Least squares of z = a + b cos δ + c sin δ give atan2(c, b). For antennas spaced evenly on a
    full circle this is the vector sum; for others it lacks its pull towards where the antennas
    stand closer.

    Parameters
    ----------
    rss_w : (k,) float64 — Readings [W]; zero: not heard, NaN: none.
    azimuths_rad : (k,) float64 — Azimuths of the antennas when they were read [rad].

    Notes
    -----
    Unknown where fewer than three azimuths differ, or they span so little that the fit is blind:
    the least singular value of [1, cos δ, sin δ] is under 0.05 of the root of their number.
    """
    rss, azimuths = np.asarray(rss_w, dtype=np.float64), np.asarray(azimuths_rad, dtype=np.float64)
    known = np.isfinite(rss)
    z, delta = rss[known], azimuths[known]
    if len(z) < 3 or not np.any(z > 0.0):
        return float("nan")
    columns = np.column_stack([np.ones(len(z)), np.cos(delta), np.sin(delta)])
    values = np.linalg.svd(columns, compute_uv=False)
    if values[-1] < _LEAST_CONDITION * np.sqrt(len(z)):
        return float("nan")
    _, along, across = np.linalg.lstsq(columns, z / z.max(), rcond=None)[0]
    return float(np.arctan2(across, along))


def distinct_azimuths(azimuths_rad: npt.ArrayLike) -> FloatArray:
    """Return antennas' azimuths, one or more and all different, read-only (n,) [rad].

    Parameters
    ----------
    azimuths_rad : (n,) float64 — In any frame [rad].
    """
    azimuths = frozen_array(azimuths_rad, name="azimuths", shape=(None,), error=NavigationError)
    turns = np.sort(np.mod(azimuths, 2.0 * np.pi))
    gaps = np.diff(np.append(turns, turns[:1] + 2.0 * np.pi))
    if not len(azimuths) or gaps.min() < _LEAST_GAP_RAD:
        msg = (
            f"the azimuths are {np.degrees(azimuths).tolist()} deg, but each antenna needs its own "
            "direction; give one azimuth for each."
        )
        raise NavigationError(msg)
    return azimuths
