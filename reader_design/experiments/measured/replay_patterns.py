"""Patterns that a replay compares readings with: of the study's reader, of a file, of a spin."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError, NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.csv_files import write_csv
from octant.navigation.logs.rounds import Rounds
from octant.navigation.logs.text_tables import read_text_table
from octant.navigation.sensing.harmonic_bearing import harmonic_bearing
from octant.navigation.sensing.spin_patterns import BEARINGS, spin_gains_db
from octant.reader_design.experiments.measured.replay import watts

FloatArray = npt.NDArray[np.float64]

STILL_M = 0.05
"""Greatest way between readings of one stand [m]."""
WHOLE_TURN_RAD = math.radians(300.0)
"""Turn from which a stand is a spin [rad]."""
_WIDEST_GAP_DEG = 75.0


def read_gains(path: Path, *, antennas: int) -> FloatArray:
    """Return the gains of a file over evenly spaced bearings, (b, n) [dB].

    Parameters
    ----------
    path : A CSV file with the columns bearing_deg, from the robot's front counter-clockwise, and
        gain_1_db ... gain_n_db.
    antennas : Number n of antennas.
    """
    table = read_text_table(path, what="patterns")
    bearing = np.mod(np.radians(table.numbers("bearing_deg")), 2.0 * np.pi)
    columns = [table.numbers(f"gain_{i + 1}_db") for i in range(antennas)]
    more = f"gain_{antennas + 1}_db"
    if more in table.header:
        msg = f"{path} has the column {more!r}, but the robot has {antennas} antennas; match them."
        raise ConfigError(msg)
    for i, values in enumerate([bearing, *columns]):
        name = "bearing_deg" if i == 0 else f"gain_{i}_db"
        table.check(name, np.isfinite(values), "a number is needed")
    order = np.argsort(bearing)
    gaps = np.diff(np.append(bearing[order], bearing[order[0]] + 2.0 * np.pi))
    if math.degrees(gaps.max()) > _WIDEST_GAP_DEG or gaps.min() < 1e-9:
        msg = (
            f"{path} has bearings with a gap of {math.degrees(gaps.max()):.0f} deg, or one twice; "
            f"give each once, all around, at most {_WIDEST_GAP_DEG:g} deg apart."
        )
        raise ConfigError(msg)
    even = 2.0 * np.pi * np.arange(BEARINGS) / BEARINGS
    return np.column_stack(
        [np.interp(even, bearing[order], c[order], period=2.0 * np.pi) for c in columns]
    )


def write_gains(path: Path, gains_db: FloatArray) -> None:
    """Write gains as `read_gains` reads them.

    Parameters
    ----------
    path : The file.
    gains_db : (b, n) float64 — Gains over evenly spaced bearings from the front [dB].
    """
    bearing = 360.0 * np.arange(len(gains_db)) / len(gains_db)
    header = ("bearing_deg", *(f"gain_{i + 1}_db" for i in range(gains_db.shape[1])))
    rows = (
        (f"{b:g}", *(f"{g:.4f}" for g in row)) for b, row in zip(bearing, gains_db, strict=True)
    )
    write_csv(path, header, rows)


def spins_of(rounds: Rounds) -> npt.NDArray[np.int64]:
    """Return the number of the spin on the spot that each round belongs to, (m,), or -1 [-].

    Parameters
    ----------
    rounds : The log's rounds.
    """
    moved = np.abs(rounds.distance_m) > STILL_M
    stand = np.cumsum(moved)
    found = np.full(len(rounds), -1, dtype=np.int64)
    number = 0
    for one in np.unique(stand):
        rows = np.flatnonzero(stand == one)
        heading = np.unwrap(rounds.poses[rows, 2])  # odometry may have gaps
        if not np.isfinite(heading).all():
            heading = np.append(0.0, np.cumsum(rounds.turn_rad[rows[1:]]))
        if np.ptp(heading) >= WHOLE_TURN_RAD:
            found[rows] = number
            number += 1
    return found


def gains_of_spins(
    rounds: Rounds,
    ids: Sequence[str],
    points_m: Mapping[str, FloatArray],
    azimuths_rad: FloatArray,
) -> FloatArray:
    """Return the antennas' gains by the turns on the spot in a log, (b, n) [dB].

    The tag's bearing is that of the true pose; where the log has none, that of the first harmonic
    over the whole turn, for which the antennas' azimuths stand in.

    Parameters
    ----------
    rounds, ids : The log's rounds, its sources.
    points_m : (2,) float64 by tag — Its point on the floor [m].
    azimuths_rad : (n,) float64 — Azimuths of the antennas from the front [rad].
    """
    spins = spins_of(rounds)
    if not np.any(spins >= 0):
        msg = (
            "the log has no turn on the spot of 300 deg or more, from which patterns could be "
            "taken; let the robot turn once in view of a tag, or give --patterns FILE."
        )
        raise ConfigError(msg)
    heading = np.cumsum(rounds.turn_rad)
    bearing = np.full(len(rounds), np.nan)
    for spin in range(int(spins.max()) + 1):
        for source, tag in enumerate(ids):
            rows = np.flatnonzero((spins == spin) & (rounds.sources == source))
            poses = rounds.poses[rows]
            if not len(rows):
                continue
            if np.isfinite(poses).all():
                away = points_m[tag] - poses[:, :2]
                bearing[rows] = wrap_angle(np.arctan2(away[:, 1], away[:, 0]) - poses[:, 2])
                continue
            power_w = watts(rounds.rss_dbm[rows])
            azimuths = azimuths_rad[None] + heading[rows][:, None]
            bearing[rows] = wrap_angle(
                harmonic_bearing(power_w.ravel(), azimuths.ravel()) - heading[rows]
            )
    heard = np.isfinite(rounds.rss_dbm) & np.isfinite(bearing)[:, None]
    row, antenna = np.nonzero(heard)
    stands = spins[row] * len(ids) + rounds.sources[row]
    try:
        return spin_gains_db(
            bearing[row],
            rounds.rss_dbm[row, antenna],
            antennas=antenna,
            stands=stands,
            count=rounds.rss_dbm.shape[1],
        )
    except NavigationError as exc:
        raise ConfigError(str(exc)) from exc
