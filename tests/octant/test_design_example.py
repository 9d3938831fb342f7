"""The Python example of the design document, line by line, on a real mesh file."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import octant

pytestmark = pytest.mark.filterwarnings("ignore::octant.geometries.errors.PhysicsWarning")

OFFICE = Path(__file__).parents[2] / "examples" / "l_shaped_office.glb"
STUDY = """
name = "short"
[room]
box_m = [3.0, 3.0, 2.5]
[[tag]]
id = "1"
position_m = [1.5, 1.5, 2.3]
antenna = "dipole"
[reader]
response = "isolated"
antennas = 4
[sweep]
antenna_radius_m = [0.05, 0.10]
[solver]
max_reflections = 1
[map]
spacing_m = 0.5
"""


@pytest.fixture
def place(tmp_path, monkeypatch):
    shutil.copy(OFFICE, tmp_path / "lab.glb")
    (tmp_path / "study.toml").write_text(STUDY)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def my_score(study):
    pattern = study.solve(step_deg=30, progress=False).pattern
    return float(np.abs(pattern).max())


@pytest.fixture
def room(place):
    assert place.is_dir()
    return octant.Room.load(
        "lab.glb",
        unit="m",
        material="brick",
        materials={"outer_walls": "concrete", "cabinet": "metal"},
    )


@pytest.fixture
def tag():
    return octant.Tag("0xFFF9", (2.0, 0.5, 2.95), antenna="dipole", power_w=1.0)


def test_room(room):
    assert "52 pieces of free border" in repr(room.audit())
    assert room.plot().axes
    assert repr(room).startswith("<Room: 7 x 6 x 3 m, 7 bodies, 718 triangles: ")
    assert "<img" in room._repr_html_()
    assert repr(octant.Room.box((5, 5, 3), "concrete")).startswith("<Room: 5 x 5 x 3 m")


def test_paths(room, tag):
    paths = room.paths(tx=tag, rx=(1.0, 1.0, 0.3), frequency_hz=2.4e9, max_reflections=3)
    table = paths.to_dataframe()
    assert len(table) == len(paths) > 20
    assert list(table.columns[:4]) == ["rx", "path", "order", "interactions"]
    assert "line of sight" in repr(paths.explain(0))
    total = paths.explain(0).to_dataframe()["change_db"].sum()
    assert total == pytest.approx(table["gain_db"][0], abs=1e-9)
    assert paths.plot().axes
    assert paths.data["gain"].attrs["units"] == "1"
    assert paths.received["coherent_db"].attrs["units"] == "dB"


def test_map(room, tag):
    reader = octant.Reader(antenna_radius_m=0.10, plate_height_m=0.08, response="isolated")
    rss = room.rss_map(
        [tag],
        reader,
        spacing_m=1.0,
        antennas=[1, 3],
        heading_deg=[0.0, 90.0],
        solver={"max_reflections": 1},
        progress=False,
    )
    assert rss["rss_w"].dims == ("heading", "tag", "x", "y", "antenna")
    assert rss["rss_w"].attrs["units"] == "W"
    assert rss["rss_dbm"].attrs["units"] == "dBm"
    assert rss["antenna"].to_numpy().tolist() == [1, 3]
    # A quarter turn of the robot puts antenna 3 where antenna 1 was.
    one = rss["rss_w"].sel(heading=90.0, antenna=1).to_numpy()
    three = rss["rss_w"].sel(heading=0.0, antenna=3).to_numpy()
    np.testing.assert_allclose(one, three, rtol=1e-9)


@pytest.mark.slow
def test_mission_sweep_and_study(room, tag, place):
    reader = octant.Reader(response="isolated")
    mission = octant.Mission(room, [tag], reader, start=(0.0, 0.0, 90.0), navigator="tracker")
    runs = mission.run(2, seed=1, progress=False)
    assert runs.success.shape == (2,)
    assert runs.trajectory(0)["x"].attrs["units"] == "m"
    assert "data:image/gif" in runs.animate(0)._repr_html_()
    swept = {"plate_height_m": [0.0, 0.08, 0.15]}
    once = octant.sweep(
        reader, swept, score=my_score, room=room, tags=[tag], store="dir", progress=False
    )
    files = {path: path.stat().st_mtime_ns for path in place.glob("dir/*")}
    again = octant.sweep(
        reader, swept, score=my_score, room=room, tags=[tag], store="dir", progress=False
    )
    assert once.identical(again)
    assert files == {path: path.stat().st_mtime_ns for path in place.glob("dir/*")}
    assert once["score"].dims == ("plate_height_m",)
    assert once["plate_height_m"].attrs["units"] == "m"


@pytest.mark.slow
def test_reader_by_full_wave(tmp_path):
    reader = octant.Reader(
        antenna_radius_m=0.10, plate_height_m=0.08, antennas=4, cells_per_wavelength=5.0
    )
    solved = reader.solve([2.40e9, 2.44e9], progress=False)
    assert solved.s.shape == (2, 4, 4)
    assert solved.z.attrs["units"] == "ohm"
    np.testing.assert_allclose(solved.s.values, solved.s.values.transpose(0, 2, 1), atol=1e-6)
    assert solved.pattern.dims == ("frequency", "antenna", "component", "theta", "phi")
    assert solved.to_touchstone(tmp_path / "reader.s1p").name == "reader.s4p"
    assert len(solved.to_ffe(tmp_path)) == 4
    assert solved.plot().axes


@pytest.mark.slow
@pytest.mark.usefixtures("place")
def test_a_study_runs_and_its_results_open():
    results = octant.Study.load("study.toml").run("out", quick=True, progress=False)
    assert results.report.is_file()
    again = octant.open_results("out")
    assert again.data.identical(results.data)
    assert "designs" in again.tables
    assert len(again.table("designs")) == 2
