"""CSV columns are found by name; what cannot be read is named by file and line."""

import numpy as np
import pytest

from octant.geometries.errors import ConfigError
from octant.reader_design.showing.tables import put_table, read_columns


def file_with(tmp_path, text):
    path = tmp_path / "poses.csv"
    path.write_text(text)
    return path


def test_columns_are_found_by_name_in_any_order(tmp_path):
    path = file_with(tmp_path, "\ufeffnote, y_m, x_m\na,2,1\n\nb,-4e-1, 3\n")
    np.testing.assert_array_equal(read_columns(path, ["x_m", "y_m"]), [[1.0, 2.0], [3.0, -0.4]])


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("x_m,z_m\n1,2\n", r"poses.csv:1: .*'y_m'"),
        ("x_m,y_m\n1,2\n3,four\n", r"poses.csv:3: y_m is 'four'"),
        ("x_m,y_m\n1\n", r"poses.csv:2: y_m is ''"),
        ("x_m,y_m\n1,nan\n", r"poses.csv:2: y_m is 'nan'"),
        ("x_m,y_m\n", "no rows"),
        ("", "'x_m'"),
    ],
)
def test_unreadable_tables_are_refused_with_file_and_line(tmp_path, text, match):
    with pytest.raises(ConfigError, match=match):
        read_columns(file_with(tmp_path, text), ["x_m", "y_m"])


def test_missing_tables_are_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"none\.csv"):
        read_columns(tmp_path / "none.csv", ["x_m"])


def test_floats_are_written_with_the_digits_that_read_back(tmp_path):
    values = np.array([0.1 + 0.2, 1e-300, np.pi])
    path = tmp_path / "t.csv"
    put_table(str(path), ["a", "b", "c"], [values], force=False)
    np.testing.assert_array_equal(read_columns(path, ["a", "b", "c"])[0], values)
    put_table(str(path), ["n", "t"], [(np.int64(3), "a,b")], force=True)
    assert path.read_text() == 'n,t\n3,"a,b"\n'


def test_tables_go_to_stdout_unless_a_file_is_named(tmp_path, capsys):
    put_table(None, ["a"], [[1]], force=False)
    assert capsys.readouterr().out == "a\n1\n"
    put_table(str(tmp_path / "t.csv"), ["a"], [[1]], force=False)
    assert (tmp_path / "t.csv").read_text() == "a\n1\n"
    with pytest.raises(ConfigError, match="--force"):
        put_table(str(tmp_path / "t.csv"), ["a"], [[2]], force=False)
