"""The contract of the keeper: nothing is lost, nothing is computed twice, and bits never change."""

import errno
import os
import pickle
import signal
import subprocess
import sys
import time
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest
from kept_points import Place, Point, compute

from octant.em.blocks import cores
from octant.geometries.errors import ConfigError, GeometryError, SweepStateError
from octant.reader_design.keeping import keeper
from octant.reader_design.keeping.folder import case_path, claimed
from octant.reader_design.keeping.keeper import RecordCodec, kept_cases, map_cases
from octant.reader_design.keeping.keys import case_keys
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.workers import LocalProcesses

HERE = Path(__file__).resolve()
ROOT = HERE.parents[3]
LEFT_OUT = ("Place.name", "Place.wait_s", "Place.log")
CODEC = RecordCodec(Point)


def run(folder, cases=range(4), place=None, **options):
    options.setdefault("codec", CODEC)
    options.setdefault("leave_out", LEFT_OUT)
    return map_cases(compute, list(cases), context=place or Place(), folder=folder, **options)


def bits(kept):
    return [(k.key, k.reason, k.record and (k.record.x, k.record.values.tobytes())) for k in kept]


def content(folder):
    """Return every file without the time that it took."""
    found = {}
    for path in sorted(folder.iterdir()):
        text, _, line = path.read_bytes().rstrip(b"\n").rpartition(b"\n")
        facts = msgspec.json.decode(line)
        del facts["seconds"], facts["digest"]
        found[path.name] = text, sorted(facts.items())
    return found


def test_records_come_back_bit_by_bit_in_order_and_are_computed_once(tmp_path):
    log = tmp_path / "log"
    place = Place(log=str(log))
    first = run(tmp_path / "f", [2, 0, 2, 1], place)
    assert [k.value.x for k in first] == [2.0, 0.0, 2.0, 1.0]
    assert bits(run(tmp_path / "f", [2, 0, 2, 1], place)) == bits(first)
    assert sorted(log.read_text().split()) == ["0", "1", "2"]
    names = {case_path(tmp_path, k.key, ".msgpack").name for k in first}
    assert {p.name for p in (tmp_path / "f").iterdir()} == names


@pytest.mark.parametrize("change", [
    {"seed": 8}, {"size": 201}, {"table": np.arange(3.0) + 1e-16 + [0, 0, 1e-15]},
    {"table": np.arange(3)}, {"table": np.arange(3.0)[:, None]},
], ids=str)  # fmt: skip
def test_every_input_is_part_of_the_key(change):
    base = case_keys(compute, [1], context=Place(), leave_out=LEFT_OUT)
    assert case_keys(compute, [1], context=replace(Place(), **change), leave_out=LEFT_OUT) != base
    assert case_keys(run, [1], context=Place(), leave_out=LEFT_OUT) != base
    assert len(set(case_keys(compute, [1, 2, 1.0, "1", (1,), None], context=Place()))) == 6


def test_what_is_named_out_is_not_part_of_the_key():
    base = case_keys(compute, [1], context=Place(), leave_out=LEFT_OUT)
    renamed = replace(Place(), name="other", wait_s=1.0)
    object.__setattr__(renamed, "derived", 3)
    assert case_keys(compute, [1], context=renamed, leave_out=LEFT_OUT) == base
    assert case_keys(compute, [1], context={"b": 1, "a": {2, 3}}) == case_keys(
        compute, [1], context={"a": {3, 2}, "b": 1}
    )
    with pytest.raises(ValueError, match="no field 'nmae'"):
        case_keys(compute, [1], context=Place(), leave_out=("Place.nmae",))
    with pytest.raises(TypeError, match="cannot be part"):
        case_keys(compute, [object()], context=None)
    with pytest.raises(TypeError, match="not a function of a module"):
        case_keys(lambda *_: None, [1], context=None)


def test_files_count_by_their_content(tmp_path):
    one, two = tmp_path / "one", tmp_path / "two"
    one.write_text("same")
    two.write_text("same")
    keys = case_keys(compute, [str(one), two], context=None)
    assert keys[0] == keys[1]
    two.write_text("other")
    assert case_keys(compute, [two], context=None)[0] != keys[0]


