"""From the table ``[track]`` to robots, weights, tags, noises and trajectories, all checked."""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError, NavigationError
from octant.navigation.estimators.pose_filters import RssModel, WheelMotion
from octant.navigation.estimators.rss_kalman import RssAssumptions
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.sensing.rss_models import (
    LogExponentialLaw,
    RssNoise,
    TagMesh,
    fit_log_exponential,
)
from octant.navigation.sensing.tag_frames import Hearing, Polling, RssCodes
from octant.navigation.sensing.tag_layouts import patterned_tags
from octant.navigation.tracking import shapes
from octant.navigation.tracking.closed_loop import World
from octant.navigation.tracking.problem import Weights, stabilisation_weights
from octant.navigation.tracking.trajectories import Curve, check_feasible, desired_trajectory
from octant.reader_design.setting.receiver import study_tag_receiver
from octant.reader_design.setting.robot import study_robot
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.showing.tables import read_columns
from octant.reader_design.study_file.robot import Robot
from octant.reader_design.study_file.schema import Study
from octant.reader_design.study_file.sensor import Sensor
from octant.reader_design.study_file.track import Track, Trajectory

FloatArray = npt.NDArray[np.float64]

_FEEDBACK_RATE_RAD_PER_S, _RATE_RAD_PER_S = 12.1, 10.0
_TRAINED = ("feedback", "long", "stabilisation")
_PLANNED = (*_TRAINED, "nominal")
NOMINAL_PERIOD_S = 0.6
"""Sample period of the nominal control, thesis 7.5.1 [s]."""
EULER_STEP_S = 0.05
"""Euler step with which nominal controls are computed [s]."""
LEMNISCATE_START = (0.5, 0.0, 0.0)
"""Start of thesis 7.5.2.2 [m, rad]."""
POINT_START = (0.0, 0.0, math.radians(28.6))
"""Start of the point stabilisation of thesis 7.5.1.1 and 7.5.2.1 [m, rad]."""
POINT_GOAL = (3.0, 8.0, 0.5 * math.pi)
"""Its goal [m, rad]."""


