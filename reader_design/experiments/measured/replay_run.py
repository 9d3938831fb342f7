"""A study and a log made ready for a replay: antennas, patterns, tags, and the estimator itself."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.geometries.errors import ConfigError, NavigationError
from octant.navigation.logs.records import NO_SOURCE, Log, of_ids
from octant.navigation.logs.rounds import Rounds, rounds_of
from octant.navigation.navigators.place_particles import LEVEL_DB
from octant.navigation.navigators.ways import occupancy
from octant.navigation.sensing.harmonic_bearing import distinct_azimuths
from octant.navigation.sensing.pattern_match import PatternMatcher, PowerTable
from octant.navigation.sensing.spin_patterns import gain_table
from octant.reader_design.experiments.measured.replay import (
    Estimator,
    Replayed,
    Said,
    bearings_said,
    check_method,
    counted,
    from_front,
    map_said,
    replayed,
    tracker_filter,
)
from octant.reader_design.experiments.measured.replay_kept import TrackerTask, kept_said
from octant.reader_design.experiments.measured.replay_patterns import gains_of_spins, read_gains
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.mapping.field_maps import mapped_tags
from octant.reader_design.mapping.pose_filter import MapStore, study_pose_filter
from octant.reader_design.setting.links import mission_reach_m, mission_tables
from octant.reader_design.setting.robot import (
    free_place_m,
    mission_space,
    robot_space,
    study_robot,
)
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.setting.solving import solved
from octant.reader_design.study_file.mission import Mission
from octant.reader_design.study_file.schema import Study

FloatArray = npt.NDArray[np.float64]

STUDY, SPIN = "study", "spin"
"""Patterns of the study's own reader; from turns on the spot in the log."""
FREE_LEVEL_SD_DB = LEVEL_DB
"""How unknown a free level is about that of `levelled` [dB]."""
_USUAL_SHARE = 0.25


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayOptions:
    """How a log is replayed.

    Parameters
    ----------
    estimator : What makes bearings or places of it.
    azimuths_rad : (n,) float64 or None — Azimuths of the log's antennas from the robot's front
        [rad]; None: those of the study's reader, or straight ahead for a single antenna.
    patterns : ``study``, ``spin`` or a file.
    window_s : Time within which readings of several antennas are of one round [s].
    combine_s : How far back readings count for a bearing [s].
    level_sd_db : How unknown the tags' level is [dB]; None: free for the tracker, see `levelled`;
        the study's for the map.
    known_start : Whether the map is told the first true pose.
    """

    estimator: Estimator
    azimuths_rad: tuple[float, ...] | None = None
    patterns: str = STUDY
    window_s: float = 0.0
    combine_s: float = 0.0
    level_sd_db: float | None = None
    known_start: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Replay:
    """A replay ready to run.

    Attributes
    ----------
    setting : The room with the log's tags as its mission's [m].
    rounds, ids : What was recorded; its sources.
    azimuths_rad : (n,) float64 — Azimuths of the antennas from the front [rad].
    gains_db : (b, n) float64 or None — Patterns that were read or found; None: the study's [dB].
    options : How.
    notes : What was supposed or left out, a sentence each.
    """

    setting: Setting
    rounds: Rounds
    ids: tuple[str, ...]
    azimuths_rad: FloatArray
    gains_db: FloatArray | None
    options: ReplayOptions
    notes: tuple[str, ...]

    @property
    def points_m(self) -> Mapping[str, FloatArray]:
        """The point of each tag on the floor, (2,) float64 [m]."""
        return {tag: self.setting.tag(tag).point_m for tag in self.ids}