@pytest.mark.parametrize(
    ("scene", "text", "other"),
    [
        ("room.gltf", '{"buffers": [{"uri": "a%20room.bin"}]}', "a room.bin"),
        (
            "room.xml",
            "<scene><string name='filename' value='meshes/wall.ply'/></scene>",
            "wall.ply",
        ),
    ],
)
def test_files_count_by_the_content_of_those_that_hold_their_meshes(tmp_path, scene, text, other):
    (tmp_path / "meshes").mkdir()
    named = tmp_path / ("meshes" if other.endswith("ply") else "") / other
    (tmp_path / scene).write_text(text)
    keys = []
    for content in ("flat", "flat", "steep"):
        named.write_text(content)
        keys += case_keys(compute, [str(tmp_path / scene)], context=None)
    assert keys[0] == keys[1]
    assert keys[1] != keys[2]


def test_damaged_cut_and_foreign_files_are_computed_again(tmp_path, capsys):
    first = run(tmp_path, range(5))
    cut, changed, foreign, empty, other = (k.path for k in first)
    whole = changed.read_bytes()
    cut.write_bytes(cut.read_bytes()[:100])
    changed.write_bytes(whole.replace(b"\xc2\xb5", b"\xc2\xb6"))
    foreign.write_bytes(other.read_bytes())
    empty.write_bytes(b"")
    there = kept_cases(
        compute, range(5), context=Place(), folder=tmp_path, codec=CODEC, leave_out=LEFT_OUT
    )
    assert [k is None for k in there] == [True] * 4 + [False]
    again = run(tmp_path, range(5), progress=Progress(quiet=False))
    assert bits(again) == bits(first)
    said = capsys.readouterr().err
    assert said.count("damaged or belongs to another case. It is computed again") == 4
    assert bits(run(tmp_path, range(5))) == bits(first)


def test_a_record_that_the_program_no_longer_understands_is_computed_again(tmp_path):
    class Older(RecordCodec):
        def decode(self, content, case):
            if self.kind is None:
                raise KeyError("x")
            return super().decode(content, case)

    run(tmp_path, [1])
    there = kept_cases(
        compute, [1], context=Place(), folder=tmp_path, codec=Older(None), leave_out=LEFT_OUT
    )
    assert there == (None,)


def test_failures_are_results_but_unexpected_ones_are_tried_again(tmp_path, capsys):
    log = tmp_path / "log"
    bad = log.with_suffix(".bad")
    bad.touch()
    folder, place = tmp_path / "f", Place(log=str(log))
    options = {"name": lambda case: f"case {case}", "progress": Progress(quiet=False)}
    kept = run(folder, [-1, 666, 3], place, **options)
    assert [k.reason for k in kept] == [
        "-1 cannot be built.", "unexpected MemoryError: too little", "",
    ]  # fmt: skip
    assert [k.unexpected for k in kept] == [False, True, False]
    assert "case -1 failed: -1 cannot be built." in capsys.readouterr().err
    with pytest.raises(SweepStateError, match="cannot be built"):
        kept[0].value  # noqa: B018
    bad.unlink()
    again = run(folder, [-1, 666, 3], place)
    assert [bool(k.reason) for k in again] == [True, False, False]
    assert log.read_text().split() == ["666", "3", "666"]
    assert len(list(folder.iterdir())) == 3
    with pytest.raises(GeometryError):
        run(folder, [-2], raises=(GeometryError,))


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    folder = tmp_path_factory.mktemp("alone")
    run(folder)
    return content(folder)


@pytest.mark.parametrize(
    "hands", [{"workers": 2}, pytest.param({"cluster": "local:2"}, marks=pytest.mark.slow)], ids=str
)
def test_bits_are_the_same_with_any_workers(tmp_path, alone, hands):
    if "cluster" in hands:
        pytest.importorskip("distributed")
    run(tmp_path, **hands)
    assert content(tmp_path) == alone


def test_linear_algebra_uses_one_thread_in_this_process_too(tmp_path, monkeypatch):
    from threadpoolctl import threadpool_info

    found = []

    def threads(_place, case):
        found.extend(i["num_threads"] for i in threadpool_info() if i["user_api"] == "blas")
        return Point(x=case, values=np.zeros(1))

    monkeypatch.setattr(sys.modules[__name__], "compute", threads)
    monkeypatch.setattr(keeper, "case_keys", lambda *_, **__: ("0" * 64,))
    run(tmp_path, [1.0])
    assert found
    assert set(found) == {1}


