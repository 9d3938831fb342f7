"""Mesh files with faults on the command line: finite numbers, or one sentence."""

import csv
import math

import numpy as np
import pytest

from octant.geometries.furniture import box
from octant.geometries.rooms import box_room

STUDY = """
name = "bad mesh"
[radio]
frequency_hz = 2.4e9
[room]
mesh = "room.obj"
unit = "m"
up = "z"
material = "concrete"
[[tag]]
id = "a"
position_m = [2.0, 1.5, 2.0]
antenna = "dipole"
[solver]
max_reflections = 2
diffraction = true
[map]
spacing_m = 0.5
"""
ENDS = ("--tx", "1,1,1.2", "--rx", "3,2,1.7", "--rx", "0,1.5,1", "--rx", "4,3,2.5")
EXPLAINED = ("--tx", "1,1,1.2", "--rx", "3,2,1.7")


def room_triangles():
    room = np.concatenate([body.triangles_m for body in box_room((4.0, 3.0, 2.5))])
    crate = box((1.0, 0.5, 0.8), position_m=(1.5, 1.2, 0.0), material="metal").triangles_m
    return np.concatenate((room, crate))


def spoilt(fault):
    triangles = room_triangles()
    flat = triangles[-12:].copy()
    if fault == "flat box":
        flat[..., 1] = 1.2
        return np.concatenate((triangles[:-12], flat))
    if fault == "inside out":
        return triangles[:, ::-1]
    if fault == "wound at random":
        odd = np.arange(len(triangles)) % 3 == 0
        return np.where(odd[:, None, None], triangles[:, ::-1], triangles)
    if fault == "given twice":
        return np.concatenate((triangles, triangles[::2, [1, 2, 0]]))
    if fault == "needles and points":
        needle = np.array([[[1.0, 1, 1], [2, 2, 2], [1.5, 1.5, 1.5]], [[9, 9, 9]] * 3])
        return np.concatenate((triangles, needle))
    if fault == "through a wall":
        return np.concatenate((triangles, flat + np.array([2.1, 1.7, 0.3])))
    if fault == "T-junctions":
        a, b, c = triangles[0]
        halves = np.array([[a, 0.5 * (a + b), c], [0.5 * (a + b), b, c]])
        return np.concatenate((triangles[1:], halves))
    if fault == "not a number":
        triangles[5, 1, 2] = math.nan
    if fault == "no area":
        return triangles[:, [0, 0, 1]]
    return triangles


@pytest.fixture
def study(study_file, tmp_path):
    def write(fault):
        triangles = spoilt(fault)
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in triangles.reshape(-1, 3).tolist()]
        lines += [f"f {k} {k + 1} {k + 2}" for k in range(1, 3 * len(triangles), 3)]
        (tmp_path / "room.obj").write_text("\n".join(lines) + "\n")
        return study_file(STUDY)

    return write


def rows(call):
    assert call.code == 0, call
    table = list(csv.DictReader(call.out.splitlines()))
    assert table
    return table


SOUND = (
    "flat box",
    "inside out",
    "wound at random",
    "given twice",
    "needles and points",
    "through a wall",
    "T-junctions",
)


@pytest.mark.parametrize("fault", SOUND)
def test_paths_in_a_faulty_mesh_are_finite_and_end_where_they_should(
    octant, study, fault, tmp_path
):
    table_file = tmp_path / "paths.csv"
    call = octant("paths", study(fault), *ENDS, "--csv", table_file)
    assert call.code == 0, call
    table = list(csv.DictReader(table_file.read_text().splitlines()))
    assert {row["rx"] for row in table} == {"0", "1", "2"}
    for row in table:
        numbers = [float(row[key]) for key in ("length_m", "gain_db", "phase_deg", "delay_ns")]
        assert all(math.isfinite(number) for number in numbers)
        assert "nan" not in row["vertices"]
    budget = octant("explain", study(fault), *EXPLAINED)
    assert budget.code == 0, budget
    assert "nan" not in budget.out


@pytest.mark.parametrize("fault", ["flat box", "wound at random", "needles and points"])
def test_a_map_of_a_faulty_mesh_is_finite(octant, study, fault, tmp_path):
    import xarray as xr

    call = octant("map", study(fault), "--isotropic", "--out", tmp_path / "map.nc")
    assert call.code == 0, call
    with xr.open_dataset(tmp_path / "map.nc", engine="h5netcdf") as stored:
        for name, values in stored.data_vars.items():
            if values.dtype.kind == "f":
                assert np.isfinite(values.values).any(), name
                assert not np.isposinf(values.values).any(), name


@pytest.mark.parametrize("fault", ["not a number", "no area"])
@pytest.mark.parametrize("verb", ["paths", "explain", "map"])
def test_a_mesh_that_cannot_be_used_is_refused(octant, study, fault, verb, tmp_path):
    options = ("--isotropic", "--out", tmp_path / "m.nc") if verb == "map" else EXPLAINED
    assert octant(verb, study(fault), *options).refused().endswith(".")
