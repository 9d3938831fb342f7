"""``octant map``: strongest antenna, bearing error, spreads, means over a disc, figures."""

import math

import numpy as np
import pytest

from octant.reader_design.face.map_figures import PAGES
from octant.reader_design.showing.netcdf import read_dataset

BOX = """
[room]
{room}
[[tag]]
id = "A"
position_m = [2.0, 0.5, 2.9]
antenna = "dipole"
[reader]
response = "isolated"
[solver]
max_reflections = 1
[map]
spacing_m = 0.5
[mission]
navigator = "thesis"
start_m = [4.0, 1.0]
heading_deg = 30.0
tags = ["A"]
"""
ROOM = "box_m = [5, 4, 3]"
CABINET = """
[[room.object]]
kind = "cabinet"
size_m = [1.5, 0.8, 1.0]
position_m = [1.75, 2.2, 0.0]
"""


@pytest.fixture
def mapped(octant, study_file, tmp_path):
    def run(*options, room=ROOM):
        out = tmp_path / "map.nc"
        call = octant("map", study_file(BOX.format(room=room)), "--out", out, *options)
        assert call.code == 0, call.err
        return read_dataset(out)

    return run


def test_strongest_antenna_is_that_of_the_stored_powers(mapped):
    data = mapped(room=ROOM + CABINET)
    rss = data["rss_w"].to_numpy()
    strongest = data["strongest_antenna"].to_numpy()
    heard = rss.max(axis=-1) > 0.0
    assert heard.any()
    assert not heard.all()  # inside the cabinet there is nothing
    np.testing.assert_array_equal(strongest[~heard], 0)
    best = np.take_along_axis(rss[heard], strongest[heard][:, None] - 1, axis=-1)[:, 0]
    np.testing.assert_array_equal(best, rss[heard].max(axis=-1))


def test_bearing_error_is_the_vector_sum_against_the_tag(mapped):
    data = mapped()
    rss = data["rss_w"].to_numpy()[0]
    azimuth = np.radians(30.0 - 90.0) + np.arange(8) * math.pi / 4  # in the room
    total = rss @ np.exp(1j * azimuth)
    x, y = np.meshgrid(data["x"], data["y"], indexing="ij")
    true = (2.0 - x) + 1j * (0.5 - y)
    expected = np.degrees(np.angle(total / true))
    found = data["bearing_error"].to_numpy()[0]
    difference = (found - expected + 180.0) % 360.0 - 180.0
    np.testing.assert_allclose(difference, 0.0, atol=1e-9)
    assert data["bearing_error"].attrs["units"] == "degree"


def test_spreads_vanish_in_free_space_and_are_stored_with_their_units(mapped):
    free = mapped("--spreads", room="free_space = true")
    for name, units in (
        ("delay_spread", "ns"),
        ("azimuth_spread", "degree"),
        ("direction_spread", "degree"),
    ):
        assert free[name].attrs["units"] == units
        assert free[name].dims == ("tag", "x", "y")
        np.testing.assert_allclose(free[name], 0.0, atol=1e-5)


def test_spreads_of_a_room_lie_within_what_its_size_allows(mapped):
    data = mapped("--spreads", "--isotropic")
    delay = data["delay_spread"].to_numpy()
    assert (delay > 0.5).all()
    assert (delay < math.hypot(10, 8, 6) / 0.299792458 / 2).all()
    assert (data["direction_spread"] < math.degrees(1.0) + 1e-9).all()
    assert "strongest_antenna" not in data


@pytest.mark.parametrize("options", [(), ("--isotropic",)])
def test_the_mean_over_a_disc_lies_between_fading_and_power_sum(mapped, options):
    data = mapped("--local-mean", "--local-mean-disc", *options)
    ratio = {
        name: np.log10(data[name].to_numpy() / data["rss_local_mean_w"].to_numpy())
        for name in ("rss_w", "rss_disc_mean_w")
    }
    assert ratio["rss_disc_mean_w"].std() < 0.75 * ratio["rss_w"].std()
    assert abs(ratio["rss_disc_mean_w"].mean()) < 0.1
    assert "one wavelength" in data["rss_disc_mean_w"].attrs["long_name"]


def test_free_space_has_no_fading_over_a_disc(mapped):
    data = mapped("--isotropic", "--local-mean-disc", room="free_space = true")
    far = np.hypot(data["x"] - 2.0, data["y"] - 0.5).to_numpy() > 0.6
    ratio = (data["rss_disc_mean_w"] / data["rss_w"]).to_numpy()[0]
    np.testing.assert_allclose(ratio[far], 1.0, atol=0.02)


def test_figures_show_every_layer(mapped, octant, study_file, tmp_path):
    folder = tmp_path / "maps"
    mapped("--spreads", "--local-mean-disc", "--figures", folder, room=ROOM + CABINET)
    woken = {"wake_margin.png"}  # of tags that the reader wakes
    assert {p.name for p in folder.iterdir()} == set(PAGES) - woken
    assert all(p.read_bytes().startswith(b"\x89PNG") for p in folder.iterdir())
    before = {path: path.read_bytes() for path in (tmp_path / "map.nc", *folder.iterdir())}
    whole = "--spreads", "--local-mean-disc", "--figures", folder
    call = ("map", tmp_path / "study.toml", "--out", tmp_path / "map.nc", *whole)
    same = octant(*call)
    assert (same.code, same.out.splitlines()[-1]) == (
        0,
        f"written: {tmp_path / 'map.nc'} and {folder}",
    )
    assert "map.nc is complete already; nothing was written." in same.err
    (folder / "power.png").unlink()
    assert "only what is made of it is written" in octant(*call).err
    assert {path: path.read_bytes() for path in before} == before
    again = octant(
        "map", study_file(), "--out", tmp_path / "other.nc", "--figures", folder
    ).refused()
    assert "--force" in again
    alone = tmp_path / "alone"
    mapped("--isotropic", "--figures", alone, "--force")
    assert sorted(p.name for p in alone.iterdir()) == ["path_count.png", "power.png"]
