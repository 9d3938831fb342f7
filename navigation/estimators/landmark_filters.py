"""Filters that localise a landmark in the body frame and learn the robot's slips on the way.

State: the landmark's place e_x, e_y [m], the linear slip b [m/s], the landmark's attitude ψ [rad]
and the angular slip s [rad/s]; the robot moves with v + b and ω + s. The paper's pair is an
attitude filter and a position filter that is driven by its turn rate; the coupled filter adds how
an error of the turn rate moves the landmark. Leading axes are a batch.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.checks import check_positive
from octant.navigation.estimators.kalman import (
    Gaussian,
    Innovation,
    innovate,
    nees,
    predict,
    update,
    within_gate,
)

FloatArray = npt.NDArray[np.float64]

PLACE, SLIP, ATTITUDE, SPIN = slice(0, 2), 2, 3, 4
"""Where the state holds e_x, e_y [m]; b [m/s]; ψ [rad]; s [rad/s]."""

_OUTPUT = np.array([[1.0, 0, 0, 0, 0], [0, 1.0, 0, 0, 0], [0, 0, 0, 1.0, 0]])
_SMALL_RAD = 1e-4


def attitude_transition(period_s: npt.ArrayLike) -> FloatArray:
    """Return exp(A T) = [[1, -T], [0, 1]] of ψ and s, (..., 2, 2) [rad per rad, s].

    Docking paper (6). [-T, 0]ᵀ ω is added; the printed input matrix holds ω already.

    Parameters
    ----------
    period_s : (...) array_like — Period T [s].
    """
    period = np.asarray(period_s, dtype=np.float64)
    one, zero = np.ones_like(period), np.zeros_like(period)
    return _matrix([[one, -period], [zero, one]])


def position_transition(turn_rate_rad_per_s: npt.ArrayLike, period_s: npt.ArrayLike) -> FloatArray:
    """Return the (..., 3, 3) transition of e_x, e_y and b over one period [m per m, s].

    Docking paper (25); its third column, less the last entry, is the effect of the speed, (26).

    Parameters
    ----------
    turn_rate_rad_per_s : (...) array_like — Turn rate ω, slip included [rad/s].
    period_s : (...) array_like — Period T [s].
    """
    rate, period = np.broadcast_arrays(
        np.asarray(turn_rate_rad_per_s, dtype=np.float64), np.asarray(period_s, dtype=np.float64)
    )
    turn = rate * period
    cos, sin = np.cos(turn), np.sin(turn)
    ahead, aside = _arc(turn)
    one, zero = np.ones_like(turn), np.zeros_like(turn)
    return _matrix([[cos, sin, -period * ahead], [-sin, cos, period * aside], [zero, zero, one]])


def turn_sensitivity(
    place_m: npt.ArrayLike,
    *,
    speed_m_per_s: npt.ArrayLike,
    turn_rate_rad_per_s: npt.ArrayLike,
    period_s: npt.ArrayLike,
) -> FloatArray:
    """Return ∂(e_x, e_y)/∂ω of the next place, (..., 2): what couples it to the slip s [m s/rad].

    Parameters
    ----------
    place_m : (..., 2) array_like — e_x, e_y before the step [m].
    speed_m_per_s, turn_rate_rad_per_s : (...) array_like — Slips included [m/s], [rad/s].
    period_s : (...) array_like — Period T [s].
    """
    place = np.asarray(place_m, dtype=np.float64)
    period = np.asarray(period_s, dtype=np.float64)
    turn = np.asarray(turn_rate_rad_per_s, dtype=np.float64) * period
    cos, sin = np.cos(turn), np.sin(turn)
    small = np.abs(turn) < _SMALL_RAD
    safe = np.where(small, 1.0, turn)
    ahead, aside = _arc(turn)
    # Derivatives of sin x / x and (1 - cos x)/x.
    d_ahead = np.where(small, -turn / 3.0, (cos - ahead) / safe)
    d_aside = np.where(small, 0.5 - turn**2 / 8.0, (sin - aside) / safe)
    x, y = place[..., 0], place[..., 1]
    distance = np.asarray(speed_m_per_s, dtype=np.float64) * period
    return np.stack(
        [
            period * (cos * y - sin * x - distance * d_ahead),
            period * (distance * d_aside - cos * x - sin * y),
        ],
        axis=-1,
    )


def checked_period(period_s: npt.ArrayLike) -> FloatArray:
    """Return a sample time, or many, once they are known to be positive [s].

    Parameters
    ----------
    period_s : (...) array_like — Sample times [s].
    """
    period = np.asarray(period_s, dtype=np.float64)
    if not (np.isfinite(period).all() and (period > 0.0).all()):
        worst = period[~(np.isfinite(period) & (period > 0.0))].flat[0]
        msg = (
            f"the sample time is {worst:g} s, but it must be positive and finite: give the time "
            "that passed since the last step."
        )
        raise NavigationError(msg)
    return period


@dataclass(frozen=True, slots=True, kw_only=True)
class LandmarkNoise:
    """The noise that a landmark filter assumes; the defaults are the paper's, section VII.

    (19) defines Q as a density over time; over any period T it adds Q T.

    Parameters
    ----------
    position_m2_per_s, attitude_rad2_per_s : Growth of the variances, Q^x [m²/s], Q^θ [rad²/s].
    linear_slip_m2_per_s3, angular_slip_rad2_per_s3 : The same of the slips [m²/s³], [rad²/s³].
    measured_position_m2, measured_attitude_rad2 : Variances R^x [m²], R^θ [rad²].
    initial_position_m2, initial_linear_slip_m2_per_s2 : Initial variances, P₀^x [m²], [m²/s²].
    initial_attitude_rad2, initial_angular_slip_rad2_per_s2 : P₀^θ, of two rows and not of three as
        printed [rad²], [rad²/s²].
    """

    position_m2_per_s: float = 4.1e-6
    linear_slip_m2_per_s3: float = 1e-8
    attitude_rad2_per_s: float = 2e-5
    angular_slip_rad2_per_s3: float = 1e-8
    measured_position_m2: float = 1e-2
    measured_attitude_rad2: float = 1e-2
    initial_position_m2: float = 1.0
    initial_linear_slip_m2_per_s2: float = 1.0
    initial_attitude_rad2: float = 0.1
    initial_angular_slip_rad2_per_s2: float = 0.1

    def __post_init__(self) -> None:
        for name, unit in (
            ("position_m2_per_s", "m²/s"),
            ("linear_slip_m2_per_s3", "m²/s³"),
            ("attitude_rad2_per_s", "rad²/s"),
            ("angular_slip_rad2_per_s3", "rad²/s³"),
            ("measured_position_m2", "m²"),
            ("measured_attitude_rad2", "rad²"),
            ("initial_position_m2", "m²"),
            ("initial_linear_slip_m2_per_s2", "m²/s²"),
            ("initial_attitude_rad2", "rad²"),
            ("initial_angular_slip_rad2_per_s2", "rad²/s²"),
        ):
            allow_zero = not name.startswith("measured")
            check_positive(getattr(self, name), name=name, unit=unit, allow_zero=allow_zero)

    @property
    def measurement(self) -> FloatArray:
        """Return R of e_x, e_y, ψ, (3, 3) [m², rad²]."""
        place = self.measured_position_m2
        return np.diag([place, place, self.measured_attitude_rad2])

    @property
    def initial(self) -> FloatArray:
        """Return P₀, (5, 5) [squared units of the state]."""
        place = self.initial_position_m2
        return np.diag(
            [
                place,
                place,
                self.initial_linear_slip_m2_per_s2,
                self.initial_attitude_rad2,
                self.initial_angular_slip_rad2_per_s2,
            ]
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class LandmarkTrack:
    """What a landmark filter believes.

    Parameters
    ----------
    belief : e_x, e_y [m], b [m/s], ψ [rad], s [rad/s]; (..., 5).
    rejected : (...) int64 — Measurements in a row that failed the gate [-].
    nis : (...) float64 — Normalised innovation squared of the last measurement [-], or NaN.
    """

    belief: Gaussian
    rejected: npt.NDArray[np.int64]
    nis: FloatArray

    @property
    def place_m(self) -> FloatArray:
        """Return the (..., 2) landmark's place in the body frame [m]."""
        return self.belief.mean[..., PLACE]

    @property
    def attitude_rad(self) -> FloatArray:
        """Return the (...) landmark's attitude in the body frame, in (-π, π] [rad]."""
        return np.asarray(self.belief.mean[..., ATTITUDE])

    @property
    def slips(self) -> FloatArray:
        """Return the (..., 2) slips b [m/s] and s [rad/s]."""
        return self.belief.mean[..., [SLIP, SPIN]]

    def nees(self, truth: npt.ArrayLike) -> FloatArray:
        """Return the (...) normalised estimation error squared [-]; 5 on average.

        Parameters
        ----------
        truth : (..., 5) array_like — True e_x, e_y [m], b [m/s], ψ [rad], s [rad/s].
        """
        return nees(self.belief, truth, angles=(ATTITUDE,))