def prepared(study: Study, log: Log, options: ReplayOptions) -> Replay:
    """Return a replay once log, antennas and patterns fit together; else refuse it by name.

    Parameters
    ----------
    study : From `with_log`; without a mission the log's tags are one.
    log : In the room's frame, its sources tags of the study, with rows of motion.
    options : How it is replayed.
    """
    present = np.unique(log.sources[log.sources != NO_SOURCE])
    log = of_ids(log, [log.ids[i] for i in present])
    azimuths, notes = _azimuths(study, log, options)
    try:
        rounds = rounds_of(log, antennas=len(azimuths), window_s=options.window_s)
    except NavigationError as exc:
        raise ConfigError(str(exc)) from exc
    turns = bool(np.ptp(np.cumsum(rounds.turn_rad)) > 0.1)
    check_method(
        options.estimator, antennas=len(azimuths), combine_s=options.combine_s, turns=turns
    )
    setting = build_setting(_with_mission(study, log))
    points = {tag: setting.tag(tag).point_m for tag in log.ids}
    gains = None
    if options.estimator in {"pattern", "tracker"} and options.patterns != STUDY:
        gains = (
            gains_of_spins(rounds, log.ids, points, azimuths)
            if options.patterns == SPIN
            else read_gains(Path(options.patterns), antennas=len(azimuths))
        )
    elif options.estimator in {"pattern", "tracker", "map"}:
        _check_reader(setting, azimuths, options)
    return Replay(
        setting=setting,
        rounds=rounds,
        ids=log.ids,
        azimuths_rad=azimuths,
        gains_db=gains,
        options=options,
        notes=(*notes, *rounds.notes),
    )


def run_replay(
    replay: Replay,
    folder: Path,
    *,
    progress: Progress,
    workers: int | None = 1,
    cluster: str | None = None,
) -> tuple[Replayed, ...]:
    """Return what the estimator says of a log, by tag.

    Parameters
    ----------
    replay : Ready to run.
    folder : Where field maps are kept, and what the tracker says of each tag.
    progress : Shows rounds, or tags.
    workers, cluster : Who shares the tags of the tracker, as in `map_cases`.
    """
    estimator, rounds = replay.options.estimator, replay.rounds
    if estimator == "tracker":
        said = kept_said(
            _tracker_task(replay, progress),
            folder,
            workers=workers,
            cluster=cluster,
            progress=progress,
        )
        return replayed(rounds, replay.ids, replay.points_m, said, in_room=False)
    said = _said(replay, progress, MapStore(folder=folder / "field_maps", progress=progress))
    with progress.count(len(rounds), label="rounds replayed") as done:
        return replayed(
            rounds,
            replay.ids,
            replay.points_m,
            counted(said, done),
            in_room=estimator == "map",
        )


def _said(replay: Replay, progress: Progress, store: MapStore) -> Iterator[Said]:
    options, rounds, setting = replay.options, replay.rounds, replay.setting
    if options.estimator == "map":
        setting = solved(setting, progress)
        return _map_said(replay, setting, store)
    tables = _tables(replay, progress) if options.estimator == "pattern" else {}
    return bearings_said(
        rounds,
        estimator=options.estimator,
        azimuths_rad=replay.azimuths_rad,
        matchers={source: PatternMatcher(table=table) for source, table in tables.items()},
        combine_s=options.combine_s,
    )


def _tracker_task(replay: Replay, progress: Progress) -> TrackerTask:
    tables, rounds, mission = _tables(replay, progress), replay.rounds, replay.setting.mission
    level = replay.options.level_sd_db
    if level is None:
        level, rounds = FREE_LEVEL_SD_DB, levelled(rounds, tables)
    return TrackerTask(
        rounds=rounds,
        seed=replay.setting.study.seed,
        filters=tuple(
            tracker_filter(tables[source], level_sd_db=level, trust=mission.tracker.trust)
            for source in range(len(replay.ids))
        ),
    )


def levelled(rounds: Rounds, tables: Mapping[int, PowerTable]) -> Rounds:
    """Return rounds whose levels are moved, source by source, to where its table would have them.

    That is where the median of what was heard is the table's mean at a quarter of its reach: only
    differences within a log count then, as of receivers that give no absolute level.

    Parameters
    ----------
    rounds, tables : The log's rounds; the RSS of each source for relative places [W].
    """
    rss = rounds.rss_dbm.copy()
    for source, table in tables.items():
        rows = rounds.sources == source
        heard = rss[rows][np.isfinite(rss[rows])]
        if heard.size:
            place = round(math.sqrt(_USUAL_SHARE) * (table.power_w.shape[0] - 1))
            usual_dbm = float(power_dbm(table.power_w[place].mean()))
            rss[rows] += usual_dbm - float(np.median(heard))
    return replace(rounds, rss_dbm=rss)