def test_only_the_cores_that_this_process_may_use_count():
    script = "import os; os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})\n"
    script += f"from {cores.__module__} import cores; print(cores())"
    if not hasattr(os, "sched_setaffinity"):
        pytest.skip("no affinity")
    assert _python("-c", script).stdout == "1\n"


def _python(*arguments, **options):
    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        capture_output=True, text=True, check=True, env=_environment(), **options,
    )  # fmt: skip


def _environment():
    found = [ROOT, HERE.parent, ROOT / "tests" / "support", os.environ.get("PYTHONPATH", "")]
    return os.environ | {"PYTHONPATH": os.pathsep.join(map(str, found))}


def test_a_function_that_workers_cannot_import_is_refused_with_a_sentence(tmp_path):
    script = (
        "from pathlib import Path\n"
        "from kept_points import Point\n"
        "from octant.reader_design.keeping.keeper import RecordCodec, map_cases\n"
        "def typed_at_the_prompt(_, case): return Point(x=case, values=case)\n"
        "try: map_cases(typed_at_the_prompt, [1, 2], context=None, folder=Path('FOLDER'),\n"
        "               codec=RecordCodec(Point), workers=2)\n"
        "except Exception as exc: print(type(exc).__name__, exc)\n"
    )
    said = _python("-c", script.replace("FOLDER", str(tmp_path)))
    assert said.stdout.startswith("SweepStateError a worker cannot import")
    assert "typed_at_the_prompt" in said.stdout
    assert said.stdout.endswith("or give workers = 1.\n")


