"""Which settings of the tracker hold in rooms of every kind: the search behind its defaults.

Draws rooms (4 to 14 m long, 2.4 to 6 m high, of concrete, brick or plasterboard, with metal
cabinets and wooden tables) with two tags on the ceiling, a reader of 4, 8 or 16 antennas, and a
link of its own: the tag's level off by up to 10 dB either way, a tenth or half of the readings
lost. Every candidate drives the same runs. After each round the better half stays and twice the
rooms come; the last round is driven in fresh rooms. The score of a run is 0 where it failed, else
the straight way over the way driven. Run: ``python benchmarks/search_tracker.py``.
"""

import argparse
import math
import time
import warnings
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import OctantError, PhysicsWarning
from octant.navigation.missions.batches import run_seeded
from octant.navigation.missions.metrics import measure
from octant.navigation.missions.run import MissionJob
from octant.navigation.navigators.place_particles import PlaceFilter
from octant.navigation.navigators.tracker import TrackerNavigator
from octant.navigation.sensing.sensor import FieldSensor, PowerLink
from octant.reader_design.experiments.missions.compute import mission_job, mission_space
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import study_of_tables

Candidate = dict[str, float]

BEFORE: Candidate = {
    "trust": 0.5,
    "fading_db": 4.0,
    "level_db": 1e-3,
    "shared_db": 4.2,  # 3 dB of each reading, weighed by trust
    "shared_m": 1e-3,
    "most": 2000,
    "loyalty": 1.0,
    "independent": 1e9,
    "contact_weight": 0.0,
}
"""As it was: the level known, the antennas' errors independent, contacts ignored."""

SPACE: dict[str, tuple[float, ...]] = {
    "trust": (0.25, 0.35, 0.5),
    "fading_db": (4.0, 6.0, 8.0),
    "level_db": (6.0, 10.0, 20.0),
    "shared_db": (2.5, 3.5, 5.0),
    "shared_m": (0.25, 0.7, 1.5),
    "independent": (4.0, 8.0),
    "contact_weight": (0.0, 0.9),
}
"""What is tried for each setting of `PlaceFilter`."""

CHANNELS_HZ = (2.405e9, 2.44e9, 2.475e9)
_MOST_DRAWS = 200


