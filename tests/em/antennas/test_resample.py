"""Patterns on other grids, against the closed form of a tilted, displaced dipole."""

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.antennas.pattern_files.common import PatternTable
from octant.em.antennas.pattern_files.resample import move_phase, resample
from octant.geometries.errors import PatternFileError

F_HZ = 2.4e9
TILTED = make_antenna("dipole", F_HZ, axis=(0.3, 0.5, 0.8))


def unit(theta, phi):
    parts = (np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta))
    return np.stack(np.broadcast_arrays(*parts), -1)


def far(theta, phi, place=(0.0, 0.0, 0.0)):
    field = np.moveaxis(TILTED.far_field(theta, phi), -1, 0)
    k = 2 * np.pi * F_HZ / 299792458.0
    return field * np.exp(1j * k * unit(theta, phi) @ np.array(place))


def table(theta, phi, place=(0.0, 0.0, 0.0), **more):
    return PatternTable(
        frequency_hz=F_HZ,
        theta_rad=theta,
        phi_rad=phi,
        field=far(theta[:, None], phi[None, :], place),
        kind="realised_gain",
        source="a.ffe, line 1",
        **more,
    )


def grid(step_deg, theta_from=0.0, phi_from=0.0):
    theta = np.radians(np.arange(theta_from, 180.0 + 1e-9, step_deg))
    return theta, np.radians(phi_from + np.arange(0.0, 360.0, step_deg))


WANTED = (np.radians(np.linspace(0.0, 180.0, 73)), np.radians(np.linspace(-180.0, 540.0, 97)))


@pytest.mark.parametrize(
    ("theta", "phi"),
    [
        grid(5.0),
        grid(5.0, theta_from=2.5),  # no direction at the poles
        grid(5.0, phi_from=1.0),  # nothing at phi 0
        (grid(5.0)[0], np.radians(np.arange(0.0, 360.0, 7.2 / 1.6))),
        (np.radians(np.r_[0:60:5, 60:120:3, 120:181:6]), grid(5.0)[1]),  # uneven
        (grid(4.0)[0], np.radians(np.arange(75) * 4.8)),  # odd number of azimuths
    ],
)
def test_any_grid_gives_the_pattern_everywhere_over_poles_and_seam(theta, phi):
    got = resample(table(theta, phi), *WANTED)
    wanted = far(WANTED[0][:, None], WANTED[1][None, :])
    assert np.abs(got - wanted).max() < 3e-4


def test_the_own_directions_come_back():
    theta, phi = grid(10.0)
    first = table(theta, phi)
    np.testing.assert_allclose(resample(first, theta, phi), first.field, atol=1e-14)


def test_phase_moves_with_its_reference():
    theta, phi = grid(15.0)
    place = (0.1, -0.05, 0.04)
    at_centre = table(theta, phi, place)
    np.testing.assert_allclose(
        move_phase(at_centre, F_HZ, place), far(theta[:, None], phi[None, :]), atol=1e-13
    )
    about_itself = table(theta, phi, origin_m=place)
    np.testing.assert_allclose(move_phase(about_itself, F_HZ), at_centre.field, atol=1e-13)


def test_amplitudes_do_not_change_sign_over_the_pole_nor_fall_below_zero():
    theta, phi = grid(10.0)
    field = np.zeros((2, len(theta), len(phi)))
    field[0] = np.abs(np.cos(theta))[:, None] ** 8
    amplitudes = PatternTable(
        frequency_hz=F_HZ,
        theta_rad=theta,
        phi_rad=phi,
        field=field,
        kind="gain",
        phase_known=False,
        source="a.msi",
    )
    got = resample(amplitudes, np.radians([0.0, 1.0, 2.0, 85.0, 95.0]), phi)
    assert got.real.min() >= 0.0
    np.testing.assert_allclose(got[0, 1, 0], np.cos(np.radians(1.0)) ** 8, atol=2e-3)


def test_half_spaces_are_refused_or_taken_as_nothing_below():
    theta = np.radians(np.arange(0.0, 90.1, 5.0))
    upper = table(theta, grid(5.0)[1])
    with pytest.raises(PatternFileError, match=r"a\.ffe, line 1: theta covers 0 to 90 deg only"):
        resample(upper, *WANTED)
    got = resample(upper, *WANTED, outside="zero")
    below = WANTED[0] > np.pi / 2 + 1e-9
    assert np.abs(got[:, below]).max() == 0.0
    wanted = far(WANTED[0][:, None], WANTED[1][None, :])
    assert np.abs(got - wanted)[:, ~below].max() < 3e-3


@pytest.mark.parametrize("outside", ["error", "zero"])
def test_missing_azimuths_are_refused(outside):
    part = table(grid(5.0)[0], np.radians(np.arange(0.0, 181.0, 5.0)))
    with pytest.raises(PatternFileError, match="phi covers 0 to 180 deg only"):
        resample(part, *WANTED, outside=outside)
    cut = table(grid(5.0)[0], np.radians([0.0, 180.0]))
    with pytest.raises(PatternFileError, match="cut, not a pattern"):
        resample(cut, *WANTED, outside=outside)


def test_an_unknown_rule_for_open_directions_is_refused():
    with pytest.raises(PatternFileError, match="error, zero"):
        resample(table(*grid(5.0)), *WANTED, outside="nearest")
