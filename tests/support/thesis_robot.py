"""The mission of thesis 5.4 and its navigator, as most tests want them."""

import numpy as np

from octant.navigation.control.controllers import FuzzyController
from octant.navigation.missions.navigators import thesis_navigator
from octant.navigation.missions.records import Mission
from octant.navigation.robot.drive import DifferentialDrive

THESIS_POINTS_M = {
    "0xFFF9": (2.0, 0.5),
    "0xFFF2": (3.5, 2.0),
    "0xFFF5": (2.0, 3.5),
    "0xFFF4": (4.0, 3.5),
}
"""Points under the four tags on the ceiling at 3 m, in the order of the visit. The thesis prints
the IDs with five hexadecimal digits, which are 20 bit, and calls them 16-bit: one F is dropped."""


def thesis_mission(arrivals, **options):
    return Mission(
        start_m=np.zeros(2),
        heading_rad=np.pi / 2.0,
        tag_ids=tuple(THESIS_POINTS_M),
        tag_points_m=np.array(list(THESIS_POINTS_M.values())),
        arrivals=arrivals,
        **options,
    )


def thesis_robot(mission, sensor, controller=None, **options):
    return thesis_navigator(
        mission,
        azimuths_rad=sensor.azimuths_rad,
        controller=FuzzyController() if controller is None else controller,
        robot=DifferentialDrive(),
        **options,
    )
