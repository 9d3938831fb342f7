"""A walk over all verbs: their shared options, help that explains them, and the same again."""

import click
import pytest
from small_study import SMALL

from octant.reader_design.cli import VERBS
from octant.reader_design.cli import octant as program

EXPERIMENTS = (
    *("study", "sweep", "optimise", "navigate", "tolerance", "track", "dock"),
    "replay",
)
MEASURED = ("compare", "calibrate")
LOG = "simulate-log"
PATHS = ("paths", "explain", "rss")
EXPECTED = {
    "study": (*EXPERIMENTS, *MEASURED, LOG, *PATHS, "map", "scene", "reader"),
    "--out": (*EXPERIMENTS, *MEASURED, LOG, "map", "scene", "reader"),
    "--force": (*EXPERIMENTS, *MEASURED, LOG, *PATHS, "map", "scene", "reader"),
    "--workers": EXPERIMENTS,
    "--cluster": EXPERIMENTS,
    "--dry-run": (*EXPERIMENTS, *MEASURED, "map", "reader"),
    "--seed": (*EXPERIMENTS, "calibrate", LOG, "rss"),
    "--quick": ("study", "navigate", "tolerance", "track", "dock", "map"),
    "--json": (*EXPERIMENTS, *MEASURED, *PATHS, "map", "scene", "reader", "audit", "materials"),
    "--quiet": (
        *EXPERIMENTS,
        *MEASURED,
        LOG,
        *PATHS,
        "map",
        "scene",
        "reader",
        "audit",
        "materials",
        "warm-up",
    ),
}
"""By option, the verbs that have it: it is absent where it would mean nothing. Maps and readers are
computed by threads, so that workers would not help; what goes to stdout needs no folder."""
OTHERS = ("init", "demo")
"""Verbs that make a study or show one."""


def command_of(verb):
    command = program.get_command(click.Context(program), verb)
    assert command is not None
    return command


def names_of(command):
    return {name for parameter in command.params for name in (*parameter.opts, parameter.name)}


@pytest.mark.parametrize("option", list(EXPECTED))
def test_a_shared_option_is_where_it_means_something_and_nowhere_else(option):
    have = {verb for verb in VERBS if option in names_of(command_of(verb))}
    assert have - set(OTHERS) == set(EXPECTED[option])


@pytest.mark.parametrize("verb", EXPECTED["study"])
def test_a_study_may_be_left_out_and_results_have_a_folder(verb):
    parameters = {parameter.name: parameter for parameter in command_of(verb).params}
    assert not parameters["study"].required
    if "out" in parameters and verb not in {"scene", LOG}:  # a file; or its other options decide
        assert str(parameters["out"].default) == f"octant-{verb}"
    assert "built-in study" in command_of(verb).epilog


@pytest.mark.parametrize("verb", list(VERBS))
def test_help_fits_80_columns_and_explains_every_option(verb):
    command = command_of(verb)
    root = click.Context(program, **program.context_settings)
    context = click.Context(command, info_name=f"octant {verb}", parent=root, terminal_width=80)
    assert max(map(len, command.get_help(context).splitlines())) <= 80
    for parameter in command.params:
        if isinstance(parameter, click.Option):
            assert parameter.help, parameter.name


STUDY = SMALL + "runs = 1\nmax_time_s = 5.0\n[sweep]\nplate_height_m = [0.0, 0.08]\n"
TWICE = {
    "map": (),
    "scene": (),
    "reader": ("--step-deg", "45"),
    "navigate": ("--workers", "1", "--animate", "run.gif"),
    "sweep": ("--workers", "1"),
}
"""Quick ones; the tests of tolerance, optimise, dock, track and study run theirs twice too."""


@pytest.mark.parametrize("verb", list(TWICE))
def test_the_same_again_is_complete_already(octant, study_file, tmp_path, monkeypatch, verb):
    monkeypatch.chdir(tmp_path)
    call = (verb, study_file(STUDY), *TWICE[verb])
    first = octant(*call)
    files = {p: p.stat().st_mtime_ns for p in tmp_path.rglob("*.*") if p.name != "study.toml"}
    again = octant(*call)
    assert (first.code, again.code) == (0, 0), first.err + again.err
    assert "complete already" in again.err
    assert again.out == first.out
    assert files == {p: p.stat().st_mtime_ns for p in files}
    named = first.out.splitlines()[-1]
    assert named.startswith("written: ")
    for path in named.removeprefix("written: ").replace(" and ", ", ").split(", "):
        assert (tmp_path / path).exists()
