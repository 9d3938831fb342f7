"""Missions among objects that stand elsewhere in every placement, drawn by the study's seed."""

from collections.abc import Callable, Iterator, Sequence

import msgspec
import numpy as np

from octant.em.antennas.embedded import ReaderResponse
from octant.geometries.errors import ConfigError, GeometryError
from octant.navigation.missions.records import MissionResult
from octant.reader_design.experiments.missions.drives import drive_missions, mission_space
from octant.reader_design.setting.links import mission_table
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.study_file.room import RoomObject
from octant.reader_design.study_file.schema import Layout, Study

_DRAWS = 100


def placed(study: Study, layout: Layout | None, rng: np.random.Generator) -> tuple[Study, Setting]:
    """Return a study whose objects stand at random places near their own, and its room.

    Parameters
    ----------
    study : Study
        With a mission; its ``placement_m`` says how far objects move along x and y [m].
    layout : Layout or None
        Room to be driven in; None: the study's own. Only the layout's own objects move then.
    rng : numpy.random.Generator
        Source of the places.

    Returns
    -------
    study : Study
        With the moved objects.
    built : Setting
        The room [m], drawn until the robot fits at its start and under every tag.
    """
    table = mission_table(study)
    ways = [table.start_m, *(t.position_m[:2] for t in study.tags if t.id in table.tags)]
    for _ in range(_DRAWS):
        if layout is None:
            objects = _moved(study.room.objects, table.placement_m, rng)
            room = msgspec.structs.replace(study.room, objects=objects)
            moved, there = msgspec.structs.replace(study, room=room), None
        else:
            objects = _moved(layout.objects, table.placement_m, rng)
            moved, there = study, msgspec.structs.replace(layout, objects=objects)
        try:
            built = build_setting(moved, there)
        except (ConfigError, GeometryError):
            continue
        if bool(mission_space(moved, built)(np.array(ways)).all()):
            return moved, built
    msg = (
        f"mission.placement_m is {table.placement_m:g} m, but in {_DRAWS} draws the objects always "
        "covered the start or a tag's point; move them less, or start them farther off."
    )
    raise ConfigError(msg)


def first_placement(study: Study, layout: Layout | None, *, runs: int) -> Setting:
    """Return the room in which `drive_placements` drives run 0 [m].

    Parameters
    ----------
    study : Study
        With a mission.
    layout : Layout or None
        Room to be driven in; None: the study's own.
    runs : int
        Number of runs in all.
    """
    _, child = next(_shares(study, runs))
    return placed(study, layout, np.random.default_rng(child))[1]


def drive_placements(
    study: Study,
    layout: Layout | None,
    responses: Sequence[ReaderResponse],
    *,
    runs: int | None = None,
    noise_db: float | None = None,
    workers: int = 1,
    progress: Callable[[int], object] | None = None,
) -> tuple[tuple[MissionResult, ...], Setting]:
    """Return the runs of a study's mission, shared evenly by its placements of the objects.

    Parameters
    ----------
    study : Study
        With a mission.
    layout : Layout or None
        Room to be driven in; None: the study's own.
    responses : sequence of ReaderResponse
        The reader's, one for each of ``study.radio.frequencies_hz``.
    runs : int or None
        Number of runs in all; None: the study's.
    noise_db : float or None
        Noise of each reading [dB]; None: the study's.
    workers : int
        Processes that share the runs; the results are the same to the bit.
    progress : callable or None
        Called with the number of finished runs.

    Returns
    -------
    results : tuple of MissionResult
        The runs of placement 0 first.
    first : Setting
        The room of placement 0 [m].
    """
    table = mission_table(study)
    total = table.runs if runs is None else runs
    results: list[MissionResult] = []
    rooms: list[Setting] = []

    def report(finished: int) -> None:
        if progress is not None:
            progress(before + finished)

    for share, child in _shares(study, total):
        moved, built = placed(study, layout, np.random.default_rng(child))
        rooms.append(built)
        before = len(results)
        results += drive_missions(
            moved,
            built,
            responses,
            runs=share,
            noise_db=noise_db,
            seed=int(child.generate_state(1)[0]),
            workers=workers,
            progress=report,
        )
    return tuple(results), rooms[0]


def _shares(study: Study, total: int) -> Iterator[tuple[int, np.random.SeedSequence]]:
    """Yield the number of runs and the seed of each placement that gets any."""
    count = mission_table(study).placements
    for number, child in enumerate(np.random.SeedSequence(study.seed).spawn(count)):
        share = total * (number + 1) // count - total * number // count
        if share:
            yield share, child


def _moved(
    objects: tuple[RoomObject, ...], reach_m: float, rng: np.random.Generator
) -> tuple[RoomObject, ...]:
    moved = []
    for thing in objects:
        dx, dy = rng.uniform(-reach_m, reach_m, 2)
        x, y, z = thing.position_m
        moved.append(msgspec.structs.replace(thing, position_m=(float(x + dx), float(y + dy), z)))
    return tuple(moved)
