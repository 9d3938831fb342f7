"""Compiled code that is kept on disk: found again while its source is the same, never after."""

import math
import os
import subprocess
import sys

import pytest

CONSTANT = "SCALE = 10.0\n"
INNER = """
from apart.constants import SCALE
from octant.geometries.kernels import kernel

@kernel
def inner(x):
    return SCALE * x
"""
BESIDE = """
import numpy as np
from typing import NamedTuple
from octant.geometries.kernels import kernel

class Arrays(NamedTuple):
    first: np.ndarray
    second: np.ndarray

@kernel(returns="UniTuple(float64, 2)")
def apart(arrays, i):
    if i > 2:
        raise ValueError("beyond the end")
    return arrays.first[i], arrays.second[i]

@kernel(returns="none")
def seldom(out):
    out[0] += 100.0

@kernel
def between(arrays, i):
    a, b = apart(arrays, i)
    return a - b

@kernel(nogil=True)
def above(arrays, out, i):
    out[0] = between(arrays, i) + apart(arrays, 0)[0]
    if i == 2:
        seldom(out)
"""
BESIDE_PROGRAM = """
import threading
import numpy as np
from apart._beside_kernels import Arrays, above, apart, seldom
from octant.reader_design.compilation import recorded_compilation
fixed, out = np.arange(3.0), np.zeros(1)
fixed.flags.writeable = False
with recorded_compilation() as record:
    above(Arrays(fixed + 1.0, fixed), out, 1)
    print(out[0], *sorted(set(record.kernels)))
    above(Arrays(fixed, fixed + 1.0), out, 2)  # types that look the same in memory: nothing new
    print(out[0], *record.kernels[-1:])
    outs = np.zeros((4, 1))
    for thread in [threading.Thread(target=above, args=(Arrays(fixed, fixed), o, 2)) for o in outs]:
        thread.start()
        thread.join()
    print(*outs[:, 0])
try:
    above(Arrays(fixed, fixed), out, 3)
except ValueError as exc:
    print(exc)
"""
OUTER = """
from apart._inner_kernels import inner
from octant.geometries.kernels import kernel

@kernel
def outer(x):
    return inner(x) + 1

@kernel
def divided(x):
    return 1.0 / x
"""
PROGRAM = """
from apart._outer_kernels import divided, outer
print(outer(2.5), outer(3), divided(0.0), sum(outer.stats.cache_hits.values()))
"""


@pytest.fixture
def package(tmp_path):
    folder = tmp_path / "apart"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "constants.py").write_text(CONSTANT)
    (folder / "_inner_kernels.py").write_text(INNER)
    (folder / "_outer_kernels.py").write_text(OUTER)
    (folder / "_beside_kernels.py").write_text(BESIDE)
    return folder


def lines(package, program):
    path = os.pathsep.join([str(package.parent), *sys.path])
    done = subprocess.run(
        [sys.executable, "-B", "-c", program],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def outer(package):
    """Return what a new process gets: its results, and how many it found compiled."""
    *results, division, found = map(float, lines(package, PROGRAM)[0].split())
    assert division == math.inf
    return results, found


@pytest.mark.parametrize(
    ("file", "old", "new", "results"),
    [
        ("_inner_kernels.py", "SCALE * x", "SCALE - x", [8.5, 8.0]),
        ("constants.py", "10.0", "20.0", [51.0, 61.0]),
    ],
)
def test_a_change_in_another_file_is_compiled(package, file, old, new, results):
    assert outer(package) == ([26.0, 31.0], 0)
    assert outer(package) == ([26.0, 31.0], 2)
    source = package / file
    source.write_text(source.read_text().replace(old, new))
    assert outer(package) == (results, 0)


def test_code_that_is_damaged_or_of_another_signature_is_compiled_anew(package):
    assert outer(package) == ([26.0, 31.0], 0)
    first, second = sorted((package / "__pycache__").glob("_outer_kernels.outer*.nbc"))
    code = first.read_bytes()
    altered = code[:-9] + bytes([code[-9] ^ 1]) + code[-8:]
    for damaged in (code[:-1], altered, second.read_bytes()):
        first.write_bytes(damaged)
        assert outer(package) == ([26.0, 31.0], 1)


def test_what_is_called_through_a_pointer_is_compiled_when_it_is_first_called(package):
    first, second, threads, error = lines(package, BESIDE_PROGRAM)
    assert first == "2.0 above apart between"
    assert second == "99.0 seldom"
    assert threads == "100.0 100.0 100.0 100.0"
    assert error == "beyond the end"
    first, second, threads, error = lines(package, BESIDE_PROGRAM)
    assert (first, error) == ("2.0", "beyond the end")
