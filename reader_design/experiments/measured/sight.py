"""How readings lie to their source: distance, and walls on the straight line between."""

import numpy as np
import numpy.typing as npt

from octant.reader_design.experiments.measured.baselines import walls_crossed
from octant.reader_design.experiments.measured.observations import Observations
from octant.reader_design.experiments.measured.predict import Rows
from octant.reader_design.setting.setting import Setting


def straight_lines(
    setting: Setting, rows: Rows, observations: Observations
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Return distance [m] and faces of walls crossed [-] from source to cell, (o,) each.

    Parameters
    ----------
    setting, rows, observations : The room, the readings and their local means.
    """
    tags = np.array([setting.tags[t].position_m if t >= 0 else np.zeros(3) for t in rows.tags])
    starts = tags[observations.sources]
    ends = np.column_stack((observations.places, np.full(len(observations), setting.reader_z_m)))
    distance: npt.NDArray[np.float64] = np.linalg.norm(ends - starts, axis=1)
    return distance, walls_crossed(setting.scene, starts, ends)
