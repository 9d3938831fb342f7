"""Draws of build errors: from seed and number alone, of the sizes that the table gives."""

import math

import msgspec
import numpy as np
import pytest

from octant.reader_design.experiments.tolerance.draws import as_drawn, drawn_deviation, regressors
from octant.reader_design.keeping.keys import digest
from octant.reader_design.study_file.tolerance import CommonTolerance, Tolerance

NONE = CommonTolerance(antenna_radius_m=0.0, gap_m=0.0, antenna_length_m=0.0, plate_height_m=0.0)
PLAIN = Tolerance(common=NONE)


def draws(tolerance, count, *, seed=1, antennas=8, radius_m=0.1):
    return [
        drawn_deviation(tolerance, antennas=antennas, antenna_radius_m=radius_m, seed=seed, index=i)
        for i in range(count)
    ]


def test_a_sample_hangs_on_seed_and_number_only():
    first = [digest(d) for d in draws(PLAIN, 5)]
    assert first == [digest(d) for d in draws(PLAIN, 9)][:5]
    assert first[0] != first[1]
    assert first[0] != digest(draws(PLAIN, 1, seed=2)[0])


def test_designs_get_the_same_errors_in_millimetres():
    for near, far in zip(
        draws(PLAIN, 3, radius_m=0.05), draws(PLAIN, 3, radius_m=0.1), strict=True
    ):
        assert np.array_equal(near.build.radial_m, far.build.radial_m)
        assert np.allclose(near.build.azimuth_rad * 0.05, far.build.azimuth_rad * 0.1, rtol=1e-12)
        assert np.array_equal(near.build.lean, far.build.lean)


def test_changing_one_size_leaves_the_other_draws_alone():
    wide = msgspec.structs.replace(PLAIN, gap_m=0.003)
    for one, other in zip(draws(PLAIN, 3), draws(wide, 3), strict=True):
        assert np.allclose(other.build.gap_m, 3.0 * one.build.gap_m, rtol=1e-12)
        assert np.array_equal(other.build.length_m, one.build.length_m)


@pytest.mark.parametrize(("distribution", "deviation"), [("uniform", 3.0**-0.5), ("normal", 1.0)])
def test_errors_have_the_spread_that_the_table_gives(distribution, deviation):
    table = msgspec.structs.replace(PLAIN, distribution=distribution, frequency_percent=2.0)
    sample = draws(table, 1500)
    degree = math.radians(2.0)
    for name, size in (
        ("radial_m", 1e-3),
        ("gap_m", 1e-3),
        ("length_m", 1e-3),
        ("plate_height_m", 1e-3),
        ("plate_azimuth_rad", degree),
        ("azimuth_rad", 1e-2),
    ):
        values = np.concatenate([getattr(d.build, name) for d in sample])
        assert values.std() == pytest.approx(deviation * size, rel=0.03)
        assert abs(values.mean()) < 0.03 * size
        if distribution == "uniform":
            assert np.abs(values).max() <= size
    lean = np.concatenate([np.arctan(d.build.lean) for d in sample])
    assert np.allclose(lean.std(axis=0), deviation * degree, rtol=0.03)
    factors = np.array([d.frequency_factor for d in sample])
    assert factors.std() == pytest.approx(0.02 * deviation, rel=0.06)


def test_common_errors_are_shared_and_added():
    shared = msgspec.structs.replace(PLAIN, common=CommonTolerance(gap_m=0.002))
    for own, both in zip(draws(PLAIN, 4), draws(shared, 4), strict=True):
        extra = both.build.gap_m - own.build.gap_m
        assert np.ptp(extra) < 1e-18
        assert 0.0 < abs(extra[0]) <= 0.002


def test_tolerances_of_zero_build_the_drawing():
    zero = Tolerance(
        position_m=0.0,
        angle_deg=0.0,
        gap_m=0.0,
        antenna_length_m=0.0,
        plate_height_m=0.0,
        ground_plane_m=0.0,
        common=NONE,
    )
    one = draws(zero, 1)[0]
    assert one.build.is_zero
    factors = (one.frequency_factor, one.permittivity_factor, one.conductivity_factor)
    assert factors == (1.0, 1.0, 1.0)


def test_regressors_are_means_and_scatters_that_vary():
    sample = draws(PLAIN, 12)
    names, columns = regressors(sample, 0.1)
    assert columns.shape == (12, len(names))
    assert "frequency: mean" not in names
    gap = np.array([d.build.gap_m for d in sample]) * 1e3
    assert np.allclose(columns[:, names.index("gap: mean")], gap.mean(axis=1))
    assert np.allclose(columns[:, names.index("gap: scatter")], gap.std(axis=1))
    assert regressors([as_drawn(8)] * 3, 0.1)[1].shape == (3, 0)
