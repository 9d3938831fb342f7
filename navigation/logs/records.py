"""A log of readings as arrays, and what is asked of it: one source, order, rounds, repeats.

A reading is the power of one source (a tag, an anchor, a beacon) at one antenna. The source's side
and the robot's side may be exchanged: by reciprocity the same record holds a robot that hears fixed
tags and fixed anchors that hear a robot.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.geometries.names import nearest_name

NO_SOURCE = -1
"""Index of the source in a row that holds no reading, only time, pose or odometry."""

NOT_HEARD_DBM = -np.inf
"""Level of a reading that was asked for and not heard: it lies below the threshold [dBm]."""

_ROW_ARRAYS = {
    "time_s": (),
    "poses": (3,),
    "sources": (),
    "antennas": (),
    "rss_dbm": (),
    "frequency_hz": (),
    "distance_m": (),
    "turn_rad": (),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Log:
    """Readings in the order in which they were noted, one element of each array a row.

    Rows without a reading carry odometry or a pose between readings; `readings` leaves them out.

    Parameters
    ----------
    ids : The sources by name: tags or anchors.
    time_s : (n,) float64 — Time [s] from any moment; NaN: unknown.
    poses : (n, 3) float64 — True place x, y [m] and heading [rad] of the robot in the room; NaN:
        unknown, each by itself.
    sources : (n,) int64 — Index into ``ids``; -1: the row holds no reading [-].
    antennas : (n,) int64 — Number of the robot's antenna, from 1; 0: the only one [-].
    rss_dbm : (n,) float64 — Received power [dBm]; -inf: listened for and not heard, so that it is
        below the threshold; NaN exactly in rows without a reading.
    frequency_hz : (n,) float64 — Carrier frequency [Hz]; NaN: unknown.
    distance_m : (n,) float64 — Odometry: way driven since the row before [m], backwards negative;
        NaN: unknown.
    turn_rad : (n,) float64 — Odometry: turn since the row before [rad], counter-clockwise positive;
        NaN: unknown.
    threshold_dbm : Level below which the receiver hears nothing [dBm]; None: unknown.
    kept : Further columns as text, (n,) each, by their names.
    """

    ids: tuple[str, ...]
    time_s: npt.NDArray[np.float64]
    poses: npt.NDArray[np.float64]
    sources: npt.NDArray[np.int64]
    antennas: npt.NDArray[np.int64]
    rss_dbm: npt.NDArray[np.float64]
    frequency_hz: npt.NDArray[np.float64]
    distance_m: npt.NDArray[np.float64]
    turn_rad: npt.NDArray[np.float64]
    threshold_dbm: float | None = None
    kept: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "ids", tuple(self.ids))
        object.__setattr__(self, "kept", {k: tuple(v) for k, v in self.kept.items()})
        n = len(self.time_s)
        for name, rest in _ROW_ARRAYS.items():
            dtype = np.int64 if name in {"sources", "antennas"} else np.float64
            array = frozen_array(
                getattr(self, name),
                name=name,
                shape=(n, *rest),
                dtype=dtype,
                finite=False,
                error=NavigationError,
            )
            object.__setattr__(self, name, array)
        self._check(n)

    def _check(self, n: int) -> None:
        if len(set(self.ids)) < len(self.ids):
            msg = f"the log names a source twice among {list(self.ids)}; give each its own id."
            raise NavigationError(msg)
        if n and not -1 <= self.sources.min() <= self.sources.max() < len(self.ids):
            msg = (
                f"sources run from {self.sources.min()} to {self.sources.max()}, but the log has "
                f"{len(self.ids)} ids; use indices of them, or -1 for none."
            )
            raise NavigationError(msg)
        if n and self.antennas.min() < 0:
            low = self.antennas.min()
            msg = f"an antenna has the number {low}; count from 1, or 0 for the only one."
            raise NavigationError(msg)
        if np.any(np.isnan(self.rss_dbm) != (self.sources == NO_SOURCE)):
            msg = "rss_dbm must be NaN exactly where a row has no source; use -inf for 'not heard'."
            raise NavigationError(msg)
        if np.any(self.rss_dbm == np.inf):
            msg = "rss_dbm holds +inf; give a level in dBm, or -inf for 'not heard'."
            raise NavigationError(msg)
        for name, column in self.kept.items():
            if len(column) != n:
                msg = f"the kept column {name!r} has {len(column)} cells, but the log has {n} rows."
                raise NavigationError(msg)

    def __len__(self) -> int:
        return len(self.time_s)

    @property
    def heard(self) -> npt.NDArray[np.bool_]:
        """Return which rows hold a reading with a level, (n,)."""
        return np.isfinite(self.rss_dbm)

    @property
    def censored(self) -> npt.NDArray[np.bool_]:
        """Return which rows say that a source was not heard, (n,)."""
        return np.isneginf(self.rss_dbm)

    @property
    def antenna_numbers(self) -> tuple[int, ...]:
        """Return the numbers of the antennas with readings, in order; (0,) for the only one."""
        return tuple(int(a) for a in np.unique(self.antennas[self.sources != NO_SOURCE]))


def taken(log: Log, rows: npt.ArrayLike) -> Log:
    """Return the log's rows that a mask or indices choose; the ids stay as they are.

    Parameters
    ----------
    log : The log.
    rows : (n,) bool or (m,) int — Which rows, in the new order [-].
    """
    chosen = np.asarray(rows)
    places = np.flatnonzero(chosen) if chosen.dtype == np.bool_ else chosen.astype(np.int64)
    arrays = {name: getattr(log, name)[places] for name in _ROW_ARRAYS}
    kept = {name: tuple(column[i] for i in places) for name, column in log.kept.items()}
    return replace(log, **arrays, kept=kept)


def readings(log: Log) -> Log:
    """Return the log without the rows that hold no reading.

    Their odometry is lost with them; `rounds` uses it.

    Parameters
    ----------
    log : The log.
    """
    return log if np.all(log.sources != NO_SOURCE) else taken(log, log.sources != NO_SOURCE)


def of_source(log: Log, source: str) -> Log:
    """Return the readings of one source.

    Parameters
    ----------
    log : The log.
    source : Its id.

    Raises
    ------
    NavigationError
        The log has no such source; the nearest is named.
    """
    if source not in log.ids:
        near = nearest_name(source, log.ids)
        hint = f"did you mean {near!r}?" if near else "it has none at all."
        msg = f"the log has no readings of {source!r}, its sources are {list(log.ids)}: {hint}"
        raise NavigationError(msg)
    return taken(log, log.sources == log.ids.index(source))


def of_ids(log: Log, ids: Sequence[str]) -> Log:
    """Return the log with just these sources, in this order; rows without a reading stay.

    Readings of others are left out, and a source without any reading is one all the same.

    Parameters
    ----------
    log : The log.
    ids : The sources wanted.
    """
    place = {name: i for i, name in enumerate(ids)}
    new = np.array([place.get(name, NO_SOURCE - 1) for name in log.ids] + [NO_SOURCE])
    sources = new[log.sources]
    there = sources != NO_SOURCE - 1
    return replace(taken(log, there), ids=tuple(ids), sources=sources[there])


def in_time_order(log: Log) -> Log:
    """Return the log ordered by time; equal and unknown times keep the order of their rows.

    Rows of unknown time come last. Odometry counts from row to row, so that a log that has any is
    refused where its rows are out of order.

    Parameters
    ----------
    log : The log.

    Raises
    ------
    NavigationError
        The order would break the odometry.
    """
    order = np.argsort(log.time_s, kind="stable")
    if np.array_equal(order, np.arange(len(order))):
        return log
    if np.any(np.isfinite(log.distance_m) | np.isfinite(log.turn_rad)):
        row = int(np.flatnonzero(np.diff(log.time_s) < 0.0)[0]) if len(log) > 1 else 0
        msg = (
            f"the log's time falls from {log.time_s[row]:g} s to {log.time_s[row + 1]:g} s after "
            f"its row {row + 1}, but odometry counts from row to row; order the rows by time."
        )
        raise NavigationError(msg)
    return taken(log, order)


def repeats(log: Log) -> npt.NDArray[np.bool_]:
    """Return which readings have the time, source and antenna of an earlier row, (n,).

    Parameters
    ----------
    log : The log; readings of unknown time repeat nothing.
    """
    found = np.zeros(len(log), dtype=bool)
    timed = np.flatnonzero(np.isfinite(log.time_s) & (log.sources != NO_SOURCE))
    if timed.size:
        keys = np.column_stack([log.time_s, log.sources, log.antennas])[timed]
        _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        found[timed] = first[inverse.reshape(-1)] != np.arange(len(timed))
    return found


def joined(logs: Sequence[Log]) -> Log:
    """Return logs one after another as one; kept columns that one lacks are empty there.

    Parameters
    ----------
    logs : At least one; the first one's threshold holds.
    """
    ids = tuple(dict.fromkeys(name for log in logs for name in log.ids))
    names = tuple(dict.fromkeys(name for log in logs for name in log.kept))
    parts = [of_ids(log, ids) for log in logs]
    arrays = {
        item.name: np.concatenate([getattr(part, item.name) for part in parts])
        for item in fields(Log)
        if item.name in _ROW_ARRAYS
    }
    kept = {
        name: tuple(c for part in parts for c in part.kept.get(name, ("",) * len(part)))
        for name in names
    }
    return Log(ids=ids, threshold_dbm=logs[0].threshold_dbm, kept=kept, **arrays)
