"""How the cost of a map grows with its receivers, from a thousand to a million.

    python benchmarks/bench_scaling.py [--figure docs/figures/scaling.png]

Images are searched before the clock starts, as they do not depend on the receivers. Memory is what
is held at the peak beyond the receivers' places and the results, which the caller keeps.
"""

import argparse
import tracemalloc
from pathlib import Path

import numpy as np
from workloads import (
    FREQUENCY_HZ,
    RECEIVER_Z_M,
    SOURCE_M,
    WORKLOADS,
    timed,
    workload_scene,
)

from octant.em.antennas.kinds import make_antenna
from octant.em.power.received_power import antenna_power
from octant.em.search.candidates import Candidates
from octant.em.search.images import search_images

COUNTS = (1_000, 3_162, 10_000, 31_623, 100_000, 316_228, 1_000_000)
NAMES = {"W1": "empty room, order 3", "W3": "room with cabinet, order 3"}
MANY = 50_000
"""Receivers from which on one run is long enough to be timed once."""
RESULT_BYTES = 24
"""Two powers and a count for each receiver."""


def places(count):
    """Return receivers spread evenly over the floor, (count, 3) [m]: a lattice of rank one."""
    i = np.arange(count)
    golden = 0.5 * (5.0**0.5 - 1.0)
    x, y = (i + 0.5) / count, (i * golden) % 1.0
    return np.column_stack((0.05 + 4.9 * x, 0.05 + 4.9 * y, np.full(count, RECEIVER_Z_M)))


def measure(name, repetitions):
    """Return seconds, seconds of all cores and MiB held beyond the result, for each count."""
    workload = WORKLOADS[name]
    scene, radio = workload_scene(workload)
    tree = search_images(scene, SOURCE_M, workload.order)
    rows = []
    for count in COUNTS:
        receivers = places(count)

        def work(receivers=receivers):
            return antenna_power(
                radio,
                Candidates(images=tree),
                receivers,
                transmitter=make_antenna("dipole", FREQUENCY_HZ),
                receiver=make_antenna("isotropic_theta", FREQUENCY_HZ),
                power_w=1.0,
            )

        seconds, found, held = np.full(2, np.inf), None, 0.0
        for _ in range(repetitions if count <= MANY else 1):
            tracemalloc.start()
            spent, found = timed(work)
            held = tracemalloc.get_traced_memory()[1] - count * RESULT_BYTES
            tracemalloc.stop()
            seconds = np.minimum(seconds, spent)
        rows.append((*seconds, held / 2**20, int(found.path_count.sum())))
        print(
            f"{name:4s} {count:9d} {rows[-1][3]:10d} {seconds[0]:9.3f} {seconds[1]:9.3f}"
            f" {rows[-1][3] / seconds[0] / 1e6:9.2f} {held / 2**20:9.2f}",
            flush=True,
        )
    return np.array(rows)


def slope(seconds):
    """Return the exponent of the cost: the least-squares slope of log time over log receivers."""
    return np.polyfit(np.log(COUNTS), np.log(seconds), 1)[0]


def draw(found, file):
    """Write the figure: time and memory over the number of receivers."""
    import matplotlib as mpl

    mpl.use("agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 5), layout="constrained")
    for (name, rows), marker in zip(found.items(), "os", strict=True):
        label = f"{name}: {NAMES[name]}"
        left.loglog(
            COUNTS, rows[:, 1], marker=marker, label=f"{label}; slope {slope(rows[:, 1]):.3f}"
        )
        right.semilogx(COUNTS, rows[:, 2] * 2**20 / COUNTS, marker=marker, label=label)
    left.loglog(COUNTS, rows[0, 1] * np.array(COUNTS) / COUNTS[0], "k:", lw=1, label="proportional")
    left.set(title="Cost of a map", xlabel="receivers", ylabel="processor time of all cores [s]")
    right.set(
        title="Memory for each receiver, beyond place and result",
        xlabel="receivers",
        ylabel="peak [byte / receiver]",
        ylim=(0, None),
    )
    for axes in (left, right):
        axes.grid(visible=True, which="major", alpha=0.3)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.15))
    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, dpi=120)


def main():
    """Read the command line and run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--figure", type=Path)
    parser.add_argument("--repetitions", type=int, default=5)
    arguments = parser.parse_args()
    print("work receivers      paths   seconds       cpu  M paths/s  MiB more")
    found = {name: measure(name, arguments.repetitions) for name in NAMES}
    for name, rows in found.items():
        print(
            f"{name}: slope of log cost over log receivers {slope(rows[:, 0]):.3f},"
            f" by processor time {slope(rows[:, 1]):.3f}"
        )
    if arguments.figure is not None:
        draw(found, arguments.figure)
        print(f"written: {arguments.figure}")


if __name__ == "__main__":
    main()
