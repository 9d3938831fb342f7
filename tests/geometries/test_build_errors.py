"""A reader as built: its sheets stay whole, and what cannot be built is refused."""

import math

import numpy as np
import pytest

from octant.geometries.build_errors import BuildErrors, common_errors, tilt_of_lean
from octant.geometries.errors import GeometryError
from octant.geometries.reader_body import GROUND_PLANE_SHAPES, reader_body

DEGREE = math.pi / 180.0


def drawn_errors(seed, antennas=8):
    """Return errors of a millimetre and two degrees, different everywhere."""
    draw = np.random.default_rng(seed).uniform
    tilt, towards = tilt_of_lean(draw(-0.035, 0.035, (antennas, 2)))
    return BuildErrors(
        radial_m=draw(-1e-3, 1e-3, antennas),
        azimuth_rad=draw(-0.01, 0.01, antennas),
        gap_m=draw(-1e-3, 1e-3, antennas),
        length_m=draw(-1e-3, 1e-3, antennas),
        tilt_rad=tilt,
        tilt_azimuth_rad=towards,
        plate_azimuth_rad=draw(-0.035, 0.035, antennas),
        plate_height_m=draw(-1e-3, 1e-3, antennas),
        ground_plane_m=float(draw(-1e-3, 1e-3)),
    )


def area_m2(body):
    a, b, c = (body.body.vertices_m[body.body.faces[:, k]] for k in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


@pytest.mark.parametrize("shape", GROUND_PLANE_SHAPES)
def test_errors_of_zero_give_the_drawn_mesh_bit_by_bit(shape):
    radius = 0.095
    drawn = reader_body(ground_plane_shape=shape, antenna_radius_m=radius)
    built = reader_body(
        ground_plane_shape=shape,
        antenna_radius_m=radius,
        errors=common_errors(8, tilt_azimuth_rad=0.3),
    )
    assert built.errors is None
    assert np.array_equal(built.body.vertices_m, drawn.body.vertices_m)
    assert np.array_equal(built.body.faces, drawn.body.faces)


def test_the_sheets_have_the_area_that_the_errors_give():
    errors = drawn_errors(1)
    body = reader_body(errors=errors)
    plates = 0.1 * (0.08 + 0.5 * (errors.plate_height_m + errors.plate_height_m.mean()))
    ground = (0.2 + errors.ground_plane_m) ** 2
    assert area_m2(body) == pytest.approx(ground + plates.sum(), rel=1e-12)


def test_feet_stand_where_the_errors_put_them():
    errors = drawn_errors(2)
    body = reader_body(antenna_radius_m=0.07, errors=errors)
    x, y, z = body.element_feet_m.T
    assert np.allclose(np.hypot(x, y), 0.07 + errors.radial_m, rtol=0.0, atol=1e-15)
    wanted = body.element_azimuths_rad + errors.azimuth_rad
    assert np.allclose(np.angle(np.exp(1j * (np.arctan2(y, x) - wanted))), 0.0, atol=1e-14)
    assert not z.any()


def test_a_plate_that_ends_on_the_rim_ends_there_as_built():
    reach = 0.1 / math.cos(math.pi / 8)
    body = reader_body(
        plate_outer_radius_m=reach, errors=common_errors(8, plate_azimuth_rad=2 * DEGREE)
    )
    ends = body.built.plate_reaches_m[:, None] * np.column_stack(
        (np.cos(body.built.plate_azimuths_rad), np.sin(body.built.plate_azimuths_rad))
    )
    assert np.allclose(np.abs(ends).max(axis=1), 0.1, rtol=0.0, atol=1e-15)


def test_errors_add_and_slopes_add_as_vectors():
    one = common_errors(5, radial_m=1e-3, tilt_rad=0.02, tilt_azimuth_rad=0.4)
    other = common_errors(5, radial_m=-3e-3, tilt_rad=0.02, tilt_azimuth_rad=0.4 + math.pi)
    both = one.plus(other)
    assert np.allclose(both.radial_m, -2e-3, rtol=0.0, atol=1e-18)
    assert np.allclose(both.tilt_rad, 0.0, atol=1e-17)
    assert np.allclose(one.plus(one).lean, 2.0 * one.lean, rtol=1e-14)


@pytest.mark.parametrize(
    ("errors", "design", "reason"),
    [
        ({"radial_m": -0.06}, {"antenna_radius_m": 0.05}, "antenna 1 would stand on the axis"),
        ({"azimuth_rad": 0.5}, {}, "antenna 1 would stand on or beyond plate 1"),
        ({"plate_azimuth_rad": 0.5}, {}, "antenna 2 would stand on or beyond plate 1"),
        ({"plate_height_m": -0.08}, {}, "plate 1 would have no height"),
        ({"ground_plane_m": -0.2}, {}, "the ground plane of 0.2 m cannot be 0.2 m smaller"),
        ({"ground_plane_m": -0.02}, {}, "plate 1 would end beyond the ground plane"),
        ({"radial_m": math.nan}, {}, "radial_m"),
        ({"tilt_rad": 2.0}, {}, "tilt_rad of antenna 1 is 2 rad"),
    ],
    ids=str,
)
def test_what_cannot_be_built_is_refused_with_the_reason(errors, design, reason):
    with pytest.raises(GeometryError, match=reason):
        reader_body(errors=common_errors(8, **errors), **design)


def test_errors_of_another_number_of_antennas_are_refused():
    with pytest.raises(GeometryError, match="errors are those of 5 antennas, but the reader has 8"):
        reader_body(errors=common_errors(5, radial_m=1e-3))
    with pytest.raises(GeometryError, match="of 5 and of 8 antennas"):
        common_errors(5).plus(common_errors(8))
