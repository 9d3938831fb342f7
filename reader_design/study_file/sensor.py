"""The table of a study file that says how the robot's reader measures RSS."""

from typing import Annotated

from msgspec import Meta

from octant.reader_design.study_file.room import NotNegative, Positive, PositiveCount, Table

Probability = Annotated[float, Meta(ge=0.0, le=1.0)]


class Sensor(Table, frozen=True, kw_only=True):
    """How RSS is measured on missions, besides ``mission.noise_db``: table ``[sensor]``.

    Parameters
    ----------
    dwell_s : Time from one antenna's reading to the next one's [s], while the robot drives on; 0:
        all antennas are read at once.
    bandwidth_hz : Noise bandwidth of the receiver [Hz]; None: no thermal noise.
    noise_figure_db : Noise figure of the receiver [dB].
    samples : Independent samples that a reading averages in power.
    required_snr_db : Ratio [dB] of a reading to the thermal noise below which the tag is not
        decoded; None: no ratio is required.
    sensitivity_dbm : Power [dBm] below which nothing is received; None: no limit.
    bits : Length of the detector's code; None: readings are not rounded.
    floor_dbm, full_scale_dbm : Powers of the lowest and of the highest code [dBm].
    drop_out_probability : Probability that one antenna's reading is lost.
    read_probability : Probability that a tag within reach answers at all.
    """

    dwell_s: NotNegative = 0.0
    bandwidth_hz: Positive | None = None
    noise_figure_db: NotNegative = 6.0
    samples: PositiveCount = 1
    required_snr_db: float | None = None
    sensitivity_dbm: float | None = None
    bits: Annotated[int, Meta(ge=1, le=16)] | None = None
    floor_dbm: float = -100.0
    full_scale_dbm: float = 0.0
    drop_out_probability: Probability = 0.0
    read_probability: Probability = 1.0
