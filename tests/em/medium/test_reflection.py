import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from octant.em.medium.materials import Material, material
from octant.em.medium.reflection import half_space_reflection, wall_coefficients

# 20 log10 |T| and |R| of P.2040-4 slabs at 2.45 GHz: normal, 60 deg TE, 60 deg TM.
SLABS = [
    ("concrete", 0.20, (-14.80, -18.42, -14.43), (-7.73, -4.33, -19.44)),
    ("brick", 0.10, (-3.26, -4.44, -2.53), None),
    ("plasterboard", 0.0125, (-1.09, -3.20, -0.29), (-7.87, -3.47, -31.61)),
    ("glass", 0.006, (-1.96, -5.16, -0.22), (-4.58, -1.67, -14.37)),
    ("wood", 0.030, (-0.74, -2.89, -0.59), None),
]


def decibel(x):
    return 20.0 * np.log10(np.abs(x))


@pytest.mark.parametrize(("name", "thickness_m", "through", "back"), SLABS)
def test_slabs_equal_the_published_table(name, thickness_m, through, back):
    wall = material({"name": name, "thickness_m": thickness_m})
    c = wall_coefficients(wall, 2.45e9, np.radians([0.0, 60.0]))
    t = (c.transmission_te[0], c.transmission_te[1], c.transmission_tm[1])
    assert decibel(t) == pytest.approx(through, abs=0.0051)
    if back is not None:
        r = (c.reflection_te[0], c.reflection_te[1], c.reflection_tm[1])
        assert decibel(r) == pytest.approx(back, abs=0.0051)


def test_brewster_angle_has_no_tm_reflection():
    glass = Material(name="lossless", eps_r_a=4.0)
    _, tm = half_space_reflection(glass, 1e9, [np.arctan(2.0)])
    assert abs(tm[0]) < 1e-15


def test_normal_incidence_is_the_index_contrast():
    wall = Material(name="lossless", eps_r_a=4.0)
    te, tm = half_space_reflection(wall, 1e9, [0.0])
    assert te[0] == pytest.approx(-1.0 / 3.0, abs=1e-15)
    assert tm[0] == pytest.approx(1.0 / 3.0, abs=1e-15)


def test_perfect_conductor_reflects_all():
    te, tm = half_space_reflection(material("pec"), 1e9, np.radians([0.0, 45.0, 89.0]))
    assert (te == -1.0).all()
    assert (tm == 1.0).all()


def test_half_wave_slab_without_loss_is_invisible():
    wall = Material(name="window", eps_r_a=4.0, thickness_m=299792458.0 / 1e9 / 4.0)
    c = wall_coefficients(wall, 1e9, [0.0])
    assert abs(c.reflection_te[0]) < 1e-12
    assert abs(c.transmission_te[0]) == pytest.approx(1.0, abs=1e-12)


def test_thick_lossy_slab_becomes_a_half_space():
    thick = Material(name="a", eps_r_a=5.0, sigma_c_s_per_m=1.0, thickness_m=5.0)
    angles = np.radians([0.0, 30.0, 75.0])
    c = wall_coefficients(thick, 2.4e9, angles)
    te, tm = half_space_reflection(thick, 2.4e9, angles)
    assert c.reflection_te == pytest.approx(te, abs=1e-12)
    assert c.reflection_tm == pytest.approx(tm, abs=1e-12)


@given(
    eps=st.floats(1.0, 80.0),
    sigma=st.floats(0.0, 1e7),
    angle=st.floats(0.0, np.pi / 2),
    thickness=st.floats(1e-4, 1.0),
)
def test_no_wall_gives_more_than_it_takes(eps, sigma, angle, thickness):
    wall = Material(name="w", eps_r_a=eps, sigma_c_s_per_m=sigma, thickness_m=thickness)
    te, tm = half_space_reflection(wall, 2.4e9, [angle])
    assert abs(te[0]) <= 1.0 + 1e-12
    assert abs(tm[0]) <= 1.0 + 1e-12
    c = wall_coefficients(wall, 2.4e9, [angle])
    assert abs(c.reflection_te[0]) ** 2 + abs(c.transmission_te[0]) ** 2 <= 1.0 + 1e-9
    assert abs(c.reflection_tm[0]) ** 2 + abs(c.transmission_tm[0]) ** 2 <= 1.0 + 1e-9
