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
from octant.navigation.navigators.drawing import systematic
from octant.navigation.navigators.interface import Odometry
from octant.navigation.navigators.learned import Learned
from octant.navigation.navigators.pose_belief import PoseBelief, PoseEstimate, agreed, pose_cells
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
_FRESH_WEIGHT = 0.01
_RIVALS, _MOST_RIVALS = 0.35, 0.95
_KEPT = 0.7
_PLACED_M = 0.15
_PLACED_PART = 8
_DOUBT = 20.0
_SETTLED_M = 0.02
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
    shares : (t,) float64 — Power over the local mean of the error field that is expected of map and
        survey [-].
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

    def _share(self, belief: PoseBelief | None = None) -> float:
        """Return the share of the error field that the field maps are expected to have.

        The poses between particles are not looked at: their distance counts as an error of the map;
        so does the survey, where the tags' places are searched for.
        """
        share = float(np.mean(self.shares))
        off_m = 0.0 if self.survey is None else math.sqrt(float(np.mean(self.survey.sd_m**2)))
        if belief is not None:
            off_m = math.hypot(off_m, self._gap_m(belief, len(belief.weights)))
        return share + misplaced_share(off_m, wavelength_m=self.wavelength_m)

    def _place_shares(
        self, belief: PoseBelief, places: TagPlaces, *, poses: int, drawn: int | None
    ) -> FloatArray:
        """Return the same of each tag for drawn poses and places: both have gaps, (t,)."""
        gap = self._gap_m(belief, poses)
        gaps = [
            math.hypot(gap, places.gap_m(tag, drawn or len(places.weights[tag])))
            for tag in range(self.maps.tags)
        ]
        more = [misplaced_share(g, wavelength_m=self.wavelength_m) for g in gaps]
        shares: FloatArray = self.shares + np.array(more)
        return shares

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
        near, told, share = self._near(belief), np.empty(0), self._share(belief)
        placed, drawn = (near, PLACES) if near is not None else (self._settled(belief), 1)
        if placed is not None:
            told, parts = reading.by_places(
                self.maps, placed, belief.poses, rng, drawn=drawn,
                shares=self._place_shares(belief, placed, poses=len(weights), drawn=drawn),
            )  # fmt: skip
            logs = told.sum(axis=1)
        else:
            logs, parts = reading.by_map(self.maps, belief.poses, share=share)
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
        weighed = replace(weighed, estimate=agreed(weighed))
        weighed = self._learned(weighed, rss_db)
        if near is not None:
            weighed = self._placed(weighed, reading, before, told, rng)
        count = max(self._wanted(weighed), round(_KEPT * len(weights)))
        if len(weights) > 1.2 * self.particles:  # the pose is open: particles are everywhere
            weighed = replace(weighed, rivals=(1.0 - _RIVAL_SHARE) * belief.rivals)
            return self._drawn_anew(weighed, count, rng, scouts=None)
        many = belief.rivals > 0.5 * self.rivals_limit
        scouts = self._anywhere(_MANY_SCOUTS if many else _SCOUTS, rng)
        rival_logs, _ = reading.by_map(self.maps, scouts, share=share)
        if self.survey is not None:
            some = belief.poses[:, systematic(before, POSES, rng)]
            plain, _ = reading.by_map(self.maps, some, share=share)
            here = max(here, _mean_of_logs(plain))
            return self._doubted(weighed, _mean_of_logs(rival_logs) - here, count, rng)
        won = bool(rival_logs.max() > logs.max())
        weighed = replace(weighed, rivals=(1.0 - _RIVAL_SHARE) * belief.rivals + _RIVAL_SHARE * won)
        if self.lost(weighed):
            return self._anew(weighed, rng)
        if not won and 1.0 / float(np.sum(weights**2)) >= 0.5 * len(weights):
            return weighed
        chosen = np.exp(self.trust * (rival_logs - rival_logs.max()))
        fresh = max(1, round((0.2 if won else self.fresh_share) * count))
        scouts = scouts[:, systematic(chosen, fresh, rng)]
        return self._drawn_anew(weighed, count, rng, scouts=scouts)

    def _near(self, belief: PoseBelief) -> TagPlaces | None:
        """Return the tags' places if the pose is known well enough to look for them by it."""
        if belief.places is None:
            return None
        estimate = agreed(belief)
        known = estimate.share >= 0.9 and estimate.spread_m <= _PLACED_M
        return belief.places if known else None

    def _settled(self, belief: PoseBelief) -> TagPlaces | None:
        """Return the tags' places if they are known, wherever the robot is."""
        if belief.places is None or float(belief.places.sd_m().max()) > _SETTLED_M:
            return None
        return belief.places

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
        each tag's reading changed their logarithms.
        """
        if belief.places is None:
            return belief
        others = told.sum(axis=1, keepdims=True) - told
        logs = reading.of_places(
            self.maps, belief.places, belief.poses, rng,
            weights=before[:, None] * np.exp(others - others.max(axis=0)),
            shares=self._place_shares(belief, belief.places, poses=POSES, drawn=None),
        )  # fmt: skip
        return replace(belief, places=belief.places.weighed(logs, rng))

    def _doubted(
        self,
        belief: PoseBelief,
        against: float,
        count: int,
        rng: np.random.Generator,
    ) -> PoseBelief:
        """Return the belief after its evidence was compared with that of poses drawn anywhere.

        The likelihood's mean over poses drawn anywhere, over its mean by the belief, is on average
        at most 1 as long as the belief is right, whatever the maps are worth; a sum of logarithms
        that never falls below 0 exceeds 20 by chance hardly ever. Furniture that the maps lack can
        make the tags' places worth less than the local mean: the better of the two counts.
        """
        doubt = max(0.0, belief.doubt + against)
        if doubt > _DOUBT:
            return self._anew(replace(belief, rivals=1.0, doubt=0.0), rng)
        belief = replace(belief, doubt=doubt, rivals=(1.0 - _RIVAL_SHARE) * belief.rivals)
        if 1.0 / float(np.sum(belief.weights**2)) >= 0.5 * len(belief.weights):
            return belief
        return self._drawn_anew(belief, count, rng, scouts=None)

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
        best of many others is better; at the right one it is not more often than such maps allow.

        Parameters
        ----------
        belief : The belief.
        """
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
        shares, places = np.full(self.maps.tags, self._share()), belief.places
        if places is not None:
            shares = self.shares + np.array(
                [misplaced_share(sd, wavelength_m=self.wavelength_m) for sd in places.sd_m()]
            )
        for t in range(self.maps.tags):
            if places is None:
                here = self.maps.rss_w(pose, tag=t)[0]
            else:
                there = places.mean_m()[t : t + 1]
                here = places.survey.paths[t].shifted_w(pose, there)[0, 0]
            told = belief.trusted[t, :-1]
            expected = float(told @ supposed_shares(float(shares[t])) / told.sum())
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

    def _wanted(self, belief: PoseBelief) -> int:
        """Return how many particles the belief needs: some for each cell that really counts."""
        number = pose_cells(belief.poses)
        shares = np.bincount(number, weights=belief.weights)
        cells = math.exp(-float(np.sum(shares[shares > 0.0] * np.log(shares[shares > 0.0]))))
        least = self.particles // _PLACED_PART if self._near(belief) is not None else self.particles
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
        share = _FRESH_WEIGHT if belief.places is None else _SELDOM_CARRIED
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
