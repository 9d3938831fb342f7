"""A log survives its CSV file to the bit, and a fault of a file is one sentence with its line."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra import numpy as hnp

from octant.geometries.errors import ConfigError, NavigationError
from octant.navigation.logs.cells import local_means
from octant.navigation.logs.log_csv import LOG_COLUMNS, read_log, write_log
from octant.navigation.logs.records import (
    _ROW_ARRAYS,
    Log,
    in_time_order,
    joined,
    of_ids,
    of_source,
    readings,
    repeats,
    taken,
)

TEXT = '''time_s,x_m,y_m,heading_deg,distance_m,turn_deg,id,antenna,rss_dbm,frequency_hz,floor
0,1,2,90,0,0,A,1,-50.5,2.402e9,tiles
0,1,2,90,0,0,A,2,-inf,2.402e9,tiles
0.5,,,,0.1,5,-,-,,,
1,1.1,2,95,0.1,5,B;1,-,,,"a, ""b"""
1,1.1,2,95,0,0,A,1,-60,2.480e9,
'''


def a_log(tmp_path, text=TEXT, **options):
    file = tmp_path / "log.csv"
    file.write_text(text)
    return read_log(file, **options)


def same(first, second):
    for name in _ROW_ARRAYS:
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name), err_msg=name)
    assert (first.ids, first.kept) == (second.ids, second.kept)


def test_a_row_says_what_was_heard_what_was_not_and_what_moved(tmp_path):
    log = a_log(tmp_path, threshold_dbm=-95.0)
    assert log.ids == ("A", "B;1")
    assert log.sources.tolist() == [0, 0, -1, 1, 0]
    assert log.antennas.tolist() == [1, 2, 0, 0, 1]
    assert log.heard.tolist() == [True, False, False, False, True]
    assert log.censored.tolist() == [False, True, False, True, False]
    assert np.isnan(log.rss_dbm[2])
    assert np.isnan(log.poses[2]).all()
    assert log.poses[0].tolist() == [1.0, 2.0, np.pi / 2]
    assert log.kept == {"floor": ("tiles", "tiles", "", 'a, "b"', "")}
    assert log.antenna_numbers == (0, 1, 2)
    assert log.threshold_dbm == -95.0


FINITE = st.floats(-1e6, 1e6, allow_nan=False)


@st.composite
def logs(draw):
    n = draw(st.integers(1, 6))

    def column(elements):
        return draw(hnp.arrays(np.float64, n, elements=st.one_of(elements, st.just(np.nan))))

    sources = draw(hnp.arrays(np.int64, n, elements=st.integers(-1, 1)))
    sources[0] = 0  # an id that no row names is not in the file
    levels = st.one_of(st.floats(-200, -1), st.just(-np.inf))
    level = draw(hnp.arrays(np.float64, n, elements=levels))
    signs = st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Zl", "Zp"))
    cells = st.text(signs, max_size=5)
    log = Log(
        ids=("0xFF,F9", 'a"b'),
        time_s=column(FINITE),
        poses=np.column_stack([column(FINITE), column(FINITE), np.radians(column(FINITE))]),
        sources=sources,
        antennas=draw(hnp.arrays(np.int64, n, elements=st.integers(0, 9))),
        rss_dbm=np.where(sources < 0, np.nan, level),
        frequency_hz=column(st.floats(1e6, 1e12)),
        distance_m=column(FINITE),
        turn_rad=np.radians(column(FINITE)),
        kept={"floor": tuple(draw(st.lists(cells, min_size=n, max_size=n)))},
    )
    return log if 1 in sources else of_ids(log, log.ids[:1])


@given(logs())
def test_a_written_log_reads_back_to_the_bit(tmp_path_factory, log):
    file = tmp_path_factory.mktemp("log") / "log.csv"
    write_log(file, log)
    back = read_log(file)
    same(of_ids(back, log.ids), log)
    write_log(file.with_name("again.csv"), back)
    assert file.with_name("again.csv").read_bytes() == file.read_bytes()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "log.csv is empty"),
        ("id,rss_dbm\n", "log.csv has no rows below its header"),
        ("id,rssi\nA,-50\n", "log.csv:1: has no column 'rss_dbm'; the nearest is 'rssi'"),
        ("id,rss_dbm,heading_rad\nA,-50,1\n", "log.csv:1: has the column 'heading_rad', but none"),
        ("id,rss_dbm,id\nA,-50,1\n", "log.csv:1: names the column 'id' twice"),
        ("# notes\nid,rss_dbm\n\nA,loud\n", "log.csv:4: rss_dbm is 'loud', but a finite number"),
        ("id,rss_dbm\nA,-50\n-,-50\n", "log.csv:3: rss_dbm is '-50', but the row has no id"),
        ("id,rss_dbm\nA,-50\nA,-999\n", "log.csv:3: rss_dbm is '-999', but a level from"),
        ("id,rss_dbm,antenna\nA,-50,1.5\n", "log.csv:2: antenna is '1.5', but a whole"),
        ("id,rss_dbm,antenna\nA,-50,0\n", "log.csv:2: antenna is '0', but a whole number from 1"),
        ("id,rss_dbm,frequency_hz\nA,-50,0\n", "log.csv:2: frequency_hz is '0', but a"),
        ("id,rss_dbm\nA,-50,3,4\n", "log.csv:2: has 4 cells, but the header names 2 columns"),
        ("id,rss_dbm\nA,1e-6\nA,3e-7\nA,2e-6\n", '= "mw", which makes 1e-06 a level of -60 dBm'),
        ("id,rss_dbm\nA,61\nA,70\nA,55\n", 'do; set log.rss_unit = "minus_dbm"'),
        ("id,rss_dbm\nA,100\nA,-61\nA,100\n", "100 in 67 % of all cells and negative elsewhere"),
    ],
)
def test_a_wrong_file_is_refused_in_one_sentence(tmp_path, text, said):
    with pytest.raises(ConfigError) as caught:
        a_log(tmp_path, text)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_semicolons_with_decimal_commas_are_the_same_log(tmp_path):
    plain = a_log(tmp_path, "time_s,id,rss_dbm,x_m\n0.5,A,-61.5,1.25\n")
    same(a_log(tmp_path, "time_s;id;rss_dbm;x_m\n0,5;A;-61,5;1,25\n"), plain)
    same(a_log(tmp_path, "time_s\tid\trss_dbm\tx_m\n0.5\tA\t-61.5\t1.25\n"), plain)


def test_all_columns_are_written_in_their_order(tmp_path):
    write_log(tmp_path / "out.csv", a_log(tmp_path))
    header, *rows = (tmp_path / "out.csv").read_text().splitlines()
    assert header == ",".join((*LOG_COLUMNS, "floor"))
    assert rows[2] == "0.5,,,,0.1,5.0,-,-,,,"


def test_a_source_that_reads_as_none_is_not_written(tmp_path):
    log = a_log(tmp_path)
    with pytest.raises(ConfigError, match="cannot tell from none"):
        write_log(tmp_path / "out.csv", of_ids(log, ("A", "-")))


def test_one_source_is_taken_out_by_its_name(tmp_path):
    log = a_log(tmp_path)
    assert of_source(log, "A").rss_dbm.tolist() == [-50.5, -np.inf, -60.0]
    with pytest.raises(NavigationError, match="did you mean 'A'"):
        of_source(log, "a")


def test_chosen_ids_take_new_indices_and_motion_stays(tmp_path):
    log = a_log(tmp_path)
    chosen = of_ids(log, ("none", "A"))
    assert chosen.sources.tolist() == [1, 1, -1, 1]
    assert len(readings(chosen)) == 3


def test_order_of_time_is_stable_and_keeps_odometry_whole(tmp_path):
    log = a_log(tmp_path, "time_s,id,rss_dbm\n2,A,-1\n1,A,-2\n2,A,-3\n,A,-4\n")
    assert in_time_order(log).rss_dbm.tolist() == [-2.0, -1.0, -3.0, -4.0]
    moved = a_log(tmp_path, "time_s,id,rss_dbm,distance_m\n2,A,-1,0\n1,A,-2,1\n")
    with pytest.raises(NavigationError, match="time falls from 2 s to 1 s after its row 1"):
        in_time_order(moved)


def test_repeats_are_the_same_reading_noted_twice(tmp_path):
    rows = ["1,A,-1,1", "1,A,-1,2", "1,A,-5,1", "2,A,-1,1", ",A,-1,1", ",A,-1,1", ""]
    log = a_log(tmp_path, "\n".join(["time_s,id,rss_dbm,antenna", *rows]))
    assert repeats(log).tolist() == [False, False, True, False, False, False]


def test_joined_logs_share_their_ids(tmp_path):
    log = a_log(tmp_path)
    both = joined([of_source(log, "B;1"), log])
    assert both.ids == ("A", "B;1")
    same(taken(both, np.arange(1, len(both))), log)


def test_local_means_are_those_of_what_was_heard_in_a_cell(tmp_path):
    rows = [
        ".1,.1,A,-50",
        ".3,.1,A,-54",
        ".2,.2,A,-inf",
        ".6,.1,A,-40",
        ".1,.1,B,-70",
        "-.1,.1,A,-inf",
    ]
    log = a_log(tmp_path, "\n".join(["x_m,y_m,id,rss_dbm", *rows, ",,A,-10"]))
    means, of_row = local_means(log, cell_m=0.5)
    assert means.mean_dbm.tolist() == [-52.0, -40.0, -70.0]
    assert means.sd_db[0] == pytest.approx(np.std([-50, -54], ddof=1))
    assert means.cells.tolist() == [[0, 0], [1, 0], [0, 0]]
    np.testing.assert_allclose(means.places[0], [0.2, 0.1])
    assert means.censored.tolist() == [1, 0, 0]
    assert of_row.tolist() == [0, 0, 0, 1, 2, -1, -1]
    assert len(local_means(log, cell_m=0.5, least=2)[0].mean_dbm) == 1
