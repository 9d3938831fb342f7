"""What a command will take is known before it starts, and too much is not started."""

import pytest
from part_of_study import part_for

from octant.navigation.logs.log_csv import LOG_COLUMNS
from octant.reader_design import options

STUDY = """
[room]
box_m = [5.0, 4.0, 3.0]
material = "concrete"
[[tag]]
id = "A"
position_m = [1.2, 1.0, 2.4]
antenna = "dipole"
[reader]
response = "rays"
[solver]
max_reflections = 1
[mission]
navigator = "thesis"
start_m = [0.6, 0.6]
tags = ["A"]
runs = 2
[tolerance]
samples = 3
[optimise]
survey = 2
evaluations = 4
parameters = { antenna_radius_m = [0.03, 0.05] }
goal = [{ score = "right_share", value = 1.0 }]
[sweep]
antenna_radius_m = [0.03, 0.04]
"""
COMMANDS = {
    "study": ("study.toml", "--out", "out"),
    "sweep": ("study.toml", "--out", "out"),
    "optimise": ("study.toml", "--out", "out"),
    "tolerance": ("study.toml", "--out", "out"),
    "map": ("study.toml", "--out", "out"),
    "navigate": ("study.toml", "--out", "out"),
    "reader": ("study.toml", "--out", "out", "--model", "fullwave"),
    "rss": ("study.toml", "--tag", "A", "--poses", "poses.csv"),
    "paths": ("study.toml", "--tx", "1,1,1", "--rx", "2,2,1"),
    "compare": ("study.toml", "--log", "log.csv", "--out", "out"),
    "calibrate": ("study.toml", "--log", "log.csv", "--out", "out", "--fit", "level"),
    "replay": ("study.toml", "--log", "log.csv", "--out", "out"),
    "dock": ("--out", "out"),
    "track": ("--out", "out"),
}


@pytest.fixture
def typed(octant, study_file, tmp_path, monkeypatch):
    """A command as it is typed in a folder with a study, with some limits of what is too much."""

    def call(verb, *more, **limits):
        study_file(part_for(verb, STUDY))
        (tmp_path / "poses.csv").write_text("x_m,y_m,heading_deg\n1,1,90\n")
        rows = [f"{k},{1 + 0.1 * k},1,0,0.1,0,A,{i},-40," for k in range(9) for i in range(1, 9)]
        (tmp_path / "log.csv").write_text("\n".join([",".join(LOG_COLUMNS), *rows]))
        monkeypatch.chdir(tmp_path)
        for name, limit in limits.items():
            monkeypatch.setattr(options, name, limit)
        return octant(verb, *COMMANDS[verb], *more)

    return call


@pytest.mark.parametrize("verb", COMMANDS)
def test_what_takes_too_long_is_not_started_without_a_yes(typed, verb, tmp_path):
    sentence = typed(verb, LONGEST_S=-1.0).refused()
    assert "--yes" in sentence
    assert "ask for less: " in sentence
    assert not list(tmp_path.glob("out/**/*.*"))


@pytest.mark.parametrize("verb", COMMANDS)
def test_what_the_machine_has_no_memory_for_is_not_started_even_with_a_yes(typed, verb, tmp_path):
    sentence = typed(verb, "--yes", free_memory_bytes=lambda: -1.0).refused()
    assert "are free; ask for less: " in sentence
    assert not list(tmp_path.glob("out/**/*.*"))


def test_readings_count_not_only_the_poses_that_they_are_of(typed):
    said = typed("rss", "--readings", "1000000", LONGEST_S=60.0).refused()
    assert "1e+06 readings" in said
    assert "--readings" in said.split("ask for less")[1]


def test_with_a_yes_it_starts(typed):
    call = typed("paths", "--yes", LONGEST_S=-1.0, MENTIONED_S=-1.0)
    assert call.code == 0
    assert "expected: " in call.err
    assert call.out.strip()
