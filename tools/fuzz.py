"""Search for input that Octant does not survive: seeded, in this process, confirmed by the command.

``python tools/fuzz.py KIND [--count N] [--seed S] [--first K] [--keep FOLDER]`` makes trials K to
K + N - 1 of a kind and prints what they found, equal findings once. A trial depends on its seed and
its number only, so ``--first K --count 1`` repeats it. A finding is a traceback, an exit code other
than 0, 2, 3 and 130, a refusal that is not one short sentence, a warning of numpy, NaN in a file, a
changed result, more than 60 s of processor time, or more memory than the limit. Exit code: 1 if
there are findings.

A kind is a line of ``GENERATORS``: a function from a random generator to a `Trial`. A new kind
needs no more than that; `tests/cli/test_fuzz.py` runs each kind for a moment.
"""

import argparse
import contextlib
import copy
import csv
import functools
import io
import json
import math
import os
import random
import re
import resource
import runpy
import signal
import struct
import subprocess
import sys
import tempfile
import time
import tomllib
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest import mock

import click
import msgspec
import numpy as np
import trimesh

from octant.em.antennas.from_files import reader_from_pattern_files
from octant.em.antennas.pattern_files.touchstone import read_touchstone
from octant.geometries.errors import OctantError, PhysicsWarning
from octant.geometries.furniture import cylinder
from octant.geometries.mesh_files import save_bodies
from octant.geometries.rooms import box_room
from octant.reader_design import options
from octant.reader_design.cli import VERBS, octant, run
from octant.reader_design.study_file.loading import load_study, parse_study
from octant.reader_design.study_file.tables_read import belongs

