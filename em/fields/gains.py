"""Complex gains of traced paths between two antennas."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.fields import _field_kernels
from octant.em.medium.radio_scene import RadioScene
from octant.em.paths.tracing import scene_arrays
from octant.em.records import PathSet
from octant.em.soundness import check_power

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class PathGains:
    """The gain of each path of a :class:`PathSet` between two antennas.

    Parameters
    ----------
    gain : (k,) complex128 — Complex gain [-], free-space loss and phase included.
    length_m : (k,) float64 — Length [m].
    departure, arrival : (k, 3) float64 — Unit vectors [-] along the path, from source and receiver.
    """

    gain: npt.NDArray[np.complex128]
    length_m: FloatArray
    departure: FloatArray
    arrival: FloatArray

    @property
    def delay_s(self) -> FloatArray:
        """Delay of each path [s], (k,)."""
        return self.length_m / SPEED_OF_LIGHT_M_PER_S


def path_gains(
    radio: RadioScene, paths: PathSet, *, transmitter: Antenna, receiver: Antenna
) -> PathGains:
    """Return each path's gain F_r . T . F_t lambda / (4 pi L) e^{-jkL} [-] between two antennas.

    T carries the polarisation through every interaction; over edges 1 / L becomes 1 / sqrt(s' s (s'
    + s)). Far field: antennas and interactions should be more than a wavelength apart.

    Parameters
    ----------
    radio : Scene that the paths were traced in.
    paths : Paths.
    transmitter, receiver : Antennas at the two ends, in the room's frame; |F|^2 = gain.
    """
    k = len(paths)
    gain = np.zeros(k, dtype=np.complex128)
    directions = np.zeros((k, 2, 3))
    _field_kernels.path_gains(
        scene_arrays(radio),
        transmitter.kernel_arrays(),
        receiver.kernel_arrays(),
        paths.interactions,
        paths.vertices_m,
        paths.codes,
        gain,
        directions,
    )
    check_power(np.abs(gain) ** 2, 1.0, paths.receivers_m[paths.receiver])
    return PathGains(
        gain=gain,
        length_m=paths.length_m,
        departure=directions[:, 0],
        arrival=directions[:, 1],
    )
