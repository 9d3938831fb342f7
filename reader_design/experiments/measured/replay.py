"""A recorded drive through the estimators: what they would have known, against where it was."""

import math
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.navigation.angles import wrap_angle
from octant.navigation.logs.rounds import Rounds, one_arc
from octant.navigation.navigators.interface import Odometry
from octant.navigation.navigators.place_particles import (
    PlaceBelief,
    PlaceFilter,
    seen_after,
)
from octant.navigation.navigators.pose_particles import PoseFilter
from octant.navigation.sensing.bearing import FRONT_AZIMUTH_RAD
from octant.navigation.sensing.harmonic_bearing import harmonic_bearing, strongest_bearing
from octant.navigation.sensing.pattern_match import PatternMatcher, PowerTable

FloatArray = npt.NDArray[np.float64]

Estimator = Literal["strongest", "vector_sum", "pattern", "tracker", "map"]
"""What makes a bearing, a place or a pose of readings."""

BEARING_METHODS = ("strongest", "vector_sum", "pattern")
"""Those that know a bearing only."""

_STREAM = 5_113
_TO_WATT = -30.0
_ANY_HEADING_SD_RAD = math.pi
_HEADING_SD_RAD = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class Replayed:
    """What an estimator said at each round of one tag.

    Parameters
    ----------
    tag : Its id.
    time_s : (k,) float64 — When [s].
    poses : (k, 3) float64 — True pose of the robot [m], [rad]; NaN: unknown.
    heard : (k,) int64 — Antennas that heard the tag [-].
    bearing_rad, true_bearing_rad : (k,) float64 — Of the tag from the robot's front [rad]; NaN:
        unknown.
    place_m, true_place_m : (k, 2) float64 — What was to be found, in the room: the tag's point, of
        ``map`` the robot's place [m]; NaN: unknown.
    spread_m : (k,) float64 — How wide the belief was [m]; NaN: it has none.
    """

    tag: str
    time_s: FloatArray
    poses: FloatArray
    heard: npt.NDArray[np.int64]
    bearing_rad: FloatArray
    true_bearing_rad: FloatArray
    place_m: FloatArray
    true_place_m: FloatArray
    spread_m: FloatArray

    @property
    def bearing_error_rad(self) -> FloatArray:
        """Error of the bearing, in (-π, π] [rad]."""
        return wrap_angle(self.bearing_rad - self.true_bearing_rad)

    @property
    def place_error_m(self) -> FloatArray:
        """Distance of the believed place from the true one [m]."""
        return np.asarray(np.hypot(*(self.place_m - self.true_place_m).T))


@dataclass(frozen=True, slots=True, kw_only=True)
class Said:
    """What an estimator says of one round.

    Parameters
    ----------
    bearing_rad : Of the tag, from the robot's front [rad].
    place_m : The tag ahead of the robot and to its left, or the robot's place in the room [m].
    spread_m : Of the belief [m].
    """

    bearing_rad: float = math.nan
    place_m: tuple[float, float] = (math.nan, math.nan)
    spread_m: float = math.nan


def watts(rss_dbm: FloatArray) -> FloatArray:
    """Return readings as powers [W]: zero where not heard, NaN where not read.

    Parameters
    ----------
    rss_dbm : (..., n) float64 — Levels [dBm].
    """
    return np.asarray(10.0 ** ((rss_dbm + _TO_WATT) / 10.0))


def replayed(
    rounds: Rounds,
    ids: Sequence[str],
    points_m: Mapping[str, FloatArray],
    said: Iterator[Said],
    *,
    in_room: bool,
) -> tuple[Replayed, ...]:
    """Return what an estimator said by tag, beside the truth.

    Parameters
    ----------
    rounds, ids : The log's rounds, and its sources.
    points_m : (2,) float64 by tag — Its point on the floor [m].
    said : What the estimator says of each round, in order.
    in_room : Whether its places are the robot's in the room, in place of the tag's seen from it.
    """
    answers = list(said)
    found = []
    for number, tag in enumerate(ids):
        rows = np.flatnonzero(rounds.sources == number)
        if not len(rows):
            continue
        poses = rounds.poses[rows]
        away = points_m[tag] - poses[:, :2]
        place = np.array([answers[row].place_m for row in rows])
        if not in_room:
            c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
            ahead, left = place.T
            place = poses[:, :2] + np.column_stack([c * ahead - s * left, s * ahead + c * left])
        truth = poses[:, :2] if in_room else np.tile(points_m[tag], (len(rows), 1))
        found.append(
            Replayed(
                tag=tag,
                time_s=rounds.time_s[rows],
                poses=poses,
                heard=np.sum(np.isfinite(rounds.rss_dbm[rows]), axis=1),
                bearing_rad=np.array([answers[row].bearing_rad for row in rows]),
                true_bearing_rad=wrap_angle(np.arctan2(away[:, 1], away[:, 0]) - poses[:, 2]),
                place_m=place,
                true_place_m=truth,
                spread_m=np.array([answers[row].spread_m for row in rows]),
            )
        )
    return tuple(found)


