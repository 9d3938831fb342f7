"""Colour where a terminal takes it, and what the shell completes."""

import io

import pytest
from click.testing import CliRunner

from octant.reader_design import cli
from octant.reader_design.terminal.colour import judged, painted, takes_colour


class Terminal(io.StringIO):
    """What a terminal would get."""

    def isatty(self):
        return True


@pytest.mark.parametrize(
    ("terminal", "variables", "coloured"),
    [
        (True, {}, True),
        (False, {}, False),
        (True, {"NO_COLOR": "1"}, False),
        (False, {"FORCE_COLOR": "1"}, True),
        (True, {"NO_COLOR": "1", "FORCE_COLOR": "1"}, False),
        (True, {"TERM": "dumb"}, False),
    ],
)
def test_colour_is_for_terminals_and_as_the_variables_say(
    monkeypatch, terminal, variables, coloured
):
    for name in ("NO_COLOR", "FORCE_COLOR"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("TERM", "xterm")
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    stream = Terminal() if terminal else io.StringIO()
    assert takes_colour(stream) == coloured
    assert ("\x1b[" in painted("error:", "error", stream)) == coloured


def test_errors_are_red_on_request_and_plain_in_a_pipe(octant, monkeypatch):
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    assert octant("map", "none.toml").err.startswith("error: ")
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert octant("map", "none.toml").err.startswith("\x1b[31m\x1b[1merror:\x1b[0m ")


def test_a_share_is_judged_by_how_many_runs_arrive():
    assert [judged(share) for share in (1.0, 0.9, 0.6, 0.2)] == ["good", "good", "fair", "poor"]


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("nav", "navigate"),
        ("map off", "office"),
        ("map st", "study.toml"),
        ("rss study.toml --tag d", "desk"),
        ("paths study.toml --tx d", "desk"),
        ("paths --tx-antenna con", "conical_patch"),
        ("materials conc", "concrete"),
        ("audit ro", "room.glb"),
        ("reader --mod", "--model"),
        ("reader --model ful", "fullwave"),
    ],
)
def test_the_shell_completes(tmp_path, monkeypatch, line, offered):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.glb").touch()
    (tmp_path / "study.toml").write_text(
        '[room]\nbox_m = [4, 4, 3]\n[[tag]]\nid = "desk"\nposition_m = [1, 1, 2]\n'
    )
    words = f"octant {line}"
    asked = {
        "_OCTANT_COMPLETE": "bash_complete",
        "COMP_WORDS": words,
        "COMP_CWORD": str(len(words.split()) - 1),
    }
    done = CliRunner().invoke(cli.octant, [], prog_name="octant", env=asked)
    assert offered in [item.partition(",")[2] for item in done.output.splitlines()]


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_prints_a_script_of_the_shell(octant, shell):
    call = octant("completion", shell)
    assert (call.code, call.err) == (0, "")
    assert "_OCTANT_COMPLETE" in call.out
    assert f"{shell}_complete" in call.out


def test_a_material_by_another_word_leads_to_the_table_s_name(octant):
    assert "did you mean 'plasterboard'?" in octant("materials", "gypsum").refused()
