import numpy as np
import pytest

from octant.em.antennas.embedded import ReaderResponse
from octant.em.antennas.kinds import make_antenna
from octant.em.reader.rays import ray_patterns
from octant.em.reader.response import reader_response, sector_response
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


def test_rays_say_what_they_leave_out():
    body = reader_body(plate_height_m=0.0)
    response = reader_response(body, make_antenna("dipole", F), model="rays", gap_m=0.005)
    assert any("coupling between antennas" in w for w in response.warnings)
    assert any("matched" in w for w in response.warnings)


def test_rays_refer_each_phase_to_the_antenna_s_own_centre():
    dipole, body = make_antenna("dipole", F), reader_body(plate_height_m=0.0)
    response = reader_response(body, dipole, model="rays", gap_m=0.005)
    at_reader = ray_patterns(
        body, dipole, gap_m=0.005, theta_rad=response.theta_rad, columns=len(response.phi_rad)
    )
    found = response.far_field(response.theta_rad[:, None], response.phi_rad)
    np.testing.assert_allclose(np.moveaxis(found, -1, 1), at_reader, rtol=0.0, atol=1e-9)


def test_a_monopole_s_phase_centre_is_its_foot_on_whichever_plane_it_has():
    monopole = make_antenna("monopole", F)
    for side_m, height_m in ((0.0, 0.0), (0.04, 0.005)):
        body = reader_body(monopole_plane_m=side_m)
        response = reader_response(body, monopole, model="isolated", gap_m=0.005)
        assert response.phase_centres_m[:, 2] == pytest.approx(np.full(8, height_m), abs=0)


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
