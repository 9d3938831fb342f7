"""RSS maps that a robot carries: a site survey, or the radio model's prediction, on a grid."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.sensing import _rss_map_kernels

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class RssMap:
    """The RSS of all tags on an evenly spaced grid of the floor.

    Parameters
    ----------
    x_m, y_m : (nx,), (ny,) float64 — Grid [m].
    rss : (nx, ny, s) float64 — RSS of every tag [dBm].
    """

    x_m: FloatArray
    y_m: FloatArray
    rss: FloatArray

    def __post_init__(self) -> None:
        for name, shape in (
            ("x_m", (None,)),
            ("y_m", (None,)),
            ("rss", (len(self.x_m), len(self.y_m), None)),
        ):
            array = frozen_array(getattr(self, name), name=name, shape=shape, error=NavigationError)
            object.__setattr__(self, name, array)
        for name in ("x_m", "y_m"):
            gaps = np.diff(getattr(self, name))
            if gaps.size == 0 or not (gaps.min() > 0.0 and np.ptp(gaps) < 1e-6 * gaps.mean()):
                msg = (
                    f"{name} of an RSS map has {gaps.size + 1} values that do not rise in even "
                    "steps: give an even grid of at least two."
                )
                raise NavigationError(msg)

    def rss_dbm(self, places_m: FloatArray) -> FloatArray:
        """Return the RSS of all tags at places, bilinear in decibels, (m, s) [dBm]."""
        places = np.ascontiguousarray(places_m, dtype=np.float64)
        out = np.empty((len(places), self.rss.shape[2]))
        _rss_map_kernels.interpolate(
            places, self.x_m[0], self.y_m[0], *self._spacing_m, self.rss, out
        )
        return out

    def slopes_db_per_m(self, places_m: FloatArray) -> FloatArray:
        """Return the slopes along x and y over one grid spacing, (m, s, 2) [dB/m]."""
        slopes = []
        for axis, spacing in enumerate(self._spacing_m):
            step = np.zeros(2)
            step[axis] = 0.5 * spacing
            rise = self.rss_dbm(places_m + step) - self.rss_dbm(places_m - step)
            slopes.append(rise / spacing)
        return np.stack(slopes, axis=-1)

    @property
    def _spacing_m(self) -> tuple[float, float]:
        return (
            float(self.x_m[-1] - self.x_m[0]) / (len(self.x_m) - 1),
            float(self.y_m[-1] - self.y_m[0]) / (len(self.y_m) - 1),
        )
