import math
import warnings

import pytest

from octant.em.medium.materials import EXTRAPOLATION, material, material_table
from octant.geometries.errors import MaterialRangeError, PhysicsWarning

# ITU-R P.2040 as given independently: a, b, c, d with f in GHz.
P2040 = {
    "concrete": (5.24, 0.0, 0.0462, 0.7822),
    "brick": (3.91, 0.0, 0.0238, 0.16),
    "plasterboard": (2.73, 0.0, 0.0085, 0.9395),
    "wood": (1.99, 0.0, 0.0047, 1.0718),
    "glass": (6.31, 0.0, 0.0036, 1.3394),
    "chipboard": (2.58, 0.0, 0.0217, 0.78),
    "metal": (1.0, 0.0, 1e7, 0.0),
}


@pytest.mark.parametrize("name", P2040)
def test_permittivity_follows_the_recommendation(name):
    a, b, c, d = P2040[name]
    eps = material(name).relative_permittivity(2.45e9)
    loss = 17.98 * c * 2.45**d / 2.45  # P.2040 (9b), 17.98 = 1 / (2 pi eps_0 1e9)
    assert eps.real == pytest.approx(a * 2.45**b, rel=1e-12)
    assert -eps.imag == pytest.approx(loss, rel=1e-3)


def test_itu_prefix_and_case_do_not_matter():
    assert material("ITU_Concrete") == material("concrete")


def test_every_material_of_the_table_is_found_by_its_name():
    assert all(material(m.name) is m for m in material_table())


def test_own_material_keeps_its_numbers():
    eps = material({"eps_r": 4.0, "sigma_s_per_m": 0.02, "thickness_m": 0.2})
    assert eps.relative_permittivity(1e9).real == 4.0
    assert eps.thickness_m == 0.2


def test_perfect_conductor_is_infinite():
    assert material("pec").relative_permittivity(1e9).imag == -math.inf


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        ("concret", "did you mean 'concrete'"),
        ({"eps": 3.0}, "'eps' is unknown"),
        ({"thickness_m": 0.1}, "neither a name nor eps_r"),
        ({"name": "concrete", "sigma_s_per_m": 1.0}, "without eps_r"),
        ({"eps_r": 0.5}, "at least 1"),
        ({"eps_r": 2.0, "sigma_s_per_m": -1.0}, "at least 0"),
        ({"name": "glass", "thickness_m": 0.0}, "above 0 m"),
        ({"eps_r": math.nan}, "not finite"),
    ],
)
def test_bad_materials_say_what_is_allowed(spec, words):
    with pytest.raises(MaterialRangeError, match=words):
        material(spec)


@pytest.mark.parametrize("frequency_hz", [0.39e9, 251e9, 0.0, -1.0, math.nan, math.inf])
def test_frequency_far_outside_the_table_is_refused(frequency_hz):
    with pytest.raises(MaterialRangeError, match="holds from 1 to 100 GHz"):
        material("concrete").relative_permittivity(frequency_hz)


def test_concrete_in_the_uhf_band_follows_its_fit_with_a_warning():
    with pytest.warns(PhysicsWarning, match="'concrete' is extrapolated: .* from 1 to 100 GHz"):
        eps = material({"name": "concrete", "thickness_m": 0.1}).relative_permittivity(0.868e9)
    assert eps.real == 5.24
    assert -eps.imag == pytest.approx(17.98 * 0.0462 * 0.868**0.7822 / 0.868, rel=1e-3)


@pytest.mark.parametrize("frequency_hz", [13.56e6, 0.868e9, 2.4e9, 300e9])
def test_metal_reflects_all_at_any_frequency_without_a_warning(frequency_hz):
    eps = material("metal").relative_permittivity(frequency_hz)
    index = eps**0.5
    assert abs((1 - index) / (1 + index)) > 0.99


@pytest.mark.parametrize("entry", material_table(), ids=lambda m: m.name)
def test_each_model_holds_warns_or_is_refused_by_its_range_alone(entry):
    low, high = entry.frequency_range_hz
    if not (low > 0.0 and math.isfinite(high)):
        assert entry.relative_permittivity(1.0).real == 1.0
        return
    for f in (low, math.sqrt(low * high), high):
        entry.relative_permittivity(f)
    lowest = entry.extrapolated_from_hz or low / EXTRAPOLATION
    for f in (lowest, 0.999 * low, 1.001 * high, high * EXTRAPOLATION):
        with pytest.warns(PhysicsWarning, match=entry.name):
            eps = entry.relative_permittivity(f)
        assert eps.real >= 1.0
        assert eps.imag <= 0.0
    for f in (0.999 * lowest, 1.001 * high * EXTRAPOLATION):
        with pytest.raises(MaterialRangeError, match=entry.name):
            entry.relative_permittivity(f)


@pytest.mark.parametrize("frequency_hz", [433e6, 868e6, 915e6, 2.4e9])
@pytest.mark.parametrize("entry", material_table(), ids=lambda m: m.name)
def test_no_material_is_refused_at_the_frequencies_of_rfid(entry, frequency_hz):
    low, high = entry.frequency_range_hz
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        eps = entry.relative_permittivity(frequency_hz)
    assert eps.real >= 1.0
    assert bool(caught) == (not low <= frequency_hz <= high)


def test_floorboard_far_below_its_fit_says_how_far():
    with pytest.warns(PhysicsWarning, match=r"50 to 100 GHz, 58 times this frequency"):
        eps = material("floorboard").relative_permittivity(0.868e9)
    assert eps.real == 3.66
    assert -eps.imag / eps.real == pytest.approx(17.98 * 0.0044 * 0.868**0.3515 / 3.66, rel=1e-3)