ROOT = Path(__file__).resolve().parents[1]
GOOD_CODES = (0, 2, 3, 130)
LONGEST_S, STRETCHED = 60.0, 10.0
"""Processor time [s] that a trial may take, and how much more the clock may say."""
ANNOUNCED_S = 10.0
"""What a command announces to take longer [s] is refused here, as beyond 12 h elsewhere."""
LONGEST_MESSAGE = 1500
MOST_MEMORY_BYTES = 8 << 30
CONFIRM = "from octant.reader_design.cli import main; main()"


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One input.

    Parameters
    ----------
    files : Content of each file of an empty folder.
    arguments : What is typed behind ``octant`` in that folder.
    load_only : Only load the first file, a study or an antenna's, which takes milliseconds.
    expected : Content that files must have after exit code 0.
    """

    files: Mapping[str, bytes]
    arguments: tuple[str, ...]
    load_only: bool = False
    expected: Mapping[str, bytes] = field(default_factory=dict)


# What is mutated ----------------------------------------------------------------------------------

STUDY = """
name = "everything"
[radio]
channels_hz = [2.4e9, 2.44e9]
[room]
box_m = [3.0, 2.5, 2.0]
material = {walls = "concrete", floor = "wood", ceiling = {eps_r = 3.0, sigma_s_per_m = 0.01}}
[[room.doorway]]
wall = 1
offset_m = 0.5
width_m = 0.8
height_m = 1.5
[[room.object]]
kind = "cabinet"
size_m = [0.4, 0.3, 0.8]
position_m = [2.3, 1.9, 0.0]
[[room.object]]
kind = "cylinder"
radius_m = 0.1
height_m = 0.5
position_m = [0.4, 2.0, 0.0]
material = {layers = [{material = "plasterboard", thickness_m = 0.0125}, {eps_r = 2.0}]}
[[tag]]
id = "a"
position_m = [1.5, 1.2, 2.0]
antenna = "dipole"
[[tag]]
id = "b"
position_m = [0.8, 0.6, 1.9]
antenna = "patch"
kind = "passive"
sensitivity_dbm = -40.0
[rfid]
power_w = 1.0
transmitter = "separate"
transmitter_axis = [0.0, 0.0, 1.0]
transmitter_position_m = [2.5, 0.3, 1.5]
other_tags = 2
[reader]
antennas = 4
response = "isolated"
cells_per_wavelength = 5.0
[sweep]
antenna = ["dipole", "monopole"]
gap_m = {from = 0.005, to = 0.01, count = 2}
[solver]
max_reflections = 1
rays = 1000
[map]
spacing_m = 0.5
[mission]
navigator = "thesis"
start_m = [1.0, 1.0]
tags = ["a"]
runs = 2
max_time_s = 20.0
starts = [[1.0, 1.0, 0.0], [1.2, 0.9, 90.0]]
[robot]
kinematics = "car"
wheelbase_m = 0.2
steering_limit_deg = 40.0
wheel_acceleration_rad_per_s2 = 20.0
encoder_counts = 2000
wheel_slip = 0.01
odometry = "rk2"
[sensor]
bandwidth_hz = 2e6
required_snr_db = 3.0
sensitivity_dbm = -95.0
bits = 8
[track]
chapters = ["rss"]
runs = 2
slam_runs = 1
training_iterations = 10
[[track.trajectory]]
name = "own"
shape = "spline"
waypoints_m = [[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]]
duration_s = 20.0
[dock]
tag = "a"
landmark_position_m = [2.9, 1.2, 0.5]
landmark_heading_deg = 0.0
runs = 2
start_low_m = [0.5, 0.5]
start_high_m = [1.0, 1.0]
start_error_deg = 20.0
[dock.regulation]
starts = [[-1.0, 0.5, 90.0]]
[optimise]
parameters = {antenna_length_m = [0.04, 0.07]}
choices = {antenna = ["dipole", "monopole"]}
survey = 2
evaluations = 2
[tolerance]
samples = 2
[[tolerance.rival]]
name = "smaller"
antenna_radius_m = 0.05
[[layout]]
name = "empty"
[[layout.object]]
kind = "box"
size_m = [0.2, 0.2, 0.2]
position_m = [2.0, 0.3, 0.0]
material = "wood"
"""
"""A study with every table, each as cheap as it can be."""

CSV_FILES = {
    "poses.csv": "x_m,y_m,heading_deg\n1.0,1.0,90\n1.2,0.9,0\n0.7,1.5,-45.5\n",
    "rx.csv": "x_m,y_m,z_m\n1.0,1.0,0.3\n0.5,0.6,0.7\n2.5,0.4,1.5\n",
}

CALLS = {
    "paths study.toml --tx 1.5,1.2,1.9 --rx 1,1,0.3 --csv paths.csv": 8,
    "explain study.toml --tx 1.5,1.2,1.9 --rx 1,1,0.3 --csv budget.csv": 4,
    "rss study.toml --tag a --poses poses.csv --csv rss.csv --readings 2 --noise-db 1": 8,
    "map study.toml --out map.nc --spreads --local-mean": 6,
    "map study.toml --out map.nc --threshold-dbm -60 --export csv --export mat --export png "
    "--export geotiff --export map-server": 2,
    "scene study.toml --glb room.glb": 2,
    "reader study.toml --out reader --step-deg 45": 1,
    "simulate-log study.toml --out drive.csv --noise-db 1": 4,
    "compare study.toml --log log.csv --out compare --least 1": 3,
    "calibrate study.toml --log log.csv --fit level --out calibrate --least 1 --folds 2": 3,
    "replay study.toml --log log.csv --out replay --workers 1": 4,
    "navigate study.toml --out navigate --workers 1": 2,
    "navigate study.toml --out navigate --workers 1 --export mcap --export tum --export csv": 1,
    "dock study.toml --out dock --workers 1 --export mcap": 0.1,
    "track study.toml --out track --workers 1 --export mcap": 1,
    "sweep study.toml --out sweep --workers 1": 2,
    "tolerance study.toml --out tolerance --workers 1": 0.1,
    "optimise study.toml --out optimise --workers 1": 0.2,
    "study study.toml --quick --out study --workers 1": 0.05,
}
"""A call of every verb that a mutated study is given to, and how often: what takes long seldom."""

NUMBERS = (
    0, 1, -1, 2, 3, 1000, 2**31, 2**63 - 1, -(2**63), 10**18, 10**30,
    0.0, -0.0, 0.5, -0.5, 1e-300, 1e-20, 1e-9, 1e-4, 1e4, 1e9, 9e18, 1e30, 1e200, 1e300, -1e300,
    5e-324, math.inf, -math.inf, math.nan,
)  # fmt: skip
TEXTS = (
    "", " ", "a", "b", "dipole", "metal", "concrete", "../x", "/", "a/b", "nul\0byte", "ü" * 40,
    "x" * 5000, "none.stl", "none.ffe", "line\nbreak", "\x1b[31m", "{}", "%s", "-1", "nan",
)  # fmt: skip
OTHERS = (True, False, [], {}, [[]], [0.0, 0.0, 0.0], [1e300] * 3, {"name": "wood"}, [1, 2], [{}])


def wild_number(rng: random.Random, old: Any) -> Any:
    """Return a number that is not what a person would write, or one near the old value."""
    if isinstance(old, int | float) and not isinstance(old, bool) and rng.random() < 0.6:
        kinds = (
            lambda: old * 10.0 ** rng.uniform(-12.0, 12.0),
            lambda: old * 2.0 ** rng.randint(-3, 3),
            lambda: -old,
            lambda: old + rng.choice((-1, 1)),
            lambda: int(old * rng.choice((0, 1, 10, 10**6))) if abs(old) < 1e15 else 0,
        )
        return rng.choice(kinds)()
    return rng.choice(NUMBERS)


def wild_value(rng: random.Random, old: Any) -> Any:
    """Return any value, most often of the old one's type."""
    if isinstance(old, str) and rng.random() < 0.7:
        return rng.choice((*TEXTS, old + "x", old[:-1], old.upper()))
    if rng.random() < 0.75:
        return wild_number(rng, old)
    return copy.deepcopy(rng.choice((*TEXTS, *OTHERS)))


