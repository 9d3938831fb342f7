"""The study's robot, and where it can stand among the walls and objects of a room."""

import math
from typing import Literal

import numpy as np
import numpy.typing as npt

from octant.geometries.scene import Scene
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.floor import RobotSpace, footprint
from octant.navigation.robot.kinematics import CarDrive, SynchroDrive
from octant.navigation.robot.odometry import Rolling
from octant.navigation.robot.robot import Robot
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.robot import SAME_KEYS
from octant.reader_design.study_file.schema import Study

FloatArray = npt.NDArray[np.float64]

PLACES_M = 0.25
"""Spacing of the places that are proposed in place of one that will not do [m]."""

Driver = Literal["mission", "dock", "track"]
"""The table of the verb that drives."""

_SCOUT = DifferentialDrive()
_PRESETS: dict[str | None, dict[str, float]] = {
    None: {},
    "scout": {"radius_m": 0.19, "max_wheel_rate_rad_per_s": _SCOUT.max_wheel_rate_rad_per_s},
    "sputnik": {
        "axle_m": 0.26,
        "radius_m": 0.17,
        "max_wheel_rate_rad_per_s": _SCOUT.max_wheel_rate_rad_per_s,
    },
}
_OWN: dict[Driver, dict[str, float]] = {
    "mission": {"radius_m": 0.15, "height_m": 0.4},
    "dock": {
        "radius_m": 0.2,
        "height_m": 0.8,
        "linear_slip_m_per_s": -0.01,
        "angular_slip_deg_per_s": 0.5,
    },
    "track": {"radius_m": 0.15, "height_m": 0.4},
}
_TURN_RATE_DEG_PER_S = 90.0


def study_robot(
    study: Study,
    driver: Driver,
    *,
    wheel_rate_rad_per_s: float | None = None,
    usual_rate_rad_per_s: float | None = None,
) -> Robot:
    """Return the robot of a study: table ``[robot]``, the verb's own keys, preset and defaults.

    Parameters
    ----------
    study : With the table of the verb that drives [m], [deg], [s].
    driver : That table's name.
    wheel_rate_rad_per_s : Limit of the wheels that the verb's own table gives [rad/s], or None.
    usual_rate_rad_per_s : Limit where neither tables nor preset have one [rad/s]; None: the
        Scout's.
    """
    table, own = study.robot, getattr(study, driver)
    preset, defaults = _PRESETS[table.preset], _OWN[driver]
    older = {
        new: old for old, new in SAME_KEYS[driver].items() if not old.endswith("rate_rad_per_s")
    }

    def value(key: str, otherwise: float) -> float:
        for given in (getattr(table, key), getattr(own, older.get(key, ""), None)):
            if given is not None:
                return float(given)
        return preset.get(key, defaults.get(key, otherwise))

    radius_m = value("wheel_radius_m", _SCOUT.wheel_radius_m)
    rate = table.max_wheel_rate_rad_per_s or wheel_rate_rad_per_s
    rate = rate or preset.get("max_wheel_rate_rad_per_s") or usual_rate_rad_per_s
    # The Scout's limit is that of its rims: with its own wheels to the last bit.
    speed = _SCOUT.max_wheel_speed_m_per_s if rate is None else rate * radius_m
    counts = value("encoder_counts", 0.0)
    return Robot(
        drive=_drive(study, radius_m, value("axle_m", _SCOUT.axle_length_m), speed),
        rolling=Rolling(
            slip_sd=value("wheel_slip", 0.0),
            scale_sd=value("wheel_scale", 0.0),
            tick_rad=2.0 * math.pi / counts if counts else 0.0,
            acceleration_rad_per_s2=table.wheel_acceleration_rad_per_s2,
            dead_band_rad_per_s=table.dead_band_rad_per_s,
            linear_m_per_s=value("linear_slip_m_per_s", 0.0),
            angular_rad_per_s=math.radians(value("angular_slip_deg_per_s", 0.0)),
        ),
        radius_m=value("radius_m", 0.15),
        height_m=value("height_m", 0.4),
        odometry=table.odometry,
    )


def _drive(study: Study, radius_m: float, axle_m: float, speed: float) -> DifferentialDrive:
    table = study.robot
    if table.kinematics == "synchro":
        turn = table.turn_acceleration_deg_per_s2
        return SynchroDrive(
            wheel_radius_m=radius_m,
            max_wheel_speed_m_per_s=speed,
            turn_rate_limit_rad_per_s=math.radians(
                table.max_turn_rate_deg_per_s or _TURN_RATE_DEG_PER_S
            ),
            turn_acceleration_rad_per_s2=None if turn is None else math.radians(turn),
        )
    if table.wheelbase_m is not None and table.steering_limit_deg is not None:
        return CarDrive(
            wheel_radius_m=radius_m,
            axle_length_m=axle_m,
            max_wheel_speed_m_per_s=speed,
            wheelbase_m=table.wheelbase_m,
            steering_limit_rad=math.radians(table.steering_limit_deg),
        )
    return DifferentialDrive(
        wheel_radius_m=radius_m, axle_length_m=axle_m, max_wheel_speed_m_per_s=speed
    )


def robot_space(scene: Scene, reader: Reader, *, radius_m: float, height_m: float) -> RobotSpace:
    """Return where a robot with the reader on top can stand in a room.

    Parameters
    ----------
    scene : The room [m].
    reader : The table ``[reader]``: its ground plane counts where it reaches beyond the robot.
    radius_m, height_m : The robot's round body [m].
    """
    radius_m = max(radius_m, 0.5 * reader.ground_plane_m)
    height_m = max(height_m, reader.height_m)
    return RobotSpace(
        footprint=footprint(scene, radius_m=radius_m, height_m=height_m),
        scene=scene,
        height_m=height_m,
    )


def mission_space(study: Study, scene: Scene) -> RobotSpace:
    """Return where the robot of a study's mission can stand in a room.

    Parameters
    ----------
    study, scene : A study with a mission; one of its rooms [m].
    """
    robot = study_robot(study, "mission")
    return robot_space(scene, study.reader, radius_m=robot.radius_m, height_m=robot.height_m)


def floor_places_m(scene: Scene, near_m: npt.ArrayLike) -> FloatArray:
    """Return (p, 2) places on whole `PLACES_M` over the bounds of a room, the nearest first [m].

    Parameters
    ----------
    scene : The room.
    near_m : (2,) array_like — What they should be near [m].
    """
    axes = [
        PLACES_M * np.arange(np.ceil(low / PLACES_M), np.floor(high / PLACES_M) + 1.0)
        for low, high in scene.bounds_m[:, :2].T
    ]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    order = np.argsort(np.hypot(*(places - np.asarray(near_m)).T), kind="stable")
    return places[order] + 0.0


def free_place_m(
    space: RobotSpace, near_m: npt.ArrayLike, *, clear_m: float = 0.0
) -> tuple[float, float] | None:
    """Return the nearest of `floor_places_m` where the robot can stand [m]; None: nowhere.

    Parameters
    ----------
    space, near_m : Where it can stand; (2,) array_like — what it should be near [m].
    clear_m : Least distance between the robot and anything [m].
    """
    places = floor_places_m(space.scene, near_m)
    free = places[space.footprint.clearance_m(places) >= clear_m]
    free = free[space(free)]
    return (float(free[0, 0]), float(free[0, 1])) if len(free) else None
