"""NaN and infinity do not reach a file unless they say what they mean."""

import numpy as np
import pytest

from octant.geometries.errors import ResultError
from octant.navigation.csv_files import number_text
from octant.reader_design.showing.netcdf import dataset, variable, write_dataset
from octant.reader_design.showing.tables import csv_text


def written(path, values, units="1", **more):
    item = variable(["place", "antenna"], values, units=units, long_name="x", **more)
    data = dataset({"x": item}, study_toml="", seed=1, title="t")
    write_dataset(data, path, force=True)


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
def test_datasets_without_meaning_are_refused_with_the_place(tmp_path, wrong):
    values = np.zeros((3, 2))
    values[1, 1] = wrong
    with pytest.raises(ResultError, match=r"x has 1 values of 6 .* place 1, antenna 1"):
        written(tmp_path / "x.nc", values)
    assert not list(tmp_path.iterdir())


def test_what_is_missing_says_why_and_no_power_has_a_level(tmp_path):
    written(tmp_path / "x.nc", [[np.nan, 1.0]], missing="no path")
    written(tmp_path / "x.nc", [[-np.inf, 1.0]], units="dBm")


def test_tables_leave_the_cell_empty_and_refuse_infinity():
    assert csv_text(["a", "g_db"], [(np.nan, -np.inf)]) == "a,g_db\n,-inf\n"
    assert number_text(np.nan) == ""
    for value, column in ((np.inf, "g_db"), (-np.inf, "a")):
        with pytest.raises(ResultError):
            csv_text([column], [(float(value),)])
    with pytest.raises(ResultError):
        number_text(np.inf)
