"""The sensor of a study's missions: how its reader measures what the links deliver."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from octant.navigation.sensing.rss_detector import RssQuantiser, ThermalNoise
from octant.navigation.sensing.sensor import FieldSensor, PowerLink
from octant.reader_design.study_file.sensor import Sensor


def study_sensor(
    table: Sensor,
    links: Mapping[str, PowerLink],
    azimuths_rad: npt.NDArray[np.float64],
    *,
    noise_db: float,
) -> FieldSensor:
    """Return the sensor that a study's table ``[sensor]`` describes.

    Parameters
    ----------
    table : Sensor
        The table [s], [Hz], [dB], [dBm].
    links : mapping of str to PowerLink
        Link of each tag that the robot may ask for.
    azimuths_rad : (n,) float64
        Azimuths of the reader's antennas [rad].
    noise_db : float
        Standard deviation of the log-normal error [dB]: the mission's.

    Returns
    -------
    FieldSensor
        For `octant.navigation.missions.run.run_missions`.
    """
    thermal, quantiser, limits_w = None, None, [0.0]
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
    if table.bits is not None:
        quantiser = RssQuantiser(
            bits=table.bits, floor_dbm=table.floor_dbm, full_scale_dbm=table.full_scale_dbm
        )
    return FieldSensor(
        links=links,
        azimuths_rad=azimuths_rad,
        noise_db=noise_db,
        sensitivity_w=max(limits_w),
        quantiser=quantiser,
        dwell_s=table.dwell_s,
        thermal=thermal,
        drop_out_probability=table.drop_out_probability,
        read_probability=table.read_probability,
    )
