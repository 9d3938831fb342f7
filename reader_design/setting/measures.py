"""What the RSS of a reader's antennas says about a tag's direction, sample by sample.

Everything here is a pure function of three arrays: the RSS of all antennas ``rss_w``
(distance or place, azimuth of the tag, antenna), the tag's azimuths in the reader frame, and the
azimuths of the antennas.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.decibels import decibels
from octant.geometries.errors import AntennaError
from octant.navigation.angles import wrap_angle
from octant.navigation.sensing.bearing import (
    FRONT_AZIMUTH_RAD,
    steering_pair,
    vector_sum_bearing,
)

FloatArray = npt.NDArray[np.float64]

ANGLE_TOLERANCE_RAD = 1e-6
"""Azimuths closer than this are the same direction [rad]."""
POWER_TIE = 1e-9
"""Antennas whose RSS differ by less than this relative amount [-] are equally strong."""
RATIO_CAP_DB = 200.0
"""Power ratios are capped to plus and minus this value [dB], so that a null stays a number."""


def leaders(rss_w: FloatArray) -> FloatArray:
    """Return each antenna's weight as the strongest one [-]: 1, or 1/k where k are equally strong.

    They sum to 1; all are 0 where nothing is received.

    Parameters
    ----------
    rss_w : (..., n) float64 — RSS [W].
    """
    peak = rss_w.max(axis=-1, keepdims=True)
    lead = (rss_w >= peak * (1.0 - POWER_TIE)) & (peak > 0.0)
    weight: FloatArray = lead / np.maximum(lead.sum(axis=-1, keepdims=True), 1)
    return weight


def right_share(
    rss_w: FloatArray, azimuths_rad: FloatArray, element_azimuths_rad: FloatArray
) -> float:
    """Return the share of directions whose strongest antenna is the nearest in angle [-].

    Parameters
    ----------
    rss_w : (d, a, n) float64 — RSS [W] by distance or place, azimuth of the tag, antenna.
    azimuths_rad, element_azimuths_rad : (a,), (n,) float64 — Azimuths of tag and antennas [rad].

    Notes
    -----
    Half-way between two antennas either one counts as right. Where k antennas are equally strong,
    each counts for 1/k, so that a reader which cannot discriminate scores 1/n, not 1. Where
    nothing is received no antenna is right. The rule is the first step of the thesis' navigator,
    (5.2).
    """
    distance = np.abs(wrap_angle(azimuths_rad[:, None] - element_azimuths_rad))
    nearest = distance <= distance.min(axis=1, keepdims=True) + ANGLE_TOLERANCE_RAD
    return float((leaders(rss_w) * nearest).sum(axis=-1).mean())


def vector_sum_bearing_rad(rss_w: FloatArray, element_azimuths_rad: FloatArray) -> FloatArray:
    """Return the bearing of the RSS-weighted vector sum, arg sum_i z_i exp(j delta_i) [rad].

    NaN where the sum vanishes (nothing received, or all antennas equal to within 1e-9).

    Parameters
    ----------
    rss_w : (..., n) float64 — RSS z_i [W].
    element_azimuths_rad : (n,) float64 — Azimuths delta_i of the antennas [rad].
    """
    total = rss_w @ np.exp(1j * element_azimuths_rad)
    bearing = vector_sum_bearing(rss_w, element_azimuths_rad)
    weak = np.abs(total) <= POWER_TIE * rss_w.sum(axis=-1)
    return np.where(weak, np.nan, bearing)


def strongest_errors_rad(
    rss_w: FloatArray, azimuths_rad: FloatArray, element_azimuths_rad: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the bearing errors of the strongest antenna [rad] and the weight of each [-].

    Both (d, a, n + 1): estimate minus truth in (-pi, pi] if antenna i were taken, and the share of
    the decisions that take it; the last column is the error pi of a reader that receives nothing.

    Parameters
    ----------
    rss_w : (d, a, n) float64 — RSS [W] by distance or place, azimuth of the tag, antenna.
    azimuths_rad, element_azimuths_rad : (a,), (n,) float64 — Azimuths of tag and antennas [rad].
    """
    weight = leaders(rss_w)
    nothing = 1.0 - weight.sum(axis=-1, keepdims=True)
    error = wrap_angle(element_azimuths_rad - azimuths_rad[:, None])
    error = np.concatenate([error, np.full((error.shape[0], 1), np.pi)], axis=1)
    weight = np.concatenate([weight, np.round(nothing)], axis=-1)
    return np.broadcast_to(error, weight.shape), weight


