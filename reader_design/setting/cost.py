"""What commands are expected to take, from a study alone: time, memory, and what makes them large.

The figures are rough on purpose, a third off in unknowns and a factor of two to four in time on a
machine of 2024; they tell minutes from days before the first is spent.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from octant.em.blocks import cores
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave.band import NODES
from octant.em.reader.fullwave.surroundings import surroundings_size
from octant.reader_design.setting.design import FULLWAVE, METAL
from octant.reader_design.study_file.checks import rooms_of
from octant.reader_design.study_file.dock import Dock
from octant.reader_design.study_file.mission import Mission
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.room import Room
from octant.reader_design.study_file.schema import Study
from octant.reader_design.study_file.sweep import expanded
from octant.reader_design.study_file.track import Track

UNKNOWNS_PER_ELEMENT = 2.9
"""Unknowns [-] for every square of the mesh's edge length on the reader's sheets."""
UNKNOWNS_OF_ANTENNA = {"dipole": 53.0, "monopole": 174.0, "monopole on its own plane": 294.0}
"""Unknowns [-] of an antenna and of the finer mesh around its foot."""
UNKNOWNS_UNDER_FOOT = 88.0
"""Further unknowns [-] below each dipole whose gap is ``CLOSE_GAP_M`` or less."""
CLOSE_GAP_M = 0.005
"""Gap [m] below which the mesh under a dipole is as fine as it gets."""
SECTORS = {"square": 4, "octagon": 8}
"""Rotations [-] that a ground plane has; a round one has as many as there are antennas."""

PROCESS_BYTES = 450e6
"""Memory [B] of a process with all libraries and a small room."""
PATTERN_S, ASSEMBLY_S, FACTORS_S = 0.2, 3e-7, 8e-11
"""Time [s] of a solution: patterns; times N^2/s; times N^3/s^2, for N unknowns in s sectors."""
APPROXIMATE_S = {"rays": 1.5, "isolated": 0.05, "files": 1.0}
"""Time [s] of the responses that need no solution."""
FREE_S, SAMPLE_S = 0.05, 4e-7
"""Time [s] of the scores in free space, and of one path to one place of the room."""

STEP_S = {"thesis": 2e-3, "tracker": 2e-2, "map": 1e-2, "counting": 2e-3}
"""Time [s] of one step of a navigator, besides the field."""
LOOP_S = 2e-4
"""Time [s] of one step of a controller or of a filter."""
STEP_BYTES = 200.0
"""Memory [B] of one step of a run that is kept."""
LAYERS_BYTES = 40.0
"""Memory [B] for each value of a map while it is computed and written."""
READING_S = 1.2e-4
"""Time [s] of one reading of the study's receiver, and of its row in a table."""
BENDS_OVER_EDGES = 8.0
"""How many more sequences there are where edges diffract [-]; 4 times that over two edges."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cost:
    """What a command is expected to take.

    Parameters
    ----------
    counts : What is computed, in words, for example ``36000 places``.
    seconds : Time of one core [s].
    memory_bytes : Memory of a process [B].
    causes : Keys and options that make it large.
    """

    counts: tuple[str, ...]
    seconds: float
    memory_bytes: float = PROCESS_BYTES
    causes: tuple[str, ...] = ()

    def and_then(self, other: "Cost") -> "Cost":
        """Return the cost of both, one after the other [s], [B].

        Parameters
        ----------
        other : What follows.
        """
        return Cost(
            counts=tuple(dict.fromkeys((*self.counts, *other.counts))),
            seconds=self.seconds + other.seconds,
            memory_bytes=max(self.memory_bytes, other.memory_bytes),
            causes=tuple(dict.fromkeys((*self.causes, *other.causes))),
        )

    def times(self, count: float, what: str, *causes: str) -> "Cost":
        """Return the cost of so many of these [s].

        Parameters
        ----------
        count, what, causes : How many [-], of what, and which keys say so.
        """
        return replace(
            self,
            counts=(f"{count:.6g} {what}", *self.counts),
            seconds=count * self.seconds,
            causes=(*causes, *self.causes),
        )

    def text(self) -> str:
        """Return counts, time and memory in words."""
        spent = f"about {duration_text(self.seconds)} of one core"
        return f"{', '.join(self.counts)}: {spent} and {gigabytes_text(self.memory_bytes)}"


def unknowns_of(design: Reader, *, edge_m: float) -> int:
    """Return about how many unknowns the moment method has for a reader, within a third.

    Parameters
    ----------
    design : Its sheets and antennas; `surroundings_size` counts what stands beside it.
    edge_m : Edge length of its mesh [m].
    """
    side_m, count = design.ground_plane_m, design.antennas
    filled = {"square": 1.0, "round": math.pi / 4.0, "octagon": 0.83}[design.ground_plane_shape]
    at_axis_m = design.plate_height_axis_m
    ends_m = design.plate_height_m, design.plate_height_m if at_axis_m is None else at_axis_m
    height_m = (sum(ends_m) / 2 + sum(design.plate_profile_m)) / (1 + len(design.plate_profile_m))
    reach_m = design.plate_outer_radius_m or side_m / 2.0
    area_m2 = filled * side_m**2 + count * reach_m * height_m
    kind: str = design.antenna
    foot = 0.0
    if kind == "dipole":
        foot = UNKNOWNS_UNDER_FOOT * min(1.0, CLOSE_GAP_M / design.gap_m) ** 2
    elif design.monopole_plane_m > 0.0:
        kind = "monopole on its own plane"
        area_m2 += count * design.monopole_plane_m**2
    each = UNKNOWNS_OF_ANTENNA[kind] + foot
    return round(UNKNOWNS_PER_ELEMENT * area_m2 / edge_m**2 + count * each)


def _metal_cost(design: Reader, study: Study) -> Cost:
    """Return what the response of a reader of any metal takes."""
    mesh = design.metal_mesh(max(study.radio.frequencies_hz))
    unknowns = round(1.5 * len(mesh.faces))
    once = PATTERN_S + ASSEMBLY_S * unknowns**2 + FACTORS_S * unknowns**3
    return Cost(
        counts=(f"about {unknowns} unknowns",),
        seconds=min(len(study.radio.frequencies_hz), NODES) * once,
        memory_bytes=PROCESS_BYTES + 16.0 * unknowns**2,
        causes=("reader.body", "reader.cells_per_wavelength"),
    )


def reader_cost(study: Study, reader: Reader | None = None, *, symmetric: bool = True) -> Cost:
    """Return what the reader's response takes at all channels of a study.

    N unknowns in s equal sectors need a matrix of 16 N^2/s bytes. A single sector is factorised in
    place; of several, one mode of 16 N^2/s^2 bytes at a time, in up to three copies.

    Parameters
    ----------
    study, reader : The study; another reader than its own.
    symmetric : Whether its sectors are equal; build errors make them differ.
    """
    design = reader or study.reader
    model, channels = study.reader.response, len(study.radio.frequencies_hz)
    if model == METAL:
        return _metal_cost(design, study)
    if model != FULLWAVE:
        return Cost(counts=(f"response {model}",), seconds=channels * APPROXIMATE_S[model])
    unknowns, sectors = solved_unknowns(study, design)
    sectors = sectors if symmetric else 1
    matrix_bytes = 16.0 * unknowns**2 / sectors
    copies = 3.0 / sectors if sectors > 1 else 0.0
    once = PATTERN_S + ASSEMBLY_S * unknowns**2 / sectors
    return Cost(
        counts=(f"{unknowns} unknowns",),
        seconds=min(channels, NODES) * (once + FACTORS_S * unknowns**3 / sectors**2),
        memory_bytes=PROCESS_BYTES + (1.0 + copies) * matrix_bytes,
        causes=(
            "the reader's size in wavelengths",
            "reader.cells_per_wavelength",
            *(("reader.object",) if design.objects else ()),
        ),
    )


def solved_unknowns(study: Study, design: Reader) -> tuple[int, int]:
    """Return about how many unknowns a reader has, and in how many equal sectors it is solved.

    Parameters
    ----------
    study, design : The study, whose highest channel the mesh is made for; the reader.
    """
    count = design.antennas
    shortest_m = SPEED_OF_LIGHT_M_PER_S / max(study.radio.frequencies_hz)
    edge_m = shortest_m / study.reader.cells_per_wavelength
    beside, turns = surroundings_size(design.surroundings, edge_m=edge_m, antennas=count)
    unknowns = unknowns_of(design, edge_m=edge_m) + beside
    return unknowns, math.gcd(count, turns, SECTORS.get(design.ground_plane_shape, count))


def sequences_of(study: Study) -> float:
    """Return about how many sequences of bends there are from a tag [-]: the images of a box.

    Parameters
    ----------
    study : Its solver's order, and whether edges diffract.
    """
    solver = study.solver
    images = 1.0 + sum(4 * order**2 + 2 for order in range(1, solver.max_reflections + 1))
    if study.room.free_space:
        images = 1.0
    edges = BENDS_OVER_EDGES * (4.0 if solver.max_diffractions == 2 else 1.0)
    return images * (edges if solver.diffraction else 1.0)


def field_cost(study: Study, places: float, *, tags: int, causes: tuple[str, ...] = ()) -> Cost:
    """Return what the power of all antennas takes at many places.

    Parameters
    ----------
    study : Its solver, channels and reader.
    places, tags : Numbers of places and of tags [-].
    causes : What says how many places there are.
    """
    paths = sequences_of(study)
    channels = len(study.radio.frequencies_hz)
    values = places * tags * study.reader.antennas
    return Cost(
        counts=(
            counted(places, "place"),
            counted(tags, "tag"),
            f"some {paths:.3g} sequences of bends",
        ),
        seconds=SAMPLE_S * values * channels * paths,
        memory_bytes=PROCESS_BYTES + LAYERS_BYTES * values,
        causes=(*causes, "solver.max_reflections", "solver.diffraction"),
    )


def readings_cost(readings: float, *, causes: tuple[str, ...] = ()) -> Cost:
    """Return what drawing and writing readings of all antennas takes.

    Parameters
    ----------
    readings : How many there are [-].
    causes : What says so.
    """
    return Cost(counts=(counted(readings, "reading"),), seconds=READING_S * readings, causes=causes)


def replay_cost(estimator: str, rounds: int) -> Cost:
    """Return what an estimator takes with a recorded drive, its reader solved already.

    Parameters
    ----------
    estimator, rounds : Tracker, map or a bearing method; rounds of the log [-].
    """
    return Cost(
        counts=(counted(rounds, "round"),),
        seconds=rounds * STEP_S.get(estimator, LOOP_S),
        causes=("the log's readings",),
    )


def mission_steps(study: Study, mission: Mission) -> float:
    """Return how many steps a run can have before its time is out [-].

    Parameters
    ----------
    study, mission : The study and its mission.
    """
    if mission.max_time_s is not None:
        return mission.max_time_s / mission.sample_time_s
    places = {tag.id: tag.position_m[:2] for tag in study.tags}
    corners = np.array([mission.start_m, *(places[tag] for tag in mission.tags)])
    way_m = float(np.hypot(*np.diff(corners, axis=0).T).sum())
    return 60.0 / mission.sample_time_s + 4.0 * way_m / mission.cruise_step_m


def mission_cost(study: Study, runs: int) -> Cost:
    """Return what driving the robot takes.

    Parameters
    ----------
    study, runs : A study with a mission, and the number of its runs.
    """
    mission = study.mission
    if mission is None:
        return Cost(counts=(), seconds=0.0)
    steps = mission_steps(study, mission)
    at = field_cost(study, 1.0, tags=1).seconds
    seconds = steps * (STEP_S.get(mission.navigator, STEP_S["tracker"]) + at)
    kept = runs * steps * (STEP_BYTES + 8.0 * study.reader.antennas)
    return Cost(
        counts=(f"{counted(runs, 'run')} of at most {steps:.6g} steps",),
        seconds=runs * seconds,
        memory_bytes=PROCESS_BYTES + kept,
        causes=("mission.runs", "mission.sample_time_s", "mission.max_time_s"),
    )


def docking_cost(study: Study, dock: Dock) -> Cost:
    """Return what the runs of a docking study take.

    Parameters
    ----------
    study, dock : The study and its docking.
    """
    rooms = 1 + len(study.layouts)
    steps = dock.tries * 300.0 * (1.0 / dock.sample_time_s + 1.0 / dock.reading_time_s)
    return Cost(
        counts=(f"{counted(rooms * dock.runs, 'run')} of at most {steps:.6g} steps",),
        seconds=rooms * dock.runs * steps * LOOP_S,
        memory_bytes=PROCESS_BYTES + rooms * dock.runs * steps * STEP_BYTES,
        causes=("dock.runs", "dock.sample_time_s", "dock.reading_time_s", "dock.tries"),
    )


def tracking_cost(track: Track) -> Cost:
    """Return what the chapters of a tracking study take.

    Parameters
    ----------
    track : Its table.
    """
    named, own = set(track.chapters), len(track.trajectories)
    longest_s = max([60.0, *(one.duration_s for one in track.trajectories)])
    steps, curves = longest_s / track.period_s, 6 + own
    curves += (1 + own) * (2 * len(track.tag_counts) + len(track.tag_ranges_m)) * ("tags" in named)
    curves += 2 * (1 + own) * track.long_laps * ("long" in named)
    curves += 2 * (1 + len(track.horizons)) * ("horizon" in named)
    curves += 20 * len({"frames", "law", "laboratory"} & named)
    readings = max(track.tags, track.feedback_tags) ** 2
    loops = track.runs * curves + track.slam_runs * (1.0 + readings / 10.0)
    training = track.training_iterations * track.training_records
    reads = track.runs * 11 * longest_s / track.room_reading_every_s * ("reader" in named)
    squares = (8.0 / track.reader_map_spacing_m) ** 2 * ("reader" in named)
    particles = 1e-7 * track.room_particles * readings * ("room" in track.chapters)
    return Cost(
        counts=(
            f"{counted(track.runs, 'run')} of {curves} trajectories in up to {steps:.6g} steps",
            f"{counted(track.slam_runs, 'run')} of SLAM",
            counted(readings, "tag"),
        ),
        seconds=steps * (loops * LOOP_S + track.runs * particles)
        + 1e-5 * training * steps / 10.0
        + 1e-6 * track.training_iterations * steps * track.runs * ("stabilisation" in named)
        + (6e-4 * reads + 1e-4 * squares) * readings,
        memory_bytes=PROCESS_BYTES + (loops + track.training_records) * steps * STEP_BYTES,
        causes=(
            "track.runs", "track.slam_runs", "track.period_s", "track.tags",
            "track.room_particles", "track.training_iterations", "duration_s of trajectories",
            "track.long_laps", "track.tag_counts", "track.reader_map_spacing_m",
        ),
    )  # fmt: skip


def floor_m2(room: Room) -> float:
    """Return about what area the floor of a room has [m2]; 100 m2 where a mesh decides.

    Parameters
    ----------
    room : The room.
    """
    if room.box_m is not None:
        return room.box_m[0] * room.box_m[1]
    if room.outline_m is not None:
        return float(np.prod(np.ptp(np.array(room.outline_m), axis=0)))
    return 0.0 if room.free_space else 100.0


def scoring_cost(study: Study, *, room_spacing_m: float, room_azimuths: int) -> Cost:
    """Return what the scores of one reader take besides its response.

    Parameters
    ----------
    study : The study.
    room_spacing_m, room_azimuths : How densely its room is probed [m]; azimuths for each antenna.
    """
    places = floor_m2(rooms_of(study)) / room_spacing_m**2
    azimuths = study.reader.antennas * room_azimuths
    channels = len(study.radio.frequencies_hz)
    samples = places * len(study.tags) * azimuths
    return Cost(
        counts=(f"{samples:.6g} samples of the room",) if samples else (),
        seconds=FREE_S + SAMPLE_S * samples * channels * sequences_of(study),
        memory_bytes=PROCESS_BYTES + LAYERS_BYTES * samples * study.reader.antennas,
        causes=("the room's floor", "solver.max_reflections"),
    )


def shared(cost: Cost, workers: int | None) -> Cost:
    """Return the cost where several processes share the cases: less time, more memory [s], [B].

    Parameters
    ----------
    cost, workers : Of one core; processes, None: one for each core.
    """
    count = cores() if workers is None else workers
    return replace(cost, seconds=cost.seconds / count, memory_bytes=cost.memory_bytes * count)


def gigabytes_text(memory_bytes: float) -> str:
    """Return a size of memory [GB] in words.

    Parameters
    ----------
    memory_bytes : Size [B].
    """
    return f"{memory_bytes / 1e9:.2g} GB"


def counted(number: float, name: str) -> str:
    """Return a number of things in words.

    Parameters
    ----------
    number, name : How many [-], and the name of one of them.
    """
    return f"{number:.6g} {name}{'' if number == 1 else 's'}"


def duration_text(seconds: float) -> str:
    """Return a time as people say it.

    Parameters
    ----------
    seconds : Time [s].
    """
    for size, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.1f} {unit}"
    return f"{seconds:.2g} s"


def sweep_cost(study: Study, *, room_spacing_m: float, room_azimuths: int) -> Cost:
    """Return what scoring every combination of the study's sweep takes, each as its own reader.

    Parameters
    ----------
    study, room_spacing_m, room_azimuths : As in `scoring_cost` [m].
    """
    cells = math.prod(float(len(values)) for values in expanded(study.sweep).values())
    scored = scoring_cost(study, room_spacing_m=room_spacing_m, room_azimuths=room_azimuths)
    return reader_cost(study).and_then(scored).times(cells, "cells", "sweep")
