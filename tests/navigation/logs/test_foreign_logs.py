"""Tables, folders and bags of others say the same as the log that they were made of."""

from dataclasses import replace

import numpy as np
import pytest

from octant.geometries.errors import ConfigError
from octant.navigation.logs.anchors import read_anchors
from octant.navigation.logs.bags import BagForm, read_bag
from octant.navigation.logs.folders import FolderForm, read_folder
from octant.navigation.logs.forms import Columns, TableForm
from octant.navigation.logs.frames import UNMOVED, Frame
from octant.navigation.logs.tables import read_table

POSE = {"time": "t", "x": "x", "y": "y", "heading": "yaw"}


def written(tmp_path, text, name="log.csv"):
    file = tmp_path / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    return file


def wide(**options):
    return TableForm(columns=Columns(**POSE, rss="rssi_{id}"), **options)


def test_one_column_a_source_becomes_one_row_a_reading(tmp_path):
    rows = ["1e9,1,2,90,-50,,a", "2e9,1,3,90,100,-70,b", "3e9,2,3,0,100,100,c"]
    file = written(tmp_path, "\n".join(["t,x,y,yaw,rssi_1,rssi_2,floor", *rows]))
    log = read_table(file, wide(time_unit="ns", not_heard=(100.0,), ids={"1": "A"}))
    assert log.ids == ("A", "2")
    assert log.time_s.tolist() == [1.0, 1.0, 2.0, 2.0, 3.0, 3.0]
    assert log.sources.tolist() == [0, 1, 0, 1, 0, 1]
    assert log.rss_dbm.tolist() == [-50.0, -np.inf, -np.inf, -70.0, -np.inf, -np.inf]
    assert log.kept == {"floor": ("a", "a", "b", "b", "c", "c")}
    np.testing.assert_array_equal(log.poses[2], [1.0, 3.0, np.pi / 2])


def test_an_empty_cell_can_be_no_reading_and_its_row_still_moves(tmp_path):
    columns = Columns(time="t", distance="d", rss="rssi_{id}")
    form = TableForm(columns=columns, empty="no_reading")
    rows = ["1,.1,-50,-60", "2,.1,,", "3,.1,,-70", "4,.1,,100"]
    file = written(tmp_path, "\n".join(["t,d,rssi_1,rssi_2", *rows]))
    log = read_table(file, replace(form, not_heard=(100.0,)))
    assert log.sources.tolist() == [0, 1, -1, 1, 1]
    assert log.censored.tolist() == [False, False, False, False, True]
    assert log.distance_m.tolist() == [0.1, 0.0, 0.1, 0.1, 0.1]  # once a row of the table


def test_only_known_sources_are_taken_from_a_table_of_hundreds(tmp_path):
    file = written(tmp_path, "WAP1,WAP2,WAP3\n-50,-60,-70\n")
    form = TableForm(columns=Columns(rss="WAP{id}"), only=frozenset({"2"}))
    assert read_table(file, form).ids == ("2",)
    assert read_table(file, form).kept == {}
    with pytest.raises(ConfigError, match=r"no column of the tags '9' by the pattern 'WAP\{id\}'"):
        read_table(file, TableForm(columns=Columns(rss="WAP{id}"), only=frozenset({"9"})))


def test_hardware_addresses_are_columns_like_any_other(tmp_path):
    text = "x;y;aa:bb:cc:00:11:22;aa:bb:cc:00:11:33\n1,5;2,25;-50,5;-60\n"
    form = TableForm(columns=Columns(x="x", y="y", rss="{id}"))
    log = read_table(written(tmp_path, text), form)
    assert log.ids == ("aa:bb:cc:00:11:22", "aa:bb:cc:00:11:33")
    assert log.rss_dbm.tolist() == [-50.5, -60.0]
    assert log.poses[0, :2].tolist() == [1.5, 2.25]


def test_antennas_stand_in_the_names_of_columns_too(tmp_path):
    form = TableForm(columns=Columns(rss="{id}@{antenna}"))
    log = read_table(written(tmp_path, "A@1,A@2,B@1\n-1,-2,-3\n"), form)
    assert (log.ids, log.sources.tolist()) == (("A", "B"), [0, 0, 1])
    assert log.antennas.tolist() == [1, 2, 1]


def test_one_row_a_reading_with_other_names_and_units(tmp_path):
    columns = Columns(
        time="when",
        x="px",
        y="py",
        qz="qz",
        qw="qw",
        id="mac",
        antenna="ant",
        rss="p",
        frequency="f",
    )
    form = TableForm(columns=columns, time_unit="iso", length_unit="cm", rss_unit="nw")
    half = repr(float(np.sqrt(0.5)))
    rows = [f"2024-01-01T00:00:01.5,100,250,{half},{half},m1,2,1.0,2.4e9,x", ",,,,,m2,-,0,,y"]
    file = written(tmp_path, "\n".join(["when,px,py,qz,qw,mac,ant,p,f,more", *rows]))
    log = read_table(file, form)
    assert log.time_s[0] == 1704067201.5
    np.testing.assert_allclose(log.poses[0], [1.0, 2.5, np.pi / 2], rtol=1e-15)
    assert log.rss_dbm.tolist() == [-60.0, -np.inf]
    assert log.antennas.tolist() == [2, 0]
    assert log.kept == {"more": ("x", "y")}


