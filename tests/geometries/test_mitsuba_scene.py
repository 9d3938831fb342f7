"""Scenes of Mitsuba and Sionna RT: shapes in their places, materials, and refusals.

Places marked "Mitsuba 3.7" were printed by Mitsuba itself for the same XML.
"""

import math

import numpy as np
import pytest

from octant.em.medium.materials import material
from octant.geometries.audit import audit_mesh
from octant.geometries.errors import GeometryError, MaterialRangeError, OctantError
from octant.geometries.furniture import box
from octant.geometries.mesh_files import load_bodies, save_bodies
from octant.geometries.scene import build_scene

CONCRETE = '<bsdf type="itu-radio-material" id="m"><string name="type" value="concrete"/></bsdf>'
REF = '<ref id="m" name="bsdf"/>'


@pytest.fixture
def scene(tmp_path):
    def load(content, **options):
        file = tmp_path / "scene.xml"
        file.write_text(f'<scene version="2.1.0">\n{content}\n</scene>')
        return load_bodies(file, **options)

    return load


def shape(scene, inside="", *, kind="rectangle", before=""):
    (body,) = scene(f'{before}{CONCRETE}<shape type="{kind}" id="s">{inside}{REF}</shape>')
    return body


def placed(scene, steps, *, kind="rectangle"):
    return shape(scene, f'<transform name="to_world">{steps}</transform>', kind=kind)


# ------------------------------------------------------------------------------ places


@pytest.mark.parametrize(
    ("kind", "steps", "bounds"),
    [
        (
            "rectangle",
            '<translate x="1"/><rotate z="1" angle="90"/><scale value="2"/>',
            [(-2, 0, 0), (2, 4, 0)],
        ),
        (
            "cube",
            '<translate x="1"/><rotate z="1" angle="90"/><scale value="2"/>',
            [(-2, 0, -2), (2, 4, 2)],
        ),
        (
            "rectangle",
            '<matrix value="1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1"/>',
            [(4, 5, 7), (6, 7, 7)],
        ),
        ("disk", "", [(-1, -1, 0), (1, 1, 0)]),
        ("cylinder", "", [(-1, -1, 0), (1, 1, 1)]),
        ("rectangle", '<scale x="3" y="0.5"/>', [(-3, -0.5, 0), (3, 0.5, 0)]),
    ],
)
def test_shapes_stand_where_mitsuba_puts_them(scene, kind, steps, bounds):  # Mitsuba 3.7
    body = placed(scene, steps, kind=kind)
    np.testing.assert_allclose(body.bounds_m, bounds, atol=1e-12)


def test_a_shape_that_looks_at_a_point_is_turned_as_in_mitsuba(scene):
    body = placed(scene, '<lookat origin="1,2,3" target="4,6,3.5" up="0,0,1"/>')
    expected = [(0.140298, 1.3204, 2.00496), (1.8597, 2.6796, 3.99504)]  # Mitsuba 3.7
    np.testing.assert_allclose(body.bounds_m, expected, atol=5e-6)


def test_the_axes_of_lookat_are_left_up_and_ahead_as_in_mitsuba(scene):
    body = placed(
        scene, '<translate value="2 3 1"/><lookat origin="1,2,3" target="4,6,3.5" up="0,0,1"/>'
    )
    left, up = (-0.8, 0.6, 0.0), (-0.0597022, -0.079603, 0.995037)
    ahead = (0.597022, 0.79603, 0.0995037)
    centre = np.array([1, 2, 3]) + np.array([2, 3, 1]) @ np.array([left, up, ahead])  # Mitsuba 3.7
    np.testing.assert_allclose(body.bounds_m.mean(axis=0), centre, atol=5e-6)


def test_a_sphere_has_centre_and_radius_before_its_transform(scene):
    centre = '<point name="center" x="1" y="2" z="3"/><float name="radius" value="0.5"/>'
    body = shape(
        scene, centre + '<transform name="to_world"><scale value="2"/></transform>', kind="sphere"
    )
    np.testing.assert_allclose(body.bounds_m, [(1, 3, 5), (3, 5, 7)], atol=1e-12)  # Mitsuba 3.7
    distance = np.linalg.norm(body.vertices_m - (2, 4, 6), axis=1)
    np.testing.assert_allclose(distance, 1.0, rtol=1e-12)