def places_of(node: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every value below a node of plain tables and lists."""
    items = node.items() if isinstance(node, dict) else enumerate(node)
    for key, value in items:
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from places_of(value, (*path, key))


def mutated_tables(rng: random.Random, tables: dict[str, Any]) -> dict[str, Any]:
    """Return tables with one to four values changed, taken away, doubled, exchanged or added."""
    tables = copy.deepcopy(tables)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 4))):
        places = list(places_of(tables))
        if not places:
            break
        *above, key = rng.choice(places)
        parent = functools.reduce(lambda node, step: node[step], above, tables)
        what = rng.random()
        if what < 0.75:
            parent[key] = wild_value(rng, parent[key])
        elif what < 0.85:
            del parent[key]
        elif what < 0.90 and isinstance(parent, list):
            parent.insert(key, copy.deepcopy(parent[key]))
        elif what < 0.95:
            *others, last = rng.choice(places)
            other = functools.reduce(lambda node, step: node[step], others, tables)
            parent[key] = copy.deepcopy(other[last])
        elif isinstance(parent, dict):
            parent[f"{key}{rng.choice(('', 's', '_m'))}"] = wild_value(rng, None)
    return tables


def mutated_bytes(rng: random.Random, content: bytes) -> bytes:
    """Return content cut, emptied, filled, flipped or doubled somewhere."""
    changed = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 4))):
        start = rng.randrange(len(changed) + 1)
        end = min(len(changed), start + rng.choice((1, 2, 8, 64, 1024)))
        what = rng.randrange(6)
        if what == 0:
            del changed[start:]
        elif what == 1:
            del changed[start:end]
        elif what == 2:
            changed[start:end] = bytes(rng.randrange(256) for _ in range(end - start))
        elif what == 3 and start < len(changed):
            changed[start] ^= 1 << rng.randrange(8)
        elif what == 4:
            changed[start:start] = changed[start:end]
        else:
            changed[start:end] = rng.choice((b"", b"\0", b"nan", b"1e999", b"-", b"\xff\xfe"))
    return bytes(changed)


@functools.cache
def bases() -> tuple[dict[str, Any], ...]:
    """Return the studies that are mutated as tables with all their keys."""
    paths = [*(ROOT / "reader_design/study_file").glob("*.toml")]
    texts = [(STUDY, ROOT)] * len(paths)
    texts += [(path.read_text("utf-8"), path.parent) for path in sorted(paths)]
    return tuple(
        msgspec.to_builtins(parse_study(text, source="study.toml", directory=at), str_keys=True)
        for text, at in texts
    )


def plain(value: Any) -> Any:
    """Return tables with lists in place of tuples, so that all of it can be changed."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    return [plain(item) for item in value] if isinstance(value, list | tuple) else value


def toml_bytes(tables: dict[str, Any]) -> bytes:
    """Return tables as a TOML file, each on a line of its own; what is None is left out."""
    lines = (f"{_toml(key)} = {_toml(value)}\n" for key, value in _given(tables))
    return "".join(lines).encode("utf-8", "surrogatepass")


def _given(table: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    return ((key, value) for key, value in table.items() if value is not None)


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_toml(k)} = {_toml(v)}" for k, v in _given(value)) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_toml(item) for item in value if item is not None) + "]"
    return json.dumps(value).replace("\x7f", "\\u007f") if isinstance(value, str) else repr(value)


# The kinds ----------------------------------------------------------------------------------------


def study_loads(rng: random.Random) -> Trial:
    """Return a study file, mutated as tables or as text, that is loaded."""
    if rng.random() < 0.1:
        content = mutated_bytes(rng, STUDY.encode())
    else:
        content = toml_bytes(mutated_tables(rng, plain(rng.choice(bases()))))
    return Trial(
        files={"study.toml": content},
        arguments=tuple(next(iter(CALLS)).split()),
        load_only=True,
    )


def study_verbs(rng: random.Random) -> Trial:
    """Return a small mutated study and a verb that computes it."""
    call = rng.choices(tuple(CALLS), tuple(CALLS.values()))[0].split()
    tables = tomllib.loads(STUDY) if rng.random() < 0.5 else plain(bases()[0])
    content = toml_bytes(mutated_tables(rng, part_for(call[0], tables)))
    return Trial(files={"study.toml": content} | files_beside(), arguments=tuple(call))


def part_for(verb: str, tables: dict[str, Any]) -> dict[str, Any]:
    """Return the tables of a study without those that a verb refuses, which are of others alone."""
    part = {key: value for key, value in tables.items() if belongs(key, verb)}
    if "rfid" not in part:  # what a passive tag needs
        part["tag"] = [
            {key: value for key, value in tag.items() if key not in ("kind", "sensitivity_dbm")}
            for tag in part["tag"]
        ]
    if verb == "tolerance":  # build errors are those of a full-wave reader
        part["reader"] = part["reader"] | {"response": "fullwave"}
    return part


