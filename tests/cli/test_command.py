"""The command itself: help, version, unknown names, exit codes, streams, interruption."""

import os
import signal
import subprocess
import sys
import time

import click
import pytest

from octant.reader_design import cli

PROGRAM = [sys.executable, "-c", "from octant.reader_design.cli import main; main()"]


def process(*arguments, **options):
    return subprocess.run(
        [*PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False, **options
    )


@pytest.mark.parametrize("argument", ["--help", "-h", None])
def test_help_lists_every_verb_on_stdout(octant, argument):
    call = octant(*([argument] if argument else []))
    assert call.code == 0
    assert call.err == ""
    for verb in ("study", "map", "paths", "rss", "audit", "materials", "navigate", "dock"):
        assert f"\n  {verb} " in call.out


@pytest.mark.parametrize("verb", list(cli.VERBS))
def test_every_verb_has_help_with_its_short_option(octant, verb):
    call = octant(verb, "-h")
    assert call.code == 0
    assert call.out.startswith(f"Usage: octant {verb} ")


def test_help_imports_nothing_heavy():
    code = (
        "import sys; from octant.reader_design.cli import run; run(['--help']);"
        "heavy = {'numpy', 'numba', 'scipy', 'trimesh', 'xarray', 'matplotlib', 'tqdm'};"
        "sys.exit(','.join(heavy & set(sys.modules)) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_help_of_a_verb_imports_nothing_slow():
    """numba alone takes a second; half a second is what a person waits for a help page."""
    code = (
        "import sys; from octant.reader_design.cli import VERBS, run;"
        "[run([verb, '--help']) for verb in VERBS];"
        "slow = {'numba', 'scipy', 'trimesh', 'xarray', 'matplotlib'};"
        "sys.exit(','.join(slow & set(sys.modules)) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_version_is_on_stdout(octant):
    call = octant("--version")
    assert call.code == 0
    assert call.out.startswith("octant")


@pytest.mark.parametrize(
    ("arguments", "near"),
    [
        (["stdy"], "'study'"),
        (["navigat"], "'navigate'"),
        (["materials", "--frequency-gz", "2"], "--frequency-ghz"),
        (["map", "x.toml", "--out", "m.nc", "--isotropc"], "--isotropic"),
    ],
)
def test_unknown_verbs_and_options_suggest_the_nearest(octant, arguments, near):
    assert near in octant(*arguments).refused()


@pytest.mark.parametrize(
    "arguments", [["paths"], ["paths", "x.toml"], ["rss", "x.toml", "--tag"], ["audit", "a", "b"]]
)
def test_usage_errors_are_one_sentence(octant, arguments):
    octant(*arguments).refused()


def test_bad_input_through_a_real_process_has_no_traceback(tmp_path):
    done = process("study", tmp_path / "none.toml")
    assert done.returncode == 2
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) == 1
    assert "none.toml" in done.stderr


def test_messages_never_reach_stdout(octant, study_file):
    call = octant("paths", study_file(), "--tx", "3.5,2,3.0", "--rx", "1,1,0.3")
    assert call.code == 0
    assert "moved" in call.err
    assert "moved" not in call.out


def test_output_into_a_closed_pipe_is_no_error():
    with subprocess.Popen(
        [*PROGRAM, "materials"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as child:
        child.stdout.close()
        error = child.stderr.read()
        assert child.wait() == 0
    assert error == b""


@pytest.mark.parametrize("stop", [KeyboardInterrupt, click.Abort])
def test_interruption_is_one_line_and_code_130(octant, monkeypatch, stop):
    @click.command()
    def endless():
        raise stop

    monkeypatch.setattr(cli.VerbGroup, "get_command", lambda *_: endless)
    call = octant("study")
    assert call.code == 130
    assert call.err.strip() == "interrupted: nothing was written."


def test_interrupted_runs_say_what_is_kept(octant, monkeypatch):
    @click.command()
    def long_run():
        raise cli.InterruptedRunError("5 of 12 cells are kept in out.")

    monkeypatch.setattr(cli.VerbGroup, "get_command", lambda *_: long_run)
    call = octant("study")
    assert (call.code, call.err) == (130, "interrupted: 5 of 12 cells are kept in out.\n")


def test_physics_warnings_are_shown_once_each(octant, monkeypatch):
    import warnings

    from octant.geometries.errors import PhysicsWarning

    @click.command()
    def doubtful():
        for text in ("near field", "near field", "out of range"):
            warnings.warn(text, PhysicsWarning, stacklevel=1)

    monkeypatch.setattr(cli.VerbGroup, "get_command", lambda *_: doubtful)
    call = octant("study")
    assert call.code == 0
    assert call.err == "warning: near field\nwarning: out of range\n"


@pytest.mark.skipif(os.name == "nt", reason="signals differ")
def test_ctrl_c_ends_a_process_with_130():
    code = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler);"  # nohup
        "import time, click; from octant.reader_design import cli;"
        "cmd = click.Command('x', callback=lambda: (print('up', flush=True), time.sleep(60)));"
        "cli.VerbGroup.get_command = lambda *a: cmd; import sys; sys.argv = ['octant', 'x'];"
        "cli.main()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as child:
        assert child.stdout.readline() == "up\n"
        time.sleep(0.1)
        child.send_signal(signal.SIGINT)
        _, error = child.communicate(timeout=30)
    assert child.returncode == 130
    assert error.strip() == "interrupted: nothing was written."


def test_want_of_memory_names_what_is_large_and_other_libraries_warnings_stay_away(
    octant, monkeypatch
):
    import warnings

    from octant.reader_design import cli

    def greedy(*_args, **_more):
        warnings.simplefilter("always")
        warnings.warn("overflow encountered in dot", RuntimeWarning, stacklevel=1)
        msg = "Unable to allocate 4.90 GiB for an array"
        raise MemoryError(msg)

    monkeypatch.setattr(cli.octant, "main", greedy)
    sentence = octant("map").refused()
    assert "needs 4.90 GiB more" in sentence
    assert "large in wavelengths" in sentence
