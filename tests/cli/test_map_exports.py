"""``octant map --export``: each file is read back by another reader and holds the map's values."""

import csv
import json
import re

import numpy as np
import pytest
from PIL import Image
from scipy.io import loadmat

import octant as face
from octant.geometries.errors import ConfigError
from octant.reader_design.showing.netcdf import read_dataset

# 1.97 m by 1.5 m in cells of at most 0.25 m: 8 x 6 cells, not square.
STUDY = """
[room]
box_m = [1.97, 1.5, 2.5]
origin_m = [-3.0, 10.0, 0.0]
[[room.object]]
kind = "cabinet"
size_m = [0.5, 0.5, 1.0]
position_m = [-2.5, 10.5, 0.0]
[[tag]]
id = "A"
position_m = [-2.0, 10.5, 2.4]
antenna = "dipole"
[[tag]]
id = "B"
position_m = [-1.5, 11.0, 2.4]
antenna = "dipole"
[reader]
response = "isolated"
[solver]
max_reflections = 1
[map]
spacing_m = 0.25
"""
LEVEL = -25.0


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    from octant.reader_design.cli import run

    folder = tmp_path_factory.mktemp("map")
    (folder / "study.toml").write_text(STUDY)
    kinds = [
        o for kind in ("csv", "mat", "png", "geotiff", "map-server") for o in ("--export", kind)
    ]
    call = ["map", folder / "study.toml", "--out", folder / "map.nc", *kinds]
    assert run([str(a) for a in (*call, "--threshold-dbm", LEVEL)]) == 0
    return folder


@pytest.fixture(scope="module")
def data(exported):
    return read_dataset(exported / "map.nc")


@pytest.fixture(scope="module")
def level_dbm(data):
    """Level of the strongest antenna [dBm], NaN in the cabinet, by tag, x and y."""
    with np.errstate(divide="ignore"):
        level = 30.0 + 10.0 * np.log10(data["rss_w"].max("antenna"))
    return level.where(data["open_floor"] == 1)


def ros_map(path):
    """Return the mask with -1 for unknown, (ny, nx) from below, resolution and origin."""
    keys = dict(re.findall(r"^(\w+): (.*)$", path.read_text(), flags=re.MULTILINE))
    magic, width, height, top, pixels = (
        (path.parent / json.loads(keys["image"])).read_bytes().split(maxsplit=4)
    )
    assert (magic, top, keys["negate"], keys["mode"]) == (b"P5", b"255", "0", "raw")
    grid = np.frombuffer(pixels, np.uint8).reshape(int(height), int(width)).astype(int)
    grid = np.where(grid <= 100, grid, -1)[
        ::-1
    ]  # the first row of the image is the last of the grid
    return grid, float(keys["resolution"]), json.loads(keys["origin"])


def conversion(path):
    text = path.with_name(f"{path.stem}_filter_info.yaml").read_text()
    keys = dict(re.findall(r"^ +(\w+): (.*)$", text, flags=re.MULTILINE))
    return int(keys["type"]), float(keys["base"]), float(keys["multiplier"])


@pytest.mark.parametrize("tag", ["A", "B"])
def test_a_ros_map_has_each_value_at_its_place(exported, level_dbm, tag):
    path = exported / f"map_rss_dbm_{tag}.yaml"
    mask, resolution_m, origin = ros_map(path)
    kind, base, multiplier = conversion(path)
    assert kind == 3
    assert origin == [-3.0, 10.0, 0.0]
    assert mask.shape == (7, 8)  # 1.5 m in cells of 1.97 m / 8
    assert resolution_m == pytest.approx(1.97 / 8)
    expected = level_dbm.sel(tag=tag).to_numpy().T
    width, depth = 1.97 / 8, 1.5 / 6
    for row, values in enumerate(mask):
        y = origin[1] + (row + 0.5) * resolution_m
        for column, value in enumerate(values):
            x = origin[0] + (column + 0.5) * resolution_m
            i, j = int((x + 3.0) / width), int((y - 10.0) / depth)
            seen = expected[j, i] if y < 11.5 else np.nan
            if np.isnan(seen):
                assert value == -1
            else:
                assert abs(base + multiplier * value - seen) <= 0.5 * multiplier + 1e-9
    assert (mask == -1).sum() < mask.size / 2


