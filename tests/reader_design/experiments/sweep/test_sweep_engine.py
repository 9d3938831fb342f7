"""Laws of the sweep's engine: nothing is lost, and every crew of workers gives the same bits."""

import errno
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import numpy as np
import pytest

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.sweep.plan import plan_sweep
from octant.reader_design.experiments.sweep.run import run_sweep
from octant.reader_design.keeping.folder import cell_path, sweep_folder
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.small_netcdf import netcdf_bytes, read_netcdf
from octant.reader_design.keeping.workers import LocalProcesses, open_crew
from octant.reader_design.setting.evaluation import SweepContext
from octant.reader_design.setting.samples import Sampling
from octant.reader_design.setting.scene import build_study_scene
from octant.reader_design.study_file.loading import parse_study

STUDY = """
name = "small"
[room]
free_space = true
[[tag]]
id = "A"
position_m = [1.0, 1.0, 3.0]
[reader]
response = "isolated"
[sweep]
"""
COARSE = Sampling(free_azimuths=2, travel_step_m=1.0, distance_step_m=1.5)


def plan_of(sweep, sampling=COARSE):
    study = parse_study(STUDY + sweep, source="test", directory=Path.cwd())
    return plan_sweep(SweepContext(study=study, built=build_study_scene(study), sampling=sampling))


def content(folder, plan):
    """Everything in the cells' files but the time that they took."""
    found = {}
    for key in plan.keys:
        arrays, attributes = read_netcdf(cell_path(folder, key).read_bytes())
        for name in ("seconds", "digest"):
            del attributes[name]
        numbers = {name: (a.dtype.str, a.shape, a.tolist()) for name, a in arrays.items()}
        found[key] = repr((sorted(numbers.items()), sorted(attributes.items())))
    return found


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
def test_sweep_killed_at_ten_random_moments_ends_in_the_same_bits(tmp_path):
    plan = plan_of("gap_m = {from = 0.005, to = 0.02, count = 50}\nheight_m = [0.2, 0.3, 0.4, 0.5]")
    assert len(plan.cells) == 200
    run_sweep(plan, tmp_path / "whole")
    moments = np.random.default_rng(5)
    fork = multiprocessing.get_context("fork")
    counts = [0]
    killed = tmp_path / "killed"
    for _ in range(10):
        child = fork.Process(target=run_sweep, args=(plan, killed))
        child.start()
        child.join(moments.uniform(0.05, 0.5))
        child.kill()
        child.join()
        counts.append(len(list(killed.glob("[!.]*.nc"))))
    assert counts == sorted(counts)
    assert 0 < counts[-1] < 200
    (killed / f".{'0' * 32}-left.nc").write_bytes(b"half a cell")
    run_sweep(plan, killed)
    assert content(killed, plan) == content(tmp_path / "whole", plan)
    assert sorted(p.name for p in killed.iterdir()) == sorted(
        cell_path(killed, key).name for key in plan.keys
    )


def test_temporary_files_of_a_run_that_still_goes_on_are_left_alone(tmp_path):
    part = tmp_path / f".{'0' * 32}-half.nc"
    with sweep_folder(tmp_path):
        part.write_bytes(b"")
        with sweep_folder(tmp_path):
            assert part.exists()
    with sweep_folder(tmp_path):
        assert not part.exists()


@pytest.mark.skipif(sys.platform == "win32", reason="no fork")
def test_two_sweeps_at_once_in_one_folder_do_no_harm(tmp_path):
    plan = plan_of("gap_m = {from = 0.005, to = 0.02, count = 20}")
    run_sweep(plan, tmp_path / "alone")
    fork = multiprocessing.get_context("fork")
    both = [fork.Process(target=run_sweep, args=(plan, tmp_path / "both")) for _ in range(2)]
    for child in both:
        child.start()
    for child in both:
        child.join()
        assert child.exitcode == 0
    assert content(tmp_path / "both", plan) == content(tmp_path / "alone", plan)


# At full sampling the sums are long enough for BLAS to split them among threads.
FULL = "gap_m = [0.005, 0.01]\nantenna_radius_m = [0.05, 0.1]"


@pytest.fixture(scope="module")
def computed_here(tmp_path_factory):
    folder = tmp_path_factory.mktemp("here")
    plan = plan_of(FULL, Sampling())
    run_sweep(plan, folder)
    return plan, content(folder, plan)


