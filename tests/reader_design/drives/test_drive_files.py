"""Files of drives, read back by programs that share no line with what wrote them."""

import csv
import json
import sys

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from octant.geometries.bodies import Body
from octant.geometries.errors import ConfigError, NavigationError
from octant.reader_design.drives.definitions import definition
from octant.reader_design.drives.files import check_kinds, drive_names, write_drive
from octant.reader_design.drives.log import Carrier, DriveLog, Surroundings
from octant.reader_design.drives.messages import drive_messages
from octant.reader_design.showing.rasters import Raster

AZIMUTHS = 2.0 * np.pi * np.arange(8) / 8
SAMPLES = 5
RNG = np.random.default_rng(4)


def drive(**changes):
    poses = np.column_stack([RNG.uniform(0.0, 4.0, (SAMPLES, 2)), RNG.uniform(-3.0, 3.0, SAMPLES)])
    belief = poses + RNG.normal(0.0, 0.1, poses.shape)
    belief[0] = np.nan
    rss_w = RNG.uniform(1e-10, 1e-8, (SAMPLES, 8))
    rss_w[1, 3], rss_w[2] = 0.0, np.nan
    fields = {
        "name": "a drive",
        "time_s": np.array([0.0, 0.1, 0.25, 1.0, 7.3]),
        "poses": poses,
        "carrier": Carrier(
            radius_m=0.2,
            height_m=0.4,
            reader_height_m=0.3,
            antenna_radius_m=0.1,
            azimuths_rad=AZIMUTHS,
        ),
        "floor_m": 0.5,
        "belief": belief,
        "odometry": RNG.normal(0.0, 1.0, (SAMPLES, 3)),
        "origin": np.array([1.0, 2.0, 0.3]),
        "commands": RNG.normal(0.0, 1.0, (SAMPLES, 2)),
        "rss_w": rss_w,
        "targets": ("A",) * SAMPLES,
        "states": ("rotation",) * SAMPLES,
        "wanted": np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 0.5]]),
        "tags_m": {"A": np.array([1.0, 2.0, 2.5])},
        "around": Surroundings(
            bodies=(
                Body(
                    name="wall",
                    vertices_m=np.array([[0.0, 0, 0], [4, 0, 0], [4, 0, 3]]),
                    faces=np.array([[0, 1, 2]]),
                    material="concrete",
                ),
            ),
            floor=Raster(
                x_m=np.array([0.5, 1.5, 2.5]),
                y_m=np.array([0.5, 1.5]),
                values=np.array([[1.0, 0.0], [np.nan, 1.0], [1.0, 0.0]]),
                name="free floor",
                unit="1",
            ),
            closing=frozenset({"wall"}),
        ),
        "facts": {"outcome": "completed"},
    }
    return DriveLog(**(fields | changes))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    log = drive()
    stem = tmp_path_factory.mktemp("drive") / "run_0"
    files = write_drive(log, stem, ("mcap", "tum", "csv"))
    return log, stem, files


@pytest.fixture(scope="module")
def messages(recorded):
    """Topic to times [ns] and messages, by rosbags."""
    _, stem, _ = recorded
    found = {}
    with AnyReader([stem.with_suffix(".mcap")]) as bag:
        for connection, stamp, raw in bag.messages():
            one = bag.deserialize(raw, connection.msgtype)
            found.setdefault(connection.topic, []).append((stamp, one))
    return found


def times_s(entries):
    return np.array([(stamp - 10**9) / 1e9 for stamp, _ in entries])


def yaw(q):
    return 2.0 * np.arctan2(q.z, q.w)


def same_turn(a, b):
    return np.abs(np.angle(np.exp(1j * (np.asarray(a) - np.asarray(b))))).max()


def test_poses_commands_and_readings_read_back_with_equal_numbers(recorded, messages):
    log, _, _ = recorded
    truth = messages["/ground_truth/pose"]
    np.testing.assert_array_equal(times_s(truth), log.time_s)
    places = np.array([[m.pose.position.x, m.pose.position.y] for _, m in truth])
    np.testing.assert_array_equal(places, log.poses[:, :2])
    assert {m.pose.position.z for _, m in truth} == {0.5}
    assert same_turn([yaw(m.pose.orientation) for _, m in truth], log.poses[:, 2]) < 1e-15
    belief = messages["/belief/pose"]
    np.testing.assert_array_equal(times_s(belief), log.time_s[1:])
    places = np.array([[m.pose.position.x, m.pose.position.y] for _, m in belief])
    np.testing.assert_array_equal(places, log.belief[1:, :2])
    twist = np.array([[m.linear.x, m.angular.z] for _, m in messages["/cmd_vel"]])
    np.testing.assert_array_equal(twist, log.commands)
    heard = [0, 1, 3, 4]
    rss_w = np.array([m.data for _, m in messages["/rss_w"]])
    np.testing.assert_array_equal(rss_w, log.rss_w[heard])
    level = np.array([m.data for _, m in messages["/rss_dbm"]])
    assert np.isnan(level[1, 3])
    np.testing.assert_allclose(10.0 ** (level[0] / 10.0 - 3.0), log.rss_w[0], rtol=1e-14)
    assert [m.data for _, m in messages["/target_tag"]] == ["A"] * SAMPLES