@dataclass(frozen=True, slots=True, kw_only=True)
class LandmarkFilter:
    """A filter of the landmark's pose in the body frame and of the robot's slips.

    Parameters
    ----------
    noise : What it assumes.
    coupled : False: the paper's pair, whose position filter takes the estimated turn rate for the
        true one and is too sure far from the landmark. True: an extended filter of all five states.
    estimate_slips : False: slips are taken to be zero, as in the paper's figures 7 to 10.
    gate_probability : Share of true detections that pass the chi-squared gate, in (0, 1) [-].
    restart_after : Rejected detections in a row after which the next is believed: the robot was
        lost.
    """

    noise: LandmarkNoise = LandmarkNoise()
    coupled: bool = True
    estimate_slips: bool = True
    gate_probability: float = 0.999
    restart_after: int = 5

    def __post_init__(self) -> None:
        if not 0.0 < self.gate_probability < 1.0 or self.restart_after < 1:
            msg = (
                f"gate_probability is {self.gate_probability} and restart_after is "
                f"{self.restart_after}, but the first must lie between 0 and 1 and the second be 1 "
                "or more: 0.999 and 5 are usual."
            )
            raise NavigationError(msg)

    def start(
        self, pose: npt.ArrayLike, *, covariance: npt.ArrayLike | None = None
    ) -> LandmarkTrack:
        """Return the belief before the first measurement, slips zero."""
        guess = np.asarray(pose, dtype=np.float64)
        mean = np.zeros((*guess.shape[:-1], 5))
        mean[..., PLACE], mean[..., ATTITUDE] = guess[..., :2], wrap_angle(guess[..., 2])
        initial = np.array(self.noise.initial)
        if covariance is not None:
            seen = [0, 1, ATTITUDE]
            initial[np.ix_(seen, seen)] = np.asarray(covariance)
        if not self.estimate_slips:
            initial[[SLIP, SPIN]] = 0.0
            initial[:, [SLIP, SPIN]] = 0.0
        batch = mean.shape[:-1]
        return LandmarkTrack(
            belief=Gaussian(mean=mean, covariance=np.broadcast_to(initial, (*batch, 5, 5))),
            rejected=np.zeros(batch, dtype=np.int64),
            nis=np.full(batch, np.nan),
        )

    def predict(
        self, track: LandmarkTrack, twist: npt.ArrayLike, *, period_s: npt.ArrayLike
    ) -> LandmarkTrack:
        """Return the belief after a period of odometry; attitude in (-π, π] [rad].

        Docking paper (8), (10), (24), (28); (28) prints B for the discrete G.

        Parameters
        ----------
        track : Belief before.
        twist : (..., 2) array_like — Commanded v [m/s], ω [rad/s]; at zero no slip and no noise.
        period_s : (...) array_like — Time that passed, any [s].
        """
        command = np.asarray(twist, dtype=np.float64)
        moving = np.asarray(np.any(command != 0.0, axis=-1), dtype=np.float64)
        period = np.asarray(checked_period(period_s) * moving)
        mean = track.belief.mean
        rate = command[..., 1] + mean[..., SPIN]
        motion = position_transition(rate, period)
        moved = np.array(mean)
        moved[..., :3] = (motion @ mean[..., :3, None])[..., 0]
        moved[..., PLACE] += motion[..., :2, 2] * command[..., :1]
        moved[..., ATTITUDE] = wrap_angle(mean[..., ATTITUDE] - period * rate)
        jacobian = np.zeros((*moved.shape[:-1], 5, 5))
        jacobian[..., :3, :3] = motion
        jacobian[..., 3:, 3:] = attitude_transition(period)
        if self.coupled:
            jacobian[..., PLACE, SPIN] = turn_sensitivity(
                mean[..., PLACE],
                speed_m_per_s=command[..., 0] + mean[..., SLIP],
                turn_rate_rad_per_s=rate,
                period_s=period,
            )
        belief = predict(
            track.belief,
            transition=jacobian,
            process_noise=self._process_noise(moved, period),
            moved_mean=moved,
        )
        return LandmarkTrack(
            belief=belief, rejected=track.rejected, nis=np.full_like(track.nis, np.nan)
        )

    def correct(self, track: LandmarkTrack, detection: npt.ArrayLike) -> LandmarkTrack:
        """Return the belief after looking for the landmark.

        Parameters
        ----------
        track : Belief before.
        detection : (..., 3) array_like — Measured e_x, e_y [m], ψ [rad], or NaN.
        """
        measured = np.asarray(detection, dtype=np.float64)
        seen = np.asarray(np.isfinite(measured).all(axis=-1))
        if not seen.any():
            return track
        innovation = innovate(
            track.belief,
            np.where(seen[..., None], measured, 0.0),
            observation=_OUTPUT,
            measurement_noise=self.noise.measurement,
            angles=(2,),
        )
        passed = within_gate(innovation, probability=self.gate_probability)
        rejected = np.where(passed, 0, track.rejected + 1)
        restarted = seen & (rejected >= self.restart_after)
        rejected = np.where(seen, np.where(restarted, 0, rejected), track.rejected)
        belief = update(track.belief, innovation, accept=seen & passed)
        if restarted.any():
            belief = self._restart(belief, innovation, restarted)
        mean = np.array(belief.mean)
        mean[..., ATTITUDE] = wrap_angle(mean[..., ATTITUDE])
        return LandmarkTrack(
            belief=Gaussian(mean=mean, covariance=belief.covariance),
            rejected=rejected.astype(np.int64),
            nis=np.where(seen, innovation.nis, np.nan),
        )

    def _process_noise(self, mean: FloatArray, period: FloatArray) -> FloatArray:
        n = self.noise
        grown = np.zeros((*mean.shape[:-1], 5, 5))
        slips = (n.linear_slip_m2_per_s3, n.angular_slip_rad2_per_s3)
        for row, density in (
            (0, n.position_m2_per_s),
            (1, n.position_m2_per_s),
            (SLIP, slips[0] if self.estimate_slips else 0.0),
            (ATTITUDE, n.attitude_rad2_per_s),
            (SPIN, slips[1] if self.estimate_slips else 0.0),
        ):
            grown[..., row, row] = density * period
        if self.coupled:
            # A random turn moves attitude and place together.
            lever = np.stack([mean[..., 1], -mean[..., 0]], axis=-1)
            spread = n.attitude_rad2_per_s * period[..., None]
            grown[..., PLACE, PLACE] += (
                spread[..., None] * lever[..., :, None] * lever[..., None, :]
            )
            grown[..., PLACE, ATTITUDE] = grown[..., ATTITUDE, PLACE] = -spread * lever
        return grown

    def _restart(
        self, belief: Gaussian, innovation: Innovation, restarted: npt.NDArray[np.bool_]
    ) -> Gaussian:
        """Return the belief with the pose taken from the measurement, slips kept."""
        seen = np.array([0, 1, ATTITUDE])
        mean, covariance = np.array(belief.mean), belief.covariance
        fresh_mean = mean[..., seen] + innovation.residual
        mean[..., seen] = np.where(restarted[..., None], fresh_mean, mean[..., seen])
        measured = np.zeros((5, 5))
        measured[np.ix_(seen, seen)] = self.noise.measurement
        slips = np.zeros((5, 5))
        slips[np.ix_([SLIP, SPIN], [SLIP, SPIN])] = 1.0
        fresh = measured + slips * covariance
        return Gaussian(
            mean=mean,
            covariance=np.where(restarted[..., None, None], fresh, covariance),
        )


def _arc(turn_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return sin x / x and (1 - cos x)/x, exact also without turning [-]."""
    half = np.sinc(turn_rad / (2.0 * np.pi))
    return np.sinc(turn_rad / np.pi), 0.5 * turn_rad * half**2


def _matrix(rows: list[list[FloatArray]]) -> FloatArray:
    filled = np.empty((*rows[0][0].shape, len(rows), len(rows[0])))
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            filled[..., i, j] = entry
    return filled