def test_the_mask_of_a_level_keeps_a_robot_where_it_is_reached(exported, level_dbm):
    path = exported / "map_covered_A.yaml"
    mask, _, _ = ros_map(path)
    assert conversion(path) == (0, 0.0, 1.0)
    expected = level_dbm.sel(tag="A").to_numpy().T
    assert set(np.unique(mask)) == {-1, 0, 100}
    np.testing.assert_array_equal(mask[0] == 100, expected[0] < LEVEL)  # both rows are the first


def test_a_geotiff_has_the_level_as_float32_at_its_place(exported, level_dbm):
    with Image.open(exported / "map_rss_dbm_B.tif") as image:
        pixels, tags = np.asarray(image), dict(image.tag_v2)
    assert pixels.dtype == np.float32
    np.testing.assert_array_equal(
        pixels, level_dbm.sel(tag="B").to_numpy().T[::-1].astype(np.float32)
    )
    assert tags[33550] == pytest.approx((1.97 / 8, 0.25, 0.0))
    assert tags[33922] == pytest.approx((0.0, 0.0, 0.0, -3.0, 11.5, 0.0))
    keys = np.reshape(tags[34735], (-1, 4)).tolist()
    assert keys[0] == [1, 1, 0, len(keys) - 1]
    assert [1024, 0, 1, 32767] in keys  # a local system
    assert [1025, 0, 1, 1] in keys  # pixels are areas
    assert [3076, 0, 1, 9001] in keys  # metres
    assert tags[42113] == "nan"


def test_a_world_file_puts_the_first_pixel_at_its_place(exported, level_dbm):
    numbers = [float(line) for line in (exported / "map_rss_dbm_A.pgw").read_text().split()]
    assert numbers == pytest.approx([1.97 / 8, 0, 0, -0.25, -3.0 + 1.97 / 16, 11.5 - 0.125])
    with Image.open(exported / "map_rss_dbm_A.png") as image:
        said, alpha = image.text, np.asarray(image)[..., 3]
    seen = level_dbm.sel(tag="A").to_numpy().T[::-1]
    np.testing.assert_array_equal(alpha == 0, np.isnan(seen))
    assert float(said["low"]) == pytest.approx(np.nanmin(seen), rel=1e-5)