RESERVED_NAMES = ("point", "lemniscate")
"""Names of the thesis' own tasks of chapter 7.3, which no other trajectory may have."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OwnTask:
    """A trajectory of the study's own.

    Parameters
    ----------
    curve, start : The way, and where the robot starts: x [m], y [m], heading [rad].
    weights : Of its cost; None: those of all trajectories.
    """

    curve: Curve
    start: tuple[float, float, float]
    weights: Weights | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """Everything that the chapters share.

    Parameters
    ----------
    study, track : The study, and its table ``[track]``.
    feedback_robot, robot : The study's robot, by default the Scout, with the wheel limits of
        chapter 6 and of chapter 7 [rad/s].
    weights, stabilisation : Of trajectories, and of thesis 7.5.2.1.
    law, noise : Of the tags' RSS.
    own : The study's own trajectories.
    given_tags_m : (s, 3) float64 or None — The tags ``[[tag]]``, heights above the antenna [m].
    samples : (k, 2) float64 or None — The study's own distances [m] and RSS [dBm].
    """

    study: Study
    track: Track
    feedback_robot: DifferentialDrive
    robot: DifferentialDrive
    weights: Weights
    stabilisation: Weights
    law: LogExponentialLaw
    noise: RssNoise
    own: tuple[OwnTask, ...]
    given_tags_m: FloatArray | None = None
    samples: FloatArray | None = None

    @property
    def tasks(self) -> dict[str, OwnTask]:
        """Return the lemniscate of thesis 7.5.2.2 and the study's own trajectories, by name."""
        lemniscate = OwnTask(curve=shapes.lemniscate(), start=LEMNISCATE_START)
        return {"lemniscate": lemniscate, **{one.curve.name: one for one in self.own}}

    @property
    def feedback_tags_m(self) -> FloatArray:
        """Return the tags of chapter 6, (s, 3) [m]."""
        return self.tags_m(self.track.feedback_tags)

    @property
    def mesh(self) -> TagMesh:
        """Return the tags of chapter 7 with their RSS [dBm]."""
        return TagMesh(tags_m=self.tags_m(self.track.tags), law=self.law)

    def tags_m(
        self, side: int, *, spacing_m: float | None = None, height_m: float | None = None
    ) -> FloatArray:
        """Return the tags ``[[tag]]``, else as the keys say, (s, 3), heights above the antenna [m].

        Parameters
        ----------
        side : Tags along each side of a mesh, unless ``track.tag_count`` says how many there are.
        spacing_m, height_m : Of a mesh; None: as the keys ``track.tag_spacing_m`` and
            ``track.tag_height_m`` [m].
        """
        if self.given_tags_m is not None:
            return self.given_tags_m
        track = self.track
        count = track.tag_count or side**2
        spacing = spacing_m or track.tag_spacing_m
        return patterned_tags(
            track.tag_pattern,
            count,
            field_m=track.tag_field_m or spacing * max(math.ceil(math.sqrt(count)) - 1, 1),
            height_m=height_m or track.tag_height_m,
            rng=np.random.default_rng([self.study.seed, 11]),
        )

    def hearing(self, tags_m: FloatArray) -> Hearing | None:
        """Return how tags are heard; None: all, everywhere, exactly and in every period.

        Parameters
        ----------
        tags_m : (s, 3) float64 — The tags, heights above the antenna [m].
        """
        track = self.track
        if track.tag_range_m is None and track.tag_bits is None and track.tag_bit_rate_hz is None:
            return None
        codes = polling = None
        if track.tag_bits is not None:
            codes = RssCodes(
                bits=track.tag_bits,
                floor_dbm=track.tag_floor_dbm,
                full_scale_dbm=track.tag_full_scale_dbm,
            )
        if track.tag_bit_rate_hz is not None:
            polling = Polling(
                tags=len(tags_m),
                bit_rate_hz=track.tag_bit_rate_hz,
                turnaround_s=track.tag_turnaround_s,
                code_bits=track.tag_bits or RssCodes().bits,
            )
        range_m = math.inf if track.tag_range_m is None else track.tag_range_m
        return Hearing(tags_m=tags_m, range_m=range_m, codes=codes, polling=polling)

    @property
    def motion(self) -> WheelMotion:
        """Return the estimators' motion model [m, rad]."""
        return WheelMotion(
            robot=self.robot,
            period_s=self.track.period_s,
            rate_sigma_rad_per_s=self.track.wheel_sigma_rad_per_s,
            method=study_robot(self.study, "track").odometry or "exact",
        )

    @property
    def assumptions(self) -> RssAssumptions:
        """Return what the filters assume of the readings' noise: its mean is unknown [dB]."""
        return RssAssumptions(sigma_db=self.noise.sigma_db)

    def world(
        self,
        sensor: RssModel,
        *,
        tags_m: FloatArray,
        noise: RssNoise | None = None,
        reading_every: int = 1,
    ) -> World:
        """Return the world in which robots are driven.

        Parameters
        ----------
        sensor, noise : RSS that the tags really send, and noise on it; None: the chapters' [dB].
        tags_m : (s, 3) float64 — These tags, heights above the antenna [m].
        reading_every : Periods from one reading to the next.
        """
        track = self.track
        sigma = np.array(
            [track.start_sigma_m, track.start_sigma_m, math.radians(track.start_sigma_deg)]
        )
        return World(
            robot=self.robot,
            period_s=track.period_s,
            sensor=sensor,
            noise=noise or self.noise,
            rate_sigma_rad_per_s=track.wheel_sigma_rad_per_s,
            start_covariance=sigma**2,
            reading_every=reading_every,
            rolling=study_robot(self.study, "track").rolling,
            receiver=study_tag_receiver(self.study.sensor),
            hearing=self.hearing(tags_m),
        )


