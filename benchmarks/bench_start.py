"""How long starting takes: ``import octant`` and ``octant --help``, beside Python alone.

    python benchmarks/bench_start.py

Prints the least time of several starts of each, taken in turns, and its ratio to an empty program.
"""

import subprocess
import sys
import time

ROUNDS = 9
CALLS = {
    "python": "pass",
    "import octant": "import octant",
    "octant --help": "from octant.reader_design.cli import run; run(['--help'])",
    "import numpy": "import numpy",
}


def start_s(code: str) -> float:
    """Return how long a program takes from its start to its end [s]."""
    began = time.perf_counter()
    subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    return time.perf_counter() - began


def main() -> None:
    """Print a line for each call."""
    times: dict[str, list[float]] = {name: [] for name in CALLS}
    for _ in range(ROUNDS):
        for name, code in CALLS.items():
            times[name].append(start_s(code))
    alone = min(times["python"])
    for name, found in times.items():
        print(f"{name:16s}{min(found):8.3f} s{min(found) / alone:8.1f} x python")


if __name__ == "__main__":
    main()
