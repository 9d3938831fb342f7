"""The table ``[optimise]`` of a study: what may be varied, within which limits, to which goals."""

from typing import Annotated, Literal, TypeVar

import msgspec
from msgspec import Meta

from octant.geometries.errors import ConfigError
from octant.reader_design.study_file.quantities import (
    Antennas,
    Cells,
    Count,
    CountOrZero,
    Distance,
    Load,
    LoadBound,
    Number,
    Part,
    PartOrZero,
    Weight,
)
from octant.reader_design.study_file.room import Table

Bounds = tuple[PartOrZero, PartOrZero]
Kind = TypeVar("Kind")
OneOrMore = Annotated[tuple[Kind, ...], Meta(min_length=1, max_length=1000)]
Score = Literal[
    "right_share",
    "margin_db",
    "bearing_error_deg",
    "front_to_back_db",
    "level_dbm",
    "gain_db",
    "footprint_m",
    "height_m",
]
SMALLER_IS_BETTER = ("bearing_error_deg", "footprint_m", "height_m")
"""Scores of which less is better; of the others more is."""
SIZES = ("footprint_m", "height_m")
"""Scores that do not depend on a distance [m]."""


class Parameters(Table, frozen=True, kw_only=True):
    """Lengths and loads that vary continuously: ``optimise.parameters``.

    Parameters
    ----------
    antenna_length_m, antenna_radius_m, plate_height_m, plate_height_axis_m : (2,) tuple or None —
        Least and greatest value of the key of ``[reader]`` of that name [m]; None: it stays.
    plate_outer_radius_m, ground_plane_m, gap_m, monopole_plane_m : (2,) tuple or None — The same
        [m].
    plate_profile_m : (2,) tuple or None — The same [m] of every height that ``[reader]`` has there.
    load_ohm : (2,) tuple or None — The same [ohm].
    """

    antenna_length_m: Bounds | None = None
    antenna_radius_m: Bounds | None = None
    plate_height_m: Bounds | None = None
    plate_height_axis_m: Bounds | None = None
    plate_profile_m: Bounds | None = None
    plate_outer_radius_m: Bounds | None = None
    ground_plane_m: Bounds | None = None
    gap_m: Bounds | None = None
    monopole_plane_m: Bounds | None = None
    load_ohm: tuple[LoadBound, LoadBound] | None = None

    def given(self) -> dict[str, tuple[float, float]]:
        """Return the bounds of the keys that vary, in the unit that each name carries."""
        pairs = {name: getattr(self, name) for name in self.__struct_fields__}
        return {name: pair for name, pair in pairs.items() if pair is not None}


class Choices(Table, frozen=True, kw_only=True):
    """Values of which every combination is surveyed: ``optimise.choices``.

    Parameters
    ----------
    antenna : Of ``dipole`` and ``monopole``; None: the reader's own, as in the other keys.
    ground_plane_shape : Of ``square``, ``round`` and ``octagon``.
    antennas : Numbers of antennas.
    antenna_length_m, antenna_radius_m, plate_height_m, plate_height_axis_m : Values [m] of the key
        of ``[reader]`` of that name.
    plate_outer_radius_m, ground_plane_m, gap_m, monopole_plane_m : The same [m].
    load_ohm : The same [ohm].
    """

    antenna: OneOrMore[Literal["dipole", "monopole"]] | None = None
    ground_plane_shape: OneOrMore[Literal["square", "round", "octagon"]] | None = None
    antennas: OneOrMore[Antennas] | None = None
    antenna_length_m: OneOrMore[Part] | None = None
    antenna_radius_m: OneOrMore[Part] | None = None
    plate_height_m: OneOrMore[PartOrZero] | None = None
    plate_height_axis_m: OneOrMore[PartOrZero] | None = None
    plate_outer_radius_m: OneOrMore[Part] | None = None
    ground_plane_m: OneOrMore[Part] | None = None
    gap_m: OneOrMore[Part] | None = None
    monopole_plane_m: OneOrMore[PartOrZero] | None = None
    load_ohm: OneOrMore[Load] | None = None

    def given(self) -> dict[str, tuple[str | float, ...]]:
        """Return the lists that are given, in the unit that each name carries."""
        lists = {name: getattr(self, name) for name in self.__struct_fields__}
        return {name: values for name, values in lists.items() if values is not None}