def settings_of(study: Study) -> Settings:
    """Return the settings of a study's table ``[track]``, everything in it checked.

    Parameters
    ----------
    study : The study [m, s, deg].
    """
    track = study.track
    if track is None:
        msg = "the study has no [track], so there is nothing to follow; add the table, even empty."
        raise ConfigError(msg)
    _check_names([one.name for one in track.trajectories])
    feedback_robot, robot = (
        study_robot(study, "track", wheel_rate_rad_per_s=given, usual_rate_rad_per_s=usual).drive
        for given, usual in (
            (track.feedback_wheel_rate_rad_per_s, _FEEDBACK_RATE_RAD_PER_S),
            (track.wheel_rate_rad_per_s, _RATE_RAD_PER_S),
        )
    )
    _check_sensor(study.sensor, track)
    planned = [chapter for chapter in track.chapters if chapter in _PLANNED]
    if planned and robot.least_radius_m > 0.0:
        msg = (
            f"track.chapters has {', '.join(planned)}, whose controls are optimal for two wheels "
            "that turn freely within their limits, but robot.kinematics is 'car', whose steering "
            f"turns it within {robot.least_radius_m:.3g} m at best; leave these chapters out."
        )
        raise ConfigError(msg)
    samples = _samples(track)
    settings = Settings(
        study=study,
        track=track,
        feedback_robot=feedback_robot,
        robot=robot,
        weights=Weights(
            state=track.state_weight,  # type: ignore[arg-type]
            final=track.final_weight,  # type: ignore[arg-type]
            inputs=track.input_weight,  # type: ignore[arg-type]
        ),
        stabilisation=stabilisation_weights(),
        law=_law(track, samples),
        noise=RssNoise(mean_db=track.rss_mean_db, sigma_db=track.rss_sigma_db),
        own=tuple(_own_task(track, i, one) for i, one in enumerate(track.trajectories)),
        given_tags_m=_given_tags_m(study),
        samples=samples,
    )
    settings.world(settings.mesh, tags_m=settings.mesh.tags_m)
    if "tags" in track.chapters and settings.given_tags_m is None:
        for count in track.tag_counts:
            replace(settings, track=msgspec.structs.replace(track, tag_count=count)).mesh  # noqa: B018
    for task in settings.tasks.values():
        check_feasible(desired_trajectory(task.curve, period_s=track.period_s), robot)
    for curve in (shapes.line(), shapes.sine()) if "feedback" in track.chapters else ():
        check_feasible(desired_trajectory(curve, period_s=track.period_s), feedback_robot)
    _ = settings.motion
    return settings


def with_robot(settings: Settings, table: Robot) -> Settings:
    """Return settings with another robot in chapter 7.

    Parameters
    ----------
    settings, table : The study, and the table ``[robot]`` in place of its own [m], [rad/s].
    """
    study = msgspec.structs.replace(settings.study, robot=table)
    robot = study_robot(study, "track", usual_rate_rad_per_s=_RATE_RAD_PER_S).drive
    return replace(settings, study=study, robot=robot)


def _samples(track: Track) -> FloatArray | None:
    if track.rss_samples is None:
        return None
    for key, usual in (("alpha_dbm", -60.0), ("beta_per_m", 0.2)):
        if getattr(track, key) != usual:
            msg = (
                f"track.{key} is {getattr(track, key):g}, and track.rss_samples gives samples from "
                "which it is fitted; give one of them."
            )
            raise ConfigError(msg)
    return read_columns(Path(track.rss_samples), ("distance_m", "rss_dbm"))


def _law(track: Track, samples: FloatArray | None) -> LogExponentialLaw:
    """Return the law (6.2) of the keys, or of the samples."""
    if samples is None:
        return LogExponentialLaw(alpha_dbm=track.alpha_dbm, beta_per_m=track.beta_per_m)
    try:
        return fit_log_exponential(*samples.T)[0]
    except NavigationError as exc:
        msg = f"{track.rss_samples}: {exc}"
        raise ConfigError(msg) from exc


def _given_tags_m(study: Study) -> FloatArray | None:
    if not study.tags:
        return None
    setting = build_setting(study)
    places = np.array([tag.position_m for tag in setting.tags])
    places[:, 2] -= setting.map_z_m
    level = np.flatnonzero(places[:, 2] == 0.0)
    if len(level):
        msg = (
            f"tag[{level[0]}].position_m is at the height of the robot's antenna, where the law of "
            "[track] has no slope under the tag; move the tag, or set map.height_m."
        )
        raise ConfigError(msg)
    return places


