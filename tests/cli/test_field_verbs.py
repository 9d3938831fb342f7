"""``map``, ``rss`` and ``navigate`` on small problems; ``materials`` and ``audit``."""

import csv
import io
import math

import msgspec
import numpy as np
import pytest
import trimesh

from octant.reader_design.showing.netcdf import read_dataset
from octant.reader_design.study_file.loading import load_study

FREE = """
name = "free"
[room]
free_space = true
[[tag]]
id = "near"
position_m = [2.0, 0.5, 3.0]
antenna = "dipole"
[[tag]]
id = "far"
position_m = [3.5, 2.0, 3.0]
antenna = "dipole"
[reader]
response = "isolated"
[map]
spacing_m = 0.5
[mission]
navigator = "thesis"
start_m = [0.0, 0.0]
tags = ["near"]
max_time_s = 20.0
runs = 2
"""
BOX = FREE.replace("free_space = true", "box_m = [7, 7, 3]\norigin_m = [-1, -1, 0]")
WAVELENGTH_M = 299_792_458.0 / 2.4e9


def dipole(theta):
    """Field pattern of a half-wave dipole of gain 1.6409."""
    return 1.640922376984585**0.5 * np.cos(0.5 * np.pi * np.cos(theta)) / np.sin(theta)


def test_rss_of_isolated_dipoles_in_free_space_is_friis(octant, study_file, tmp_path):
    poses = tmp_path / "poses.csv"
    poses.write_text("x_m,y_m,heading_deg\n0,0,90\n1,1,-30\n")
    out = tmp_path / "rss.csv"
    call = octant("rss", study_file(FREE), "--tag", "near", "--poses", poses, "--csv", out)
    assert call.code == 0, call.err
    assert call.out == ""
    rows = list(csv.DictReader(io.StringIO(out.read_text())))
    assert list(rows[0]) == ["x_m", "y_m", "heading_deg", *(f"rss_{i}_w" for i in range(1, 9))]
    # Seen from the reader's centre all eight antennas have the same level.
    for row, place in zip(rows, [(0, 0, 0.3), (1, 1, 0.3)], strict=True):
        ray = np.array([2.0, 0.5, 3.0]) - place
        distance = np.linalg.norm(ray)
        theta = math.acos(ray[2] / distance)
        friis = (WAVELENGTH_M / (4 * math.pi * distance)) ** 2 * dipole(theta) ** 4
        levels = [float(row[f"rss_{i}_w"]) for i in range(1, 9)]
        np.testing.assert_allclose(levels, friis, rtol=1e-3)
    assert (rows[1]["x_m"], rows[1]["heading_deg"]) == ("1.0", "-30.0")


def test_readings_are_those_of_the_sensor_and_its_noise(octant, study_file, tmp_path):
    poses = tmp_path / "poses.csv"
    poses.write_text("x_m,y_m,heading_deg\n0,0,90\n1,1,-30\n")
    call = ("--tag", "near", "--poses", poses, "-q")
    exact = table_of(octant("rss", study_file(FREE), *call).out)
    many = ("--readings", "400", "--noise-db", "2")
    read = table_of(octant("rss", study_file(FREE), *call, *many).out)
    assert read.dtype.names == (*exact.dtype.names, "reading")
    for pose in range(2):
        mine = read[400 * pose : 400 * (pose + 1)]
        assert (mine["reading"] == np.arange(400)).all()
        off_db = 10.0 * np.log10(mine["rss_3_w"] / exact["rss_3_w"][pose])
        assert off_db.std() == pytest.approx(2.0, rel=0.15)
        assert off_db.mean() == pytest.approx(0.0, abs=0.4)
    again = table_of(octant("rss", study_file(FREE), *call, *many).out)
    other = table_of(octant("rss", study_file(FREE), *call, *many, "--seed", "9").out)
    assert (again == read).all()
    assert (other["rss_1_w"] != read["rss_1_w"]).all()
    # Codes of 3 bits from -60 to -20 dBm, without noise: seven steps, rounded.
    coded = FREE + "[sensor]\nbits = 3\nfloor_dbm = -60.0\nfull_scale_dbm = -20.0\n"
    codes = table_of(octant("rss", study_file(coded), *call, *many[:2], "--noise-db", "-0").out)
    level = 10.0 * np.log10(codes["rss_1_w"]) + 30.0
    steps = (level + 60.0) / (40.0 / 7.0)
    assert steps == pytest.approx(np.round(steps))
    assert "--readings" in octant("rss", study_file(FREE), *call, "--seed", "1").refused()


def table_of(text):
    return np.genfromtxt(io.StringIO(text), delimiter=",", names=True)


def test_rss_without_csv_goes_to_stdout(octant, study_file, tmp_path):
    poses = tmp_path / "poses.csv"
    poses.write_text("heading_deg,x_m,y_m\n0,1,2\n")
    call = octant("rss", study_file(FREE), "--tag", "far", "--poses", poses, "--quiet")
    assert call.out.startswith("x_m,y_m,heading_deg,rss_1_w,")
    assert call.out.splitlines()[1].startswith("1.0,2.0,0.0,")
    assert all(line.startswith("warning: ") for line in call.err.splitlines())


