"""Any metal with ports, alone and over a plane: numbers of others' programs and closed forms."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import j0

from octant.em.reader.fullwave.ported import ported_mesh, refined, ruled_sheet, strip
from octant.em.reader.fullwave.solve import solve_reader
from octant.geometries.errors import GeometryError

F_HZ = 299792458.0
"""Wavelength of 1 m."""
REFERENCE = Path(__file__).resolve().parents[3] / "reference"


def dipole(length, width, rows, *, axis=(0, 0, 1), middle=(0, 0, 0), across=(1, 0, 0)):
    half, c = 0.5 * length * np.array(axis, dtype=float), np.array(middle, dtype=float)
    shape = {"width_m": width, "across": across, "rows": rows}
    return [("low", *strip(c - half, c, **shape)), ("high", *strip(c, c + half, **shape))]


def solved(parts, ports, *, frequency_hz=F_HZ, **keys):
    return solve_reader(ported_mesh(parts, ports, frequency_hz=frequency_hz, **keys))


def bow_tie():
    z = np.linspace(-0.2, 0.2, 13)
    half = 0.015 + 0.085 * np.abs(z) / 0.2
    left, right = np.c_[-half, 0 * z, z], np.c_[half, 0 * z, z]
    parts = {"low": slice(0, 7), "high": slice(6, 13)}
    return [(name, *ruled_sheet(left[s], right[s], columns=4)) for name, s in parts.items()]


@pytest.mark.parametrize(
    ("parts", "unknowns", "impedance_ohm"),
    [
        # bempp-cl 0.4.2, RWG and Galerkin on the same triangles: 62.86 - j21.94 and, with singular
        # and regular quadrature of order 4, 78.88 + j37.74 ohm.
        (dipole(0.45, 0.02, 7), 27, 62.86 - 21.94j),
        (bow_tie(), 128, 78.88 + 37.74j),
    ],
    ids=["strip", "bow tie"],
)
def test_published_meshes_have_the_impedance_of_another_galerkin_code(
    parts, unknowns, impedance_ohm
):
    result = solved(parts, [("low", "high")])
    assert result.unknowns == unknowns
    (found,) = result.impedance_ohm.ravel()
    assert abs(found - impedance_ohm) < 1e-3 * abs(impedance_ohm)
    # However the mesh is given: turned as a whole, the port along any edge.
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turned = [(name, v @ turn.T + np.array((0.3, -1.0, 2.0)), f) for name, v, f in parts]
    again = solved(turned, [("low", "high")])
    assert again.impedance_ohm[0, 0] == pytest.approx(found, rel=1e-9)


def test_a_dipole_just_above_a_plane_has_what_nec_has():
    # nec2c 1.3 (OpenNEC, issue 14): 10.6 m of 1 mm radius at 14 MHz in 21 segments, free: 76.464 +
    # j29.441 ohm, 0.43 m over a perfect plane: 0.953 + j3.066 ohm. A segment of half a metre is
    # fed there, which moves the reactance.
    keys = {"axis": (1, 0, 0), "middle": (0, 0, 0.43), "across": (0, 1, 0)}
    parts = dipole(10.6, 0.004, 11, **keys)
    ports = [("low", "high")]
    free = solved(parts, ports, frequency_hz=14e6).impedance_ohm[0, 0]
    assert abs(free - (76.464 + 29.441j)) < 0.01 * abs(free)
    above = solved(parts, ports, frequency_hz=14e6, ground=True)
    assert above.impedance_ohm[0, 0].real == pytest.approx(0.953, rel=0.01)
    assert above.impedance_ohm[0, 0].imag == pytest.approx(3.066, abs=0.1)
    assert above.balance_error < 1e-4


def test_two_coupled_monopoles_over_a_plane_are_as_published():
    """0.249 wavelengths high, 60 degrees apart; numbers of a NEC user."""
    shape = {"width_m": 0.0012, "across": (0, 1, 0), "rows": 12}
    parts = [
        (name, *strip((x, 0, 0), (x, 0, 0.249), **shape)) for name, x in (("a", 0), ("b", 1 / 6))
    ]
    result = solved(parts, [("ground", "a"), ("ground", "b")], ground=True)
    z = result.impedance_ohm
    assert abs(z[0, 0]) == pytest.approx(44.0, abs=0.5)
    assert abs(z[0, 1]) == pytest.approx(32.0, abs=0.5)
    volts = z @ np.array([1.0, np.exp(-2j * math.pi / 3.0)])  # currents 120 degrees apart
    field = np.tensordot(volts, result.unloaded.shorted_v.on_grid(np.array([math.pi / 2]), 360), 1)
    gain = (np.abs(field[0]) ** 2).sum(axis=-1)
    sent = 0.5 * (volts.conj() @ result.unloaded.shorted_v.power_matrix() @ volts).real
    assert 10 * math.log10(gain.max() / sent) == pytest.approx(9.2, abs=0.1)
    assert 10 * math.log10(gain.max() / gain.min()) == pytest.approx(25.0, abs=3.0)


def test_a_monopole_over_a_plane_is_half_a_dipole_and_dark_below():
    half = {"width_m": 0.01, "across": (1, 0, 0), "rows": 10}
    mast = [("mast", *strip((0, 0, 0), (0, 0, 0.25), **half))]
    over = solved(mast, [("ground", "mast")], ground=True)
    ((_, points, faces),) = mast
    both = [("low", points * (1, 1, -1), faces), ("high", points, faces)]
    whole = solved(both, [("low", "high")])
    assert over.impedance_ohm[0, 0] == pytest.approx(whole.impedance_ohm[0, 0] / 2, rel=1e-9)
    theta = np.radians([30.0, 80.0, 90.0, 91.0, 150.0])
    above, free = (
        (np.abs(r.pattern_grid(theta, 4)) ** 2).sum(-1)[0, :, 0] / r.radiated_share[0]
        for r in (over, whole)
    )
    np.testing.assert_allclose(above, 2.0 * free * (theta < 1.58), rtol=1e-9)
    np.testing.assert_allclose(
        over.far_field(theta, 0.0)[0], over.pattern_grid(theta, 4)[0, :, 0], atol=1e-8
    )


def patch(length, width, height, *, rows, columns):
    """A patch over the plane, fed by a strip in the middle of one edge."""
    x = np.linspace(-0.5 * length, 0.5 * length, rows + 1)
    left = np.c_[x, np.full_like(x, -0.5 * width), np.full_like(x, height)]
    cell = width / columns
    probe = strip((x[0], 0, 0), (x[0], 0, height), width_m=cell, across=(0, 1, 0), rows=1)
    return [("patch", *ruled_sheet(left, left * (1, -1, 1), columns=columns)), ("probe", *probe)]


def test_a_patch_over_air_is_near_to_its_cavity_model_and_a_wire_grid():
    """Resonance within 5 %, edge resistance within 15 %: C. Balanis, Antenna Theory, 14.2.

    Beside a wire grid: resonance within 1 % of that of ever finer grids, gain towards the zenith
    within 0.15 dB, resistance within 20 %.
    """
    length, width, height = 0.46, 0.5, 0.03
    mesh = ported_mesh(
        patch(length, width, height, rows=14, columns=15),
        [("ground", "probe")],
        frequency_hz=F_HZ,
        ground=True,
    )
    share = [0.93, 0.945, 0.96, 0.975]
    results = [solve_reader(mesh, frequency_hz=F_HZ * s) for s in share]
    z = np.array([r.impedance_ohm[0, 0] for r in results])
    top = int(z.real.argmax())
    assert 0 < top < len(z) - 1
    fit = np.polyfit(share[top - 1 : top + 2], z.real[top - 1 : top + 2], 2)
    resonance = -0.5 * fit[1] / fit[0]
    longer = 0.412 * height * 1.3 * (width / height + 0.264) / (0.742 * (width / height + 0.8))
    assert resonance == pytest.approx(0.5 / (length + 2.0 * longer), rel=0.05)
    k = 2.0 * math.pi * resonance

    def slot(theta, distance=0.0):
        across = np.sinc(k * width * math.cos(theta) / (2 * math.pi)) * 0.5 * k * width
        return across**2 * math.sin(theta) ** 3 * j0(k * distance * math.sin(theta))

    own, mutual = (
        quad(slot, 0.0, math.pi, args=(d,))[0] / (120.0 * math.pi**2) for d in (0.0, length)
    )
    assert np.polyval(fit, resonance) == pytest.approx(0.5 / (own + mutual), rel=0.15)
    assert results[top].balance_error < 0.01
    _, coarse, fine = json.loads((REFERENCE / "nec" / "patch.json").read_text())
    cells = [math.sqrt(length * width / (one["rows"] * one["columns"])) for one in (coarse, fine)]
    places = [one["resonance_share"] for one in (coarse, fine)]
    finest = places[1] + cells[1] * (places[1] - places[0]) / (cells[0] - cells[1])
    assert resonance == pytest.approx(finest, rel=0.01)
    resistance = fine["resistance_ohm"] * fine["mean_gain"]
    assert np.polyval(fit, resonance) == pytest.approx(resistance, rel=0.2)
    zenith = (np.abs(results[top].pattern_grid([0.0], 4)) ** 2).sum(-1)[0, 0, 0]
    directivity = 10.0 * math.log10(zenith / results[top].radiated_share[0])
    assert directivity == pytest.approx(fine["zenith_dbi"], abs=0.15)


PLATE = ruled_sheet([(0, 0, 0), (0, 0, 0.1)], [(0.1, 0, 0), (0.1, 0, 0.1)])
NEXT = ruled_sheet([(0, 0, 0.1), (0, 0, 0.2)], [(0.1, 0, 0.1), (0.1, 0, 0.2)])
FAR = (PLATE[0] + np.array((0.0, 0.3, 0.0)), PLATE[1])
FINER = ruled_sheet([(0, 0, 0.1), (0, 0, 0.2)], [(0.1, 0, 0.1), (0.1, 0, 0.2)], columns=2)
CROSS = (PLATE[0] @ np.array(((0, 1, 0), (1, 0, 0), (0, 0, 1.0))) + (0.05, -0.04, 0.01), PLATE[1])


@pytest.mark.parametrize(
    ("parts", "ports", "keys", "said"),
    [
        ([("a", *PLATE), ("b", *FAR)], [("a", "b")], {}, "port 1 is on no edge"),
        ([("a", *PLATE), ("b", *NEXT)], [("a", "c")], {}, "names the part 'c'"),
        ([("a", *PLATE), ("b", *NEXT)], [("a", "b"), ("b", "a")], {}, "ports 1 and 2 are on one"),
        ([("a", *PLATE), ("b", *FINER)], [("a", "b")], {}, "without sharing it"),
        ([("a", *PLATE), ("b", *CROSS)], [("a", "b")], {}, "triangles cross near"),
        ([("a", *PLATE), ("b", *PLATE)], [("a", "b")], {}, "lie on each other"),
        ([("a", 3e3 * PLATE[0], PLATE[1])], [("a", "a")], {}, "mm instead of m"),
        ([("a", 1e-3 * PLATE[0], PLATE[1])], [("a", "a")], {}, "m instead of mm"),
        ([("a", 6.0 * PLATE[0], PLATE[1])], [("a", "a")], {}, "refine them"),
        ([("a", *PLATE)], [("a", "ground")], {}, "names the part 'ground'"),
        ([("a", PLATE[0] - (0, 0, 0.05), PLATE[1])], [("a", "ground")], {"ground": True}, "on no"),
        (
            [("a", PLATE[0][:, [0, 2, 1]], PLATE[1]), ("b", *NEXT)],
            [("ground", "a")],
            {"ground": True},
            "lies in the infinite plane",
        ),
    ],
)
def test_what_cannot_be_solved_is_refused_in_one_sentence(parts, ports, keys, said):
    with pytest.raises(GeometryError, match=said):
        solved(parts, ports, **keys)


def test_triangles_are_halved_until_they_are_small_enough():
    coarse = [
        (n, *strip((0, 0, z), (0, 0, z + 0.225), width_m=0.02, across=(1, 0, 0), rows=3))
        for n, z in (("a", -0.225), ("b", 0.0))
    ]
    mesh = ported_mesh(refined(coarse, edge_m=0.05), [("a", "b")], frequency_hz=F_HZ)
    assert mesh.coarse_m <= 0.05
    assert len(mesh.faces) == 12 * 4
    assert len(mesh.ports[0]) == 2
    assert abs(solve_reader(mesh).impedance_ohm[0, 0] - (62.86 - 21.94j)) < 6.0