def test_a_compass_counts_clockwise_from_north(tmp_path):
    form = TableForm(
        columns=Columns(heading="h", turn="w", id="id", rss="r"),
        heading_zero_deg=90.0,
        clockwise=True,
    )
    log = read_table(written(tmp_path, "h,w,id,r\n90,10,A,-50\n"), form)
    np.testing.assert_allclose(
        [log.poses[0, 2], log.turn_rad[0]], [0.0, -np.radians(10.0)], atol=1e-15
    )


def test_a_table_without_header_has_numbers_for_names(tmp_path):
    form = TableForm(columns=Columns(rss="{id}"), header=False, ids={"1": "A", "2": "B"})
    log = read_table(written(tmp_path, "-50 -60\n-51 -61\n"), form)
    assert (log.ids, log.rss_dbm.tolist()) == (("A", "B"), [-50.0, -60.0, -51.0, -61.0])


@pytest.mark.parametrize(
    ("text", "options", "said"),
    [
        ("t,x,y,yaw,rss_1\n1,1,1,1,-50\n", {}, "log.csv:1: has no column like 'rssi_{id}'"),
        ("t,x,y,rssi_1\n1,1,1,-50\n", {}, "log.csv:1: has no column 'yaw'"),
        ("t,x,y,yaw,rssi_1\n1,1,1,1,loud\n", {}, "log.csv:2: rssi_1 is 'loud'"),
        ("t,x,y,yaw,rssi_1\n1,1,1,1,-50\n", {"ids": {"7": "A"}}, "no column of the source '7'"),
        ("t,x,y,yaw,rssi_1\n1,1,1,1,1e-6\n", {}, 'set log.rss_unit = "mw"'),
        ("t,x,y,yaw,rssi_1\n1,1,1,1,-50\n", {"rss_unit": "mw"}, 'set log.rss_unit = "dbm"'),
        ("t,x,y,yaw,rssi_1\n1,1,1,1,100\n1,1,1,1,-50\n", {}, "set log.not_heard = [100]"),
        ("t,x,y,yaw,rssi_1\nsoon,1,1,1,-50\n", {"time_unit": "iso"}, "log.csv:2: t is 'soon'"),
    ],
)
def test_a_table_that_is_not_as_described_is_refused_with_its_line(tmp_path, text, options, said):
    with pytest.raises(ConfigError) as caught:
        read_table(written(tmp_path, text), wide(**options))
    assert said in str(caught.value)


def test_files_of_a_folder_have_their_places_in_their_names(tmp_path):
    form = TableForm(columns=Columns(rss="ap{id}"), length_unit="cm")
    for x, y, level in ((100, 250, -50), (-50, 0, -60)):
        written(tmp_path, f"ap1,ap2\n{level},-80\n", f"room3/p_{x}_{y}.csv")
    written(tmp_path, "what", "readme.txt")
    log = read_folder(tmp_path, form, FolderForm(name="{any}/p_{x}_{y}.csv"))
    assert log.rss_dbm.tolist() == [-60.0, -80.0, -50.0, -80.0]
    assert log.poses[::2, :2].tolist() == [[-0.5, 0.0], [1.0, 2.5]]
    with pytest.raises(ConfigError, match=r"has no file like 'q_\{x\}.csv'; it has readme.txt"):
        read_folder(tmp_path, form, FolderForm(name="q_{x}.csv"))


def test_places_of_a_list_and_sources_of_names_meet(tmp_path):
    places = written(tmp_path, "place;x;y\nhall;1,5;2\nroom;3;4\n", "places.csv")
    form = TableForm(columns=Columns(rss="level"), ids={"b7": "B"})
    written(tmp_path, "level\n-50\n-51\n", "data/hall/a1.csv")
    written(tmp_path, "level\n-60\n", "data/room/b7.csv")
    log = read_folder(tmp_path / "data", form, FolderForm(name="{place}/{id}.csv", places=places))
    assert [log.ids[i] for i in log.sources] == ["a1", "a1", "B"]
    assert log.poses[:, :2].tolist() == [[1.5, 2.0], [1.5, 2.0], [3.0, 4.0]]
    assert log.kept == {"place": ("hall", "hall", "room")}
    written(tmp_path, "level\n-60\n", "data/rom/b7.csv")
    with pytest.raises(ConfigError, match="place 'rom' is not in the list; did you mean 'room'"):
        read_folder(tmp_path / "data", form, FolderForm(name="{place}/{id}.csv", places=places))


