"""What a docking mission takes place in, and where missions start."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.docking_task import Blocked
from octant.navigation.landmark_sensor import LandmarkSensor
from octant.navigation.robot import DifferentialDrive
from octant.navigation.sensing import Sensor

FloatArray = npt.NDArray[np.float64]

_START_DRAWS = 1000


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


@dataclass(frozen=True, slots=True, kw_only=True)
class StartArea:
    """Return where missions may start; a start is drawn until the robot fits.

    Parameters
    ----------
    low_m, high_m : (2,) float64
        Corners of a rectangle on the floor [m].
    fits : callable
        (m, 2) points [m] -> (m,) bool: where the robot can stand.

    Raises
    ------
    NavigationError
        When the rectangle is empty.
    """

    low_m: FloatArray
    high_m: FloatArray
    fits: Blocked

    def __post_init__(self) -> None:
        for name in ("low_m", "high_m"):
            corner = frozen_array(getattr(self, name), name=name, shape=(2,), error=NavigationError)
            object.__setattr__(self, name, corner)
        if not (self.low_m < self.high_m).all():
            msg = (
                f"the starts lie between {self.low_m.tolist()} and {self.high_m.tolist()} m, but "
                "the first corner must be the lower one: exchange them."
            )
            raise NavigationError(msg)

    def draw(self, rng: np.random.Generator) -> FloatArray:
        """Return a random start.

        Parameters
        ----------
        rng : numpy.random.Generator
            Source of the start.

        Returns
        -------
        (3,) float64
            x [m], y [m], heading [rad], uniform over the free part of the area.

        Raises
        ------
        NavigationError
            When the robot fits nowhere.
        """
        for _ in range(_START_DRAWS):
            point = rng.uniform(self.low_m, self.high_m)
            if bool(self.fits(point[None])[0]):
                return np.array([*point, rng.uniform(-np.pi, np.pi)])
        msg = (
            f"the robot found no room between {self.low_m.tolist()} and {self.high_m.tolist()} m "
            f"in {_START_DRAWS} draws: widen the area of the starts."
        )
        raise NavigationError(msg)
