"""Passive UHF tags by the verbs: where they wake, how far they are read, what robots read."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest

from octant.reader_design.showing.netcdf import read_dataset

EXAMPLES = Path(__file__).parents[2] / "examples"
STUDY = """
name = "uhf"
[radio]
frequency_hz = {frequency_hz}
[room]
{room}
[[tag]]
id = "P"
position_m = [1.0, 1.0, 1.1]
antenna = "dipole"
kind = "passive"
sensitivity_dbm = -18.0
[[tag]]
id = "A"
position_m = [2.0, 1.0, 1.1]
antenna = "dipole"
[rfid]
region = "{region}"
reader_sensitivity_dbm = -90.0
[reader]
response = "isolated"
ground_plane_m = 0.5
antenna_radius_m = 0.2
height_m = 1.0
[solver]
max_reflections = 1
[map]
spacing_m = {spacing_m}
margin_m = 20.0
[mission]
navigator = "thesis"
start_m = [9.0, 1.5]
heading_deg = 180.0
tags = ["P"]
max_time_s = 5.0
"""
OPEN = "free_space = true"


@pytest.fixture
def uhf(octant, study_file):
    def call(verb, *options, frequency_hz=868e6, region="etsi", room=OPEN, spacing_m=0.5):
        keys = {"frequency_hz": frequency_hz, "region": region, "room": room}
        study = study_file(STUDY.format(spacing_m=spacing_m, **keys))
        done = octant(verb, study, *options)
        assert done.code == 0, done.err
        return done

    return call


@pytest.mark.parametrize(
    ("frequency_hz", "region", "eirp_w"), [(868e6, "etsi", 2.0 * 10**0.215), (915e6, "fcc", 4.0)]
)
def test_the_map_wakes_the_tag_as_far_as_the_link_budget_reaches(
    uhf, tmp_path, frequency_hz, region, eirp_w
):
    out = tmp_path / "map.nc"
    keys = {"frequency_hz": frequency_hz, "region": region}
    done = uhf("map", "--out", out, "--isotropic", "--figures", tmp_path / "figures", **keys)
    data = read_dataset(out)
    budget_m = 299_792_458.0 / frequency_hz / (4.0 * math.pi)
    budget_m *= math.sqrt(eirp_w * 1.641 / 10.0 ** (-18.0 / 10.0 - 3.0))
    passive = data.sel(tag="P")
    distance = np.hypot(passive["x"] - 1.0, passive["y"] - 1.0).to_numpy()
    awake = passive["wake_margin_db"].to_numpy() >= 0.0
    assert distance[awake].max() == pytest.approx(budget_m, rel=0.05)
    assert distance[~awake & (distance > 1.0)].min() == pytest.approx(budget_m, rel=0.05)
    for name in ("read_range", "read_range_closed_form", "read_range_peak_gains"):
        assert float(passive[name]) == pytest.approx(budget_m, rel=0.05)
    assert f"read range in the open {float(passive['read_range']):.2f} m" in done.out
    level = 10.0 * np.log10(passive["chip_power_w"].to_numpy() * 1e3) + 18.0
    np.testing.assert_allclose(level, passive["wake_margin_db"].to_numpy(), atol=1e-9)
    rss = passive["rss_w"].to_numpy()
    assert ((rss > 0.0) == awake).all()
    assert ((passive["reading_antennas"].to_numpy() > 0.0) == awake).all()
    active = data.sel(tag="A")
    assert np.isnan(active["wake_margin_db"]).all()
    assert (active["rss_w"] > 0.0).all()
    assert (tmp_path / "figures" / "wake_margin.png").is_file()


def test_the_readers_map_keeps_a_layer_for_every_antenna(uhf, tmp_path):
    out = tmp_path / "map.nc"
    room = "box_m = [9.5, 3.0, 3.0]"
    uhf("map", "--out", out, "--tag", "P", room=room, spacing_m=1.0)
    whole = read_dataset(out).sel(tag="P")
    assert whole["chip_power_w"].dims == ("x", "y", "antenna")
    best = whole["chip_power_w"].max("antenna").to_numpy()
    np.testing.assert_allclose(
        10.0 * np.log10(best / 10.0**-4.8), whole["wake_margin_db"].to_numpy(), atol=1e-9
    )
    one = tmp_path / "one.nc"
    uhf("map", "--out", one, "--tag", "P", "--antenna", "3", room=room, spacing_m=1.0)
    third = read_dataset(one).sel(tag="P")
    chosen = whole["chip_power_w"].sel(antenna=3).to_numpy()
    assert (third["chip_power_w"].to_numpy()[..., 0] == chosen).all()
    margin = third["wake_margin_db"].to_numpy()
    np.testing.assert_allclose(10.0 * np.log10(chosen / 10.0**-4.8), margin, atol=1e-9)


def test_rss_of_a_sleeping_tag_is_zero(uhf, tmp_path):
    poses, out = tmp_path / "poses.csv", tmp_path / "rss.csv"
    poses.write_text("x_m,y_m,heading_deg\n4.0,1.0,0.0\n30.0,1.0,0.0\n")
    uhf("rss", "--tag", "P", "--poses", poses, "--csv", out)
    near, far = [
        [float(v) for v in row[3:]] for row in list(csv.reader(out.read_text().splitlines()))[1:]
    ]
    assert min(near) > 0.0
    assert max(far) == 0.0


@pytest.mark.parametrize(("start", "awake"), [("[9.0, 1.5]", True), ("[60.0, 1.5]", False)])
def test_a_robot_reads_nothing_of_a_tag_that_sleeps(octant, study_file, tmp_path, start, awake):
    text = STUDY.format(frequency_hz=868e6, region="etsi", room=OPEN, spacing_m=1.0)
    study = study_file(text.replace("[9.0, 1.5]", start))
    done = octant("navigate", study, "--out", tmp_path / "out", "--runs", "1")
    assert done.code == 0, done.err
    rows = list(csv.DictReader((tmp_path / "out" / "trajectory.csv").read_text().splitlines()))
    heard = [float(row[f"rss_{i}_w"]) > 0.0 for row in rows for i in range(1, 9)]
    assert any(heard) == awake
    if awake:
        assert not all(heard)  # an inventory does not always read the tag in its time
    again = octant("navigate", study, "--out", tmp_path / "out", "--runs", "1")
    assert "complete already" in again.err


@pytest.mark.slow
@pytest.mark.parametrize("name", ["passive_uhf", "passive_uhf_915"])
def test_the_examples_run_end_to_end(octant, tmp_path, name):
    done = octant("study", EXAMPLES / f"{name}.toml", "--out", tmp_path, "--quick")
    assert done.code == 0, done.err
    data = read_dataset(tmp_path / "results.nc")
    computed = data["map_read_range"].to_numpy()
    np.testing.assert_allclose(computed, data["map_read_range_closed_form"], rtol=1e-6)
    np.testing.assert_allclose(computed, data["map_read_range_peak_gains"], rtol=0.05)
    margin = data["map_wake_margin_db"].to_numpy()
    assert (margin > 0.0).any()
    assert (margin < 0.0).any()
    assert (tmp_path / "figures" / "map_wake.png").is_file()
    assert "Tags that the reader wakes" in (tmp_path / "report.html").read_text()


@pytest.mark.slow
def test_passive_tags_that_a_mast_wakes_lead_the_robot(octant, tmp_path):
    study = EXAMPLES / "passive_uhf_drive.toml"
    done = octant("navigate", study, "--out", tmp_path, "--runs", "2")
    assert done.code == 0, done.err
    rows = list(csv.DictReader((tmp_path / "missions.csv").read_text().splitlines()))
    assert [row["success"].lower() for row in rows] in (["true"] * 2, ["1"] * 2)


def test_track_has_no_tags_that_the_reader_wakes(octant, study_file, tmp_path):
    text = STUDY.format(frequency_hz=868e6, region="etsi", room=OPEN, spacing_m=1.0)
    text = text[: text.index("[mission]")]
    done = octant("track", study_file(text), "--out", tmp_path / "out")
    assert "[rfid]" in done.refused() or "[map]" in done.refused()
