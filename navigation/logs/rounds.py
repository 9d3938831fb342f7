"""A log as an estimator meets it: one round of antennas after another, with the motion between."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.checks import check_positive
from octant.navigation.logs.records import NO_SOURCE, Log, in_time_order, repeats, taken

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Rounds:
    """Readings of one source by all antennas, one round a row, in order of time.

    Parameters
    ----------
    sources : (m,) int64 — Index into the log's ids [-].
    time_s : (m,) float64 — When the round ended [s]; the number of the round where the log has no
        times at all.
    poses : (m, 3) float64 — True pose at its end [m], [rad]; NaN: unknown.
    rss_dbm : (m, n) float64 — Levels [dBm]; -inf: not heard; NaN: the antenna was not read.
    distance_m, turn_rad : (m,) float64 — Odometry since the round before of whatever source [m],
        [rad].
    notes : What was supposed or left out, a sentence each.
    """

    sources: npt.NDArray[np.int64]
    time_s: FloatArray
    poses: FloatArray
    rss_dbm: FloatArray
    distance_m: FloatArray
    turn_rad: FloatArray
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.sources)


def rounds_of(log: Log, *, antennas: int, window_s: float = 0.0) -> Rounds:
    """Return a log's rounds.

    A round ends where the source, or the time by more than the window, changes, and where an
    antenna comes a second time. Rows that say the same twice count once. Odometry is that of the
    log; where it has none, that of the true poses; where it has neither, the robot stands.

    Parameters
    ----------
    log : The log, with rows of motion.
    antennas : Number n of the robot's antennas; number 0 counts as 1.
    window_s : Time within which readings are of one round [s].

    Raises
    ------
    NavigationError
        An antenna has a higher number, or there is no reading.
    """
    check_positive(window_s, name="window_s", unit="s", allow_zero=True)
    highest = int(log.antennas[log.sources != NO_SOURCE].max(initial=0))
    if highest > antennas:
        msg = (
            f"the log has readings of antenna {highest}, but the robot has {antennas}; say where "
            "they stand, or give a reader with as many."
        )
        raise NavigationError(msg)
    notes: list[str] = []
    log = _without_doubles(in_time_order(log), notes)
    there = log.sources != NO_SOURCE
    if not there.any():
        raise NavigationError("the log holds no reading; give one with levels of the tags.")
    distance, turn = _odometry(log, notes)
    number = _round_numbers(log, window_s)
    count = int(number.max()) + 1
    rss = np.full((count, antennas), np.nan)
    rss[number[there], np.maximum(log.antennas[there], 1) - 1] = log.rss_dbm[there]
    last = np.zeros(count, dtype=np.int64)
    last[number[there]] = np.flatnonzero(there)
    way, turned = _between(last, distance, turn)
    time_s = log.time_s[last]
    if np.isnan(time_s).all():
        notes.append("The log has no times: the number of the round stands for them.")
        time_s = np.arange(count, dtype=np.float64)
    return Rounds(
        sources=log.sources[last],
        time_s=time_s,
        poses=log.poses[last],
        rss_dbm=rss,
        distance_m=way,
        turn_rad=turned,
        notes=tuple(notes),
    )


def _without_doubles(log: Log, notes: list[str]) -> Log:
    """Return the log without rows that repeat a reading to the bit; odometry of these stays."""
    again = repeats(log)
    if not again.any():
        return log
    keys = np.column_stack([log.time_s, log.sources, log.antennas, log.rss_dbm])
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    double = again & (first[inverse.reshape(-1)] != np.arange(len(log)))
    still = np.nan_to_num(log.distance_m) == 0.0
    double &= still & (np.nan_to_num(log.turn_rad) == 0.0)
    if double.any():
        notes.append(f"{int(double.sum())} rows that repeat a reading to the bit are left out.")
    return taken(log, ~double)


def _round_numbers(log: Log, window_s: float) -> npt.NDArray[np.int64]:
    """Return the round of each row, (n,), rows of motion with the one that follows them."""
    number = np.zeros(len(log), dtype=np.int64)
    current, seen = 0, set[int]()
    source, began = NO_SOURCE, np.nan
    for row in range(len(log)):
        if log.sources[row] == NO_SOURCE:
            number[row] = current
            continue
        antenna, time_s = int(log.antennas[row]), float(log.time_s[row])
        late = not (time_s - began <= window_s) and not (np.isnan(time_s) and np.isnan(began))
        if seen and (log.sources[row] != source or late or antenna in seen):
            current, seen = current + 1, set()
        if not seen:
            source, began = int(log.sources[row]), time_s
        seen.add(antenna)
        number[row] = current
    return number


def _odometry(log: Log, notes: list[str]) -> tuple[FloatArray, FloatArray]:
    """Return way [m] and turn [rad] since the row before, (n,) each."""
    known = np.isfinite(log.distance_m) & np.isfinite(log.turn_rad)
    placed = np.isfinite(log.poses).all(axis=1)
    if known.all():
        return log.distance_m, log.turn_rad
    way, turned = np.zeros(len(log)), np.zeros(len(log))
    rows = np.flatnonzero(placed)
    step = np.diff(log.poses[rows], axis=0)
    turn = wrap_angle(step[:, 2])
    middle = log.poses[rows[:-1], 2] + 0.5 * turn
    chord = step[:, 0] * np.cos(middle) + step[:, 1] * np.sin(middle)
    way[rows[1:]] = chord / np.sinc(turn / (2.0 * np.pi))
    turned[rows[1:]] = turn
    if not known.any():
        what = "is that of the true poses" if len(rows) > 1 else "is taken as none: it stands"
        notes.append(f"The log has no odometry: the robot's {what}.")
        return way, turned
    gaps = int((~known).sum())
    notes.append(f"Odometry is unknown in {gaps} rows: the true poses stand for it, or no motion.")
    return np.where(known, log.distance_m, way), np.where(known, log.turn_rad, turned)


def _between(
    last: npt.NDArray[np.int64], distance_m: FloatArray, turn_rad: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the one arc that leads from each round to the next, by those of the rows between."""
    way, turned = np.zeros(len(last)), np.zeros(len(last))
    begin = 0
    for number, row in enumerate(last):
        rows = slice(begin, int(row) + 1)
        way[number], turned[number] = one_arc(distance_m[rows], turn_rad[rows])
        begin = int(row) + 1
    return way, turned


def one_arc(distance_m: FloatArray, turn_rad: FloatArray) -> tuple[float, float]:
    """Return way [m] and turn [rad] of the arc that stands for arcs driven one after another.

    It ends with their turn, and as far along its chord as they lead together.

    Parameters
    ----------
    distance_m, turn_rad : (k,) float64 — The arcs, at least one [m], [rad].
    """
    if len(distance_m) == 1:
        return float(distance_m[0]), float(turn_rad[0])
    total = float(turn_rad.sum())
    heading = np.cumsum(turn_rad) - 0.5 * turn_rad - 0.5 * total
    chord = np.sum(distance_m * np.sinc(turn_rad / (2.0 * np.pi)) * np.cos(heading))
    bend = float(np.sinc(np.clip(total, -np.pi, np.pi) / (2.0 * np.pi)))
    return float(chord) / bend, total
