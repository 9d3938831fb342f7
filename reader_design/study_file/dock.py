"""The table ``[dock]`` of a study: a station, the robot that docks there, and its errors."""

import math
from typing import Annotated, Literal

from msgspec import Meta

from octant.reader_design.study_file.quantities import (
    Angle,
    AngleDeviation,
    Coordinate,
    Count,
    Deviation,
    Distance,
    Duration,
    Gain,
    Name,
    Period,
    Point,
    Share,
    Speed,
    SpeedError,
    Spot,
    TurnRate,
    TurnRateError,
)
from octant.reader_design.study_file.room import Table

Start = tuple[Coordinate, Coordinate, Angle]
Tolerance = Annotated[float, Meta(ge=1e-3, le=180.0)]
"""Of a direction [deg]."""


class Regulation(Table, frozen=True, kw_only=True):
    """The textbook's regulators, driven to the dock's pose: table ``[dock.regulation]``.

    Parameters
    ----------
    starts : Starts as seen from the goal: x, y [m], heading [deg].
    k1_per_s, k2_per_s : Gains of the Cartesian regulator, textbook (11.78), (11.79) [1/s].
    posture_k1_per_s, posture_k2_per_s, posture_k3 : Gains of the posture regulator, textbook
        (11.81), (11.82) [1/s], [1/s], [-].
    duration_s : How long they drive [s].
    """

    starts: Annotated[tuple[Start, ...], Meta(min_length=1, max_length=20)] = (
        (-1.0, -1.0, 0.0),
        (1.0, 1.0, 0.0),
    )
    k1_per_s: Gain = 1.0
    k2_per_s: Gain = 3.0
    posture_k1_per_s: Gain = 1.0
    posture_k2_per_s: Gain = 2.5
    posture_k3: Gain = 3.0
    duration_s: Duration = 8.0


class Dock(Table, frozen=True, kw_only=True):
    """Docking at a tagged station: table ``[dock]``.

    Parameters
    ----------
    tag : Tag that hangs over the staging place: the ``id`` of a ``[[tag]]``.
    landmark_position_m : (3,) tuple of float — Landmark at the station, in the room's frame [m].
    landmark_heading_deg : Direction that the robot has when it faces the landmark squarely [deg].
    stand_off_m : The robot docks so far in front of the landmark [m].
    staging_m : Distance of the staging place from the landmark [m].
    tolerance_m, tolerance_deg : The robot is docked where it is at most so far from the docking
        place [m], and turned at most so far from its direction [deg].
    tries : How often the robot tries.
    runs : Monte-Carlo repetitions in each layout.
    start_low_m, start_high_m : (2,) tuple of float or None — Corners of the area in which starts
        are drawn [m]; None: the room, or in free space 4 m to every side of the staging place.
    noise_db : Standard deviation of the noise of each RSS reading [dB].
    reading_time_s : Time between two readings of the tag [s].
    sample_time_s : Time between two images of the camera and two commands of the docking law [s].
    gamma_per_s, h, k_per_s : Gains of the docking law [1/s], [-], [1/s].
    max_speed_m_per_s, max_turn_rate_deg_per_s : Limits of its speed [m/s] and turn rate [deg/s].
    saturation : ``curvature``: beyond a limit both commands shrink by one factor; ``clip``: each by
        itself.
    approach : Which end of the robot docks: ``forward`` its front; ``reverse`` its back, as into a
        charger, the goals [0, ±π, ±π] of the docking paper; its camera then looks backwards.
    start_error_m : (2,) tuple of float or None — How wrong the first estimate of the landmark's
        place is, ahead and to the left [m]; with this or the next key the robot follows the docking
        law from a wrong estimate at once, instead of looking first.
    start_error_deg : How wrong its attitude is [deg].
    latch_radius_m : The robot stops so near to the goal [m].
    compensate_slips : Whether estimated slips are taken off the commands.
    linear_slip_m_per_s : How much faster the robot drives than it is commanded to [m/s]; this and
        the next three are in ``[robot]`` for all verbs; None: as there, and else -0.01.
    angular_slip_deg_per_s : How much faster it turns than it is commanded to [deg/s]; None: as
        there, and else 0.5.
    robot_radius_m, robot_height_m : The round body that collides [m]; None: as there, and else 0.2
        m and 0.8 m.
    camera_range_m : Greatest distance at which the landmark is recognised [m].
    camera_width_deg : Horizontal field of view [deg].
    position_sd_m : Standard deviation of each measured coordinate of the landmark [m].
    attitude_sd_deg : Standard deviation of its measured attitude [deg].
    detection_probability : Probability that a landmark in sight is detected.
    false_probability : Probability that something else is reported in its stead.
    regulation : The table ``[dock.regulation]``.
    """

    tag: Name
    landmark_position_m: Point
    landmark_heading_deg: Angle = 0.0
    stand_off_m: Distance = 0.5
    staging_m: Distance = 2.0
    tolerance_m: Distance = 0.08
    tolerance_deg: Tolerance = math.degrees(0.2)
    tries: Count = 4
    runs: Count = 100
    start_low_m: Spot | None = None
    start_high_m: Spot | None = None
    noise_db: Deviation = 1.0
    reading_time_s: Period = 1.0
    sample_time_s: Period = 0.1
    gamma_per_s: Gain = 0.125
    h: Gain = 20.0
    k_per_s: Gain = 1.0
    max_speed_m_per_s: Speed = 0.2
    max_turn_rate_deg_per_s: TurnRate = math.degrees(0.2)
    saturation: Literal["curvature", "clip"] = "curvature"
    approach: Literal["forward", "reverse"] = "forward"
    start_error_m: Spot | None = None
    start_error_deg: Angle | None = None
    latch_radius_m: Distance = 0.02
    compensate_slips: bool = True
    linear_slip_m_per_s: SpeedError | None = None
    angular_slip_deg_per_s: TurnRateError | None = None
    robot_radius_m: Distance | None = None
    robot_height_m: Distance | None = None
    camera_range_m: Distance = 4.5
    camera_width_deg: Annotated[float, Meta(ge=0.1, le=180.0)] = 57.0
    position_sd_m: Distance = 0.1
    attitude_sd_deg: AngleDeviation = math.degrees(0.1)
    detection_probability: Share = 0.95
    false_probability: Share = 0.02
    regulation: Regulation = Regulation()
