"""The table ``[track]`` of a study: the trajectories, noises and weights of the tracking part."""

from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from octant.reader_design.study_file.quantities import (
    Angle,
    AngleDeviation,
    Bandwidth,
    Count,
    Deviation,
    Distance,
    Duration,
    FileName,
    Level,
    Name,
    Number,
    Period,
    PeriodOrZero,
    Ratio,
    Share,
    Spot,
    WheelRate,
    WheelRateDeviation,
)
from octant.reader_design.study_file.room import Table

Chapter = Literal[
    "rss",
    "feedback",
    "nominal",
    "neighbouring",
    "slam",
    "room",
    "costs",
    "tags",
    "long",
    "stabilisation",
    "law",
    "horizon",
    "slam line",
    "laboratory",
    "frames",
    "reader",
]
Shape = Literal[
    "line", "sine", "sigmoid", "parabola", "ellipse", "lemniscate", "u-shape", "point", "spline"
]
CodeLevel = Annotated[float, Meta(ge=-1e4, le=1e4)]
"""Of a code [dBm]: the exaggerated readings of thesis 6.5.1 reach -900 dBm."""
Horizon = Annotated[int, Meta(ge=1, le=1000)]
Beta = Annotated[float, Meta(ge=-100.0, le=100.0)]
Weights = Annotated[
    tuple[Number | Annotated[tuple[Number, ...], Meta(max_length=3)], ...],
    Meta(min_length=1, max_length=3),
]


class Trajectory(Table, frozen=True, kw_only=True):
    """A trajectory of one's own, driven by the neighbouring control: ``[[track.trajectory]]``.

    Parameters
    ----------
    name : Name in the results.
    shape : ``line``, ``sine``, ``sigmoid``, ``parabola``, ``ellipse``, ``lemniscate`` (as in the
        thesis), ``u-shape``, ``point`` (stay at ``start_m``), or ``spline``.
    waypoints_m : Points of a ``spline``, or the two ends of a ``line`` [m].
    closed : The spline returns to its first point.
    duration_s : How long it takes [s].
    start_m : (2,) tuple of float or None — Where the robot starts [m]; None: on the trajectory.
    start_heading_deg : Its heading there [deg]; None: along the trajectory.
    goal_heading_deg : Heading in which it is to stay at a ``point`` [deg]; None: that of the start.
    state_weight, final_weight : Q and P(t_f) of this trajectory; None: those of ``[track]``. For a
        ``point`` the thesis has 0.01 and 2 on all diagonals (7.5.2.1).
    """

    name: Name
    shape: Shape
    waypoints_m: Annotated[tuple[Spot, ...], Meta(max_length=10_000)] = ()
    closed: bool = False
    duration_s: Duration = 60.0
    start_m: Spot | None = None
    start_heading_deg: Angle | None = None
    goal_heading_deg: Angle | None = None
    state_weight: Weights | None = None
    final_weight: Weights | None = None


