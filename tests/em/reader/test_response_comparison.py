"""Laws of the comparison: nothing off by itself, a known error comes out as it went in."""

import dataclasses
import math

import numpy as np
import pytest

from octant.em.reader.comparison import compare_responses
from octant.em.reader.response import sector_response
from octant.geometries.errors import AntennaError

F = 2.4e9
AZIMUTHS = np.arange(8) * math.pi / 4
THETA = [math.radians(40.0), math.radians(60.0)]


@pytest.fixture(scope="module")
def sector():
    return sector_response(AZIMUTHS, frequency_hz=F, exponent=2.0)


def test_a_response_is_not_off_itself(sector):
    same = compare_responses(sector, sector, THETA)
    assert same.offset_db == pytest.approx(0.0, abs=1e-9)
    assert same.strong_rms_db == pytest.approx(0.0, abs=1e-9)
    assert same.weak_rms_db == pytest.approx(0.0, abs=1e-9)
    assert same.faint_rms_db == pytest.approx(0.0, abs=1e-9)
    assert same.other_antenna_share == pytest.approx(0.0, abs=1e-12)
    assert same.model == "sector"


def test_a_level_is_an_offset_and_no_pattern_error(sector):
    louder = dataclasses.replace(sector, pattern=sector.pattern * math.sqrt(2.0))
    found = compare_responses(sector, louder, THETA)
    assert found.offset_db == pytest.approx(10.0 * math.log10(2.0))
    assert found.strong_rms_db == pytest.approx(0.0, abs=1e-9)
    assert found.other_antenna_share == pytest.approx(0.0, abs=1e-12)


def test_a_ripple_in_azimuth_comes_out_as_its_rms(sector):
    # exp(a sin 40 phi) is 8.686 a dB high: rms over whole periods 8.686 a / sqrt 2
    ripple = np.exp(0.05 * np.sin(40.0 * sector.phi_rad))
    wavy = dataclasses.replace(sector, pattern=sector.pattern * ripple)
    found = compare_responses(sector, wavy, THETA)
    expected = 20.0 / math.log(10.0) * 0.05 / math.sqrt(2.0)
    assert found.strong_rms_db == pytest.approx(expected, rel=0.02)
    assert found.weak_rms_db == pytest.approx(expected, rel=0.1)


def test_swapped_antennas_name_the_wrong_one_everywhere(sector):
    moved = dataclasses.replace(sector, pattern=np.roll(sector.pattern, 1, axis=0))
    assert compare_responses(sector, moved, THETA).other_antenna_share == pytest.approx(
        1.0, abs=0.03
    )


def test_antennas_that_are_all_equal_are_right_once_in_eight(sector):
    alike = dataclasses.replace(
        sector, pattern=np.repeat(sector.pattern[:1], 8, axis=0) * 0.0 + sector.pattern.mean()
    )
    found = compare_responses(sector, alike, THETA)
    assert found.other_antenna_share == pytest.approx(7.0 / 8.0, abs=1e-6)


def test_readers_of_other_sizes_are_refused(sector):
    with pytest.raises(AntennaError, match="8 and 4"):
        compare_responses(sector, sector_response(AZIMUTHS[::2], frequency_hz=F), THETA)


def test_each_sector_of_level_has_the_error_that_was_put_into_it(sector):
    """Gains 10 to 20 dB below the maximum 2 dB up, those further down 4 dB down."""
    base = np.stack((sector.pattern[:, 0], np.full(sector.pattern[:, 0].shape, 0.05)), axis=1)
    truth = dataclasses.replace(sector, pattern=base)
    gain = np.sum(np.abs(base) ** 2, axis=1, keepdims=True)
    below = 10.0 * np.log10(np.max(gain, axis=(2, 3), keepdims=True) / np.maximum(gain, 1e-12))
    change_db = np.where(below > 20.0, -4.0, np.where(below > 10.0, 2.0, 0.0))
    bent = dataclasses.replace(sector, pattern=base * 10.0 ** (change_db / 20.0))
    found = compare_responses(truth, bent, THETA)
    assert found.strong_rms_db == pytest.approx(0.0, abs=0.05)
    assert found.weak_rms_db == pytest.approx(2.0, abs=0.1)
    assert found.faint_rms_db == pytest.approx(4.0, abs=0.1)
