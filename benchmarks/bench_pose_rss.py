"""What the eight RSS values of one pose cost, and a hundred missions of a hundred steps.

    python benchmarks/bench_pose_rss.py

Rooms of 6, 12, 30 and 60 facets: a concrete box with cabinets on its floor. Reflections up to the
third order, one channel and sixteen from 2.402 to 2.480 GHz, the tag a patch below the ceiling.
Every figure is the best of several repetitions.
"""

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
from workloads import best_of

from octant.em.antennas.kinds import make_antenna
from octant.em.medium.radio_scene import radio_scene
from octant.em.power.received_power import reader_link
from octant.em.reader.response import sector_response
from octant.em.search.candidates import SolverSettings
from octant.geometries.furniture import cabinet
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene

ROOM_M = (7.0, 7.0, 3.1)
CABINET_M = (0.6, 0.4, 1.0)
CABINETS_M = (
    (1.5, 1.0),
    (3.5, 1.0),
    (5.0, 2.0),
    (1.0, 3.0),
    (3.0, 3.2),
    (5.0, 4.0),
    (1.5, 5.0),
    (3.2, 5.2),
    (5.2, 5.5),
)
OFF_THE_FLOOR_M = 0.02
TAG_M = (3.5, 2.2, 3.05)
ORDER = 3
AZIMUTHS_RAD = np.arange(8) * (np.pi / 4.0)
CARRIER_HZ = (2.441e9,)
CHANNELS_HZ = tuple(np.linspace(2.402e9, 2.480e9, 16).tolist())
BATCH = 200
MISSIONS, STEPS = 100, 100
HEADINGS = 72
REPETITIONS = 3


def room(cabinets):
    """Return a room of 6 facets and 6 more for each cabinet."""
    bodies = [
        cabinet(CABINET_M, position_m=(x, y, OFF_THE_FLOOR_M), name=f"cabinet {i}")
        for i, (x, y) in enumerate(CABINETS_M[:cabinets])
    ]
    return build_scene(box_room(ROOM_M), objects=bodies)


def link_of(scene, frequencies_hz):
    """Return the link of the tag over all frequencies."""
    return reader_link(
        [radio_scene(scene, f) for f in frequencies_hz],
        tag_position_m=TAG_M,
        tag_antenna=[make_antenna("patch", f) for f in frequencies_hz],
        tag_power_w=1.0,
        response=[sector_response(AZIMUTHS_RAD, frequency_hz=f) for f in frequencies_hz],
        reader_height_m=0.3,
        solver=SolverSettings(max_reflections=ORDER),
    )


def seconds(call):
    """Return the least wall-clock time of a call [s]."""
    call()
    return best_of(REPETITIONS, call)[0][0]


def one_by_one(link, poses):
    """Read the poses as a robot does: each when the one before is known."""
    for pose in poses:
        link.rss_w(pose[None])


def drive(link, places):
    """Drive the missions on all cores, a mission on one thread, a pose at a time."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(lambda poses: one_by_one(link, poses), places))


def table(link, scene, rng):
    """Print times per pose in one room."""
    poses = np.column_stack((rng.uniform(0.3, 6.7, (BATCH, 2)), rng.uniform(-np.pi, np.pi, BATCH)))
    single = seconds(lambda: one_by_one(link, poses)) / BATCH
    batch = seconds(lambda: link.rss_w(poses)) / BATCH
    places, headings_rad = poses[: BATCH // 10, :2], poses[:HEADINGS, 2]
    headings = seconds(lambda: link.rss_by_heading_w(places, headings_rad)) / len(places)
    facets = len(scene.facets.facet_plane)
    channels = sum(band.channels for band in link.bands)
    print(
        f"{facets:6d} {channels:9d} {link.power(poses).path_count.mean():6.1f} {1e3 * single:9.2f}"
        f" {1e3 * batch:9.2f} {single / batch:9.1f} {1e3 * headings:12.2f}"
    )


def main():
    """Print the table, then what sharing the paths between channels gains, then the missions."""
    rng = np.random.default_rng(1)
    print("facets  channels  paths  ms, one  ms, batch  one/batch  ms, 72 headings")
    for cabinets in (0, 1, 4, 9):
        scene = room(cabinets)
        for frequencies_hz in (CARRIER_HZ, CHANNELS_HZ):
            link = link_of(scene, frequencies_hz)
            table(link, scene, rng)
    bands = tuple(band for f in CHANNELS_HZ for band in link_of(scene, (f,)).bands)
    apart = replace(link, bands=bands)
    poses = np.column_stack((rng.uniform(0.3, 6.7, (BATCH, 2)), rng.uniform(-np.pi, np.pi, BATCH)))
    ratio = seconds(lambda: one_by_one(apart, poses)) / seconds(lambda: one_by_one(link, poses))
    print(f"every channel searched and traced by itself: {ratio:.1f} times the time of a pose")
    search = seconds(lambda: [link_of(scene, (f,)) for f in CHANNELS_HZ])
    search /= seconds(lambda: link_of(scene, CHANNELS_HZ))
    print(f"and {search:.1f} times that of making the link")
    starts = rng.uniform(0.5, 6.5, (MISSIONS, 1, 2))
    steps = rng.normal(0.0, 0.02, (MISSIONS, STEPS, 2)).cumsum(axis=1)
    turns = rng.uniform(-np.pi, np.pi, (MISSIONS, STEPS, 1))
    missions = np.concatenate((np.clip(starts + steps, 0.3, 6.7), turns), axis=2)
    for name, one in (("1 channel", link_of(scene, CARRIER_HZ)), ("16 channels", link)):
        time_s = best_of(1, lambda one=one: drive(one, missions))[0][0]
        print(
            f"{MISSIONS} missions of {STEPS} steps, {name}, {os.cpu_count()} cores: {time_s:.1f} s"
        )


if __name__ == "__main__":
    main()
