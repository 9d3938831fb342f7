"""The navigators, set up for a mission."""

from collections.abc import Sequence

import numpy.typing as npt

from octant.navigation.control.controllers import Controller
from octant.navigation.missions.records import Mission
from octant.navigation.navigators.place_particles import (
    FADING_DB,
    LEVEL_DB,
    TRUST,
    PlaceFilter,
)
from octant.navigation.navigators.thesis import Rotation, ThesisNavigator
from octant.navigation.navigators.tracker import TrackerNavigator
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.motion import Integration
from octant.navigation.sensing.bearing import checked_azimuths
from octant.navigation.sensing.pattern_match import PowerTable

_ARRIVAL_SHARE = 0.4


def thesis_navigator(
    mission: Mission,
    *,
    azimuths_rad: npt.ArrayLike,
    controller: Controller,
    robot: DifferentialDrive,
    rotation: Rotation = "strongest",
    rerotate_for_s: float = 0.0,
    method: Integration = "exact",
) -> ThesisNavigator:
    """Return the thesis' navigator for a mission.

    Parameters
    ----------
    mission : Its arrival tests, cruise speed and period are used.
    azimuths_rad, controller, robot, rotation, rerotate_for_s, method : As of `ThesisNavigator`
        [rad], [s].
    """
    return ThesisNavigator(
        arrivals=mission.arrivals,
        azimuths_rad=checked_azimuths(azimuths_rad),
        controller=controller,
        robot=robot,
        cruise_speed_m_per_s=mission.cruise_speed_m_per_s,
        period_s=mission.sample_time_s,
        rotation=rotation,
        rerotate_for_s=rerotate_for_s,
        method=method,
    )


def tracker_navigator(
    mission: Mission,
    *,
    tables: Sequence[PowerTable],
    robot: DifferentialDrive,
    trust: float = TRUST,
    fading_db: float = FADING_DB,
    level_db: float = LEVEL_DB,
    method: Integration = "rk2",
) -> TrackerNavigator:
    """Return the tracking navigator for a mission.

    It declares arrival within two fifths of the mission's least arrival radius: the rest is kept
    for the estimate's error, whose table knows neither floor nor ceiling.

    Parameters
    ----------
    mission : Its arrival radius, cruise step and period are used.
    tables : The reader's patterns for each of the mission's tags, in order.
    robot : Wheels, axle and limits.
    trust, fading_db, level_db, method : As of `PlaceFilter` [dB].
    """
    return TrackerNavigator(
        filters=tuple(
            PlaceFilter(
                table=table, trust=trust, fading_db=fading_db, level_db=level_db, method=method
            )
            for table in tables
        ),
        robot=robot,
        cruise_step_m=mission.cruise_step_m,
        period_s=mission.sample_time_s,
        arrival_radius_m=_ARRIVAL_SHARE * min(test.radius_m for test in mission.arrivals),
    )
