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
    return folder


def outer(package):
    """Return what a new process gets: its results, and how many it found compiled."""
    path = os.pathsep.join([str(package.parent), *sys.path])
    done = subprocess.run(
        [sys.executable, "-B", "-c", PROGRAM],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    *results, division, found = map(float, done.stdout.split())
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