def _ratio_db(numerator_w: FloatArray, denominator_w: FloatArray) -> FloatArray:
    """Return a power ratio in dB, capped; 0 dB where both powers are zero."""
    floor = 10.0 ** (-RATIO_CAP_DB / 10.0) * np.maximum(numerator_w, denominator_w)
    floor = np.where(floor > 0.0, floor, 1.0)
    return decibels(np.maximum(numerator_w, floor) / np.maximum(denominator_w, floor))


def facing_ratios_db(
    rss_w: FloatArray, azimuths_rad: FloatArray, element_azimuths_rad: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return front-to-back ratio and margin over the neighbours of antennas facing the tag [dB].

    Both (d, k), for the k azimuths that meet an antenna: its RSS over that of the opposite one (the
    mean of the two opposite ones when n is odd), and over the stronger of its two neighbours,
    within plus and minus 200 dB.

    Parameters
    ----------
    rss_w : (d, a, n) float64 — RSS [W] by distance or place, azimuth of the tag, antenna.
    azimuths_rad : (a,) float64 — Azimuths of the tag in the reader frame [rad]; only those that
        meet an antenna's azimuth are used, and one must.
    element_azimuths_rad : (n,) float64 — Azimuths of the antennas [rad], ascending and evenly
        spaced.
    """
    n = element_azimuths_rad.size
    offset = np.abs(wrap_angle(azimuths_rad[:, None] - element_azimuths_rad))
    sample, antenna = np.nonzero(offset <= ANGLE_TOLERANCE_RAD)
    if sample.size == 0:
        msg = (
            f"none of the {azimuths_rad.size} azimuths meets an antenna's azimuth; "
            "use a grid of azimuths that contains the antennas' own."
        )
        raise AntennaError(msg)
    facing = rss_w[:, sample, antenna]
    back = 0.5 * (
        rss_w[:, sample, (antenna + n // 2) % n] + rss_w[:, sample, (antenna + (n + 1) // 2) % n]
    )
    neighbour = np.maximum(rss_w[:, sample, (antenna + 1) % n], rss_w[:, sample, antenna - 1])
    return _ratio_db(facing, back), _ratio_db(facing, neighbour)


@dataclass(frozen=True, slots=True, kw_only=True)
class SteeringSignal:
    """The navigator's steering signal z2 - z4 while the tag turns from antenna 4 to antenna 2.

    Attributes
    ----------
    deviation_rad : (k,) float64 — Direction of the tag, from the robot's front towards antenna 2,
        ascending [rad].
    difference_w : (d, k) float64 — z2 - z4 by distance or place [W].
    normalised : (d, k) float64 — (z2 - z4)/(z2 + z4) [-]; 0 where neither receives anything.
    """

    deviation_rad: FloatArray
    difference_w: FloatArray
    normalised: FloatArray


def steering_signal(
    rss_w: FloatArray, azimuths_rad: FloatArray, element_azimuths_rad: FloatArray
) -> SteeringSignal:
    """Return z2 - z4 against the tag's deviation from the robot's front [W] and its normalisation.

    Within one antenna spacing on either side of the front, where at least three azimuths must lie.

    Parameters
    ----------
    rss_w : (d, a, n) float64 — RSS [W] by distance or place, azimuth of the tag, antenna.
    azimuths_rad : (a,) float64 — Azimuths of the tag in the reader frame [rad].
    element_azimuths_rad : (n,) float64 — Azimuths of the antennas [rad], ascending and evenly
        spaced.

    Notes
    -----
    Antennas 2 and 4 stand for the neighbours of the front antenna at any number of antennas; the
    five rules of the thesis (section 5.2.2.2) steer by their difference.
    """
    right, left = steering_pair(element_azimuths_rad)
    deviation = wrap_angle(FRONT_AZIMUTH_RAD - azimuths_rad)
    spacing = 2.0 * np.pi / element_azimuths_rad.size
    near = np.nonzero(np.abs(deviation) <= spacing + ANGLE_TOLERANCE_RAD)[0]
    if near.size < 3:
        msg = f"{near.size} azimuths lie beside the robot's front, but at least 3 are needed."
        raise AntennaError(msg)
    near = near[np.argsort(deviation[near])]
    total = rss_w[:, near, right] + rss_w[:, near, left]
    difference = rss_w[:, near, right] - rss_w[:, near, left]
    normalised = np.divide(difference, total, out=np.zeros_like(total), where=total > 0.0)
    return SteeringSignal(
        deviation_rad=deviation[near], difference_w=difference, normalised=normalised
    )
