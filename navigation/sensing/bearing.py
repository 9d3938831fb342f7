"""Bearing of the tag from the reader's RSS, and the turn towards it.

Reader azimuths δ are measured in the reader frame x'y', whose +y' (90°) is the robot's front, room
azimuths from +x towards +y. A robot of heading h has antenna i at the room azimuth h - 90° + δ_i.
"""

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle

FRONT_AZIMUTH_RAD = np.pi / 2.0
"""Reader azimuth of the robot's front [rad]: +y', where antenna 3 of eight stands."""

ANY_DIRECTION_RAD2 = np.pi**2 / 3.0
"""Variance of a direction that may be any [rad²]."""

_SAME_DIRECTION_RAD = 1e-6


def room_azimuth(
    heading_rad: npt.ArrayLike, reader_azimuth_rad: npt.ArrayLike
) -> npt.NDArray[np.float64]:
    """Return the room azimuth h - π/2 + δ of a direction in the reader frame, in (-π, π] [rad].

    Parameters
    ----------
    heading_rad : (...) float64 — Robot's heading h in the room [rad].
    reader_azimuth_rad : (...) float64 — Azimuth δ in the reader frame [rad].
    """
    heading = np.asarray(heading_rad, dtype=np.float64)
    return wrap_angle(heading - FRONT_AZIMUTH_RAD + np.asarray(reader_azimuth_rad))


def reader_azimuth(
    heading_rad: npt.ArrayLike, room_azimuth_rad: npt.ArrayLike
) -> npt.NDArray[np.float64]:
    """Return the reader azimuth φ - h + π/2 of a direction in the room, in (-π, π] [rad].

    Parameters
    ----------
    heading_rad : (...) float64 — Robot's heading h in the room [rad].
    room_azimuth_rad : (...) float64 — Azimuth φ in the room [rad].
    """
    heading = np.asarray(heading_rad, dtype=np.float64)
    return wrap_angle(np.asarray(room_azimuth_rad) - heading + FRONT_AZIMUTH_RAD)


def checked_azimuths(azimuths_rad: npt.ArrayLike, *, least: int = 3) -> npt.NDArray[np.float64]:
    """Return the antennas' azimuths read-only, enough of them and all different (n,) [rad].

    Parameters
    ----------
    azimuths_rad : (n,) float64 — Azimuths δ_i of the antennas in the reader frame [rad].
    least : Number of antennas at least: three for a bearing from one reading.
    """
    azimuths = frozen_array(azimuths_rad, name="azimuths_rad", shape=(None,), error=NavigationError)
    if azimuths.size < least:
        what = "a bearing needs" if least > 1 else "it needs"
        msg = f"the reader has {azimuths.size} antennas, but {what} at least {least}: add some."
        raise NavigationError(msg)
    turns = np.sort(np.mod(azimuths, 2.0 * np.pi))
    gaps = np.diff(np.append(turns, turns[0] + 2.0 * np.pi))
    if gaps.min() < _SAME_DIRECTION_RAD:
        msg = (
            f"two antennas stand at the same azimuth among {np.degrees(azimuths).tolist()} deg, "
            "but each needs its own direction: move one."
        )
        raise NavigationError(msg)
    return azimuths


def steering_pair(azimuths_rad: npt.ArrayLike) -> tuple[int, int]:
    """Return the indices of the two antennas whose difference steers: right one, left one.

    Those nearest to the front, clockwise and counter-clockwise, one exactly in front left out:
    antennas 2 and 4 of eight (indices 1 and 3). For every even number of evenly spaced antennas
    equal RSS means "straight ahead". For an odd number it keeps the tag 90°/n off the front (30°
    for 3, 18° for 5), and the robot reaches it on a spiral; the vector sum has no such offset.

    Parameters
    ----------
    azimuths_rad : (n,) float64 — Azimuths of the antennas in the reader frame [rad].
    """
    away = wrap_angle(np.asarray(azimuths_rad, dtype=np.float64) - FRONT_AZIMUTH_RAD)
    right = np.where(away < -_SAME_DIRECTION_RAD, -away, np.inf)
    left = np.where(away > _SAME_DIRECTION_RAD, away, np.inf)
    if not (np.isfinite(right).any() and np.isfinite(left).any()):
        msg = (
            f"the antennas at {np.degrees(azimuths_rad).tolist()} deg stand on one side of the "
            "front (90 deg) only, but steering needs one on each: spread them."
        )
        raise NavigationError(msg)
    return int(np.argmin(right)), int(np.argmin(left))


