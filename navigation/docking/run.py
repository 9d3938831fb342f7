"""One docking mission, or many: coarse and fine stage in turn, try after try."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.docking.stages import CoarseDrive, DockingDrive, FineDrive, LeftTheRoom
from octant.navigation.docking.task import DockingResult, DockingSetting, DockingTask, Failure
from octant.navigation.missions.starts import RandomStarts
from octant.navigation.robot.floor import check_start
from octant.navigation.sensing.sensor import unknown_tag


def run_docking(
    task: DockingTask, setting: DockingSetting, start: npt.ArrayLike, rng: np.random.Generator
) -> DockingResult:
    """Return the record of one docking mission, also of one that fails.

    Parameters
    ----------
    task : What to do.
    setting : Reader, camera, robot and obstacles.
    start : (3,) array_like — x [m], y [m], heading [rad] in the room; the robot does not know them.
    rng : Source of every random number of the run.
    """
    pose = np.array(start, dtype=np.float64)
    if setting.reader is not None and task.tag_id not in setting.reader.tag_ids:
        raise unknown_tag(task.tag_id, setting.reader.tag_ids)
    check_start(pose[:2], setting.blocked, setting.outside)
    if (np.cos(setting.camera.yaw_rad) < 0.0) != task.in_reverse:
        msg = (
            f"the camera looks {np.degrees(setting.camera.yaw_rad):.3g} degrees off the front, but "
            f"a robot that docks by {task.fine.law.approach!r} needs it at the end that comes "
            "first: turn it about."
        )
        raise NavigationError(msg)
    drive = DockingDrive(task, setting, pose=pose, rng=rng)
    fine = FineDrive(task, setting.camera, drive, rng)
    reader = setting.reader
    coarse = None if reader is None else CoarseDrive(task, reader, drive, rng)
    return _sequence(task, drive, coarse, fine)


@dataclass(frozen=True, slots=True, kw_only=True)
class DockingJob:
    """What makes one docking mission from its seed, for `batches.run_seeded`.

    Parameters
    ----------
    task, setting : As for `run_docking`.
    starts : Where missions start.
    """

    task: DockingTask
    setting: DockingSetting
    starts: RandomStarts

    def __call__(self, seed: np.random.SeedSequence) -> DockingResult:
        """Return the record of the run of a seed, from which its start and all its noise come."""
        rng = np.random.default_rng(seed)
        return run_docking(self.task, self.setting, self.starts.draw(rng), rng)


def _sequence(
    task: DockingTask, drive: DockingDrive, coarse: CoarseDrive | None, fine: FineDrive
) -> DockingResult:
    at_station = coarse is None
    attempt = 0
    if coarse is not None and drive.docked:
        return drive.result("docked", "the robot stood in the dock already", tries=0)
    while True:
        attempt += 1
        try:
            failure = None if at_station or coarse is None else coarse.approach(attempt)
            if failure is None and not drive.docked:
                at_station, failure = _attempt(task, drive, fine)
        except LeftTheRoom:
            return drive.result("left the room", "the robot left the room", tries=attempt)
        if failure is None:
            return drive.result("docked", "the robot stands in the dock", tries=attempt)
        if drive.worn_out or attempt >= task.tries:
            return drive.result(*failure, tries=attempt)


def _attempt(
    task: DockingTask, drive: DockingDrive, fine: FineDrive
) -> tuple[bool, Failure | None]:
    """Return whether the robot is at the station after a try, and why it is not docked."""
    if np.isnan(drive.staged_m):
        staging = task.landmark.goal(task.staging_m)
        drive.staged_m = float(np.hypot(*(drive.pose - staging)[:2]))
    track = fine.search()
    if track is None:
        return False, ("landmark not found", "no landmark came into view at the staging place")
    failure = fine.dock(track)
    if failure is not None:
        away_m = task.staging_m - task.stand_off_m
        drive.straight(away_m if task.in_reverse else -away_m, "back off")
    return True, failure
