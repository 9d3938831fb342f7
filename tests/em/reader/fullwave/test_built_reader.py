"""The full-wave mesh and solution of a reader as built: against symmetry and first order."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.reader.cache import cached_responses
from octant.em.reader.fullwave.mesh import reader_mesh
from octant.em.reader.fullwave.solve import solve_reader
from octant.em.reader.response import reader_response
from octant.geometries.build_errors import BuildErrors, common_errors, tilt_of_lean
from octant.geometries.errors import AntennaError, GeometryError
from octant.geometries.reader_body import reader_body

FREQUENCY_HZ = 2.4e9
ANTENNAS = 4
DESIGN = {"antennas": ANTENNAS, "antenna_radius_m": 0.06, "ground_plane_m": 0.16}
THETA, PHI = np.meshgrid(np.radians([25.0, 60.0, 95.0, 140.0]), np.radians([3.0, 77.0, 201.0]))


def random_errors(seed, scale=1.0):
    draw = np.random.default_rng(seed).uniform
    tilt, towards = tilt_of_lean(scale * draw(-0.035, 0.035, (ANTENNAS, 2)))
    return BuildErrors(
        radial_m=scale * draw(-1e-3, 1e-3, ANTENNAS),
        azimuth_rad=scale * draw(-0.01, 0.01, ANTENNAS),
        gap_m=scale * draw(-1e-3, 1e-3, ANTENNAS),
        length_m=scale * draw(-1e-3, 1e-3, ANTENNAS),
        tilt_rad=tilt,
        tilt_azimuth_rad=towards,
        plate_azimuth_rad=scale * draw(-0.035, 0.035, ANTENNAS),
        plate_height_m=scale * draw(-1e-3, 1e-3, ANTENNAS),
        ground_plane_m=scale * float(draw(-1e-3, 1e-3)),
    )


def mesh_of(errors=None, *, antenna="dipole", cells=4.0, gap_m=0.005, **design):
    body = reader_body(**{**DESIGN, **design}, errors=errors)
    return reader_mesh(
        body, frequency_hz=FREQUENCY_HZ, antenna=antenna, gap_m=gap_m, cells_per_wavelength=cells
    )


@cache
def drawn(shape, antenna, plane_m):
    design = {"ground_plane_shape": shape, "monopole_plane_m": plane_m}
    return solve_reader(mesh_of(antenna=antenna, **design))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("antenna", "plane_m"), [("dipole", 0.0), ("monopole", 0.0), ("monopole", 0.03)]
)
def test_turning_everything_on_a_round_plane_turns_the_patterns(antenna, plane_m):
    turn = math.radians(7.0)
    design = {"ground_plane_shape": "round", "monopole_plane_m": plane_m}
    errors = common_errors(ANTENNAS, azimuth_rad=turn, plate_azimuth_rad=turn)
    there = solve_reader(mesh_of(errors, antenna=antenna, **design)).far_field(THETA, PHI + turn)
    here = drawn("round", antenna, plane_m).far_field(THETA, PHI)
    assert np.allclose(there, here, rtol=0.0, atol=1e-9)


def test_mirrored_errors_give_mirrored_patterns():
    errors = random_errors(5)
    partner = -np.arange(ANTENNAS) % ANTENNAS
    plate = (-np.arange(ANTENNAS) - 1) % ANTENNAS
    mirrored = BuildErrors(
        radial_m=errors.radial_m[partner],
        azimuth_rad=-errors.azimuth_rad[partner],
        gap_m=errors.gap_m[partner],
        length_m=errors.length_m[partner],
        tilt_rad=errors.tilt_rad[partner],
        tilt_azimuth_rad=-errors.tilt_azimuth_rad[partner],
        plate_azimuth_rad=-errors.plate_azimuth_rad[plate],
        plate_height_m=errors.plate_height_m[plate],
        ground_plane_m=errors.ground_plane_m,
    )
    plain = drawn("square", "dipole", 0.0)
    here, there = (solve_reader(mesh_of(e)) for e in (errors, mirrored))
    change = here.far_field(THETA, PHI) - plain.far_field(THETA, PHI)
    image = there.far_field(THETA, -PHI) - plain.far_field(THETA, -PHI)
    image = image[partner] * np.array((1.0, -1.0))
    # Only the strips' diagonals are not mirrored.
    assert np.abs(image - change).max() < 5e-3 * np.abs(change).max()


def test_leaning_antennas_with_raised_feet_are_the_array_turned_as_a_whole():
    # The ground plane is a speck half a metre below; three antennas stand 5 cm from the axis.
    lean, gap, count = 0.02, 0.5, 3
    design = {
        "antennas": count,
        "antenna_radius_m": 0.0025,
        "ground_plane_m": 0.005,
        "plate_height_m": 0.0,
    }
    upright = common_errors(count, radial_m=0.05)
    azimuth = 2.0 * math.pi * np.arange(count) / count
    east = 0.0525 * np.cos(azimuth)
    # Turned about y through (0, 0, gap): z' = z - x sin, x' = x cos; a vertical leans to +x.
    x, y = east * math.cos(lean), 0.0525 * np.sin(azimuth)
    built = np.arctan2(y, x)
    tilt, towards = np.full(count, lean), -built
    turned = replace(
        upright,
        radial_m=np.hypot(x, y) - 0.0025,
        azimuth_rad=np.angle(np.exp(1j * (built - azimuth))),
        gap_m=-east * math.sin(lean),
        tilt_rad=tilt,
        tilt_azimuth_rad=towards,
    )
    straight, leaning = (solve_reader(mesh_of(e, gap_m=gap, **design)) for e in (upright, turned))
    direction = np.stack(
        [np.sin(THETA) * np.cos(PHI), np.sin(THETA) * np.sin(PHI), np.cos(THETA)], axis=-1
    )
    c, s = math.cos(lean), math.sin(lean)
    turn = np.array(((c, 0.0, s), (0.0, 1.0, 0.0), (-s, 0.0, c)))
    there = direction @ turn.T
    fields = []
    for result, points in ((straight, direction), (leaning, there)):
        theta, phi = np.arccos(points[..., 2]), np.arctan2(points[..., 1], points[..., 0])
        pattern = result.far_field(theta, phi)
        ct, st, cp, sp = np.cos(theta), np.sin(theta), np.cos(phi), np.sin(phi)
        along_theta = np.stack((ct * cp, ct * sp, -st), axis=-1)
        along_phi = np.stack((-sp, cp, np.zeros_like(sp)), axis=-1)
        wave = 2.0 * math.pi * FREQUENCY_HZ / 299792458.0
        phase = np.exp(-1j * wave * gap * points[..., 2])  # about the point of the turn
        vector = pattern[..., :1] * along_theta + pattern[..., 1:] * along_phi
        fields.append(vector * phase[..., None])
    expected = fields[0] @ turn.T
    assert np.abs(expected - fields[0]).max() > 0.01
    assert np.abs(fields[1] - expected).max() < 2e-4


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "step"),
    [
        ("radial_m", 1e-4),
        ("azimuth_rad", 1e-3),
        ("gap_m", 1e-4),
        ("length_m", 1e-4),
        ("plate_azimuth_rad", 1e-3),
        ("plate_height_m", 1e-4),
        ("tilt_rad", 1e-3),
    ],
)
def test_levels_change_linearly_with_small_errors(name, step):
    phi = np.radians([0.0, 20.0, 90.0, 135.0])

    def ratio_db(value):
        values = np.zeros(ANTENNAS)
        values[1] = abs(value)
        given = {name: math.copysign(1.0, value) * values}
        if name == "tilt_rad":
            towards = np.full(ANTENNAS, 0.3 if value > 0.0 else 0.3 + math.pi)
            given = {name: values, "tilt_azimuth_rad": towards}
        errors = replace(common_errors(ANTENNAS), **given)
        field = solve_reader(mesh_of(errors)).far_field(1.2, phi)
        gain = (np.abs(field) ** 2).sum(axis=-1)
        return 10.0 * np.log10(gain[0] / gain[1])

    coarse, fine = ((ratio_db(h) - ratio_db(-h)) / (2.0 * h) for h in (step, 0.5 * step))
    assert np.abs(fine).max() * step > 1e-4
    assert np.abs(fine - coarse).max() < 2e-3 * np.abs(fine).max()


def test_symmetry_is_used_when_the_built_reader_has_it_and_only_then():
    common = solve_reader(mesh_of(common_errors(ANTENNAS, radial_m=5e-4, tilt_rad=0.03)))
    assert common.basis.sectors == ANTENNAS
    alone = solve_reader(
        mesh_of(common_errors(ANTENNAS, radial_m=5e-4, tilt_rad=0.03)), symmetry=False
    )
    assert np.allclose(
        common.far_field(THETA, PHI), alone.far_field(THETA, PHI), rtol=0.0, atol=1e-9
    )
    errors = common_errors(ANTENNAS)
    one = replace(errors, gap_m=np.array([1e-6, 0.0, 0.0, 0.0]))
    assert solve_reader(mesh_of(one)).basis.sectors == 1


def test_strips_lie_along_the_lines_that_the_errors_give():
    errors = random_errors(3)
    mesh, body = mesh_of(errors), reader_body(**DESIGN, errors=errors)
    half_wave = 0.5 * 299792458.0 / FREQUENCY_HZ
    for i in range(ANTENNAS):
        points = mesh.vertices_m[np.unique(mesh.faces[mesh.antenna_of_face == i])]
        points = points[np.argsort(points[:, 2])]
        low, high = points[:2].mean(axis=0), points[-2:].mean(axis=0)
        assert np.allclose(low[:2], body.element_feet_m[i, :2], rtol=0.0, atol=1e-15)
        assert low[2] == pytest.approx(0.005 + errors.gap_m[i], abs=1e-15)
        assert np.linalg.norm(high - low) == pytest.approx(half_wave + errors.length_m[i])
        axis = (high - low) / np.linalg.norm(high - low)
        assert math.acos(axis[2]) == pytest.approx(errors.tilt_rad[i], abs=1e-12)
        towards = math.atan2(axis[1], axis[0]) - body.built.element_azimuths_rad[i]
        wrong = math.remainder(towards - errors.tilt_azimuth_rad[i], 2.0 * math.pi)
        assert abs(wrong) < 1e-9
        assert np.allclose(mesh.phase_centres_m[i], 0.5 * (low + high), rtol=0.0, atol=1e-12)
        feed = mesh.feed_top_m[i] - mesh.feed_bottom_m[i]
        assert np.linalg.norm(feed) == pytest.approx(0.0057, rel=1e-12)
        assert np.linalg.norm(np.cross(feed, axis)) < 1e-12


@pytest.mark.parametrize("shape", ["square", "round", "octagon"])
def test_the_moved_sheets_are_those_of_the_built_body(shape):
    errors = replace(random_errors(4), ground_plane_m=0.0)
    errors = replace(errors, ground_plane_m=5e-4)
    mesh = mesh_of(errors, ground_plane_shape=shape, plate_outer_radius_m=0.07, cells=6.0)
    plain = mesh_of(ground_plane_shape=shape, plate_outer_radius_m=0.07, cells=6.0)
    body = reader_body(**DESIGN, ground_plane_shape=shape, plate_outer_radius_m=0.07, errors=errors)
    assert np.array_equal(mesh.faces, plain.faces)
    sheets = mesh.faces[mesh.antenna_of_face < 0]
    corners = mesh.vertices_m[sheets]
    upright = np.abs(corners[..., 2]).max(axis=1) > 1e-9
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    heights = 0.08 + 0.5 * (errors.plate_height_m + errors.plate_height_m.mean())
    assert areas[upright].sum() == pytest.approx((0.07 * heights).sum(), rel=1e-12)
    if shape == "round":  # a polygon whose corners are on the circle, as drawn
        rim = np.hypot(*corners[~upright].reshape(-1, 3)[:, :2].T).max()
        assert rim == pytest.approx(0.08 + 2.5e-4, rel=1e-12)
    else:
        drawn_area = {"square": 1.0, "octagon": 2.0 * (math.sqrt(2.0) - 1.0)}[shape]
        assert areas[~upright].sum() == pytest.approx(drawn_area * 0.1605**2, rel=1e-12)
    points = corners[upright].reshape(-1, 3)
    radius = np.hypot(points[:, 0], points[:, 1])
    azimuth = np.arctan2(points[:, 1], points[:, 0])
    off = azimuth[:, None] - body.built.plate_azimuths_rad
    off = np.abs(np.angle(np.exp(1j * off))).min(axis=1) * radius
    assert off.max() < 1e-12


@pytest.mark.parametrize("shape", ["square", "round", "octagon"])
@pytest.mark.parametrize("radius_m", [0.06, 0.075, 0.079, 0.08])
@pytest.mark.parametrize("gap_m", [0.001, 0.005])
def test_a_millimetre_and_two_degrees_can_always_be_meshed(shape, radius_m, gap_m):
    errors = random_errors(6)
    errors = replace(errors, gap_m=0.5 * gap_m * errors.gap_m / 1e-3)
    mesh = mesh_of(errors, gap_m=gap_m, ground_plane_shape=shape, antenna_radius_m=radius_m)
    ground = mesh.faces[np.abs(mesh.vertices_m[mesh.faces, 2]).max(axis=1) == 0.0]
    corners = mesh.vertices_m[ground]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2]
    assert np.abs(area).min() > 0.0
    body = reader_body(
        **{**DESIGN, "antenna_radius_m": radius_m, "ground_plane_shape": shape}, errors=errors
    )
    if radius_m < 0.07:  # well inside: the fine mesh is below the foot, wherever that is
        nearest = np.abs(mesh.vertices_m[:, None] - body.element_feet_m).max(axis=2).min(axis=0)
        assert nearest.max() < 1e-12


@pytest.mark.parametrize(
    ("errors", "design", "reason"),
    [
        ({"gap_m": -0.005}, {}, "gap_m of antenna 1 would be 0 m"),
        ({"length_m": -0.07}, {}, "length_m of antenna 1 would be"),
        ({"length_m": -0.058}, {}, "feed_gap_m is 0.0057 m, but the antenna is only 0.004"),
        ({"tilt_rad": 1.4, "tilt_azimuth_rad": 1.6}, {}, "antenna 1 touches the plate at"),
        (
            {"radial_m": 1e-3},
            {"antenna": "monopole", "antenna_radius_m": 0.08},
            "antenna 1 is joined to the ground plane at or near its rim",
        ),
        (
            {"azimuth_rad": 0.06},
            {"antenna": "monopole", "monopole_plane_m": 0.2},
            "touches by its own plane the plate",
        ),
        (
            {"plate_azimuth_rad": 0.01},
            {"plate_outer_radius_m": 0.08 * math.sqrt(2.0)},
            "ends on a corner",
        ),
    ],
    ids=str,
)
def test_what_cannot_be_built_is_refused_with_the_reason(errors, design, reason):
    with pytest.raises(GeometryError, match=reason):
        mesh_of(common_errors(ANTENNAS, **errors), **design)


def test_only_full_wave_takes_build_errors():
    body = reader_body(**DESIGN, errors=common_errors(ANTENNAS, radial_m=1e-3))
    with pytest.raises(AntennaError, match='only "fullwave" knows them'):
        reader_response(body, make_antenna("dipole", FREQUENCY_HZ), model="rays", gap_m=0.005)


@pytest.mark.slow
def test_the_cache_tells_built_readers_apart_and_can_be_left_out(tmp_path):
    antenna = make_antenna("dipole", FREQUENCY_HZ)

    def gain(errors, *, keep):
        body = reader_body(**DESIGN, errors=errors)
        options = {"cells_per_wavelength": 4.0, "folder": tmp_path, "keep": keep}
        return cached_responses(body, antenna, (FREQUENCY_HZ,), **options)[0].response.pattern

    wrong = common_errors(ANTENNAS, gap_m=1e-3)
    plain = gain(None, keep=True)
    assert len(list(tmp_path.iterdir())) == 1
    off = gain(wrong, keep=False)
    assert len(list(tmp_path.iterdir())) == 1
    assert np.array_equal(off, gain(wrong, keep=True))
    assert len(list(tmp_path.iterdir())) == 2
    assert not np.array_equal(off, plain)
