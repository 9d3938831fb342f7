"""What a study's receiver reads of the powers that arrive: the table ``[sensor]``, pose by pose."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.reader_design.setting.receiver import study_sensor
from octant.reader_design.study_file.schema import Study

FloatArray = npt.NDArray[np.float64]

READINGS_STREAM = 5_107
"""Keeps these readings' random numbers apart from those of other parts with the same seed [-]."""


@dataclass(frozen=True, slots=True)
class KnownPower:
    """A link whose power is known already, at one pose.

    Parameters
    ----------
    power_w : (n,) float64 — RSS of the antennas [W].
    """

    power_w: FloatArray

    def rss_w(self, poses: npt.ArrayLike) -> FloatArray:
        """Return the power at each of (k, 3) poses, (k, n) [W]."""
        return np.tile(self.power_w, (len(np.asarray(poses)), 1))


def study_noise_db(study: Study) -> float:
    """Return the noise of each reading: that of the mission, or of docking, or none [dB].

    Parameters
    ----------
    study : The study.
    """
    tables = (study.mission, study.dock)
    return next((table.noise_db for table in tables if table is not None), 0.0)


def readings_w(
    study: Study,
    rss_w: FloatArray,
    azimuths_rad: FloatArray,
    rng: np.random.Generator,
    *,
    readings: int,
    noise_db: float,
) -> FloatArray:
    """Return what the study's receiver reads of RSS, (k, readings, n) [W]; zero: nothing.

    The robot stands, so that a dwell time changes nothing; the tag is asked for alone, so that none
    collide.

    Parameters
    ----------
    study : The table ``[sensor]``.
    rss_w : (k, n) float64 — RSS by pose and antenna [W].
    azimuths_rad : (n,) float64 — Azimuths of the antennas [rad].
    rng : Source of the errors.
    readings : Number of readings at each pose.
    noise_db : Standard deviation of the log-normal error [dB].
    """
    still, tag = np.zeros(3), "tag"
    sensors = (
        study_sensor(study.sensor, {tag: KnownPower(row)}, azimuths_rad, noise_db=noise_db)
        for row in rss_w
    )
    read = [[sensor.read(still, tag, rng) for _ in range(readings)] for sensor in sensors]
    return np.array(read).reshape(len(rss_w), readings, rss_w.shape[1])
