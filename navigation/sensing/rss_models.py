"""RSS of tags by closed-form laws of distance, their fits to samples, and the noise on readings."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError

FloatArray = npt.NDArray[np.float64]

XBEE_DISTANCES_M = (3.00, 3.13, 3.50, 4.04, 4.69, 5.41, 6.18)
"""Distances of thesis Table 6.1 [m]."""
XBEE_RSS_DBM = (-47.0, -48.0, -51.0, -62.0, -54.0, -64.0, -69.0)
"""RSS of thesis Table 6.1 [dBm]."""


class DistanceLaw(Protocol):
    """RSS as a function of the distance between tag and reader."""

    def rss_dbm(self, distance_m: FloatArray) -> FloatArray:
        """Return the RSS at distances, any shape [dBm].

        Parameters
        ----------
        distance_m : (...) float64 — Distances [m], positive.
        """

    def slope_db_per_m(self, distance_m: FloatArray) -> FloatArray:
        """Return the derivative of the RSS with respect to distance [dB/m].

        Parameters
        ----------
        distance_m : (...) float64 — Distances [m], positive.
        """


@dataclass(frozen=True, slots=True, kw_only=True)
class LogExponentialLaw:
    """The law alpha exp(beta d) of thesis (6.2); the defaults are chapter 6 and 7's noisy fit.

    An exponential of decibels has no physical ground: far tags, whose RSS changes fastest, look the
    most informative. Good between 3 and 6 m, where Table 6.1 was taken.

    Parameters
    ----------
    alpha_dbm : RSS at no distance [dBm], negative.
    beta_per_m : Growth of its magnitude [1/m].
    """

    alpha_dbm: float = -60.0
    beta_per_m: float = 0.2

    def __post_init__(self) -> None:
        if not (np.isfinite([self.alpha_dbm, self.beta_per_m]).all() and self.alpha_dbm < 0.0):
            msg = (
                f"alpha is {self.alpha_dbm} dBm and beta {self.beta_per_m} 1/m, but both must be "
                "finite and alpha negative: give a fit of (6.2) such as -60 dBm and 0.2 1/m."
            )
            raise NavigationError(msg)

    def rss_dbm(self, distance_m: FloatArray) -> FloatArray:
        """Return the RSS at distances, any shape [dBm]."""
        rss: FloatArray = self.alpha_dbm * np.exp(self.beta_per_m * np.asarray(distance_m))
        return rss

    def slope_db_per_m(self, distance_m: FloatArray) -> FloatArray:
        """Return the derivative of the RSS with respect to distance [dB/m]."""
        return self.beta_per_m * self.rss_dbm(distance_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class LogDistanceLaw:
    """The law P_1 - 10 n log10(d / 1 m) of radio propagation.

    Parameters
    ----------
    rss_1m_dbm : RSS at 1 m [dBm].
    exponent : Path-loss exponent n [-]; 2 in free space.
    """

    rss_1m_dbm: float
    exponent: float

    def __post_init__(self) -> None:
        if not np.isfinite([self.rss_1m_dbm, self.exponent]).all():
            msg = (
                f"the RSS at 1 m is {self.rss_1m_dbm} dBm and the exponent {self.exponent}, but "
                "both must be finite: give numbers."
            )
            raise NavigationError(msg)

    def rss_dbm(self, distance_m: FloatArray) -> FloatArray:
        """Return the RSS at distances, any shape [dBm]."""
        rss: FloatArray = self.rss_1m_dbm - 10.0 * self.exponent * np.log10(distance_m)
        return rss

    def slope_db_per_m(self, distance_m: FloatArray) -> FloatArray:
        """Return the derivative of the RSS with respect to distance [dB/m]."""
        slope: FloatArray = -10.0 / np.log(10.0) * self.exponent / np.asarray(distance_m)
        return slope


def fit_log_exponential(
    distance_m: npt.ArrayLike, rss_dbm: npt.ArrayLike
) -> tuple[LogExponentialLaw, float]:
    """Return the least-squares fit of thesis (6.2), alpha below zero, and its RMS residual [dB].

    By variable projection: the best alpha for each beta is linear, so beta alone is searched, from
    the minimum of a scan. Table 6.1 gives (-34.9 dBm, 0.111 1/m) with 3.42 dB rms; the thesis
    prints (-35.5, 0.1071), 0.01 dB worse: the table holds some samples only.

    Parameters
    ----------
    distance_m : (k,) float64 — Distances [m].
    rss_dbm : (k,) float64 — RSS [dBm].
    """
    from scipy.optimize import minimize_scalar

    distance, rss = _samples(distance_m, rss_dbm)

    def best(beta: float) -> tuple[float, float]:
        shape = np.exp(beta * (distance - distance.mean()))
        alpha = min(float(shape @ rss / (shape @ shape)), -1e-9)
        return float(np.sum((alpha * shape - rss) ** 2)), alpha

    scan = np.linspace(-2.0, 2.0, 401)
    shapes = np.exp(np.outer(scan, distance - distance.mean()))
    alphas = np.minimum(shapes @ rss / np.sum(shapes**2, axis=1), -1e-9)
    start = int(np.argmin(np.sum((alphas[:, None] * shapes - rss) ** 2, axis=1)))
    bracket = scan[max(start - 1, 0)], scan[min(start + 1, len(scan) - 1)]
    found = minimize_scalar(
        lambda b: best(b)[0], bounds=bracket, method="bounded", options={"xatol": 1e-10}
    )
    beta = float(found.x)
    cost, alpha = best(beta)
    law = LogExponentialLaw(
        alpha_dbm=alpha * float(np.exp(-beta * distance.mean())), beta_per_m=beta
    )
    return law, float(np.sqrt(cost / len(distance)))


def fit_log_distance(
    distance_m: npt.ArrayLike, rss_dbm: npt.ArrayLike
) -> tuple[LogDistanceLaw, float]:
    """Return the least-squares fit of the log-distance law and its RMS residual [dB].

    Parameters
    ----------
    distance_m, rss_dbm : As for `fit_log_exponential` [m], [dBm].
    """
    distance, rss = _samples(distance_m, rss_dbm)
    slope, offset = np.polyfit(np.log10(distance), rss, 1)
    law = LogDistanceLaw(rss_1m_dbm=float(offset), exponent=float(-slope / 10.0))
    return law, float(np.sqrt(np.mean((law.rss_dbm(distance) - rss) ** 2)))


def _samples(distance_m: npt.ArrayLike, rss_dbm: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    distance = frozen_array(distance_m, name="distance_m", shape=(None,), error=NavigationError)
    rss = frozen_array(rss_dbm, name="rss_dbm", shape=(len(distance),), error=NavigationError)
    if len(distance) < 2 or not (distance > 0.0).all():
        msg = (
            f"{len(distance)} samples are given, but a law of distance needs at least two at "
            "distances above 0 m: add samples."
        )
        raise NavigationError(msg)
    return distance, rss


@dataclass(frozen=True, slots=True, kw_only=True)
class RssNoise:
    """Gaussian noise on every reading of every tag, thesis 6.5.1.

    Parameters
    ----------
    mean_db, sigma_db : Mean and standard deviation [dB]; the thesis has -30 and 50.
    """

    mean_db: float = -30.0
    sigma_db: float = 50.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.sigma_db) and self.sigma_db > 0.0 and np.isfinite(self.mean_db)):
            msg = (
                f"the RSS noise has mean {self.mean_db} dB and standard deviation {self.sigma_db} "
                "dB, but the filters divide by its covariance, so the deviation must be positive "
                "and both finite: give for example 50 dB."
            )
            raise NavigationError(msg)

    def draw(self, shape: tuple[int, ...], rng: np.random.Generator) -> FloatArray:
        """Return noise [dB].

        Parameters
        ----------
        shape : Its shape.
        rng : Source.
        """
        return rng.normal(self.mean_db, self.sigma_db, shape)


@dataclass(frozen=True, slots=True, kw_only=True)
class TagMesh:
    """The RSS of a mesh of tags that all follow one law of distance, thesis (6.1).

    Parameters
    ----------
    tags_m : (s, 3) float64 — Places of the tags, heights above the robot's antenna [m].
    law : RSS against distance.
    """

    tags_m: FloatArray
    law: DistanceLaw

    def __post_init__(self) -> None:
        tags = frozen_array(self.tags_m, name="tags_m", shape=(None, 3), error=NavigationError)
        object.__setattr__(self, "tags_m", tags)
        if len(tags) == 0 or not (np.abs(tags[:, 2]) > 0.0).all():
            msg = (
                f"{len(tags)} tags are given, but a mesh needs at least one and none at the "
                "height of the robot's antenna: place them higher."
            )
            raise NavigationError(msg)

    def rss_dbm(self, places_m: FloatArray) -> FloatArray:
        """Return the RSS of all tags at places of the robot, (m, s) [dBm]."""
        return self.law.rss_dbm(self._offsets(places_m)[1])

    def slopes_db_per_m(self, places_m: FloatArray) -> FloatArray:
        """Return the derivatives of the RSS along x and y, (m, s, 2) [dB/m]."""
        offset, distance = self._offsets(places_m)
        rate = self.law.slope_db_per_m(distance) / distance
        slopes: FloatArray = rate[..., None] * offset
        return slopes

    def _offsets(self, places_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        offset = np.asarray(places_m)[:, None, :] - self.tags_m[:, :2]
        distance = np.sqrt(np.sum(offset**2, axis=-1) + self.tags_m[:, 2] ** 2)
        return offset, distance


def tag_grid(side: int, *, spacing_m: float, height_m: float) -> FloatArray:
    """Return a square mesh of tags around the origin, (side², 3) [m].

    Parameters
    ----------
    side : Tags along each side; 3 in chapter 6, 5 in chapter 7.
    spacing_m, height_m : Distance of neighbours; height above the robot's antenna [m].
    """
    if side < 1 or not (spacing_m > 0.0 and height_m > 0.0):
        msg = (
            f"a mesh of {side} x {side} tags, {spacing_m} m apart and {height_m} m high, cannot be "
            "built: give at least one tag and positive lengths."
        )
        raise NavigationError(msg)
    axis = spacing_m * (np.arange(side) - 0.5 * (side - 1))
    x, y = np.meshgrid(axis, axis, indexing="ij")
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height_m)])
