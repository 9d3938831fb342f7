"""A study's log lies in the study's room and speaks of the study's tags, or is refused by name."""

from pathlib import Path

import numpy as np
import pytest

from octant.geometries.errors import ConfigError
from octant.reader_design.setting.measured import measured_log, with_log
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import parse_study, to_toml

ROOM = """
[room]
box_m = [6.0, 4.0, 3.0]
material = "concrete"
[[tag]]
id = "A"
position_m = [1.0, 1.0, 2.5]
[reader]
response = "isolated"
[log]
"""
HEAD = "x_m,y_m,id,rss_dbm\n"


def study(tmp_path, keys="", log=None):
    if log is not None:
        (tmp_path / "log.csv").write_text(log)
        keys = f'file = "log.csv"\n{keys}'
    return parse_study(ROOM + keys, source="study.toml", directory=tmp_path)


def read(tmp_path, keys="", log=None, **options):
    whole = with_log(study(tmp_path, keys, log))
    return measured_log(whole, build_setting(whole).scene, **options)


def test_a_study_with_a_log_survives_its_file(tmp_path):
    whole = study(tmp_path, 'ids = {x = "A"}\nnot_heard = [100]\n', HEAD)
    assert whole.log.file == str(tmp_path / "log.csv")
    assert parse_study(to_toml(whole), source="again", directory=Path("/")) == whole


def test_sources_are_the_studys_tags_in_their_order(tmp_path):
    found = read(tmp_path, "threshold_dbm = -90\n", HEAD + "1,1,A,-50\n,,-,\n2,1,A,-inf\n")
    assert found.log.ids == ("A",)
    assert found.log.rss_dbm.tolist() == [-50.0, -np.inf]
    assert found.log.threshold_dbm == -90.0
    assert len(read(tmp_path, "", HEAD + "1,1,A,-50\n,,-,\n", motion=True).log) == 2


def test_anchors_of_a_table_become_tags_and_the_antenna_rides_as_high_as_it_did(tmp_path):
    (tmp_path / "anchors.csv").write_text("id,x,y\nA,0,0\nB,2,3\n")
    keys = 'anchors = "anchors.csv"\nanchor_height_m = 2.0\nheight_m = 1.3\nshift_m = [1, 0.5]\n'
    whole = with_log(study(tmp_path, keys))
    assert {tag.id: tag.position_m for tag in whole.tags} == {
        "A": (1.0, 1.0, 2.5),  # the study's own
        "B": (3.0, 3.5, 2.0),
    }
    assert whole.reader.height_m == 1.3


@pytest.mark.parametrize(
    ("keys", "log", "said"),
    [
        ("", None, "no log is named; give --log FILE, or log.file"),
        ("", "", "log.csv is empty"),
        ("", HEAD, "log.csv has no rows"),
        ("", HEAD + "1,1,-,\n", "log.csv holds no reading at all"),
        ("", HEAD + "1,1,a,-50\n", "readings of 'a', but the study has no such [[tag]]"),
        ("", HEAD + "1,1,a,-50\n", "did you mean 'A'"),
        ('unknown_ids = "leave_out"', HEAD + "1,1,Z,-50\n", "readings of 'Z' only"),
        ("", HEAD + "1,1,A,1e-5\n1,1,A,2e-7\n", 'set log.rss_unit = "mw"'),
        ("", HEAD + "1,5.5,A,-50\n1,1,A,-50\n", "1 of 2 poses"),
        ("", HEAD + "1,5.5,A,-50\n1,1,A,-50\n", "x and y exchanged nearly all lie inside: try"),
        ("", HEAD + "100,55,A,-50\n500,350,A,-50\n", 'try log.length_unit = "cm"'),
        ("points_log_m = [[0, 0]]", HEAD, "log.points_room_m 0"),
        ("points_log_m = [[0, 0], [1, 0]]\npoints_room_m = [[0, 0], [1, 0]]", HEAD, "on one line"),
        ('format = "bag"', HEAD + "1,1,A,-50\n", "is a bag; name the topic"),
        ('columns = {rss = "r"}', HEAD + "1,1,A,-50\n", "no column names the sources"),
        ('columns = {x = "x_m"}', HEAD + "1,1,A,-50\n", 'give columns.rss, such as "rss_dbm"'),
    ],
)
def test_a_log_that_cannot_be_of_this_room_is_refused_in_one_sentence(tmp_path, keys, log, said):
    with pytest.raises(ConfigError) as caught:
        read(tmp_path, keys, log)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_is_left_out_is_said(tmp_path):
    keys = 'unknown_ids = "leave_out"\noutside_share = 0.5\n'
    found = read(tmp_path, keys, HEAD + "1,1,A,-50\n1,9,A,-50\n1,1,Z,-50\n")
    assert found.log.rss_dbm.tolist() == [-50.0]
    assert found.notes[0] == "1 readings of 'Z', which the study has no [[tag]] for, are left out."
    assert "1 of 2 poses" in found.notes[1]


def test_three_reference_points_lay_a_mirrored_log_onto_the_room(tmp_path):
    keys = """points_log_m = [[0, 0], [4, 0], [0, 6]]
points_room_m = [[0, 0], [0, 4], [6, 0]]
"""
    found = read(tmp_path, keys, HEAD + "1,5.5,A,-50\n")
    np.testing.assert_allclose(found.log.poses[0, :2], [5.5, 1.0], atol=1e-12)


def test_the_columns_of_octant_may_hold_other_units(tmp_path):
    log = "x_m,y_m,heading_deg,id,rss_dbm\n100,200,1.5,A,1e-6\n100,200,,A,0\n"
    keys = 'rss_unit = "mw"\nlength_unit = "cm"\nangle_unit = "rad"\n'
    found = read(tmp_path, keys, log).log
    np.testing.assert_allclose(found.poses[0], [1.0, 2.0, 1.5])
    np.testing.assert_allclose(found.rss_dbm, [-60.0, -np.inf])
