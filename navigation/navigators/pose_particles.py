"""Where the robot is: particles of its pose, weighed by field maps of all tags that it hears.

A map is never exact. Each reading is therefore explained under several supposed powers of the field
that the map lacks, from that which survey and map are known to leave up to one that makes all
fading unknown (the local mean), and the readings decide between them.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.em.decibels import decibels
from octant.em.power.field_maps import FieldMap
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.checks import check_positive
from octant.navigation.navigators._pose_kernels import pose_log_likelihood
from octant.navigation.navigators.interface import Odometry
from octant.navigation.robot.floor import Blocked
from octant.navigation.robot.motion import Integration, move

FloatArray = npt.NDArray[np.float64]

_CELL_M = 0.25
_SECTORS = 12
_NEAR_M = 0.5
_NEAR_RAD = 0.6
_FORGET = 0.05
_LEAST_WEIGHT = 0.02
_RIVAL_SHARE = 0.15
_BLUR_M = 0.006
_BLUR_RAD = 0.01
_PER_M2 = 500.0
_MOST = 40_000
_PER_CELL = 60
_SCOUTS, _MANY_SCOUTS = 500, 2000
_DRAWS = 50
_EXPLORED = 0.2
_FRESH_WEIGHT = 0.01
_RIVALS = 0.35
_KEPT = 0.7


@dataclass(frozen=True, slots=True, kw_only=True)
class PoseEstimate:
    """The pose on which most particles agree.

    Parameters
    ----------
    pose : (3,) float64 — x, y [m], heading [rad].
    share : Probability that the robot is near there [-].
    covariance_m2 : (2, 2) float64 — Of the particles' places there [m²].
    heading_sd_rad : Deviation of their headings [rad].
    """

    pose: FloatArray
    share: float
    covariance_m2: FloatArray
    heading_sd_rad: float

    @property
    def spread_m(self) -> float:
        """Return the deviation along the least known direction [m]."""
        return math.sqrt(max(float(np.linalg.eigvalsh(self.covariance_m2)[-1]), 0.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class PoseBelief:
    """What is believed of the robot's pose, of levels, and of how far maps can be trusted.

    Parameters
    ----------
    poses : (3, m) float64 — x, y [m] and heading [rad] of each particle.
    weights : (m,) float64 — Their probabilities, adding up to one [-].
    trusted : (t, s + 1) float64 — Probability of each supposed share of error for each tag, and of
        an outlier [-].
    level_db, level_variance : (t,) float64 — By how much a tag reads more than its map [dB], and
        the variance of that [dB²].
    gain_db, gain_variance : (n,) float64 — The same of an antenna against the others, [dB]
        and [dB²].
    rivals : Share of the last readings that were explained better by poses drawn anywhere [-].
    estimate : The pose after the last reading, before particles are drawn anew; None: of another
        moment.
    """

    poses: FloatArray
    weights: FloatArray
    trusted: FloatArray
    level_db: FloatArray
    level_variance: FloatArray
    gain_db: FloatArray
    gain_variance: FloatArray
    rivals: float = 0.0
    estimate: PoseEstimate | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class PoseFilter:
    """An estimator of the robot's pose from odometry and the RSS of all tags that are heard.

    An antenna expects P + D: the map's coherent power and the error field's power D = share * local
    mean. Its level then has the variance noise² + fading² f(2 - f), f = D/(P + D), and lies below
    that of P + D by up to 2.5 dB, as the level of an exponential power does: a deep fade of the map
    says little where the map is not exact. All antennas of a tag share an unknown level; tags'
    levels and antennas' gains are found while driving (Kalman filters at the estimate).

    Parameters
    ----------
    maps : Field maps of all tags.
    shares : (t,) float64 — Power over the local mean of the error field that is expected of map and
        survey [-].
    floors_w : (t,) float64 — Power of it that is the same everywhere, also in shadows [W].
    low_m, high_m : (2,) float64 — Rectangle of the floor [m].
    blocked : Where the robot's centre cannot be; None: nowhere.
    wavelength_m, radius_m : Shortest wavelength [m]; distance of the antennas from the axis [m].
    noise_db : Deviation of a reading's noise [dB].
    fading_db : (t,) float64 — Deviation of the coherent level around the local mean [dB].
    level_db, gain_db : Deviations of tags' levels and of antennas' gains from the map's [dB].
    particles : Number of particles, at least.
    trust : Power of a reading's likelihood: the error field is alike at places close by [-].
    outlier_share, outlier_db : Prior share of outliers [-], and their deviation [dB].
    fresh_share : Share of new particles, anywhere, at each drawing [-].
    travel_sd, slip_sd_m, slip_sd_rad : Deviation of odometry's error: as a share of way and turn
        [-]; in a period in which the robot moves [m], [rad].
    method : How a period's motion is added up, as in `motion.move`.
    """

    maps: FieldMap
    shares: FloatArray
    floors_w: FloatArray
    low_m: FloatArray
    high_m: FloatArray
    blocked: Blocked | None
    wavelength_m: float
    noise_db: float
    fading_db: FloatArray
    radius_m: float = 0.1
    level_db: float = 2.0
    gain_db: float = 1.0
    particles: int = 2000
    trust: float = 0.5
    outlier_share: float = 0.05
    outlier_db: float = 15.0
    fresh_share: float = 0.01
    travel_sd: float = 0.05
    slip_sd_m: float = 0.003
    slip_sd_rad: float = 0.01
    method: Integration = "exact"

    def __post_init__(self) -> None:
        for name in ("low_m", "high_m", "fading_db", "shares", "floors_w"):
            array = frozen_array(getattr(self, name), name=name, shape=(None,))
            object.__setattr__(self, name, array)
        for name, unit in (
            ("level_db", "dB"),
            ("gain_db", "dB"),
            ("particles", "particles"),
            ("outlier_db", "dB"),
        ):
            check_positive(getattr(self, name), name=name, unit=unit)
        shares = (self.trust, self.outlier_share, self.fresh_share)
        if not all(0.0 < share <= 1.0 for share in shares):
            msg = (
                f"trust, outlier_share and fresh_share are {shares}, but they must lie between 0 "
                "and 1: 0.5, 0.05 and 0.01 are usual."
            )
            raise NavigationError(msg)

    def _shares(self, belief: PoseBelief | None = None) -> FloatArray:
        """Return the supposed shares of the error field: expected, in between, everything.

        The poses between particles are not looked at: their distance counts as an error of the map.
        """
        least = float(np.mean(self.shares))
        if belief is not None:
            least += misplaced_share(self._gap_m(belief), wavelength_m=self.wavelength_m)
        least = float(np.clip(least, 1e-3, 0.9))
        return np.array([least, math.sqrt(least), 1.0])

    def _gap_m(self, belief: PoseBelief) -> float:
        """Return about how far neighbouring particles are apart, turns as the antennas move [m].

        The volume of a normal distribution is (2 pi)^(3/2) times its deviations; particles in
        several cells share them.
        """
        number = _cells(belief.poses)
        shares = np.bincount(number, weights=belief.weights)
        inside = number == int(np.argmax(shares))
        place, heading = belief.poses[:2, inside], belief.poses[2, inside]
        turn = wrap_angle(heading - heading[0])
        spread = np.array([*place.std(axis=1), self.radius_m * float(np.std(turn))])
        volume = (2.0 * math.pi) ** 1.5 * float(np.prod(np.maximum(spread, 1e-4)))
        shares = shares[shares > 0.0]
        cells = math.exp(-float(np.sum(shares * np.log(shares))))
        return float((cells * volume / len(belief.weights)) ** (1.0 / 3.0))

    def start(
        self,
        rng: np.random.Generator,
        *,
        pose: FloatArray | None,
        sd_m: float = 0.02,
        sd_rad: float = 0.03,
    ) -> PoseBelief:
        """Return the belief before the first reading.

        Parameters
        ----------
        rng : Source of the particles.
        pose : (3,) float64 — Where the robot starts, x, y [m], heading [rad]; None: anywhere.
        sd_m, sd_rad : How exactly that is known [m], [rad].
        """
        if pose is None:
            area = float(np.prod(self.high_m - self.low_m))
            poses = self._anywhere(int(min(max(_PER_M2 * area, self.particles), _MOST)), rng)
        else:
            spread = np.array([sd_m, sd_m, sd_rad])
            poses = pose[:, None] + spread[:, None] * rng.standard_normal((3, self.particles))
        count, tags = poses.shape[1], self.maps.tags
        antennas = len(self.maps.ring)
        hypotheses = len(self._shares())
        prior = np.full(hypotheses + 1, (1.0 - self.outlier_share) / hypotheses)
        prior[-1] = self.outlier_share
        return PoseBelief(
            poses=poses,
            weights=np.full(count, 1.0 / count),
            trusted=np.tile(prior, (tags, 1)),
            level_db=np.zeros(tags),
            level_variance=np.full(tags, self.level_db**2),
            gain_db=np.zeros(antennas),
            gain_variance=np.full(antennas, self.gain_db**2),
        )

    def moved(self, belief: PoseBelief, odometry: Odometry, rng: np.random.Generator) -> PoseBelief:
        """Return the belief after a motion; after a contact the robot went any part of the way.

        Parameters
        ----------
        belief, odometry : Belief before; the motion.
        rng : Source of the odometry's errors, one for each particle.
        """
        way, turn = odometry.distance_m, odometry.turn_rad
        if way == 0.0 and turn == 0.0:
            return belief
        draw = rng.standard_normal((4, len(belief.weights)))
        part = 1.0 + self.travel_sd * draw[0]
        side = np.zeros(len(belief.weights))
        if odometry.contact:
            part = rng.random(len(belief.weights))
            side = 0.5 * abs(way) * draw[3]
        turns = turn * (1.0 + self.travel_sd * draw[1]) + self.slip_sd_rad * draw[2]
        ways = way * part + self.slip_sd_m * draw[3] * (way != 0.0)
        poses = move(belief.poses.T, distance_m=ways, turn_rad=turns, method=self.method).T
        poses[0] -= side * np.sin(poses[2])
        poses[1] += side * np.cos(poses[2])
        return replace(belief, poses=poses, estimate=None)

    def observed(
        self, belief: PoseBelief, rss_w: FloatArray, rng: np.random.Generator
    ) -> PoseBelief:
        """Return the belief weighed by readings, drawn anew when under half the particles count.

        Parameters
        ----------
        belief : Belief before.
        rss_w : (t, n) float64 — One reading of every tag; zero where nothing was received [W].
        rng : Source of new particles.
        """
        heard = rss_w > 0.0
        if not heard.any():
            return belief
        rss_db = np.full(rss_w.shape, -np.inf)
        rss_db[heard] = decibels(rss_w[heard])
        weights = belief.weights
        if self.blocked is not None:
            there = self.blocked(np.ascontiguousarray(belief.poses[:2].T))
            weights = np.where(there, 1e-3 * weights, weights)
        logs, parts = self._explained(belief.poses, rss_db, belief)
        weights = weights * np.exp(logs - logs.max())
        weights /= weights.sum()
        tags = np.asarray(heard.any(axis=1))
        shared = np.tensordot(weights, parts, axes=1)
        trusted = np.where(
            tags[:, None], (1.0 - _FORGET) * belief.trusted + _FORGET * shared, belief.trusted
        )
        trusted = np.maximum(trusted, _LEAST_WEIGHT)
        weighed = replace(
            belief,
            weights=weights,
            trusted=trusted / trusted.sum(axis=1, keepdims=True),
        )
        weighed = replace(weighed, estimate=self._agreed(weighed))
        weighed = self._learned(weighed, rss_db)
        count = max(self._wanted(weighed), round(_KEPT * len(weights)))
        if len(weights) > 1.2 * self.particles:  # the pose is open: particles are everywhere
            weighed = replace(weighed, rivals=(1.0 - _RIVAL_SHARE) * belief.rivals)
            return self._drawn_anew(weighed, count, rng, scouts=None)
        scouts = self._anywhere(_MANY_SCOUTS if belief.rivals > 0.5 * _RIVALS else _SCOUTS, rng)
        rival_logs, _ = self._explained(scouts, rss_db, belief)
        won = bool(rival_logs.max() > logs.max())
        weighed = replace(weighed, rivals=(1.0 - _RIVAL_SHARE) * belief.rivals + _RIVAL_SHARE * won)
        if self.lost(weighed):
            return self._anew(weighed, rng)
        if not won and 1.0 / float(np.sum(weights**2)) >= 0.5 * len(weights):
            return weighed
        chosen = np.exp(self.trust * (rival_logs - rival_logs.max()))
        fresh = max(1, round((0.2 if won else self.fresh_share) * count))
        scouts = scouts[:, _systematic(chosen, fresh, rng)]
        return self._drawn_anew(weighed, count, rng, scouts=scouts)

    def _anew(self, belief: PoseBelief, rng: np.random.Generator) -> PoseBelief:
        """Return a belief that the robot may be anywhere; levels and gains stay known."""
        fresh = self.start(rng, pose=None)
        return replace(
            belief,
            poses=fresh.poses,
            weights=fresh.weights,
            trusted=fresh.trusted,
            estimate=None,
        )

    def lost(self, belief: PoseBelief) -> bool:
        """Return whether poses drawn anywhere explain most of the last readings better.

        That readings do not fit says that the map is wrong here, or the pose. At a wrong pose the
        best of many others is better; at the right one it is not, be the map as wrong as it may.

        Parameters
        ----------
        belief : The belief.
        """
        return belief.rivals > _RIVALS

    def estimate(self, belief: PoseBelief) -> PoseEstimate:
        """Return mean and covariance of the particles around the heaviest cell.

        Parameters
        ----------
        belief : The particles.
        """
        return belief.estimate or self._agreed(belief)

    def _agreed(self, belief: PoseBelief) -> PoseEstimate:
        number = _cells(belief.poses)
        shares = np.bincount(number, weights=belief.weights)
        pose = _mean_pose(belief.poses, belief.weights * (number == int(np.argmax(shares))))
        for _ in range(2):
            near = (
                (belief.poses[0] - pose[0]) ** 2 + (belief.poses[1] - pose[1]) ** 2 < _NEAR_M**2
            ) & (np.abs(wrap_angle(belief.poses[2] - pose[2])) < _NEAR_RAD)
            weight = belief.weights * near
            share = float(weight.sum())
            pose = _mean_pose(belief.poses, weight)
        off = belief.poses[:2] - pose[:2, None]
        turn = wrap_angle(belief.poses[2] - pose[2])
        return PoseEstimate(
            pose=pose,
            share=share,
            covariance_m2=np.asarray((off * weight) @ off.T / share),
            heading_sd_rad=math.sqrt(float(turn**2 @ weight) / share),
        )

    def _explained(
        self, poses: FloatArray, rss_db: FloatArray, belief: PoseBelief
    ) -> tuple[FloatArray, FloatArray]:
        maps, shares, tags = self.maps, self._shares(belief), self.maps.tags
        logs = np.empty(poses.shape[1])
        parts = np.empty((poses.shape[1], tags, len(shares) + 1))
        pose_log_likelihood(
            np.ascontiguousarray(poses), _grid(maps.x_m, maps.y_m), maps.levels,
            _grid(maps.node_x_m, maps.node_y_m), maps.means, maps.powers_w, maps.ring,
            maps.shift_rad * maps.levels.shape[4] / (2.0 * math.pi), rss_db, belief.level_db,
            belief.level_variance, belief.gain_db, shares, self.floors_w, max(self.noise_db, 0.1),
            self.fading_db, self.outlier_db, self.trust, belief.trusted, logs, parts,
        )  # fmt: skip
        return logs, parts

    def _learned(self, belief: PoseBelief, rss_db: FloatArray) -> PoseBelief:
        """Return the belief with levels and gains moved by the errors at the estimate."""
        estimate = self.estimate(belief)
        if estimate.share < 0.9 or estimate.spread_m > _EXPLORED:
            return belief
        pose = estimate.pose[None]
        level, level_variance = belief.level_db.copy(), belief.level_variance.copy()
        gain, gain_variance = belief.gain_db.copy(), belief.gain_variance.copy()
        expected = belief.trusted[:, :-1] @ self._shares() / belief.trusted[:, :-1].sum(axis=1)
        for t in range(self.maps.tags):
            here = self.maps.rss_w(pose, tag=t)[0]
            mean = self.maps.local_mean_w(pose, tag=t)[0]
            sound = (rss_db[t] > -np.inf) & (mean > 0.0)
            if not sound.any():
                continue
            diffuse = expected[t] * mean[sound] + self.floors_w[t]
            part = diffuse / (here[sound] + diffuse)
            part *= 2.0 - part
            variance = (self.noise_db**2 + self.fading_db[t] ** 2 * part) / self.trust
            error = (
                rss_db[t, sound]
                - decibels(here[sound] + diffuse)
                + 2.51 * self.fading_db[t] / 5.57 * part
            )
            rest = error - level[t] - gain[sound]
            weight = 1.0 / variance
            total = weight.sum()
            towards = level_variance[t] / (level_variance[t] + 1.0 / total)
            moved = towards * float(weight @ rest) / total
            level[t] += moved
            level_variance[t] *= 1.0 - towards
            ratio = gain_variance[sound] / (gain_variance[sound] + variance)
            gain[sound] += ratio * (rest - moved)
            gain_variance[sound] *= 1.0 - ratio
        floor = (0.1 * self.level_db) ** 2
        return replace(
            belief,
            level_db=level,
            level_variance=np.maximum(level_variance, floor),
            gain_db=gain,
            gain_variance=gain_variance,
        )

    def _wanted(self, belief: PoseBelief) -> int:
        """Return how many particles the belief needs: some for each cell that really counts."""
        number = _cells(belief.poses)
        shares = np.bincount(number, weights=belief.weights)
        cells = math.exp(-float(np.sum(shares[shares > 0.0] * np.log(shares[shares > 0.0]))))
        return round(max(self.particles, min(_MOST, _PER_CELL * cells)))

    def _drawn_anew(
        self,
        belief: PoseBelief,
        count: int,
        rng: np.random.Generator,
        *,
        scouts: FloatArray | None,
    ) -> PoseBelief:
        """Return particles of like weight: systematic resampling, blurred, with some fresh ones.

        Scouts weigh little: the best of very many explain one reading by chance.
        """
        if scouts is None:
            scouts = self._anywhere(max(1, round(self.fresh_share * count)), rng)
        fresh = scouts.shape[1]
        kept = count - fresh
        chosen = _systematic(belief.weights, kept, rng)
        poses = belief.poses[:, chosen]
        poses[:2] += _BLUR_M * rng.standard_normal((2, kept))
        poses[2] += _BLUR_RAD * rng.standard_normal(kept)
        weights = np.concatenate(
            [np.full(kept, (1.0 - _FRESH_WEIGHT) / kept), np.full(fresh, _FRESH_WEIGHT / fresh)]
        )
        return replace(belief, poses=np.hstack([poses, scouts]), weights=weights)

    def _anywhere(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Return poses anywhere on the free floor."""
        found: list[FloatArray] = []
        missing = count
        for _ in range(_DRAWS):
            points = rng.uniform(self.low_m, self.high_m, (max(64, 2 * missing), 2))
            if self.blocked is not None:
                points = points[~np.asarray(self.blocked(points))]
            found.append(points[:missing])
            missing -= len(found[-1])
            if missing == 0:
                break
        points = np.concatenate(found)
        if not len(points):
            msg = "there is no free floor on the field map, but the robot stands on some; enlarge."
            raise NavigationError(msg)
        points = points[np.arange(count) % len(points)]
        return np.vstack([points.T, rng.uniform(-np.pi, np.pi, count)])


