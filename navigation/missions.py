"""Closed-loop missions: navigator, sensor and robot, one sample period after another."""

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.batches import run_seeded
from octant.navigation.bearing import wrap_angle
from octant.navigation.controllers import Controller
from octant.navigation.mission_records import Mission, MissionResult, Outcome
from octant.navigation.navigator import Navigator, NavigatorState
from octant.navigation.robot import DifferentialDrive
from octant.navigation.sensing import Sensor, unknown_tag

__all__ = ["Blocked", "Mission", "MissionResult", "run_mission", "run_missions"]

Blocked = Callable[[npt.NDArray[np.float64]], npt.NDArray[np.bool_]]
"""Says for (m, 2) points on the floor [m] whether the robot's centre cannot stand there."""

_COLLISION_SPACING_M = 0.01


def run_mission(
    mission: Mission,
    sensor: Sensor,
    controller: Controller,
    robot: DifferentialDrive,
    rng: np.random.Generator,
    *,
    blocked: Blocked | None = None,
) -> MissionResult:
    """Return the record of one closed-loop run.

    Parameters
    ----------
    mission : Mission
        Start, tags and manner.
    sensor : Sensor
        What the robot reads.
    controller : Controller
        Law of the navigation mode.
    robot : DifferentialDrive
        The robot.
    rng : numpy.random.Generator
        Source of every random number of the run.
    blocked : callable or None
        (m, 2) points on the floor [m] -> (m,) bool: where the robot's centre cannot be. The run
        ends at the last free point before one.

    Returns
    -------
    MissionResult
        Also when the tags are out of reach, time runs out or something is in the way: those are
        results.

    Raises
    ------
    NavigationError
        When the sensor lacks a tag, the cruise speed exceeds what the wheels can do, or the start
        is blocked.

    Notes
    -----
    A reading takes no time: after an arrival the next tag is read at once, in the same period.
    """
    _check_run(mission, sensor, robot, blocked)
    navigator = Navigator(
        arrivals=mission.arrivals,
        azimuths_rad=sensor.azimuths_rad,
        controller=controller,
        robot=robot,
        cruise_speed_m_per_s=mission.cruise_speed_m_per_s,
        period_s=mission.sample_time_s,
        rotation=mission.rotation,
    )
    pose = np.array([*mission.start_m, float(wrap_angle(mission.heading_rad))])
    log = _Log(mission)
    state = NavigatorState()
    collided = False
    last = int(np.floor(mission.time_limit_s / mission.sample_time_s * (1.0 + 1e-12)))
    for k in range(last + 1):
        rss_w = sensor.read(pose, mission.tag_ids[state.target], rng)
        arrived, following = navigator.arrived(state, rss_w)
        if arrived:
            log.arrive(k, pose, state.target)
            if following.mode != "stopped":
                rss_w = sensor.read(pose, mission.tag_ids[following.target], rng)
                _, following = navigator.arrived(following, rss_w)
        state = following
        ended = _ended(mission, state, collided=collided, out_of_time=k == last)
        log.row(k, pose, state, rss_w, ended is not None)
        if ended is not None:
            return log.result(*ended)
        rates, state = navigator.decide(state, rss_w)
        pose, collided = _move(mission, robot, pose, rates, blocked)
    raise AssertionError  # the last turn always ends the run


def _check_run(
    mission: Mission, sensor: Sensor, robot: DifferentialDrive, blocked: Blocked | None
) -> None:
    for tag_id in mission.tag_ids:
        if tag_id not in sensor.tag_ids:
            raise unknown_tag(tag_id, sensor.tag_ids)
    if mission.cruise_speed_m_per_s > robot.max_wheel_speed_m_per_s:
        msg = (
            f"the cruise speed is {mission.cruise_speed_m_per_s:g} m/s, but the wheels reach "
            f"{robot.max_wheel_speed_m_per_s:g} m/s: take a smaller step or a longer period."
        )
        raise NavigationError(msg)
    if blocked is not None and bool(np.any(blocked(mission.start_m.reshape(1, 2)))):
        msg = (
            f"the start ({mission.start_m[0]:g}, {mission.start_m[1]:g}) m is inside an obstacle, "
            "but the robot needs free floor there: move it."
        )
        raise NavigationError(msg)


def _ended(
    mission: Mission, state: NavigatorState, *, collided: bool, out_of_time: bool
) -> tuple[Outcome, str] | None:
    tag_id = mission.tag_ids[state.target]
    if state.mode == "stopped":
        return "completed", "all tags were declared reached"
    if collided:
        return "collision", f"the robot ran into an obstacle on its way to tag {tag_id}"
    if state.silent_readings >= mission.silent_limit:
        return "no signal", (
            f"no antenna received tag {tag_id} in {state.silent_readings} readings in a row"
        )
    if out_of_time:
        return "time-out", f"tag {tag_id} was not reached within {mission.time_limit_s:g} s"
    return None