def files_beside() -> dict[str, bytes]:
    """Return the files besides the study that a call names."""
    return {name: text.encode() for name, text in CSV_FILES.items()} | {"log.csv": measured_log()}


@functools.cache
def measured_log() -> bytes:
    """Return the log of a drive through the study's room."""
    call = next(call for call in CALLS if call.startswith("simulate-log"))
    study = toml_bytes(part_for("simulate-log", tomllib.loads(STUDY)))
    with _folder_of({"study.toml": study}) as folder, contextlib.redirect_stdout(io.StringIO()):
        code = run([*call.split(), "--quiet"])
        assert code == 0, f"octant {call} ended with {code}"  # noqa: S101
        return (folder / "drive.csv").read_bytes()


WHOLE = 0.1
"""Share of option lines of an experiment that compute it; the others end with ``--dry-run``."""
SELDOM = {"demo": 0.02, "study": 0.1, "dock": 0.1, "tolerance": 0.1}
"""The same share of verbs that take longest, as part of the others'."""


def option_lines(rng: random.Random) -> Trial:
    """Return a sound study, and a verb with options of any value, half of them sound."""
    if rng.random() < 0.3:
        words = rng.choice(tuple(CALLS)).split()
        at = rng.randrange(1, len(words))
        words[at] = _wild_word(rng, words[at])
    else:
        verbs = [verb for verb in VERBS if verb != "warm-up"]
        name = rng.choices(verbs, [SELDOM["demo"] if v == "demo" else 1.0 for v in verbs])[0]
        words = rng.choice([c.split() for c in CALLS if c.startswith(f"{name} ")] or [[name]])
        command = octant.get_command(click.Context(octant), name)
        for _ in range(rng.choice((1, 1, 2, 3))):
            option = rng.choice(command.params)
            if isinstance(option, click.Option) and option.opts[0] != "--cluster":
                words.append(rng.choice(option.opts))
            if not getattr(option, "is_flag", False):
                sound = rng.random() < 0.5
                words.append(_sound_word(rng, option) if sound else _wild_word(rng, "1"))
    of_verb = octant.get_command(click.Context(octant), words[0])
    can_be_dry = of_verb is not None and any("--dry-run" in p.opts for p in of_verb.params)
    if can_be_dry and rng.random() > WHOLE * SELDOM.get(words[0], 1.0):
        words.append("--dry-run")
    else:  # what takes longer than ``ANNOUNCED_S`` is then refused
        words = [word for word in words if word != "--yes"]
    return Trial(
        files={"study.toml": toml_bytes(part_for(words[0], tomllib.loads(STUDY)))} | files_beside(),
        arguments=tuple(words),
    )


def _sound_word(rng: random.Random, option: click.Parameter) -> str:
    """Return a value that an option takes by itself."""
    kind = option.type
    if isinstance(kind, click.Choice):
        return str(rng.choice(tuple(kind.choices)))
    if isinstance(kind, click.IntRange | click.FloatRange):
        low = 0.0 if kind.min is None else float(kind.min)
        high = low + 1e3 if kind.max is None else float(kind.max)
        value = rng.choice((low, high, rng.uniform(low, min(high, low + 10.0))))
        return str(int(value)) if isinstance(kind, click.IntRange) else f"{value:g}"
    if isinstance(kind, click.Path):
        return rng.choice((*CSV_FILES, "log.csv", "study.toml", "made", "made.nc", "made.csv"))
    return rng.choice(SOUND_WORDS)


SOUND_WORDS = (
    "a", "b", "a,b", "dipole", "patch", "1,1,0.3", "1.5,1.2,1.9", "floor", "tags", "poses.csv",
    "spin", "study", "level", "level,place", "diffuse", "tilt:a", "antenna_level", "height",
    "eps_r:walls", "sigma:walls=0.02:0.01", "anchors", "2", "0,90,180,270", "made.csv", "m", "mm",
    "2.4e9:2.5e9:3", "2.4:2.5:3", "study.toml", "log.csv",
)  # fmt: skip
"""Words that options of text take, each at least one."""


def _wild_word(rng: random.Random, old: str) -> str:
    kinds = (
        lambda: str(rng.choice(NUMBERS)),
        lambda: ",".join(str(rng.choice(NUMBERS)) for _ in range(rng.choice((1, 2, 3, 3, 3, 4)))),
        lambda: rng.choice(TEXTS).replace("\0", ""),
        lambda: rng.choice(("study.toml", "poses.csv", "rx.csv", "dipole", "patch", "a", "9")),
        lambda: old + rng.choice(("x", "0", "e9", ",")),
    )
    return rng.choice(kinds)()


