"""The face: quick to import, documented by examples that run, and equal to the commands."""

import csv
import doctest
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import trimesh
from rosbags.highlevel import AnyReader

import octant
from octant.geometries.errors import ConfigError
from octant.reader_design.cli import run
from octant.reader_design.showing.netcdf import read_dataset

STUDY = """
[room]
box_m = [4.0, 3.0, 2.5]
material = "brick"
[[room.object]]
kind = "cabinet"
size_m = [0.5, 0.5, 1.0]
position_m = [3.0, 2.0, 0.0]
[[tag]]
id = "A"
position_m = [1.0, 1.0, 2.3]
antenna = "dipole"
[reader]
response = "isolated"
antennas = 6
[solver]
max_reflections = 2
diffraction = true
[map]
spacing_m = 0.5
[mission]
navigator = "thesis"
start_m = [2.0, 1.0]
heading_deg = 120.0
tags = ["A"]
runs = 2
"""
QUIET = "ignore::octant.geometries.errors.PhysicsWarning"
ROOT = Path(__file__).parents[2]


@pytest.fixture
def study_file(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    return path


@pytest.mark.filterwarnings(QUIET)
@pytest.mark.parametrize("name", octant.__all__)
def test_every_name_has_an_example_that_runs(name, monkeypatch):
    monkeypatch.chdir(ROOT)
    thing = getattr(octant, name)
    tests = doctest.DocTestFinder(recurse=False).find(thing, name, globs={})
    assert sum(len(test.examples) for test in tests) > 0
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    assert not sum(runner.run(test).failed for test in tests)


def test_names_are_listed_and_unknown_ones_refused():
    assert set(octant.__all__) <= set(dir(octant))
    with pytest.raises(AttributeError, match="has no attribute 'Rom'"):
        _ = octant.Rom


@pytest.mark.parametrize(
    ("code", "own"),
    [
        ("import octant", {"octant"}),
        ("from octant.reader_design.cli import run; run(['--help'])", None),
    ],
)
def test_octant_and_its_help_load_no_heavy_library(code, own):
    # What takes time is importing; benchmarks/bench_start.py measures it.
    code += "; import sys; print(*sys.modules)"
    call = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, check=True, text=True, encoding="utf-8"
    )
    loaded = set(call.stdout.splitlines()[-1].split())
    assert not loaded & {"numpy", "numba", "scipy", "matplotlib", "xarray", "msgspec", "trimesh"}
    ours = {name for name in loaded if name.partition(".")[0] == "octant"}
    assert own is None or ours == own


def column(path, name):
    """Return one column of a CSV file with the numbers that its text means exactly."""
    with path.open(newline="") as file:
        return [float(row[name]) for row in csv.DictReader(file)]


def face_room():
    return octant.Room.box(
        (4.0, 3.0, 2.5),
        "brick",
        objects=[{"kind": "cabinet", "size_m": (0.5, 0.5, 1.0), "position_m": (3.0, 2.0, 0.0)}],
    )


SOLVER = {"max_reflections": 2, "diffraction": True}


def test_paths_equal_the_command_to_the_bit(study_file, tmp_path):
    out_csv = tmp_path / "paths.csv"
    ends = ["--tx", "1,1,2.3", "--rx", "3.5,0.4,0.3", "--rx", "0.4,2.5,1.1"]
    assert run(["paths", str(study_file), *ends, "--csv", str(out_csv), "-q"]) == 0
    places = [(3.5, 0.4, 0.3), (0.4, 2.5, 1.1)]
    tag = octant.Tag("A", (1.0, 1.0, 2.3), antenna="dipole")
    found = face_room().paths(tag, places, solver=SOLVER)
    found.to_csv(tmp_path / "face.csv")
    assert (tmp_path / "face.csv").read_bytes() == out_csv.read_bytes()
    again = octant.Study.load(study_file).paths((1, 1, 2.3), places)
    pd.testing.assert_frame_equal(again.to_dataframe(), found.to_dataframe(), check_exact=True)


def test_explain_equals_the_command_to_the_bit(study_file, tmp_path, capsys):
    out_csv = tmp_path / "budget.csv"
    ends = ["--tx", "1,1,2.3", "--rx", "3.5,0.4,0.3", "--path", "3"]
    assert run(["explain", str(study_file), *ends, "--csv", str(out_csv), "-q"]) == 0
    found = face_room().paths((1.0, 1.0, 2.3), (3.5, 0.4, 0.3), solver=SOLVER).explain(3)
    assert capsys.readouterr().out == "\n".join(found.lines()) + "\n"
    assert column(out_csv, "change_db") == found.to_dataframe()["change_db"].tolist()


