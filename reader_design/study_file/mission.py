"""The table ``[mission]`` of a study: which tags, by which navigator, how often, on what floor."""

from typing import Annotated, Literal

from msgspec import Meta

from octant.navigation.navigators.place_particles import FADING_DB, LEVEL_DB, TRUST
from octant.reader_design.study_file.quantities import (
    Angle,
    Coordinate,
    Count,
    Deviation,
    Distance,
    DistanceOrZero,
    Duration,
    DurationOrZero,
    FileName,
    Name,
    Number,
    Period,
    PowerNanowatt,
    Share,
    Spot,
)
from octant.reader_design.study_file.room import Table

NAVIGATORS = ("thesis", "tracker", "map", "counting")
"""Octant's own navigators."""
Corners = Annotated[tuple[Number, ...], Meta(min_length=3, max_length=4)]
Terms = Annotated[dict[Name, Corners], Meta(min_length=1, max_length=100)]
Start = tuple[Coordinate, Coordinate, Angle]


class Membership(Table, frozen=True, kw_only=True):
    """The fuzzy controller's terms and rules: table ``[mission.membership]``.

    Parameters
    ----------
    input : Terms of the steering input, from left to right on [-1, 1]: where the membership leaves
        0, reaches 1, leaves 1 (for four) and is 0 again.
    speed : Terms of a wheel's speed on [0, 1], 0.5 being the cruise speed.
    rules : For each term of the input the terms of the right and the left wheel's speed.
    """

    input: Terms
    speed: Terms
    rules: dict[Name, tuple[Name, Name]]


class Tracker(Table, frozen=True, kw_only=True):
    """What the tracker supposes of readings: table ``[mission.tracker]``.

    Parameters
    ----------
    trust : Power of the likelihood of a reading: nearby readings share their fading, and so weigh
        less than independent ones.
    fading_db : Standard deviation of an antenna's RSS where reflections dominate [dB].
    level_db : How well the tag's level is known, as a standard deviation [dB]; it hardly changes
        over a leg, and the tracker finds it out.
    reach_m : How far from the start of a leg, along the floor, the tag is looked for [m]; None: the
        diagonal of the room, in free space 1.5 times the diagonal of what start and tags span, at
        least 8 m.
    """

    trust: Annotated[float, Meta(ge=1e-3, le=1.0)] = TRUST
    fading_db: Annotated[float, Meta(ge=0.1, le=40.0)] = FADING_DB
    level_db: Annotated[float, Meta(ge=0.01, le=100.0)] = LEVEL_DB
    reach_m: Annotated[float, Meta(ge=0.5, le=1000.0)] | None = None


class MapKeys(Table, frozen=True, kw_only=True):
    """What the navigator ``map`` is told of room and survey: table ``[mission.map]``.

    Parameters
    ----------
    start : Whether it knows where it starts: ``known``, or ``unknown`` place and heading.
    particles : Poses that it weighs, at least; more while the pose is open.
    spacing_m : Distance of the places of its field maps [m]; None: a sixth of a wavelength.
    edges : Whether field maps contain paths over an edge with one reflection before or behind it:
        in furnished rooms their error field is then 2 to 4 times weaker, and they take 3 to 9 times
        longer. None: in rooms of 500 edges that diffract at most.
    tag_sd_m : How exactly the tags' places are surveyed, as a standard deviation along each axis
        [m]. Half a wavelength over 2 pi (2 cm at 2.4 GHz) makes half of all fading unknown.
        Where that is more than half of what is unknown, in plain rooms beyond a twentieth of a
        wavelength (6 mm), the places are searched for while driving.
    level_sd_db, gain_sd_db : How well tags' levels and antennas' gains are known, as standard
        deviations [dB]; it finds them out while driving.
    field_error : Power over the local mean of the field that the map does not know for other
        reasons: materials, furniture, people [-]. It supposes at least this, and more where
        readings say so.
    learned : The file ``learned.toml`` of an earlier mission in this room with this reader: where
        tags hang, and levels and gains; its maps are made for the places that it found.
    earlier_missions : How many missions the robot has driven before in the same world, each run:
        it keeps what these have found of the tags' places and levels and of its antennas' gains.
    """

    start: Literal["known", "unknown"] = "known"
    particles: Annotated[int, Meta(ge=100, le=100_000)] = 2000
    spacing_m: Distance | None = None
    edges: bool | None = None
    tag_sd_m: DistanceOrZero = 0.02
    level_sd_db: Annotated[float, Meta(ge=0.01, le=100.0)] = 2.0
    gain_sd_db: Annotated[float, Meta(ge=0.01, le=100.0)] = 1.0
    field_error: Share = 0.02
    learned: FileName | None = None
    earlier_missions: Annotated[int, Meta(ge=0, le=100)] = 0


class Mission(Table, frozen=True, kw_only=True):
    """The drive through the tags: table ``[mission]``.

    Parameters
    ----------
    start_m : (2,) tuple of float — Where the robot starts, in the room's frame [m].
    heading_deg : Direction of its front at the start, counter-clockwise from +x [deg].
    tags : Tags to visit, in this order.
    navigator : ``thesis``: rotation, then the controller, arrival by a null (thesis 5.2);
        ``tracker``: estimates the tag's place from all readings and drives there. Neither knows
        where the tags are; the tracker knows how they hang. ``map`` knows the room and all tags,
        and finds its own pose by field maps; ``counting`` knows the tags' points and counts its
        wheels' turns only. These two drive round what stands about.
        Or one of your own:
        ``FILE.py:Class`` (beside the study file), ``package.module:Class``, or the name of an entry
        point of the group ``octant.navigators``; see `octant.Navigator`.
    tracker : What the tracker supposes of readings.
    map : What the navigator ``map`` is told.
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
    robot_radius_m, robot_height_m : The round body that collides [m]; None: as in ``[robot]``,
        which has it for all verbs, and else 0.15 m and 0.4 m.
    wheel_slip : Standard deviation of each wheel's slip in a period, as a share of its rotation;
        this and the next two are in ``[robot]`` for all verbs; None: as there, and else none.
    wheel_scale : The same, constant over a run [-].
    encoder_counts : Counts of an encoder in a turn of the wheel; None: as there, and else exact.
    """

    start_m: Spot
    heading_deg: Angle = 90.0
    tags: Annotated[tuple[Name, ...], Meta(min_length=1, max_length=10_000)]
    navigator: FileName = "tracker"
    tracker: Tracker = Tracker()
    map: MapKeys = MapKeys()
    controller: Literal["fuzzy", "vector_sum", "pattern"] = "fuzzy"
    membership: Membership | None = None
    steering_input: Literal["normalised", "nanowatt"] = "normalised"
    full_scale_nw: PowerNanowatt = 1200.0
    rotation: Literal["strongest", "vector_sum"] = "strongest"
    rerotate_for_s: DurationOrZero = 0.0
    sample_time_s: Period = 1.0
    cruise_step_m: Distance = 0.09
    runs: Count = 100
    noise_db: Deviation = 1.0
    arrival_radius_m: Distance = 0.2
    max_time_s: Duration | None = None
    silent_limit: Count = 20
    starts: tuple[Start, ...] = ()
    random_starts: bool = False
    placement_m: DistanceOrZero = 0.0
    placements: Count = 1
    contact: Literal["end", "slide"] = "end"
    robot_radius_m: Distance | None = None
    robot_height_m: Distance | None = None
    wheel_slip: Share | None = None
    wheel_scale: Share | None = None
    encoder_counts: Count | None = None