def csv_files(rng: random.Random) -> Trial:
    """Return a sound study, and a mutated table of receivers or poses."""
    name = rng.choice(tuple(CSV_FILES))
    if rng.random() < 0.5:
        content = mutated_bytes(rng, CSV_FILES[name].encode())
    else:
        rows = [line.split(",") for line in CSV_FILES[name].splitlines()]
        for _ in range(rng.choice((1, 1, 2, 3))):
            row = rng.choice(rows[1:])
            row[rng.randrange(len(row))] = _wild_word(rng, "1.0")
        content = "\n".join(",".join(row) for row in rows).encode()
    call = {
        "poses.csv": "rss study.toml --tag a --poses poses.csv --csv rss.csv",
        "rx.csv": "paths study.toml --tx 1.5,1.2,1.9 --rx-file rx.csv --csv paths.csv",
    }[name]
    return Trial(files={"study.toml": STUDY.encode(), name: content}, arguments=tuple(call.split()))


def pattern_files(rng: random.Random) -> Trial:
    """Return an antenna's file of any format, mutated as text or in its numbers, that is read."""
    form = rng.choice(tuple(_pattern_texts()))
    content = _pattern_texts()[form].encode()
    if rng.random() < 0.5:
        content = mutated_bytes(rng, content)
    else:
        lines = content.decode().split("\n")
        head = range(min(40, len(lines)))
        for _ in range(rng.choice((1, 1, 2, 3, 8))):
            at = rng.choice(head) if rng.random() < 0.5 else rng.randrange(len(lines))
            found = list(re.finditer(r"[-+]?\d[\d.]*([eE][-+]?\d+)?", lines[at]))
            if found:
                one, line = rng.choice(found), lines[at]
                value = wild_number(rng, float(one.group()))
                lines[at] = f"{line[: one.start()]}{value}{line[one.end() :]}"
        content = "\n".join(lines).encode()
    name = f"antenna.{form}"
    call = f"paths study.toml --tx 0,0,1 --rx 1,1,0.3 --tx-antenna {name} --csv paths.csv"
    files = {name: content, "study.toml": FREE_SPACE}  # the study is for who repeats it by hand
    return Trial(files=files, arguments=tuple(call.split()), load_only=True)


FREE_SPACE = b'[room]\nfree_space = true\n[[tag]]\nid = "a"\nposition_m = [0.0, 0.0, 1.0]\n'
S2P = """! Touchstone file exported from HFSS
# GHZ S MA R 50.0
2.3 0.1 180 0.9 -90 0.9 -90 0.1 0
! Port Impedance30               0                75               0
2.4 0.2 170 0.8 -80 0.8 -80 0.2 10 ! near
! Port Impedance30               1                75               0
"""


@functools.cache
def _pattern_texts() -> dict[str, str]:
    """Return a sound file of each format, by its suffix: those of the tests."""
    made = runpy.run_path(str(ROOT / "tests/support/pattern_texts.py"))["TEXTS"]
    rows = [
        f"{t},{p},{-t / 20:g},{-p / 30:g}" for t in range(0, 181, 15) for p in range(0, 360, 15)
    ]
    cuts = [f"{cut},{a},{-abs(a) / 9:g}" for cut in ("horizontal", "vertical") for a in ANGLES]
    return {{"nec": "nout"}.get(form, form): make() for form, make in made.items()} | {
        "gains.csv": "\n".join(("theta_deg,phi_deg,gain_theta_db,gain_phi_db", *rows)),
        "cuts.csv": "\n".join(("cut,angle_deg,gain_db", *cuts)),
        "s2p": S2P,
    }


ANGLES = range(-180, 180, 10)


def caches(rng: random.Random) -> Trial:
    """Return files that a run has kept, one of them mutated, and the same command once more."""
    call = rng.choice(KEEPING)
    files, results = _kept_files(call)
    kept = [name for name in files if name not in ("study.toml", *CSV_FILES)]
    name = rng.choice(kept)
    return Trial(
        files=files | {name: mutated_bytes(rng, files[name])},
        arguments=(*call.split(), "--force"),
        expected=results,
    )


KEEPING = (
    "rss study.toml --tag a --poses poses.csv --csv rss.csv",
    "sweep study.toml --out sweep --workers 1",
)
"""Calls that keep what they compute, in the cache of readers or in the folder of their results."""


@functools.cache
def _kept_files(call: str) -> tuple[dict[str, bytes], dict[str, bytes]]:
    study = tomllib.loads(STUDY.replace('"isolated"', '"fullwave"'))
    study = toml_bytes(part_for(call.split(maxsplit=1)[0], study))
    given = {"study.toml": study} | {name: text.encode() for name, text in CSV_FILES.items()}
    with _folder_of(given) as folder, contextlib.redirect_stdout(io.StringIO()):
        with contextlib.redirect_stderr(io.StringIO()):
            code = run(call.split())
        assert code == 0, f"octant {call} ended with {code}"  # noqa: S101
        made = {
            str(path.relative_to(folder)): path.read_bytes()
            for path in sorted(folder.rglob("*"))
            if path.is_file()
        }
    return made, {name: content for name, content in made.items() if name.endswith(".csv")}


