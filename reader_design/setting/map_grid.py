"""The grid of a study's radio maps."""

import math

import numpy as np
import numpy.typing as npt

from octant.em.power.radio_map import grid_axis_m
from octant.geometries.errors import ConfigError
from octant.reader_design.setting.setting import Setting

FloatArray = npt.NDArray[np.float64]

LARGEST_MAP = 100_000_000
"""Values that a map may hold [-]: 0.8 GB."""


def map_axes_m(setting: Setting) -> tuple[FloatArray, FloatArray]:
    """Return x and y of a study's map grid, cell centres [m]; refuse more than `LARGEST_MAP`.

    Parameters
    ----------
    setting : The room, whose ``map.spacing_m`` is the greatest distance between neighbours; in free
        space the grid spans tags, start and objects and reaches ``map.margin_m`` beyond.
    """
    study, scene = setting.study, setting.scene
    if scene.has_room:
        low, high = scene.bounds_m[0, :2], scene.bounds_m[1, :2]
    else:
        points = [tag.point_m for tag in setting.tags]
        points += [np.array(study.mission.start_m)] if study.mission else []
        points += list(scene.bounds_m[:, :2]) if scene.bodies else []
        low = np.min(points, axis=0) - study.map.margin_m
        high = np.max(points, axis=0) + study.map.margin_m
    spacing = study.map.spacing_m
    cells = float(np.prod(np.maximum((high - low) / spacing, 1.0)))
    if cells > LARGEST_MAP:
        msg = (
            f"map.spacing_m is {spacing:g} m, which makes {cells:.3g} receivers in this room; "
            f"choose at least {math.sqrt(float(np.prod(high - low)) / 1e6):.2g} m."
        )
        raise ConfigError(msg)
    return (
        grid_axis_m(float(low[0]), float(high[0]), spacing_m=spacing),
        grid_axis_m(float(low[1]), float(high[1]), spacing_m=spacing),
    )
