"""What a log has measured, cell by cell: local means, also where some readings were not heard."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.measured.predict import Rows

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

CELL_M = 0.5
"""Default side of a cell [m]."""
LEAST = 5
"""Default number of readings that make a local mean [-]."""
FADING_DB = 5.57
"""Scatter of readings in dB under Rayleigh fading [dB], where a log has too few to tell its own."""
_HALVINGS = 60


@dataclass(frozen=True, slots=True, kw_only=True)
class Observations:
    """Local means over cells of one source at one antenna each.

    Parameters
    ----------
    sources, antennas, cells : (o,), (o,) and (o, 2) int64 — Index into the log's ids, antenna, and
        column and row of the cell [-].
    places : (o, 2) float64 — Mean place of the readings [m].
    level_dbm : (o,) float64 — Local mean of the levels in dB [dBm]; NaN where nothing was heard.
    heard, censored : (o,) int64 — Readings with a level, and those known to lie below the
        threshold [-].
    scatter_db : Standard deviation of readings about their local mean, pooled [dB].
    threshold_dbm : Level below which nothing is heard [dBm]; None: unknown.
    of_row : (n,) int64 — Observation that each reading belongs to [-]; -1: none.
    """

    sources: IntArray
    antennas: IntArray
    cells: IntArray
    places: FloatArray
    level_dbm: FloatArray
    heard: IntArray
    censored: IntArray
    scatter_db: float
    threshold_dbm: float | None
    of_row: IntArray

    def __len__(self) -> int:
        return len(self.sources)

    def means(self, of_readings: FloatArray) -> FloatArray:
        """Return the mean over the readings of each observation, (o,) or (o, p) [their unit].

        Parameters
        ----------
        of_readings : (n,) or (n, p) float64 — A value of each reading [any].
        """
        used = self.of_row >= 0
        index, count = self.of_row[used], np.bincount(self.of_row[used], minlength=len(self))
        columns = of_readings[used].reshape(len(index), -1)
        sums = np.stack(
            [np.bincount(index, column, minlength=len(self)) for column in columns.T], axis=1
        )
        mean: FloatArray = (sums / count[:, None]).reshape(len(self), *of_readings.shape[1:])
        return mean


def observed(rows: Rows, *, cell_m: float = CELL_M, least: int = LEAST) -> Observations:
    """Return the local means of a log's readings over square cells, by source and antenna.

    "Not heard" counts as what it says where the log has a threshold: the mean is then the one of
    greatest likelihood for Gaussian scatter in dB, of the heard levels and of the number below the
    threshold (Tobin 1958). Without a threshold such readings may as well be lost packets, and are
    left out.

    Parameters
    ----------
    rows : The readings.
    cell_m : Side of a cell [m]; cells start at x = 0 and y = 0.
    least : Readings that make a local mean.

    References
    ----------
    J. Tobin, "Estimation of relationships for limited dependent variables", Econometrica 26 (1958)
    24-36.
    """
    log = rows.log
    counted = log.heard | (log.censored & (log.threshold_dbm is not None))
    cell = np.floor(log.poses[:, :2] / cell_m).astype(np.int64)
    keys = np.column_stack([log.sources, log.antennas, cell])[counted]
    groups, index = np.unique(keys, axis=0, return_inverse=True)
    index = index.reshape(-1)
    k = len(groups)
    heard_row = log.heard[counted]
    level = np.where(heard_row, log.rss_dbm[counted], 0.0)
    total, heard = np.bincount(index, minlength=k), np.bincount(index, heard_row, minlength=k)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.bincount(index, level, minlength=k) / heard
    squares = np.bincount(index, np.where(heard_row, level - mean[index], 0.0) ** 2, minlength=k)
    good = total >= least
    if not good.any():
        msg = (
            f"no cell of {cell_m:g} m holds {least} readings of one source at one antenna (the "
            f"fullest has {total.max(initial=0)}); choose larger cells or a smaller number."
        )
        raise ConfigError(msg)
    spare = np.sum(np.maximum(heard - 1, 0)[good])
    enough = spare >= 10
    scatter = float(np.sqrt(np.sum(squares[good]) / spare)) if enough else FADING_DB
    censored = total - heard.astype(np.int64)
    if log.threshold_dbm is not None:
        mean = censored_means(mean, heard, censored, log.threshold_dbm, scatter)
    number = np.where(good, np.cumsum(good) - 1, -1)
    of_row = np.full(len(log), -1, dtype=np.int64)
    of_row[np.flatnonzero(counted)] = number[index]
    x, y = (np.bincount(index, log.poses[counted, i], minlength=k) / total for i in (0, 1))
    return Observations(
        sources=groups[good, 0],
        antennas=groups[good, 1],
        cells=groups[good, 2:],
        places=np.column_stack([x, y])[good],
        level_dbm=mean[good],
        heard=heard[good].astype(np.int64),
        censored=censored[good],
        scatter_db=scatter,
        threshold_dbm=log.threshold_dbm,
        of_row=of_row,
    )


def censored_means(
    mean_dbm: FloatArray,
    heard: npt.NDArray[np.generic],
    censored: npt.NDArray[np.generic],
    threshold_dbm: float,
    scatter_db: float,
) -> FloatArray:
    """Return means of greatest likelihood where some readings lie below a threshold [dBm].

    The root m of n (ȳ - m) / s = k φ(t) / Φ(t) with t = (T - m) / s, by bisection: the left side
    falls, the right side rises with m.

    Parameters
    ----------
    mean_dbm, heard : (o,) — Mean ȳ [dBm] of the n readings that were heard, and n [-].
    censored : (o,) — Number k of readings below the threshold [-].
    threshold_dbm, scatter_db : Threshold T [dBm]; scatter s of readings [dB], above 0.
    """
    from scipy.special import log_ndtr

    n, k = np.asarray(heard, dtype=np.float64), np.asarray(censored, dtype=np.float64)
    mixed = (n > 0.0) & (k > 0.0)
    high = np.where(mixed, mean_dbm, 0.0)
    # At most what all of the censored readings far below could pull: k / n of their distance.
    low = high - scatter_db * (10.0 + 10.0 * k / np.maximum(n, 1.0))
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        t = (threshold_dbm - middle) / scatter_db
        mills = np.exp(-0.5 * t * t - 0.5 * np.log(2.0 * np.pi) - log_ndtr(t))
        rises = n * (np.where(mixed, mean_dbm, 0.0) - middle) / scatter_db > k * mills
        low, high = np.where(rises, middle, low), np.where(rises, high, middle)
    return np.where(mixed, 0.5 * (low + high), mean_dbm)