class Track(Table, frozen=True, kw_only=True):
    """The controllers of thesis chapters 6 and 7: table ``[track]``.

    Parameters
    ----------
    chapters : What is computed: ``rss`` (Fig. 6.3), ``feedback`` (6.4, 6.5), ``nominal`` (7.3-7.5),
        ``neighbouring`` (7.6, 7.7), ``slam`` (7.15), ``room`` (RSS from the room solver), ``costs``
        (Table 8.1); and, if named, ``tags`` (error against number and range of tags, 6.5.5),
        ``long`` (whether the error grows with the way, 6.5.4), ``stabilisation`` (chapter 6's
        feedback holds a point, 6.5.5), ``law`` (alpha and beta fitted on line, 6.3),
        ``horizon`` (receding horizon, 7.5.4), ``slam line`` (SLAM beside the filter on RSS, 7.7),
        ``laboratory`` (the experiments of 7.6 with their robots and tags, and sliding mode, 7.6.5),
        ``frames`` (codes and turns of the tags, 4.6.2), ``reader`` (the designed reader with its
        ``[sensor]`` in the room, for every controller and estimator and for SLAM).
    runs, slam_runs : Monte-Carlo repetitions, and those of SLAM.
    period_s : Sample period T of chapters 6 and 7.3 [s].
    alpha_dbm, beta_per_m : Alpha [dBm] and beta [1/m] of the RSS law (6.2).
    rss_samples : A CSV file with the columns ``distance_m`` and ``rss_dbm``: alpha and beta are
        fitted to it by least squares. None: the two keys count.
    guess_alpha_dbm, guess_beta_per_m : With what the chapter ``law`` begins [dBm], [1/m].
    guess_alpha_sigma_dbm, guess_beta_sigma_per_m : How uncertain that is [dBm], [1/m].
    rss_mean_db, rss_sigma_db : Mean and standard deviation of the noise on readings [dB].
    wheel_sigma_rad_per_s : Standard deviation of what a wheel adds to its command in a period
        [rad/s]; the thesis prints it for SLAM only.
    encoder_counts : Counts of a wheel encoder per turn, which the estimators receive; None: as in
        ``[robot]``, which has it for all verbs, and else they receive the commands, as in the
        thesis.
    start_sigma_m, start_sigma_deg : How wrong the assumed start is [m], [deg].
    feedback_tags, tags : Tags along each side of the square mesh of chapter 6 and of chapter 7.
    tag_spacing_m : Distance of neighbouring tags [m].
    tag_height_m : Height of the tags above the robot's antenna [m].
    tag_pattern : How the tags hang where the study has no ``[[tag]]``: ``mesh``, ``line`` along x,
        ``circle`` or ``random``, drawn from the seed. With ``[[tag]]``, these are the tags of all
        chapters, and the keys of number, pattern, spacing and height are not read.
    tag_count : Number of tags of every chapter; None: ``feedback_tags`` and ``tags`` squared.
    tag_field_m : Side of the square that the tags fill [m]; None: from ``tag_spacing_m``.
    tag_range_m : Distance from which on a tag is not heard [m]; None: heard everywhere.
    horizon, horizon_iterations : Periods that the predictive control looks ahead, and iterations of
        its solver in each.
    horizons : Horizons of the chapter ``horizon``, in periods.
    circle_radius_m, circle_duration_s : Its circle [m], [s].
    laboratory_wheel_scale, laboratory_rss_sigma_db : Of the chapter ``laboratory``: how much more
        or less than believed each wheel rolls, a standard deviation constant over a run [-]; and
        the scatter of readings [dB]. The thesis prints neither; Table 6.1 scatters by 3.4 dB.
    long_laps : Laps of the chapter ``long``.
    least_tags : Tags that the robot should hear everywhere.
    tag_counts : Numbers of tags of the chapter ``tags``; of a mesh square numbers.
    tag_ranges_m : Ranges of a tag of the chapter ``tags`` [m]; Table 6.1 ends at 6.18 m.
    tag_bits : Length of the code in which a tag answers with the RSS that it measures; None:
        readings are not rounded. The thesis has 8, after 16 of the tag's identity.
    tag_floor_dbm, tag_full_scale_dbm : RSS of the lowest and of the highest of these codes [dBm].
    tag_bit_rate_hz : Bits that reader and tags send in a second [Hz], which makes tags answer one
        after another; None: all in every period.
    tag_turnaround_s : Pause before each tag's reply [s].
    frame_bit_rates_hz : Bit rates of the chapter ``frames`` [Hz].
    feedback_wheel_rate_rad_per_s, wheel_rate_rad_per_s : Limits of the wheels in chapter 6 and in
        chapter 7 [rad/s]; None: as in ``[robot]``, and else 12.1 and 10.
    state_weight, final_weight : Q and P(t_f) of trajectories: three diagonal values, or three rows
        [1/m², 1/rad²].
    input_weight : R of the neighbouring control: two diagonal values, or two rows [s²/rad²].
    training_iterations : Of the measurement feedback.
    training_records : Noise records of the training over many.
    room_noise_db : Standard deviation of the noise on readings in the room solver's part and of
        each antenna of the designed reader [dB].
    room_reading_every_s : Time from one reading of the tags to the next there [s].
    reader_map_spacing_m : Spacing of the map of the chapter ``reader`` [m]: eight antennas added up
        fade over wider distances than one.
    room_tag_spacing_m : Distance of neighbouring tags of the mesh of chapter 7 there [m].
    room_map_spacing_m : Spacing of the map that the robot carries [m]; a fade is some centimetres
        wide.
    room_particles : Particles of the particle filter.
    trajectories : The tables ``[[track.trajectory]]``.
    """

    chapters: Annotated[tuple[Chapter, ...], Meta(min_length=1)] = (
        "rss",
        "feedback",
        "nominal",
        "neighbouring",
        "slam",
        "room",
        "costs",
    )
    runs: Count = 50
    slam_runs: Count = 100
    period_s: Period = 0.1
    alpha_dbm: Level = -60.0
    beta_per_m: Beta = 0.2
    rss_samples: FileName | None = None
    guess_alpha_dbm: Level = -35.5
    guess_beta_per_m: Beta = 0.1071
    guess_alpha_sigma_dbm: Annotated[float, Meta(ge=1e-6, le=1e3)] = 20.0
    guess_beta_sigma_per_m: Annotated[float, Meta(ge=1e-6, le=100.0)] = 0.1
    rss_mean_db: Ratio = -30.0
    rss_sigma_db: Deviation = 50.0
    wheel_sigma_rad_per_s: WheelRateDeviation = 0.1
    encoder_counts: Count | None = None
    start_sigma_m: Distance = 0.05
    start_sigma_deg: AngleDeviation = 3.0
    feedback_tags: Annotated[int, Meta(ge=1, le=100)] = 3
    tags: Annotated[int, Meta(ge=1, le=100)] = 5
    tag_spacing_m: Distance = 3.0
    tag_height_m: Distance = 3.0
    tag_pattern: Literal["mesh", "line", "circle", "random"] = "mesh"
    tag_count: Annotated[int, Meta(ge=1, le=10_000)] | None = None
    tag_field_m: Distance | None = None
    tag_range_m: Distance | None = None
    horizon: Horizon = 20
    horizon_iterations: Annotated[int, Meta(ge=1, le=1000)] = 5
    horizons: Annotated[tuple[Horizon, ...], Meta(min_length=1, max_length=20)] = (5, 10, 20, 40)
    circle_radius_m: Distance = 2.0
    circle_duration_s: Duration = 60.0
    laboratory_wheel_scale: Share = 0.01
    laboratory_rss_sigma_db: Annotated[float, Meta(ge=1e-3, le=100.0)] = 3.4
    long_laps: Annotated[int, Meta(ge=2, le=1000)] = 10
    least_tags: Annotated[int, Meta(ge=1, le=10_000)] = 9
    tag_counts: Annotated[
        tuple[Annotated[int, Meta(ge=1, le=10_000)], ...], Meta(min_length=1, max_length=100)
    ] = (4, 9, 25, 49)
    tag_ranges_m: Annotated[tuple[Distance, ...], Meta(max_length=100)] = (4.0, 6.18, 9.0)
    tag_bits: Annotated[int, Meta(ge=1, le=16)] | None = None
    tag_floor_dbm: CodeLevel = -255.0
    tag_full_scale_dbm: CodeLevel = 0.0
    tag_bit_rate_hz: Bandwidth | None = None
    tag_turnaround_s: PeriodOrZero = 0.0
    frame_bit_rates_hz: Annotated[tuple[Bandwidth, ...], Meta(min_length=1, max_length=20)] = (
        250e3,
        9600.0,
        2400.0,
        600.0,
    )
    feedback_wheel_rate_rad_per_s: WheelRate | None = None
    wheel_rate_rad_per_s: WheelRate | None = None
    state_weight: Weights = (1.0, 1.0, 2.0)
    final_weight: Weights = (0.5, 0.5, 1.0)
    input_weight: Weights = (0.01, 0.01)
    training_iterations: Count = 4000
    training_records: Count = 10
    room_noise_db: Deviation = 2.0
    room_reading_every_s: Period = 0.5
    room_tag_spacing_m: Distance = 2.5
    room_map_spacing_m: Distance = 0.04
    room_particles: Count = 500
    reader_map_spacing_m: Distance = 0.05
    trajectories: tuple[Trajectory, ...] = msgspec.field(default=(), name="trajectory")
