"""What one key of a study demands of another; a failure is a `ConfigError` with the key path."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import get_args

import msgspec

from octant.em.antennas.kinds import AntennaKind
from octant.geometries.errors import ConfigError, InfeasibleDesignError
from octant.geometries.tolerances import LENGTHS
from octant.navigation.navigators.loading import entry_point_names
from octant.reader_design.study_file.choice import Choice, Scoring
from octant.reader_design.study_file.dock import Dock
from octant.reader_design.study_file.errors import unknown_name
from octant.reader_design.study_file.log import check_log
from octant.reader_design.study_file.materials import check_material, material_label, material_specs
from octant.reader_design.study_file.mission import NAVIGATORS, Mission
from octant.reader_design.study_file.optimise import check_optimise
from octant.reader_design.study_file.reader import Reader, check_conductor
from octant.reader_design.study_file.reader_feed import check_feed
from octant.reader_design.study_file.reader_metal import check_metal
from octant.reader_design.study_file.rfid import check_rfid
from octant.reader_design.study_file.robot import check_robot
from octant.reader_design.study_file.room import Room
from octant.reader_design.study_file.room_checks import check_rooms
from octant.reader_design.study_file.rules import mission_rules
from octant.reader_design.study_file.schema import Layout, Study, Tag
from octant.reader_design.study_file.scores import SCORE_NAMES, higher_is_better, score_unit
from octant.reader_design.study_file.sensor import Sensor

TAG_ANTENNAS = get_args(AntennaKind)
"""Antennas of tags and of the ends of paths that need no file."""


def unknown_antenna(path: str, name: str) -> str:
    """Return the sentence for an antenna that is neither known nor a pattern file.

    Parameters
    ----------
    path, name : Where it is named, and what was given.
    """
    what = "antenna, and no such pattern file"
    return unknown_name(path, name, TAG_ANTENNAS, what=what)


def check_study(study: Study, *, shapes: bool = True) -> None:
    """Refuse a study whose keys contradict each other.

    Parameters
    ----------
    study : A study whose single values are already within their ranges.
    shapes : False: leave out whether the walls of rooms fit together, which building the scene
        finds out as well; it takes a hundred times as long as the rest.
    """
    check_rooms(study, shapes=shapes)
    _check_unique("layout", "name", [layout.name for layout in study.layouts])
    _check_tags(study.tags)
    _check_transmitter(study)
    check_rfid(study)
    _check_codes("scoring", study.scoring)
    _check_codes("sensor", study.sensor)
    _check_choice(study.choice, drives=study.mission is not None)
    _check_reader(study.reader)
    _check_pattern_files(study.reader)
    _check_surroundings(study.reader)
    check_conductor(study.reader)
    given = study.reader
    check_metal(
        given.bodies,
        given.ports,
        antennas=given.antennas,
        response=given.response,
        ground=given.ground,
    )
    if study.reader.line is not None:
        check_feed(study.reader.line, antennas=given.antennas, response=given.response)
    _check_sensor(study.sensor)
    check_robot(study.robot, {"mission": study.mission, "dock": study.dock, "track": study.track})
    if study.mission is not None:
        _check_mission(study.mission, study.tags)
        period_s = study.mission.sample_time_s
        _check_dwell(study, key="mission.sample_time_s", period_s=period_s)
    if study.dock is not None:
        _check_dock(study.dock, study.tags)
        _check_dwell(study, key="dock.reading_time_s", period_s=study.dock.reading_time_s)
    if study.track is not None and "reader" in study.track.chapters:
        period_s = study.track.room_reading_every_s
        _check_dwell(study, key="track.room_reading_every_s", period_s=period_s)
    if study.optimise is not None:
        check_optimise(study.optimise)
        if study.optimise.parameters.plate_profile_m and not study.reader.plate_profile_m:
            msg = (
                "optimise.parameters.plate_profile_m is given, but reader.plate_profile_m has no "
                "heights; give as many there as are to vary, such as [0.08, 0.08, 0.08]."
            )
            raise ConfigError(msg)
    if study.tolerance is not None:
        _check_tolerance(study)
    if study.log is not None:
        check_log(study.log)
    for path, spec in material_specs(study):
        check_material(path, spec, study.radio.frequencies_hz)


def _check_codes(path: str, table: Scoring | Sensor) -> None:
    if table.floor_dbm >= table.full_scale_dbm:
        msg = (
            f"{path}.floor_dbm is {table.floor_dbm:g} dBm, but the codes must rise to "
            f"{path}.full_scale_dbm = {table.full_scale_dbm:g} dBm; choose less."
        )
        raise ConfigError(msg)


def _check_choice(choice: Choice, *, drives: bool) -> None:
    if choice.by_missions and not (drives and choice.missions > 1):
        lacks = f"choice.missions is {choice.missions}" if drives else "there is no [mission]"
        msg = (
            f"choice.by_missions ranks designs by their missions, but {lacks}; give a [mission], "
            "and the number of designs that drive, 2 or more, as choice.missions."
        )
        raise ConfigError(msg)
    for i, criterion in enumerate(choice.criteria):
        given = [(key, getattr(criterion, key)) for key in ("free", "room")]
        named = [(key, name) for key, name in given if name]
        if not named:
            msg = f"choice.criterion[{i}] names no score; give free, room, or both."
            raise ConfigError(msg)
        for key, name in named:
            if name not in SCORE_NAMES:
                path = f"choice.criterion[{i}].{key}"
                raise ConfigError(unknown_name(path, name, SCORE_NAMES, what="score"))
        if len({(score_unit(n), higher_is_better(n)) for _, n in named}) > 1:
            msg = (
                f"choice.criterion[{i}] compares {criterion.free!r} in free space with "
                f"{criterion.room!r} in the room, which cannot be averaged; name like scores."
            )
            raise ConfigError(msg)


def rooms_of(study: Study, layout: Layout | None = None) -> Room:
    """Return the room of a study, or a layout's (by default the study's) with the objects of both.

    Parameters
    ----------
    study : The study.
    layout : One of its layouts; None: the study's own room.
    """
    if layout is None:
        return study.room
    room = layout.room or study.room
    return msgspec.structs.replace(room, objects=room.objects + layout.objects)


def _check_unique(table: str, key: str, names: Sequence[str]) -> None:
    for i, name in enumerate(names):
        if name in names[:i]:
            msg = (
                f"{table}[{i}].{key} is {name!r}, which {table}[{names.index(name)}] has already; "
                f"give every {table} its own {key}."
            )
            raise ConfigError(msg)


def _check_tags(tags: Sequence[Tag]) -> None:
    _check_unique("tag", "id", [tag.id for tag in tags])
    for i, tag in enumerate(tags):
        if tag.antenna not in TAG_ANTENNAS and not Path(tag.antenna).suffix:
            raise ConfigError(unknown_antenna(f"tag[{i}].antenna", tag.antenna))
        if tag.axis is not None and math.hypot(*tag.axis) == 0.0:
            msg = (
                f"tag[{i}].axis is {list(tag.axis)}, but an antenna needs a direction; "
                "write for example [0, 0, 1] for a vertical one."
            )
            raise ConfigError(msg)


def _check_transmitter(study: Study) -> None:
    if study.rfid is None:
        return
    name, axis = study.rfid.transmitter_antenna, study.rfid.transmitter_axis
    if name not in TAG_ANTENNAS and not Path(name).suffix:
        raise ConfigError(unknown_antenna("rfid.transmitter_antenna", name))
    if axis is not None and math.hypot(*axis) == 0.0:
        msg = (
            f"rfid.transmitter_axis is {list(axis)}, but an antenna needs a direction; write for "
            "example [0, 0, 1] for a vertical one."
        )
        raise ConfigError(msg)


def _check_reader(reader: Reader) -> None:
    limit_m = reader.ground_plane_m / 2.0
    if reader.antenna_radius_m > limit_m * (1.0 + LENGTHS.same_share):
        msg = (
            f"reader.antenna_radius_m is {reader.antenna_radius_m:g} m, but the antennas must "
            f"stand on the ground plane, whose half is {limit_m:g} m; choose a smaller radius or "
            "a larger reader.ground_plane_m."
        )
        raise InfeasibleDesignError(msg)


def _check_surroundings(reader: Reader) -> None:
    if reader.objects and reader.response != "fullwave":
        msg = (
            f"reader.object stands near the reader, but reader.response is {reader.response!r}, "
            'which leaves it out; set reader.response = "fullwave", or take the object away.'
        )
        raise ConfigError(msg)
    for i, item in enumerate(reader.objects):
        if material_label(item.material) not in ("pec", "metal"):
            msg = (
                f"reader.object[{i}].material is {material_label(item.material)!r}, but only a "
                'conductor may stand near the reader; write "pec" or "metal".'
            )
            raise ConfigError(msg)


def _check_pattern_files(reader: Reader) -> None:
    given = len(reader.pattern_files)
    if reader.response != "files":
        if given:
            msg = (
                f"reader.pattern_files names {given} files, but reader.response is "
                f'{reader.response!r}; set reader.response = "files", or leave the files out.'
            )
            raise ConfigError(msg)
        if reader.pattern_turn != "none":
            msg = (
                f"reader.pattern_turn is {reader.pattern_turn!r}, but reader.response is "
                f'{reader.response!r}; set reader.response = "files", or leave the turn out.'
            )
            raise ConfigError(msg)
        return
    if given != reader.antennas and not (given == 1 and reader.pattern_turn == "each"):
        msg = (
            f"reader.pattern_files names {given} files, but the reader has {reader.antennas} "
            "antennas; give one file for each, in their order, or the one of antenna 1 with "
            'reader.pattern_turn = "each".'
        )
        raise ConfigError(msg)


def _check_mission(mission: Mission, tags: Sequence[Tag]) -> None:
    known = [tag.id for tag in tags]
    own = mission.navigator
    if own not in NAVIGATORS and ":" not in own:
        names = (*NAVIGATORS, *entry_point_names())
        if own not in names:
            what = "navigator, and no class of yours as FILE.py:Class or package.module:Class"
            raise ConfigError(unknown_name("mission.navigator", own, names, what=what))
    for i, tag_id in enumerate(mission.tags):
        if tag_id not in known:
            raise ConfigError(unknown_name(f"mission.tags[{i}]", tag_id, known, what="[[tag]]"))
    if mission.max_time_s is not None and mission.max_time_s < mission.sample_time_s:
        msg = (
            f"mission.max_time_s is {mission.max_time_s:g} s, but a mission lasts at least one "
            f"sample of {mission.sample_time_s:g} s."
        )
        raise ConfigError(msg)
    mission_rules(mission)


def _check_sensor(sensor: Sensor) -> None:
    if sensor.required_snr_db is not None and sensor.bandwidth_hz is None:
        msg = (
            f"sensor.required_snr_db is {sensor.required_snr_db:g} dB, but without "
            "sensor.bandwidth_hz the receiver has no noise; give the bandwidth, or "
            "sensor.sensitivity_dbm instead."
        )
        raise ConfigError(msg)


def _check_dwell(study: Study, *, key: str, period_s: float) -> None:
    dwell_s, antennas = study.sensor.dwell_s, study.reader.antennas
    round_s = antennas * dwell_s
    if round_s > period_s * (1.0 + 1e-12):
        msg = (
            f"sensor.dwell_s is {dwell_s:g} s, so that one round of {antennas} antennas takes "
            f"{round_s:g} s, but {key} is {period_s:g} s; shorten the dwell time."
        )
        raise ConfigError(msg)


def _check_tolerance(study: Study) -> None:
    tolerance = study.tolerance
    if tolerance is None:
        return
    _check_unique("tolerance.rival", "name", [rival.name for rival in tolerance.rivals])
    if tolerance.room and study.room.free_space:
        msg = (
            "tolerance.room is true, but the study's room is free space; set it false, or give a "
            "room."
        )
        raise ConfigError(msg)
    percent = max(tolerance.permittivity_percent, tolerance.conductivity_percent)
    if percent > 0.0 and not tolerance.room:
        msg = (
            f"tolerance gives materials errors of {percent:g} %, but tolerance.room is false, so "
            "no room is scored; set tolerance.room = true, or leave the errors out."
        )
        raise ConfigError(msg)


def _check_dock(dock: Dock, tags: Sequence[Tag]) -> None:
    known = [tag.id for tag in tags]
    if dock.tag not in known:
        raise ConfigError(unknown_name("dock.tag", dock.tag, known, what="[[tag]]"))
    if dock.staging_m <= dock.stand_off_m:
        msg = (
            f"dock.staging_m is {dock.staging_m:g} m and dock.stand_off_m {dock.stand_off_m:g} m, "
            "but the robot must stage farther from the landmark than it docks; raise staging_m."
        )
        raise ConfigError(msg)
    if (dock.start_low_m is None) != (dock.start_high_m is None):
        msg = (
            "dock.start_low_m and dock.start_high_m are the two corners of one area, but only one "
            "is given; give both, or none."
        )
        raise ConfigError(msg)
    if dock.start_low_m is not None and dock.start_high_m is not None:
        for low, high in zip(dock.start_low_m, dock.start_high_m, strict=True):
            if low >= high:
                msg = (
                    f"dock.start_low_m is {list(dock.start_low_m)} m and dock.start_high_m "
                    f"{list(dock.start_high_m)} m, but the first must be the lower corner; "
                    "exchange them."
                )
                raise ConfigError(msg)
