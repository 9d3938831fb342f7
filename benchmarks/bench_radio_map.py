"""How many valid paths a second, and how the cost grows with receivers.

One command: ``python benchmarks/bench_radio_map.py``. Everything is measured side by side in this
one run: trust the ratios, not the seconds. Kernels are compiled before the clock starts.
"""

import os
import time
import tracemalloc
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from octant.em.antennas import make_antenna
from octant.em.image_search import search_images
from octant.em.radio_map import map_antenna, map_reader
from octant.em.radio_scene import radio_scene
from octant.em.reader_response import sector_response
from octant.em.received_power import antenna_power, reader_link
from octant.geometries.furniture import cabinet
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene

FREQUENCY_HZ = 2.4e9
SOURCE_M = (3.5, 2.0, 2.9)
REPEATS = 3


def grid_m(n):
    """Return the axes of the peers' grid: n x n receivers in the box, off its walls."""
    i = np.arange(n)
    return 0.0531 + i * 4.8938 / (n - 1), 0.0517 + i * 4.8966 / (n - 1)


def measure(work):
    """Return the shortest of a few runs, and the result."""
    best, result = np.inf, None
    for _ in range(REPEATS):
        start = time.perf_counter()
        result = work()
        best = min(best, time.perf_counter() - start)
    return best, result


def main():
    """Print the table."""
    room = box_room((5.0, 5.0, 3.0))
    furniture = (cabinet(size_m=(1.5, 0.35, 1.0), position_m=(1.75, 2.2, 0.0)),)
    scenes = {"empty": build_scene(room), "cabinet": build_scene(room, objects=furniture)}
    dipole = make_antenna("dipole", FREQUENCY_HZ)
    isotropic = make_antenna("isotropic_theta", FREQUENCY_HZ)
    workloads = [
        ("W1      ", "empty", 3, 50),
        ("W1-200  ", "empty", 3, 200),
        ("W1-400  ", "empty", 3, 400),
        ("W2-200  ", "empty", 5, 200),
        ("W3      ", "cabinet", 3, 50),
        ("W3-200  ", "cabinet", 3, 200),
    ]
    print(f"{os.cpu_count()} cores; fields included; best of {REPEATS}")
    print("workload  receivers     paths  million paths/s  us/receiver  peak MiB  vs W1-200")
    rates = {}
    lines = []
    for name, scene_name, order, n in workloads:
        radio = radio_scene(scenes[scene_name], FREQUENCY_HZ)
        tree = search_images(scenes[scene_name], SOURCE_M, order)
        x, y = grid_m(n)

        def work(radio=radio, tree=tree, x=x, y=y):
            return map_antenna(
                radio,
                tree,
                x_m=x,
                y_m=y,
                z_m=0.3,
                transmitter=dipole,
                receiver=isotropic,
                power_w=1.0,
            )

        work()
        seconds, field = measure(work)
        tracemalloc.start()
        work()
        peak = tracemalloc.get_traced_memory()[1] / 2**20
        tracemalloc.stop()
        paths = int(field.path_count.sum())
        rates[name] = paths / seconds
        lines.append((name, n * n, paths, rates[name], seconds / n**2, peak))
    for name, count, paths, rate, each, peak in lines:
        print(
            f"{name}  {count:9d} {paths:9d}  {rate / 1e6:15.2f}  {each * 1e6:11.2f}  {peak:8.1f}"
            f"  {rate / rates['W1-200  ']:9.2f}"
        )
    reader(scenes["empty"], dipole, rates["W1-200  "])
    threads(scenes["empty"], dipole, isotropic)


def reader(scene, dipole, antenna_rate):
    """Print the rate of a map of all eight antennas of a reader, beside that of one antenna."""
    link = reader_link(
        radio_scene(scene, FREQUENCY_HZ),
        tag_position_m=SOURCE_M,
        tag_antenna=dipole,
        tag_power_w=1.0,
        response=sector_response(np.arange(8) * np.pi / 4, frequency_hz=FREQUENCY_HZ),
        reader_height_m=0.3,
        max_reflections=3,
    )
    x, y = grid_m(200)
    seconds, field = measure(lambda: map_reader(link, x_m=x, y_m=y, heading_rad=0.3))
    rate = int(field.path_count.sum()) / seconds
    print(
        f"eight antennas on W1-200: {rate / 1e6:.2f} million paths/s,"
        f" {rate / antenna_rate:.2f} times one antenna"
    )


def threads(scene, dipole, isotropic):
    """Print the gain of the second core, on the same work."""
    radio, tree = radio_scene(scene, FREQUENCY_HZ), search_images(scene, SOURCE_M, 3)
    x, y = grid_m(200)
    gx, gy = np.meshgrid(x, y, indexing="ij")
    places = np.column_stack((gx.ravel(), gy.ravel(), np.full(gx.size, 0.3)))
    seconds = {}
    for workers in (1, os.cpu_count() or 1):
        with ThreadPoolExecutor(workers) as pool:

            def work(pool=pool):
                return antenna_power(
                    radio,
                    tree,
                    places,
                    transmitter=dipole,
                    receiver=isotropic,
                    power_w=1.0,
                    executor=pool,
                )

            seconds[workers], _ = measure(work)
    for workers, taken in seconds.items():
        print(f"{workers} threads: {seconds[1] / taken:.2f} times one thread")


if __name__ == "__main__":
    main()
