"""The reader's patterns as the robot knows them, and the bearing that explains a reading best.

A table holds the RSS of every antenna for a tag at a relative place, with nothing else in the
world, measured once in the open or computed. It says nothing of where tags are.
"""

import math
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from octant.em.decibels import decibels
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.checks import check_positive
from octant.navigation.sensing.bearing import ANY_DIRECTION_RAD2
from octant.navigation.sensing.sensor import PowerLink

FloatArray = npt.NDArray[np.float64]

_FLOOR_SHARE = 1e-15

NULL_SHARE = 0.01
"""Share of the mean over the antennas that is added to each before decibels are compared [-]: a
table does not know how deep a null is below that."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerTable:
    """The RSS of the antennas for relative places of a tag, free of reflections.

    Parameters
    ----------
    reach_m : Largest distance, along the floor, of the table [m].
    power_w : (r, b, s, n) float64 — RSS [W] of n antennas. Distance i is reach (i/(r - 1))² [m],
        dense under the tag where the RSS falls fast; bearing j from the robot's front 2πj/b; the
        robot stands to the side 2πk/s of the tag, in the room.
    """

    reach_m: float
    power_w: FloatArray
    reference_w: float = field(init=False, repr=False, compare=False)
    """Strongest mean over the antennas that the table holds [W]."""

    def __post_init__(self) -> None:
        check_positive(self.reach_m, name="reach_m", unit="m")
        power = frozen_array(
            self.power_w, name="power_w", shape=(None, None, None, None), error=NavigationError
        )
        if power.shape[0] < 2 or power.shape[1] < 4 or not (power > 0.0).all():
            msg = (
                f"power_w has the shape {power.shape} and the least power {power.min():g} W, but "
                "two distances, four bearings and powers above 0 W are needed: compute it anew."
            )
            raise NavigationError(msg)
        object.__setattr__(self, "power_w", power)
        object.__setattr__(self, "reference_w", float(power.mean(axis=3).max()))

    @property
    def antennas(self) -> int:
        """Return the number n of antennas."""
        return int(self.power_w.shape[3])

    @property
    def bearings_rad(self) -> FloatArray:
        """Return the (b,) bearings from the robot's front [rad]."""
        count = self.power_w.shape[1]
        return np.asarray(2.0 * np.pi * np.arange(count) / count)


def power_table(
    link: PowerLink,
    tag_point_m: npt.ArrayLike,
    *,
    reach_m: float = 8.0,
    distances: int = 61,
    bearings: int = 48,
    sides: int = 16,
) -> PowerTable:
    """Return the table of a reader and a kind of tag; 150 dB below the strongest in place of zero.

    Parameters
    ----------
    link : Link of one tag to the reader in free space.
    tag_point_m : (2,) float64 — Point on the floor under that tag [m].
    reach_m : Largest distance [m].
    distances, bearings, sides : Size; one side is enough for a tag that is alike from all.
    """
    point = np.asarray(tag_point_m, dtype=np.float64)
    rho = reach_m * (np.arange(distances) / (distances - 1.0)) ** 2
    bearing = 2.0 * np.pi * np.arange(bearings) / bearings
    side = 2.0 * np.pi * np.arange(sides) / sides
    # Links trace a place once for all headings that follow each other there.
    far, at, off = np.meshgrid(rho, side, bearing, indexing="ij")
    poses = np.stack(
        [point[0] + far * np.cos(at), point[1] + far * np.sin(at), at + np.pi - off], axis=-1
    )
    power = link.rss_w(poses.reshape(-1, 3)).reshape(*far.shape, -1).swapaxes(1, 2)
    strongest = float(power.max())
    if not strongest > 0.0:
        msg = "the reader receives nothing of the tag in the open: check antennas and heights."
        raise NavigationError(msg)
    return PowerTable(reach_m=reach_m, power_w=np.maximum(power, _FLOOR_SHARE * strongest))


