"""Small netCDF files keep bits, and need units and coordinates."""

import io

import h5py
import numpy as np
import pytest

from octant.reader_design.keeping.small_netcdf import netcdf_bytes, read_netcdf


def test_small_netcdf_needs_units_and_coordinates_and_keeps_bits():
    stored = {
        "x": (["x"], np.array([1.0, np.nan]), "m", "place"),
        "word": (["x"], ["eins", "zwei µ"], "1", "words"),
        "empty": ([], np.float64(0.1), "W", "one number"),
    }
    data = netcdf_bytes(stored, {"note": "µ", "count": 3})
    assert data == netcdf_bytes(stored, {"note": "µ", "count": 3})
    arrays, attributes = read_netcdf(data)
    assert arrays["word"].tolist() == ["eins", "zwei µ"]
    np.testing.assert_array_equal(arrays["x"], [1.0, np.nan])
    with h5py.File(io.BytesIO(data)) as file:
        said = {name: "missing" in item.attrs for name, item in file.items()}
    assert said == {"x": True, "word": False, "empty": False}  # where NaN is, it has a meaning
    assert (arrays["empty"], attributes["note"], attributes["count"]) == (0.1, "µ", 3)
    with pytest.raises(ValueError, match="units"):
        netcdf_bytes({"x": (["x"], [1.0], "", "place")}, {})
    with pytest.raises(ValueError, match="coordinate"):
        netcdf_bytes({"y": (["x"], [1.0], "m", "place")}, {})
