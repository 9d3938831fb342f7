"""Where the tag is, seen from the robot: particles weighed by what the reader's patterns explain.

All readings of a leg depend on one place. One may point anywhere; many agree only at the tag.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.decibels import decibels
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.checks import check_positive
from octant.navigation.navigators._place_kernels import place_log_likelihood
from octant.navigation.navigators.interface import Odometry
from octant.navigation.robot.motion import Integration
from octant.navigation.sensing.pattern_match import NULL_SHARE, PowerTable

FloatArray = npt.NDArray[np.float64]
_Reals = float | FloatArray

TRUST = 0.25
"""Power of the likelihood of a reading [-]."""

FADING_DB = 6.0
"""Standard deviation of an antenna's RSS where the diffuse wave dominates [dB]."""

LEVEL_DB = 10.0
"""Standard deviation of a tag's unknown level [dB]."""

_FIRST_FACTOR = 4
_FIRST_REACH_M = 8.0
_MOST_AREAS = 50.0
_CELL_M = 0.5
_NEAR_M = 1.0
_STRONGEST_DIFFUSE_DB = 0.0
_WEAKEST_DIFFUSE_DB = -80.0
_BLUR_M = 0.03
_BLUR_DB = 0.7


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceBelief:
    """What is believed of the tag's place.

    Parameters
    ----------
    places : (9, m) float64 — Of each particle: the tag ahead and to the left of the robot [m], the
        diffuse field's level over the table's reference [dB], the robot's heading in the frame of
        the tags' orientation [rad]; by how much all antennas read more than the table says, because
        of the tag and because of where the robot stands: means [dB], then the first's variance,
        their covariance and the second's variance [dB²].
    weights : (m,) float64 — Their probabilities, adding up to one [-].
    """

    places: FloatArray
    weights: FloatArray

    def __post_init__(self) -> None:
        places = frozen_array(self.places, name="places", shape=(9, None), error=NavigationError)
        weights = frozen_array(
            self.weights, name="weights", shape=(places.shape[1],), error=NavigationError
        )
        object.__setattr__(self, "places", places)
        object.__setattr__(self, "weights", weights)

    @property
    def effective_size(self) -> float:
        """Return the number of particles that really count, 1/Σ w² [-]."""
        return float(1.0 / np.sum(self.weights**2))


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceEstimate:
    """The place on which most particles agree.

    Parameters
    ----------
    place_m : (2,) float64 — Ahead of the robot and to its left [m].
    share : Probability that the tag is within 1 m of there [-].
    covariance_m2 : (2, 2) float64 — Of the particles within 1 m [m²].
    heading_rad, heading_sd_rad : Mean and deviation of the robot's heading over them [rad].
    level_db : Mean of the tag's level over the table's [dB].
    """

    place_m: FloatArray
    share: float
    covariance_m2: FloatArray
    heading_rad: float
    heading_sd_rad: float
    level_db: float

    @property
    def distance_m(self) -> float:
        """Return the distance to the place along the floor [m]."""
        return math.hypot(float(self.place_m[0]), float(self.place_m[1]))

    @property
    def bearing_rad(self) -> float:
        """Return the bearing from the robot's front, counter-clockwise positive [rad]."""
        return math.atan2(float(self.place_m[1]), float(self.place_m[0]))

    @property
    def spread_m(self) -> float:
        """Return the root of the covariance's trace [m]."""
        return math.sqrt(float(np.trace(self.covariance_m2)))


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceFilter:
    """An estimator of a tag's place from readings and odometry.

    An antenna at a supposed place expects P_i + D: the table's direct power and the power D from
    everywhere, which each particle supposes for itself. The error in decibels has the variance
    noise² + fading² f(2 - f) with the diffuse share f = D/(P_i + D): under a tag, in the dipoles'
    null, a reading says little about bearings and the filter knows it. Nulls below `NULL_SHARE` of
    the mean count as that deep. A reading may be an outlier and change nothing.

    All antennas share an error too, in two parts that each particle estimates (a Kalman filter of
    two states): the tag's level, which stays, and a part that belongs to where the robot stands and
    fades along the way. Where the diffuse wave dominates, each reading adds one of its own. The
    antennas sample one field: more than `independent` say no more than so many. The defaults were
    found in rooms drawn at random, see `benchmarks/search_tracker.py`.

    Parameters
    ----------
    table : RSS of the reader for relative places of a tag, free of reflections.
    particles, most : Number of particles, at least and at most.
    per_cell : In between, particles for each cell of 0.5 m among which the belief is divided [-].
    noise_db, fading_db : Standard deviations where the direct, the diffuse wave dominates [dB].
    level_db : Standard deviation of the tag's level over the table's before the first reading [dB].
    shared_db, shared_m : The same of the error that all antennas share where the robot stands [dB],
        and the way along which its correlation falls to 1/e [m].
    outlier_share : Probability of a reading apart from the tag's place, in (0, 1) [-].
    trust : Power of the likelihood of a reading, in (0, 1] [-]: nearby readings share their fading.
    independent : Number of antennas whose errors are independent, at most [-].
    contact_m, contact_weight : A contact counts against places ahead, by this share at the robot
        and e times less for each such distance [m], [-].
    fresh_share : Share of new particles, anywhere, at each drawing [-]; they find lost tags.
    loyalty : Cells within 1 m of the place to which the robot was driving count so many times [-].
    travel_sd : Standard deviation of odometry's error as a share of way and turn [-].
    heading_sd_rad : The same for the turn of a period, added [rad].
    method : How a period's motion is added up, as in `motion.move`.
    """

    table: PowerTable
    particles: int = 2000
    most: int = 10000
    per_cell: float = 500.0
    noise_db: float = 2.0
    fading_db: float = FADING_DB
    level_db: float = LEVEL_DB
    outlier_share: float = 0.05
    shared_db: float = 3.5
    shared_m: float = 0.7
    trust: float = TRUST
    independent: float = 8.0
    contact_m: float = 0.5
    contact_weight: float = 0.9
    fresh_share: float = 0.01
    loyalty: float = 3.0
    travel_sd: float = 0.05
    heading_sd_rad: float = 0.01
    method: Integration = "rk2"

    def __post_init__(self) -> None:
        for name, unit in (
            ("particles", "particles"),
            ("most", "particles"),
            ("per_cell", "particles"),
            ("noise_db", "dB"),
            ("fading_db", "dB"),
            ("level_db", "dB"),
            ("shared_db", "dB"),
            ("shared_m", "m"),
            ("independent", "antennas"),
            ("loyalty", "1"),
            ("contact_m", "m"),
            ("travel_sd", "1"),
            ("heading_sd_rad", "rad"),
        ):
            check_positive(getattr(self, name), name=name, unit=unit)
        shares = (self.outlier_share, self.trust, self.fresh_share)
        if not (0.0 < shares[0] < 1.0 and 0.0 < shares[1] <= 1.0 and 0.0 <= shares[2] < 1.0):
            msg = (
                f"outlier_share, trust and fresh_share are {shares}, but they must lie between 0 "
                "and 1: 0.05, 0.3 and 0.01 suit a concrete room."
            )
            raise NavigationError(msg)

    def start(
        self, rng: np.random.Generator, *, heading_rad: float, heading_sd_rad: float
    ) -> PlaceBelief:
        """Return the belief before the first reading: the tag is anywhere in reach."""
        area = (self.table.reach_m / _FIRST_REACH_M) ** 2
        count = round(_FIRST_FACTOR * self.particles * min(max(area, 1.0), _MOST_AREAS))
        headings = rng.normal(heading_rad, heading_sd_rad, count)
        return PlaceBelief(
            places=self._anywhere(headings, rng), weights=np.full(count, 1.0 / count)
        )

    def moved(
        self, belief: PlaceBelief, odometry: Odometry, rng: np.random.Generator
    ) -> PlaceBelief:
        """Return the belief seen from the new pose; after a contact it went any part of the way.

        Parameters
        ----------
        belief : Belief before.
        odometry : The motion.
        rng : Source of the odometry's errors, one for each particle.
        """
        count = len(belief.weights)
        if odometry.contact:
            part = rng.random(count)  # the wheels spun on where the robot had stopped
        else:
            part = 1.0 + self.travel_sd * rng.standard_normal(count)
        way = odometry.distance_m * part
        turn = odometry.turn_rad * (1.0 + self.travel_sd * rng.standard_normal(count))
        turn += self.heading_sd_rad * rng.standard_normal(count)
        alike = np.exp(-np.abs(way) / self.shared_m)
        places = np.array(
            [
                *seen_after(belief.places[:2], way_m=way, turn_rad=turn, method=self.method),
                belief.places[2],
                belief.places[3] + turn,
                belief.places[4],
                alike * belief.places[5],
                belief.places[6],
                alike * belief.places[7],
                alike**2 * belief.places[8] + (1.0 - alike**2) * self.shared_db**2,
            ]
        )
        weights = belief.weights
        if odometry.contact:
            weights = weights * self._free_way(places, forward=odometry.distance_m >= 0.0)
            weights /= weights.sum()
        return PlaceBelief(places=places, weights=weights)

    def _free_way(self, places: FloatArray, *, forward: bool) -> FloatArray:
        """Return how probable a contact is where the tag is at each place, (m,) [-].

        The robot can drive under the tag: what it touches does not stand there. The nearer a place
        lies in the direction of the contact, the less room is left for an obstacle before it.
        """
        way_m = np.hypot(places[0], places[1])
        towards = np.maximum((places[0] if forward else -places[0]) / np.maximum(way_m, 1e-9), 0.0)
        near = np.exp(-way_m / self.contact_m)
        return np.asarray(1.0 - self.contact_weight * towards * near)

    def observed(
        self,
        belief: PlaceBelief,
        rss_w: FloatArray,
        rng: np.random.Generator,
    ) -> PlaceBelief:
        """Return the belief weighed by a reading, drawn anew when under half the particles count.

        Parameters
        ----------
        belief : Belief before.
        rss_w : (n,) float64 — The reading; without any signal the belief stays [W].
        rng : Source of the new particles.
        """
        heard = rss_w > 0.0
        if not heard.any():
            return belief
        rss_db = np.full(len(rss_w), -np.inf)
        rss_db[heard] = decibels(rss_w[heard] + NULL_SHARE * rss_w[heard].mean())
        found = np.empty((3, len(belief.weights)))
        place_log_likelihood(
            belief.places,
            self.table.reach_m,
            self.table.power_w,
            10.0 * math.log10(self.table.reference_w),
            rss_db,
            self.noise_db,
            self.fading_db,
            self.trust,
            NULL_SHARE,
            self.independent,
            found,
        )
        logs, above_db, variance = found
        likelihood = (1.0 - self.outlier_share) * np.exp((logs - logs.max()) / self.trust)
        outlier = (
            self.outlier_share / (1.0 - self.outlier_share) * float(belief.weights @ likelihood)
        )
        weights = belief.weights * (likelihood + outlier) ** self.trust
        weighed = PlaceBelief(
            places=levels_learned(
                belief.places, above_db, variance, likelihood / (likelihood + outlier)
            ),
            weights=weights / weights.sum(),
        )
        count = self._wanted(weighed)
        if len(weights) > 2 * count or weighed.effective_size < 0.5 * len(weights):
            return self._drawn_anew(weighed, count, rng)
        return weighed

    def estimate(self, belief: PlaceBelief, *, held_m: FloatArray | None = None) -> PlaceEstimate:
        """Return mean and covariance of the particles within 1 m of the heaviest cell of 0.5 m.

        Parameters
        ----------
        belief : The particles.
        held_m : (2,) float64 — The place to which the robot was driving, ahead and to the left [m].
        """
        ahead, left, _, heading, level_db = belief.places[:5]
        centres, shares = _cells(belief)
        if held_m is not None:
            held = np.linalg.norm(centres - held_m, axis=1) < _NEAR_M
            shares = np.where(held, self.loyalty * shares, shares)
        place = centres[int(np.argmax(shares))]
        for _ in range(2):
            near = (ahead - place[0]) ** 2 + (left - place[1]) ** 2 < _NEAR_M**2
            weight = belief.weights * near
            share = float(weight.sum())
            place = belief.places[:2] @ weight / share
        off = belief.places[:2] - place[:, None]
        mean = float(heading @ weight) / share
        return PlaceEstimate(
            place_m=place,
            share=share,
            covariance_m2=np.asarray((off * weight) @ off.T / share),
            heading_rad=mean,
            heading_sd_rad=math.sqrt(float((heading - mean) ** 2 @ weight) / share),
            level_db=float(level_db @ weight) / share,
        )

    def _anywhere(self, headings: FloatArray, rng: np.random.Generator) -> FloatArray:
        count = len(headings)
        far = self.table.reach_m * np.sqrt(rng.random(count))
        side = rng.uniform(-np.pi, np.pi, count)
        diffuse = rng.uniform(_WEAKEST_DIFFUSE_DB, _STRONGEST_DIFFUSE_DB, count)
        return np.array(
            [
                far * np.cos(side),
                far * np.sin(side),
                diffuse,
                headings,
                np.zeros(count),
                np.zeros(count),
                np.full(count, self.level_db**2),
                np.zeros(count),
                np.full(count, self.shared_db**2),
            ]
        )

    def _wanted(self, belief: PlaceBelief) -> int:
        """Return how many particles the belief needs: the more cells share it, the more."""
        _, shares = _cells(belief)
        return round(max(self.particles, min(self.most, self.per_cell / np.sum(shares**2))))

    def _drawn_anew(self, belief: PlaceBelief, count: int, rng: np.random.Generator) -> PlaceBelief:
        """Return equally heavy particles: systematic resampling, blurred, with some fresh ones."""
        fresh = round(self.fresh_share * count)
        kept = count - fresh
        steps = (rng.random() + np.arange(kept)) / kept
        edges = np.cumsum(belief.weights)
        chosen = np.minimum(np.searchsorted(edges, steps * edges[-1]), len(edges) - 1)
        places = belief.places[:, chosen]
        places[:2] += _BLUR_M * rng.standard_normal((2, kept))
        places[2] += _BLUR_DB * rng.standard_normal(kept)
        return PlaceBelief(
            places=np.hstack([places, self._anywhere(places[3, :fresh], rng)]),
            weights=np.full(count, 1.0 / count),
        )


