"""The table ``[truth]`` of a study: how the world differs from what the navigator is told."""

from typing import Annotated

import msgspec
from msgspec import Meta

from octant.reader_design.study_file.quantities import (
    AngleDeviation,
    Count,
    Deviation,
    DistanceOrZero,
    Duration,
    Share,
)
from octant.reader_design.study_file.room import RoomObject, Table


class Truth(Table, frozen=True, kw_only=True):
    """How the world of missions differs from the study, which is what navigators are told.

    Every deviation is that of a normal distribution, drawn from the study's seed; the world of a
    run is one of ``draws``. What is not given is as in the study.

    Parameters
    ----------
    draws : Number of worlds that the runs take in turn.
    permittivity_factor : Real part of all walls' and objects' permittivity over the study's [-].
    tag_sd_m : Deviation of every tag's place along x, y and z [m].
    tag_level_sd_db : Deviation of every tag's level [dB].
    tag_tilt_sd_deg : Deviation of the angle by which its antenna's axis leans, to any side [deg].
    antenna_gain_sd_db : Deviation of the gain of every antenna of the reader [dB].
    noise_db : Standard deviation of the noise of each RSS reading [dB]; None: the mission's.
    reader_height_error_m : How much higher the reader stands [m].
    max_reflections : Order of the true field [-].
    diffraction : Whether edges diffract there.
    wheel_slip, wheel_scale : As in ``[robot]``, of the true wheels [-].
    kidnapped_at_s : When somebody carries the robot to another free place and heading, unnoticed by
        its wheels [s]; None: never.
    objects : What stands there besides: the tables ``[[truth.object]]``.
    """

    draws: Count = 1
    permittivity_factor: Annotated[float, Meta(ge=0.1, le=10.0)] = 1.0
    tag_sd_m: DistanceOrZero = 0.0
    tag_level_sd_db: Deviation = 0.0
    tag_tilt_sd_deg: AngleDeviation | None = None
    antenna_gain_sd_db: Deviation = 0.0
    noise_db: Deviation | None = None
    reader_height_error_m: Annotated[float, Meta(ge=-10.0, le=10.0)] = 0.0
    max_reflections: Annotated[int, Meta(ge=0, le=12)] | None = None
    diffraction: bool | None = None
    wheel_slip: Share | None = None
    wheel_scale: Share | None = None
    kidnapped_at_s: Duration | None = None
    objects: tuple[RoomObject, ...] = msgspec.field(default=(), name="object")
