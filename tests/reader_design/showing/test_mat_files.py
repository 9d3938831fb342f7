"""MAT files: what scipy loads is what the dataset holds."""

import numpy as np
import pytest
import xarray as xr
from scipy.io import loadmat

import octant
from octant.reader_design.showing.mat_files import write_mat
from octant.reader_design.showing.netcdf import variable, write_dataset


def test_complex_numbers_texts_and_units_come_back(tmp_path):
    rng = np.random.default_rng(1)
    parts = rng.normal(size=(3, 2, 2))
    data = xr.Dataset(
        {
            "s_matrix": variable(
                ["antenna", "antenna_2", "part"], parts, units="1", long_name="S-matrix"
            ),
            "reached": variable(["tag"], [True, False], units="1", long_name="reached"),
            "power": variable([], 2.5, units="W", long_name="power"),
        },
        coords={
            "tag": variable(["tag"], ["A", "0xFFF9"], units="1", long_name="tag"),
            "part": variable(["part"], ["re", "im"], units="1", long_name="part"),
        },
    )
    for name in ("a.mat", "b.mat"):
        write_mat(data, tmp_path / name)
    assert (tmp_path / "a.mat").read_bytes() == (tmp_path / "b.mat").read_bytes()
    back = loadmat(tmp_path / "a.mat")
    np.testing.assert_array_equal(back["s_matrix"], parts[..., 0] + 1j * parts[..., 1])
    np.testing.assert_array_equal(back["reached"].ravel(), [1, 0])
    assert [str(cell[0][0]) for cell in back["tag"]] == ["A", "0xFFF9"]
    assert back["power"].item() == 2.5
    assert back["units"]["power"].item()[0] == "W"
    assert back["dimensions"]["s_matrix"].item()[0] == "antenna, antenna_2"
    assert "part" not in back


def test_results_of_a_folder_are_written_too(tmp_path):
    data = xr.Dataset(
        {"score": variable(["design"], [1.0, 2.0], units="dB", long_name="score")},
        attrs={"title": "a"},
    )
    data["score"].attrs["missing"] = "none"
    write_dataset(data, tmp_path / "results.nc", force=True)
    octant.open_results(tmp_path).to_mat(tmp_path / "results.mat")
    np.testing.assert_array_equal(loadmat(tmp_path / "results.mat")["score"].ravel(), [1.0, 2.0])


@pytest.mark.filterwarnings("ignore::octant.geometries.errors.PhysicsWarning")
def test_a_solved_reader_is_written_with_complex_patterns(tmp_path):
    solved = octant.Reader(response="isolated", antennas=4).solve(2.4e9, progress=False)
    solved.to_mat(tmp_path / "reader.mat")
    back = loadmat(tmp_path / "reader.mat")
    wanted = solved.dataset()["pattern"].to_numpy()
    np.testing.assert_array_equal(back["pattern"], wanted[..., 0] + 1j * wanted[..., 1])