SCRIPT = """
import signal, sys
from pathlib import Path
from test_keeper import Place, run
signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGTERM, signal.SIG_DFL)
if __name__ == "__main__":
    try:
        run(Path(sys.argv[1]), range(40), Place(wait_s=0.02, size=20), workers=int(sys.argv[2]))
    except KeyboardInterrupt:
        sys.exit(130)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
@pytest.mark.parametrize("workers", [1, 2])
def test_a_run_that_is_killed_or_interrupted_ends_in_the_same_files(tmp_path, workers):
    (tmp_path / "main.py").write_text(SCRIPT)
    folder = tmp_path / "stopped"
    command = [sys.executable, str(tmp_path / "main.py"), str(folder), str(workers)]
    codes, counts = [], [0]
    for number in (signal.SIGKILL, signal.SIGINT, signal.SIGTERM):
        with subprocess.Popen(command, env=_environment(), stderr=subprocess.DEVNULL) as child:
            deadline = time.monotonic() + 60.0
            while time.monotonic() < deadline and child.poll() is None:
                if len(list(folder.glob("[!.]*"))) > counts[-1] + 2:
                    child.send_signal(number)
                    break
                time.sleep(0.005)
            codes.append(child.wait(60))
        counts.append(len(list(folder.glob("[!.]*"))))
    assert codes == [-signal.SIGKILL, 130, -signal.SIGTERM]
    assert counts == sorted(set(counts))
    half = folder / f".{'0' * 32}-half.msgpack"
    half.write_bytes(b"half a case")
    mine = folder / ".mine"
    mine.write_bytes(b"")
    for each in (folder, tmp_path / "whole"):
        _python(tmp_path / "main.py", each, 1)
    assert mine.exists()
    mine.unlink()
    assert content(folder) == content(tmp_path / "whole")


def test_temporary_files_of_a_run_that_still_goes_on_stay(tmp_path):
    part = tmp_path / f".{'a' * 32}-half.nc"
    with claimed(tmp_path):
        part.write_bytes(b"")
        with claimed(tmp_path):
            assert part.exists()
    with claimed(tmp_path):
        assert not part.exists()


@pytest.mark.slow
def test_two_runs_at_once_in_one_folder_do_no_harm(tmp_path):
    (tmp_path / "main.py").write_text(SCRIPT)
    command = [sys.executable, str(tmp_path / "main.py"), str(tmp_path / "both"), "1"]
    both = [subprocess.Popen(command, env=_environment()) for _ in range(2)]
    assert [child.wait(120) for child in both] == [0, 0]
    _python(tmp_path / "main.py", tmp_path / "alone", 1)
    assert content(tmp_path / "both") == content(tmp_path / "alone")


class BreakingCrew:
    """A pool of processes in which one case kills its worker, and with it the pool."""

    size = 2

    def __init__(self, deadly):
        self.deadly, self.renewed, self.broken, self.stopped = deadly, 0, False, False

    def submit(self, call, packed, version):
        case = pickle.loads(packed)[1]  # noqa: S301
        if self.broken:
            raise BrokenProcessPool
        future = Future()
        self.broken = case == self.deadly
        if self.broken:
            future.set_exception(BrokenProcessPool())
        elif case == 99:
            future.set_exception(RuntimeError("worker died"))
        else:
            future.set_result(call(packed, version))
        return future

    def renew(self):
        self.renewed += 1
        self.broken = False

    def stop(self):
        self.stopped = True


def test_a_killed_worker_costs_only_the_case_that_kills_it(tmp_path, capsys):
    crew = BreakingCrew(3)
    cases = [0, 1, 2, 3, 4, 99]
    kept = run(tmp_path, cases, crew=crew, progress=Progress(quiet=False))
    assert [bool(k.reason) for k in kept] == [False, False, False, True, False, True]
    assert "want of memory" in kept[3].reason
    assert kept[5].reason == "unexpected RuntimeError: worker died"
    assert crew.renewed >= 2
    assert "one at a time" in capsys.readouterr().err
    assert not any(k.reason for k in run(tmp_path, cases))


def test_a_worker_of_another_version_ends_the_run(tmp_path):
    class Other(BreakingCrew):
        def submit(self, call, packed, version):
            future = Future()
            assert version != "0.0.0"
            try:
                future.set_result(call(packed, "0.0.0"))
            except SweepStateError as exc:
                future.set_exception(exc)
            return future

    crew = Other(None)
    with pytest.raises(SweepStateError, match=r"started by 0\.0\.0; update it"):
        run(tmp_path, crew=crew)
    assert crew.stopped


def test_processes_are_started_again_after_one_died():
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
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=_environment()) as child:
        worker = int(child.stdout.readline())
        assert Path(f"/proc/{worker}").exists()
        child.send_signal(signal.SIGKILL)
    deadline = time.monotonic() + 30
    while _runs(worker) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not _runs(worker)


@pytest.mark.slow
def test_workers_that_are_stopped_while_they_hand_over_results_are_not_waited_for(tmp_path):
    script = (
        "import time\n"
        "from octant.reader_design.keeping.workers import LocalProcesses\n"
        "if __name__ == '__main__':\n"
        "    for number in range(8):\n"
        "        crew = LocalProcesses(1)\n"
        "        crew.submit(bytes, 1).result()\n"
        "        for _ in range(3):\n"
        "            crew.submit(bytes, 30_000_000)\n"
        "        time.sleep(0.01 * number)\n"
        "        crew.stop()\n"
    )
    (tmp_path / "main.py").write_text(script)
    _python(tmp_path / "main.py", timeout=120)


def _runs(pid):
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state != "Z"


def test_a_full_disk_is_one_sentence_and_loses_nothing(tmp_path, monkeypatch):
    written, real = [], Path.write_bytes

    def full(self, data):
        if len(written) == 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written.append(self)
        return real(self, data)

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(ConfigError, match="No space left on device") as caught:
        run(tmp_path)
    assert "\n" not in str(caught.value)
    monkeypatch.undo()
    there = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert len(there) == 2
    run(tmp_path)
    assert all((tmp_path / name).read_bytes() == data for name, data in there.items())


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="no such permissions")
def test_a_folder_that_cannot_be_written_to_still_gives_what_it_holds(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="cannot be written"):
        run(tmp_path / "file" / "cases", [1])
    folder = tmp_path / "kept"
    first = run(folder, [1])
    folder.chmod(0o500)
    try:
        assert bits(run(folder, [1])) == bits(first)
        if os.geteuid() != 0:  # nothing is closed to root
            with pytest.raises(ConfigError, match="give a folder that can be written to"):
                run(folder, [2])
    finally:
        folder.chmod(0o700)
