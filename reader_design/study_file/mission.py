"""The table ``[mission]`` of a study: which tags, by which navigator, how often, on what floor."""

from typing import Annotated, Literal

from msgspec import Meta

from octant.reader_design.study_file.room import NotNegative, Positive, PositiveCount, Table

Corners = Annotated[tuple[float, ...], Meta(min_length=3, max_length=4)]
Start = tuple[float, float, float]


class Membership(Table, frozen=True, kw_only=True):
    """The fuzzy controller's terms and rules: table ``[mission.membership]``.

    Parameters
    ----------
    input : Terms of the steering input, from left to right on [-1, 1]: where the membership leaves
        0, reaches 1, leaves 1 (for four) and is 0 again.
    speed : Terms of a wheel's speed on [0, 1], 0.5 being the cruise speed.
    rules : For each term of the input the terms of the right and the left wheel's speed.
    """

    input: dict[str, Corners]
    speed: dict[str, Corners]
    rules: dict[str, tuple[str, str]]


class Mission(Table, frozen=True, kw_only=True):
    """The drive through the tags: table ``[mission]``.

    Parameters
    ----------
    start_m : (2,) tuple of float — Where the robot starts, in the room's frame [m].
    heading_deg : Direction of its front at the start, counter-clockwise from +x [deg].
    tags : Tags to visit, in this order.
    navigator : ``thesis``: rotation, then the controller, arrival by a null (thesis 5.2);
        ``tracker``: estimates the tag's place from all readings and drives there. Neither knows
        where the tags are; the tracker knows how they hang.
    controller : Of the thesis' navigator. ``fuzzy``: the five rules of thesis 5.2.2.2;
        ``vector_sum``: turn in proportion to the bearing of the RSS-weighted vector sum;
        ``pattern``: the same with the bearing that fits the reader's patterns best.
    membership : Terms and rules of the fuzzy controller; None: evenly spaced triangles and Table
        5.1.
    steering_input : What the fuzzy controller sees: ``normalised``, (z2 - z4)/(z2 + z4), or
        ``nanowatt``, z2 - z4 over ``full_scale_nw``, clipped, as in the thesis.
    full_scale_nw : Full scale of the ``nanowatt`` input [nW].
    rotation : Where the rotation mode turns to: ``strongest`` antenna, thesis (5.2), or
        ``vector_sum``.
    rerotate_for_s : For so long on each leg the thesis' navigator rotates again when the strongest
        antenna is none of the front three [s]; 0: never.
    sample_time_s : Sample time T [s].
    cruise_step_m : Distance driven straight ahead in one sample time [m].
    runs : Monte-Carlo repetitions.
    noise_db : Standard deviation of the noise of each RSS reading [dB].
    arrival_radius_m : Distance from a tag's point on the floor at which the robot should find that
        it is there [m].
    max_time_s : A run that takes longer has failed [s]; None: 60 s and four times what the straight
        way takes.
    silent_limit : Readings in a row without any signal after which a run ends.
    starts : Starts that the runs take in turn: x, y [m], heading [deg]; empty: ``start_m``.
    random_starts : Each run starts anywhere on the free floor instead, with any heading.
    placement_m : Each run moves the layout's objects, each by up to so much along x and y, at
        random [m].
    placements : Number of such placements that the runs take in turn.
    contact : When the robot touches a wall or an object: ``end`` of the run, or ``slide`` along it.
    robot_radius_m, robot_height_m : The round body that collides [m].
    wheel_slip : Standard deviation of each wheel's slip in a period, as a share of its rotation.
    wheel_scale : The same, constant over a run [-].
    encoder_counts : Counts of an encoder in a turn of the wheel; None: exact.
    """

    start_m: tuple[float, float]
    heading_deg: float = 90.0
    tags: Annotated[tuple[str, ...], Meta(min_length=1)]
    navigator: Literal["thesis", "tracker"] = "thesis"
    controller: Literal["fuzzy", "vector_sum", "pattern"] = "fuzzy"
    membership: Membership | None = None
    steering_input: Literal["normalised", "nanowatt"] = "normalised"
    full_scale_nw: Positive = 1200.0
    rotation: Literal["strongest", "vector_sum"] = "strongest"
    rerotate_for_s: NotNegative = 0.0
    sample_time_s: Positive = 1.0
    cruise_step_m: Positive = 0.09
    runs: PositiveCount = 100
    noise_db: NotNegative = 1.0
    arrival_radius_m: Positive = 0.2
    max_time_s: Positive | None = None
    silent_limit: PositiveCount = 5
    starts: tuple[Start, ...] = ()
    random_starts: bool = False
    placement_m: NotNegative = 0.0
    placements: PositiveCount = 1
    contact: Literal["end", "slide"] = "end"
    robot_radius_m: Positive = 0.15
    robot_height_m: Positive = 0.4
    wheel_slip: NotNegative = 0.0
    wheel_scale: NotNegative = 0.0
    encoder_counts: PositiveCount | None = None