@pytest.mark.parametrize("crew", [{"workers": 2}, {"cluster": "local:2"}], ids=str)
def test_workers_compute_the_same_bits(computed_here, tmp_path, crew):
    if "cluster" in crew:
        pytest.importorskip("distributed")
    plan, here = computed_here
    with open_crew(**crew) as workers:
        assert workers.size == 2
        cells = run_sweep(plan, tmp_path, crew=workers)
    assert not any(cell.reason for cell in cells)
    assert content(tmp_path, plan) == here


class BreakingCrew:
    """A pool of processes in which one cell kills its worker, and with it the pool."""

    size = 2

    def __init__(self, deadly):
        self.deadly, self.renewed, self.broken, self.taken = deadly, 0, False, 0

    def submit(self, call, planned, version):
        if self.broken:
            raise BrokenProcessPool
        self.taken += 1
        future = Future()
        self.broken = planned.key == self.deadly
        if self.broken:
            future.set_exception(BrokenProcessPool())
        else:
            future.set_result(call(planned, version))
        return future

    def renew(self):
        self.renewed += 1
        self.broken = False

    def stop(self):
        pass


def test_killed_worker_costs_only_the_cell_that_kills_it(tmp_path, capsys):
    plan = plan_of("gap_m = {from = 0.005, to = 0.02, count = 6}")
    crew = BreakingCrew(plan.keys[3])
    cells = run_sweep(plan, tmp_path, crew=crew, progress=Progress(quiet=False))
    assert [bool(cell.reason) for cell in cells] == [i == 3 for i in range(6)]
    assert "want of memory" in cells[3].reason
    assert crew.renewed >= 2
    assert "one at a time" in capsys.readouterr().err
    assert not any(cell.reason for cell in run_sweep(plan, tmp_path))


def test_crew_is_renewed_after_a_worker_died():
    crew = LocalProcesses(1)
    try:
        with pytest.raises(BrokenProcessPool):
            crew.submit(os._exit, 1).result()
        crew.renew()
        assert crew.submit(abs, -2).result() == 2
    finally:
        crew.stop()


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="looks processes up in /proc")
def test_workers_leave_when_the_process_that_started_them_is_killed(tmp_path):
    script = (
        "import os, time\n"
        "from octant.reader_design.keeping.workers import LocalProcesses\n"
        "if __name__ == '__main__':\n"
        "    crew = LocalProcesses(1)\n"
        "    print(crew.submit(os.getpid).result(), flush=True)\n"
        "    time.sleep(60)\n"
    )
    (tmp_path / "main.py").write_text(script)
    command = [sys.executable, str(tmp_path / "main.py")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        worker = int(child.stdout.readline())
        assert Path(f"/proc/{worker}").exists()
        child.send_signal(signal.SIGKILL)
    deadline = time.monotonic() + 30
    while _runs(worker) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not _runs(worker)


def _runs(pid):
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state != "Z"


def test_full_disk_is_one_sentence_and_loses_nothing(tmp_path, monkeypatch):
    plan = plan_of("gap_m = {from = 0.005, to = 0.02, count = 5}")
    written, real = [], Path.write_bytes

    def full(self, data):
        if len(written) == 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written.append(self)
        return real(self, data)

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(ConfigError, match="No space left on device") as caught:
        run_sweep(plan, tmp_path)
    assert "\n" not in str(caught.value)
    monkeypatch.undo()
    there = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert len(there) == 2
    assert not any(cell.reason for cell in run_sweep(plan, tmp_path))
    assert all((tmp_path / name).read_bytes() == data for name, data in there.items())


def test_small_netcdf_needs_units_and_coordinates_and_keeps_bits():
    stored = {
        "x": (["x"], np.array([1.0, np.nan]), "m", "place"),
        "word": (["x"], ["eins", "zwei µ"], "1", "words"),
        "empty": ([], np.float64(0.1), "W", "one number"),
    }
    data = netcdf_bytes(stored, {"note": "µ", "count": 3})
    assert data == netcdf_bytes(stored, {"note": "µ", "count": 3})
    arrays, attributes = read_netcdf(data)
    assert arrays["word"].tolist() == ["eins", "zwei µ"]
    np.testing.assert_array_equal(arrays["x"], [1.0, np.nan])
    assert (arrays["empty"], attributes["note"], attributes["count"]) == (0.1, "µ", 3)
    with pytest.raises(ValueError, match="units"):
        netcdf_bytes({"x": (["x"], [1.0], "", "place")}, {})
    with pytest.raises(ValueError, match="coordinate"):
        netcdf_bytes({"y": (["x"], [1.0], "m", "place")}, {})
