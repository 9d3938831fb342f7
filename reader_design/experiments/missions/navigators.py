"""The navigator that a study's mission names."""

from collections.abc import Sequence
from typing import Any

from octant.em.antennas.embedded import ReaderResponse
from octant.geometries.errors import ConfigError
from octant.navigation.control.controllers import (
    Controller,
    FuzzyController,
    PatternController,
    VectorSumController,
)
from octant.navigation.missions.navigators import thesis_navigator, tracker_navigator
from octant.navigation.missions.records import Mission
from octant.navigation.navigators.interface import Navigator
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.sensing.pattern_match import PatternMatcher, PowerTable
from octant.reader_design.setting.links import mission_table, mission_tables
from octant.reader_design.setting.setting import Setting
from octant.reader_design.study_file.mission import Mission as MissionTable
from octant.reader_design.study_file.rules import mission_rules
from octant.reader_design.study_file.schema import Study

_WATT_PER_NANOWATT = 1e-9


def study_controller(table: MissionTable, pattern: PowerTable | None = None) -> Controller:
    """Return the controller that a mission names; its full scale in the study is in [nW].

    Parameters
    ----------
    table : Mission
        The table ``[mission]``.
    pattern : PowerTable or None
        The reader's patterns [W], for the controller ``pattern``.
    """
    gain_per_s = 0.5 / table.sample_time_s
    if table.controller == "vector_sum":
        return VectorSumController(gain_per_s=gain_per_s)
    if table.controller == "pattern":
        if pattern is None:
            msg = 'mission.controller is "pattern", which needs the reader\'s patterns; give them.'
            raise ConfigError(msg)
        return PatternController(matcher=PatternMatcher(table=pattern), gain_per_s=gain_per_s)
    return FuzzyController(
        steering_input=table.steering_input,
        full_scale_w=table.full_scale_nw * _WATT_PER_NANOWATT,
        rules=mission_rules(table),
    )


def study_navigator(
    study: Study,
    built: Setting,
    mission: Mission,
    responses: Sequence[ReaderResponse],
    *,
    robot: DifferentialDrive,
) -> Navigator[Any]:
    """Return the navigator that a study's mission names.

    Parameters
    ----------
    study : Study
        With a mission.
    built : Setting
        The room: how the tags hang is taken from it, and not where.
    mission : Mission
        From `study_mission` [m], [rad], [s].
    responses : sequence of ReaderResponse
        The reader's, one for each of ``study.radio.frequencies_hz``.
    robot : DifferentialDrive
        The robot.
    """
    table = mission_table(study)
    if table.navigator == "tracker":
        return tracker_navigator(
            mission, tables=mission_tables(study, built, responses), robot=robot
        )
    wanted = table.controller == "pattern"
    pattern = mission_tables(study, built, responses)[0] if wanted else None
    return thesis_navigator(
        mission,
        azimuths_rad=responses[0].azimuths_rad,
        controller=study_controller(table, pattern),
        robot=robot,
        rotation=table.rotation,
        rerotate_for_s=table.rerotate_for_s,
    )
