"""What spoils a bearing inside concrete walls, and what helps: an independent prototype's order."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from octant.em.reader.response import sector_response
from octant.reader_design.setting.design import reader_responses
from octant.reader_design.setting.setting import build_setting

BENCH = Path(__file__).resolve().parents[3] / "benchmarks" / "bench_room_bearing.py"
SPEC = importlib.util.spec_from_file_location("bench_room_bearing", BENCH)
bench = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(bench)

FEW = bench.CHANNELS_HZ[::7]


def reader_of(plate_height_m):
    """A thesis reader by rays; its patterns serve all channels of so narrow a band."""
    text = f"response = 'rays'\nplate_height_m = {plate_height_m}\n"
    study = bench.study_of(room=False, channels=(), antenna="dipole", reader=text)
    return reader_responses(study.reader, study.radio)[0]


def quantiles_deg(reader, **case):
    """Median and 90 % of the errors of a small version of a case."""
    given = {"room": True, "channels": (), "antenna": "dipole", **case}
    study = bench.study_of(**given, reader="")
    responses = [replace(reader, frequency_hz=f) for f in study.radio.frequencies_hz]
    setting = build_setting(study).with_responses(responses)
    errors = bench.errors_deg(setting, antenna=given["antenna"], poses=400)
    return np.quantile(errors, [0.5, 0.9])


@pytest.fixture(scope="module")
def reader():
    return reader_of(0.08)


@pytest.fixture(scope="module")
def plain(reader):
    return quantiles_deg(reader)


@pytest.mark.slow
def test_concrete_walls_spoil_the_bearing_that_free_space_gives(reader, plain):
    free = quantiles_deg(reader, room=False)
    assert free[0] < 3.0
    assert 10.0 < plain[0] < 35.0
    assert 55.0 < plain[1] < 125.0


@pytest.mark.slow
def test_without_plates_the_room_leaves_no_bearing(plain):
    bare = quantiles_deg(reader_of(0.0))
    assert bare[0] > 1.7 * plain[0]
    assert bare[1] > 120.0


@pytest.mark.slow
def test_channels_and_a_tag_that_looks_down_each_help_and_both_help_most(reader, plain):
    channels = quantiles_deg(reader, channels=FEW)
    downward = quantiles_deg(reader, antenna="cosine")
    both = quantiles_deg(reader, channels=FEW, antenna="cosine")
    for better in (channels, downward):
        assert (better < 0.8 * plain).all()
        assert (both < better).all()


def test_random_poses_come_from_the_generator_and_lie_in_the_area():
    study = bench.study_of(room=True, channels=(), antenna="dipole", reader="")
    setting = build_setting(study)
    response = sector_response(np.arange(8) * np.pi / 4, frequency_hz=2.4e9)

    def drawn(seed):
        rng = np.random.default_rng(seed)
        return bench.random_pose_errors_rad(
            setting.with_responses([response]), area_m=(5.0, 5.0), poses=50, rng=rng
        )

    np.testing.assert_array_equal(drawn(1), drawn(1))
    assert (drawn(1) != drawn(2)).any()
    assert drawn(1).shape == (50,)
