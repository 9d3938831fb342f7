"""The tables ``[scoring]`` and ``[choice]`` of a study: how designs are judged and compared."""

from typing import Annotated

import msgspec
from msgspec import Meta

from octant.reader_design.study_file.quantities import (
    Count,
    Deviation,
    Level,
    NotNegative,
    Part,
    Share,
)
from octant.reader_design.study_file.room import Table


class Scoring(Table, frozen=True, kw_only=True):
    """The receiver whose readings are scored beside the exact RSS: table ``[scoring]``.

    Parameters
    ----------
    noise_db : Standard deviation of the error of each RSS reading [dB].
    thermal_noise_dbm : Power of the receiver's noise [dBm]; the default is that of 2 MHz at 290 K,
        -111 dBm, with a noise figure of 11 dB.
    bits : Length of the code of an RSS reading [bit], as in the thesis' tags; 0: it is exact.
    floor_dbm, full_scale_dbm : Powers of the lowest and of the highest code [dBm].
    draws : Readings of every sample.
    """

    noise_db: Deviation = 1.0
    thermal_noise_dbm: Level = -100.0
    bits: Annotated[int, Meta(ge=0, le=16)] = 8
    floor_dbm: Level = -100.0
    full_scale_dbm: Level = 0.0
    draws: Count = 4


class Criterion(Table, frozen=True, kw_only=True):
    """One criterion of the choice: ``[[choice.criterion]]``.

    Parameters
    ----------
    free, room : Names of the scores that count in free space and in the room; empty: none there.
        Where both count it is their mean, of bearing errors their root mean square; a study without
        a room takes that of free space.
    tolerance : Designs that stay behind the best by no more than this count as equal, in the
        score's unit [dB, rad or -].
    relative : Whether the tolerance is a fraction of the best instead.
    """

    free: str = ""
    room: str = ""
    tolerance: NotNegative = 0.0
    relative: bool = False


CRITERIA = (
    Criterion(free="right_share", room="right_share", tolerance=0.02),
    Criterion(free="vector_rms_rad", room="vector_rms_rad", tolerance=0.05, relative=True),
    Criterion(free="margin_worst_db", room="margin_mean_db", tolerance=0.5),
    Criterion(free="level_median_dbm", room="level_median_dbm"),
)
"""The criteria of a study that names none, in order of weight."""


class Choice(Table, frozen=True, kw_only=True):
    """The rules of the choice: table ``[choice]``.

    Parameters
    ----------
    least_usable_share : A design whose strongest antenna is usable in a smaller share of samples,
        in free space or in the room, ranks below all others.
    greatest_width_m, greatest_height_m : A reader that is wider, or taller above its ground plane,
        ranks last [m]; None: any.
    criteria : The tables ``[[choice.criterion]]``, in order of weight.
    shortlist : Designs that the report's short list shows.
    missions : Designs, best first, with which the missions are driven; the first is the chosen one.
    by_missions : Whether these designs are ranked anew by how many of their runs, all rooms
        together, reached every tag; of as many the better scores decide.

    Notes
    -----
    The order of the default criteria follows the use: the navigator takes the strongest antenna
    for the tag's direction (thesis (5.2)), so a wrong one sends the robot astray; then counts how
    well all antennas together give the bearing, then how much noise the decision of a facing
    antenna stands, and at last the level, which matters less because the tag's power can be raised.
    The tolerances keep sampling noise and the error of the models (about 0.5 dB at best) from
    deciding. In a room the worst margin is a fading dip at a single place and says nothing about
    the design, so the mean stands for it; in free space the worst one does.
    """

    least_usable_share: Share = 0.95
    greatest_width_m: Part | None = None
    greatest_height_m: Part | None = None
    criteria: Annotated[tuple[Criterion, ...], Meta(min_length=1)] = msgspec.field(
        default=CRITERIA, name="criterion"
    )
    shortlist: Count = 5
    missions: Count = 1
    by_missions: bool = False