def _check_sensor(sensor: Sensor, track: Track) -> None:
    if sensor == Sensor():
        return
    trained = [chapter for chapter in track.chapters if chapter in _TRAINED]
    if trained:
        msg = (
            f"track.chapters has {', '.join(trained)}, whose feedback is trained for noise that "
            "adds to readings, but the table [sensor] says how a receiver measures; leave these "
            "chapters out, or the table."
        )
        raise ConfigError(msg)
    single = [chapter for chapter in track.chapters if chapter != "reader"]
    if sensor.dwell_s > 0.0 and single:
        msg = (
            f"sensor.dwell_s is {sensor.dwell_s:g} s, but the robot of track.chapters "
            f"{', '.join(single)} reads one antenna; give track.tag_bit_rate_hz for the time from "
            "tag to tag, and leave it out, or name the chapter reader alone."
        )
        raise ConfigError(msg)


def _check_names(names: list[str]) -> None:
    for i, name in enumerate(names):
        if name in RESERVED_NAMES or name in names[:i]:
            msg = (
                f"track.trajectory[{i}].name is {name!r}, which another trajectory has (the "
                f"thesis' are {' and '.join(RESERVED_NAMES)}); give every one its own name."
            )
            raise ConfigError(msg)


def _own_task(track: Track, index: int, given: Trajectory) -> OwnTask:
    curve = _curve(f"track.trajectory[{index}]", given)
    first, velocity, _ = curve.motion(np.zeros(1))
    heading = math.atan2(velocity[0, 1], velocity[0, 0]) if velocity.any() else 0.0
    if given.start_heading_deg is not None:
        heading = math.radians(given.start_heading_deg)
    x, y = given.start_m or (float(first[0, 0]), float(first[0, 1]))
    return OwnTask(curve=curve, start=(x, y, heading), weights=_own_weights(track, given))


def _own_weights(track: Track, given: Trajectory) -> Weights | None:
    if given.state_weight is None and given.final_weight is None:
        return None
    return Weights(
        state=given.state_weight or track.state_weight,  # type: ignore[arg-type]
        final=given.final_weight or track.final_weight,  # type: ignore[arg-type]
        inputs=track.input_weight,  # type: ignore[arg-type]
    )


def _curve(path: str, given: Trajectory) -> Curve:
    needed = {"spline": 2, "line": 2, "point": 1}.get(given.shape, 0)
    exact = given.shape in ("line", "point")
    count = len(given.waypoints_m)
    if count < needed or (exact and count != needed) or (needed == 0 and count):
        wanted = f"{'exactly' if exact else 'at least'} {needed}" if needed else "no"
        msg = (
            f"{path}.waypoints_m has {count} points, but the shape {given.shape!r} takes {wanted}; "
            "change the list or the shape."
        )
        raise ConfigError(msg)
    if given.goal_heading_deg is not None and given.shape != "point":
        msg = (
            f"{path}.goal_heading_deg is {given.goal_heading_deg:g}, but only a 'point' has a goal "
            f"heading, and the shape is {given.shape!r}: leave it out."
        )
        raise ConfigError(msg)
    duration = given.duration_s
    fixed = {
        "sine": shapes.sine,
        "sigmoid": shapes.sigmoid,
        "parabola": shapes.parabola,
        "ellipse": shapes.ellipse,
        "lemniscate": shapes.lemniscate,
        "u-shape": shapes.u_shape,
    }
    if given.shape in fixed:
        curve = fixed[given.shape](duration_s=duration)
    elif given.shape == "line":
        curve = shapes.line(*given.waypoints_m, duration_s=duration)
    elif given.shape == "point":
        goal = given.goal_heading_deg
        heading = math.radians((given.start_heading_deg or 0.0) if goal is None else goal)
        curve = shapes.fixed_pose((*given.waypoints_m[0], heading), duration_s=duration)
    else:
        curve = shapes.spline(given.waypoints_m, duration_s=duration, closed=given.closed)
    return Curve(
        name=given.name,
        duration_s=curve.duration_s,
        motion=curve.motion,
        resting_heading_rad=curve.resting_heading_rad,
    )
