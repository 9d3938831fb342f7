"""Results keep their units, their provenance, and are whole or absent."""

import numpy as np
import pytest

from octant.geometries.errors import ConfigError
from octant.reader_design.showing import netcdf


def example(**extra):
    x = netcdf.variable(["x"], [0.0, 1.0], units="m", long_name="x in the room")
    variables = {
        "rss_w": netcdf.variable(["x"], [1e-9, 2e-9], units="W", long_name="received power"),
        "gain": netcdf.variable(["x"], [1 + 2j, 3 - 4j], units="1", long_name="complex gain"),
    }
    return netcdf.dataset(
        variables | extra, coordinates={"x": x}, study_toml="name = 1\n", seed=7, title="example"
    )


def test_round_trip_keeps_numbers_units_and_provenance(tmp_path):
    path = tmp_path / "deep" / "results.nc"
    netcdf.write_dataset(example(), path, force=False)
    again = netcdf.read_dataset(path)
    np.testing.assert_array_equal(again["rss_w"], [1e-9, 2e-9])
    assert again["rss_w"].attrs == {"units": "W", "long_name": "received power"}
    assert again.attrs["study"] == "name = 1\n"
    assert again.attrs["seed"] == 7
    assert again.attrs["numpy_version"] == np.__version__


def test_complex_numbers_are_stored_as_parts(tmp_path):
    path = tmp_path / "r.nc"
    netcdf.write_dataset(example(), path, force=False)
    again = netcdf.read_dataset(path)
    assert again["gain"].dims == ("x", "part")
    assert again["part"].to_numpy().tolist() == ["re", "im"]
    np.testing.assert_array_equal(again["gain"], [[1.0, 2.0], [3.0, -4.0]])


def test_variables_without_unit_or_name_are_refused(tmp_path):
    with pytest.raises(ValueError, match="long_name"):
        netcdf.variable(["x"], [1.0], units="W", long_name="")
    import xarray as xr

    with pytest.raises(ValueError, match="bare"):
        example(bare=xr.Variable(["x"], [1.0, 2.0]))
    with pytest.raises(ValueError, match="bare"):
        netcdf.write_dataset(
            example().assign(bare=("x", [1.0, 2.0])), tmp_path / "r.nc", force=True
        )
    assert list(tmp_path.iterdir()) == []


def test_existing_files_are_kept_without_force(tmp_path):
    path = tmp_path / "r.nc"
    path.write_text("mine")
    with pytest.raises(ConfigError, match="--force"):
        netcdf.write_dataset(example(), path, force=False)
    assert path.read_text() == "mine"
    netcdf.write_dataset(example(), path, force=True)
    assert float(netcdf.read_dataset(path)["rss_w"][1]) == 2e-9


def test_reading_what_is_no_result_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="does not exist"):
        netcdf.read_dataset(tmp_path / "none.nc")
    (tmp_path / "text.nc").write_text("no netCDF")
    with pytest.raises(ConfigError, match="not a netCDF4 file"):
        netcdf.read_dataset(tmp_path / "text.nc")
