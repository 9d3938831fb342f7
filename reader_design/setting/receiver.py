"""The device that measures the RSS: as the scores see it, and as a robot carries it."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.navigation.sensing.device import Device, TagReceiver
from octant.navigation.sensing.rss_detector import RssQuantiser, ThermalNoise, log_normal_rss
from octant.navigation.sensing.sensor import FieldSensor, PowerLink
from octant.reader_design.setting.inventory import Inventory
from octant.reader_design.study_file.choice import Scoring
from octant.reader_design.study_file.schema import Study
from octant.reader_design.study_file.sensor import Sensor

FloatArray = npt.NDArray[np.float64]

SCORING_STREAM = 5_103
"""Keeps the random numbers of the scores apart from those of other parts with the same seed [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RssReceiver:
    """A receiver of RSS: thermal noise is added, a log-normal error multiplies, codes round.

    Attributes
    ----------
    noise_db : Standard deviation of the error of each reading [dB].
    thermal_noise_w : Power of the receiver's own noise [W], which adds to that of the signal.
    quantiser : Codes in which the reading comes; None: it is exact.
    """

    noise_db: float = 0.0
    thermal_noise_w: float = 0.0
    quantiser: RssQuantiser | None = None

    def __post_init__(self) -> None:
        for name, unit in (("noise_db", "dB"), ("thermal_noise_w", "W")):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                msg = f"{name} is {value} {unit}, but it must be finite and not negative; raise it."
                raise ConfigError(msg)

    def read(self, rss_w: npt.ArrayLike, rng: np.random.Generator) -> FloatArray:
        """Return a reading of each RSS [W]: (RSS + thermal noise) 10^(N(0, noise_db)/10), coded.

        Parameters
        ----------
        rss_w : (...) array_like — Received powers [W].
        rng : Source of the errors; nothing is drawn without ``noise_db``.

        Notes
        -----
        A detector averages over many noise periods, so the noise's power adds as its mean; what
        fluctuation is left is part of ``noise_db``. It is the same noise at all antennas and so
        pulls the vector sum to no side, but drowns what tells the antennas apart.
        """
        noisy = log_normal_rss(np.asarray(rss_w) + self.thermal_noise_w, self.noise_db, rng)
        return noisy if self.quantiser is None else self.quantiser.quantise(noisy)

    def readings(self, rss_w: FloatArray, rng: np.random.Generator, *, draws: int) -> FloatArray:
        """Return (draws d, a, n) independent readings of samples, one draw after another [W].

        Parameters
        ----------
        rss_w : (d, a, n) float64 — Received powers [W] by distance or place, azimuth, antenna.
        rng : Source of the errors.
        draws : Readings of each; one is enough without ``noise_db``, and then one is made.
        """
        count = draws if self.noise_db > 0.0 else 1
        return np.concatenate([self.read(rss_w, rng) for _ in range(count)])


def quantiser_of(table: Scoring | Sensor) -> RssQuantiser | None:
    """Return the codes in which RSS readings come; None where the table gives no bits.

    Parameters
    ----------
    table : Table ``[scoring]`` or ``[sensor]``; its levels are in [dBm].
    """
    if not table.bits:
        return None
    return RssQuantiser(
        bits=table.bits, floor_dbm=table.floor_dbm, full_scale_dbm=table.full_scale_dbm
    )


def receiver_of(table: Scoring) -> RssReceiver:
    """Return the receiver that a study's table ``[scoring]`` describes [W], [dB].

    Parameters
    ----------
    table : The table; its levels are in [dBm].
    """
    return RssReceiver(
        noise_db=table.noise_db,
        thermal_noise_w=10.0 ** ((table.thermal_noise_dbm - 30.0) / 10.0),
        quantiser=quantiser_of(table),
    )


def scoring_readings_w(study: Study, rss_w: FloatArray) -> FloatArray:
    """Return the (k, a, n) readings by the study's receiver of samples [W]; k is a multiple of d.

    The errors depend on the seed and on the shape only: all designs meet the same ones, which takes
    their luck out of the comparison.

    Parameters
    ----------
    study : Table ``[scoring]`` and seed.
    rss_w : (d, a, n) float64 — Received powers [W] by distance or place, azimuth, antenna.
    """
    rng = np.random.default_rng((study.seed, SCORING_STREAM))
    return receiver_of(study.scoring).readings(rss_w, rng, draws=study.scoring.draws)


def study_device(table: Sensor, *, noise_db: float) -> Device:
    """Return what the receiver of a study's table ``[sensor]`` makes of power.

    Parameters
    ----------
    table : The table [Hz], [dB], [dBm].
    noise_db : Standard deviation of the log-normal error [dB].
    """
    thermal, limits_w = None, [0.0]
    if table.sensitivity_dbm is not None:
        limits_w.append(10.0 ** ((table.sensitivity_dbm - 30.0) / 10.0))
    if table.bandwidth_hz is not None:
        thermal = ThermalNoise(
            bandwidth_hz=table.bandwidth_hz,
            noise_figure_db=table.noise_figure_db,
            samples=table.samples,
        )
        if table.required_snr_db is not None:
            limits_w.append(thermal.power_w * 10.0 ** (table.required_snr_db / 10.0))
    return Device(
        noise_db=noise_db,
        sensitivity_w=max(limits_w),
        quantiser=quantiser_of(table),
        thermal=thermal,
    )


def study_tag_receiver(table: Sensor) -> TagReceiver | None:
    """Return the receiver of tracking, one antenna and many tags; None for a perfect one.

    Parameters
    ----------
    table : The table ``[sensor]`` [Hz], [dB], [dBm]; its errors come after those of the channel.
    """
    if table == Sensor():
        return None
    kept = (1.0 - table.drop_out_probability) * table.read_probability
    return TagReceiver(device=study_device(table, noise_db=0.0), lost_probability=1.0 - kept)


def study_sensor(
    table: Sensor,
    links: Mapping[str, PowerLink],
    azimuths_rad: npt.NDArray[np.float64],
    *,
    noise_db: float,
    inventory: Inventory | None = None,
) -> FieldSensor:
    """Return the sensor that a study's table ``[sensor]`` describes.

    Parameters
    ----------
    table : The table [s], [Hz], [dB], [dBm].
    links : Link of each tag that the robot may ask for.
    azimuths_rad : (n,) float64 — Azimuths of the reader's antennas [rad].
    noise_db : Standard deviation of the log-normal error [dB]: the mission's.
    inventory : How tags that the reader wakes answer together; None: none do.
    """
    device = study_device(table, noise_db=noise_db)
    return FieldSensor(
        links=links,
        azimuths_rad=azimuths_rad,
        noise_db=device.noise_db,
        sensitivity_w=device.sensitivity_w,
        quantiser=device.quantiser,
        thermal=device.thermal,
        dwell_s=table.dwell_s if inventory is None else inventory.dwell_s,
        drop_out_probability=table.drop_out_probability,
        read_probability=table.read_probability,
        crowd={} if inventory is None else inventory.crowd,
        rates=None if inventory is None else inventory.rates,
    )
