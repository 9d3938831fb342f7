"""The Pareto front of a table of scores: the rows that no other row beats."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import SweepStateError


def pareto_front(values: npt.ArrayLike, maximise: bool | Sequence[bool]) -> npt.NDArray[np.bool_]:
    """Return which rows no other row dominates: as good in every column, better in one.

    Equal rows do not dominate each other. A row with NaN is never on the front and dominates
    nothing.

    Parameters
    ----------
    values : (k, m) array_like — One row a design, one column a score, each column in a unit of its
        own [-]; infinities are numbers like others.
    maximise : Whether more is better, for all columns or one by one.

    Notes
    -----
    Taken in lexicographic order, best first, a row can only be dominated by an earlier one, and
    then also by one that is on the front: each is compared with the front so far (Kung, Luccio and
    Preparata, J. ACM 22, 1975). That takes O(k log k) and at worst O(k^2) comparisons.
    """
    table = frozen_array(
        values, name="values", shape=(None, None), error=SweepStateError, finite=False
    )
    columns = table.shape[1]
    up = np.full(columns, maximise) if isinstance(maximise, bool) else np.asarray(maximise)
    if up.shape != (columns,):
        msg = f"maximise has {up.size} entries, but there are {columns} scores; give one for each."
        raise SweepStateError(msg)
    gain = np.where(up, table, -table)
    on_front = np.zeros(len(gain), dtype=np.bool_)
    known = np.flatnonzero(~np.isnan(gain).any(axis=1))
    order = known[np.lexsort(-gain[known].T[::-1])] if columns else known
    front = np.empty((len(order), columns))
    count = 0
    for row in order:
        rivals = front[:count]
        as_good = (rivals >= gain[row]).all(axis=1)
        if not (as_good & (rivals > gain[row]).any(axis=1)).any():
            front[count] = gain[row]
            count += 1
            on_front[row] = True
    return on_front
