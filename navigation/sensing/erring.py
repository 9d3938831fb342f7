"""Links whose levels are not what they are taken for."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.sensing.sensor import PowerLink

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ErringLink:
    """A link with other levels: of the tag, and of each antenna of the reader.

    Parameters
    ----------
    link : The link without them.
    factor : (n,) float64 — Power of each antenna over the link's [-].
    """

    link: PowerLink
    factor: FloatArray

    def __post_init__(self) -> None:
        factor = frozen_array(self.factor, name="factor", shape=(None,), error=NavigationError)
        object.__setattr__(self, "factor", factor)

    def rss_w(self, poses: FloatArray) -> FloatArray:
        """Return the received power of each antenna, (m, n) [W]; zero where nothing arrives.

        Parameters
        ----------
        poses : (m, 3) float64 — x [m], y [m], heading [rad] of the robot in the room.
        """
        return self.link.rss_w(poses) * self.factor