def bearings_said(
    rounds: Rounds,
    *,
    estimator: Estimator,
    azimuths_rad: FloatArray,
    matchers: Mapping[int, PatternMatcher],
    combine_s: float = 0.0,
) -> Iterator[Said]:
    """Yield the bearing of each round by the readings of its tag, now and a while back.

    Readings that were taken before the robot turned count at the azimuth at which their antenna
    stood then. With 0 s each round stands for itself.

    Parameters
    ----------
    rounds : The log's rounds.
    estimator : One of `BEARING_METHODS`.
    azimuths_rad : (n,) float64 — Azimuths of the antennas from the front [rad].
    matchers : Of each source, for ``pattern``.
    combine_s : How far back readings count [s].
    """
    heading = np.cumsum(rounds.turn_rad)
    power_w = watts(rounds.rss_dbm)
    before: dict[int, deque[int]] = {}
    for row in range(len(rounds)):
        source = int(rounds.sources[row])
        rows = before.setdefault(source, deque())
        rows.append(row)
        limit = rounds.time_s[row] - combine_s
        while len(rows) > 1 and not rounds.time_s[rows[0]] >= limit:
            rows.popleft()
        if combine_s == 0.0:
            rows = before[source] = deque((row,))
        chosen = np.array(rows)
        turned = heading[row] - heading[chosen]
        if estimator == "pattern":
            bearing, variance = matchers[source].bearing_over(
                np.nan_to_num(power_w[chosen]), turned
            )
            yield Said(bearing_rad=bearing if variance < math.pi**2 / 3.0 else math.nan)
            continue
        azimuths = (azimuths_rad[None] - turned[:, None]).ravel()
        method = strongest_bearing if estimator == "strongest" else harmonic_bearing
        yield Said(bearing_rad=method(power_w[chosen].ravel(), azimuths))


def tracker_said(
    rounds: Rounds, filters: Mapping[int, PlaceFilter], *, seed: int
) -> Iterator[Said]:
    """Yield where each round's tag is believed, by all of its readings and the odometry so far.

    As the navigator does, it keeps to a place until another is clearly more probable. A tag's
    answers do not depend on the others.

    Parameters
    ----------
    rounds : The log's rounds.
    filters : Of each source that is wanted; rounds of others are passed over.
    seed : Of the particles.
    """
    power_w = np.nan_to_num(watts(rounds.rss_dbm))
    beliefs: dict[int, tuple[int, PlaceBelief, FloatArray]] = {}
    rngs = {source: np.random.default_rng((seed, _STREAM, source)) for source in filters}
    for row in range(len(rounds)):
        source = int(rounds.sources[row])
        if source not in filters:
            continue
        tracker, rng, held_m = filters[source], rngs[source], None
        if source not in beliefs:
            heading = float(rounds.poses[row, 2])
            known = math.isfinite(heading)
            belief = tracker.start(
                rng,
                heading_rad=heading if known else 0.0,
                heading_sd_rad=_HEADING_SD_RAD if known else _ANY_HEADING_SD_RAD,
            )
        else:
            last, belief, place_m = beliefs[source]
            since = slice(last + 1, row + 1)
            way, turn = one_arc(rounds.distance_m[since], rounds.turn_rad[since])
            if way != 0.0 or turn != 0.0:
                belief = tracker.moved(belief, Odometry(distance_m=way, turn_rad=turn), rng)
            held_m = seen_after(place_m, way_m=way, turn_rad=turn, method=tracker.method)
        belief = tracker.observed(belief, power_w[row], rng)
        estimate = tracker.estimate(belief, held_m=held_m)
        beliefs[source] = row, belief, estimate.place_m
        ahead, left = (float(c) for c in estimate.place_m)
        yield Said(
            bearing_rad=estimate.bearing_rad,
            place_m=(ahead, left),
            spread_m=estimate.spread_m,
        )