MESH_STUDY = """
[radio]
frequency_hz = 2.4e9
[room]
mesh = "room.KIND"
unit = "m"
material = "concrete"
[[tag]]
id = "a"
position_m = [1.5, 1.2, 2.0]
antenna = "dipole"
[reader]
response = "isolated"
[solver]
max_reflections = 1
diffraction = true
"""
WILD_NUMBERS = """
    nan inf -inf 1e999 1e200 -1e200 1e20 1e-300 0 -0 -1 0.5 1e5 65536 -2147483649 1e9
    99999999999999999999 -99999999999999999999 abc 1,5 0x10 1//2 1/ --1
"""
"""What takes the place of a number of a mesh file in text."""


def meshes(rng: random.Random) -> Trial:
    """Return a mutated mesh file that is looked over."""
    return _mutated_mesh(rng, "audit room.KIND --unit m")


def mesh_rooms(rng: random.Random) -> Trial:
    """Return a mutated mesh file that is a room with paths in it."""
    return _mutated_mesh(rng, "paths study.toml --tx 1.5,1.2,1.9 --rx 0.5,0.6,0.7 --csv paths.csv")


def _mutated_mesh(rng: random.Random, call: str) -> Trial:
    kind, content = rng.choice(mesh_files())
    what = rng.random()
    if kind in ("gltf", "glb") and what < 0.6:
        content = _mutated_gltf(rng, content)
    elif kind in ("obj", "stl", "ply", "off") and b"\0" not in content and what < 0.6:
        content = _other_numbers(rng, content)
    elif what < 0.97:
        content = mutated_bytes(rng, content)
    else:
        content = b""
    call, study = call.replace("KIND", kind), MESH_STUDY.replace("KIND", kind)
    if kind == "3mf":  # the file says its unit
        call, study = call.removesuffix(" --unit m"), study.replace('unit = "m"\n', "")
    return Trial(
        files={"study.toml": study.encode(), f"room.{kind}": content},
        arguments=tuple(call.split()),
    )


@functools.cache
def mesh_files() -> tuple[tuple[str, bytes], ...]:
    """Return a furnished room in every format that is written here, text and binary."""
    bodies = (
        *box_room((3.0, 2.5, 2.0)),
        cylinder(0.2, 0.7, position_m=(0.9, 1.7, 0.0), yaw_deg=10.0, material="metal", sides=6),
    )
    both = trimesh.Trimesh(
        np.concatenate([body.triangles_m.reshape(-1, 3) for body in bodies]),
        np.arange(3 * sum(len(body.faces) for body in bodies)).reshape(-1, 3),
        process=False,
    )
    found = [
        ("stl", both.export(file_type="stl_ascii").encode()),
        ("ply", both.export(file_type="ply", encoding="ascii")),
        ("obj", POLYGONS.encode()),
    ]
    with tempfile.TemporaryDirectory() as folder:
        for kind in ("obj", "stl", "ply", "off", "glb", "gltf", "3mf"):
            path = Path(folder) / f"room.{kind}"
            save_bodies(bodies, path)
            found.append((kind, path.read_bytes()))
    return tuple(found)


POLYGONS = """o floor
v 0 0 0
v 3 0 0
v 3 1 0
v 1.5 1 0
v 1.5 2.5 0
v 0 2.5 0
f 1 2 3 4 5 6
o walls
v 0 0 2
v 3 0 2
v 3 1 2
f 1 2 8 7
f -1/1/1 -2/2/2 2/3/3 3/4/4
"""
"""A mesh of polygons, one of them concave."""


def _other_numbers(rng: random.Random, content: bytes) -> bytes:
    """Return a text with one to four numbers replaced."""
    places = list(re.finditer(rb"(?<![\w.])[-+]?\d[\w.+-]*", content))
    for place in sorted(rng.sample(places, rng.choice((1, 1, 2, 4))), key=lambda p: -p.start()):
        number = rng.choice(WILD_NUMBERS.split()).encode()
        content = content[: place.start()] + number + content[place.end() :]
    return content


def _mutated_gltf(rng: random.Random, content: bytes) -> bytes:
    """Return a GLB or GLTF file whose tables are mutated, its lengths right."""
    if not content.startswith(b"glTF"):
        return json.dumps(mutated_tables(rng, json.loads(content))).encode()
    length = int.from_bytes(content[12:16], "little")
    tables = mutated_tables(rng, json.loads(content[20 : 20 + length]))
    text = json.dumps(tables).encode()
    text += b" " * (-len(text) % 4)
    rest = content[20 + length :]
    head = b"glTF" + struct.pack("<III", 2, 20 + len(text) + len(rest), len(text))
    return head + b"JSON" + text + rest


GENERATORS: dict[str, Callable[[random.Random], Trial]] = {
    "studies": study_loads,
    "verbs": study_verbs,
    "options": option_lines,
    "csv": csv_files,
    "patterns": pattern_files,
    "caches": caches,
    "meshes": meshes,
    "rooms": mesh_rooms,
}


