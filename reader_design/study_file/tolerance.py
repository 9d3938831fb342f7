"""The table ``[tolerance]`` of a study: how exactly readers are made, and what they must reach."""

from typing import Annotated, Literal

from msgspec import Meta, field

from octant.reader_design.study_file.quantities import (
    AngleDeviation,
    Count,
    Distance,
    Level,
    Load,
    Name,
    Part,
    PartOrZero,
    Percent,
    Ratio,
    Share,
)
from octant.reader_design.study_file.room import Table


class CommonTolerance(Table, frozen=True, kw_only=True):
    """What all antennas or plates of one reader share, as from a wrong jig: ``[tolerance.common]``.

    Parameters
    ----------
    antenna_radius_m, plate_height_m : Errors of r_a and h_p [m].
    gap_m, antenna_length_m : Errors of the gap and of the antennas' length [m].
    """

    antenna_radius_m: PartOrZero = 0.0005
    gap_m: PartOrZero = 0.0005
    antenna_length_m: PartOrZero = 0.0005
    plate_height_m: PartOrZero = 0.0005


class Limits(Table, frozen=True, kw_only=True):
    """What a built reader must reach to count as good: ``[tolerance.limits]``, in free space.

    Parameters
    ----------
    least_right_share : Share of directions whose strongest antenna is the nearest [-].
    least_margin_db : Worst margin of the facing antenna over its neighbours [dB].
    most_vector_rms_deg : RMS bearing error of the vector sum [deg].
    least_front_to_back_db : Mean front-to-back ratio [dB].
    least_level_dbm : Mean level of the strongest antenna at every distance [dBm].
    """

    least_right_share: Share | None = 1.0
    least_margin_db: Ratio | None = None
    most_vector_rms_deg: AngleDeviation | None = None
    least_front_to_back_db: Ratio | None = None
    least_level_dbm: Level | None = None


class Rival(Table, frozen=True, kw_only=True):
    """Another design, built with the same errors, to compare with: ``[[tolerance.rival]]``.

    Parameters
    ----------
    name : Name in the results.
    antenna : ``dipole`` or ``monopole``. None here and below: as the study's reader.
    antenna_radius_m, plate_height_m, plate_height_axis_m, plate_outer_radius_m : As in ``[reader]``
        [m].
    ground_plane_m, gap_m, antenna_length_m, monopole_plane_m : As in ``[reader]`` [m].
    load_ohm : As in ``[reader]`` [ohm].
    ground_plane_shape : ``square``, ``round`` or ``octagon``.
    """

    name: Name
    antenna: Literal["dipole", "monopole"] | None = None
    antenna_radius_m: Part | None = None
    plate_height_m: PartOrZero | None = None
    plate_height_axis_m: PartOrZero | None = None
    plate_outer_radius_m: Part | None = None
    ground_plane_m: Part | None = None
    ground_plane_shape: Literal["square", "round", "octagon"] | None = None
    gap_m: Part | None = None
    antenna_length_m: Part | None = None
    monopole_plane_m: PartOrZero | None = None
    load_ohm: Load | None = None


class Tolerance(Table, frozen=True, kw_only=True):
    """How exactly readers are made: table ``[tolerance]``.

    Parameters
    ----------
    samples : Readers built.
    distribution : ``uniform``: errors lie evenly within plus and minus the values below;
        ``normal``: these are standard deviations.
    position_m : Place of each antenna's foot, away from the axis and sideways [m].
    angle_deg : Lean of each antenna, away from the axis and sideways, and azimuth of each plate
        [deg].
    gap_m, antenna_length_m : Height of each antenna's lower end, and its length [m].
    plate_height_m : Height of each plate at its outer end [m].
    ground_plane_m : Side or diameter of the ground plane [m].
    frequency_percent : Frequency of the radio [%].
    permittivity_percent, conductivity_percent : Relative permittivity less one, and conductivity,
        of all materials of the room [%]; only where the room is scored.
    slopes : How the slopes around the drawing are found: by ``differences`` of readers that are
        solved, four for each kind of error, or by ``derivatives`` of the drawing's solution; these
        also give a linear estimate of the spreads.
    room : Whether to score in the study's room, too.
    distances_m : Horizontal distances from the tag in free space [m].
    common : Errors that all antennas share, besides.
    limits : What counts as good.
    rivals : The tables ``[[tolerance.rival]]``.
    """

    samples: Count = 64
    distribution: Literal["uniform", "normal"] = "uniform"
    position_m: PartOrZero = 0.001
    angle_deg: Annotated[float, Meta(ge=0.0, le=90.0)] = 2.0
    gap_m: PartOrZero = 0.001
    antenna_length_m: PartOrZero = 0.001
    plate_height_m: PartOrZero = 0.001
    ground_plane_m: PartOrZero = 0.001
    frequency_percent: Percent = 0.0
    permittivity_percent: Percent = 0.0
    conductivity_percent: Percent = 0.0
    slopes: Literal["differences", "derivatives"] = "differences"
    room: bool = False
    distances_m: Annotated[tuple[Distance, ...], Meta(min_length=1, max_length=1000)] = (
        1.0,
        2.0,
        4.0,
    )
    common: CommonTolerance = CommonTolerance()
    limits: Limits = Limits()
    rivals: tuple[Rival, ...] = field(default=(), name="rival")
