"""The table ``[robot]`` of a study: the robot that missions, tracking and docking drive."""

from typing import Literal

from octant.geometries.errors import ConfigError
from octant.reader_design.study_file.quantities import (
    Count,
    Distance,
    Share,
    SpeedError,
    SteeringLimit,
    TurnAcceleration,
    TurnRate,
    TurnRateError,
    WheelAcceleration,
    WheelRate,
    WheelRateDeviation,
)
from octant.reader_design.study_file.room import Table


class Robot(Table, frozen=True, kw_only=True):
    """The robot: table ``[robot]``, for missions, `octant track` and `octant dock` alike.

    What is not given here is as in the preset; without a preset it is the Scout of thesis 3.3.3,
    with the body, the slips and the wheels' limits that each verb's own table names. A key that
    stands in such a table too ([mission], [dock], [track]) must not say something else there.

    Parameters
    ----------
    preset : ``scout``: wheels of radius 8.25 cm, 30 cm apart, rims up to 0.75 m/s and so 9.09
        rad/s, a body of radius 19 cm (thesis 3.3.3); ``sputnik``: the same with wheels 26 cm apart
        (7.6.2) and, as its body is not printed, the Scout's overhang of 4 cm: radius 17 cm.
    kinematics : ``differential``: two wheels with a motor each; ``car``: driven rear wheels and
        steered front wheels, which cannot turn on the spot and drives an arc of its least radius
        instead; ``synchro``: all wheels roll and steer together, by a motor each, and the body does
        not turn: the reader stands on the turret, whose front is where the wheels roll.
    wheel_radius_m : Radius of the driven wheels [m].
    axle_m : Distance of the driven wheels [m]; not for ``synchro``.
    wheelbase_m : Distance of a car's axles [m].
    steering_limit_deg : Greatest steering angle of its front wheels [deg]; its least radius is
        wheelbase_m / tan(steering_limit_deg).
    max_wheel_rate_rad_per_s : Greatest rate of a wheel [rad/s].
    max_turn_rate_deg_per_s : Greatest rate of the steering of ``synchro`` [deg/s]; None: 90.
    wheel_acceleration_rad_per_s2 : Greatest acceleration of a wheel [rad/s²]; None: at once.
    turn_acceleration_deg_per_s2 : Of the steering of ``synchro`` [deg/s²]; None: at once.
    dead_band_rad_per_s : A wheel does not turn on commands below this rate [rad/s].
    encoder_counts : Counts of an encoder in a turn of the wheel; None: exact, and in `octant track`
        the estimators receive the commands.
    odometry : How odometry adds up a period's motion: ``euler`` along the heading at its begin,
        ``rk2`` along the mean heading, ``exact`` on the arc, textbook (11.83)-(11.85); None: exact,
        and ``rk2`` for the particles of the mission's tracker, whose own spread is wider.
    wheel_slip : Standard deviation of each wheel's slip in a period, as a share of its rotation.
    wheel_scale : The same, constant over a run [-].
    linear_slip_m_per_s : How much faster the robot drives than its wheels roll, while it moves
        [m/s].
    angular_slip_deg_per_s : How much faster it turns [deg/s].
    radius_m, height_m : The round body that collides, on missions and docking [m].
    """

    preset: Literal["scout", "sputnik"] | None = None
    kinematics: Literal["differential", "car", "synchro"] = "differential"
    wheel_radius_m: Distance | None = None
    axle_m: Distance | None = None
    wheelbase_m: Distance | None = None
    steering_limit_deg: SteeringLimit | None = None
    max_wheel_rate_rad_per_s: WheelRate | None = None
    max_turn_rate_deg_per_s: TurnRate | None = None
    wheel_acceleration_rad_per_s2: WheelAcceleration | None = None
    turn_acceleration_deg_per_s2: TurnAcceleration | None = None
    dead_band_rad_per_s: WheelRateDeviation = 0.0
    encoder_counts: Count | None = None
    odometry: Literal["euler", "rk2", "exact"] | None = None
    wheel_slip: Share | None = None
    wheel_scale: Share | None = None
    linear_slip_m_per_s: SpeedError | None = None
    angular_slip_deg_per_s: TurnRateError | None = None
    radius_m: Distance | None = None
    height_m: Distance | None = None


SAME_KEYS = {
    "mission": {
        "robot_radius_m": "radius_m",
        "robot_height_m": "height_m",
        "wheel_slip": "wheel_slip",
        "wheel_scale": "wheel_scale",
        "encoder_counts": "encoder_counts",
    },
    "dock": {
        "robot_radius_m": "radius_m",
        "robot_height_m": "height_m",
        "linear_slip_m_per_s": "linear_slip_m_per_s",
        "angular_slip_deg_per_s": "angular_slip_deg_per_s",
    },
    "track": {
        "encoder_counts": "encoder_counts",
        "feedback_wheel_rate_rad_per_s": "max_wheel_rate_rad_per_s",
        "wheel_rate_rad_per_s": "max_wheel_rate_rad_per_s",
    },
}
"""Keys of a verb's own table that say the same as a key of ``[robot]``, by the table."""

_ONLY = {
    "wheelbase_m": "car",
    "steering_limit_deg": "car",
    "max_turn_rate_deg_per_s": "synchro",
    "turn_acceleration_deg_per_s2": "synchro",
}


def check_robot(robot: Robot, tables: dict[str, Table | None]) -> None:
    """Refuse a robot whose keys contradict its kinematics, or another table.

    Parameters
    ----------
    robot : The table ``[robot]`` [m], [deg].
    tables : The tables of `SAME_KEYS` by name; None: the study has none.
    """
    for key, kinematics in _ONLY.items():
        given = getattr(robot, key)
        if given is not None and robot.kinematics != kinematics:
            msg = (
                f"robot.{key} is {given:g}, but only a robot of kinematics {kinematics!r} has it, "
                f"and robot.kinematics is {robot.kinematics!r}; leave it out."
            )
            raise ConfigError(msg)
        if kinematics == robot.kinematics == "car" and given is None:
            msg = (
                f"robot.kinematics is 'car', but robot.{key} is not given; give wheelbase_m and "
                "steering_limit_deg, from which its least turning radius follows."
            )
            raise ConfigError(msg)
    if robot.kinematics == "synchro" and robot.axle_m is not None:
        msg = (
            f"robot.axle_m is {robot.axle_m:g} m, but a synchro drive turns by its steering; give "
            "robot.max_turn_rate_deg_per_s instead."
        )
        raise ConfigError(msg)
    for name, keys in SAME_KEYS.items():
        for old, new in keys.items():
            there, here = getattr(tables[name], old, None), getattr(robot, new)
            if there is not None and here is not None and there != here:
                msg = (
                    f"{name}.{old} is {there:g}, but robot.{new} is {here:g}, and they say the "
                    f"same; leave {name}.{old} out."
                )
                raise ConfigError(msg)
