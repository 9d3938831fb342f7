"""How a sweep of 10^4 cells is planned, resumed, merged and opened: seconds, and seconds a cell.

``python benchmarks/bench_sweep.py [--cells 10000]`` writes synthetic cells (one computed cell under
ten thousand names), which takes 1.3 GB of disk for a while.
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from octant.reader_design.experiments.sweep.cells import CellCodec
from octant.reader_design.experiments.sweep.compute import study_plan
from octant.reader_design.experiments.sweep.results import open_sweep
from octant.reader_design.experiments.sweep.table import CELLS_FOLDER, known_rows, write_table
from octant.reader_design.keeping.folder import case_path, write_case
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.evaluation import scored_cell
from octant.reader_design.study_file.loading import parse_study, to_toml

STUDY = """
name = "bench"
[room]
free_space = true
[[tag]]
id = "a"
position_m = [0.0, 0.0, 3.0]
antenna = "dipole"
[reader]
response = "isolated"
[sweep]
ground_plane_shape = ["square", "round", "octagon"]
gap_m = {from = 0.001, to = 0.1, count = COUNT}
"""


def timed(name: str, work: Callable[[], object], cells: int) -> object:
    """Return what some work returns, and print the time that it took."""
    began = time.perf_counter()
    result = work()
    seconds = time.perf_counter() - began
    print(f"{name:42s} {seconds:8.2f} s {1e3 * seconds / cells:8.3f} ms a cell")
    return result


def main() -> None:
    """Print the times of each step."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cells", type=int, default=10_000)
    count = parser.parse_args().cells
    text = STUDY.replace("COUNT", str(count // 3))
    study = timed(
        "reading the study", lambda: parse_study(text, source="bench", directory=Path()), count
    )
    plan = timed("planning", lambda: study_plan(study), count)
    first = plan.cells[0]
    cell = scored_cell(first.setting)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / CELLS_FOLDER).mkdir()

        def write() -> None:
            for planned in plan.cells:
                path = case_path(folder / CELLS_FOLDER, planned.key, ".nc")
                content = CellCodec().encode(cell, planned)
                write_case(path, content, {"key": planned.key, "seconds": 0.0})

        timed("writing the cells", write, count)
        quiet = Progress()
        rows = timed(
            "first reading, every file opened",
            lambda: known_rows(plan, folder, progress=quiet),
            count,
        )
        toml = to_toml(study)
        timed("merging: sweep.nc, sweep.csv", lambda: write_table(plan, rows, folder, toml), count)
        timed(
            "resuming, files known by their hash",
            lambda: known_rows(plan, folder, progress=quiet),
            count,
        )
        sweep = timed("opening", lambda: open_sweep(folder), count)
        found = timed(
            "query",
            lambda: sweep.query({"ground_plane_shape": "round", "gap_m": (0.005, 0.02)}),
            count,
        )
        print(
            f"{len(plan.cells)} cells, {len(found)} found; sweep.nc "
            f"{(folder / 'sweep.nc').stat().st_size / 1e6:.1f} MB"
        )


if __name__ == "__main__":
    main()