def map_said(
    rounds: Rounds,
    pose_filter: PoseFilter,
    points_m: Sequence[FloatArray],
    *,
    start: FloatArray | None,
    seed: int,
) -> Iterator[Said]:
    """Yield where the robot is believed at each round, by the readings of all tags so far.

    Parameters
    ----------
    rounds : The log's rounds.
    pose_filter : With a map of every source, in their order.
    points_m : (2,) float64 of every source — Its point on the floor [m].
    start : (3,) float64 or None — Pose before the first round [m], [rad]; None: anywhere.
    seed : Of the particles.
    """
    rng = np.random.default_rng((seed, _STREAM))
    power_w = np.nan_to_num(watts(rounds.rss_dbm))
    belief = pose_filter.start(rng, pose=start)
    for rows in _at_one_place(rounds):
        way, turn = float(rounds.distance_m[rows[0]]), float(rounds.turn_rad[rows[0]])
        belief = pose_filter.moved(belief, Odometry(distance_m=way, turn_rad=turn), rng)
        reading = np.zeros((len(points_m), power_w.shape[1]))
        for row in rows:
            reading[rounds.sources[row]] = power_w[row]
        belief = pose_filter.observed(belief, reading, rng)
        estimate = pose_filter.estimate(belief)
        x, y, heading = (float(c) for c in estimate.pose)
        for row in rows:
            away = points_m[int(rounds.sources[row])] - estimate.pose[:2]
            bearing = math.atan2(float(away[1]), float(away[0])) - heading
            yield Said(
                bearing_rad=float(wrap_angle(bearing)),
                place_m=(x, y),
                spread_m=estimate.spread_m,
            )


def _at_one_place(rounds: Rounds) -> Iterator[list[int]]:
    """Yield the rounds of different tags that are taken without motion between them."""
    group: list[int] = []
    for row in range(len(rounds)):
        moved = rounds.distance_m[row] != 0.0 or rounds.turn_rad[row] != 0.0
        again = rounds.sources[row] in {rounds.sources[other] for other in group}
        if group and (moved or again):
            yield group
            group = []
        group.append(row)
    if group:
        yield group


def tracker_filter(table: PowerTable, *, level_sd_db: float, trust: float) -> PlaceFilter:
    """Return the tracker's filter for logs of an unknown level.

    Parameters
    ----------
    table : The reader's patterns.
    level_sd_db : How unknown the level is [dB].
    trust : Power of the likelihood of a reading [-].
    """
    return PlaceFilter(table=table, level_db=level_sd_db, trust=trust, method="exact")


def check_method(estimator: Estimator, *, antennas: int, combine_s: float, turns: bool) -> None:
    """Refuse a bearing method that the antennas cannot feed.

    Parameters
    ----------
    estimator : The method.
    antennas : Number of the robot's antennas.
    combine_s : How far back readings count [s].
    turns : Whether the robot turns at all in the log.
    """
    needed = {"strongest": 2, "vector_sum": 3, "pattern": 2}.get(estimator, 1)
    if antennas >= needed or (combine_s > 0.0 and turns):
        return
    what = "antenna" if antennas == 1 else "antennas"
    hint = "give --combine-s S, so that readings of the last S seconds count while the robot turns"
    if not turns:
        hint = "the robot never turns in this log, so take one with more antennas"
    msg = (
        f"the log has {antennas} {what}, but a bearing by {estimator!r} needs {needed} directions; "
        f"{hint}, or take --estimator tracker with --patterns."
    )
    raise ConfigError(msg)


def counted(said: Iterator[Said], done: Callable[[int], object]) -> Iterator[Said]:
    """Yield the same, telling how many there were.

    Parameters
    ----------
    said, done : What an estimator says; called with their number so far.
    """
    for number, one in enumerate(said, 1):
        done(number)
        yield one


def from_front(azimuths_rad: FloatArray) -> FloatArray:
    """Return azimuths of the reader's frame as bearings from the robot's front, (n,) [rad].

    Parameters
    ----------
    azimuths_rad : (n,) float64 — Azimuths in the reader's frame [rad].
    """
    return wrap_angle(azimuths_rad - FRONT_AZIMUTH_RAD)