class Goal(Table, frozen=True, kw_only=True):
    """One goal of the search: ``[[optimise.goal]]``.

    Parameters
    ----------
    score : Over the distances that count: ``right_share``, mean share of directions whose strongest
        antenna is the nearest; ``margin_db``, worst lead of the facing antenna over its neighbours
        [dB]; ``bearing_error_deg``, rms error of the vector sum over azimuth, at the worst distance
        [deg]; ``front_to_back_db``, mean lead of the facing antenna over the opposite one [dB];
        ``level_dbm``, signal of the strongest antenna, mean over azimuth, where it is weakest
        [dBm]; ``gain_db``, least gain of that signal over the study's ``[reader]`` [dB]. Of no
        distance: ``footprint_m``, size of the ground plane [m]; ``height_m``, of plates and
        antennas above it [m].
    value : What is to be reached or undercut, in the score's unit.
    weight : How much one unit of shortfall counts.
    at_m : Distances that count [m], of ``distances_m``; empty: all.
    """

    score: Score
    value: Number
    weight: Weight = 1.0
    at_m: tuple[Distance, ...] = ()


DEFAULT_GOALS = (
    Goal(score="right_share", value=1.0, weight=100.0),
    Goal(score="margin_db", value=2.6),
    Goal(score="bearing_error_deg", value=0.3, weight=5.0),
    Goal(score="gain_db", value=3.01),
)
"""Goals of a study that names none [-], [dB], [deg]."""


class Optimise(Table, frozen=True, kw_only=True):
    """The search for a design: table ``[optimise]``.

    Parameters
    ----------
    parameters : What varies continuously, and its bounds [m], [ohm].
    choices : What varies in steps; every combination is surveyed.
    goals : The tables ``[[optimise.goal]]``.
    distances_m : Horizontal distances of the tag at which designs are scored, in free space [m].
    footprint_m : Greatest ground plane: side, diameter, or width across flats [m].
    height_m : Greatest height of plates and antennas above the ground plane [m].
    survey : Designs spread over the bounds for each combination of choices, besides the reader's
        own values, which are always tried.
    starts : Combinations of choices that are refined, each from its best design of the survey, the
        best ones first.
    evaluations : Designs that each refinement may evaluate; 0: survey only.
    method : ``nelder-mead`` and ``cobyqa`` refine locally; ``differential-evolution`` searches all
        between the bounds; ``gradient`` refines locally by derivatives, in a fifth of the
        solutions: full wave only, and of the parameters all but ``plate_outer_radius_m`` and
        ``monopole_plane_m``.
    shortlist : Designs on the short list.
    confirm_cells_per_wavelength : Mesh with which the winner and the reader are solved once more
        [-].
    """

    parameters: Parameters = Parameters()
    choices: Choices = Choices()
    goals: Annotated[tuple[Goal, ...], Meta(min_length=1)] = msgspec.field(
        default=DEFAULT_GOALS, name="goal"
    )
    distances_m: OneOrMore[Distance] = (1.0, 2.0, 4.0)
    footprint_m: Part = 0.2
    height_m: Part = 0.10
    survey: CountOrZero = 8
    starts: Count = 1
    evaluations: CountOrZero = 60
    method: Literal["nelder-mead", "cobyqa", "differential-evolution", "gradient"] = "nelder-mead"
    shortlist: Count = 5
    confirm_cells_per_wavelength: Cells = 14.0


def check_optimise(table: Optimise) -> None:
    """Refuse bounds, choices and goals that contradict each other.

    Parameters
    ----------
    table : Table whose single values are within their ranges [m], [ohm].
    """
    bounds, choices = table.parameters.given(), table.choices.given()
    for name, (low, high) in bounds.items():
        if low >= high:
            msg = (
                f"optimise.parameters.{name} is [{low:g}, {high:g}], but the first bound must lie "
                "below the second; turn them round, or move the value to [reader]."
            )
            raise ConfigError(msg)
        if name in choices:
            msg = f"optimise.{name} is both a parameter and a choice; keep one of them."
            raise ConfigError(msg)
    for name, values in choices.items():
        if len(set(values)) < len(values):
            msg = f"optimise.choices.{name} names a value twice; name each once."
            raise ConfigError(msg)
    if not bounds and not choices:
        msg = (
            "optimise has neither parameters nor choices, so there is nothing to search; give "
            "bounds, for example parameters = {antenna_length_m = [0.04, 0.07]}."
        )
        raise ConfigError(msg)
    if table.evaluations and not bounds:
        msg = (
            f"optimise.evaluations is {table.evaluations}, but no parameter varies; give "
            "optimise.parameters, or evaluations = 0."
        )
        raise ConfigError(msg)
    for i, goal in enumerate(table.goals):
        _check_goal(f"optimise.goal[{i}]", goal, table.distances_m)


def _check_goal(path: str, goal: Goal, distances_m: tuple[float, ...]) -> None:
    for distance in goal.at_m:
        if distance not in distances_m:
            known = ", ".join(f"{d:g}" for d in distances_m)
            msg = (
                f"{path}.at_m has {distance:g} m, but designs are scored at {known} m; add it to "
                "optimise.distances_m."
            )
            raise ConfigError(msg)
    if goal.at_m and goal.score in SIZES:
        msg = f"{path}.at_m is given, but {goal.score} does not depend on a distance; leave it out."
        raise ConfigError(msg)