def misplaced_share(sd_m: float, *, wavelength_m: float) -> float:
    """Return the power over the local mean of what a place that is off adds to the field [-].

    Waves of a tag, or at a robot, that is off by d in a random direction have phases k d.u off, u
    being the direction of each. Of directions all around, and without the phase that all share, the
    mean square of that is 2/3 k² sd²; the error field is 1 - exp(-that).

    Parameters
    ----------
    sd_m : Deviation of the place along each axis [m].
    wavelength_m : Wavelength [m].
    """
    phase = 2.0 * math.pi / wavelength_m * sd_m
    return 1.0 - math.exp(-2.0 / 3.0 * phase**2)


def _systematic(weights: FloatArray, count: int, rng: np.random.Generator) -> npt.NDArray[np.int64]:
    edges = np.cumsum(weights)
    steps = (rng.random() + np.arange(count)) / count * edges[-1]
    chosen: npt.NDArray[np.int64] = np.minimum(np.searchsorted(edges, steps), len(edges) - 1)
    return chosen


def _cells(poses: FloatArray) -> npt.NDArray[np.int64]:
    """Return the number of the cell of place and heading in which each particle is, (m,)."""
    x = np.floor((poses[0] - poses[0].min()) / _CELL_M).astype(np.int64)
    y = np.floor((poses[1] - poses[1].min()) / _CELL_M).astype(np.int64)
    sector = np.floor(poses[2] % (2.0 * np.pi) / (2.0 * np.pi) * _SECTORS).astype(np.int64)
    sector = np.minimum(sector, _SECTORS - 1)
    rows = int(y.max()) + 1
    number: npt.NDArray[np.int64] = (x * rows + y) * _SECTORS + sector
    return number


def _mean_pose(poses: FloatArray, weights: FloatArray) -> FloatArray:
    total = weights.sum()
    heading = math.atan2(float(weights @ np.sin(poses[2])), float(weights @ np.cos(poses[2])))
    x, y = poses[:2] @ weights / total
    return np.array([x, y, heading])


def _grid(x_m: FloatArray, y_m: FloatArray) -> FloatArray:
    return np.array([x_m[0], y_m[0], x_m[1] - x_m[0], y_m[1] - y_m[0]])
