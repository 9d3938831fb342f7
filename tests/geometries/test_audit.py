"""The audit finds each fault that is put into a clean mesh, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from octant.geometries.audit import audit_mesh
from octant.geometries.bodies import Body, place
from octant.geometries.errors import GeometryError
from octant.geometries.furniture import box, cylinder
from octant.geometries.mesh_files import save_bodies
from octant.geometries.reader_body import reader_body
from octant.geometries.rooms import Doorway, box_room

ROOM = box_room((5.0, 4.0, 3.0))
CABINET = box((1.5, 0.35, 1.0), material="metal", position_m=(1, 1, 0.5), name="cabinet")


def kinds(audit):
    return [finding.kind for finding in audit.findings]


def with_faces(body, faces):
    return replace(body, faces=np.asarray(faces))


def grid(nx, ny, size_x, size_y):
    """A plane sheet of nx by ny cells, as one body."""
    x, y = np.meshgrid(np.linspace(0, size_x, nx + 1), np.linspace(0, size_y, ny + 1))
    vertices = np.column_stack((x.ravel(), y.ravel(), 0 * x.ravel()))
    a = (np.arange(nx)[None, :] + (nx + 1) * np.arange(ny)[:, None]).ravel()
    faces = np.concatenate(
        (
            np.column_stack((a, a + 1, a + nx + 2)),
            np.column_stack((a, a + nx + 2, a + nx + 1)),
        )
    )
    return Body(name=f"grid {nx}x{ny}", vertices_m=vertices, faces=faces, material="wood")


def test_a_clean_room_has_no_findings_and_the_numbers_of_a_box():
    audit = audit_mesh(ROOM)
    assert audit.findings == ()
    assert audit.free_edges == 0
    assert audit.faces == 12
    assert audit.vertices == 16  # 8 of the walls, 4 of the floor, 4 of the ceiling
    assert audit.welded_vertices == 8
    assert audit.area_m2 == pytest.approx(2 * (20 + 15 + 12))
    np.testing.assert_array_equal(audit.bounds_m, [(0, 0, 0), (5, 4, 3)])
    # 12 edges of 3, 4, 5 m and 6 diagonals of 5 (3-4), sqrt(34) and sqrt(41) m
    np.testing.assert_allclose(audit.edge_lengths_m, (3, 5, np.sqrt(41)))
    assert (audit.components, audit.closed_components, audit.inward_components) == (1, 1, 1)


def test_a_solid_in_a_room_is_a_part_of_its_own():
    audit = audit_mesh((*ROOM, CABINET))
    assert audit.findings == ()
    assert (audit.components, audit.closed_components, audit.inward_components) == (2, 2, 1)


def test_a_doorway_is_a_free_border_of_known_length():
    door = Doorway(wall=0, offset_m=1.0, width_m=0.9, height_m=2.0)
    audit = audit_mesh(box_room((5, 4, 3), doorways=[door]))
    assert kinds(audit) == ["free_edges"]
    assert audit.free_edges > 0
    assert audit.free_edge_length_m == pytest.approx(2 * 2.0 + 2 * 0.9)
    assert audit.closed_components == 0


def test_a_missing_triangle_leaves_three_free_edges():
    audit = audit_mesh([with_faces(CABINET, CABINET.faces[1:])])
    assert (audit.free_edges, audit.open_edges) == (3, 3)
    assert kinds(audit) == ["free_edges"]


def test_stl_like_triangles_with_corners_of_their_own_are_the_same_mesh():
    soup = CABINET.triangles_m.reshape(-1, 3)
    audit = audit_mesh([replace(CABINET, vertices_m=soup, faces=np.arange(36).reshape(-1, 3))])
    assert audit.findings == ()
    assert (audit.vertices, audit.welded_vertices) == (36, 8)


def test_duplicate_triangles_are_counted_whichever_way_they_wind():
    faces = np.concatenate((CABINET.faces, CABINET.faces[:1], CABINET.faces[1:3, ::-1]))
    audit = audit_mesh([with_faces(CABINET, faces)])
    assert audit.duplicate_faces == 3
    assert kinds(audit) == ["duplicate_faces"]
    assert audit.free_edges == 0


def test_triangles_without_an_area_are_counted():
    vertices = [*CABINET.vertices_m, (2, 1.1, 0.9), (2, 1.1, 0.9)]
    faces = [*CABINET.faces.tolist(), [0, 1, 1], [0, 8, 9]]
    audit = audit_mesh([replace(CABINET, vertices_m=vertices, faces=faces)])
    assert audit.degenerate_faces == 2
    assert kinds(audit) == ["degenerate_faces"]


def test_unreferenced_vertices_are_counted_and_do_not_widen_the_bounds():
    audit = audit_mesh([replace(CABINET, vertices_m=[*CABINET.vertices_m, (99, 99, 99)])])
    assert audit.unreferenced_vertices == 1
    assert kinds(audit) == ["unreferenced_vertices"]
    np.testing.assert_allclose(audit.bounds_m, CABINET.bounds_m)


def test_one_turned_triangle_conflicts_with_its_three_neighbours():
    faces = CABINET.faces.copy()
    faces[4] = faces[4, ::-1]
    audit = audit_mesh([with_faces(CABINET, faces)])
    assert audit.winding_conflicts == 3
    assert kinds(audit) == ["winding_conflicts"]


def test_bodies_may_wind_as_they_like():
    walls, floor, ceiling = ROOM
    assert audit_mesh((walls, with_faces(floor, floor.faces[:, ::-1]), ceiling)).findings == ()


def test_a_solid_inside_out_is_found_in_a_room_but_not_on_its_own():
    inside_out = with_faces(CABINET, CABINET.faces[:, ::-1])
    assert kinds(audit_mesh((*ROOM, inside_out))) == ["inside_out_components"]
    alone = audit_mesh([inside_out])
    assert alone.findings == ()
    assert alone.inward_components == 1


def test_t_junctions_between_unequal_grids_are_no_opening():
    """Two panels of 4 m, cut into 4 and 6 pieces: the 3 + 5 inner vertices, two of them common."""
    left = grid(3, 4, 2.0, 4.0)
    right = place(replace(grid(2, 6, 2.0, 4.0), name="right"), position_m=(2, 0, 0))
    audit = audit_mesh([left, right])
    # Cuts at 1, 2, 3 m against 2/3, 4/3, 2, 8/3, 10/3 m: 2 m is common, 2 + 4 are not.
    assert audit.t_junctions == 6
    assert audit.components == 1
    assert audit.free_edge_length_m == pytest.approx(2 * (4 + 4))


def test_a_box_closed_over_t_junctions_is_watertight():
    lid = place(replace(grid(7, 5, 1.5, 0.35), name="lid"), position_m=(1, 1, 1.5))
    high = CABINET.vertices_m[CABINET.faces][:, :, 2].min(axis=1) == 1.5
    pot = with_faces(CABINET, CABINET.faces[~high])
    audit = audit_mesh([pot, lid])
    assert kinds(audit) == ["t_junctions"]
    assert audit.t_junctions == 2 * (6 + 4)
    assert (audit.free_edges, audit.closed_components) == (0, 1)


def test_three_sheets_at_one_edge_are_reported():
    fin = Body(
        name="fin",
        vertices_m=[(0, 0, 0), (0, 4, 0), (0, 4, 3), (0, 0, 3), (-1, 0, 0), (-1, 0, 3)],
        faces=[(0, 4, 5), (0, 5, 3)],  # stands on the edge x = y = 0 of the room
        material="wood",
    )
    audit = audit_mesh((*ROOM, fin))
    assert audit.non_manifold_edges == 1
    assert audit.unreferenced_vertices == 2
    assert "non_manifold_edges" in kinds(audit)


def test_the_readers_body_has_its_junctions_and_no_other_fault():
    audit = audit_mesh([reader_body().body])
    assert audit.non_manifold_edges == 9  # 8 feet and the axis
    assert kinds(audit) == ["free_edges", "non_manifold_edges"]
    assert audit.t_junctions == 0


def test_a_concave_polygon_cut_into_a_fan_is_found():
    """The L with corners (0,0) (4,0) (4,1) (1,1) (1,3) (0,3), fanned at (4,0), covers too much."""
    corners = [(0, 0, 0), (4, 0, 0), (4, 1, 0), (1, 1, 0), (1, 3, 0), (0, 3, 0)]
    ring = [1, 2, 3, 4, 5, 0]
    fan = [(ring[0], ring[k], ring[k + 1]) for k in range(1, 5)]
    audit = audit_mesh([Body(name="floor", vertices_m=corners, faces=fan, material="wood")])
    assert audit.folded_edges > 0
    assert "folded_edges" in kinds(audit)


@pytest.mark.parametrize(
    ("size", "expected"),
    [
        ((5000, 4000, 3000), ["size"]),
        ((0.005, 0.004, 0.003), ["size"]),
        ((5, 4, 3), []),
        ((4, 3, 5), ["up"]),
    ],
)
def test_unlikely_sizes_and_rooms_on_their_side_are_questioned(size, expected):
    assert kinds(audit_mesh(box_room(size))) == expected


def test_a_file_is_audited_in_its_unit_and_the_report_says_so(tmp_path):
    file = tmp_path / "room.stl"
    save_bodies([*box_room((5000, 4000, 3000)), box((9, 9, 9), material="m")], file)
    audit = audit_mesh(file, unit="mm")
    np.testing.assert_allclose(audit.bounds_m, [(0, 0, 0), (5, 4, 3)])
    text = "\n".join(audit.lines())
    assert str(file) in text
    assert "24 triangles" in text
    assert "5 x 4 m, 3 m high" in text
    assert "nothing else to report" in text


def test_every_finding_says_what_it_means():
    broken = with_faces(CABINET, [*CABINET.faces[1:], CABINET.faces[2]])
    audit = audit_mesh([broken])
    lines = audit.lines()
    for finding in audit.findings:
        assert any(finding.what in line for line in lines)
        assert any(finding.meaning in line for line in lines)
    assert "3 pieces of free border" in "\n".join(lines)
    assert "1 triangle given more than once" in "\n".join(lines)


def test_an_audit_needs_something_to_look_at(tmp_path):
    with pytest.raises(GeometryError, match="no body"):
        audit_mesh([])
    flat = Body(name="f", vertices_m=np.zeros((3, 3)), faces=[(0, 1, 2)], material="m")
    with pytest.raises(GeometryError, match="has an area"):
        audit_mesh([flat])
    with pytest.raises(GeometryError, match="does not exist"):
        audit_mesh(tmp_path / "missing.glb")
    with pytest.raises(GeometryError, match="tolerance_m"):
        audit_mesh(ROOM, tolerance_m=0.0)


def test_the_number_of_free_edges_of_a_holed_sheet_is_counted_edge_by_edge():
    """Against a slow count: every edge of every triangle, looked up by its rounded ends."""
    sheet = grid(12, 9, 3.0, 2.0)
    kept = np.random.default_rng(7).random(len(sheet.faces)) < 0.7
    body = with_faces(sheet, sheet.faces[kept])
    sides: dict[frozenset[tuple[float, ...]], int] = {}
    for corners in np.round(body.triangles_m, 9).tolist():
        for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
            key = frozenset((tuple(a), tuple(b)))
            sides[key] = sides.get(key, 0) + 1
    audit = audit_mesh([body])
    assert audit.free_edges == audit.open_edges == sum(n == 1 for n in sides.values())
    assert audit.t_junctions == 0


def test_a_cylinder_in_several_files_worth_of_bodies_counts_its_parts():
    posts = [
        cylinder(0.1, 2.0, material="wood", sides=12, position_m=(k, 0, 0), name=f"post {k}")
        for k in range(5)
    ]
    audit = audit_mesh(posts)
    assert (audit.components, audit.closed_components, audit.inward_components) == (5, 5, 0)
    assert audit.findings == ()
