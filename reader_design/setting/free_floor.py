"""Where the floor of a room is free, cell by cell, as occupancy maps of robots take it."""

import math

import numpy as np
import numpy.typing as npt

from octant.navigation.robot.floor import RobotSpace, footprint
from octant.reader_design.setting.setting import Setting

FloatArray = npt.NDArray[np.float64]


def free_floor(
    setting: Setting, x_m: FloatArray, y_m: FloatArray, *, height_m: float
) -> FloatArray:
    """Return where the floor is free, (nx, ny): 1 free, 0 occupied, NaN outside the room [-].

    A cell is occupied where anything up to a height touches the circle around it.

    Parameters
    ----------
    setting : The room.
    x_m, y_m : (nx,), (ny,) float64 — Cell centres, evenly spaced and rising [m].
    height_m : Up to where things count, above the floor [m].
    """
    places = np.stack(np.meshgrid(x_m, y_m, indexing="ij"), axis=-1).reshape(-1, 2)
    radius_m = 0.5 * math.hypot(*(np.diff(axis[:2]).sum() for axis in (x_m, y_m)))
    space = RobotSpace(
        footprint=footprint(setting.scene, radius_m=radius_m, height_m=height_m),
        scene=setting.scene,
        height_m=height_m,
    )
    free: FloatArray = np.where(space.outside(places), np.nan, space(places))
    return free.reshape(len(x_m), len(y_m))