# How a trial is judged ----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """What is wrong with how a trial ended.

    Parameters
    ----------
    what : In one line; equal lines are one finding.
    detail : What helps to mend it.
    """

    what: str
    detail: str = ""


@contextlib.contextmanager
def _folder_of(files: Mapping[str, bytes]) -> Iterator[Path]:
    """Yield a new working directory with these files, and the cache of readers in it."""
    with tempfile.TemporaryDirectory() as name, contextlib.chdir(name):
        folder = Path(name)
        for place, content in files.items():
            (folder / place).parent.mkdir(parents=True, exist_ok=True)
            (folder / place).write_bytes(content)
        before = os.environ.get("OCTANT_CACHE_DIR")
        os.environ["OCTANT_CACHE_DIR"] = str(folder / "cache")
        try:
            yield folder
        finally:
            if before is None:
                del os.environ["OCTANT_CACHE_DIR"]
            else:
                os.environ["OCTANT_CACHE_DIR"] = before


@contextlib.contextmanager
def _time_limit() -> Iterator[None]:
    """Limit processor time, and the clock's, which others' work on the machine stretches."""

    def stop(_signal: int, _frame: object) -> None:
        msg = f"longer than {LONGEST_S:g} s"
        raise TimeoutError(msg)

    timers = (
        (signal.SIGPROF, signal.ITIMER_PROF, LONGEST_S),
        (signal.SIGALRM, signal.ITIMER_REAL, STRETCHED * LONGEST_S),
    )
    before = [signal.signal(number, stop) for number, _, _ in timers]
    for _, timer, limit_s in timers:
        signal.setitimer(timer, limit_s)
    try:
        yield
    finally:
        for (number, timer, _), old in zip(timers, before, strict=True):
            signal.setitimer(timer, 0.0)
            signal.signal(number, old)


def judged(trial: Trial) -> Finding | None:
    """Return what is wrong with how a trial ends in this process, if anything.

    Parameters
    ----------
    trial : The trial.
    """
    said, faults = io.StringIO(), []

    def floating_point(kind: str, _flag: int) -> None:
        faults.append(f"numpy: {kind} at {_place(traceback.extract_stack())}")

    with (
        _folder_of(trial.files) as folder,
        mock.patch.object(options, "LONGEST_S", ANNOUNCED_S),
        np.errstate(over="call", invalid="call", divide="call", call=floating_point),
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(said),
    ):
        began = time.process_time()
        try:
            with _time_limit():
                code = _loaded(next(iter(trial.files))) if trial.load_only else run(trial.arguments)
        except (Exception, SystemExit) as exc:  # noqa: BLE001  that is what is looked for
            where = _place(traceback.extract_tb(exc.__traceback__))
            text = re.sub(r"[-+]?\d[\d.e+-]*", "#", str(exc))[:80]
            return Finding(what=f"{type(exc).__name__} at {where}: {text}", detail=str(exc)[:300])
        seconds = time.process_time() - began
        if seconds > LONGEST_S:
            return Finding(what=f"{trial.arguments[0]} took longer than {LONGEST_S:g} s")
        wrong = _wrong_answer(code, said.getvalue()) or _wrong_files(trial, code, folder)
    return wrong or (Finding(what=faults[0]) if faults else None)


def _place(frames: Any) -> str:
    own = [f for f in frames if "/tools/" not in f.filename] or list(frames)
    inside = [
        f for f in own if re.search(r"/(em|geometries|navigation|reader_design)/", f.filename)
    ]
    last = (inside or own)[-1]
    return f"{'/'.join(Path(last.filename).parts[-2:])}:{last.lineno}"


def _loaded(name: str) -> int:
    """Return the exit code that loading a file would lead to; its sentence goes to stderr."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", PhysicsWarning)  # doubts about a file are no finding
            if name.endswith(".toml"):
                load_study(name)
            elif name.endswith(".s2p"):
                read_touchstone(name)
            else:
                made = reader_from_pattern_files(
                    [name], azimuths_rad=[0.0], frequency_hz=2.4e9, step_deg=15.0
                )
                if not np.isfinite(made.far_field(*np.ogrid[0.0:3.1:0.4, 0.0:6.0:0.5])).all():
                    msg = "the far field is not finite"
                    raise FloatingPointError(msg)
    except OctantError as exc:
        sys.stderr.write(f"error: {' '.join(str(exc).split())}\n")
        return 2
    return 0


def _wrong_answer(code: int, said: str) -> Finding | None:
    if code not in GOOD_CODES:
        return Finding(what=f"exit code {code}", detail=said)
    if "Traceback" in said:
        return Finding(what="a traceback is printed", detail=said)
    if re.search(r"encountered in|NumbaWarning|RuntimeWarning|DeprecationWarning", said):
        return Finding(what="another library's warning is printed", detail=said)
    errors = [line for line in said.splitlines() if line.startswith("error: ")]
    if code == 2 and len(errors) != 1:
        return Finding(what=f"{len(errors)} lines of error with exit code 2", detail=said)
    if errors and len(errors[0]) > LONGEST_MESSAGE:
        return Finding(what=f"a message of more than {LONGEST_MESSAGE} characters", detail=said)
    return None


