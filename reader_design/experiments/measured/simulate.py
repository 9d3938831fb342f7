"""A log of a simulated drive: what a robot on a way reads of the tags, as a receiver reads it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.em.power.backscatter import Link
from octant.geometries.errors import ConfigError
from octant.navigation.angles import wrap_angle
from octant.navigation.logs.records import NOT_HEARD_DBM, Log
from octant.navigation.logs.units import exact_degrees
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.motion import Motion
from octant.navigation.robot.odometry import RollingWheels, wheel_travel
from octant.navigation.robot.robot import Robot
from octant.navigation.sensing.sensor import FieldSensor, PowerLink
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.antennas import named_antenna
from octant.reader_design.setting.inventory import study_inventory
from octant.reader_design.setting.receiver import study_sensor
from octant.reader_design.setting.rfid import single_response
from octant.reader_design.setting.robot import study_robot
from octant.reader_design.setting.setting import Setting
from octant.reader_design.study_file.loading import vary

FloatArray = npt.NDArray[np.float64]

LOG_STREAM = 5_111
"""Keeps the random numbers of logs apart from those of other parts with the same seed [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Readings:
    """How a simulated log is read.

    Parameters
    ----------
    period_s : Time from one pose's readings to the next one's [s].
    noise_db : Standard deviation of the log-normal error of each reading [dB].
    hop : Each reading at one of the study's channels, drawn at random; else the mean power over
        them.
    local_mean : Power sums over the paths, without fading of small scale.
    runs : How often the way is driven.
    seed : Of all random numbers.
    """

    period_s: float = 1.0
    noise_db: float = 0.0
    hop: bool = False
    local_mean: bool = False
    runs: int = 1
    seed: int = 1


@dataclass(frozen=True, slots=True)
class TracedLink:
    """A link whose power on a way is computed at once, and elsewhere when it is asked for.

    Parameters
    ----------
    link : The link.
    local_mean : Whether its power is the sum over its paths.
    known_w : (n,) float64 by the bytes of a pose — Power that is known already [W].
    """

    link: Link
    local_mean: bool
    known_w: Mapping[bytes, FloatArray]

    def rss_w(self, poses: npt.NDArray[np.float64]) -> FloatArray:
        """Return the power of each antenna, (m, n) [W].

        Parameters
        ----------
        poses : (m, 3) float64 — x, y [m], heading [rad].
        """
        if len(poses) == 1 and (known := self.known_w.get(poses[0].tobytes())) is not None:
            return known[None]
        power = self.link.power(poses)
        return power.local_mean_w if self.local_mean else power.coherent_w


def traced_link(link: Link, poses: FloatArray, *, local_mean: bool) -> TracedLink:
    """Return a link that knows its power at the poses of a way [W].

    Parameters
    ----------
    link, local_mean : The link; whether its power is the sum over its paths.
    poses : (m, 3) float64 — The way [m], [rad].
    """
    bare = TracedLink(link, local_mean, {})
    rows = zip(poses, bare.rss_w(poses), strict=True) if len(poses) > 1 else ()
    return TracedLink(link, local_mean, {pose.tobytes(): row for pose, row in rows})


def with_antenna(setting: Setting, kind: str) -> Setting:
    """Return a setting whose robot carries one antenna in place of the reader.

    Parameters
    ----------
    setting : The room.
    kind : An antenna that is alike all around, such as ``dipole``, as of a tag.
    """
    responses = [
        single_response(named_antenna(kind, f, key="--antenna"), model=kind)
        for f in setting.study.radio.frequencies_hz
    ]
    return setting.with_responses(responses)


def simulated_log(
    setting: Setting, poses: FloatArray, how: Readings, *, progress: Progress | None = None
) -> Log:
    """Return the log of a robot that reads all tags at each pose of a way.

    The pose in the log is the true one, at the end of the round of antennas; odometry errs as the
    table ``[robot]`` says. What is not received is "not heard". Angles are those that degrees of a
    file give back, so that `read_log` returns the log to the bit.

    Parameters
    ----------
    setting : The room, its tags and its reader.
    poses : (m, 3) float64 — The way [m], [rad].
    how : How it is read.
    progress : Shows poses.
    """
    if not setting.tags:
        msg = "the study has no [[tag]], so that there is nothing to read; add tags."
        raise ConfigError(msg)
    sensors, frequencies = _sensors(setting, poses, how)
    robot = study_robot(setting.study, "mission")
    ids = tuple(tag.id for tag in setting.tags)
    antennas, m = sensors[0].antennas, len(poses)
    level = np.empty((how.runs, m, len(ids), antennas))
    channel = np.empty((how.runs, m, len(ids)), dtype=np.int64)
    odometry = []
    with (progress or Progress()).count(how.runs * m, label="poses read") as done:
        for run in range(how.runs):
            rng = np.random.default_rng((how.seed, LOG_STREAM, run))
            wheels_rng, channel_rng = rng.spawn(2)
            channel[run] = channel_rng.integers(len(sensors), size=(m, len(ids)))
            steps, counted = _driven(poses, robot, how.period_s, wheels_rng)
            odometry.append(counted)
            for k, pose in enumerate(poses):
                motion = Motion(
                    speed_m_per_s=float(steps[k, 0] / how.period_s),
                    turn_rate_rad_per_s=float(steps[k, 1] / how.period_s),
                )
                for t, name in enumerate(ids):
                    sensor = sensors[channel[run, k, t]]
                    level[run, k, t] = power_dbm(sensor.read(pose, name, rng, motion=motion))
                done(run * m + k + 1)
    rows = (how.runs, m, len(ids), antennas)
    first = np.zeros(rows, dtype=bool)
    first[:, :, 0, 0] = True
    time_s = how.period_s * np.arange(how.runs * m).reshape(how.runs, m)
    counted = np.where(first[..., None], np.array(odometry)[:, :, None, None], 0.0)
    frequency = np.full(rows, frequencies[0]) if len(frequencies) == 1 else np.full(rows, np.nan)
    if how.hop and len(sensors) > 1:
        frequency = np.broadcast_to(np.array(frequencies)[channel][..., None], rows)
    heading = np.radians(exact_degrees(poses[:, 2]))
    exact = np.column_stack([poses[:, :2], heading])

    def flat(values: npt.ArrayLike) -> FloatArray:
        return np.broadcast_to(np.asarray(values, dtype=np.float64), rows).reshape(-1)

    numbers = np.arange(1, antennas + 1) if antennas > 1 else np.zeros(1, dtype=np.int64)
    run_number = flat(np.arange(1.0, how.runs + 1.0)[:, None, None, None])
    return Log(
        ids=ids,
        time_s=flat(time_s[..., None, None]),
        poses=np.column_stack([flat(exact[:, i, None, None]) for i in range(3)]),
        sources=np.broadcast_to(np.arange(len(ids))[:, None], rows).reshape(-1),
        antennas=np.broadcast_to(numbers, rows).reshape(-1),
        rss_dbm=np.where(np.isfinite(level), level, NOT_HEARD_DBM).reshape(-1),
        frequency_hz=frequency.reshape(-1),
        distance_m=counted[..., 0].reshape(-1),
        turn_rad=np.radians(exact_degrees(counted[..., 1].reshape(-1))),
        threshold_dbm=setting.study.sensor.sensitivity_dbm,
        kept={"run": tuple(f"{number:.0f}" for number in run_number)} if how.runs > 1 else {},
    )


def _sensors(
    setting: Setting, poses: FloatArray, how: Readings
) -> tuple[tuple[FieldSensor, ...], tuple[float, ...]]:
    """Return a sensor for each channel, or one for their mean, and the frequencies [Hz]."""
    frequencies = setting.study.radio.frequencies_hz
    settings = [setting]
    if how.hop and len(frequencies) > 1:
        settings = [_at_channel(setting, k) for k in range(len(frequencies))]
    found = []
    for one in settings:
        traced = {tag.id: one.link(tag) for tag in one.tags}
        inventory = study_inventory(one, traced, key="--period-s", period_s=how.period_s)
        links: dict[str, PowerLink] = {
            name: traced_link(link, poses, local_mean=how.local_mean)
            for name, link in traced.items()
        }
        found.append(
            study_sensor(
                one.study.sensor,
                links,
                one.responses[0].azimuths_rad,
                noise_db=how.noise_db,
                inventory=inventory,
            )
        )
    return tuple(found), frequencies


def _at_channel(setting: Setting, number: int) -> Setting:
    """Return the setting at one of its channels alone."""
    frequency = setting.study.radio.frequencies_hz[number]
    study = vary(setting.study, {"radio.channels_hz": [], "radio.frequency_hz": frequency})
    tags = tuple(replace(tag, antennas=(tag.antennas[number],)) for tag in setting.tags)
    one = replace(setting, study=study, radios=(setting.radios[number],), tags=tags)
    return one.with_responses((setting.responses[number],))


def _driven(
    poses: FloatArray, robot: Robot, period_s: float, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Return way and turn to each pose, (m, 2), and what the wheels count of them [m], [rad]."""
    step = np.diff(poses, axis=0, prepend=poses[:1])
    turn = wrap_angle(step[:, 2])
    middle = poses[:, 2] - 0.5 * turn
    chord = step[:, 0] * np.cos(middle) + step[:, 1] * np.sin(middle)
    steps = np.column_stack([chord / np.sinc(turn / (2.0 * np.pi)), turn])
    wheels = RollingWheels(robot.rolling, robot.drive, rng)
    rotations = _rotations(robot.drive, steps)
    counted = [wheels.count(wheels.turned(one, period_s=period_s)) for one in rotations]
    distance, turned = wheel_travel(np.array(counted), robot.drive)
    return steps, np.column_stack([distance, turned])


def _rotations(drive: DifferentialDrive, steps: FloatArray) -> Sequence[FloatArray]:
    """Return the wheels' rotations that make ways and turns, (m, 2) [rad]."""
    return list(drive.wheel_rates(speed_m_per_s=steps[:, 0], turn_rate_rad_per_s=steps[:, 1]))