@pytest.mark.filterwarnings(QUIET)
def test_maps_and_rss_equal_the_commands_to_the_bit(study_file, tmp_path):
    out, poses, out_csv = tmp_path / "map.nc", tmp_path / "poses.csv", tmp_path / "rss.csv"
    poses.write_text("x_m,y_m,heading_deg\n0.5,0.7,10\n2.0,1.5,200\n")
    assert run(["map", str(study_file), "--out", str(out), "--local-mean", "--spreads", "-q"]) == 0
    call = ["--tag", "A", "--poses", str(poses), "--csv", str(out_csv), "-q"]
    assert run(["rss", str(study_file), *call]) == 0
    reader = octant.Reader(response="isolated", antennas=6)
    room, tag = face_room(), octant.Tag("A", (1.0, 1.0, 2.3), antenna="dipole")
    made = room.rss_map(
        [tag],
        reader,
        spacing_m=0.5,
        heading_deg=120.0,
        local_mean=True,
        spreads=True,
        solver=SOLVER,
        progress=False,
    )
    for name, values in read_dataset(out).variables.items():
        np.testing.assert_array_equal(made[name].to_numpy(), values.to_numpy(), name)
        assert made[name].attrs["units"] == values.attrs["units"]
    rss = room.rss([tag], reader, [(0.5, 0.7, 10), (2.0, 1.5, 200)], solver=SOLVER)
    table = [column(out_csv, f"rss_{i + 1}_w") for i in range(6)]
    assert rss["rss_w"].to_numpy()[0].T.tolist() == table


@pytest.mark.slow
@pytest.mark.filterwarnings(QUIET)
def test_readers_equal_the_command_to_the_bit(study_file, tmp_path):
    out = tmp_path / "out"
    assert run(["reader", str(study_file), "--out", str(out), "--step-deg", "30", "-q"]) == 0
    solved = octant.Reader(response="isolated", antennas=6).solve(step_deg=30, progress=False)
    stored = read_dataset(out / "reader.nc")
    made = solved.dataset()
    for name, values in stored.variables.items():
        np.testing.assert_array_equal(made[name].to_numpy(), values.to_numpy(), name)
    solved.to_ffe(tmp_path / "face")
    for file in (tmp_path / "face").iterdir():
        assert file.read_bytes() == (out / file.name).read_bytes()


@pytest.mark.filterwarnings(QUIET)
def test_missions_equal_the_command_to_the_bit(study_file, tmp_path):
    assert run(["navigate", str(study_file), "--out", str(tmp_path / "out"), "-q"]) == 0
    mission = octant.Mission(
        face_room(),
        [octant.Tag("A", (1.0, 1.0, 2.3), antenna="dipole")],
        octant.Reader(response="isolated", antennas=6),
        start=(2.0, 1.0, 120.0),
        navigator="thesis",
        solver=SOLVER,
    )
    found = mission.run(2, seed=1, progress=False)
    found.to_csv(tmp_path)
    found.to_mcap(tmp_path / "run.mcap", run=1)
    found.to_tum(tmp_path / "run.tum", run=1)
    found.to_glb(tmp_path / "run.glb", run=1)
    way = np.loadtxt(tmp_path / "run.tum")[:, 1:3]
    np.testing.assert_array_equal(way, found.results[1].poses[:, :2])
    assert "trajectory run 1" in trimesh.load(tmp_path / "run.glb").graph.nodes_geometry
    with AnyReader([tmp_path / "run.mcap"]) as bag:
        assert bag.topics["/ground_truth/pose"].msgcount == len(way)
    for name in ("missions.csv", "trajectory.csv"):
        assert (tmp_path / name).read_bytes() == (tmp_path / "out" / name).read_bytes()