def _move(
    mission: Mission,
    robot: DifferentialDrive,
    pose: npt.NDArray[np.float64],
    rates: npt.NDArray[np.float64],
    blocked: Blocked | None,
) -> tuple[npt.NDArray[np.float64], bool]:
    step = robot.step_euler if mission.motion == "euler" else robot.step_arc
    reached = step(pose, rates, period_s=mission.sample_time_s)
    collided = False
    if blocked is not None:
        length_m = abs(float(robot.twist(rates)[0])) * mission.sample_time_s
        parts = int(np.ceil(length_m / _COLLISION_SPACING_M))
        times_s = mission.sample_time_s * np.arange(1, parts + 1) / max(parts, 1)
        way = np.array([step(pose, rates, period_s=float(t)) for t in times_s]).reshape(-1, 3)
        hits = np.flatnonzero(blocked(way[:, :2])) if parts else np.array([], dtype=np.int64)
        if hits.size:
            collided = True
            reached = np.array(way[hits[0] - 1] if hits[0] > 0 else pose)
    reached[2] = wrap_angle(reached[2])
    return reached, collided


class _Log:
    """Collects the rows of one run."""

    def __init__(self, mission: Mission) -> None:
        self._mission = mission
        self._rows: list[tuple[float, npt.NDArray[np.float64], str, int]] = []
        self._rss_w: list[npt.NDArray[np.float64]] = []
        tags = len(mission.tag_ids)
        self._arrival_times_s = np.full(tags, np.nan)
        self._arrival_points_m = np.full((tags, 2), np.nan)

    def row(
        self,
        k: int,
        pose: npt.NDArray[np.float64],
        state: NavigatorState,
        rss_w: npt.NDArray[np.float64],
        ended: bool,
    ) -> None:
        mode = "stopped" if ended else state.mode
        self._rows.append((k * self._mission.sample_time_s, pose, mode, state.target))
        self._rss_w.append(rss_w)

    def arrive(self, k: int, pose: npt.NDArray[np.float64], target: int) -> None:
        self._arrival_times_s[target] = k * self._mission.sample_time_s
        self._arrival_points_m[target] = pose[:2]

    def result(self, outcome: Outcome, reason: str) -> MissionResult:
        times_s, poses, modes, targets = zip(*self._rows, strict=True)
        return MissionResult(
            mission=self._mission,
            outcome=outcome,
            reason=reason,
            time_s=np.array(times_s),
            poses=np.array(poses),
            modes=modes,
            targets=np.array(targets, dtype=np.int64),
            rss_w=np.array(self._rss_w),
            arrival_times_s=self._arrival_times_s,
            arrival_points_m=self._arrival_points_m,
        )


def run_missions(
    mission: Mission,
    sensor: Sensor,
    controller: Controller,
    robot: DifferentialDrive,
    *,
    runs: int,
    seed: int,
    workers: int = 1,
    executor: Executor | None = None,
    blocked: Blocked | None = None,
    progress: Callable[[int], object] | None = None,
) -> tuple[MissionResult, ...]:
    """Return the records of many runs of one mission, in order, each with its own random numbers.

    Parameters
    ----------
    mission : Mission
        Start, tags and manner.
    sensor : Sensor
        What the robot reads.
    controller : Controller
        Law of the navigation mode.
    robot : DifferentialDrive
        The robot.
    runs : int
        Number of runs [-].
    seed : int
        Base seed, not negative [-]. Run i uses child i of its numpy SeedSequence, so its result
        depends neither on the number of runs nor on that of workers.
    workers : int
        Processes that share the runs [-]; 1 stays in this one. More need picklable arguments.
    executor : concurrent.futures.Executor or None
        Runs the batches in place of `workers` own processes; `workers` then only sizes them.
    blocked : callable or None
        As for `run_mission`.
    progress : callable or None
        Called in this process with the number of finished runs, whenever some have finished.

    Returns
    -------
    tuple of MissionResult
        Run 0 first.

    Raises
    ------
    NavigationError
        When the number of runs or workers is below 1, the seed is negative, or a run cannot start.
    KeyboardInterrupt
        Passed on after the batches that have not begun are cancelled.
    """
    results = run_seeded(
        _Job(mission=mission, sensor=sensor, controller=controller, robot=robot, blocked=blocked),
        runs=runs,
        seed=seed,
        workers=workers,
        executor=executor,
        progress=progress,
    )
    # Unpickled arrays are writable and each result has its own copy of the mission: make them
    # whole again.
    return tuple(replace(result, mission=mission) for result in results)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Job:
    mission: Mission
    sensor: Sensor
    controller: Controller
    robot: DifferentialDrive
    blocked: Blocked | None

    def __call__(self, seed: np.random.SeedSequence) -> MissionResult:
        return run_mission(
            self.mission,
            self.sensor,
            self.controller,
            self.robot,
            np.random.default_rng(seed),
            blocked=self.blocked,
        )
