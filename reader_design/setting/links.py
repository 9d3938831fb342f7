"""A study's links: from its tags to its reader, in a room and in the open."""

import warnings
from collections.abc import Sequence

import msgspec

from octant.em.antennas.embedded import ReaderResponse
from octant.em.power.received_power import ReaderLink, reader_link
from octant.geometries.errors import ConfigError, PhysicsWarning
from octant.navigation.sensing.pattern_match import PowerTable, power_table
from octant.reader_design.setting.design import reader_responses
from octant.reader_design.setting.setting import PlacedTag, Setting, build_setting, solver_settings
from octant.reader_design.study_file.mission import Mission as MissionTable
from octant.reader_design.study_file.room import Room
from octant.reader_design.study_file.schema import Study

_ROUND = ("dipole", "monopole", "isotropic_theta")
_SIDES = 16


def study_responses(study: Study) -> tuple[ReaderResponse, ...]:
    """Return the response of a study's ``[reader]`` at each frequency; warn of what does not hold.

    Parameters
    ----------
    study : The study.
    """
    responses = reader_responses(study.reader, study.radio)
    for text in dict.fromkeys(text for response in responses for text in response.warnings):
        warnings.warn(text, PhysicsWarning, stacklevel=2)
    return responses


def tag_link(
    study: Study,
    setting: Setting,
    tag: PlacedTag,
    responses: Sequence[ReaderResponse],
    *,
    height_m: float | None = None,
) -> ReaderLink:
    """Return the link of one tag to the reader: RSS [W] for any pose, mean over the channels.

    Parameters
    ----------
    study, setting : A study and one of its rooms.
    tag : One of the room's tags.
    responses : The reader's, one for each of ``study.radio.frequencies_hz``.
    height_m : Ground plane above the floor [m]; None: the study's.
    """
    return reader_link(
        setting.radios,
        tag_position_m=tag.position_m,
        tag_antenna=tag.antennas,
        tag_power_w=study.radio.tag_power_w,
        response=responses,
        reader_height_m=study.reader.height_m if height_m is None else height_m,
        solver=solver_settings(study),
    )


def mission_table(study: Study) -> MissionTable:
    """Return the study's table ``[mission]``; refuse a study without one.

    Parameters
    ----------
    study : The study.
    """
    if study.mission is None:
        msg = "the study has no table [mission], which is needed to drive; add start_m and tags."
        raise ConfigError(msg)
    return study.mission


def open_link(
    study: Study, setting: Setting, tag_id: str, responses: Sequence[ReaderResponse]
) -> ReaderLink:
    """Return the link of a tag that hangs over (0, 0) as it does in a room, but in free space.

    Parameters
    ----------
    study : The study.
    setting : One of its rooms; only the tag's height above the floor is taken from it [m].
    tag_id : The tag.
    responses : The reader's, one for each of ``study.radio.frequencies_hz``.
    """
    table = next(tag for tag in study.tags if tag.id == tag_id)
    height_m = float(setting.tag(tag_id).position_m[2]) - setting.scene.floor_height_m
    lone = msgspec.structs.replace(
        study,
        room=Room(free_space=True),
        tags=(msgspec.structs.replace(table, position_m=(0.0, 0.0, height_m)),),
        mission=None,
        track=None,
        dock=None,
        layouts=(),
    )
    there = build_setting(lone)
    return tag_link(lone, there, there.tag(tag_id), responses)


def mission_tables(
    study: Study, setting: Setting, responses: Sequence[ReaderResponse]
) -> tuple[PowerTable, ...]:
    """Return what the robot knows of its reader, for each tag of the mission; alike ones share it.

    Parameters
    ----------
    study : With a mission.
    setting : The room; how the tags hang is taken from it, and not where.
    responses : The reader's, one for each of ``study.radio.frequencies_hz``.
    """
    made: dict[str, PowerTable] = {}
    tables = []
    for tag_id in mission_table(study).tags:
        tag = next(tag for tag in study.tags if tag.id == tag_id)
        height_m = float(setting.tag(tag_id).position_m[2]) - setting.scene.floor_height_m
        kind = repr((tag.antenna, tag.axis, tag.azimuth_deg, height_m))
        if kind not in made:
            upright = tag.antenna in _ROUND and (tag.axis is None or not any(tag.axis[:2]))
            made[kind] = power_table(
                open_link(study, setting, tag_id, responses),
                (0.0, 0.0),
                sides=1 if upright else _SIDES,
            )
        tables.append(made[kind])
    return tuple(tables)