def test_what_a_study_file_says_the_face_says(study_file, tmp_path):
    said = octant.Study(
        face_room(),
        tags=[octant.Tag("A", (1.0, 1.0, 2.3), antenna="dipole")],
        reader=octant.Reader(response="isolated", antennas=6),
        solver=SOLVER,
        map={"spacing_m": 0.5},
        mission={
            "start_m": (2.0, 1.0),
            "heading_deg": 120.0,
            "tags": ["A"],
            "navigator": "thesis",
            "runs": 2,
        },
    )
    assert said == octant.Study.load(study_file)
    text = said.to_toml(tmp_path / "again.toml")
    assert octant.Study.load(tmp_path / "again.toml") == said
    assert tomllib.loads(text)["reader"]["antennas"] == 6


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: octant.Room.box((5, 4, 3), "concret"), "did you mean 'concrete'"),
        (lambda: octant.Reader(plate_hight_m=0.1), "did you mean 'plate_height_m'"),
        (lambda: octant.Tag("1", (9, 9)), "a list of 3 is needed"),
        (lambda: octant.Room.load("nothing.glb", unit="m"), "give an existing file"),
        (lambda: octant.Room.box((5, 4, 3)).paths((1, 1), (2, 2, 2)), "give a Tag"),
        (lambda: octant.Room.box((5, 4, 3)).paths((9, 9, 9), (2, 2, 2)), "outside the room"),
        (lambda: octant.Room.box((5, 4, 3)).audit(), "nothing to audit"),
        (lambda: octant.Room.box((5, 4, 3)).rss_map([(1, 1, 1)]), "octant.Tag is needed"),
        (lambda: octant.Room.box((5, 4, 3)).rss_map([], octant.Reader()), "nothing that transmits"),
        (lambda: octant.sweep(octant.Reader(), {}), "no parameter is swept"),
        (lambda: octant.sweep(octant.Reader(), {"gap": [1.0]}), "did you mean 'gap_m'"),
        (
            lambda: octant.Reader(response="isolated").solve(step_deg=30, progress=False).s,
            "gives patterns only",
        ),
    ],
)
@pytest.mark.filterwarnings(QUIET)
def test_mistakes_are_refused_in_one_sentence(call, words):
    with pytest.raises(ConfigError) as error:
        call()
    assert words in str(error.value)


def test_progress_is_silent_when_asked(capsys):
    room = octant.Room.box((2, 2, 2))
    tag = octant.Tag("1", (1, 1, 1.9), antenna="dipole")
    solver = {"max_reflections": 0}
    room.rss_map([tag], spacing_m=1.0, solver=solver, progress=False)
    assert capsys.readouterr().err == ""
    room.rss_map([tag], spacing_m=1.0, solver=solver)
    assert "tag 1" in capsys.readouterr().err


def test_a_failing_score_is_said_and_kept_apart(tmp_path):
    reader = octant.Reader(response="isolated", plate_height_m=0.0)
    swept = octant.sweep(
        reader,
        {"antennas": [4, 6]},
        score=_only_four,
        store=tmp_path,
        progress=False,
    )
    assert swept["fours"].to_numpy()[0] == 4.0
    assert np.isnan(swept["fours"].to_numpy()[1])
    assert "six" in str(swept["failed_because"].to_numpy()[1])


def _only_four(study):
    if study.reader.antennas != 4:
        msg = "six is too many."
        raise ConfigError(msg)
    return {"fours": study.reader.antennas}


def test_a_tag_that_the_reader_wakes_and_the_table_that_says_how():
    tag = octant.Tag("P", (0.0, 0.0, 1.6), kind="passive", mismatch_loss_db=1.0, antenna="dipole")
    assert tag.kind == "passive"
    assert tag.replaced({"kind": "semi_passive"}).mismatch_loss_db == 1.0
    room = octant.Room.free_space()
    options = {"spacing_m": 4.0, "height_m": 1.5, "frequency_hz": 868e6, "progress": False}
    data = room.rss_map([tag], rfid={"region": "etsi"}, margin_m=20.0, **options)
    awake = data["wake_margin_db"].to_numpy()[0] >= 0.0
    assert 0 < awake.sum() < awake.size
    assert ((data["rss_w"].to_numpy()[0] > 0.0) == awake).all()
    assert float(data["chip_power_dbm"].max()) > -18.0
    with pytest.raises(ConfigError, match=r"no table \[rfid\]"):
        room.rss_map([tag], **options)


@pytest.mark.filterwarnings("ignore::octant.geometries.errors.PhysicsWarning")
def test_a_mission_is_driven_by_the_robot_that_is_given():
    tag = octant.Tag("1", (1.5, 1.0, 2.0), antenna="dipole")
    reader = octant.Reader(response="isolated")
    car = {"kinematics": "car", "wheelbase_m": 0.3, "steering_limit_deg": 40.0}
    mission = octant.Mission(octant.Room.free_space(), [tag], reader, start=(0, 0, 90), robot=car)
    assert mission.study.robot.kinematics == "car"
    with pytest.raises(ConfigError, match="wheelbase_m is not given"):
        octant.Mission(
            octant.Room.free_space(), [tag], reader, start=(0, 0), robot={"kinematics": "car"}
        )
