"""After ``octant warm-up`` no command compiles anything, and what is compiled is told once."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from octant.reader_design.compilation import recorded_compilation

STUDY = """
name = "other than the warm-up's"
[room]
outline_m = [[0, 0], [6, 0], [6, 3], [3, 3], [3, 5], [0, 5]]
height_m = 2.8
material = "brick"
[[tag]]
id = "a"
position_m = [2.0, 0.5, 2.7]
antenna = "dipole"
[[tag]]
id = "b"
position_m = [1.0, 2.5, 2.7]
antenna = "isotropic_theta"
[reader]
antenna = "monopole"
antennas = 6
response = "{model}"
cells_per_wavelength = 5.0
[solver]
max_reflections = 2
{solver}
[map]
spacing_m = 0.5
[mission]
navigator = "thesis"
start_m = [1.0, 1.0]
tags = ["a", "b"]
controller = "fuzzy"
"""
SOLVERS = {
    "edges": "diffraction = true\nmax_diffractions = 2\ntransmission = true",
    "launched": 'search = "rays"\nrays = 2000\ndiffraction = true',
}
OBJECT = """
[[room.object]]
kind = "box"
size_m = [0.6, 0.4, 0.9]
position_m = [1.2, 1.6, 0.0]
material = { name = "glass", thickness_m = 0.01 }
"""
CALLS = (
    "paths edges.toml --tx 2,0.5,2.7 --rx 1,1,0.3 --rx 1,2.2,0.3 --csv edges.csv -q",
    "explain edges.toml --tx 2,0.5,2.7 --rx 1,2.2,0.3 --path 9 -q",
    "map edges.toml --out edges.nc --antenna 2 -q",
    "paths launched.toml --tx 2,0.5,2.7 --rx 1,1,0.3 --csv launched.csv -q",
    "paths rays.toml --tx 2,0.5,2.7 --rx 1,1,0.3 --rx 1,2,0.3 --csv paths.csv -q",
    "map rays.toml --out one.nc --antenna 2 --local-mean -q",
    "map isolated.toml --out isotropic.nc --isotropic --tag b -q",
    "map fullwave.toml --out all.nc -q",
    "rss rays.toml --tag b --poses poses.csv --csv rss.csv -q",
    "navigate isolated.toml --out navigate --runs 2 -q",
    "navigate tracker.toml --out tracker --runs 2 -q",
    "reader fullwave.toml --out reader --step-deg 45 -q",
)


PROGRAM = """
import sys
from numba.core.dispatcher import Dispatcher
from octant.reader_design.cli import run

def called():
    return {
        (kernel.py_func.__module__, kernel.py_func.__name__, str(signature))
        for name, module in list(sys.modules.items()) if name.startswith("octant.")
        for kernel in vars(module).values() if isinstance(kernel, Dispatcher)
        for signature in kernel.signatures
    }

assert run(["warm-up"]) == 0
warm = called()
assert len(warm) > 25, warm
for call in sys.argv[1:]:
    assert run(call.split()) == 0, call
    assert called() <= warm, (call, called() - warm)
assert run(["warm-up", "-q"]) == 0
"""
"""What is compiled, or found on disk, while warm-up runs, is all that the other calls need. That it
is found on disk where it is, is numba's own; so this needs no second compilation of everything."""


@pytest.mark.slow
def test_after_warm_up_no_command_compiles(tmp_path):
    for model in ("rays", "isolated", "fullwave"):
        (tmp_path / f"{model}.toml").write_text(STUDY.format(model=model, solver=""))
    for name, solver in SOLVERS.items():
        text = STUDY.format(model="isolated", solver=solver) + OBJECT
        (tmp_path / f"{name}.toml").write_text(text)
    text = STUDY.format(model="isolated", solver="").replace('"thesis"', '"tracker"')
    text += "max_time_s = 5.0\n"
    (tmp_path / "tracker.toml").write_text(text)
    (tmp_path / "poses.csv").write_text("x_m,y_m,heading_deg\n1.0,1.0,0.0\n2.0,1.5,90.0\n")
    environment = os.environ | {
        "OCTANT_CACHE_DIR": str(tmp_path / "responses"),
        "MPLBACKEND": "agg",
    }
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *CALLS],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith("nothing to compile: every kernel is ready.\n")
    assert "warm-up: 100%" in done.stderr


def test_compilation_is_announced_once_and_recorded(tmp_path, monkeypatch):
    source = tmp_path / "_double_kernels.py"
    source.write_text(
        "from numba import njit\n\n\n@njit(cache=True)\ndef inner(x):\n    return x + x\n\n\n"
        "@njit(cache=True)\ndef outer(x):\n    return inner(x) + 1\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    said = []
    with recorded_compilation(lambda: said.append("first")) as record:
        import _double_kernels

        assert said == []
        assert _double_kernels.outer(1) == 3
        assert _double_kernels.outer(2) == 5
    assert said == ["first"]
    assert sorted(record.kernels) == ["inner", "outer"]
    assert record.folders == {tmp_path / "__pycache__"}
    assert record.seconds > 0.0
    with recorded_compilation(lambda: said.append("again")) as record:
        _double_kernels.outer(3)
        _double_kernels.inner(3)
    assert said == ["first"]
    assert record.kernels == []


@pytest.mark.slow
def test_nowhere_to_keep_kernels_is_one_sentence(tmp_path):
    package = tmp_path / "octant"
    package.mkdir()
    import octant.geometries

    shutil.copy(octant.__file__, package)
    root = Path(octant.geometries.__file__).resolve().parents[1]
    for layer in ("geometries", "em", "navigation", "reader_design"):
        shutil.copytree(root / layer, package / layer, ignore=shutil.ignore_patterns("__pycache__"))
        for folder in [package / layer, *(p for p in (package / layer).rglob("*") if p.is_dir())]:
            (folder / "__pycache__").write_text("")  # a file, so that no folder can be made
    home = tmp_path / "home"
    home.write_text("")
    (tmp_path / "study.toml").write_text(STUDY.format(model="isolated", solver=""))
    script = "from octant.reader_design.cli import main; main()"
    arguments = ["paths", "study.toml", "--tx", "1,1,1", "--rx", "2,1,1"]
    done = subprocess.run(
        [sys.executable, "-B", "-c", script, *arguments],
        cwd=tmp_path,
        env={"PYTHONPATH": str(tmp_path), "HOME": str(home), "XDG_CACHE_HOME": str(home)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith("error: compiled kernels can be kept neither")
    assert "NUMBA_CACHE_DIR" in done.stderr
    assert done.stderr.count("\n") == 1