def test_frames_chain_to_where_the_robot_believes_to_be(recorded, messages):
    log, _, _ = recorded
    for k, (_, message) in enumerate(messages["/tf"]):
        moves = {(t.header.frame_id, t.child_frame_id): t.transform for t in message.transforms}
        truth = moves["map", "base_link_true"].translation
        assert (truth.x, truth.y) == tuple(log.poses[k, :2])
        odom, base = moves["map", "odom"], moves["odom", "base_link"]
        turn = yaw(odom.rotation)
        across = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        away = across @ [base.translation.x, base.translation.y]
        there = away + np.array([odom.translation.x, odom.translation.y])
        if k == 0:  # before the first belief, odometry's axes stand where the robot started
            assert (odom.translation.x, odom.translation.y) == (1.0, 2.0)
            continue
        np.testing.assert_allclose(there, log.belief[k, :2], atol=1e-14)
        assert same_turn(turn + yaw(base.rotation), log.belief[k, 2]) < 1e-14
    still = {t.child_frame_id: t for t in messages["/tf_static"][0][1].transforms}
    assert len(still) == 9
    # the reader's +y looks ahead: its x axis, where antenna 1 stands, to the robot's right
    assert yaw(still["reader"].transform.rotation) == pytest.approx(-np.pi / 2)
    third = still["antenna_3"].transform.translation
    np.testing.assert_allclose([third.x, third.y], [0.0, 0.1], atol=1e-16)


def test_odometry_has_the_speeds_of_an_arc():
    time_s = 0.5 * np.arange(SAMPLES)
    speed, rate = 0.3, 0.4
    heading = rate * time_s
    arc = np.column_stack(
        [speed / rate * np.sin(heading), speed / rate * (1.0 - np.cos(heading)), heading]
    )
    found = [
        m["twist"]["twist"]
        for topic, _, m in drive_messages(drive(time_s=time_s, odometry=arc))
        if topic.name == "/odom"
    ]
    chord = np.sinc(0.5 * rate * 0.5 / np.pi)
    assert [t["angular"]["z"] for t in found[1:]] == pytest.approx([rate] * (SAMPLES - 1))
    assert [t["linear"]["x"] for t in found[1:]] == pytest.approx([speed * chord] * (SAMPLES - 1))


def test_map_room_and_tags_read_back(recorded, messages):
    log, _, _ = recorded
    grid = messages["/map"][0][1]
    cells = np.array(grid.data).reshape(grid.info.height, grid.info.width)
    np.testing.assert_array_equal(cells, [[0, -1, 0], [100, 0, 100]])
    assert (grid.info.origin.position.x, grid.info.origin.position.y) == (0.0, 0.0)
    assert grid.info.resolution == 1.0
    wall = messages["/room"][0][1].markers[0]
    assert (wall.ns, wall.type, wall.action) == ("wall", 11, 0)
    corners = np.array([[p.x, p.y, p.z] for p in wall.points])
    np.testing.assert_array_equal(corners, log.around.bodies[0].triangles_m.reshape(-1, 3))
    assert wall.color.a == pytest.approx(0.3)
    ball, text = messages["/tags"][0][1].markers
    assert (ball.pose.position.x, ball.pose.position.y, ball.pose.position.z) == (1.0, 2.0, 2.5)
    assert text.text == "A"
    assert len(messages["/plan"][0][1].poses) == 2


def test_bearing_is_the_vector_sum_and_stands_beside_the_true_one(recorded, messages):
    log, _, _ = recorded
    total = log.rss_w[0] @ np.exp(1j * (AZIMUTHS - np.pi / 2))
    assert messages["/bearing_deg"][0][1].data == pytest.approx(np.degrees(np.angle(total)))
    x, y, heading = log.poses[0]
    truth = np.degrees(np.angle(np.exp(1j * (np.arctan2(2.0 - y, 1.0 - x) - heading))))
    assert messages["/ground_truth/bearing_deg"][0][1].data == pytest.approx(truth)
    assert len(messages["/bearing_deg"]) == 4


