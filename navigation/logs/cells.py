"""Local means of a log's readings over square cells of the floor, and their scatter there."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.checks import check_positive
from octant.navigation.logs.records import Log


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalMeans:
    """Means over cells, one element a cell, source and antenna.

    Parameters
    ----------
    sources, antennas : (k,) int64 — As in the log [-].
    places : (k, 2) float64 — Mean place of the readings that were heard [m].
    cells : (k, 2) int64 — The cell's column and row, counted from x = 0 and y = 0 [-].
    mean_dbm : (k,) float64 — Mean of the levels in dB of the readings that were heard [dBm]; not
        the level of the mean power, which lies 2.5 dB higher under Rayleigh fading.
    sd_db : (k,) float64 — Their standard deviation with n - 1 [dB]; NaN for a single one.
    heard, censored : (k,) int64 — Readings with a level, and those that were not heard [-]. Where
        there are any of these the mean is too high, because the weak ones are missing from it.
    """

    sources: npt.NDArray[np.int64]
    antennas: npt.NDArray[np.int64]
    places: npt.NDArray[np.float64]
    cells: npt.NDArray[np.int64]
    mean_dbm: npt.NDArray[np.float64]
    sd_db: npt.NDArray[np.float64]
    heard: npt.NDArray[np.int64]
    censored: npt.NDArray[np.int64]


def local_means(
    log: Log, *, cell_m: float, least: int = 1
) -> tuple[LocalMeans, npt.NDArray[np.int64]]:
    """Return the means over cells of the floor, and the cell of each row, (n,), or -1.

    Parameters
    ----------
    log : The log; rows without a place or a reading are left out.
    cell_m : Side of a cell [m]; cells start at x = 0 and y = 0.
    least : Readings that must be heard in a cell, of one source at one antenna.
    """
    check_positive(cell_m, name="cell_m", unit="m")
    if least < 1:
        msg = f"a cell must hold at least {least} readings, but a mean needs 1: raise it."
        raise NavigationError(msg)
    rows = np.flatnonzero(np.isfinite(log.poses[:, :2]).all(axis=1) & ~np.isnan(log.rss_dbm))
    cell = np.floor(log.poses[rows, :2] / cell_m).astype(np.int64)
    keys = np.column_stack([log.sources[rows], log.antennas[rows], cell])
    groups, inverse = np.unique(keys, axis=0, return_inverse=True)
    inverse = inverse.reshape(-1)
    heard = log.heard[rows]
    level = np.where(heard, log.rss_dbm[rows], 0.0)
    k = len(groups)
    count = np.bincount(inverse, heard, minlength=k)
    some = np.maximum(count, 1.0)
    mean = np.bincount(inverse, level, minlength=k) / some
    squares = np.bincount(inverse, np.where(heard, level - mean[inverse], 0.0) ** 2, minlength=k)
    places = np.column_stack(
        [np.bincount(inverse, heard * log.poses[rows, i], minlength=k) / some for i in (0, 1)]
    )
    good = count >= least
    number = np.where(good, np.cumsum(good) - 1, -1)
    of_row = np.full(len(log), -1, dtype=np.int64)
    of_row[rows] = number[inverse]
    sd = np.sqrt(squares / np.maximum(count - 1.0, 1.0))
    means = LocalMeans(
        sources=groups[good, 0],
        antennas=groups[good, 1],
        cells=groups[good, 2:],
        places=places[good],
        mean_dbm=mean[good],
        sd_db=np.where(count > 1.0, sd, np.nan)[good],
        heard=count[good].astype(np.int64),
        censored=(np.bincount(inverse, minlength=k) - count)[good].astype(np.int64),
    )
    return means, of_row
