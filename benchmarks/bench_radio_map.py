"""What a map of a whole reader costs beside that of one antenna, and what the second core gains.

    python benchmarks/bench_radio_map.py

Paths a second by workload are in ``bench_peers.py``, growth with receivers in ``bench_scaling.py``.
"""

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from workloads import (
    FREQUENCY_HZ,
    RECEIVER_Z_M,
    SOURCE_M,
    WORKLOADS,
    best_of,
    octant_map,
    workload_scene,
)

from octant.em.antennas.kinds import make_antenna
from octant.em.power.radio_map import map_reader
from octant.em.power.received_power import antenna_power, reader_link
from octant.em.reader.response import sector_response
from octant.em.search.candidates import Candidates, SolverSettings
from octant.em.search.images import search_images

WORKLOAD = WORKLOADS["W1-200"]
REPETITIONS = 3


def reader(scene, radio):
    """Print the rate of a map of all eight antennas of a reader, beside that of one antenna."""
    one, found = best_of(REPETITIONS, lambda: octant_map(WORKLOAD, scene, radio))
    link = reader_link(
        radio,
        tag_position_m=SOURCE_M,
        tag_antenna=make_antenna("dipole", FREQUENCY_HZ),
        tag_power_w=1.0,
        response=sector_response(np.arange(8) * np.pi / 4, frequency_hz=FREQUENCY_HZ),
        reader_height_m=RECEIVER_Z_M,
        solver=SolverSettings(max_reflections=WORKLOAD.order),
    )
    x, y = WORKLOAD.axes_m
    eight, _ = best_of(REPETITIONS, lambda: map_reader(link, x_m=x, y_m=y, heading_rad=0.3))
    paths = int(found.path_count.sum())
    print(f"one antenna on {WORKLOAD.name}: {paths / one[0] / 1e6:.2f} million paths/s")
    print(
        f"eight antennas: {paths / eight[0] / 1e6:.2f} million paths/s,"
        f" {eight[1] / one[1]:.2f} times the processor time"
    )


def threads(scene, radio):
    """Print the gain of the second core, on the same work."""
    tree = search_images(scene, SOURCE_M, WORKLOAD.order)
    seconds = {}
    for workers in (1, os.cpu_count() or 1):
        with ThreadPoolExecutor(workers) as pool:

            def work(pool=pool):
                return antenna_power(
                    radio,
                    Candidates(images=tree),
                    WORKLOAD.receivers_m,
                    transmitter=make_antenna("dipole", FREQUENCY_HZ),
                    receiver=make_antenna("isotropic_theta", FREQUENCY_HZ),
                    power_w=1.0,
                    executor=pool,
                )

            seconds[workers] = best_of(REPETITIONS, work)[0][0]
    for workers, taken in seconds.items():
        print(f"{workers} threads: {seconds[1] / taken:.2f} times one thread")


def main():
    """Print both."""
    scene, radio = workload_scene(WORKLOAD)
    octant_map(WORKLOAD, scene, radio)
    reader(scene, radio)
    threads(scene, radio)


if __name__ == "__main__":
    main()
