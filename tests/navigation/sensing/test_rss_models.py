"""Laws of RSS: the thesis' fits, derivatives, meshes of tags and maps."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from octant.geometries.errors import NavigationError
from octant.navigation.sensing.rss_maps import RssMap
from octant.navigation.sensing.rss_models import (
    XBEE_DISTANCES_M,
    XBEE_RSS_DBM,
    LogDistanceLaw,
    LogExponentialLaw,
    RssNoise,
    TagMesh,
    fit_log_distance,
    fit_log_exponential,
    tag_grid,
)


def test_table_6_1_gives_the_printed_parameters_within_four_per_cent():
    law, rms = fit_log_exponential(XBEE_DISTANCES_M, XBEE_RSS_DBM)
    assert law.alpha_dbm == pytest.approx(-35.5, rel=0.02)
    assert law.beta_per_m == pytest.approx(0.1071, rel=0.04)
    printed = LogExponentialLaw(alpha_dbm=-35.5, beta_per_m=0.1071)
    residual = printed.rss_dbm(np.array(XBEE_DISTANCES_M)) - XBEE_RSS_DBM
    assert 0.0 < np.sqrt(np.mean(residual**2)) - rms < 0.02


def test_the_fit_is_scipys_nonlinear_least_squares():
    d, z = np.array(XBEE_DISTANCES_M), np.array(XBEE_RSS_DBM)
    other = least_squares(lambda p: p[0] * np.exp(p[1] * d) - z, [-30.0, 0.1], xtol=1e-14)
    law, _ = fit_log_exponential(d, z)
    assert [law.alpha_dbm, law.beta_per_m] == pytest.approx(other.x, rel=1e-6)


@pytest.mark.parametrize("truth", [(-60.0, 0.2), (-35.5, 0.1071), (-80.0, -0.05)])
def test_a_fit_finds_the_law_that_made_the_samples(truth):
    d = np.linspace(1.0, 9.0, 40)
    law = LogExponentialLaw(alpha_dbm=truth[0], beta_per_m=truth[1])
    found, rms = fit_log_exponential(d, law.rss_dbm(d))
    assert (found.alpha_dbm, found.beta_per_m) == pytest.approx(truth, rel=1e-6)
    assert rms < 1e-6
    line = LogDistanceLaw(rss_1m_dbm=-30.0, exponent=2.2)
    again, rms = fit_log_distance(d, line.rss_dbm(d))
    assert (again.rss_1m_dbm, again.exponent) == pytest.approx((-30.0, 2.2))
    assert rms < 1e-10


def test_the_fit_of_the_noisy_signal_tends_to_its_mean_not_to_the_printed_one():
    rng = np.random.default_rng(0)
    d = np.tile(np.array(XBEE_DISTANCES_M), 200)
    clean = LogExponentialLaw(alpha_dbm=-35.5, beta_per_m=0.1071).rss_dbm(d)
    law, _ = fit_log_exponential(d, clean + RssNoise().draw(d.shape, rng))
    assert law.alpha_dbm == pytest.approx(-63.7, abs=12.0)
    assert law.beta_per_m == pytest.approx(0.071, abs=0.05)


@pytest.mark.parametrize(
    "law", [LogExponentialLaw(), LogDistanceLaw(rss_1m_dbm=-20.0, exponent=2.5)]
)
def test_slopes_of_a_mesh_are_its_central_differences(law):
    mesh = TagMesh(tags_m=tag_grid(3, spacing_m=3.0, height_m=3.0), law=law)
    places = np.random.default_rng(2).uniform(-4, 4, (20, 2))
    for axis in range(2):
        step = 1e-5 * np.eye(2)[axis]
        rise = (mesh.rss_dbm(places + step) - mesh.rss_dbm(places - step)) / 2e-5
        assert mesh.slopes_db_per_m(places)[..., axis] == pytest.approx(rise, rel=1e-6, abs=1e-6)


def test_a_map_is_exact_on_planes_and_goes_on_at_its_edge():
    axis = np.linspace(-1.0, 1.0, 11)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    found = RssMap(x_m=axis, y_m=axis, rss=np.stack([2 * x + 3 * y, -x], axis=-1))
    places = np.random.default_rng(3).uniform(-0.9, 0.9, (50, 2))
    wanted = np.column_stack([2 * places[:, 0] + 3 * places[:, 1], -places[:, 0]])
    assert found.rss_dbm(places) == pytest.approx(wanted, abs=1e-12)
    slopes = found.slopes_db_per_m(places)
    assert slopes == pytest.approx(np.tile([[2.0, 3.0], [-1.0, 0.0]], (50, 1, 1)), abs=1e-9)
    assert found.rss_dbm(np.array([[5.0, 0.0]]))[0] == pytest.approx([2.0, -1.0])


def test_bad_laws_noises_meshes_and_maps_are_one_sentence():
    with pytest.raises(NavigationError, match="alpha negative"):
        LogExponentialLaw(alpha_dbm=1.0)
    with pytest.raises(NavigationError, match="covariance"):
        RssNoise(sigma_db=0.0)
    with pytest.raises(NavigationError, match="at least two"):
        fit_log_distance([1.0], [2.0])
    with pytest.raises(NavigationError, match="at least one"):
        TagMesh(tags_m=np.zeros((0, 3)), law=LogExponentialLaw())
    with pytest.raises(NavigationError, match="even"):
        RssMap(x_m=[0.0, 1.0, 3.0], y_m=[0.0, 1.0], rss=np.zeros((3, 2, 1)))
    with pytest.raises(NavigationError, match="cannot be built"):
        tag_grid(0, spacing_m=1.0, height_m=1.0)
