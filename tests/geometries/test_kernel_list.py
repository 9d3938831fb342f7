"""Kernels that are compiled ahead by another process, from a list, and by one process at a time."""

import importlib
import inspect
import json
import os
import shutil
import subprocess
import sys
from multiprocessing import active_children
from pathlib import Path

from octant.geometries.kernel_list import kernel_named
from octant.reader_design.compilation import LIST, compiled_ahead

KERNELS = """
import numpy as np
from typing import NamedTuple
from octant.geometries.kernels import kernel

class Arrays(NamedTuple):
    first: np.ndarray
    flags: np.ndarray

@kernel(returns="UniTuple(float64, 2)")
def apart(arrays, pair):
    return arrays.first[0], pair[1][0]

@kernel
def above(arrays, scale):
    a, b = apart(arrays, (arrays.flags, arrays.first))
    return scale * (a - b)
"""
USE = """
import numpy as np
from ahead._listed_kernels import Arrays, above

def use():
    fixed = np.ones(3)
    fixed.flags.writeable = False
    return above(Arrays(fixed, np.zeros(2, dtype=bool)), 2.0) + above(Arrays(fixed, fixed), 3)
"""
RECORD = f"""{USE}
import json
from octant.geometries.kernel_list import Recorded
with Recorded() as record:
    use()
print(json.dumps(record.listed))
"""
COMPILE = """
import json, sys
from octant.geometries.kernel_list import compile_listed
listed = json.loads(sys.argv[1])
print(compile_listed(listed, [*reversed(listed["kernels"]), "ahead._listed_kernels:gone"]))
"""
RUN = f"""{USE}
from octant.reader_design.compilation import recorded_compilation
with recorded_compilation() as record:
    use()
print(*record.kernels)
"""


def process(folder, program, *arguments):
    return subprocess.Popen(
        [sys.executable, "-B", "-c", program, *arguments],
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(folder), *sys.path])},
        stdout=subprocess.PIPE,
        text=True,
    )


def said(started):
    out, _ = started.communicate()
    assert started.returncode == 0
    return out.splitlines()[-1]


def package(folder):
    (folder / "ahead").mkdir()
    (folder / "ahead" / "__init__.py").write_text("")
    (folder / "ahead" / "_listed_kernels.py").write_text(KERNELS)
    return folder


def test_what_is_compiled_from_a_list_is_all_that_its_work_needs(tmp_path):
    folder = package(tmp_path)
    text = said(process(folder, RECORD))
    names = [name.partition(":")[2] for name in json.loads(text)["kernels"]]
    assert names == ["above", "apart", "above#2", "apart#2"]
    shutil.rmtree(folder / "ahead" / "__pycache__")
    assert said(process(folder, COMPILE, text)) == "4"
    assert said(process(folder, RUN)) == ""


def test_two_processes_compile_no_kernel_twice(tmp_path):
    folder = package(tmp_path)
    both = [process(folder, RUN) for _ in range(2)]
    compiled = " ".join(said(one) for one in both).split()
    assert sorted(compiled) == ["above", "above", "apart", "apart"]  # two kinds of each


def test_the_list_describes_kernels_that_are_there():
    listed = json.loads(LIST.read_text())
    for name, takes in listed["kernels"].items():
        assert len(inspect.signature(kernel_named(name).py_func).parameters) == len(takes), name
    for name, takes in listed["records"].items():
        module, _, record = name.partition("#")[0].partition(":")
        assert len(getattr(importlib.import_module(module), record)._fields) == len(takes), name
    assert {name for verb in listed["verbs"].values() for name in verb} == set(listed["kernels"])


PATHS = """
import json
from octant.geometries.kernel_list import Recorded
from octant.reader_design.cli import run
with Recorded() as record:
    assert run("paths box.toml --tx 2,0.5,1.5 --rx 1,1,0.3 --csv paths.csv -q".split()) == 0
print(json.dumps(record.listed))
"""


def test_the_list_has_what_paths_needs(tmp_path, monkeypatch):
    (tmp_path / "box.toml").write_text("[room]\nbox_m = [3.0, 2.0, 2.0]\n")
    monkeypatch.chdir(tmp_path)
    needed = json.loads(said(process(Path(), PATHS)))
    listed = json.loads(LIST.read_text())
    assert list(needed["kernels"]) == listed["verbs"]["paths"]
    assert needed["kernels"].items() <= listed["kernels"].items()
    assert needed["records"].items() <= listed["records"].items()


def test_the_second_process_ends_with_the_block_and_is_not_begun_in_vain():
    with compiled_ahead("paths", lambda: True) as start:
        start()
        assert len(active_children()) == 1
    assert active_children() == []
    for verb, cores in (("paths", False), ("audit", True)):
        with compiled_ahead(verb, lambda cores=cores: cores) as start:
            start()
            assert active_children() == []
