"""Patterns that end in a step: nothing rings, nothing leaks; smooth ones are as they were."""

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from octant.em.antennas.from_files import antenna_from_pattern_file
from octant.em.antennas.kinds import Antenna, make_antenna
from octant.em.antennas.pattern_files.common import PatternTable
from octant.em.antennas.pattern_files.cuts import write_csv
from octant.em.antennas.pattern_files.resample import resample
from octant.em.decibels import decibels
from octant.geometries.errors import PhysicsWarning

F_HZ = 2.4e9
FINE = (np.radians(np.linspace(0.0, 180.0, 361)), np.radians(np.linspace(0.0, 360.0, 91)))


def table(theta_deg, phi_deg, field, *, phase_known=True):
    return PatternTable(
        frequency_hz=F_HZ,
        theta_rad=np.radians(theta_deg),
        phi_rad=np.radians(phi_deg),
        field=field,
        kind="realised_gain",
        phase_known=phase_known,
        source="a.csv, line 2",
    )


def half_space(step_deg, last_deg, *, around=(0.0, 360.0), phase_known=True, edge=1.0):
    """Unit gain in theta down to an angle, on a range of azimuths, and exactly nothing beyond."""
    theta, phi = np.arange(0.0, 180.1, step_deg), np.arange(0.0, 360.0, step_deg)
    lit = (theta[:, None] <= last_deg) & (phi >= around[0]) & (phi < around[1])
    field = np.zeros((2, len(theta), len(phi)))
    field[0] = np.where(lit, 1.0, 0.0)
    field[0, theta == last_deg] *= edge
    return table(theta, phi, field, phase_known=phase_known)


def of_file(folder, pattern):
    path = folder / "a.csv"
    write_csv(path, [pattern])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysicsWarning)
        return antenna_from_pattern_file(path, frequency_hz=F_HZ)


def gain(field):
    return np.sum(np.abs(field) ** 2, axis=0)


@given(
    step_deg=st.sampled_from([5.0, 10.0]),
    last=st.floats(0.2, 0.8),
    width=st.sampled_from([90.0, 180.0, 360.0]),
    phase_known=st.booleans(),
    edge=st.sampled_from([1.0, 0.7, 0.5, 0.1]),
)
def test_a_step_neither_rings_above_the_table_nor_leaks_between_zeros(
    step_deg, last, width, phase_known, edge
):
    last_deg = step_deg * round(last * 180.0 / step_deg)
    pattern = half_space(
        step_deg, last_deg, around=(0.0, width), phase_known=phase_known, edge=edge
    )
    made = gain(resample(pattern, *FINE))
    assert made.max() <= 1.0 + 1e-9
    assert made[FINE[0] >= np.radians(last_deg + step_deg) - 1e-9].max() < 1e-24
    dark = (FINE[1] > np.radians(width) - 1e-9) & (FINE[1] < np.radians(360.0 - step_deg) + 1e-9)
    assert made[:, dark].max(initial=0.0) < 1e-24
    lit = FINE[0] < np.radians(last_deg - 2.0 * step_deg)
    inside = (FINE[1] > np.radians(step_deg)) & (FINE[1] < np.radians(width - 2.0 * step_deg))
    np.testing.assert_allclose(made[np.ix_(lit, inside)], 1.0, rtol=1e-9)


@pytest.mark.parametrize(
    ("step_deg", "phase_known"), [(2.0, True), (5.0, False), (10.0, True), (10.0, False)]
)
def test_an_antenna_of_a_file_keeps_the_steps_of_the_file(step_deg, phase_known, tmp_path):
    antenna = of_file(tmp_path, half_space(step_deg, 90.0, phase_known=phase_known))
    theta = np.radians(np.linspace(0.0, 180.0, 721))
    level = gain(np.moveaxis(antenna.far_field(theta[:, None], FINE[1]), -1, 0))
    assert level.max() <= 1.0 + 1e-9
    assert level[theta > np.radians(90.0 + step_deg) + 1e-9].max() < 1e-24
    np.testing.assert_allclose(level[theta < np.radians(90.0 - step_deg)], 1.0, rtol=1e-9)


def test_equal_amplitudes_stay_equal_at_the_poles():
    field = np.zeros((2, 7, 8), dtype=np.complex128)
    field[1] = 1.0
    antenna = Antenna(
        kind="pattern", length_m=0.0, frequency_hz=F_HZ, axis=np.array([0.0, 0.0, 1.0]),
        pattern=field,
    )  # fmt: skip
    level = gain(np.moveaxis(antenna.far_field(FINE[0][:, None], FINE[1]), -1, 0))
    np.testing.assert_allclose(level, 1.0, rtol=1e-12)


def smooth(step_deg, place_m):
    theta, phi = np.arange(0.0, 180.1, step_deg), np.arange(0.0, 360.0, step_deg)
    return table(theta, phi, tilted(np.radians(theta), np.radians(phi), place_m))


def tilted(theta_rad, phi_rad, place_m):
    dipole = make_antenna("dipole", F_HZ, axis=(0.3, 0.5, 0.8))
    field = np.moveaxis(dipole.far_field(theta_rad[:, None], phi_rad), -1, 0)
    sine = np.sin(theta_rad)[:, None]
    across = (sine * np.cos(phi_rad), sine * np.sin(phi_rad))
    unit = np.stack((*across, np.cos(theta_rad)[:, None] + 0.0 * across[0]), axis=-1)
    return field * np.exp(2j * np.pi * F_HZ / 299792458.0 * unit @ np.array(place_m))


# greatest error over the greatest amplitude that plain splines have on these grids
@pytest.mark.parametrize(
    ("step_deg", "place_m", "error"),
    [
        (5.0, (0.0, 0.0, 0.0), 1e-5),
        (10.0, (0.0, 0.0, 0.0), 2e-4),
        (5.0, (0.1, 0.05, 0.02), 1.5e-3),
        (10.0, (0.1, 0.05, 0.02), 3e-2),
    ],
)
def test_smooth_patterns_have_no_steps_and_plain_splines(step_deg, place_m, error, tmp_path):
    pattern = smooth(step_deg, place_m)
    made = resample(pattern, *FINE)
    wanted = tilted(*FINE, place_m)
    assert np.abs(made - wanted).max() < error * np.abs(wanted).max()
    assert of_file(tmp_path, pattern).steps is None


@pytest.mark.parametrize("power", [1, 2, 4, 8, 30])
@pytest.mark.parametrize("step_deg", [5.0, 10.0])
def test_narrow_beams_and_nulls_are_no_steps(step_deg, power, tmp_path):
    theta, phi = np.arange(0.0, 180.1, step_deg), np.arange(0.0, 360.0, step_deg)
    off = np.sin(np.radians(theta))[:, None] * np.cos(np.radians(phi))
    field = np.zeros((2, len(theta), len(phi)))
    field[0] = (0.5 + 0.5 * off) ** power
    antenna = of_file(tmp_path, table(theta, phi, field, phase_known=False))
    assert antenna.steps is None
    level = decibels(gain(np.moveaxis(antenna.far_field(np.radians([90.0]), FINE[1]), -1, 0)))
    wanted = 20.0 * power * np.log10(0.5 + 0.5 * np.cos(FINE[1]) + 1e-12)
    strong = wanted > -20.0
    off_db = np.abs(level.ravel() - wanted)[strong].max()
    assert off_db < (0.5 if power == 30 and step_deg == 10.0 else 0.05)
