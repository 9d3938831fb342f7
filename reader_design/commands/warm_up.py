"""``octant warm-up``: compile every kernel that a command can need, ahead of its first use."""

import contextlib
import io
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

import click

from octant.reader_design.cli import run
from octant.reader_design.keeping.progress import Progress

STUDY = """
name = "warm-up"
[room]
box_m = [2.0, 2.0, 2.0]
[[room.object]]
kind = "cabinet"
size_m = [0.3, 0.3, 0.3]
position_m = [1.5, 1.5, 0.0]
[[tag]]
id = "tag"
position_m = [1.0, 1.0, 1.9]
antenna = "dipole"
[reader]
response = "RESPONSE"
antennas = 4
cells_per_wavelength = 5.0
[solver]
max_reflections = 1
SOLVER
[map]
spacing_m = 0.5
[mission]
navigator = "thesis"
start_m = [0.5, 0.5]
tags = ["tag"]
runs = 1
"""
"""A scene that takes moments; RESPONSE stands for the reader's model, SOLVER for more settings."""

SOLVERS = {
    "edges": """
diffraction = true
max_diffractions = 2
transmission = true
""",
    "launched": """
search = "rays"
rays = 1000
faces = "as_stored"
""",
}
"""Further settings of the solver by name of the study, whose reader is ``isolated``."""

NAVIGATORS = {"tracker": "tracker"}
"""Navigator of such a study in place of ``thesis``, by the study's name."""

POSES = "x_m,y_m,heading_deg\n0.5,0.5,0.0\n"

CALLS = (
    ("isolated", "paths STUDY --tx 1,1,1.9 --rx 0.5,0.5,0.3"),
    ("edges", "paths STUDY --tx 1,1,1.9 --rx 0.5,0.5,0.3"),
    ("edges", "explain STUDY --tx 1,1,1.9 --rx 1.65,1.65,0.6 --path 0"),
    ("edges", "map STUDY --out edges.nc"),
    ("launched", "paths STUDY --tx 1,1,1.9 --rx 0.5,0.5,0.3"),
    ("isolated", "map STUDY --out isotropic.nc --isotropic"),
    ("isolated", "map STUDY --out map.nc"),
    ("isolated", "rss STUDY --tag tag --poses POSES --csv rss.csv"),
    ("isolated", "navigate STUDY --out navigate"),
    ("tracker", "navigate STUDY --out tracker"),
    ("rays", "reader STUDY --out rays --step-deg 45"),
    ("fullwave", "reader STUDY --out fullwave --step-deg 45"),
    ("fullwave", "study STUDY --out study --quick"),
)
"""Study (by its reader's model or its solver) and call: every verb that computes."""


@click.command(name="warm-up")
@click.option("--quiet", "-q", is_flag=True, help="No progress and no messages.")
def warm_up(*, quiet: bool) -> None:
    """Compile every kernel now, so that no later command has to.

    Runs each verb once on a small scene of its own, except ``track`` and ``dock``, which compile
    their own loops when they first run; only the compiled kernels are kept.
    They stay beside the installed package, or in the user's cache folder where the package's cannot
    be written, or in the folder that the environment variable NUMBA_CACHE_DIR names.
    """
    from octant.geometries.kernels import open_all
    from octant.reader_design.compilation import recorded_compilation

    with tempfile.TemporaryDirectory() as name, recorded_compilation() as record:
        folder = Path(name)
        _write_inputs(folder)
        with Progress(quiet=quiet).track(CALLS, label="warm-up") as calls:
            for model, call in calls:
                _run(model, call, folder)
        open_all()
    if record.kernels:
        where = os.path.commonpath([str(kept) for kept in record.folders])
        click.echo(f"compiled {len(record.kernels)} kernels in {record.seconds:.0f} s: {where}")
    else:
        click.echo("nothing to compile: every kernel is ready.")


def _write_inputs(folder: Path) -> None:
    for name in {name for name, _ in CALLS}:
        own = name in SOLVERS or name in NAVIGATORS
        text = STUDY.replace("RESPONSE", "isolated" if own else name)
        text = text.replace("SOLVER", SOLVERS.get(name, ""))
        text = text.replace('"thesis"', f'"{NAVIGATORS.get(name, "thesis")}"')
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    (folder / "poses.csv").write_text(POSES, encoding="utf-8")


def _run(model: str, call: str, folder: Path) -> None:
    places = {"STUDY": f"{model}.toml", "POSES": "poses.csv"}
    words = [places.get(word, word) for word in f"{call} --quiet".split()]
    said = io.StringIO()
    with (
        contextlib.chdir(folder),
        _environment("OCTANT_CACHE_DIR", str(folder)),
        contextlib.redirect_stdout(said),
        contextlib.redirect_stderr(said),
    ):
        code = run(words)
    if code:
        msg = f"warming up, 'octant {call}' ended with exit code {code}: {said.getvalue()}"
        raise click.ClickException(msg)


@contextlib.contextmanager
def _environment(name: str, value: str) -> Iterator[None]:
    before = os.environ.get(name)
    os.environ[name] = value
    try:
        yield
    finally:
        if before is None:
            del os.environ[name]
        else:
            os.environ[name] = before