@dataclass(frozen=True, slots=True, kw_only=True)
class PatternMatcher:
    """A bearing estimator: least squares in decibels over the table of patterns.

    A reading z fits distance ρ and bearing φ with S = Σ (r_i - mean r)² of r_i = 10 log(z_i/P_i(ρ,
    φ)): neither tag power nor path loss matters. The posterior exp(-S/(2 error²)) over the table,
    equal before, has a circular mean, the bearing, and a mean length R, the variance -2 ln R.
    `NULL_SHARE` of their mean is first added to reading and patterns.

    Parameters
    ----------
    table : The reader's patterns.
    error_db : Standard deviation of each RSS about the patterns, noise and reflections [dB].
    """

    table: PowerTable
    error_db: float = 2.0
    _level_db: FloatArray = field(init=False, repr=False, compare=False)
    _whole_db: FloatArray = field(init=False, repr=False, compare=False)
    _unit: npt.NDArray[np.complex128] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_positive(self.error_db, name="error_db", unit="dB")
        power = self.table.power_w.mean(axis=2)
        power = power + NULL_SHARE * power.mean(axis=2, keepdims=True)
        level = decibels(power)
        whole = frozen_array(level, name="level", shape=level.shape)
        object.__setattr__(self, "_whole_db", whole)
        level -= level.mean(axis=2, keepdims=True)
        object.__setattr__(self, "_level_db", frozen_array(level, name="level", shape=level.shape))
        unit = np.exp(1j * self.table.bearings_rad)
        object.__setattr__(
            self, "_unit", frozen_array(unit, name="unit", shape=unit.shape, dtype=np.complex128)
        )

    def bearing(self, rss_w: FloatArray) -> tuple[float, float]:
        """Return bearing, from the front in (-π, π] [rad], and variance, at most π²/3 [rad²].

        Parameters
        ----------
        rss_w : (n,) float64 — One reading [W]; 0 W is left out; with none above it 0 and π²/3
            result.
        """
        heard = rss_w > 0.0
        if np.count_nonzero(heard) < 2:
            return 0.0, ANY_DIRECTION_RAD2
        filled = rss_w[heard] + NULL_SHARE * rss_w[heard].mean()
        return self._mean(decibels(filled) - self._level_db[..., heard])

    def bearing_over(self, rss_w: FloatArray, turned_rad: FloatArray) -> tuple[float, float]:
        """Return the same of readings that a turning robot took one after another.

        Parameters
        ----------
        rss_w : (k, n) float64 — The readings [W]; 0 W is left out. Their common level is free.
        turned_rad : (k,) float64 — Turn since each of them [rad], 0 for one of now.
        """
        step = 2.0 * np.pi / len(self.table.bearings_rad)
        residuals = []
        for rss, turned in zip(rss_w, turned_rad, strict=True):
            heard = rss > 0.0
            if heard.any():
                filled = rss[heard] + NULL_SHARE * rss[heard].mean()
                before, share = divmod(float(turned) / step, 1.0)
                level = (1.0 - share) * np.roll(self._whole_db, -int(before), axis=1)
                level += share * np.roll(self._whole_db, -int(before) - 1, axis=1)
                residuals.append(decibels(filled) - level[..., heard])
        if sum(part.shape[-1] for part in residuals) < 2:
            return 0.0, ANY_DIRECTION_RAD2
        return self._mean(np.concatenate(residuals, axis=-1))

    def _mean(self, residual: FloatArray) -> tuple[float, float]:
        """Return bearing and variance by residuals over the table, (r, b, k) [dB]."""
        squares = residual.var(axis=-1) * residual.shape[-1]
        weight = np.exp(-0.5 * (squares - squares.min()) / self.error_db**2)
        mean = complex(weight.sum(axis=0) @ self._unit) / float(weight.sum())
        length = max(abs(mean), math.exp(-0.5 * ANY_DIRECTION_RAD2))
        return math.atan2(mean.imag, mean.real), max(0.0, -2.0 * math.log(min(length, 1.0)))
