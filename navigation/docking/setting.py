"""What a docking mission takes place in."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.navigation.docking.task import Blocked
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.sensing.landmark_sensor import LandmarkSensor
from octant.navigation.sensing.sensor import Sensor

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class DockingSetting:
    """Return what a docking mission takes place in.

    Parameters
    ----------
    reader : Sensor or None
        The bearing-sensitive reader; None: the robot starts at the staging place.
    camera : LandmarkSensor
        The landmark's detector.
    robot : DifferentialDrive
        Wheels and limits.
    blocked : callable or None
        (m, 2) points on the floor [m] -> (m,) bool: where the robot touches something.
    """

    reader: Sensor | None
    camera: LandmarkSensor
    robot: DifferentialDrive
    blocked: Blocked | None = None
