"""The first, second and third mission of a robot in a room that it is told wrongly.

    python benchmarks/second_mission.py --worlds 10

A concrete room with dipole tags. In each world every tag hangs elsewhere than surveyed and has
another level, every antenna has another gain, and a metal cabinet stands there that the map lacks;
the true field has one reflection more and diffraction, and the wheels slip by 2 %. A robot drives
three missions in it, each taught by those before (as `mission.map.earlier_missions` does). A second
robot drives with the same seeds without being taught. Printed: missions that reached every tag to
40 cm, and to 5 cm, with Wilson's 95 % interval, and medians of the worst arrival, of the time and
of the way.
"""

import argparse
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np

from octant.navigation.missions.metrics import MissionMetrics, measure
from octant.navigation.missions.run import MissionJob, run_mission
from octant.navigation.navigators.map_navigator import MapNavigator
from octant.navigation.statistics import wilson
from octant.reader_design.experiments.missions.compute import mission_job
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.mapping.pose_filter import MapStore
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.setting.solving import solved
from octant.reader_design.setting.truth import true_world
from octant.reader_design.study_file.loading import parse_study

STUDY = """
[room]
box_m = [5.2, 4.4, 2.8]
material = "concrete"
[[tag]]
id = "a"
position_m = [4.2, 1.0, 2.75]
antenna = "dipole"
[[tag]]
id = "b"
position_m = [3.6, 3.4, 2.75]
antenna = "dipole"
[[tag]]
id = "c"
position_m = [1.2, 3.2, 2.75]
antenna = "dipole"
[reader]
antenna_radius_m = 0.10
plate_height_m = 0.08
height_m = 0.3
[solver]
max_reflections = 2
[mission]
navigator = "map"
start_m = [0.8, 0.8]
heading_deg = 0.0
tags = ["a", "b", "c"]
contact = "slide"
noise_db = 1.0
map.tag_sd_m = {tag_sd_m}
map.particles = {particles}
[truth]
tag_sd_m = {tag_sd_m}
tag_level_sd_db = 2.0
antenna_gain_sd_db = 1.0
max_reflections = 3
diffraction = true
wheel_slip = 0.02
wheel_scale = 0.02
[[truth.object]]
kind = "box"
size_m = [0.4, 0.8, 1.4]
position_m = [2.2, 1.6, 0.0]
material = "metal"
"""
NEAR_M = 0.05
MISSIONS = 3


def told(tag_sd_m: float, particles: int) -> Setting:
    """Return the room that the robot is told."""
    text = STUDY.format(tag_sd_m=tag_sd_m, particles=particles)
    study = parse_study(text, source="second_mission", directory=Path())
    return solved(build_setting(study), Progress())


def job_of(setting: Setting, seed: int, folder: Path) -> MissionJob:
    """Return what drives in the world of a seed."""
    world = true_world(setting, np.random.default_rng(seed))
    return mission_job(setting, world=world, maps=MapStore(folder=folder))


def driven(
    number: int, *, seed: int, tag_sd_m: float, particles: int, folder: Path, teach: bool
) -> list[MissionMetrics]:
    """Return the missions of one robot in one world, in their order."""
    job = job_of(told(tag_sd_m, particles), seed + number, folder)
    navigator, found = job.navigator, []
    for child in np.random.SeedSequence((seed, number)).spawn(MISSIONS):
        result = run_mission(
            job.mission, job.sensor, navigator, job.robot, np.random.default_rng(child),
            blocked=job.blocked, outside=job.outside,
        )  # fmt: skip
        found.append(measure(result))
        if teach and result.learned is not None and isinstance(navigator, MapNavigator):
            navigator = navigator.taught(result.learned)
    return found


def worst_m(metrics: MissionMetrics) -> float:
    """Return the greatest distance from a tag on arrival; inf: one was not reached [m]."""
    off = metrics.arrival_errors_m
    return float(off.max()) if np.isfinite(off).all() else np.inf


def rows(label: str, missions: list[list[MissionMetrics]]) -> Iterator[str]:
    """Yield a line of the table for the first, second and third mission of all worlds."""
    for k in range(MISSIONS):
        these = [one[k] for one in missions]
        near = sum(worst_m(m) <= NEAR_M for m in these)
        share = wilson(sum(m.success for m in these), len(these))
        close = wilson(near, len(these))
        yield (
            f"{label:8s} {k + 1}  {sum(m.success for m in these):3d} of {len(these)} "
            f"({100 * share.low:.0f} to {100 * share.high:.0f} %)  {near:3d} "
            f"({100 * close.low:.0f} to {100 * close.high:.0f} %)  "
            f"{100 * np.median([worst_m(m) for m in these]):6.1f} cm  "
            f"{np.median([m.time_s for m in these]):5.0f} s  "
            f"{np.median([m.path_m for m in these]):5.1f} m  "
            f"{np.mean([m.contacts for m in these]):5.1f}"
        )


def main() -> None:
    """Drive and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--worlds", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tag-sd-m", type=float, default=0.03)
    parser.add_argument("--particles", type=int, default=2000)
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_args()
    began = time.process_time()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        job_of(told(given.tag_sd_m, given.particles), given.seed, folder)  # makes the maps
        print("robot    n  to 40 cm  to 5 cm  worst arrival  time  way  contacts", flush=True)
        for label, teach in (("taught", True), ("untaught", False)):
            work = partial(
                driven, seed=given.seed, tag_sd_m=given.tag_sd_m, particles=given.particles,
                folder=folder, teach=teach,
            )  # fmt: skip
            if given.workers == 1:
                missions = [work(number) for number in range(given.worlds)]
            else:
                with ProcessPoolExecutor(given.workers) as pool:
                    missions = list(pool.map(work, range(given.worlds)))
            for line in rows(label, missions):
                print(line, flush=True)
    print(f"{time.process_time() - began:.0f} s of processor time in this process")


if __name__ == "__main__":
    main()
