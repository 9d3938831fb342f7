"""How far one response of a reader is from another: levels, patterns, and the antenna they name."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.decibels import decibels
from octant.geometries.errors import AntennaError

STRONG_DB = 10.0
"""Directions within this of an antenna's greatest gain are its strong ones [dB]."""

WEAK_DB = 20.0
"""Directions from `STRONG_DB` down to this below the greatest gain are its weak ones [dB]."""

FLOOR_DB = 40.0
"""Gains lower than this below an antenna's greatest one count as that low [dB]."""

TIE = 1e-6
"""Antennas whose gains differ by less than this relative amount are equally strong [-]."""

AZIMUTHS = 360
"""Azimuths at which the strongest antennas are compared [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ResponseDifference:
    """How far a response is from the one that is taken as true.

    Parameters
    ----------
    model, offset_db : The judged model; its mean gain over the true one, strong directions [dB].
    strong_rms_db, weak_rms_db, faint_rms_db : Rms difference of gain in the strong directions, the
        offset taken out, in the weak and in the still fainter ones, NaN where there are none [dB].
    other_antenna_share : Share of azimuths where it names another antenna as the strongest [-].
    """

    model: str
    offset_db: float
    strong_rms_db: float
    weak_rms_db: float
    faint_rms_db: float
    other_antenna_share: float


def compare_responses(
    truth: ReaderResponse, other: ReaderResponse, theta_rad: Sequence[float]
) -> ResponseDifference:
    """Return how far a response is from a true one, in [dB] and as a share of azimuths.

    Gains are of both polarisations, over the hemisphere above the ground plane, weighted by solid
    angle. The strongest antenna is that of the theta polarisation, which vertical tags send; of k
    equally strong ones each counts for 1/k.

    Parameters
    ----------
    truth, other : What is taken as true, and what is judged, on any grid; as many antennas each.
    theta_rad : Angles from the vertical under which tags are seen [rad], for the strongest antenna.
    """
    if truth.antennas != other.antennas:
        msg = (
            f"the responses have {truth.antennas} and {other.antennas} antennas, but only readers "
            "with the same number can be compared."
        )
        raise AntennaError(msg)
    strong, weak, faint, weight = _gain_differences_db(truth, other)
    offset = float(np.nansum(weight * strong) / np.sum(weight[np.isfinite(strong)]))
    theta = np.asarray(theta_rad, dtype=np.float64)[:, None]
    phi = np.linspace(0.0, 2.0 * np.pi, AZIMUTHS, endpoint=False)
    same = np.sum(_leaders(truth, theta, phi) * _leaders(other, theta, phi), axis=0)
    return ResponseDifference(
        model=other.model,
        offset_db=offset,
        strong_rms_db=_rms(strong - offset, weight),
        weak_rms_db=_rms(weak - offset, weight),
        faint_rms_db=_rms(faint - offset, weight),
        other_antenna_share=float(1.0 - same.mean()),
    )


def _gain_differences_db(
    truth: ReaderResponse, other: ReaderResponse
) -> tuple[npt.NDArray[np.float64], ...]:
    """Return (n, t, P) differences of strong, weak and faint directions (else NaN), and weights."""
    above = truth.theta_rad <= 0.5 * np.pi + 1e-9
    theta, phi = truth.theta_rad[above][:, None], truth.phi_rad
    gain = np.sum(np.abs(truth.far_field(theta, phi)) ** 2, axis=-1)
    judged = np.sum(np.abs(other.far_field(theta, phi)) ** 2, axis=-1)
    peak = gain.max(axis=(1, 2), keepdims=True)
    floor = peak * 10.0 ** (-FLOOR_DB / 10.0)
    level = decibels(np.maximum(gain, floor) / peak)
    difference = decibels(np.maximum(judged, floor) / np.maximum(gain, floor))
    strong = np.where(level >= -STRONG_DB, difference, np.nan)
    weak = np.where((level < -STRONG_DB) & (level >= -WEAK_DB), difference, np.nan)
    faint = np.where(level < -WEAK_DB, difference, np.nan)
    weight = np.broadcast_to(np.sin(theta), gain.shape)
    return strong, weak, faint, weight


def _rms(value: npt.NDArray[np.float64], weight: npt.NDArray[np.float64]) -> float:
    known = np.isfinite(value)
    if not known.any():
        return float("nan")
    return float(np.sqrt(np.average(value[known] ** 2, weights=weight[known])))


def _leaders(
    response: ReaderResponse, theta: npt.NDArray[np.float64], phi: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Return (n, ...) each antenna's weight as the strongest one for vertical tags."""
    gain = np.abs(response.far_field(theta, phi)[..., 0]) ** 2
    lead = gain >= gain.max(axis=0) * (1.0 - TIE)
    weight: npt.NDArray[np.float64] = lead / lead.sum(axis=0)
    return weight