def test_topics_for_latecomers_are_offered_as_transient_local(recorded):
    _, stem, _ = recorded
    with AnyReader([stem.with_suffix(".mcap")]) as bag:
        durability = {
            c.topic: c.ext.offered_qos_profiles[0].durability.name for c in bag.connections
        }
    kept = {topic for topic, name in durability.items() if name == "TRANSIENT_LOCAL"}
    assert kept == {
        "/tf_static", "/room", "/tags", "/map", "/robot", "/plan", "/ground_truth/path",
    }  # fmt: skip


def test_schemas_are_those_of_ros_2():
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    for name in (
        "tf2_msgs/TFMessage", "nav_msgs/Odometry", "nav_msgs/Path", "nav_msgs/OccupancyGrid",
        "geometry_msgs/PoseStamped", "geometry_msgs/PointStamped", "geometry_msgs/Twist",
        "std_msgs/Float64MultiArray", "std_msgs/Float64", "std_msgs/String",
        "visualization_msgs/MarkerArray",
    ):  # fmt: skip
        full = name.replace("/", "/msg/")
        for kind, (_, fields) in get_types_from_msg(definition(name), full).items():
            assert list(fields) == list(store.fielddefs[kind][1]), kind


def test_the_same_drive_makes_the_same_bytes(recorded, tmp_path):
    log, stem, _ = recorded
    again, *_ = write_drive(log, tmp_path / "again", ("mcap",))
    assert again.read_bytes() == stem.with_suffix(".mcap").read_bytes()


def test_the_layout_shows_topics_that_are_there(recorded, messages):
    _, stem, files = recorded
    layout = json.loads((stem.parent / "foxglove_layout.json").read_text())
    panels = layout["configById"]
    for panel in panels.values():
        for path in panel.get("paths", ()):
            assert path["value"].split(".")[0] in messages
        for topic in panel.get("topics", ()):
            assert topic in messages or topic == "/belief/tag"
    placed = []

    def walk(node):
        if isinstance(node, str):
            placed.append(node)
        else:
            walk(node["first"])
            walk(node["second"])

    walk(layout["layout"])
    assert sorted(placed) == sorted(panels)
    assert stem.parent / "foxglove_layout.json" in files


def test_trajectories_as_tum_and_csv(recorded):
    log, stem, _ = recorded
    rows = np.loadtxt(stem.parent / "run_0_truth.tum")
    np.testing.assert_array_equal(rows[:, :3], np.column_stack([log.time_s, log.poses[:, :2]]))
    assert same_turn(2.0 * np.arctan2(rows[:, 6], rows[:, 7]), log.poses[:, 2]) < 1e-15
    assert len(np.loadtxt(stem.parent / "run_0_belief.tum")) == SAMPLES - 1
    with stem.with_suffix(".csv").open() as file:
        table = list(csv.DictReader(file))
    assert [float(row["x_m"]) for row in table] == log.poses[:, 0].tolist()
    assert table[0]["believed_x_m"] == ""
    assert table[2]["rss_1_w"] == ""
    assert float(table[1]["rss_1_w"]) == log.rss_w[1, 0]


def test_a_drive_without_reader_or_belief_is_written_too(tmp_path):
    bare = DriveLog(
        name="bare",
        time_s=np.array([0.0, 1.0]),
        poses=np.zeros((2, 3)),
        carrier=Carrier(radius_m=0.2, height_m=0.3),
    )
    mcap, layout, truth = write_drive(bare, tmp_path / "bare", ("mcap", "tum"))
    with AnyReader([mcap]) as bag:
        assert {c.topic for c in bag.connections} == {
            "/tf", "/ground_truth/pose", "/ground_truth/path", "/robot",
        }  # fmt: skip
    assert "rss" not in layout.read_text()
    assert truth.exists()


def test_without_the_packages_a_sentence_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "mcap_ros2.writer", None)
    check_kinds(("tum",))
    with pytest.raises(ConfigError, match=r"octant\[ros\]"):
        check_kinds(("mcap",))


def test_times_that_do_not_rise_are_refused():
    with pytest.raises(NavigationError, match="rising"):
        drive(time_s=np.zeros(SAMPLES))


def test_file_names_are_plain_and_differ():
    assert drive_names(["Room 1 run 0", "room 1/run 0", "../x"]) == [
        "room_1_run_0",
        "room_1_run_0_2",
        "x",
    ]