def doct(rss_w: npt.ArrayLike, azimuths_rad: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return the direction of the current tag, thesis (5.2): the strongest antenna's azimuth [rad].

    The first one of equals; NaN where nothing is received. Resolution is the antennas' spacing.

    Parameters
    ----------
    rss_w, azimuths_rad : As for `vector_sum_bearing` [W], [rad].
    """
    rss = np.asarray(rss_w, dtype=np.float64)
    azimuths = np.asarray(azimuths_rad, dtype=np.float64)
    strongest = azimuths[np.argmax(rss, axis=-1)]
    return np.asarray(np.where(rss.max(axis=-1) > 0.0, strongest, np.nan))


def vector_sum_bearing(
    rss_w: npt.ArrayLike, azimuths_rad: npt.ArrayLike
) -> npt.NDArray[np.float64]:
    """Return the bearing atan2(Σ z_i sin δ_i, Σ z_i cos δ_i), reader frame, in (-π, π] [rad].

    NaN where no antenna receives anything. Equal RSS on a full circle gives a direction of
    rounding. Not in the thesis; it names only "the differences between the RSS values of various
    antenna combinations". Unbiased for a single path when all antennas have the same pattern about
    their own azimuth and its harmonics of order n ± 1 are small.

    Parameters
    ----------
    rss_w : (..., n) float64 — RSS z_i of the antennas [W], not negative.
    azimuths_rad : (n,) float64 — Azimuths δ_i of the antennas in the reader frame [rad].
    """
    rss = np.asarray(rss_w, dtype=np.float64)
    azimuths = np.asarray(azimuths_rad, dtype=np.float64)
    bearing = np.arctan2(rss @ np.sin(azimuths), rss @ np.cos(azimuths))
    return np.asarray(np.where(rss.max(axis=-1) > 0.0, bearing, np.nan))


def vector_sum_variance(
    rss_w: npt.ArrayLike, azimuths_rad: npt.ArrayLike, *, noise_db: float
) -> npt.NDArray[np.float64]:
    """Return the variance of the vector sum's bearing under noise of the readings [rad²].

    To first order Σ (z_i sin(δ_i - γ) / R)² s², with the sum's length R and direction γ and s =
    noise_db ln(10)/10; π²/3, that of any direction, at most and without signal. No reflections.

    Parameters
    ----------
    rss_w, azimuths_rad : As for `vector_sum_bearing` [W], [rad].
    noise_db : Standard deviation of the independent log-normal error of each RSS [dB].
    """
    rss = np.asarray(rss_w, dtype=np.float64)
    azimuths = np.asarray(azimuths_rad, dtype=np.float64)
    along, across = rss @ np.cos(azimuths), rss @ np.sin(azimuths)
    length2 = along**2 + across**2
    sine = along[..., None] * np.sin(azimuths) - across[..., None] * np.cos(azimuths)
    moment = np.sum((rss * sine) ** 2, axis=-1)
    noise2 = (noise_db * np.log(10.0) / 10.0) ** 2
    some = length2 > 0.0
    variance = noise2 * moment / np.where(some, length2, 1.0) ** 2
    return np.asarray(np.where(some, np.minimum(variance, ANY_DIRECTION_RAD2), ANY_DIRECTION_RAD2))


def turn_towards(bearing_rad: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return the shorter turn wrap(γ - 90°) to the robot's front, counter-clockwise positive [rad].

    Thesis Algorithm 1, corrected: its second `if` should be `else if`. As printed, for γ - 90°
    above 180° (antenna 8, γ = 315°) both branches turn, and the robot ends up at -270° instead of
    -135° while its stored heading counts one turn only.

    Parameters
    ----------
    bearing_rad : (...) float64 — Bearing γ in the reader frame [rad].
    """
    return wrap_angle(np.asarray(bearing_rad, dtype=np.float64) - FRONT_AZIMUTH_RAD)