def test_a_table_and_a_mat_file_hold_everything_in_watts_and_dbm(exported, data):
    with (exported / "map.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2 * 8 * 6
    row = next(r for r in rows if r["tag"] == "B" and float(r["x_m"]) == data["x"][5])
    place = data.sel(tag="B", x=float(row["x_m"]), y=float(row["y_m"]))
    for antenna in (1, 8):
        power = float(place["rss_w"].sel(antenna=antenna))
        assert float(row[f"rss_{antenna}_w"]) == power
        assert float(row[f"rss_{antenna}_dbm"]) == pytest.approx(30.0 + 10.0 * np.log10(power))
    assert float(row["bearing_error_deg"]) == float(place["bearing_error"])
    nothing = next(r for r in rows if r["path_count"] == "0")
    assert nothing["rss_1_dbm"] == ""
    mat = loadmat(exported / "map.mat", simplify_cells=True)
    np.testing.assert_array_equal(mat["rss_w"], data["rss_w"])
    np.testing.assert_array_equal(np.ravel(mat["x"]), data["x"])
    assert mat["units"]["rss_dbm"] == "dBm"
    assert mat["dimensions"]["rss_w"] == "tag, x, y, antenna"
    assert list(mat["tag"]) == ["A", "B"]


def test_the_share_of_the_floor_counts_open_places_only(exported, level_dbm, octant):
    call = octant(
        "map", exported / "study.toml", "--out", exported / "map.nc", "--threshold-dbm", LEVEL
    )
    reached, floor = level_dbm.sel(tag="A") >= LEVEL, level_dbm.sel(tag="A").notnull()
    share = 100.0 * float(reached.sum() / floor.sum())
    assert 0.0 < share < 100.0
    assert f"tag A: -25 dBm or more on {share:.1f} % (coherent) of the floor." in call.out
    assert "complete already" in call.err


def test_files_do_not_depend_on_when_they_are_written(exported, tmp_path):
    from octant.reader_design.face.map_files import MapAccessor

    again = MapAccessor(read_dataset(exported / "map.nc"))
    again.to_mat(tmp_path / "a.mat")
    again.to_geotiff(tmp_path / "a.tif", tag="B")
    assert (tmp_path / "a.mat").read_bytes() == (exported / "map.mat").read_bytes()
    assert (tmp_path / "a.tif").read_bytes() == (exported / "map_rss_dbm_B.tif").read_bytes()


def test_power_height_and_a_transmitter_of_ones_own(exported, octant, tmp_path, data):
    study = exported / "study.toml"
    assert octant("map", study, "--out", tmp_path / "a.nc", "--power-dbm", "20").code == 0
    louder = read_dataset(tmp_path / "a.nc")
    np.testing.assert_allclose(louder["rss_w"], 0.1 * data["rss_w"], rtol=1e-12)
    plain = ("--tx", "-2,10.5,2.4", "--tx-antenna", "isotropic_theta", "--isotropic")
    assert octant("map", study, "--out", tmp_path / "b.nc", *plain, "--height-m", "1.5").code == 0
    own = read_dataset(tmp_path / "b.nc")
    assert own["tag"].to_numpy().tolist() == ["tx"]
    assert float(own["z"]) == 1.5
    both = octant(
        "map", study, "--out", tmp_path / "c.nc", "--power-dbm", "20", "--power-w", "1"
    ).refused()
    assert "there is one power" in both
    (tmp_path / "d.csv").write_text("mine")
    taken = octant("map", study, "--out", tmp_path / "d.nc", "--export", "csv").refused()
    assert "d.csv exists already" in taken
    assert not (tmp_path / "d.nc").exists()


@pytest.mark.filterwarnings("ignore::octant.geometries.errors.PhysicsWarning")
def test_the_map_in_python_is_written_as_the_command_does(exported, tmp_path, level_dbm):
    room = face.Room.box(
        (1.97, 1.5, 2.5),
        "concrete",
        origin_m=(-3.0, 10.0, 0.0),
        objects=[{"kind": "cabinet", "size_m": (0.5, 0.5, 1.0), "position_m": (-2.5, 10.5, 0.0)}],
    )
    rss = room.rss_map(
        [face.Tag("B", (-1.5, 11.0, 2.4), antenna="dipole")],
        face.Reader(response="isolated"),
        spacing_m=0.25,
        solver={"max_reflections": 1},
        progress=False,
    )
    rss.octant.to_geotiff(tmp_path / "b.tif")
    assert (tmp_path / "b.tif").read_bytes() == (exported / "map_rss_dbm_B.tif").read_bytes()
    seen = level_dbm.sel(tag="B")
    share = float((seen >= LEVEL).sum() / seen.notnull().sum())
    assert float(rss.octant.coverage(LEVEL)[0]) == pytest.approx(share)
    figure = rss.octant.plot(threshold_dbm=LEVEL)
    assert figure.axes[0].get_title("left") == "tag B"
    with pytest.raises(ConfigError, match=r"no layer 'rss_dBm'.*the nearest is 'rss_dbm'"):
        rss.octant.to_png(tmp_path / "c.png", "rss_dBm")
    with pytest.raises(ConfigError, match=r"ends in \.yaml"):
        rss.octant.to_map_server(tmp_path / "c.pgm")


def test_the_free_floor_is_a_ros_map(tmp_path):
    room = face.Room.outline(
        [(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (0, 2)],
        "concrete",
        height_m=2.5,
        objects=[
            {
                "kind": "box",
                "material": "wood",
                "size_m": (0.4, 0.4, 0.3),
                "position_m": (2.0, 0.3, 0.0),
            },
            {
                "kind": "box",
                "material": "wood",
                "size_m": (0.4, 0.4, 0.3),
                "position_m": (1.0, 0.3, 0.9),
            },
        ],
    )
    yaml, image = room.to_map_server(tmp_path / "map.yaml", resolution_m=0.1)
    keys = dict(re.findall(r"^(\w+): (.*)$", yaml.read_text(), flags=re.MULTILINE))
    assert (keys["mode"], keys["origin"], keys["image"]) == (
        "trinary",
        "[0.0, 0.0, 0.0]",
        '"map.pgm"',
    )
    pixels = np.asarray(Image.open(image))[::-1]
    assert pixels.shape == (20, 30)

    def at(x_m, y_m):
        return pixels[int(y_m / 0.1), int(x_m / 0.1)]

    assert at(2.2, 0.5) == 0  # in the box
    assert at(1.2, 0.5) == 254  # below the one that hangs
    assert at(0.55, 0.55) == 254
    assert at(0.02, 0.55) == 0  # the wall
    assert at(2.0, 1.5) == 205  # outside the L