@dataclass(frozen=True, slots=True)
class OffLevel:
    """A link whose power is another than the robot believes."""

    link: PowerLink
    factor: float

    def rss_w(self, poses: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Return the received power of each antenna, (m, n) [W]."""
        return self.factor * self.link.rss_w(poses)


def drawn_tables(rng: np.random.Generator) -> dict[str, Any]:
    """Return the tables of a study of one room, which may be one that cannot be built."""
    hall = rng.random() < 0.25
    size = rng.uniform(8.0, 14.0, 2) if hall else rng.uniform(4.0, 8.0, 2)
    height = rng.uniform(3.5, 6.0) if hall else rng.uniform(2.4, 3.2)
    objects = []
    for number in range(int(rng.integers(1, 5))):
        low = rng.uniform([0.3, 0.3], size - 1.0)
        objects.append(
            {
                "kind": "cabinet",
                "name": f"cabinet {number}",
                "size_m": rng.uniform([0.5, 0.35, 0.8], [1.4, 0.6, 2.0]).tolist(),
                "position_m": [*low.tolist(), 0.0],
                "yaw_deg": float(rng.uniform(-45.0, 45.0)),
                "material": "metal",
            }
        )
    if rng.random() < 0.5:
        objects.append(
            {
                "kind": "box",
                "name": "table",
                "size_m": [1.4, 0.8, 0.03],
                "position_m": [*rng.uniform([0.3, 0.3], size - 1.7).tolist(), 0.72],
                "material": "chipboard",
            }
        )
    tags = [
        {
            "id": name,
            "position_m": [*rng.uniform([0.5, 0.5], size - 0.5).tolist(), height - 0.05],
            "antenna": str(rng.choice(["conical_patch", "conical_patch", "patch"])),
        }
        for name in ("A", "B")
    ]
    return {
        "room": {
            "box_m": [*size.tolist(), float(height)],
            "material": str(rng.choice(["concrete", "concrete", "brick", "plasterboard"])),
            "object": objects,
        },
        "radio": {"frequency_hz": 2.44e9, "channels_hz": list(CHANNELS_HZ)},
        "tag": tags,
        "reader": {"antennas": int(rng.choice([4, 8, 16])), "height_m": 0.3},
        "solver": {"max_reflections": 2},
        "mission": {
            "start_m": rng.uniform([0.5, 0.5], size - 0.5).tolist(),
            "heading_deg": float(rng.uniform(-180.0, 180.0)),
            "tags": ["A", "B"],
            "navigator": "tracker",
            "contact": "slide",
        },
    }


def room_job(number: int) -> MissionJob:
    """Return what drives one run in a room, its link and level as drawn for it."""
    rng = np.random.default_rng((14, number))
    for _ in range(_MOST_DRAWS):
        try:
            study = study_of_tables(drawn_tables(rng), source="a drawn room", directory=Path())
            setting = build_setting(study)
            points = np.array([setting.mission.start_m, *(tag.point_m for tag in setting.tags)])
            legs = np.linalg.norm(np.diff(points, axis=0), axis=1)
            if legs.min() < 1.5 or not mission_space(setting)(points).all():
                continue
            job = mission_job(setting, noise_db=rng.uniform(0.5, 2.0))
        except OctantError:
            continue
        sensor, factor = job.sensor, 10.0 ** (0.1 * rng.uniform(-10.0, 10.0))
        assert isinstance(sensor, FieldSensor)  # noqa: S101  for the type checker
        links = {name: OffLevel(link, factor) for name, link in sensor.links.items()}
        lost = float(rng.choice([0.1, 0.5]))
        return replace(job, sensor=replace(sensor, links=links, drop_out_probability=lost))
    msg = f"no room could be drawn for number {number}"
    raise RuntimeError(msg)


def scores(number: int, candidates: Sequence[Candidate]) -> list[tuple[float, float, float]]:
    """Return success, score and largest arrival error [m] of each candidate's run in a room."""
    warnings.simplefilter("ignore", PhysicsWarning)
    job, found = room_job(number), []
    for candidate in candidates:
        tracker = job.navigator
        assert isinstance(tracker, TrackerNavigator)  # noqa: S101  for the type checker
        filters = tuple(replace(one, **candidate) for one in tracker.filters)
        trial = replace(job, navigator=replace(tracker, filters=filters))
        (result,) = run_seeded(trial, runs=1, seed=number)
        metrics = measure(result)
        straight_m = float(
            np.linalg.norm(np.diff(result.mission.waypoints_m, axis=0), axis=1).sum()
        )
        score = metrics.success * straight_m / max(straight_m, metrics.path_m)
        found.append((float(metrics.success), score, float(np.max(metrics.arrival_errors_m))))
    return found


def text_of(candidate: Candidate) -> str:
    """Return a candidate in one line."""
    return ", ".join(f"{key} {value:g}" for key, value in candidate.items())


def tried(
    candidates: Sequence[Candidate], rooms: Iterable[int], pool: ProcessPoolExecutor
) -> npt.NDArray[np.float64]:
    """Return (rooms, candidates, 3): see `scores`."""
    return np.array(list(pool.map(partial(scores, candidates=candidates), rooms)))


def show(candidates: Sequence[Candidate], found: npt.NDArray[np.float64]) -> None:
    """Print a line for each candidate, the best first."""
    runs = len(found)
    for i in np.argsort(-found[:, :, 1].mean(axis=0), kind="stable"):
        good = found[found[:, i, 0] > 0.0, i, 2]
        error = float(np.median(good)) if len(good) else math.nan
        print(
            f"  {int(found[:, i, 0].sum()):3d} of {runs} reached, score "
            f"{found[:, i, 1].mean():.3f}, arrival {error:.2f} m: {text_of(candidates[i])}",
            flush=True,
        )


def main() -> None:
    """Search, then show the best, the defaults in force and those before in fresh rooms."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--candidates", type=int, default=16, help="drawn at random")
    parser.add_argument("--rooms", type=int, default=8, help="in the first round")
    parser.add_argument("--rounds", type=int, default=3, help="rounds that halve the candidates")
    parser.add_argument("--fresh", type=int, default=40, help="rooms of the last comparison")
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    begun, rng = time.monotonic(), np.random.default_rng(14)
    candidates = [
        {key: float(rng.choice(values)) for key, values in SPACE.items()}
        for _ in range(given.candidates)
    ]
    in_force: Candidate = {
        key: float(PlaceFilter.__dataclass_fields__[key].default) for key in SPACE
    }
    candidates.insert(0, in_force)
    with ProcessPoolExecutor(given.workers) as pool:
        found, first = np.empty((0, len(candidates), 3)), 0
        for number in range(given.rounds):
            rooms = given.rooms * 2**number
            more = tried(candidates, range(first, first + rooms), pool)
            found, first = np.concatenate([found, more]), first + rooms
            print(f"round {number + 1}, {len(found)} rooms, {time.monotonic() - begun:.0f} s")
            show(candidates, found)
            best = np.argsort(-found[:, :, 1].mean(axis=0), kind="stable")
            kept = best[: max(2, len(candidates) // 2)]
            candidates, found = [candidates[i] for i in kept], found[:, kept]
        final = [candidates[0], in_force, BEFORE]
        fresh = tried(final, range(first, first + given.fresh), pool)
    print("in fresh rooms: the best, the defaults in force, those before")
    show(final, fresh)


if __name__ == "__main__":
    main()
