"""Layered walls against slabs, thin-film theory, transfer matrices and conservation laws."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.medium._reflection_kernels import fill_wall
from octant.em.medium.materials import Material, material
from octant.em.medium.reflection import half_space_reflection, wall_coefficients
from octant.geometries.errors import MaterialRangeError

FREQUENCY_HZ = 2.4e9
WAVELENGTH_M = SPEED_OF_LIGHT_M_PER_S / FREQUENCY_HZ
ANGLES = np.radians([0.0, 20.0, 45.0, 60.0, 80.0, 89.9])
DRYWALL = {
    "layers": [
        {"material": "plasterboard", "thickness_m": 0.0125},
        {"name": "air", "thickness_m": 0.07},
        {"eps_r": 4.0, "sigma_s_per_m": 0.02, "thickness_m": 0.02},
    ]
}


def plain(eps_r, thickness_m, sigma=0.0):
    return Material(name="x", eps_r_a=eps_r, sigma_c_s_per_m=sigma, thickness_m=thickness_m)


def layered(*layers):
    return Material(name="wall", layers=layers)


def by_transfer_matrices(layers, incidence_rad):
    """Return r_te, r_tm, t_te, t_tm at one angle, from the product of ABCD matrices."""
    cosine, k = np.cos(incidence_rad), 2.0 * np.pi / WAVELENGTH_M
    result = []
    for is_tm in (False, True):
        whole = np.eye(2, dtype=complex)
        for layer in layers:
            eps = layer.relative_permittivity(FREQUENCY_HZ)
            kz = np.sqrt(eps - np.sin(incidence_rad) ** 2)
            p = kz / eps if is_tm else kz
            q = k * kz * layer.thickness_m
            whole = whole @ np.array(
                [[np.cos(q), 1j * np.sin(q) / p], [1j * p * np.sin(q), np.cos(q)]]
            )
        (a, b), (c, d) = whole
        total = a + b * cosine + c / cosine + d
        result.append(((a + b * cosine - c / cosine - d) / total, 2.0 / total))
    (r_te, t_te), (r_tm, t_tm) = result
    return r_te, r_tm, t_te, t_tm


def test_equal_layers_are_one_slab():
    split = layered(*(plain(5.0, d, 0.05) for d in (0.03, 0.05, 0.02)))
    whole = plain(5.0, 0.10, 0.05)
    for ours, theirs in zip(
        wall_coefficients(split, FREQUENCY_HZ, ANGLES),
        wall_coefficients(whole, FREQUENCY_HZ, ANGLES),
        strict=True,
    ):
        assert ours == pytest.approx(theirs, abs=1e-13)


def test_layers_of_air_do_nothing_but_delay():
    gap = material({"layers": [{"name": "air", "thickness_m": d} for d in (0.03, 0.05)]})
    angles = np.append(ANGLES, np.pi / 2)
    found = wall_coefficients(gap, FREQUENCY_HZ, angles)
    assert np.abs(found.reflection_te).max() == 0.0
    assert np.abs(found.reflection_tm).max() == 0.0
    delay = np.exp(-2j * np.pi * 0.08 / WAVELENGTH_M * np.cos(angles))
    assert found.transmission_te == pytest.approx(delay, abs=1e-14)
    assert found.transmission_tm == pytest.approx(delay, abs=1e-14)


def test_quarter_wave_coating_of_the_geometric_mean_index_does_not_reflect():
    coating = plain(3.0, WAVELENGTH_M / 4.0 / 3.0**0.5)
    coated = layered(coating, Material(name="behind", eps_r_a=9.0))
    assert abs(wall_coefficients(coated, FREQUENCY_HZ, [0.0]).reflection_te[0]) < 1e-15
    pane = layered(coating, plain(9.0, 0.037), coating)
    found = wall_coefficients(pane, FREQUENCY_HZ, [0.0])
    assert abs(found.reflection_te[0]) < 1e-14
    assert abs(found.transmission_te[0]) == pytest.approx(1.0, abs=1e-14)


def test_half_wave_layer_vanishes_before_a_half_space():
    behind = Material(name="behind", eps_r_a=6.0, sigma_c_s_per_m=0.1)
    hidden = layered(plain(4.0, WAVELENGTH_M / 4.0), behind)
    te, _ = half_space_reflection(behind, FREQUENCY_HZ, [0.0])
    found = wall_coefficients(hidden, FREQUENCY_HZ, [0.0])
    assert found.reflection_te == pytest.approx(te, abs=1e-15)
    assert found.transmission_te[0] == 0.0


def test_layer_on_a_perfect_conductor_is_the_shorted_line():
    layer = plain(4.0, 0.013, 0.02)
    backed = layered(layer, material("pec"))
    angle = np.radians(35.0)
    found = wall_coefficients(backed, FREQUENCY_HZ, [angle])
    eps = layer.relative_permittivity(FREQUENCY_HZ)
    kz = np.sqrt(eps - np.sin(angle) ** 2)
    short = 1j * np.tan(2.0 * np.pi / WAVELENGTH_M * kz * 0.013)  # input impedance over the layer's
    te = (short / kz - 1.0 / np.cos(angle)) / (short / kz + 1.0 / np.cos(angle))
    tm = (np.cos(angle) - short * kz / eps) / (np.cos(angle) + short * kz / eps)
    assert found.reflection_te[0] == pytest.approx(te, abs=1e-14)
    assert found.reflection_tm[0] == pytest.approx(tm, abs=1e-14)
    assert found.transmission_tm[0] == 0.0


thicknesses = st.floats(1e-4, 0.2)
lossless = st.lists(st.tuples(st.floats(1.0, 12.0), thicknesses), min_size=2, max_size=6)
lossy = st.lists(
    st.tuples(st.floats(1.0, 12.0), thicknesses, st.floats(0.0, 0.3)), min_size=2, max_size=6
)
angles = st.floats(0.0, np.radians(89.9))


@given(layers=lossless, angle=angles, from_front=st.booleans())
def test_energy_is_conserved_without_loss(layers, angle, from_front):
    wall = layered(*(plain(*x) for x in layers))
    c = wall_coefficients(wall, FREQUENCY_HZ, [angle], from_front=from_front)
    assert abs(c.reflection_te[0]) ** 2 + abs(c.transmission_te[0]) ** 2 == pytest.approx(1.0)
    assert abs(c.reflection_tm[0]) ** 2 + abs(c.transmission_tm[0]) ** 2 == pytest.approx(1.0)


@given(layers=lossy, angle=angles)
def test_layered_walls_equal_the_product_of_transfer_matrices(layers, angle):
    wall = layered(*(plain(*x) for x in layers))
    for from_front in (True, False):
        c = wall_coefficients(wall, FREQUENCY_HZ, [angle], from_front=from_front)
        order = wall.layers if from_front else wall.layers[::-1]
        assert [x[0] for x in c] == pytest.approx(by_transfer_matrices(order, angle), abs=1e-9)


@given(layers=lossy, angle=st.floats(0.0, np.pi / 2))
def test_both_sides_let_through_the_same_and_no_wall_gives_more_than_it_takes(layers, angle):
    wall = layered(*(plain(*x) for x in layers))
    front = wall_coefficients(wall, FREQUENCY_HZ, [angle])
    back = wall_coefficients(wall, FREQUENCY_HZ, [angle], from_front=False)
    assert front.transmission_te == pytest.approx(back.transmission_te, abs=1e-12)
    assert front.transmission_tm == pytest.approx(back.transmission_tm, abs=1e-12)
    for c in (front, back):
        assert abs(c.reflection_te[0]) ** 2 + abs(c.transmission_te[0]) ** 2 <= 1.0 + 1e-9
        assert abs(c.reflection_tm[0]) ** 2 + abs(c.transmission_tm[0]) ** 2 <= 1.0 + 1e-9


def test_sides_of_an_uneven_wall_reflect_differently():
    wall = material(DRYWALL)
    front = wall_coefficients(wall, FREQUENCY_HZ, [0.4])
    back = wall_coefficients(wall, FREQUENCY_HZ, [0.4], from_front=False)
    turned = material({"layers": DRYWALL["layers"][::-1]})
    assert abs(front.reflection_te[0] - back.reflection_te[0]) > 0.05
    assert back == wall_coefficients(turned, FREQUENCY_HZ, [0.4])


def test_a_wall_that_fills_what_lies_behind_has_one_side():
    wall = material({"layers": [DRYWALL["layers"][0], {"material": "brick"}]})
    front = wall_coefficients(wall, FREQUENCY_HZ, ANGLES)
    back = wall_coefficients(wall, FREQUENCY_HZ, ANGLES, from_front=False)
    assert np.array_equal(front, back)
    assert np.abs(front.transmission_te).max() == 0.0


def test_thick_metal_between_other_layers_is_finite():
    wall = layered(plain(3.0, 0.01), plain(1.0, 1.0, 1e7), plain(3.0, 0.02))
    c = wall_coefficients(wall, FREQUENCY_HZ, np.append(ANGLES, np.pi / 2))
    assert np.isfinite(c).all()
    assert np.abs(c.transmission_te).max() == 0.0


@pytest.mark.parametrize("from_front", [True, False])
@pytest.mark.parametrize("inner", [complex(1.0, 0.0), complex(1.0, -np.inf)])
@pytest.mark.parametrize("outer", [complex(1.0, 0.0), complex(5.0, -0.1)])
def test_exactly_grazing_waves_give_no_nan(inner, outer, from_front):
    out = np.empty((4, 1), np.complex128)
    layers = np.array([1.0, inner, outer])
    fill_wall(layers, np.array([0.1, 0.2, 0.3]), np.array([0.0]), from_front, out)
    assert np.isfinite(out).all()
    assert (np.abs(out) <= 1.0).all()
    fill_wall(np.array([outer]), np.array([np.inf]), np.array([0.0]), from_front, out)
    assert np.isfinite(out).all()


def test_stack_lists_layers_from_front_to_back():
    permittivity, thickness_m = material(DRYWALL).layer_stack(FREQUENCY_HZ)
    assert permittivity[1] == 1.0
    assert permittivity[2].real == 4.0
    assert thickness_m.tolist() == [0.0125, 0.07, 0.02]
    permittivity, thickness_m = material("brick").layer_stack(FREQUENCY_HZ)
    assert permittivity.shape == (1,)
    assert thickness_m[0] == np.inf


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ({"layers": []}, "empty list"),
        ({"layers": [{"name": "wood", "thickness_m": 0.1}]}, "two layers or more"),
        ({"layers": [{"name": "wood"}, {"name": "air"}]}, "layer 0 .wood. .* has no thickness_m"),
        ({"layers": [DRYWALL, {"name": "air"}]}, "has layers itself"),
        ({**DRYWALL, "thickness_m": 0.1}, "gives thickness_m beside layers"),
        ({"layers": [{"name": "wood", "material": "wood"}, {"name": "air"}]}, "mean the same"),
    ],
)
def test_bad_layers_say_what_is_allowed(spec, words):
    with pytest.raises(MaterialRangeError, match=words):
        material(spec)


def test_layered_wall_has_no_permittivity_of_its_own():
    with pytest.raises(MaterialRangeError, match="3 layers"):
        material(DRYWALL).relative_permittivity(FREQUENCY_HZ)
