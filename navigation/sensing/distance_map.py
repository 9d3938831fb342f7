"""The distance-RSS map of thesis 5.2.2.1, and what it says about an earlier orientation (Fig. 5.2).

The thesis names the map to do without it: its navigator compares antennas instead. Here it can be
held against the truth, in the room in which the robot drives.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.sensing.sensor import PowerLink

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class DistanceMap:
    """Distance along the floor from the tag's point by the RSS of all antennas together.

    A vertical dipole on the ceiling sends nothing down: the RSS grows from the point under the tag
    to a maximum some metres off (about one and a half times the tag's height above the reader),
    then falls. One reading has two distances; the map knows the nearer one, so that farther places
    are taken for near ones. Reflections bend it anywhere.

    Parameters
    ----------
    distances_m : (d,) float64 — Distances along the floor, growing [m].
    rss_w : (d,) float64 — Sum over the antennas there, growing [W].
    """

    distances_m: FloatArray
    rss_w: FloatArray

    def __post_init__(self) -> None:
        for name in ("distances_m", "rss_w"):
            array = frozen_array(
                getattr(self, name), name=name, shape=(None,), error=NavigationError
            )
            object.__setattr__(self, name, array)
            if array.size < 2 or not (np.diff(array) > 0.0).all():
                msg = f"{name} of a distance-RSS map must grow, from at least two values on."
                raise NavigationError(msg)

    def distance_m(self, rss_w: npt.ArrayLike) -> FloatArray:
        """Return the distances (...,) along the floor [m]; NaN above the map's greatest RSS.

        Parameters
        ----------
        rss_w : (..., n) float64 — Readings of all antennas [W].
        """
        total = np.asarray(rss_w, dtype=np.float64).sum(axis=-1)
        found = np.interp(total, self.rss_w, self.distances_m, right=np.nan)
        return np.asarray(np.where(total > 0.0, found, np.nan))


def distance_map(
    link: PowerLink, *, reach_m: float, spacing_m: float = 0.02, headings: int = 16
) -> DistanceMap:
    """Return the map of a tag that hangs over (0, 0): mean over the robot's headings.

    Parameters
    ----------
    link : Of that tag to the reader in free space.
    reach_m, spacing_m : Greatest distance and step [m].
    headings : Number of headings, evenly over the circle.
    """
    away = np.arange(0.0, reach_m + 0.5 * spacing_m, spacing_m)
    turns = 2.0 * np.pi * np.arange(headings) / headings
    poses = np.zeros((away.size, headings, 3))
    poses[:, :, 0], poses[:, :, 2] = away[:, None], turns
    rss = link.rss_w(poses.reshape(-1, 3)).sum(axis=1).reshape(away.size, headings).mean(axis=1)
    rising = np.maximum.accumulate(rss)
    keep = np.concatenate([[True], rss[1:] > rising[:-1]])
    if int(keep.sum()) < 2:
        msg = (
            "the RSS of the tag is greatest right under it, so that it tells no distance by a map "
            "that grows: use tags with a null below them, such as dipoles."
        )
        raise NavigationError(msg)
    return DistanceMap(distances_m=away[keep], rss_w=rss[keep])


def propagated_error_rad(
    old_m: npt.ArrayLike, new_m: npt.ArrayLike, seen_rad: npt.ArrayLike
) -> FloatArray:
    """Return by how far a straight move missed the tag's direction, thesis 5.2.2.1 [rad].

    The law of sines in the triangle of both places and the tag's point: sin of the old error is
    new over old distance times sin of the new angle. NaN where no such triangle is. Between -90°
    and 90°: of a move away from the tag the sine says the supplement. The thesis prints the
    distances along the floor as √(d̂² - h²) and the angle at the new place once with a π, which the
    sine drops.

    Parameters
    ----------
    old_m, new_m : (...) float64 — Distances along the floor before and after the move [m].
    seen_rad : (...) float64 — Direction of the tag after it, from the direction of the move [rad].
    """
    old, new = np.asarray(old_m, dtype=np.float64), np.asarray(new_m, dtype=np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        sine = new / old * np.sin(seen_rad)
        return np.asarray(np.where(np.abs(sine) <= 1.0, np.arcsin(sine), np.nan))
