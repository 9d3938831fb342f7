"""Pattern tables as the kernels take them: repeated beyond their ends for the cubic stencil."""

import numpy as np
import numpy.typing as npt

from octant.em.antennas._response_kernels import PAD


def padded_table(pattern: npt.NDArray[np.complex128]) -> npt.NDArray[np.complex128]:
    """Return the padded table of patterns on a uniform grid.

    Parameters
    ----------
    pattern : (n, 2, T, P) complex128
        F_theta and F_phi [-]; theta from 0 to pi, phi from 0 up to, not including, 2 pi, P even.

    Returns
    -------
    (T + 2 PAD, P + 2 PAD, n, 2) complex128
        Contiguous. Beyond a pole the grid goes on at the opposite azimuth, where both unit vectors
        point the other way.
    """
    table = np.ascontiguousarray(np.moveaxis(pattern, (0, 1), (2, 3)))
    half = table.shape[1] // 2
    opposite = -np.roll(table, half, axis=1)
    above, below = opposite[PAD:0:-1], opposite[-2 : -2 - PAD : -1]
    table = np.concatenate((above, table, below))
    return np.ascontiguousarray(np.concatenate((table[:, -PAD:], table, table[:, :PAD]), axis=1))
