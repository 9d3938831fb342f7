"""Antennas by name: a kind with a closed-form pattern, or a pattern file."""

import math
from collections.abc import Sequence
from pathlib import Path

from octant.em.antennas.from_files import antenna_from_pattern_file
from octant.em.antennas.kinds import Antenna, make_antenna
from octant.geometries.errors import ConfigError
from octant.reader_design.study_file.checks import TAG_ANTENNAS, unknown_antenna


def named_antenna(
    name: str,
    frequency_hz: float,
    *,
    key: str,
    axis: Sequence[float] | None = None,
    azimuth_deg: float = 0.0,
    length_m: float | None = None,
) -> Antenna:
    """Return the antenna that a study file or the command line names, in the room's frame.

    Parameters
    ----------
    name : A kind of `octant.em.antennas.kinds.AntennaKind`, or the path of a pattern file.
    frequency_hz : Frequency [Hz].
    key : Where it is named, for messages.
    axis : (3,) sequence of float, optional — Its direction in the room [-]; by default up, patches
        down.
    azimuth_deg : Turn about the axis [deg].
    length_m : Length, or diameter of a conical patch [m]; by default resonant. Files have none.
    """
    azimuth_rad = math.radians(azimuth_deg)
    if name in TAG_ANTENNAS:
        return make_antenna(
            name, frequency_hz, length_m=length_m, axis=axis, azimuth_rad=azimuth_rad
        )
    if not Path(name).is_file():
        raise ConfigError(unknown_antenna(key, name))
    return antenna_from_pattern_file(
        name,
        frequency_hz=frequency_hz,
        axis=(0.0, 0.0, 1.0) if axis is None else axis,
        azimuth_rad=azimuth_rad,
    )
