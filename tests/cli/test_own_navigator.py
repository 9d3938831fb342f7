"""``navigator = "FILE.py:Class"``: the example arrives, by every way that leads to it."""

import csv
import importlib.util
import math
import re
import shutil
from pathlib import Path

import pytest

import octant as face

EXAMPLE = Path(__file__).parents[2] / "examples" / "python" / "own_navigator.py"
STUDY = """
[room]
free_space = true
[[tag]]
id = "A"
position_m = [1.2, 0.5, 2.0]
antenna = "dipole"
[reader]
response = "files"
pattern_files = ["panel.csv", "panel.csv", "panel.csv", "panel.csv"]
pattern_turn = "each"
antennas = 4
[mission]
start_m = [0.0, 0.0]
tags = ["A"]
navigator = "own_navigator.py:Towards"
noise_db = 0.5
runs = 2
"""
QUIET = "ignore::octant.geometries.errors.PhysicsWarning"


@pytest.fixture
def study(tmp_path, study_file):
    shutil.copy(EXAMPLE, tmp_path / "own_navigator.py")
    rows = ["theta_deg,phi_deg,gain_theta_db,gain_phi_db"]
    for t in range(0, 181, 10):
        for p in range(0, 360, 10):
            cosine = math.sin(math.radians(t)) * math.cos(math.radians(p))
            rows.append(f"{t},{p},{20 * math.log10(0.01 + 0.5 + 0.49 * cosine):.3f},-60")
    (tmp_path / "panel.csv").write_text("\n".join(rows))
    return study_file(STUDY)


def successes(folder):
    with (folder / "missions.csv").open() as file:
        return [int(row["success"]) for row in csv.DictReader(file)]


def test_the_example_has_forty_lines_and_arrives(study, octant, tmp_path):
    assert len(EXAMPLE.read_text().splitlines()) <= 40
    out = tmp_path / "out"
    call = octant("navigate", study, "--out", out, "--workers", "1")
    assert call.code == 0, call.err
    assert successes(out) == [1, 1]
    assert 'navigator = "../own_navigator.py:Towards"' in (out / "study.toml").read_text()
    again = octant("navigate", study, "--out", out, "--workers", "1")
    assert "complete already" in again.err
    # Another source of the class is another navigator: its runs are driven anew.
    file = tmp_path / "own_navigator.py"
    file.write_text(file.read_text().replace("self.ahead >= 3 and", "True or"))
    changed = octant("navigate", study, "--out", out, "--workers", "1")
    assert "complete already" not in changed.err
    assert successes(out) == [0, 0]


def test_a_class_that_fails_ends_the_command_with_its_line(study, octant, tmp_path):
    file = tmp_path / "own_navigator.py"
    file.write_text(file.read_text().replace("self.ahead += in_front", "self.ahead += 1 / 0"))
    line = next(i for i, s in enumerate(file.read_text().splitlines(), 1) if "1 / 0" in s)
    for workers in ("1", "2"):
        out = tmp_path / f"out{workers}"
        said = octant("navigate", study, "-q", "--out", out, "--workers", workers).refused()
        assert f"own_navigator.py, line {line}" in said
        assert "ZeroDivisionError: division by zero" in said
    study.write_text(STUDY.replace("Towards", "Toward"))
    said = octant("navigate", study, "-q", "--out", tmp_path / "out").refused()
    assert "own_navigator.py has no class 'Toward'; did you mean 'Towards'?" in said
    said = octant("study", study, "-q", "--out", tmp_path / "out").refused()
    assert "no class 'Toward'" in said
    study.write_text(STUDY.replace("own_navigator.py:Towards", "trackr"))
    said = octant("navigate", study, "-q", "--out", tmp_path / "out").refused()
    assert "did you mean 'tracker'" in said


@pytest.mark.usefixtures("study")
def test_own_and_built_in_navigators_are_compared(octant, tmp_path):
    compare = tmp_path / "compare.toml"
    compare.write_text(
        'runs = 2\n[[layout]]\nstudy = "study.toml"\n'
        '[[controller]]\nname = "mine"\nmission.navigator = "own_navigator.py:Towards"\n'
        '[[controller]]\nname = "thesis"\nmission.navigator = "thesis"\n'
    )
    out = tmp_path / "out"
    call = octant("navigate", compare, "--compare", "--out", out, "--workers", "1")
    assert call.code == 0, call.err
    with (out / "compare.csv").open() as file:
        rows = {row["controller"]: row for row in csv.DictReader(file)}
    assert rows["mine"]["successes"] == "2"
    assert set(rows) == {"mine", "thesis"}
    assert not re.search("own_navigator", rows["mine"]["failed_because"])


@pytest.mark.filterwarnings(QUIET)
def test_a_class_itself_drives_as_its_file_does(study, octant, tmp_path):
    spec = importlib.util.spec_from_file_location("own_navigator", EXAMPLE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    mission = face.Mission(
        face.Room.free_space(),
        [face.Tag("A", (1.2, 0.5, 2.0))],
        face.Reader(
            response="files",
            pattern_files=[str(study.parent / "panel.csv")] * 4,
            pattern_turn="each",
            antennas=4,
        ),
        start=(0.0, 0.0, 90.0),
        navigator=module.Towards,
        noise_db=0.5,
    )
    assert "navigator own_navigator:Towards" in repr(mission)
    runs = mission.run(2, seed=1, progress=False)
    assert runs.success.values.all()
    out = tmp_path / "out"
    assert octant("navigate", study, "--out", out, "--runs", "2", "--workers", "1").code == 0
    with (out / "missions.csv").open() as file:
        path_m = [float(row["path_m"]) for row in csv.DictReader(file)]
    assert runs.data["path_m"].values.tolist() == pytest.approx(path_m)
