"""What is believed of a robot's pose: weighed particles, and the pose on which most agree."""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.navigation.angles import wrap_angle
from octant.navigation.navigators.tag_places import TagPlaces

FloatArray = npt.NDArray[np.float64]

_CELL_M = 0.25
_SECTORS = 12
_NEAR_M = 0.5
_NEAR_RAD = 0.6
_PROVEN = 10.0
_STRANGE, _MOST_STRANGE, _STRANGE_FORGET = 3.0, 20.0, 0.1

MOST_PROOF = 30.0
"""Evidence for a belief [-] at which it is not counted further: a pose that is known."""


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
    places : Where the tags may really hang; None: where they were surveyed.
    doubt : By how much the last readings speak for a robot that may be anywhere, rather than for
        this belief: a log-likelihood, not negative [-].
    proof : By how much the readings since the pose was open, or the known start, speak for this
        belief, rather than for a robot that may be anywhere: not negative, and at most 30 [-].
    rivals : Share of the last readings that were explained better by poses drawn anywhere [-].
    strange : By how much the last readings speak for the local mean alone, though fades were
        foreseen until then: a log-likelihood of which a tenth is forgotten with each reading, not
        negative, and at most 20 [-].
    estimate : The pose after the last reading, before particles are drawn anew; None: of another
        moment.
    sure : The belief when it was proven and nothing spoke against it last; None: never.
    """

    poses: FloatArray
    weights: FloatArray
    trusted: FloatArray
    level_db: FloatArray
    level_variance: FloatArray
    gain_db: FloatArray
    gain_variance: FloatArray
    places: TagPlaces | None = None
    doubt: float = 0.0
    rivals: float = 0.0
    estimate: PoseEstimate | None = None
    proof: float = MOST_PROOF
    strange: float = 0.0
    sure: "PoseBelief | None" = None

    @property
    def proven(self) -> bool:
        """Return whether readings speak for this belief clearly enough to learn from it."""
        return self.proof >= _PROVEN

    @property
    def faded(self) -> float:
        """Return the probability that readings tell no more than the local mean does [-]."""
        return float(np.mean(self.trusted[:, -2:].sum(axis=1)))

    @property
    def estranged(self) -> bool:
        """Return whether readings are no longer as the belief foresees them."""
        return self.strange > _STRANGE

    def compared(self, faded: float) -> "PoseBelief":
        """Return the belief with one more reading in what is strange.

        At a right pose the mean of exp(faded) is at most 1, whatever the maps are worth; at a wrong
        one fades are not where they were foreseen.

        Parameters
        ----------
        faded : Logarithm of the likelihood by the local mean alone, over that by this belief [-].
        """
        strange = max(0.0, (1.0 - _STRANGE_FORGET) * self.strange + faded)
        return replace(self, strange=min(strange, _MOST_STRANGE))

    def judged(self, against: float) -> "PoseBelief":
        """Return the belief with doubt and proof moved by the evidence of one reading.

        Parameters
        ----------
        against : Logarithm of the likelihood's mean over poses drawn anywhere, over its mean by
            this belief before the reading [-].
        """
        doubt = max(0.0, self.doubt + against)
        proof = min(max(0.0, self.proof - against), MOST_PROOF)
        belief = replace(self, doubt=doubt, proof=proof)
        if doubt == 0.0 and belief.proven:
            belief = replace(belief, sure=replace(belief, sure=None))
        return belief

    def unlearned(self) -> "PoseBelief":
        """Return the belief with levels, gains and tags' places as when nothing spoke against it.

        What a sum of evidence that never falls below 0 has found began when it was 0 last: what was
        learned from then on was learned at a wrong pose.
        """
        if self.sure is None:
            return self
        return replace(
            self,
            level_db=self.sure.level_db,
            level_variance=self.sure.level_variance,
            gain_db=self.sure.gain_db,
            gain_variance=self.sure.gain_variance,
            places=self.sure.places,
        )


def agreed(belief: PoseBelief) -> PoseEstimate:
    """Return mean and covariance of the particles around the heaviest cell.

    Parameters
    ----------
    belief : The particles.
    """
    number = pose_cells(belief.poses)
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


def pose_cells(poses: FloatArray) -> npt.NDArray[np.int64]:
    """Return the number of the cell of place and heading in which each particle is, (m,).

    Parameters
    ----------
    poses : (3, m) float64 — x, y [m] and heading [rad].
    """
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
