"""Compiled code that is kept on disk: found again while its source is the same, never after."""

import math
import os
import subprocess
import sys

import numba
import numpy as np
import pytest

from octant.geometries._array_kernels import first_not_below
from octant.geometries.kernels import Kernel

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
HELPERS = """
import numpy as np
from octant.geometries.kernels import kernel

@kernel
def larger(a, b):
    return max(a, b) + np.empty(2).size

@kernel(forceinline=True)
def inlined(a, b):
    return larger(a, b) + max(a, b) + np.empty(2).size

@kernel(returns="float64")
def apart(a, b):
    return max(a, b) + np.empty(3).size

@kernel(nogil=True)
def above(a, b):
    return inlined(a, b) + apart(a, b) + max(a, b) + np.empty(4).size
"""
HELPERS_PROGRAM = """
import collections, gc
from numba.core import event
from apart._helpers_kernels import above

class Compiled(event.Listener):
    def __init__(self):
        self.seen = collections.Counter()
    def on_start(self, begun):
        assert not gc.isenabled()
        function = begun.data["dispatcher"].py_func
        self.seen[function.__module__, function.__qualname__, str(begun.data["args"])] += 1
    def on_end(self, ended):
        pass

with event.install_listener("numba:compile", Compiled()) as compiled:
    print(above(2.0, 5.0))
assert gc.isenabled()
own = {name for module, name, _ in compiled.seen if module == "apart._helpers_kernels"}
print(*sorted(own))
print(sum("arrayobj" in module for module, _, _ in compiled.seen) > 0, max(compiled.seen.values()))
"""
COUNTED = """
import numpy as np
from typing import NamedTuple
from octant.geometries.kernels import kernel

class Arrays(NamedTuple):
    first: np.ndarray
    second: np.ndarray

@kernel
def same(array):
    return array

@kernel
def part(arrays):
    kept = arrays.first
    return kept

@kernel
def larger(array, room):
    if room > len(array):
        more = np.zeros(room)
        more[: len(array)] = array
        return more
    return array

@kernel
def grows(array, arrays, times):
    other = same(array)
    for i in range(times):
        lent = arrays
        row = lent.second[i:]
        if i % 2 == 1:
            array = larger(array, len(array) + 1)
        elif row[0] < 0.0:
            array = lent.first
    other, array = array, other
    return array, other, part(arrays)
"""
COUNTED_PROGRAM = """
import sys
import numpy as np
from apart._counted_kernels import Arrays, grows, larger, part, same
one, two, three = np.arange(3.0), np.arange(4.0), np.array([1.0, -1.0, -1.0, 1.0])
before = [sys.getrefcount(each) for each in (one, two, three)]
for _ in range(50):
    kept = [same(one), part(Arrays(two, three)), larger(one, 2), larger(one, 5)]
    for times in range(4):
        kept += grows(one, Arrays(two, three), times)
expected = [[0, 1, 2], [0, 1, 2, 3], [0, 1, 2], [0, 1, 2, 0, 0]]
for last in ([0, 1, 2], [0, 1, 2], [0, 1, 2, 0], [0, 1, 2, 3]):
    expected += [[0, 1, 2], last, [0, 1, 2, 3]]
print([each.tolist() for each in kept] == expected)
del kept
print([sys.getrefcount(each) for each in (one, two, three)] == before)
gone = larger(same(np.arange(100.0)), 1)
other = np.full(100, 7.0)
print(gone.sum() == 4950.0)
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
    (folder / "_helpers_kernels.py").write_text(HELPERS)
    (folder / "_counted_kernels.py").write_text(COUNTED)
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


def test_numpys_functions_are_translated_once_whatever_kernels_call_them(package):
    total, own, most = lines(package, HELPERS_PROGRAM)
    assert total == "31.0"
    assert own == "above apart inlined larger"
    assert most == "True 1"


def test_arrays_that_a_kernel_is_given_live_as_long_as_what_it_returns_and_no_longer(package):
    assert lines(package, COUNTED_PROGRAM) == ["True"] * 3


def test_types_that_two_threads_bring_at_once_are_found_without_a_search(monkeypatch):
    fixed = np.arange(3.0)
    fixed.flags.writeable = False
    for _ in range(2):  # what both do when the first call finds nothing
        first_not_below.compile((numba.typeof(fixed), numba.float64))
    searched = []
    monkeypatch.setattr(Kernel, "compile", lambda _self, sig: searched.append(sig))
    assert first_not_below(fixed, 0.5) == 1
    assert searched == []
