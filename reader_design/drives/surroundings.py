"""What stands about a drive, and what the robot carries, from the setting that it is driven in."""

import numpy as np

from octant.em.power.radio_map import grid_axis_m
from octant.navigation.robot.robot import Robot
from octant.reader_design.drives.log import Carrier, Surroundings
from octant.reader_design.setting.free_floor import free_floor
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.rasters import Raster
from octant.reader_design.showing.scene_glb import closes_room

CELL_M = 0.05
"""Width of the cells of the occupancy grid [m], as robots' maps have it."""
MOST_CELLS = 1_000_000
"""Cells of an occupancy grid; greater rooms have wider ones [-]."""


def surroundings(setting: Setting, robot: Robot) -> Surroundings:
    """Return walls, objects and free floor of a room; in free space the objects alone.

    Parameters
    ----------
    setting, robot : The room; its height says what stands in the robot's way [m].
    """
    scene = setting.scene
    floor = None
    if scene.has_room:
        low, high = scene.bounds_m[:, :2]
        width = max(CELL_M, float(np.sqrt(np.prod(high - low) / MOST_CELLS)))
        x_m, y_m = (
            grid_axis_m(float(a), float(b), spacing_m=width) for a, b in zip(low, high, strict=True)
        )
        height_m = max(robot.height_m, setting.reader.height_m)
        floor = Raster(
            x_m=x_m,
            y_m=y_m,
            values=free_floor(setting, x_m, y_m, height_m=height_m),
            name="free floor",
            unit="1",
        )
    return Surroundings(
        bodies=scene.bodies,
        floor=floor,
        closing=frozenset(body.name for body in scene.bodies if closes_room(body, scene)),
    )


def carrier(setting: Setting, robot: Robot) -> Carrier:
    """Return the robot with the study's reader on it [m].

    Parameters
    ----------
    setting, robot : The reader, solved; the robot.
    """
    return Carrier(
        radius_m=robot.radius_m,
        height_m=robot.height_m,
        reader_height_m=setting.reader.height_m,
        antenna_radius_m=setting.reader.antenna_radius_m,
        azimuths_rad=setting.responses[0].azimuths_rad,
    )
