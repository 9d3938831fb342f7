"""The same room wherever its file's origin lies: a national grid, or a corner of the room."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from octant.geometries.audit import audit_mesh
from octant.geometries.bodies import Body, place
from octant.geometries.errors import GeometryError
from octant.geometries.furniture import box
from octant.geometries.mesh_files import load_bodies, save_bodies
from octant.geometries.planes import observed_rounding
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene
from octant.geometries.wedges import find_wedges

UTM_M = (500_000.0, 5_400_000.0, 120.0)


def furnished(thickness_m, yaw_rad=0.0):
    """A room with a wall and a cabinet in it, about the origin."""
    bodies = [
        *box_room((5.0, 4.0, 3.0)),
        box((thickness_m, 3.0, 3.0), position_m=(2.45, 0.0, 0.0), material="brick", name="wall"),
        box((1.0, 1.0, 1.5), position_m=(3.0, 2.0, 0.0), material="metal", name="cabinet"),
    ]
    return [place(body, yaw_rad=yaw_rad) for body in bodies]


def moved(bodies, shift_m):
    return [place(body, position_m=shift_m) for body in bodies]


def written_and_read(bodies, path):
    save_bodies(bodies, path)
    return load_bodies(path, unit="m", material="brick")


def shape(bodies):
    """Planes, facets, solids and wedges of a scene."""
    scene = build_scene(bodies)
    facets = scene.facets
    counts = len(facets.plane_normal), len(facets.facet_plane), len(scene.solids)
    return *counts, len(find_wedges(scene))


@pytest.mark.parametrize("thickness_m", [0.1, 0.01, 0.001])
@pytest.mark.parametrize(
    "shift_m", [(5e3, -2e3, 0.0), (5e4, 0.0, 0.0), UTM_M, (0.0, 1e7, 0.0)], ids=str
)
def test_a_thin_wall_and_a_cabinet_stay_solid_far_from_the_origin(thickness_m, shift_m, tmp_path):
    near = written_and_read(furnished(thickness_m), tmp_path / "near.obj")
    far = written_and_read(moved(near, shift_m), tmp_path / "far.obj")
    assert shape(far) == shape(near)
    assert shape(near)[2] == 2


@given(
    yaw=st.floats(0.0, 6.3),
    x=st.floats(-1e6, 1e6),
    y=st.floats(-1e7, 1e7),
    thickness_m=st.floats(1e-3, 0.2),
)
def test_a_room_is_the_same_wherever_it_stands(yaw, x, y, thickness_m):
    near = furnished(thickness_m, yaw)
    planes, *rest, _ = shape(near)
    there, *same, _ = shape(moved(near, (x, y, 0.0)))
    assert same == rest
    # The end faces of thinner walls are slivers, whose planes rounding tilts more than the room's:
    # some stay apart from them, which costs time and loses no path.
    assert there == planes or thickness_m < 0.01


@pytest.mark.parametrize("kind", ["stl", "glb", "ply"])
def test_float32_far_from_the_origin_is_refused_with_the_size_of_its_rounding(kind, tmp_path):
    far = moved(furnished(0.1), (500_000.3, 0.0, 0.0))
    with pytest.raises(GeometryError, match=r"500 km from its origin .* rounded to 60 mm there"):
        written_and_read(far, tmp_path / f"far.{kind}")


@pytest.mark.parametrize("kind", ["stl", "glb", "ply"])
@pytest.mark.parametrize("shift_m", [0.0, 100.0, 300.0])
def test_flat_walls_that_float32_made_uneven_stay_flat(kind, shift_m, tmp_path):
    near = furnished(0.1, 0.7)
    read = written_and_read(moved(near, (shift_m, 0.0, 0.0)), tmp_path / f"room.{kind}")
    assert len(build_scene(read).facets.plane_normal) == shape(near)[0]


def test_what_counts_as_float32_is_seen_in_the_digits():
    drawn = np.array([[500_002.45, 5_400_001.0, 0.1], [500_000.0, 5_400_004.0, 3.0]])
    stored = drawn.astype(np.float32).astype(np.float64)
    printed = np.round(stored, 6)
    rounding = 0.5**24 * 500_000.0  # y is in whole metres
    assert observed_rounding(drawn) == 0.0
    assert observed_rounding(np.round(drawn)) == 0.0  # whole metres, which float32 could hold too
    assert observed_rounding(stored) == pytest.approx(rounding, rel=1e-6)
    assert observed_rounding(printed) == pytest.approx(rounding, rel=1e-6)


def test_the_audit_prints_the_digits_that_tell_places_apart():
    text = "\n".join(audit_mesh(moved(furnished(0.1), UTM_M)).lines())
    assert "x 500000 to 500005 m, y 5400000 to 5400004 m, z 120 to 123 m" in text


def test_a_corner_farther_away_than_any_place_is_refused():
    with pytest.raises(GeometryError, match=r"corner at 1e\+200 m, but at most 1e\+08 m"):
        Body(
            name="far",
            vertices_m=[[0, 0, 0], [1e200, 0, 0], [0, 1, 0]],
            faces=[[0, 1, 2]],
            material="wood",
        )