def _timeless(table: bytes) -> list[dict[str, str]]:
    """Return the rows of a CSV file without how long each took."""
    rows = csv.DictReader(io.StringIO(table.decode("utf-8", "replace")))
    return [{name: cell for name, cell in row.items() if name != "seconds"} for row in rows]


def _wrong_files(trial: Trial, code: int, folder: Path) -> Finding | None:
    if code == 0:
        for name, content in trial.expected.items():
            path = folder / name
            if not path.is_file() or _timeless(path.read_bytes()) != _timeless(content):
                return Finding(what=f"{name} is not what it was before a file was changed")
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if name in trial.files or name.startswith("cache") or not path.is_file():
            continue
        if path.suffix == ".csv" and (cell := _bad_cell(path)):
            return Finding(what=f"{path.name}: {cell}")
        if path.suffix == ".nc" and (found := _bad_variable(path)):
            return Finding(what=f"{path.name}: {found}")
    return None


def _bad_cell(path: Path) -> str:
    with path.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            for column, cell in row.items():
                parts = str(cell).lower().split(";")
                silent = "_db" in str(column) and "-inf" in parts
                if {"nan", "inf", "-inf"} & set(parts) and not silent:
                    return f"{cell} in column {column}"
    return ""


def _bad_variable(path: Path) -> str:
    import h5py

    if not h5py.is_hdf5(path):  # a file of another kind that an option named so
        return ""
    with h5py.File(path) as file:
        for name, values in file.items():
            if values.dtype.kind != "f":
                continue
            numbers, unit = values[()], str(values.attrs.get("units", ""))
            if np.isnan(numbers).any() and "missing" not in values.attrs:
                return f"NaN in {name}"
            if np.isposinf(numbers).any() or (np.isneginf(numbers).any() and "dB" not in unit):
                return f"infinity in {name}"
    return ""


def confirmed(trial: Trial) -> str:
    """Return what the command line says to a trial: its exit code and its last line on stderr.

    Parameters
    ----------
    trial : The trial.
    """
    with _folder_of(trial.files):
        words = [sys.executable, "-c", CONFIRM, *trial.arguments]
        try:
            done = subprocess.run(words, capture_output=True, timeout=3 * LONGEST_S, check=False)
        except subprocess.TimeoutExpired:
            return f"no end after {3 * LONGEST_S:g} s"
        lines = done.stderr.decode("utf-8", "replace").strip().splitlines()
    traced = "a traceback, " if any(line.startswith("Traceback") for line in lines) else ""
    return f"{traced}exit code {done.returncode}: {lines[-1][:200] if lines else ''}"


def trial_of(kind: str, seed: int, number: int) -> Trial:
    """Return a trial by its number.

    Parameters
    ----------
    kind, seed, number : A name of ``GENERATORS``; seed of the run, number in it.
    """
    return GENERATORS[kind](random.Random(f"{kind} {seed} {number}"))  # noqa: S311  no secrets here


def findings(
    kind: str, *, seed: int, count: int, first: int = 0
) -> Iterator[tuple[int, Trial, Finding]]:
    """Yield every trial that ends as none may, with its number.

    Parameters
    ----------
    kind, seed, count, first : As on the command line.
    """
    for number in range(first, first + count):
        trial = trial_of(kind, seed, number)
        if (finding := judged(trial)) is not None:
            yield number, trial, finding


def main() -> int:
    """Return 1 where the trials that the command line asks for have findings, else 0."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("kind", choices=tuple(GENERATORS))
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--keep", type=Path, help="Folder for the files of each finding.")
    given = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY_BYTES, resource.RLIM_INFINITY))
    if given.kind != "studies":
        with contextlib.redirect_stdout(io.StringIO()):
            run(["warm-up", "--quiet"])  # compiling is not what takes a trial's time
    seen: dict[str, int] = {}
    for number, trial, finding in findings(
        given.kind, seed=given.seed, count=given.count, first=given.first
    ):
        seen[finding.what] = seen.get(finding.what, 0) + 1
        if seen[finding.what] > 1:
            continue
        click.echo(f"{given.kind} {number}: {finding.what}\n    {finding.detail[-600:]}")
        click.echo(f"    octant {' '.join(trial.arguments)}: {confirmed(trial)}")
        if given.keep is not None:
            for name, content in trial.files.items():
                path = given.keep / f"{given.kind}-{given.seed}-{number}" / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(content)
    click.echo(f"{given.kind}: {given.count} trials with seed {given.seed}, {len(seen)} findings")
    for what, times in sorted(seen.items(), key=lambda item: -item[1]):
        click.echo(f"{times:6d}  {what}")
    return 1 if seen else 0


if __name__ == "__main__":
    sys.exit(main())
