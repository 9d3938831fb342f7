"""The table ``[sensor]`` in tracking: every key changes what is read, or is refused."""

from pathlib import Path

import numpy as np
import pytest

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.tracking.chapters import neighbouring_runs
from octant.reader_design.experiments.tracking.settings import settings_of
from octant.reader_design.setting.receiver import study_tag_receiver
from octant.reader_design.study_file.loading import parse_study
from octant.reader_design.study_file.sensor import Sensor

TEXT = """
[room]
free_space = true
[track]
chapters = ["{}"]
runs = 2
alpha_dbm = -40.0
beta_per_m = 0.1
rss_mean_db = 0.0
rss_sigma_db = 1.0
wheel_sigma_rad_per_s = 0.01
[[track.trajectory]]
name = "mine"
shape = "line"
waypoints_m = [[0.0, 0.0], [3.0, 3.0]]
duration_s = 20.0
[sensor]
{}
"""
LEVELS = np.tile(np.linspace(-110.0, -30.0, 400), (2, 1))


def study_of(keys="", chapter="neighbouring"):
    return parse_study(TEXT.format(chapter, keys), source="test", directory=Path())


def heard(keys):
    receiver = study_tag_receiver(study_of(keys).sensor)
    rngs = [np.random.default_rng(seed) for seed in range(2)]
    return LEVELS if receiver is None else receiver.heard(LEVELS, rngs)


def test_every_key_changes_what_is_read():
    noise = "bandwidth_hz = 1e9\n"
    cases = {
        "bandwidth_hz": ("", noise),
        "noise_figure_db": (noise, noise + "noise_figure_db = 20"),
        "samples": (noise, noise + "samples = 50"),
        "required_snr_db": (noise, noise + "required_snr_db = 10"),
        "sensitivity_dbm": ("", "sensitivity_dbm = -70"),
        "bits": ("", "bits = 6"),
        "floor_dbm": ("bits = 6", "bits = 6\nfloor_dbm = -80"),
        "full_scale_dbm": ("bits = 6", "bits = 6\nfull_scale_dbm = -50"),
        "drop_out_probability": ("", "drop_out_probability = 0.5"),
        "read_probability": ("", "read_probability = 0.5"),
    }
    assert set(cases) | {"dwell_s"} == set(Sensor.__struct_fields__)
    for key, (before, after) in cases.items():
        assert not np.array_equal(heard(before), heard(after), equal_nan=True), key


def test_readings_are_the_devices():
    level = heard("sensitivity_dbm = -70")
    assert (np.isnan(level) == (LEVELS < -70.0)).all()
    assert level[0, -1] == pytest.approx(-30.0)
    steps = (heard("bits = 6\nfloor_dbm = -90\nfull_scale_dbm = -27") + 90.0) / 1.0
    assert steps[np.isfinite(steps)] == pytest.approx(np.round(steps[np.isfinite(steps)]))
    assert (np.isnan(steps) == (LEVELS < -90.5)).all()
    lost = np.isnan(heard("drop_out_probability = 0.2\nread_probability = 0.5"))
    assert lost.mean() == pytest.approx(0.6, abs=0.06)
    # k T0 B F = -174 dBm/Hz + 90 + 6 dB: weak signals drown in -78 dBm.
    floor = heard("bandwidth_hz = 1e9\nnoise_figure_db = 6\nsamples = 1000")[:, :40]
    assert floor.mean() == pytest.approx(-78.0, abs=0.2)


def test_a_robot_with_a_poor_receiver_still_follows_its_line():
    ends = {}
    for keys in ("", "read_probability = 0.5\nbits = 6"):
        (outcome,), _ = neighbouring_runs(settings_of(study_of(keys)), "mine")
        ends[keys] = outcome.runs.final_error_m
        assert (ends[keys] < 0.3).all()
    assert not np.array_equal(*ends.values())


@pytest.mark.parametrize(
    ("keys", "chapter", "words"),
    [("dwell_s = 0.01", "neighbouring", "sensor.dwell_s"), ("bits = 8", "feedback", "is trained")],
)
def test_what_tracking_cannot_take_is_refused(keys, chapter, words):
    with pytest.raises(ConfigError, match=words):
        settings_of(study_of(keys, chapter))