def test_anchors_lie_in_the_frame_of_the_log(tmp_path):
    file = written(tmp_path, "ID,X,Y\n1,100,200\n2,0,0\n", "anchors.csv")
    form = TableForm(columns=Columns(), length_unit="cm", ids={"2": "B"})
    frame = Frame(turn_rad=np.pi / 2, shift_m=np.array([5.0, 0.0]))
    found = read_anchors(file, form, frame, height_m=2.5)
    assert [one.id for one in found] == ["1", "B"]
    np.testing.assert_allclose(found[0].position_m, [3.0, 1.0, 2.5], atol=1e-15)
    with pytest.raises(ConfigError, match=r"anchors.csv:2: the anchor '1' has no height"):
        read_anchors(file, form, UNMOVED, height_m=None)


@pytest.fixture
def bag(tmp_path):
    """A rosbag2 in MCAP with own messages: two beacons a message, poses at other times."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg("string tag\nfloat32 rssi\n", "lab_msgs/msg/Beacon"))
    scan = "std_msgs/Header header\nlab_msgs/Beacon[] beacons\n"
    store.register(get_types_from_msg(scan, "lab_msgs/msg/Scan"))
    types = store.types

    def header(time_s):
        seconds = int(time_s)
        stamp = types["builtin_interfaces/msg/Time"](seconds, round((time_s - seconds) * 1e9))
        return types["std_msgs/msg/Header"](stamp, "map")

    def pose(x, y, heading):
        point = types["geometry_msgs/msg/Point"](x, y, 0.0)
        turn = types["geometry_msgs/msg/Quaternion"](
            0.0, 0.0, np.sin(heading / 2), np.cos(heading / 2)
        )
        return types["geometry_msgs/msg/Pose"](point, turn)

    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        scans = writer.add_connection("/scan", "lab_msgs/msg/Scan", typestore=store)
        poses = writer.add_connection("/pose", "geometry_msgs/msg/PoseStamped", typestore=store)
        for time_s, x, heading in ((1.0, 0.0, 3.0), (2.0, 1.0, -3.0), (3.0, 2.0, -3.0)):
            message = types["geometry_msgs/msg/PoseStamped"](header(time_s), pose(x, 0.5, heading))
            data = store.serialize_cdr(message, "geometry_msgs/msg/PoseStamped")
            writer.write(poses, round(time_s * 1e9), data)
        beacon = types["lab_msgs/msg/Beacon"]
        for time_s, first, second in (
            (1.5, -50.0, -60.0),
            (2.5, -51.0, -np.inf),
            (9.0, -1.0, -2.0),
        ):
            heard = [beacon("A", first), beacon("B", second)]
            message = types["lab_msgs/msg/Scan"](header(time_s), heard)
            writer.write(scans, 0, store.serialize_cdr(message, "lab_msgs/msg/Scan"))
    return tmp_path / "bag"


BEACONS = TableForm(columns=Columns(id="beacons[].tag", rss="beacons[].rssi"))


def test_a_bag_gives_readings_with_the_pose_between_its_poses(bag):
    log = read_bag(bag, BEACONS, BagForm(readings="/scan", pose="/pose", odometry="/pose"))
    assert [log.ids[i] for i in log.sources] == ["A", "B"] * 3
    assert log.rss_dbm.tolist() == [-50.0, -60.0, -51.0, -np.inf, -1.0, -2.0]
    assert log.time_s.tolist() == [1.5, 1.5, 2.5, 2.5, 9.0, 9.0]
    np.testing.assert_allclose(
        log.poses[0], [0.5, 0.5, np.pi]
    )  # through half a turn, not through 0
    np.testing.assert_allclose(log.poses[2, :2], [1.5, 0.5])
    assert np.isnan(log.poses[4]).all()
    np.testing.assert_allclose(log.turn_rad[:4], [0.0, 0.0, np.pi - 3.0, 0.0], atol=1e-12)


def test_a_topic_or_field_that_is_not_there_is_named_with_those_that_are(bag):
    with pytest.raises(ConfigError, match="no topic '/scans'; did you mean '/scan'"):
        read_bag(bag, BEACONS, BagForm(readings="/scans"))
    form = TableForm(columns=Columns(id="beacons[].mac", rss="beacons[].rssi"))
    with pytest.raises(ConfigError, match=r"no field 'mac'; at 'mac' there are \['tag', 'rssi'\]"):
        read_bag(bag, form, BagForm(readings="/scan"))
    with pytest.raises(ConfigError, match="holds lab_msgs/msg/Scan, but poses"):
        read_bag(bag, BEACONS, BagForm(readings="/scan", pose="/scan"))
    with pytest.raises(ConfigError, match="cannot be read as a bag"):
        read_bag(bag / "metadata.yaml", BEACONS, BagForm(readings="/scan"))