def test_a_cylinder_stands_between_its_two_points(scene):
    ends = (
        '<point name="p0" x="1" y="2" z="3"/><point name="p1" x="1" y="4" z="3"/>'
        '<float name="radius" value="0.5"/>'
    )
    body = shape(scene, ends, kind="cylinder")
    np.testing.assert_allclose(body.bounds_m[:, 1], (2, 4), atol=1e-12)
    about = np.hypot(body.vertices_m[:, 0] - 1, body.vertices_m[:, 2] - 3)
    np.testing.assert_allclose(about, 0.5, rtol=1e-12)
    centre = body.triangles_m.mean(axis=1)
    a, b, c = np.moveaxis(body.triangles_m, 1, 0)
    outward = np.sum(np.cross(b - a, c - a)[:, ::2] * (centre - (1, 0, 3))[:, ::2], axis=1)
    assert (outward > 0).all()
    assert body.area_m2 == pytest.approx(24 * 2 * 2 * 0.5 * math.sin(math.pi / 24), rel=1e-12)


@pytest.mark.parametrize(
    ("extra", "up"),
    [
        ("", 1.0),
        ('<boolean name="flip_normals" value="true"/>', -1.0),
        ('<transform name="to_world"><scale x="-1"/></transform>', 1.0),
        ('<transform name="to_world"><rotate x="1" angle="180"/></transform>', -1.0),
    ],
)
def test_the_winding_follows_flips_and_turns_but_not_mirrors(scene, extra, up):
    a, b, c = shape(scene, extra).triangles_m[0]
    assert np.sign(np.cross(b - a, c - a)[2]) == up


def test_variables_are_filled_in_from_their_defaults(scene):
    inside = '<transform name="to_world"><translate z="$height"/></transform>'
    body = shape(scene, inside, before='<default name="height" value="2.5"/>')
    assert (body.vertices_m[:, 2] == 2.5).all()


def test_binary_ply_with_texture_coordinates_is_read_to_its_float32(scene, tmp_path):
    """Vertices as Sionna's own scenes have them: x y z u v, little-endian."""
    corners = np.array([(0, 0, 0.1), (1, 0, 0.2), (1, 1, 0.3), (0, 1, 0.7)], dtype="<f4")
    vertices = np.column_stack((corners, np.full((4, 2), 9.0, "<f4"))).astype("<f4")
    header = (
        "ply\nformat binary_little_endian 1.0\nelement vertex 4\n"
        + "".join(f"property float {n}\n" for n in "xyzuv")
        + "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.zeros(2, dtype=[("n", "u1"), ("v", "<i4", 3)])
    faces["n"], faces["v"] = 3, [(0, 1, 2), (0, 2, 3)]
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "sheet.ply").write_bytes(
        header.encode() + vertices.tobytes() + faces.tobytes()
    )
    name = '<string name="filename" value="meshes/sheet.ply"/>'
    body = shape(scene, name + '<boolean name="face_normals" value="true"/>', kind="ply")
    np.testing.assert_array_equal(body.vertices_m, corners.astype(np.float64))
    np.testing.assert_array_equal(body.faces, [(0, 1, 2), (0, 2, 3)])


def test_obj_meshes_are_moved_with_their_shape(scene, tmp_path):
    save_bodies([box((1, 2, 3), material="wood")], tmp_path / "box.obj")
    inside = '<string name="filename" value="box.obj"/><transform name="to_world">'
    body = shape(scene, inside + '<translate value="1 1 1"/></transform>', kind="obj")
    np.testing.assert_array_equal(body.bounds_m, [(1, 1, 1), (2, 3, 4)])
    assert (body.name, body.material) == ("s", "concrete")


# --------------------------------------------------------------------------- materials


@pytest.mark.parametrize(
    ("bsdf", "label"),
    [
        (
            (
                '<bsdf type="itu-radio-material" id="m"><string name="type" value="glass"/>'
                '<float name="thickness" value="0.01"/></bsdf>'
            ),
            "name = glass, thickness_m = 0.01",
        ),
        ('<bsdf type="diffuse" id="mat-itu_metal"/>', "metal"),
        ('<bsdf type="itu-radio-material" id="itu-ceiling-board"/>', "ceiling_board"),
        (
            '<bsdf type="twosided" id="mat-itu_brick"><bsdf type="diffuse" id="inner"/></bsdf>',
            "brick",
        ),
        (
            (
                '<bsdf type="twosided"><bsdf type="diffuse" id="mat-itu_wood">'
                '<float name="thickness" value="0.03"/></bsdf></bsdf>'
            ),
            "name = wood, thickness_m = 0.03",
        ),
        (
            (
                '<bsdf type="radio-material" id="own">'
                '<float name="relative_permittivity" value="4"/>'
                '<float name="conductivity" value="0.02"/>'
                '<float name="thickness" value="$t"/></bsdf>'
            ),
            "eps_r = 4.0, sigma_s_per_m = 0.02, thickness_m = 0.2",
        ),
        ('<bsdf type="diffuse" id="mat-Oak"/>', "Oak"),
    ],
)
@pytest.mark.parametrize("nested", [True, False])
def test_materials_become_labels_of_the_study_file(scene, bsdf, label, nested):
    name = bsdf.split('id="')[1].split('"')[0] if 'twosided">' not in bsdf else None
    default = '<default name="t" value="0.2"/>'
    alone = nested or name is None  # a material without an id cannot be referred to
    inside, before = (bsdf, default) if alone else (f'<ref id="{name}"/>', default + bsdf)
    (body,) = scene(f'{before}<shape type="cube">{inside}</shape>')
    assert body.material == label


