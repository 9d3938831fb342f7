"""The table of a study file that says how the robot's reader measures RSS."""

from typing import Annotated

from msgspec import Meta

from octant.reader_design.study_file.quantities import (
    Bandwidth,
    Count,
    Deviation,
    Level,
    PeriodOrZero,
    Ratio,
    Share,
)
from octant.reader_design.study_file.room import Table


class Sensor(Table, frozen=True, kw_only=True):
    """How RSS is measured on missions, docking and tracking: table ``[sensor]``.

    Besides ``noise_db`` of ``[mission]`` and ``[dock]``, and the noises of ``[track]``, whose
    chapters ``feedback``, ``long`` and ``stabilisation`` do not take this table; its chapter
    ``reader`` reads with all antennas, the others with one. `octant rss --readings` gives such
    readings; `octant map` and `octant rss` without them give the power that arrives. Scores read by
    the table ``[scoring]``.

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

    dwell_s: PeriodOrZero = 0.0
    bandwidth_hz: Bandwidth | None = None
    noise_figure_db: Deviation = 6.0
    samples: Count = 1
    required_snr_db: Ratio | None = None
    sensitivity_dbm: Level | None = None
    bits: Annotated[int, Meta(ge=1, le=16)] | None = None
    floor_dbm: Level = -100.0
    full_scale_dbm: Level = 0.0
    drop_out_probability: Share = 0.0
    read_probability: Share = 1.0
