"""Results are written once, and again when their inputs change, a file is missing, or by force."""

import pytest

from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.results import write_once


@pytest.fixture
def write(tmp_path, capsys):
    stamp = tmp_path / "cases" / "finished.json"
    written = []

    def once(inputs, *, force=False):
        def results():
            written.append(inputs)
            (tmp_path / "table.csv").write_text(str(inputs))
            return [tmp_path / "table.csv"]

        stamp.parent.mkdir(exist_ok=True)
        return write_once(stamp, inputs, results, force=force, progress=Progress(quiet=False))

    once.written, once.table, once.stamp, once.said = (
        written, tmp_path / "table.csv", stamp, lambda: capsys.readouterr().err,
    )  # fmt: skip
    return once


def test_equal_inputs_are_written_once_and_the_second_time_says_so(write):
    assert write([1, "a"])
    assert not write([1, "a"])
    assert write.written == [[1, "a"]]
    assert "complete already; nothing was written." in write.said()


def test_force_other_inputs_a_missing_file_and_a_damaged_stamp_write_again(write):
    write(1)
    assert write(1, force=True)
    assert write(2)
    write.table.unlink()
    assert write(2)
    write.stamp.write_text("{")
    assert write(2)
    assert write.written == [1, 1, 2, 2, 2]


def test_results_whose_writing_failed_are_not_complete(write):
    write(1)

    def failing():
        raise OSError

    with pytest.raises(OSError):  # noqa: PT011  any
        write_once(write.stamp, 1, failing, force=True, progress=Progress(quiet=True))
    assert write(1)
