"""Numbers rounded as a person would."""

import math

import pytest

from octant.reader_design.showing.numbers import rounded, with_doubt, with_interval


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (1.3234, "dB", "1.32"),
        (-35.4471, "dBm", "-35.4"),
        (2.0713, "°", "2.1"),
        (0.98765, "1", "0.988"),
        (1234.5, "MHz", "1.23e+03"),
        (math.nan, "dB", "–"),
    ],
)
def test_the_unit_decides_the_digits(value, unit, text):
    assert rounded(value, unit) == text


def test_an_interval_or_a_doubt_that_rounds_to_nothing_is_left_out():
    assert with_interval(1.3234, low=1.3233, high=1.3235, unit="dB") == "1.32"
    assert with_interval(1.32, low=1.2, high=1.5, unit="dB") == "1.32 (1.20 to 1.50)"
    assert with_doubt(-2.0714, 1e-6) == "-2.07"
    assert with_doubt(-2.0714, 0.03) == "-2.07 ± 0.03"
