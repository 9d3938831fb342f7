"""A tag or an end of a path given by a pattern file."""

from pathlib import Path

import numpy.typing as npt

from octant.em.antennas.kinds import Antenna
from octant.em.reader.pattern_files import reader_from_pattern_files


def antenna_from_pattern_file(
    path: str | Path,
    *,
    frequency_hz: float,
    axis: npt.ArrayLike = (0.0, 0.0, 1.0),
    azimuth_rad: float = 0.0,
) -> Antenna:
    """Return the antenna of a pattern file, put into the room's frame.

    Parameters
    ----------
    path : str or Path
        FEKO .ffe, HFSS .ffd, CST .ffs, NEC output, MSI/Planet or CSV, over the full sphere.
    frequency_hz : float
        Frequency [Hz]: a table within 0.1 %, or two tables at most 5 % apart around it.
    axis : (3,) float
        Where the file's z axis points in the room [-].
    azimuth_rad : float
        Turn of the file's x axis about it [rad], see `octant.em.antennas.kinds.Antenna`.

    Returns
    -------
    Antenna
        Of kind ``pattern``, |F|^2 = gain of the kind that the file holds (realised gain into 50 ohm
        where it tells the impedance), phase referred to the origin that the file names.

    Raises
    ------
    PatternFileError
        When the file is malformed, leaves directions open, or misses the frequency.
    AntennaError
        When the axis has no direction.

    Warns
    -----
    PhysicsWarning
        When the file holds no phase, is not realised gain, or radiates more than it takes in.
    """
    table = reader_from_pattern_files([path], azimuths_rad=[0.0], frequency_hz=frequency_hz)
    return Antenna(
        kind="pattern",
        length_m=0.0,
        frequency_hz=frequency_hz,
        axis=axis,  # type: ignore[arg-type]  # checked and frozen there
        azimuth_rad=azimuth_rad,
        pattern=table.pattern[0],
    )
