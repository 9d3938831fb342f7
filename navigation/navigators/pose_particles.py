"""Where the robot is: particles of its pose, weighed by field maps of all tags that it hears.

A map is never exact. Each reading is therefore explained under several supposed powers of the field
that the map lacks, from that which survey and map are known to leave up to one that makes all
fading unknown (the local mean), and the readings decide between them.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.em.decibels import decibels
from octant.em.power.field_maps import FieldMap
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.checks import check_positive
from octant.navigation.navigators.drawing import systematic
from octant.navigation.navigators.interface import Odometry
from octant.navigation.navigators.learned import Learned
from octant.navigation.navigators.pose_belief import (
    MOST_PROOF,
    PoseBelief,
    PoseEstimate,
    agreed,
    pose_cells,
)
from octant.navigation.navigators.readings import PLACES, POSES, Reading, supposed_shares
from octant.navigation.navigators.tag_places import TagPlaces, TagSurvey
from octant.navigation.robot.floor import Blocked
from octant.navigation.robot.motion import Integration, move

FloatArray = npt.NDArray[np.float64]

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
_WON_SHARE = 0.2
_FRESH_WEIGHT = 0.01
_RIVALS, _MOST_RIVALS = 0.35, 0.95
_KEPT = 0.7
_PLACED_M = 0.15
_PLACED_PART = 8
_DOUBT = 20.0
_FOUND = 0.5
_SETTLED_M = 0.005
_LOOKED_AGAIN = 0.25
_FADED = 0.5
_WIDE_RAD = 0.1
_GOOD_MAPS = 0.2
_SELDOM_CARRIED = 1e-4
_LEAST_PLACE_SD_M = 0.005
_LEAST_LEVEL_SD_DB = 0.3


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
    shares : (t,) float64 — Power over the local mean of the error field that is expected of the map
        [-].
    floors_w : (t,) float64 — Power of it that is the same everywhere, also in shadows [W].
    low_m, high_m : (2,) float64 — Rectangle of the floor [m].
    blocked : Where the robot's centre cannot be; None: nowhere.
    wavelength_m, radius_m : Shortest wavelength [m]; distance of the antennas from the axis [m].
    noise_db : Deviation of a reading's noise [dB].
    fading_db : (t,) float64 — Deviation of the coherent level around the local mean [dB].
    level_db, gain_db : Deviations of tags' levels and of antennas' gains from the map's [dB].
    survey : Of tags that may hang elsewhere than the maps have them, by more than the maps can
        bear; None: they hang where they should. While the pose is known to 15 cm, an eighth of the
        particles is then weighed by the places that tags may have, and those by the particles.
    survey_sd_m : Deviation of the survey along an axis, where places are not searched for [m].
    known : What earlier missions have found of levels, gains and places; None: nothing.
    base_m, base_sd_m : (t, 3) float64 — Where the maps have the tags, from their surveyed places,
        and how exactly that is known; None: there, and exactly [m].
    particles : Number of particles, at least.
    trust : Power of a reading's likelihood: the error field is alike at places close by [-].
    outlier_share, outlier_db : Prior share of outliers [-], and their deviation [dB].
    fresh_share : Share of new particles, anywhere, at each drawing [-].
    travel_sd, slip_sd_m, slip_sd_rad : Deviation of odometry's error: as a share of way and turn
        [-]; in a period in which the robot moves [m], [rad].
    rivals_limit : Share of the last readings that poses drawn anywhere explain better, beyond which
        the pose is lost [-]; see `limit_of`.
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
    survey: TagSurvey | None = None
    survey_sd_m: float = 0.0
    known: Learned | None = None
    base_m: FloatArray | None = None
    base_sd_m: FloatArray | None = None
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
    rivals_limit: float = _RIVALS
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

    def _share(self, belief: PoseBelief | None = None) -> tuple[float, float]:
        """Return the shares of the error field that the field maps should have, and may have.

        The poses between particles are not looked at: their distance counts as an error of the map.
        The survey may be exact, or as it says.
        """
        gap_m = 0.0 if belief is None else self._gap_m(belief, len(belief.weights))
        off_m = self.survey_sd_m
        if self.survey is not None:
            off_m = math.sqrt(float(np.mean(self.survey.sd_m**2)))
        share = float(np.mean(self.shares))
        return share + self._misplaced(gap_m), share + self._misplaced(math.hypot(off_m, gap_m))

    def _place_shares(self, gap_m: float, place_gaps_m: Iterable[float]) -> FloatArray:
        """Return what the field at places of the tags is expected to lack, (t,) [-].

        gap_m and place_gaps_m (t,) are how far poses and places are apart, of which some stand for
        all.
        """
        more = [self._misplaced(math.hypot(gap_m, one)) for one in place_gaps_m]
        shares: FloatArray = self.shares + np.array(more)
        return shares

    def _misplaced(self, sd_m: float) -> float:
        return misplaced_share(sd_m, wavelength_m=self.wavelength_m)

    def _gap_m(self, belief: PoseBelief, count: int) -> float:
        """Return about how far so many particles are apart, turns as the antennas move [m].

        The volume of a normal distribution is (2 pi)^(3/2) times its deviations; particles in
        several cells share them.
        """
        number = pose_cells(belief.poses)
        shares = np.bincount(number, weights=belief.weights)
        inside = number == int(np.argmax(shares))
        place, heading = belief.poses[:2, inside], belief.poses[2, inside]
        turn = wrap_angle(heading - heading[0])
        spread = np.array([*place.std(axis=1), self.radius_m * float(np.std(turn))])
        volume = (2.0 * math.pi) ** 1.5 * float(np.prod(np.maximum(spread, 1e-4)))
        shares = shares[shares > 0.0]
        cells = math.exp(-float(np.sum(shares * np.log(shares))))
        return float((cells * volume / count) ** (1.0 / 3.0))

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
        hypotheses = len(supposed_shares(0.0))
        prior = np.full(hypotheses + 1, (1.0 - self.outlier_share) / hypotheses)
        prior[-1] = self.outlier_share
        belief = PoseBelief(
            poses=poses,
            weights=np.full(count, 1.0 / count),
            trusted=np.tile(prior, (tags, 1)),
            level_db=np.zeros(tags),
            level_variance=np.full(tags, self.level_db**2),
            gain_db=np.zeros(antennas),
            gain_variance=np.full(antennas, self.gain_db**2),
            places=None if self.survey is None else self.survey.start(rng),
            proof=0.0 if pose is None else MOST_PROOF,
        )
        if self.known is None:
            return belief
        return replace(
            belief,
            level_db=self.known.level_db,
            level_variance=self.known.level_sd_db**2,
            gain_db=self.known.gain_db,
            gain_variance=self.known.gain_sd_db**2,
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
        reading = self._reading(rss_db, belief)
        searching = self._searching(belief)
        logs, parts, told = self._explained(belief, reading, rng, searching=searching)
        before, weights = weights / weights.sum(), weights * np.exp(logs - logs.max())
        here = float(logs.max()) + math.log(float(weights.sum()))
        weights = weights / weights.sum()
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
        ratio = np.prod(parts[:, :, -2] / belief.trusted[:, -2], axis=1)
        weighed = weighed.compared(math.log(float(weights @ ratio) + 1e-300))
        weighed = replace(weighed, estimate=agreed(weighed))
        weighed = self._learned(weighed, rss_db)
        if searching:
            weighed = self._placed(weighed, reading, before, told, rng)
        count = max(self._wanted(weighed, searching=searching), round(_KEPT * len(weights)))
        if len(weights) > 1.2 * self.particles:  # the pose is open: particles are everywhere
            weighed = replace(weighed, rivals=(1.0 - _RIVAL_SHARE) * belief.rivals)
            return self._drawn_anew(weighed, count, rng, scouts=None)
        if self.survey is None:
            return self._challenged(weighed, reading, float(logs.max()), count, rng)
        some = belief.poses[:, systematic(before, POSES, rng)]
        plain, _ = reading.by_map(self.maps, some, share=self._share(belief))
        # Furniture that the maps lack can make places worth less than the local mean.
        return self._judged(weighed, reading, max(here, _mean_of_logs(plain)), count, rng)

    def _explained(
        self, belief: PoseBelief, reading: Reading, rng: np.random.Generator, *, searching: bool
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return log-likelihoods (m,) of the poses, the shares' probabilities, and each tag's part.

        By places of the tags where these are known, or being searched for: else by the field maps,
        and without (m, t) of the tags.
        """
        places, poses = belief.places, belief.poses
        if places is None or not (searching or self._found(places)):
            logs, parts = reading.by_map(self.maps, poses, share=self._share(belief))
            return logs, parts, np.empty((len(logs), 0))
        sds_m = places.sd_m()
        drawn = [PLACES if searching and sd > _SETTLED_M else None for sd in sds_m]
        gaps_m = [
            sd if count is None else places.gap_m(tag, count)
            for tag, (sd, count) in enumerate(zip(sds_m, drawn, strict=True))
        ]
        shares = self._place_shares(self._gap_m(belief, poses.shape[1]), gaps_m)
        told, parts = reading.by_places(self.maps, places, poses, rng, drawn=drawn, shares=shares)
        return told.sum(axis=1), parts, told

    def _challenged(
        self,
        belief: PoseBelief,
        reading: Reading,
        best: float,
        count: int,
        rng: np.random.Generator,
    ) -> PoseBelief:
        """Return the belief after its best pose, of log-likelihood best, met poses drawn anywhere.

        Those that explain the reading better become particles.
        """
        many = belief.rivals > 0.5 * self.rivals_limit
        scouts = self._anywhere(_MANY_SCOUTS if many else _SCOUTS, rng)
        logs, _ = reading.by_map(self.maps, scouts, share=self._share(belief))
        won = bool(logs.max() > best)
        rivals = (1.0 - _RIVAL_SHARE) * belief.rivals + _RIVAL_SHARE * won
        belief = replace(belief, rivals=rivals)
        if self.lost(belief):
            return self._anew(belief, rng)
        if not won and _many_count(belief):
            return belief
        fresh = max(1, round((_WON_SHARE if won else self.fresh_share) * count))
        return self._drawn_anew(belief, count, rng, scouts=self._likely(scouts, logs, fresh, rng))

    def _judged(
        self,
        belief: PoseBelief,
        reading: Reading,
        here: float,
        count: int,
        rng: np.random.Generator,
    ) -> PoseBelief:
        """Return the belief after its evidence was compared with that of poses drawn anywhere.

        The likelihood's mean over poses drawn anywhere, over its mean by the belief, exp(here), is
        on average at most 1 as long as the belief is right, whatever the maps are worth; a sum of
        logarithms that never falls below 0 exceeds 20 by chance hardly ever. Until as much speaks
        for the belief, poses that explain the reading become particles.
        """
        scouts = self._anywhere(_SCOUTS if belief.proven else _MANY_SCOUTS, rng)
        logs, _ = reading.by_map(self.maps, scouts, share=self._share(belief))
        belief = belief.judged(_mean_of_logs(logs) - here)
        if belief.doubt > _DOUBT:
            return self._anew(belief.unlearned(), rng)
        if belief.proven:
            return (
                belief if _many_count(belief) else self._drawn_anew(belief, count, rng, scouts=None)
            )
        fresh = round(_WON_SHARE * count)
        return self._drawn_anew(belief, count, rng, scouts=self._likely(scouts, logs, fresh, rng))

    def _likely(
        self, scouts: FloatArray, logs: FloatArray, count: int, rng: np.random.Generator
    ) -> FloatArray:
        chosen = np.exp(self.trust * (logs - logs.max()))
        likely: FloatArray = scouts[:, systematic(chosen, count, rng)]
        return likely

    def _searching(self, belief: PoseBelief) -> bool:
        """Return whether the pose is known well enough to look for the tags' places by it.

        At a wrong pose places would be found that fit it, and nothing would ever contradict it.
        """
        if belief.places is None or self.lost(belief) or belief.faded > _FADED:
            return False
        estimate = agreed(belief)
        return estimate.share >= 0.9 and estimate.spread_m <= _PLACED_M

    def _found(self, places: TagPlaces) -> bool:
        """Return whether the tags' places are known so well that any pose is weighed by them."""
        surveyed_m = np.sqrt(np.mean(places.survey.sd_m**2, axis=1))
        left, before = (sum(map(self._misplaced, sd)) for sd in (places.sd_m(), surveyed_m))
        return left < _FOUND * before

    def _placed(
        self,
        belief: PoseBelief,
        reading: Reading,
        before: FloatArray,
        told: FloatArray,
        rng: np.random.Generator,
    ) -> PoseBelief:
        """Return the belief with the tags' places weighed by the reading, and poses by the others'.

        before (m,) and told (m, t) are the particles' weights before the reading, and by how much
        each tag's reading changed their logarithms. A tag whose place is known to some millimetres
        is looked at by every fourth reading.
        """
        if belief.places is None:
            return belief
        others = told.sum(axis=1, keepdims=True) - told
        places = belief.places
        gaps_m = [places.gap_m(tag, len(one)) for tag, one in enumerate(places.weights)]
        logs = reading.of_places(
            self.maps, places, belief.poses, rng,
            weights=before[:, None] * np.exp(others - others.max(axis=0)),
            shares=self._place_shares(self._gap_m(belief, POSES), gaps_m),
            wanted=(places.sd_m() > _SETTLED_M) | (rng.random(self.maps.tags) < _LOOKED_AGAIN),
        )  # fmt: skip
        return replace(belief, places=places.weighed(logs, rng))

    def _anew(self, belief: PoseBelief, rng: np.random.Generator) -> PoseBelief:
        """Return a belief that the robot may be anywhere; levels and gains stay known."""
        fresh = self.start(rng, pose=None)
        return replace(
            belief,
            poses=fresh.poses,
            weights=fresh.weights,
            trusted=fresh.trusted,
            doubt=0.0,
            proof=0.0,
            strange=0.0,
            estimate=None,
        )

    def lost(self, belief: PoseBelief) -> bool:
        """Return whether poses drawn anywhere explain most of the last readings better.

        Where the tags' places are searched for: whether too little speaks for the belief yet, or
        readings are no longer as it foresees them.
        That readings do not fit says that the map is wrong here, or the pose. At a wrong pose the
        best of many others is better; at the right one it is not more often than such maps allow.

        Parameters
        ----------
        belief : The belief.
        """
        if self.survey is not None:
            return not belief.proven or belief.estranged
        return belief.rivals > self.rivals_limit

    def limit_of(self, poses: FloatArray, rss_w: FloatArray, rng: np.random.Generator) -> float:
        """Return beyond which `rivals` the pose is lost, by readings at known poses [-].

        Where the map is poor, poses drawn anywhere explain a reading better even than the right
        one: in a share p of readings. The mean over the last ones, each of which counts 15 % less
        than the next, then has the deviation sqrt(p (1 - p) 0.15 / 1.85); the limit lies three of
        these above p.

        Parameters
        ----------
        poses : (m, 3) float64 — x, y [m], heading [rad].
        rss_w : (t, m, n) float64 — RSS of every tag there, without noise [W].
        rng : Source of noise and poses.
        """
        beaten = 0
        for number, pose in enumerate(poses):
            rss_db = np.full(rss_w[:, number].shape, -np.inf)
            heard = rss_w[:, number] > 0.0
            noise_db = self.noise_db * rng.standard_normal(int(heard.sum()))
            rss_db[heard] = decibels(rss_w[:, number][heard]) + noise_db
            belief = self.start(rng, pose=pose)
            reading, share = self._reading(rss_db, belief), self._share(belief)
            here, _ = reading.by_map(self.maps, belief.poses, share=share)
            there, _ = reading.by_map(self.maps, self._anywhere(_MANY_SCOUTS, rng), share=share)
            beaten += bool(there.max() > here.max())
        p = beaten / max(1, len(poses))
        sd = math.sqrt(p * (1.0 - p) * _RIVAL_SHARE / (2.0 - _RIVAL_SHARE))
        return min(max(p + 3.0 * sd, _RIVALS), _MOST_RIVALS)

    def estimate(self, belief: PoseBelief) -> PoseEstimate:
        """Return mean and covariance of the particles around the heaviest cell.

        Parameters
        ----------
        belief : The particles.
        """
        return belief.estimate or agreed(belief)

    def _reading(self, rss_db: FloatArray, belief: PoseBelief) -> Reading:
        return Reading(
            rss_db=rss_db,
            level_db=belief.level_db,
            level_variance=belief.level_variance,
            gain_db=belief.gain_db,
            trusted=belief.trusted,
            floors_w=self.floors_w,
            fading_db=self.fading_db,
            noise_db=max(self.noise_db, 0.1),
            outlier_db=self.outlier_db,
            trust=self.trust,
        )

    def _learned(self, belief: PoseBelief, rss_db: FloatArray) -> PoseBelief:
        """Return the belief with levels and gains moved by the errors at the estimate."""
        estimate = self.estimate(belief)
        if estimate.share < 0.9 or estimate.spread_m > _EXPLORED:
            return belief
        pose = estimate.pose[None]
        level, level_variance = belief.level_db.copy(), belief.level_variance.copy()
        gain, gain_variance = belief.gain_db.copy(), belief.gain_variance.copy()
        shares, places = np.full(self.maps.tags, self._share()[0]), belief.places
        more = self._share()[1] if places is None else 0.0
        if places is not None:
            shares = self.shares + np.array([self._misplaced(sd) for sd in places.sd_m()])
        for t in range(self.maps.tags):
            if places is None:
                here = self.maps.rss_w(pose, tag=t)[0]
            else:
                there = places.mean_m()[t : t + 1]
                here = places.survey.paths[t].shifted_w(pose, there)[0, 0]
            told = belief.trusted[t, :-1]
            expected = float(told @ supposed_shares(float(shares[t]), more) / told.sum())
            mean = self.maps.local_mean_w(pose, tag=t)[0]
            sound = (rss_db[t] > -np.inf) & (mean > 0.0)
            if not sound.any():
                continue
            diffuse = expected * mean[sound] + self.floors_w[t]
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

    def offsets_m(self, belief: PoseBelief) -> FloatArray:
        """Return where each tag is believed to hang, from its surveyed place, (t, 3) [m].

        Parameters
        ----------
        belief : The belief.
        """
        off_m = np.zeros((self.maps.tags, 3)) if self.base_m is None else self.base_m
        return off_m if belief.places is None else off_m + belief.places.mean_m()

    def learned(self, belief: PoseBelief, tags: tuple[str, ...]) -> Learned | None:
        """Return what the next mission can use of a belief; None: it does not know where it is.

        Parameters
        ----------
        belief, tags : At the end of a mission; ids of the tags, in the order of the maps.
        """
        estimate = self.estimate(belief)
        if self.lost(belief) or estimate.share < 0.9 or estimate.spread_m > _EXPLORED:
            return None
        offset_m = self.offsets_m(belief)
        offset_sd_m = np.zeros((len(tags), 3)) if self.base_sd_m is None else self.base_sd_m
        if belief.places is not None:
            sd_m = np.maximum(belief.places.sd_m(), _LEAST_PLACE_SD_M)
            offset_sd_m = np.tile(sd_m[:, None], (1, 3))
        return Learned(
            tags=tags,
            offset_m=offset_m,
            offset_sd_m=offset_sd_m,
            level_db=belief.level_db,
            level_sd_db=np.sqrt(np.maximum(belief.level_variance, _LEAST_LEVEL_SD_DB**2)),
            gain_db=belief.gain_db,
            gain_sd_db=np.sqrt(np.maximum(belief.gain_variance, _LEAST_LEVEL_SD_DB**2)),
            missions=1 if self.known is None else self.known.missions + 1,
        )

    def taught(self, known: Learned) -> "PoseFilter":
        """Return the filter with what earlier missions have found.

        Parameters
        ----------
        known : Of the same tags, in the order of the maps [m], [dB].
        """
        survey = self.survey
        if survey is not None:
            off_m = known.offset_m if self.base_m is None else known.offset_m - self.base_m
            survey = replace(survey, known_m=off_m, known_sd_m=known.offset_sd_m)
        return replace(self, survey=survey, known=known)

    def _wanted(self, belief: PoseBelief, *, searching: bool) -> int:
        """Return how many particles the belief needs: some for each cell that really counts."""
        number = pose_cells(belief.poses)
        shares = np.bincount(number, weights=belief.weights)
        cells = math.exp(-float(np.sum(shares[shares > 0.0] * np.log(shares[shares > 0.0]))))
        least = self.particles // _PLACED_PART if searching else self.particles
        return round(max(least, min(_MOST, _PER_CELL * cells)))

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
        chosen = systematic(belief.weights, kept, rng)
        poses = belief.poses[:, chosen]
        poses[:2] += _BLUR_M * rng.standard_normal((2, kept))
        poses[2] += _BLUR_RAD * rng.standard_normal(kept)
        if float(np.mean(self.shares)) < _GOOD_MAPS:
            # What only the local mean explains leaves the pose open by about a wavelength; where
            # maps are poor, most readings are such, and the way driven is the better guide.
            wide = rng.random(kept) < belief.faded
            poses[:2] += wide * self.wavelength_m * rng.standard_normal((2, kept))
            poses[2] += wide * _WIDE_RAD * rng.standard_normal(kept)
        known = belief.places is not None and belief.proven
        share = _SELDOM_CARRIED if known else _FRESH_WEIGHT
        weights = np.concatenate(
            [np.full(kept, (1.0 - share) / kept), np.full(fresh, share / fresh)]
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


def _many_count(belief: PoseBelief) -> bool:
    """Return whether half of the particles count, or more."""
    return bool(1.0 / float(np.sum(belief.weights**2)) >= 0.5 * len(belief.weights))


def _mean_of_logs(logs: FloatArray) -> float:
    """Return the logarithm of the mean likelihood."""
    best = float(logs.max())
    return best + math.log(float(np.mean(np.exp(logs - best))))


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
