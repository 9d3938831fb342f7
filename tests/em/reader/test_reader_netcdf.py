"""reader.nc: the layout that other programs read, and back."""

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from octant.em.reader.reader_netcdf import read_reader_netcdf, reader_dataset
from octant.em.reader.response import sector_response
from octant.geometries.errors import PatternFileError

F_HZ = 2.4e9
AZIMUTHS = np.arange(8) * np.pi / 4
SECTOR = sector_response(AZIMUTHS, frequency_hz=F_HZ)
Z = 50.0 + 1j * np.arange(8)
S = (np.arange(64) * (0.01 - 0.02j)).reshape(8, 8)


def written(path, **options):
    reader_dataset(SECTOR, **options).to_netcdf(path, engine="h5netcdf")
    return path


@pytest.fixture
def path(tmp_path):
    return written(tmp_path / "reader.nc", impedance_ohm=Z, s_matrix=S)


def test_the_file_has_the_promised_variables_with_units(path):
    with xr.open_dataset(path) as data:
        assert data["pattern"].dims == ("antenna", "component", "theta", "phi", "part")
        assert data["impedance_ohm"].dims == ("antenna", "part")
        assert data["s_matrix"].dims == ("antenna", "antenna_2", "part")
        np.testing.assert_allclose(data["theta_deg"][[0, -1]], [0.0, 180.0], atol=1e-12)
        np.testing.assert_allclose(data["phi_deg"][[0, -1]], [0.0, 360.0], atol=1e-12)
        assert list(data["component"].to_numpy()) == ["theta", "phi"]
        assert list(data["part"].to_numpy()) == ["re", "im"]
        for name in data.variables:
            assert data[name].attrs["units"], name
            assert data[name].attrs["long_name"], name
        np.testing.assert_array_equal(data["impedance_ohm"][:, 1], Z.imag)
        np.testing.assert_array_equal(data["s_matrix"][3, 5], [S[3, 5].real, S[3, 5].imag])
        np.testing.assert_array_equal(data["pattern"][..., 0, :], data["pattern"][..., -1, :])


def test_the_pattern_has_its_phase_at_the_readers_centre(path):
    with xr.open_dataset(path) as data:
        row = int(np.argmin(np.abs(data["theta_deg"].to_numpy() - 90.0)))
        f = data["pattern"][2, 0, row].to_numpy() @ [1.0, 1.0j]
        phi = np.radians(data["phi_deg"].to_numpy())
    direct = SECTOR.far_field(np.pi / 2, phi)[2, :, 0]
    np.testing.assert_allclose(f, direct, atol=1e-12)


def test_a_response_comes_back(path):
    back = read_reader_netcdf(path)
    np.testing.assert_allclose(back.pattern, SECTOR.pattern, atol=1e-14)
    np.testing.assert_allclose(back.azimuths_rad, SECTOR.azimuths_rad, rtol=1e-15)
    np.testing.assert_array_equal(back.phase_centres_m, SECTOR.phase_centres_m)
    assert (back.model, back.frequency_hz) == (SECTOR.model, SECTOR.frequency_hz)
    assert back.warnings == SECTOR.warnings


def test_another_step_may_be_chosen(tmp_path):
    written(tmp_path / "a.nc", step_deg=5.0)
    with xr.open_dataset(tmp_path / "a.nc") as data:
        assert data["pattern"].shape == (8, 2, 37, 73, 2)
        assert "s_matrix" not in data
    back = read_reader_netcdf(tmp_path / "a.nc")
    at = (1.0, np.linspace(0, 6, 50))
    np.testing.assert_allclose(back.far_field(*at), SECTOR.far_field(*at), atol=3e-4)


@pytest.mark.parametrize(
    "options",
    [{"impedance_ohm": Z[:7]}, {"s_matrix": S[:7]}, {"step_deg": 7.0}, {"step_deg": -1.0}],
)
def test_wrong_shapes_and_steps_are_refused(options):
    with pytest.raises(PatternFileError, match=next(iter(options))):
        reader_dataset(SECTOR, **options)


@pytest.mark.parametrize("name", ["pattern", "frequency_hz", "theta_deg", "phi_deg"])
def test_a_missing_variable_is_named(name, path):
    with xr.open_dataset(path) as data:
        data.load().drop_vars(name).to_netcdf(path.with_name("b.nc"), engine="h5netcdf")
    with pytest.raises(PatternFileError, match=rf"b\.nc: variable '{name}' is missing"):
        read_reader_netcdf(path.with_name("b.nc"))


def test_a_wrong_dimension_or_grid_is_refused(path):
    with xr.open_dataset(path) as opened:
        data = opened.load()
    data.rename_dims(theta="elevation").to_netcdf(path.with_name("b.nc"), engine="h5netcdf")
    with pytest.raises(PatternFileError, match=r"b\.nc cannot be read"):
        read_reader_netcdf(path.with_name("b.nc"))
    data.isel(theta=slice(0, 50)).to_netcdf(path.with_name("c.nc"), engine="h5netcdf")
    with pytest.raises(PatternFileError, match="uniform"):
        read_reader_netcdf(path.with_name("c.nc"))


@given(share=st.floats(0.0, 0.98))
def test_a_truncated_file_is_refused(share, path):
    whole = path.read_bytes()
    cut = path.with_name("cut.nc")
    cut.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(PatternFileError, match=r"cut\.nc"):
        read_reader_netcdf(cut)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(PatternFileError, match=r"none\.nc cannot be read"):
        read_reader_netcdf(tmp_path / "none.nc")