def _map_said(replay: Replay, setting: Setting, store: MapStore) -> Iterator[Said]:
    space = mission_space(setting.study, setting.scene)
    tags = mapped_tags(setting)
    if setting.scene.has_room:
        low, high = setting.scene.bounds_m[:, :2]
    else:
        places = np.vstack([replay.rounds.poses[:, :2], [tag.point_m for tag in tags]])
        places = places[np.isfinite(places).all(axis=1)]
        low, high = places.min(axis=0) - 1.0, places.max(axis=0) + 1.0
    pose_filter = study_pose_filter(
        setting,
        space,
        store,
        bounds_m=(low, high),
        blocked=occupancy(low, high, space),
        method="exact",
    )
    first = replay.rounds.poses[0]
    known = replay.options.known_start and bool(np.isfinite(first).all())
    if replay.options.level_sd_db is not None:
        pose_filter = replace(pose_filter, level_db=replay.options.level_sd_db)
    return map_said(
        replay.rounds,
        pose_filter,
        [tag.point_m for tag in tags],
        start=first if known else None,
        seed=setting.study.seed,
    )


def _tables(replay: Replay, progress: Progress) -> dict[int, PowerTable]:
    """Return the RSS table of each source [W]."""
    setting = replay.setting
    if replay.gains_db is None:
        found = mission_tables(solved(setting, progress))
        return dict(enumerate(found))
    reach_m = mission_reach_m(setting)
    return {
        source: gain_table(
            replay.gains_db,
            height_m=float(setting.tag(tag).position_m[2]) - setting.reader_z_m,
            reach_m=reach_m,
        )
        for source, tag in enumerate(replay.ids)
    }


def _azimuths(study: Study, log: Log, options: ReplayOptions) -> tuple[FloatArray, tuple[str, ...]]:
    """Return the antennas' azimuths from the front [rad], and what was supposed."""
    highest = int(log.antennas.max(initial=0))
    if options.azimuths_rad is not None:
        try:
            azimuths = distinct_azimuths(options.azimuths_rad)
        except NavigationError as exc:
            raise ConfigError(f"--azimuths-deg: {exc}") from exc
        if highest > len(azimuths):
            msg = (
                f"--azimuths-deg gives {len(azimuths)}, but the log has readings of antenna "
                f"{highest}; give one for each antenna, in the order of their numbers."
            )
            raise ConfigError(msg)
        return azimuths, ()
    if highest == 0:
        note = "The log's antennas have no numbers: it is taken as one antenna, facing ahead."
        return np.zeros(1), (note,)
    count = study.reader.antennas
    if highest > count:
        msg = (
            f"the log has readings of antenna {highest}, but the study's reader has {count}; say "
            "where the log's antennas stand by --azimuths-deg, or set reader.antennas."
        )
        raise ConfigError(msg)
    return from_front(2.0 * np.pi * np.arange(count) / count), ()


def _check_reader(setting: Setting, azimuths_rad: FloatArray, options: ReplayOptions) -> None:
    """Refuse the study's patterns for a robot that carries another reader."""
    count = setting.reader.antennas
    own = from_front(2.0 * np.pi * np.arange(count) / count)
    same = len(own) == len(azimuths_rad) and np.allclose(
        np.exp(1j * own), np.exp(1j * azimuths_rad), atol=1e-3
    )
    if same:
        return
    where = ", ".join(f"{math.degrees(a):.0f}" for a in azimuths_rad)
    msg = (
        f"the log's antennas stand at {where} deg from the front, but the patterns would be those "
        f"of the study's reader with {count} antennas all around; give --patterns spin or a file, "
        "or a reader like the log's."
    )
    if options.estimator == "map":
        msg = msg.replace("give --patterns spin or a file, or", "give")
    raise ConfigError(msg)


def _with_mission(study: Study, log: Log) -> Study:
    """Return the study with a mission through the log's tags, which estimators take as theirs."""
    if study.mission is not None:
        mission = msgspec.structs.replace(study.mission, tags=log.ids, navigator="map")
        return msgspec.structs.replace(study, mission=mission)
    scene = build_setting(study).scene
    places = log.poses[np.isfinite(log.poses[:, :2]).all(axis=1), :2]
    near = places[0] if len(places) else scene.bounds_m[:, :2].mean(axis=0)
    robot = study_robot(study, "mission")
    space = robot_space(scene, study.reader, radius_m=robot.radius_m, height_m=robot.height_m)
    start = (float(near[0]), float(near[1]))
    if scene.has_room:
        start = free_place_m(space, near) or start
    return msgspec.structs.replace(study, mission=Mission(start_m=start, tags=log.ids))
