"""Surface currents of a full-wave solution as densities on its triangles, to be looked at."""

import numpy as np
import numpy.typing as npt

from octant.em.reader.fullwave.result import FullwaveResult


def current_density_a_per_m(result: FullwaveResult, antenna: int) -> npt.NDArray[np.float64]:
    """Return the size of the current density while one antenna is driven, on each triangle [A/m].

    Parameters
    ----------
    result : FullwaveResult
        Solution; triangles are those of its ``basis``.
    antenna : int
        Number of the driven antenna, from 0; the others are loaded.

    Returns
    -------
    (f,) float64
        Peak value of the mean density over each triangle, for a source of 1 W available power;
        both sides of the sheet together [A/m].
    """
    volts = np.sqrt(8.0 * result.load_ohm[antenna].real) * result.embedded_voltages_v[antenna]
    moments = np.tensordot(volts, result.samples.moments_a_m, axes=(0, 0))
    area = result.basis.areas_m2
    density = moments.reshape(len(area), -1, 3).sum(axis=1) / area[:, None]
    size: npt.NDArray[np.float64] = np.linalg.norm(density, axis=1)
    return size
