"""Sliding-mode tracking, with which thesis 7.6.5 compares: a law on reference velocities."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.navigation.angles import wrap_angle
from octant.navigation.checks import check_positive
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.tracking.trajectories import DesiredTrajectory

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class SlidingModeControl:
    """Tracking on two sliding surfaces, s1 = x_e and s2 = θ_e + arctan(c v_r y_e).

    The thesis compares in words with Lee et al. (2009), whose law it does not print. This is the
    usual sliding mode of a unicycle's kinematics with the same inputs, the reference velocities:
    x_e, y_e, θ_e are the errors in the robot's frame, and each surface is approached by ṡ = -k
    sat(s / δ). On both surfaces ẏ_e = -v_r sin(arctan(c v_r y_e)), so that y_e decays. A desired
    pose that rests has no direction of y_e to steer by: it is not stabilised, as the thesis says of
    such laws.

    Parameters
    ----------
    desired : What to follow, sampled at the control period.
    robot : Wheels and axle.
    along_m_per_s, turn_rad_per_s : k of the surfaces [m/s], [rad/s].
    along_layer_m, turn_layer_rad : δ of the surfaces, within which the law is linear [m], [rad].
    approach_s_per_m2 : c, how steeply the robot heads for the trajectory [s/m²].
    """

    desired: DesiredTrajectory
    robot: DifferentialDrive
    along_m_per_s: float = 0.3
    turn_rad_per_s: float = 1.5
    along_layer_m: float = 0.3
    turn_layer_rad: float = 0.5
    approach_s_per_m2: float = 5.0

    def __post_init__(self) -> None:
        for name, unit in (
            ("along_m_per_s", "m/s"),
            ("turn_rad_per_s", "rad/s"),
            ("along_layer_m", "m"),
            ("turn_layer_rad", "rad"),
            ("approach_s_per_m2", "s/m²"),
        ):
            check_positive(getattr(self, name), name=name, unit=unit)

    def surfaces(self, step: int, poses: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return x_e (r,) [m], y_e (r,) [m] and s2 (r,) [rad]; s1 is x_e.

        Parameters
        ----------
        step : Number of the period.
        poses : (r, 3) float64 — x [m], y [m], heading [rad].
        """
        offset = self.desired.poses[step] - poses
        cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        ahead = cos * offset[:, 0] + sin * offset[:, 1]
        aside = cos * offset[:, 1] - sin * offset[:, 0]
        steep = self.approach_s_per_m2 * self.desired.speed_m_per_s[step]
        return ahead, aside, wrap_angle(offset[:, 2]) + np.arctan(steep * aside)

    def wheel_rates(self, step: int, poses: FloatArray, rss_dbm: FloatArray) -> FloatArray:
        """Return the rates of a period, (r, 2) [rad/s]."""
        del rss_dbm
        speed, turn = self.desired.speed_m_per_s[step], self.desired.turn_rate_rad_per_s[step]
        after = min(step + 1, self.desired.steps)
        rise = (self.desired.speed_m_per_s[after] - speed) / self.desired.period_s
        ahead, aside, surface = self.surfaces(step, poses)
        heading = wrap_angle(self.desired.poses[step, 2] - poses[:, 2])
        steep = self.approach_s_per_m2 * speed
        flat = 1.0 / (1.0 + (steep * aside) ** 2)
        by_aside, by_speed = steep * flat, self.approach_s_per_m2 * aside * flat
        wanted = turn + by_speed * rise + by_aside * speed * np.sin(heading)
        wanted = wanted + self.turn_rad_per_s * np.clip(surface / self.turn_layer_rad, -1.0, 1.0)
        # Far ahead of the robot the surface turns with it: its slope must not change sign.
        rate = wanted / np.maximum(1.0 + by_aside * ahead, 0.2)
        reach = self.along_m_per_s * np.clip(ahead / self.along_layer_m, -1.0, 1.0)
        forward = rate * aside + speed * np.cos(heading) + reach
        return self.robot.wheel_rates(speed_m_per_s=forward, turn_rate_rad_per_s=rate)
