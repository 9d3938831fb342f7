"""Files are written whole or not at all, and never over what is there without --force."""

import pytest

from octant.geometries.errors import ConfigError
from octant.geometries.files import refuse_overwrite, whole_file, write_text


def test_failed_writes_leave_the_old_file_and_no_rubbish(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("old")

    def interrupted():
        with whole_file(path) as part:
            part.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert [p.name for p in tmp_path.iterdir()] == ["table.csv"]
    assert path.read_text() == "old"


def test_places_that_cannot_be_written_are_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="cannot be written"):
        write_text(tmp_path / "file" / "inside.txt", "x")


def test_places_inside_a_file_are_refused_before_any_work(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="is a file"):
        refuse_overwrite(tmp_path / "file" / "deep" / "x.nc", force=True)
    refuse_overwrite(tmp_path / "new" / "deep" / "x.nc", force=False)
