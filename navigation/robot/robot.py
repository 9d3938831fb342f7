"""A robot: what drives it, how its wheels roll, and the room it takes."""

from dataclasses import dataclass, field

from octant.navigation.checks import check_positive
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.motion import Integration
from octant.navigation.robot.odometry import Rolling


@dataclass(frozen=True, slots=True, kw_only=True)
class Robot:
    """A robot of any kinematics, as missions, tracking and docking drive it.

    Parameters
    ----------
    drive : Wheels, axle, limits and kinematics: what a command makes of speed and turn rate.
    rolling : Motors, slip and encoders: what the world makes of it.
    radius_m, height_m : Its round body, which collides [m].
    odometry : {"euler", "rk2", "exact"} or None — How odometry adds up a period; None: as each
        estimator does by itself, exact, and "rk2" for the particles of the tracker.
    """

    drive: DifferentialDrive = field(default_factory=DifferentialDrive)
    rolling: Rolling = field(default_factory=Rolling)
    radius_m: float = 0.15
    height_m: float = 0.4
    odometry: Integration | None = None

    def __post_init__(self) -> None:
        check_positive(self.radius_m, name="radius_m", unit="m")
        check_positive(self.height_m, name="height_m", unit="m")
