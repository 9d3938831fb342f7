import numpy as np
import pytest
from scipy.integrate import dblquad
from scipy.special import sici

from octant.em.antennas import make_antenna
from octant.geometries.errors import AntennaError

F = 2.4e9
WAVELENGTH = 299792458.0 / F


def gain_dbi(antenna, theta_rad):
    return 10.0 * np.log10(np.sum(np.abs(antenna.far_field(theta_rad, 0.3)) ** 2))


def test_half_wave_dipole_and_quarter_wave_monopole_have_the_published_gain():
    assert gain_dbi(make_antenna("dipole", F), np.pi / 2) == pytest.approx(2.1509, abs=5e-5)
    assert gain_dbi(make_antenna("monopole", F), np.pi / 2) == pytest.approx(5.1612, abs=5e-5)


@pytest.mark.parametrize("wavelengths", [0.1, 0.3, 0.5, 0.8, 1.0, 1.25, 2.3])
def test_directivity_equals_the_closed_form_of_any_length(wavelengths):
    """Balanis (2005), equations 4-68 and 4-75."""
    kl = 2.0 * np.pi * wavelengths
    si1, ci1 = sici(kl)
    si2, ci2 = sici(2.0 * kl)
    q = (
        np.euler_gamma
        + np.log(kl)
        - ci1
        + 0.5 * np.sin(kl) * (si2 - 2.0 * si1)
        + 0.5 * np.cos(kl) * (np.euler_gamma + np.log(kl / 2.0) + ci2 - 2.0 * ci1)
    )
    theta = np.linspace(0.05, 3.0, 50)
    pattern = (np.cos(0.5 * kl * np.cos(theta)) - np.cos(0.5 * kl)) / np.sin(theta)
    f = make_antenna("dipole", F, length_m=wavelengths * WAVELENGTH).far_field(theta, 0.0)
    assert np.abs(f[:, 0]) ** 2 == pytest.approx(2.0 * pattern**2 / q, rel=1e-10)


def test_very_short_dipole_becomes_hertzian():
    f = make_antenna("dipole", F, length_m=1e-5 * WAVELENGTH).far_field(np.pi / 2, 0.0)
    assert abs(f[0]) ** 2 == pytest.approx(1.5, rel=1e-9)


@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 0, 0), (1, -2, 0.5)])
def test_every_axis_radiates_all_of_its_power(axis):
    antenna = make_antenna("dipole", F, axis=axis)

    def flux(theta, phi):
        return np.sum(np.abs(antenna.far_field(theta, phi)) ** 2) * np.sin(theta)

    total, _ = dblquad(flux, 0, 2 * np.pi, 0, np.pi, epsabs=1e-5)
    assert total == pytest.approx(4.0 * np.pi, rel=1e-5)


def test_nothing_is_radiated_along_the_axis():
    assert np.abs(make_antenna("dipole", F).far_field([0.0, np.pi], 0.7)).max() == 0.0


def test_monopole_is_silent_below_its_plane():
    assert np.abs(make_antenna("monopole", F).far_field([1.6, 2.0, 3.0], 0.0)).max() == 0.0


def test_isotropic_has_unit_theta_component_everywhere():
    theta = np.linspace(0.0, np.pi, 7)
    f = make_antenna("isotropic_theta", F).far_field(theta, 0.0)
    assert f[:, 0] == pytest.approx(np.ones(7), abs=1e-12)
    assert np.abs(f[:, 1]).max() < 1e-12


def test_tilted_dipole_is_the_turned_vertical_one():
    theta = np.linspace(0.1, 3.0, 9)
    lying = make_antenna("dipole", F, axis=(1, 0, 0)).far_field(theta, np.pi / 2)
    # In the plane x = 0 a dipole along x radiates its broadside gain, polarised along -phi.
    assert np.abs(lying[:, 0]).max() < 1e-12
    assert np.abs(lying[:, 1]) ** 2 == pytest.approx(np.full(9, 1.640922377), rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"kind": "dipol", "frequency_hz": F}, "allowed are dipole"),
        ({"kind": "dipole", "frequency_hz": -1.0}, "above 0 Hz"),
        ({"kind": "dipole", "frequency_hz": F, "length_m": 0.0}, "above 0 m"),
        ({"kind": "dipole", "frequency_hz": F, "axis": (0, 0, 0)}, "no direction"),
        ({"kind": "dipole", "frequency_hz": F, "axis": (0, np.nan, 1)}, "NaN"),
    ],
)
def test_bad_antennas_say_what_is_allowed(arguments, words):
    with pytest.raises(AntennaError, match=words):
        make_antenna(**arguments)
