"""Antennas of strips: against another Galerkin code on the same triangles, and closed forms."""

import math

import numpy as np
import pytest

from octant.em.reader.fullwave.elements import (
    copied_around,
    dipole_parts,
    inverted_f_parts,
    loop_parts,
    patch_parts,
)
from octant.em.reader.fullwave.ported import ported_mesh
from octant.em.reader.fullwave.solve import solve_reader
from octant.geometries.errors import GeometryError

F_HZ = 299792458.0
"""Wavelength of 1 m."""
PAIR = [("low", "high")]


def solved(parts, ports, *, share=1.0, **keys):
    mesh = ported_mesh(parts, ports, frequency_hz=F_HZ, **keys)
    return solve_reader(mesh, frequency_hz=share * F_HZ)


def loop(width, height):
    return loop_parts(size_m=(width, height), width_m=0.004, middle_m=(0, 0, 0), cell_m=0.02)


@pytest.mark.parametrize(
    ("size", "unknowns", "impedance_ohm", "within"),
    [
        # bempp-cl 0.4.2 on these triangles, quadrature of order 4.
        ((0.26, 0.26), 106, 111.95 - 81.38j, 2e-3),
        ((0.02, 0.47), 104, 319.01 + 65.14j, 1e-2),
    ],
    ids=["loop", "folded dipole"],
)
def test_loops_have_the_impedance_of_another_galerkin_code(size, unknowns, impedance_ohm, within):
    result = solved(loop(*size), PAIR)
    assert result.unknowns == unknowns
    assert abs(result.impedance_ohm[0, 0] - impedance_ohm) < within * abs(impedance_ohm)


def test_a_folded_dipole_is_four_dipoles_and_a_line():
    """C. Balanis, Antenna Theory, equations (9-15) to (9-24): within a tenth."""
    width, spacing, length = 0.004, 0.02, 0.47
    folded = solved(loop(spacing, length), PAIR).impedance_ohm[0, 0]
    thick = 4.0 * math.sqrt(0.25 * width * spacing)  # strip of the equivalent radius
    keys = {"middle_m": (0, 0, 0), "axis": (0, 0, 1), "cell_m": 0.1}
    over_all = length + width
    parts = dipole_parts(length_m=over_all, width_m=thick, **keys)
    dipole = solved(parts, PAIR).impedance_ohm[0, 0]
    line = 119.92 * math.acosh(spacing / (0.5 * width))
    stub = 1j * line * math.tan(math.pi * over_all)
    expected = 4.0 * stub * dipole / (2.0 * dipole + stub)
    assert abs(folded - expected) < 0.1 * abs(expected)


def test_an_inverted_f_resonates_where_height_and_arm_are_a_quarter_wave():
    shape = {"height_m": 0.04, "arm_m": 0.21, "width_m": 0.004, "cell_m": 0.02}
    parts = inverted_f_parts(tap_m=0.03, foot_m=(0.1, 0, 0), **shape)
    z = [
        solved(parts, [("ground", "leg")], share=s, ground=True).impedance_ohm[0, 0]
        for s in (0.92, 0.96, 1.0, 1.04)
    ]
    assert 1 <= int(np.argmax(np.real(z))) <= 2
    assert z[0].imag > 0.0 > z[-1].imag


def test_slanted_dipoles_around_the_axis_are_alike_and_have_both_polarisations():
    keys = {"length_m": 0.47, "width_m": 0.004, "cell_m": 0.1}
    one = dipole_parts(axis=(0, 1, 1), middle_m=(0.5, 0, 0), **keys)
    parts = copied_around(one, "d", around=4)
    ports = [(f"d {i}.low", f"d {i}.high") for i in (1, 2, 3, 4)]
    result = solved(parts, ports)
    z = result.input_impedance_ohm
    np.testing.assert_allclose(z, z[0], rtol=1e-9)
    phi = np.radians([0.0, 90.0, 180.0, 270.0])
    field = result.far_field(np.full(4, 0.5 * math.pi), phi)
    own = field[np.arange(4), np.arange(4)]
    np.testing.assert_allclose(own, own[:1].repeat(4, axis=0), rtol=1e-6)
    alone = solved(dipole_parts(axis=(0, 1, 1), middle_m=(0.5, 0, 0), **keys), PAIR)
    theta, across = alone.far_field(0.5 * math.pi, 0.0)[0]
    assert abs(theta) == pytest.approx(abs(across), rel=2e-3)


def test_a_patch_and_its_probe_meet_in_an_edge_wherever_it_is_fed():
    keys = {"size_m": (0.46, 0.5), "height_m": 0.05, "middle_m": (0, 0, 0), "cell_m": 0.06}
    at_edge, inside = (
        solved(patch_parts(feed_m=y, **keys), [("ground", "probe")], share=0.93, ground=True)
        for y in (0.23, 0.115)
    )
    # cos² of the way to the edge, a little more by the probe's own field.
    ratio = inside.impedance_ohm[0, 0].real / at_edge.impedance_ohm[0, 0].real
    assert ratio == pytest.approx(math.sin(math.pi * 0.115 / 0.46) ** 2, abs=0.15)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: loop(0.003, 0.4), "closed by its strip"),
        (
            lambda: inverted_f_parts(
                height_m=0.04, arm_m=0.2, tap_m=0.003, width_m=0.004, foot_m=(0, 0, 0), cell_m=0.1
            ),
            "no room for its leg",
        ),
        (
            lambda: dipole_parts(
                length_m=0.5, width_m=0.01, middle_m=(0, 0, 0), axis=(0, 0, 0), cell_m=0.1
            ),
            "a direction is needed",
        ),
    ],
)
def test_shapes_that_cannot_be_are_refused(make, said):
    with pytest.raises(GeometryError, match=said):
        make()