def test_a_label_of_a_slab_means_the_slab():
    slab = material("name = concrete, thickness_m = 0.1")
    assert (slab.name, slab.thickness_m) == ("concrete", 0.1)
    own = material("eps_r = 4.0, sigma_s_per_m = 0.02, thickness_m = 0.2")
    assert own == material({"eps_r": 4.0, "sigma_s_per_m": 0.02, "thickness_m": 0.2})
    with pytest.raises(MaterialRangeError, match="a number is needed"):
        material("eps_r = four")


def test_what_the_caller_says_of_materials_wins(scene):
    content = f'{CONCRETE}<shape type="cube" id="mesh-a">{REF}</shape><shape type="disk"/>'
    with pytest.raises(GeometryError, match=r"'disk' of .* has no material"):
        scene(content)
    bodies = scene(content, materials_by_name={"disk": "wood"})
    assert [(b.name, b.material) for b in bodies] == [("a", "concrete"), ("disk", "wood")]
    assert [b.material for b in scene(content, material="brick")] == ["brick", "brick"]


def test_a_scene_can_be_audited_and_built(scene, tmp_path):
    bodies = scene(f'{CONCRETE}<shape type="cube">{REF}</shape>')
    assert len(build_scene(bodies).facets.facet_plane) == 6
    assert any("12 triangles" in line for line in audit_mesh(tmp_path / "scene.xml").lines())


def test_a_scene_may_be_drawn_in_another_unit(scene):
    (body,) = scene(f'{CONCRETE}<shape type="cube">{REF}</shape>', unit="mm")
    np.testing.assert_allclose(body.bounds_m, [(-1e-3,) * 3, (1e-3,) * 3])


# ---------------------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ('<shape type="ply"><string name="filename" value="no.ply"/></shape>', "does not exist"),
        ('<shape type="ply"/>', "names no file"),
        ('<shape type="hair"/>', "'hair', but only ply, obj"),
        ('<shape type="cube"><ref id="mat-x"/></shape>', "refers to the material 'mat-x'"),
        ('<include filename="more.xml"/>', "<include> in"),
        (
            '<shape type="cube"><transform name="to_world"><scale x="0"/></transform></shape>',
            "is singular",
        ),
        (
            '<shape type="cube"><transform name="to_world"><skew/></transform></shape>',
            "is not a transformation",
        ),
        (
            (
                '<shape type="cube"><transform name="to_world"><matrix value="1 2"/></transform>'
                "</shape>"
            ),
            "has 2 numbers",
        ),
        (
            '<shape type="cube"><transform name="to_world"><rotate angle="3"/></transform></shape>',
            "needs an axis",
        ),
        (
            '<shape type="cube"><transform name="to_world"><translate x="a"/></transform></shape>',
            "finite numbers",
        ),
        (
            '<shape type="cube"><transform name="to_world"><translate x="$h"/></transform></shape>',
            r"uses \$h",
        ),
        (
            (
                '<shape type="cube"><transform name="to_world">'
                '<lookat origin="0 0 0" target="0 0 1" up="0 0 1"/></transform></shape>'
            ),
            "along its own up",
        ),
        ('<shape type="sphere"><float name="radius" value="-1"/></shape>', "must be positive"),
        ("", "holds no triangles"),
        ("<shape", "cannot be read as a Mitsuba scene"),
    ],
)
def test_what_cannot_be_read_is_refused_in_one_sentence(scene, content, says):
    with pytest.raises(OctantError, match=says) as error:
        scene(content, material="wood")
    assert "\n" not in str(error.value)


def test_entities_are_not_expanded(tmp_path):
    secret = tmp_path / "secret.txt"
    secret.write_text("secret")
    file = tmp_path / "scene.xml"
    file.write_text(
        f'<!DOCTYPE scene [<!ENTITY x SYSTEM "{secret.as_uri()}">]>'
        '<scene><shape type="cube" id="s">&x;</shape></scene>'
    )
    with pytest.raises(GeometryError, match="declares a DOCTYPE"):
        load_bodies(file, material="wood")
