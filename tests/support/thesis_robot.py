"""The thesis' navigator for a mission, as most tests want it."""

from octant.navigation.control.controllers import FuzzyController
from octant.navigation.missions.navigators import thesis_navigator
from octant.navigation.robot.drive import DifferentialDrive


def thesis_robot(mission, sensor, controller=None, **options):
    return thesis_navigator(
        mission,
        azimuths_rad=sensor.azimuths_rad,
        controller=FuzzyController() if controller is None else controller,
        robot=DifferentialDrive(),
        **options,
    )