def seen_after(
    place_m: FloatArray, *, way_m: _Reals, turn_rad: _Reals, method: Integration = "rk2"
) -> FloatArray:
    """Return places as seen by the robot after a motion, (2, ...) [m].

    Parameters
    ----------
    place_m : (2, ...) float64 — Ahead of the robot and to its left before [m].
    way_m, turn_rad : (...) float64 — The motion [m], [rad].
    method : As in `motion.move`.
    """
    half = 0.0 if method == "euler" else 0.5 * turn_rad
    chord = way_m * np.sinc(turn_rad / (2.0 * np.pi)) if method == "exact" else way_m
    ahead = place_m[0] - chord * np.cos(half)
    left = place_m[1] - chord * np.sin(half)
    cosine, sine = np.cos(turn_rad), np.sin(turn_rad)
    return np.array([cosine * ahead + sine * left, cosine * left - sine * ahead])


def _cells(belief: PlaceBelief) -> tuple[FloatArray, FloatArray]:
    """Return centres (k, 2) [m] and probabilities (k,) [-] of the cells of 0.5 m."""
    cells = np.floor(belief.places[:2] / _CELL_M).astype(np.int64)
    side = int(np.abs(cells).max()) + 1
    index = (cells[0] + side) * (2 * side + 1) + cells[1] + side
    shares = np.asarray(np.bincount(index, weights=belief.weights), dtype=np.float64)
    held = np.flatnonzero(shares)
    centres = _CELL_M * (np.column_stack(np.divmod(held, 2 * side + 1)) - side + 0.5)
    return centres, shares[held]


def levels_learned(
    places: FloatArray, above_db: FloatArray, variance: FloatArray, believed: FloatArray
) -> FloatArray:
    """Return particles after a Kalman filter's step of the two errors that all antennas share.

    Parameters
    ----------
    places : (9, m) float64 — The particles, see `PlaceBelief`.
    above_db, variance : (m,) float64 — By how much the reading is above what each expects [dB], and
        the variance of that [dB²].
    believed : (m,) float64 — Probability that it is no outlier, which would teach nothing [-].
    """
    learned = places.copy()
    tag, way = places[6] + places[7], places[7] + places[8]
    gain = believed / (tag + way + variance)
    learned[4] += gain * tag * above_db
    learned[5] += gain * way * above_db
    learned[6] -= gain * tag * tag
    learned[7] -= gain * tag * way
    learned[8] -= gain * way * way
    return learned
