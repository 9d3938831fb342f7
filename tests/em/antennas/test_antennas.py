import numpy as np
import pytest
from scipy.integrate import dblquad
from scipy.special import sici

from octant.em.antennas.kinds import Antenna, make_antenna
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


def mean_gain(antenna):
    """Mean of |F|^2 over the sphere; both hemispheres about the axis apart, as patches need."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    axis, side = antenna.axis, antenna.side
    phi = np.arange(80) * (2.0 * np.pi / 80)
    total = 0.0
    for sign in (-1.0, 1.0):
        c = 0.5 * sign * (nodes + 1.0)[:, None]
        s = np.sqrt(1.0 - c**2)
        d = c[..., None] * axis + (s * np.cos(phi))[..., None] * side
        d = d + (s * np.sin(phi))[..., None] * np.cross(axis, side)
        f = antenna.far_field(
            np.arccos(np.clip(d[..., 2], -1, 1)), np.arctan2(d[..., 1], d[..., 0])
        )
        total += weights @ np.sum(np.abs(f) ** 2, axis=-1).mean(axis=1) / 4.0
    return total


@pytest.mark.parametrize("axis", [None, (0, 0, 1), (1, 0, 0), (1, -2, 0.5)])
@pytest.mark.parametrize("kind", ["patch", "monopole", "dipole"])
def test_gain_over_the_sphere_averages_to_one(kind, axis):
    antenna = make_antenna(kind, F, axis=axis, azimuth_rad=0.4)
    assert mean_gain(antenna) == pytest.approx(1.0, abs=1e-12)


def test_patch_is_the_cavity_model_of_two_slots():
    """Balanis (2005), 14-43 and 14-44: |E| ~ sin t' sinc(Z) cos(Y), t' from the slots' axis."""
    up = make_antenna("patch", F, axis=(0, 0, 1))
    theta = np.linspace(0.0, 0.5 * np.pi, 13)[:, None]
    phi = np.linspace(0.0, 2.0 * np.pi, 17)
    dx, dy = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi)
    shape = np.sqrt(1.0 - dy**2) * np.sinc(0.5 * dy) * np.cos(0.5 * np.pi * dx)
    gain = np.sum(np.abs(up.far_field(theta, phi)) ** 2, axis=-1)
    peak = gain[0, 0]
    np.testing.assert_allclose(gain, peak * shape**2, atol=1e-12)
    broadside = up.far_field(0.0, 0.0)
    assert abs(broadside[0]) ** 2 == pytest.approx(peak)  # polarised along its resonant side
    assert abs(broadside[1]) < 1e-12


def test_patch_faces_down_by_default_and_is_silent_behind():
    patch = make_antenna("patch", F)
    assert patch.axis.tolist() == [0.0, 0.0, -1.0]
    assert np.abs(patch.far_field([0.0, 0.5, 1.5], 0.3)).max() == 0.0
    assert gain_dbi(patch, np.pi) > 8.0


def test_azimuth_turns_a_patch_about_its_axis():
    theta, phi = np.linspace(0.05, 1.4, 7)[:, None], np.linspace(0.0, 6.0, 9)
    still = make_antenna("patch", F, axis=(0, 0, 1)).far_field(theta, phi)
    turned = make_antenna("patch", F, axis=(0, 0, 1), azimuth_rad=0.7).far_field(theta, phi + 0.7)
    np.testing.assert_allclose(turned, still, atol=1e-13)


def tabulated(antenna, step_deg=1.5, **placing):
    rows = round(180 / step_deg) + 1
    theta = np.linspace(0.0, np.pi, rows)[:, None]
    phi = np.arange(2 * (rows - 1)) * (np.pi / (rows - 1))
    pattern = np.moveaxis(antenna.far_field(theta, phi), -1, 0)
    place = {"axis": np.array([0.0, 0.0, 1.0])} | placing
    return Antenna(kind="pattern", length_m=0.0, frequency_hz=F, pattern=pattern, **place)


def directions():
    rng = np.random.default_rng(5)
    return np.arccos(rng.uniform(-1.0, 1.0, 400)), rng.uniform(0.0, 2.0 * np.pi, 400)


def test_a_table_gives_the_antenna_that_it_was_made_of():
    slanted = make_antenna("dipole", F, axis=(1, -2, 0.5))
    error = tabulated(slanted).far_field(*directions()) - slanted.far_field(*directions())
    assert np.abs(error).max() < 1e-5
    coarse = tabulated(slanted, 3.0).far_field(*directions()) - slanted.far_field(*directions())
    assert np.abs(coarse).max() / np.abs(error).max() > 10.0  # fourth order: 16


