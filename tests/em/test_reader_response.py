import numpy as np
import pytest

from octant.em.antennas import make_antenna
from octant.em.reader_response import ReaderResponse, reader_response, sector_response
from octant.geometries.errors import AntennaError
from octant.geometries.reader_body import reader_body

F = 2.4e9
K = 2.0 * np.pi * F / 299792458.0


def directions(n=200, seed=3):
    rng = np.random.default_rng(seed)
    return np.arccos(rng.uniform(-1, 1, n)), rng.uniform(-np.pi, 3 * np.pi, n)


def unit(theta, phi):
    return np.stack((np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)), -1)


def test_isolated_elements_are_shifted_dipoles():
    dipole = make_antenna("dipole", F)
    response = reader_response(reader_body(), dipole, model="isolated", gap_m=0.005)
    theta, phi = directions()
    f = response.far_field(theta, phi)
    alone = dipole.far_field(theta, phi)
    for i, delta in enumerate(np.arange(8) * np.pi / 4):
        place = np.array([0.1 * np.cos(delta), 0.1 * np.sin(delta), 0.005 + dipole.length_m / 2])
        turn = np.exp(1j * K * unit(theta, phi) @ place)
        assert f[i] == pytest.approx(alone * turn[:, None], abs=2e-7)


def test_interpolation_is_continuous_over_the_poles():
    """A field that is one constant vector has patterns that turn with azimuth at the poles."""
    vector = np.array([0.3, -1.1, 0.4])
    theta = np.linspace(0, np.pi, 121)[:, None]
    phi = (np.arange(240) * 2 * np.pi / 240)[None, :]

    def components(theta, phi):
        t = np.stack((np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), -np.sin(theta)), -1)
        p = np.stack((-np.sin(phi), np.cos(phi), np.zeros_like(phi)), -1)
        return np.stack((t @ vector, p @ vector))

    table = components(*np.broadcast_arrays(theta, phi)).astype(complex)
    response = ReaderResponse(
        model="constant",
        frequency_hz=F,
        azimuths_rad=[0.0],
        phase_centres_m=[[0.0, 0.0, 0.0]],
        pattern=table[None],
    )
    theta, phi = directions()
    theta[:20] *= 0.01
    theta[20:40] = np.pi - 0.01 * theta[20:40]
    expected = np.moveaxis(components(theta, phi), 0, -1)
    assert response.far_field(theta, phi)[0] == pytest.approx(expected, abs=1e-6)


def test_rays_over_a_ground_plane_alone_are_the_two_image_model():
    """Straight up from the plane, where the reflection point lies well within it: F_theta of the
    element and of its image, which has the same sign for a vertical current over a conductor."""
    dipole = make_antenna("dipole", F)
    body = reader_body(plate_height_m=0.0, antenna_radius_m=0.0001, ground_plane_m=2.0)
    response = reader_response(body, dipole, model="rays", gap_m=0.005)
    theta, phi = np.linspace(0.1, 1.4, 20), np.full(20, 0.2)
    centre = np.array([0.0001, 0.0, 0.005 + dipole.length_m / 2])
    image = centre * (1, 1, -1)
    up = unit(theta, phi)
    alone = dipole.far_field(theta, phi)[:, 0]
    expected = alone * (np.exp(1j * K * up @ centre) + np.exp(1j * K * up @ image))
    assert response.far_field(theta, phi)[0, :, 0] == pytest.approx(expected, abs=3e-4)


def test_rays_shadow_of_the_ground_plane_is_dark():
    dipole = make_antenna("dipole", F)
    body = reader_body(plate_height_m=0.0, ground_plane_m=2.0)
    response = reader_response(body, dipole, model="rays", gap_m=0.005)
    assert np.abs(response.far_field(np.full(5, 2.9), np.linspace(0, 6, 5))).max() == 0.0


def test_rays_of_a_round_reader_have_its_symmetry():
    response = reader_response(
        reader_body(ground_plane_shape="round"),
        make_antenna("dipole", F),
        model="rays",
        gap_m=0.005,
    )
    p = np.abs(response.pattern[:, 0]) ** 2
    for i in range(8):
        # Rims and shadow boundaries fall within one cell; elsewhere the patterns are equal.
        turned = np.roll(p[0], 30 * i, axis=1)
        assert np.mean(np.abs(p[i] - turned) > 1e-6) < 2e-3


def test_rays_say_what_they_leave_out():
    response = reader_response(reader_body(), make_antenna("dipole", F), model="rays", gap_m=0.005)
    assert any("geometrical optics" in w for w in response.warnings)


def test_sector_window_is_half_power_at_its_documented_width():
    response = sector_response([0.0, np.pi / 2], frequency_hz=F)
    half = np.radians(94.1 / 2.0)
    f = np.abs(response.far_field(np.full(2, np.pi / 2), [0.0, half])[0, :, 0]) ** 2
    assert f[1] / f[0] == pytest.approx(0.5, abs=0.005)


@pytest.mark.parametrize(
    ("change", "words"),
    [({"model": "ray"}, "allowed are rays, isolated"), ({"gap_m": -0.1}, "0 m or more")],
)
def test_bad_responses_are_refused(change, words):
    arguments = {"model": "isolated", "gap_m": 0.005, **change}
    with pytest.raises(AntennaError, match=words):
        reader_response(reader_body(), make_antenna("dipole", F), **arguments)
