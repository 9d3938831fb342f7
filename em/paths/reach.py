"""Images near a place: of a robot that drives, most images of a tag cannot have a path to it.

What rejects an image does not change from one step to the next. So space is divided into cells, and
the first time that a receiver is in one, those images are kept that can have a path to any point of
it: exactly, by the same planes and facets as the search for paths, which the others cannot change.
"""

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from octant.em.paths import _reach_kernels
from octant.em.records import SceneArrays, TreeArrays

CELLS_M = (0.5, 2.0)
"""Sides of the cells [m]: the small ones are sought among the images of the large ones."""

MOST_CELLS = 4096
"""Cells [-] that are kept; then all are forgotten, so that a long drive does not fill the memory.
"""


@dataclass(frozen=True, slots=True)
class CellImages:
    """The images of one source that can have a path into a cell of space.

    Parameters
    ----------
    scene, tree : The scene, and all images of a source in it.
    """

    scene: SceneArrays
    tree: TreeArrays
    _cells: dict[tuple[int, int, int, float], TreeArrays] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    def at(self, place_m: npt.NDArray[np.float64]) -> TreeArrays:
        """Return the tree for one receiver, to be searched for those images alone.

        Parameters
        ----------
        place_m : (3,) float64 — Place of the receiver [m].
        """
        x, y, z = place_m.tolist()
        return self._cell(0, x, y, z)

    def _cell(self, level: int, x: float, y: float, z: float) -> TreeArrays:
        if level == len(CELLS_M):
            return self.tree
        side = CELLS_M[level]
        i, j = math.floor(x / side), math.floor(y / side)
        near = self._cells.get((level, i, j, z))
        if near is None:
            wide = self._cell(level + 1, x, y, z)
            place = float(i) * side, float(j) * side, z
            leaves = _reach_kernels.leaves_of_square(self.scene, wide, *place, side)
            leaves.flags.writeable = False
            near = wide._replace(leaves=leaves)
            if len(self._cells) >= MOST_CELLS:
                self._cells.clear()
            self._cells[level, i, j, z] = near
        return near