def test_isotropic_map_of_free_space_is_friis(octant, study_file, tmp_path):
    out = tmp_path / "map.nc"
    call = octant(
        "map", study_file(FREE), "--out", out, "--isotropic", "--local-mean", "--tag", "far"
    )
    assert call.code == 0, call.err
    data = read_dataset(out)
    assert data["rss_w"].dims == ("tag", "x", "y")
    assert data["tag"].to_numpy().tolist() == ["far"]
    x, y = np.meshgrid(data["x"], data["y"], indexing="ij")
    across = np.hypot(x - 3.5, y - 2.0)
    distance = np.hypot(across, 2.7)
    gain = dipole(np.arctan2(np.maximum(across, 1e-12), -2.7)) ** 2
    expected = (WAVELENGTH_M / (4 * math.pi * distance)) ** 2 * gain
    np.testing.assert_allclose(data["rss_w"][0], expected, rtol=1e-9, atol=1e-25)
    np.testing.assert_allclose(data["rss_local_mean_w"], data["rss_w"], rtol=1e-12)
    assert (data["path_count"] == 1).all()
    assert data.attrs["receiver"] == "isotropic_theta"
    assert float(data["z"]) == 0.3


def test_reader_map_holds_every_tag_and_antenna_and_the_study(octant, study_file, tmp_path):
    study, out = study_file(BOX), tmp_path / "map.nc"
    call = octant("map", study, "--out", out)
    assert call.code == 0, call.err
    assert "tag 'near' at (2, 0.5, 3) m lies on a surface" in call.err
    data = read_dataset(out)
    assert dict(data.sizes) == {"tag": 2, "x": 14, "y": 14, "antenna": 8}
    assert float(data["x"][0]) == pytest.approx(-0.75)
    assert data["antenna"].to_numpy().tolist() == list(range(1, 9))
    assert all("units" in v.attrs and "long_name" in v.attrs for v in data.variables.values())
    assert (data["path_count"] == 63).all()
    again = tmp_path / "again.toml"
    again.write_text(data.attrs["study"])
    assert load_study(again) == load_study(study)
    single = tmp_path / "single.nc"
    assert octant("map", study, "--out", single, "--antenna", "3", "--tag", "far").code == 0
    one = read_dataset(single)
    np.testing.assert_array_equal(
        one["rss_w"].sel(tag="far", antenna=3), data["rss_w"].sel(tag="far", antenna=3)
    )


def test_navigate_writes_what_it_promises_and_repeats_itself(octant, study_file, tmp_path):
    study = study_file(FREE)
    first, second = tmp_path / "a", tmp_path / "b"
    call = octant("navigate", study, "--out", first, "--noise-db", "0.5")
    assert call.code == 0, call.err
    assert "of 2 runs reached every tag" in call.out
    missions = list(csv.DictReader(io.StringIO((first / "missions.csv").read_text())))
    assert list(missions[0])[:4] == ["run", "success", "time_s", "path_m"]
    assert [m["run"] for m in missions] == ["0", "1"]
    trajectory = list(csv.DictReader(io.StringIO((first / "trajectory.csv").read_text())))
    assert list(trajectory[0]) == [
        *["t_s", "x_m", "y_m", "heading_deg", "mode", "target"],
        *(f"rss_{i}_w" for i in range(1, 9)),
    ]
    assert (trajectory[0]["x_m"], trajectory[0]["heading_deg"]) == ("0.0", "90.0")
    assert sorted(p.name for p in (first / "figures").iterdir()) == [
        "membership.png",
        "percentiles.png",
        "rss.png",
        "trajectory.png",
    ]
    stored, given = load_study(first / "study.toml"), load_study(study)
    noisy = msgspec.structs.replace(given.mission, noise_db=0.5)
    assert stored == msgspec.structs.replace(given, mission=noisy)
    assert octant("navigate", study, "--out", second, "--noise-db", "0.5", "-q").code == 0
    for name in ("missions.csv", "trajectory.csv"):
        assert (first / name).read_bytes() == (second / name).read_bytes()


def test_a_mesh_that_changed_changes_the_files_too(octant, study_file, tmp_path):
    """The study's text is the same: what says that everything is there must read the mesh."""
    mesh = 'mesh = "room.stl"\nunit = "m"\nmaterial = "concrete"'
    study, out = study_file(FREE.replace("free_space = true", mesh)), tmp_path / "out"
    tables = []
    for height_m in (3.4, 3.1, 3.1):
        room = trimesh.creation.box(bounds=[[-4.0, -4.0, 0.0], [4.0, 4.0, height_m]])
        room.invert()
        room.export(tmp_path / "room.stl")
        call = octant("navigate", study, "--out", out)
        assert call.code == 0, call.err
        tables.append((out / "trajectory.csv").read_bytes())
    assert tables[0] != tables[1]
    assert tables[1] == tables[2]
    assert "complete already" in call.err


def test_materials_at_the_default_frequency_are_those_of_the_recommendation(octant):
    call = octant("materials")
    concrete = next(line for line in call.out.splitlines() if line.startswith("concrete"))
    assert concrete.split()[1] == "5.24"
    assert float(concrete.split()[2]) == pytest.approx(0.0462 * 2.4**0.7822, rel=1e-3)
    assert any(line.split()[:3] == ["pec", "-", "infinite"] for line in call.out.splitlines())


def test_materials_outside_their_range_show_a_dash(octant):
    call = octant("materials", "--frequency-ghz", "0.3")
    concrete = next(line for line in call.out.splitlines() if line.startswith("concrete"))
    assert concrete.split()[1:3] == ["-", "-"]


def test_audit_reports_on_stdout(octant, tmp_path):
    from octant.geometries.furniture import box
    from octant.geometries.mesh_files import save_bodies

    save_bodies([box((1.0, 2.0, 3.0), material="wood")], tmp_path / "box.obj")
    call = octant("audit", tmp_path / "box.obj", "--unit", "m")
    assert (call.code, call.err) == (0, "")
    assert "12 triangles" in call.out
