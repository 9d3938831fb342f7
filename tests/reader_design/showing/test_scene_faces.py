"""Faces of a scene for a picture: walls, what is cut away, and what objects hide."""

import json
import struct

import numpy as np
import pytest

from octant.geometries.appearance import LOOKS, UNKNOWN, looks_of
from octant.geometries.furniture import box, cabinet
from octant.geometries.mesh_files import save_bodies
from octant.geometries.rooms import Doorway, box_room
from octant.geometries.scene import build_scene
from octant.reader_design.showing.scene_faces import hidden_points, scene_faces
from octant.reader_design.showing.scene_glb import closes_room, tube
from octant.reader_design.showing.scene_picture import View

ABOVE = View(azimuth_deg=-60.0, elevation_deg=35.0).towards


def room(**options):
    return build_scene(
        box_room((5.0, 4.0, 3.0), **options), objects=[cabinet(position_m=(1.75, 2.2, 0.0))]
    )


def test_view_points_from_the_scene_to_the_viewer():
    level = np.cos(np.radians(35))
    expected = [level / 2, -level * np.sqrt(0.75), np.sin(np.radians(35))]
    np.testing.assert_allclose(ABOVE, expected, rtol=1e-12)


@pytest.mark.parametrize("doorways", [(), (Doorway(wall=2, offset_m=1, width_m=1, height_m=2),)])
def test_the_walls_towards_the_viewer_and_the_ceiling_are_cut_away(doorways):
    faces = scene_faces(room(doorways=doorways), ABOVE)
    walls = [face for face in faces if face.wall]
    assert len(walls) == 6
    centres = np.array([f.triangles_m.mean(axis=(0, 1)) for f in walls if f.cut_away])
    assert len(centres) == 3
    assert centres[:, 0].max() == 5.0  # the wall towards +x
    assert centres[:, 1].min() == 0.0  # the wall towards -y
    assert centres[:, 2].max() == 3.0  # the ceiling
    objects = [face for face in faces if not face.wall]
    assert len(objects) == 6
    assert not any(face.cut_away for face in objects)


def test_faces_are_polygons_with_the_area_of_their_triangles():
    for face in scene_faces(
        room(doorways=(Doorway(wall=2, offset_m=1, width_m=1, height_m=2),)), ABOVE
    ):
        a, b, c = np.moveaxis(face.triangles_m, 1, 0)
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
        (corners,) = face.outlines_m
        around = np.linalg.norm(np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)) / 2
        assert around == pytest.approx(area, rel=1e-9)


def test_objects_hide_what_is_behind_them_and_walls_do_not():
    faces = scene_faces(room(), ABOVE)
    behind = np.array([2.5, 2.8, 0.1])  # beyond the cabinet, seen from -y
    before = np.array([2.5, 1.5, 0.1])
    outside = np.array([2.5, 2.375, 0.5]) - 10.0 * ABOVE
    hidden = hidden_points(faces, np.array([behind, before, outside]), ABOVE)
    assert hidden.tolist() == [True, False, True]


def test_every_named_material_has_looks_of_its_own():
    assert (
        looks_of("name = concrete, thickness_m = 0.1")
        == looks_of("itu_concrete")
        == LOOKS["concrete"]
    )
    assert looks_of("eps_r = 4.0") == UNKNOWN
    assert looks_of("glass").opacity < 1.0
    assert len({looks.colour for looks in LOOKS.values()}) == len(LOOKS)


def test_glb_has_a_named_double_sided_material_for_each_label(tmp_path):
    file = tmp_path / "t.glb"
    walls = box((5, 4, 3), material="brick", name="walls")
    save_bodies([walls, box((1, 1, 1), material="metal")], file, opacity={"walls": 0.25})
    data = file.read_bytes()
    header = json.loads(data[20 : 20 + struct.unpack("<I", data[12:16])[0]])
    brick, metal = header["materials"]
    assert (brick["name"], brick["alphaMode"], brick["doubleSided"]) == ("brick", "BLEND", True)
    assert brick["pbrMetallicRoughness"]["baseColorFactor"][3] == pytest.approx(0.25, abs=0.01)
    assert (metal["name"], metal["alphaMode"]) == ("metal", "OPAQUE")
    assert metal["pbrMetallicRoughness"]["metallicFactor"] > 0.5


def test_walls_and_ceiling_close_a_room_but_floor_and_furniture_do_not():
    scene = room()
    closing = {body.name: closes_room(body, scene) for body in scene.bodies}
    assert closing == {"walls": True, "floor": False, "ceiling": True, "cabinet": False}


def test_a_tube_follows_its_path_at_its_radius():
    path = np.array([(0.0, 0, 0), (1, 2, 2), (1, 2, 2), (4, 2, 2)])
    body = tube(path, 0.1, name="p", material="m")
    assert len(body.faces) == 2 * 12  # the leg without length is left out
    leg = body.vertices_m[:12]
    axis = np.array([1, 2, 2]) / 3
    across = leg - np.outer(leg @ axis, axis)
    np.testing.assert_allclose(np.linalg.norm(across, axis=1), 0.1, rtol=1e-12)
    assert body.area_m2 == pytest.approx(6 * 0.1 * (3.0 + 3.0), rel=1e-9)