@pytest.mark.parametrize("pole", [0.0, np.pi])
def test_a_table_is_smooth_over_its_poles(pole):
    slanted = make_antenna("dipole", F, axis=(1, -2, 0.5))
    theta = np.abs(pole - np.array([0.0, 1e-9, 0.003, 0.02]))[:, None]
    phi = np.linspace(0.0, 2.0 * np.pi, 25)
    error = tabulated(slanted).far_field(theta, phi) - slanted.far_field(theta, phi)
    assert np.abs(error).max() < 1e-5


@pytest.mark.parametrize("axis", [(0, 0, -1), (1, 0, 0), (0, 1, 0), (0.3, -0.8, 0.4)])
def test_a_table_turns_with_its_axis_and_azimuth_like_the_antenna(axis):
    patch = make_antenna("patch", F, axis=(0, 0, 1))
    # Slightly off the horizon, where the table cannot follow the patch's shadow boundary.
    table = tabulated(patch, axis=np.array(axis, dtype=float), azimuth_rad=1.1)
    same = make_antenna("patch", F, axis=axis, azimuth_rad=1.1)
    theta, phi = directions()
    d = np.stack((np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)), -1)
    off = np.abs(d @ same.axis) > 0.1
    error = table.far_field(theta, phi)[off] - same.far_field(theta, phi)[off]
    assert np.abs(error).max() < 1e-4


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"pattern": np.zeros((2, 9, 7))}, "even number"),
        ({"pattern": np.full((2, 9, 8), np.nan)}, "NaN"),
        ({"pattern": None}, "do not fit"),
        ({"azimuth_rad": np.inf}, "not an angle"),
    ],
)
def test_tables_that_cannot_be_interpolated_are_refused(changes, words):
    good = {"kind": "pattern", "length_m": 0.0, "frequency_hz": F, "axis": (0, 0, 1)}
    good["pattern"] = np.zeros((2, 9, 8))
    with pytest.raises(AntennaError, match=words):
        Antenna(**(good | changes))


def test_conical_patch_is_the_cavity_model_of_a_ring_of_magnetic_current():
    from scipy.special import j1, jn_zeros

    disc = make_antenna("conical_patch", F)
    radius_rad = np.pi * disc.length_m / disc.wavelength_m
    assert radius_rad == pytest.approx(jn_zeros(1, 1)[0], rel=1e-15)
    down = np.linspace(0.5 * np.pi + 1e-9, np.pi, 50)
    field = disc.far_field(down, 0.4)
    shape = j1(radius_rad * np.sin(down))
    assert np.abs(field[:, 1]).max() < 1e-15  # nothing along phi
    ratio = field[1:-1, 0] / shape[1:-1]
    assert np.ptp(ratio.real) < 1e-12 * abs(ratio[0])
    assert np.abs(disc.far_field([0.0, 1.0, 1.5], 0.4)).max() == 0.0  # silent behind
    assert np.degrees(np.pi - down[np.abs(field[:, 0]).argmax()]) == pytest.approx(28.7, abs=2.0)


def test_conical_patch_is_silent_on_its_axis_and_on_the_horizon():
    disc = make_antenna("conical_patch", F)
    assert np.abs(disc.far_field([np.pi, 0.5 * np.pi + 1e-12], 0.0)).max() < 1e-10


@pytest.mark.parametrize("kind", ["monopole", "patch"])
def test_along_the_plane_under_an_antenna_counts_as_above_it(kind):
    """Else rounding would choose, between ends of one height, between its most and nothing."""
    antenna = make_antenna(kind, F, axis=(0, 0, 1))
    along = antenna.far_field(0.5 * np.pi + np.array([-1e-15, 0.0, 1e-15, 1e-10]), 0.3)
    assert np.abs(along).max() > 0.1
    assert along == pytest.approx(np.tile(along[0], (4, 1)), abs=1e-8)
    assert np.abs(antenna.far_field(0.5 * np.pi + 1e-8, 0.3)).max() == 0.0


@pytest.mark.parametrize("diameter_m", [0.08, 0.15, 0.17])
def test_conical_patch_of_any_diameter_has_mean_gain_one(diameter_m):
    disc = make_antenna("conical_patch", F, length_m=diameter_m, axis=(1, -2, 0.5))
    assert mean_gain(disc) == pytest.approx(1.0, abs=1e-12)


def test_conical_patch_too_wide_is_refused():
    with pytest.raises(AntennaError, match="diameter up to"):
        make_antenna("conical_patch", F, length_m=1.0)
