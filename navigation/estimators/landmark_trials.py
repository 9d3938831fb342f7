"""Trials of the landmark filters: a slipping robot drives past a landmark, many times."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.estimators.landmark_filters import (
    ATTITUDE,
    PLACE,
    SLIP,
    SPIN,
    LandmarkFilter,
    checked_period,
    position_transition,
)
from octant.navigation.sensing.landmark_sensor import Landmark, LandmarkSensor

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Manoeuvre:
    """A set drive past a landmark.

    Parameters
    ----------
    start : (3,) float64 — x [m], y [m], heading [rad] of the robot.
    legs : (k, 3) float64 — Duration [s], commanded v [m/s], commanded ω [rad/s] of each leg.
    landmark : What the camera looks for.
    period_s : Mean sample time [s].
    jitter : Sample times are uniform within this share of the mean about it [-], below 1.
    """

    start: FloatArray
    legs: FloatArray
    landmark: Landmark
    period_s: float = 0.1
    jitter: float = 0.5

    def __post_init__(self) -> None:
        for name, shape in (("start", (3,)), ("legs", (None, 3))):
            array = frozen_array(getattr(self, name), name=name, shape=shape, error=NavigationError)
            object.__setattr__(self, name, array)
        checked_period(self.period_s)
        checked_period(self.legs[:, 0])
        if not 0.0 <= self.jitter < 1.0:
            msg = f"jitter is {self.jitter}, but it must lie in [0, 1): 0.5 is usual."
            raise NavigationError(msg)

    @property
    def duration_s(self) -> float:
        """Return how long the drive takes [s]."""
        return float(self.legs[:, 0].sum())

    def commands(self, time_s: FloatArray) -> FloatArray:
        """Return the (k, 2) commands v [m/s], ω [rad/s] in force at times.

        Parameters
        ----------
        time_s : (k,) float64 — Times [s].
        """
        ends = np.cumsum(self.legs[:, 0])
        leg = np.searchsorted(ends, time_s, side="right")
        return np.asarray(self.legs[np.minimum(leg, len(self.legs) - 1), 1:])


def paper_manoeuvre() -> Manoeuvre:
    """Return a drive like the paper's first experiment; it gives no trajectory, numbers are chosen.

    Some 23 s in sight of the landmark, over 30 s out of sight, then back until it is seen again.
    """
    return Manoeuvre(
        start=np.array([-2.0, 0.25, 0.07]),
        legs=np.array([[60.0, 0.05, -0.038], [13.0, 0.0, 0.2], [37.0, 0.02, -0.01]]),
        landmark=Landmark(position_m=np.array([0.0, 0.0, 0.5]), heading_rad=0.0),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Drives:
    """What happened in many repetitions of one manoeuvre, s of them in n steps.

    Parameters
    ----------
    time_s, periods_s : (n,) float64 — End and length of each step [s].
    commands : (n, 2) float64 — Commanded v [m/s], ω [rad/s] in each step.
    poses : (n, s, 3) float64 — True x [m], y [m], heading [rad].
    truth : (n, s, 5) float64 — True state: e_x, e_y [m], b [m/s], ψ [rad], s [rad/s].
    detections : (n, s, 3) float64 — Measured e_x, e_y [m], ψ [rad]; NaN where there was none.
    """

    time_s: FloatArray
    periods_s: FloatArray
    commands: FloatArray
    poses: FloatArray
    truth: FloatArray
    detections: FloatArray

    @property
    def unseen_s(self) -> FloatArray:
        """Return the (n, s) time since the landmark was last detected, or since the start [s]."""
        seen = np.isfinite(self.detections[..., 0])
        last = np.where(seen, self.time_s[:, None], 0.0)
        return self.time_s[:, None] - np.maximum.accumulate(last, axis=0)

    def blackout_end(self, seconds_s: float) -> npt.NDArray[np.int64]:
        """Return the (s,) first steps at which the landmark was unseen for so long.

        Parameters
        ----------
        seconds_s : Length of the blackout [s].
        """
        long = self.unseen_s >= seconds_s
        if not long.any(axis=0).all():
            msg = (
                f"the landmark is never out of sight for {seconds_s:g} s in every repetition: ask "
                "for less, or drive farther away."
            )
            raise NavigationError(msg)
        return np.asarray(np.argmax(long, axis=0))


def drive(
    manoeuvre: Manoeuvre,
    sensor: LandmarkSensor,
    filter_: LandmarkFilter,
    *,
    slips: tuple[float, float],
    repetitions: int,
    seed: int,
) -> Drives:
    """Return truth and measurements of a manoeuvre with slips and the noise that a filter assumes.

    Parameters
    ----------
    manoeuvre : What is driven.
    sensor : Camera.
    filter_ : Its process noise is the truth's, so that its consistency can be judged.
    slips : b [m/s] and s [rad/s] at the start; they wander by the filter's densities.
    repetitions : How many.
    seed : Seed; repetition i depends on it and on i only.
    """
    if repetitions < 1:
        msg = f"repetitions is {repetitions}, but at least one is needed: raise it."
        raise NavigationError(msg)
    children = np.random.SeedSequence(seed).spawn(repetitions + 1)
    periods = _periods(manoeuvre, np.random.default_rng(children[0]))
    time = np.cumsum(periods)
    commands = manoeuvre.commands(time - periods)
    rngs = [np.random.default_rng(child) for child in children[1:]]
    steps = len(periods)
    normal = np.stack([rng.standard_normal((steps, 5)) for rng in rngs], axis=1)
    truth, poses = _truth(manoeuvre, filter_, periods, commands, normal=normal, slips=slips)
    detections = np.stack(
        [sensor.detect(poses[:, i], manoeuvre.landmark, rng) for i, rng in enumerate(rngs)],
        axis=1,
    )
    return Drives(
        time_s=time,
        periods_s=periods,
        commands=commands,
        poses=poses,
        truth=truth,
        detections=detections,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimates:
    """What a filter made of repeated drives, s of them in n steps.

    Parameters
    ----------
    mean : (n, s, 5) float64 — Estimated e_x, e_y [m], b [m/s], ψ [rad], s [rad/s].
    variance : (n, s, 5) float64 — Their variances [squared units].
    nees : (n, s) float64 — Normalised error squared [-], of the states that are estimated.
    nis : (n, s) float64 — Normalised innovation squared [-]; NaN where nothing was measured.
    """

    mean: FloatArray
    variance: FloatArray
    nees: FloatArray
    nis: FloatArray

    def position_error_m(self, drives: Drives) -> FloatArray:
        """Return the (n, s) distances between the landmark's estimated and true place [m].

        Parameters
        ----------
        drives : What the estimates are of.
        """
        return np.asarray(np.linalg.norm((self.mean - drives.truth)[..., PLACE], axis=-1))


def estimate(
    drives: Drives, filter_: LandmarkFilter, *, start_error: npt.ArrayLike = (0.0, 0.0, 0.0)
) -> Estimates:
    """Return what a filter estimates in every step of repeated drives.

    Parameters
    ----------
    drives : Odometry and detections.
    filter_ : The filter.
    start_error : (3,) or (s, 3) array_like — First guess less truth of e_x, e_y [m], ψ [rad].
    """
    steps, repetitions = drives.truth.shape[:2]
    first = drives.truth[0][:, [0, 1, ATTITUDE]]
    track = filter_.start(first + np.asarray(start_error, dtype=np.float64))
    mean, variance = np.empty((steps, repetitions, 5)), np.empty((steps, repetitions, 5))
    nees, nis = np.empty((steps, repetitions)), np.empty((steps, repetitions))
    for k in range(steps):
        if k > 0:
            track = filter_.predict(
                track, drives.commands[k], period_s=np.full(repetitions, drives.periods_s[k])
            )
        track = filter_.correct(track, drives.detections[k])
        mean[k], nis[k] = track.belief.mean, track.nis
        variance[k] = np.diagonal(track.belief.covariance, axis1=-2, axis2=-1)
        nees[k] = track.nees(drives.truth[k]) if filter_.estimate_slips else np.nan
    return Estimates(mean=mean, variance=variance, nees=nees, nis=nis)


def _periods(manoeuvre: Manoeuvre, rng: np.random.Generator) -> FloatArray:
    steps = round(manoeuvre.duration_s / manoeuvre.period_s)
    share = 1.0 + manoeuvre.jitter * rng.uniform(-1.0, 1.0, steps)
    return np.asarray(share * manoeuvre.duration_s / share.sum())


def _truth(
    manoeuvre: Manoeuvre,
    filter_: LandmarkFilter,
    periods: FloatArray,
    commands: FloatArray,
    *,
    normal: FloatArray,
    slips: tuple[float, float],
) -> tuple[FloatArray, FloatArray]:
    noise = filter_.noise
    densities = np.array(
        [
            noise.position_m2_per_s,
            noise.position_m2_per_s,
            noise.linear_slip_m2_per_s3,
            noise.attitude_rad2_per_s,
            noise.angular_slip_rad2_per_s3,
        ]
    )
    steps, repetitions = normal.shape[:2]
    wander = np.sqrt(densities * periods[:, None, None]) * normal
    pose = np.tile(manoeuvre.start, (repetitions, 1))
    slip = np.tile(np.array(slips), (repetitions, 1))
    poses, truth = np.empty((steps, repetitions, 3)), np.empty((steps, repetitions, 5))
    for k in range(steps):
        twist = commands[k] + slip
        # The body's own motion is minus the effect of the speed on a fixed point, turned back.
        step = position_transition(-twist[:, 1], periods[k])[..., :2, 2] * -twist[:, :1]
        cos, sin = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        pose = pose + np.column_stack(
            [
                cos * step[:, 0] - sin * step[:, 1] + wander[k, :, 0],
                sin * step[:, 0] + cos * step[:, 1] + wander[k, :, 1],
                periods[k] * twist[:, 1] + wander[k, :, 3],
            ]
        )
        slip = slip + wander[k][:, [SLIP, SPIN]]
        poses[k] = pose
        seen = manoeuvre.landmark.in_body(pose)
        truth[k, :, PLACE], truth[k, :, ATTITUDE] = seen[:, :2], seen[:, 2]
        truth[k][:, [SLIP, SPIN]] = slip
    return truth, poses
