"""How well the RSS of a reader's antennas tells where a tag is: the scores of one reader design.

:mod:`octant.reader_design.setting.measures` has the quantities that are averaged here,
:mod:`octant.reader_design.setting.samples` obtains the RSS from the radio model.
"""

from dataclasses import asdict

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import AntennaError
from octant.reader_design.setting.bearing_errors import (
    ErrorSummary,
    summarise_errors,
    vector_errors_rad,
)
from octant.reader_design.setting.measures import (
    SteeringSignal,
    facing_ratios_db,
    right_share,
    steering_signal,
    strongest_errors_rad,
)
from octant.reader_design.study_file.scores import Scores

FloatArray = npt.NDArray[np.float64]

USABLE_DBM = -90.0
"""Default threshold of a usable RSS [dBm]: 2 dB above the -92 dBm at which 2.4 GHz IEEE 802.15.4
receivers such as the thesis' MC13193 (section 4.6.1) still decode."""


def _steering_scores(steering: SteeringSignal) -> dict[str, float]:
    """Return the six scores of the steering signal."""
    slope = {}
    angle = steering.deviation_rad
    straight = int(np.abs(angle).argmin())
    low, high = max(straight - 1, 0), min(straight + 1, angle.size - 1)
    for name, signal in (("w", steering.difference_w), ("n", steering.normalised)):
        slope[name] = (signal[:, high] - signal[:, low]) / (angle[high] - angle[low])
    grows = np.diff(steering.difference_w, axis=1) > 0.0
    grows_normalised = np.diff(steering.normalised, axis=1) > 0.0
    return {
        "monotonic_share": float(grows.all(axis=1).mean()),
        "monotonic_normalised_share": float(grows_normalised.all(axis=1).mean()),
        "slope_w_per_rad": float(np.median(slope["w"])),
        "slope_normalised_per_rad": float(np.median(slope["n"])),
        "full_scale_w": float(np.median(np.abs(steering.difference_w).max(axis=1))),
        "full_scale_normalised": float(np.median(np.abs(steering.normalised).max(axis=1))),
    }


def _error_scores(method: str, errors: ErrorSummary) -> dict[str, float]:
    """Return the scores of one way to read off the bearing."""
    return {f"{method}_{name}": value for name, value in asdict(errors).items()}


def _reading_scores(
    readings_w: FloatArray, azimuths_rad: FloatArray, element_azimuths_rad: FloatArray
) -> dict[str, float]:
    """Return the scores of what a receiver reads."""
    strongest = strongest_errors_rad(readings_w, azimuths_rad, element_azimuths_rad)
    vector = summarise_errors(vector_errors_rad(readings_w, azimuths_rad, element_azimuths_rad))
    return {
        "read_right_share": right_share(readings_w, azimuths_rad, element_azimuths_rad),
        "read_strongest_rms_rad": summarise_errors(*strongest).rms_rad,
        "read_vector_median_rad": vector.median_rad,
        "read_vector_rms_rad": vector.rms_rad,
        "read_vector_p90_rad": vector.p90_rad,
        "read_vector_beyond_90_share": vector.beyond_90_share,
    }


def _powers(
    name: str, powers_w: npt.ArrayLike, azimuths_rad: FloatArray, element_azimuths_rad: FloatArray
) -> FloatArray:
    """Return powers by distance or place, azimuth and antenna, checked."""
    shape = (None, azimuths_rad.size, element_azimuths_rad.size)
    powers: FloatArray = frozen_array(powers_w, name=name, shape=shape, error=AntennaError)
    if powers.size == 0 or powers.min() < 0.0:
        least = "nothing" if powers.size == 0 else f"{powers.min():.3g} W"
        msg = f"{name} holds {least} where powers of zero or more are needed; check the samples."
        raise AntennaError(msg)
    return powers


def score_rss(
    rss_w: npt.ArrayLike,
    azimuths_rad: npt.ArrayLike,
    element_azimuths_rad: npt.ArrayLike,
    *,
    usable_dbm: float = USABLE_DBM,
    readings_w: npt.ArrayLike | None = None,
    captured_share: float = 0.0,
) -> Scores:
    """Return all scores of a reader from the RSS of its antennas; angles in [rad], ratios in [dB].

    Parameters
    ----------
    rss_w : (d, a, n) array_like — RSS [W], not negative, by distance or place, azimuth of the tag,
        antenna.
    azimuths_rad : (a,) array_like — Azimuths of the tag in the reader frame [rad]; evenly spaced
        over the circle, containing those of the antennas, if the averages are to mean what they
        say.
    element_azimuths_rad : (n,) array_like — Azimuths of the antennas in the reader frame [rad],
        ascending and evenly spaced.
    usable_dbm : RSS at which a tag is still read [dBm].
    readings_w : (k, a, n) array_like, optional — What a receiver reads of such samples [W], for the
        scores whose names begin with ``read``; default: the RSS itself.
    captured_share : Passed on [-]; see :mod:`octant.reader_design.setting.capture`.

    Notes
    -----
    A direction without a bearing (nothing received, or all antennas equally strong in the vector
    sum) counts with an error of pi. All scores but those in W or dBm and the usable share are
    invariant under a change of the transmitted power.
    """
    elements: FloatArray = frozen_array(
        element_azimuths_rad, name="element_azimuths_rad", shape=(None,), error=AntennaError
    )
    azimuths: FloatArray = frozen_array(
        azimuths_rad, name="azimuths_rad", shape=(None,), error=AntennaError
    )
    rss = _powers("rss_w", rss_w, azimuths, elements)
    strongest = summarise_errors(*strongest_errors_rad(rss, azimuths, elements))
    vector = summarise_errors(vector_errors_rad(rss, azimuths, elements))
    front_to_back, margin = facing_ratios_db(rss, azimuths, elements)
    level = power_dbm(np.maximum(rss.max(axis=-1), 1e-30))
    return Scores(
        right_share=right_share(rss, azimuths, elements),
        **_error_scores("strongest", strongest),
        **_error_scores("vector", vector),
        front_to_back_mean_db=float(front_to_back.mean()),
        front_to_back_worst_db=float(front_to_back.min()),
        margin_mean_db=float(margin.mean()),
        margin_worst_db=float(margin.min()),
        **_steering_scores(steering_signal(rss, azimuths, elements)),
        usable_share=float((level >= usable_dbm).mean()),
        level_median_dbm=float(np.median(level)),
        level_p10_dbm=float(np.quantile(level, 0.1)),
        captured_share=captured_share,
        **_reading_scores(
            rss if readings_w is None else _powers("readings_w", readings_w, azimuths, elements),
            azimuths,
            elements,
        ),
    )
