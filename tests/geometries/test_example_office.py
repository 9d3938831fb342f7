"""The office in examples/ is what its script writes, and holds what the examples promise."""

import itertools
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

from octant.geometries.audit import audit_mesh
from octant.geometries.mesh_files import load_bodies

EXAMPLES = Path(__file__).parents[2] / "examples"
OFFICE = EXAMPLES / "l_shaped_office.glb"
SCRIPT = EXAMPLES / "make_l_shaped_office.py"


@pytest.fixture(scope="module")
def office():
    return {body.name: body for body in load_bodies(OFFICE, material="any")}


def covers(body, point):
    """Whether a point, seen from above, lies on a body's triangles."""
    for tri in body.triangles_m[:, :, :2]:
        nxt = np.roll(tri, -1, axis=0)
        side = (nxt[:, 0] - tri[:, 0]) * (point[1] - tri[:, 1]) - (nxt[:, 1] - tri[:, 1]) * (
            point[0] - tri[:, 0]
        )
        if (side >= -1e-9).all() or (side <= 1e-9).all():
            return True
    return False


def test_the_committed_file_is_what_the_script_writes(tmp_path, monkeypatch, capsys, office):
    fresh = tmp_path / "office.glb"
    monkeypatch.setattr(sys, "argv", [str(SCRIPT), str(fresh)])
    runpy.run_path(str(SCRIPT), run_name="__main__")
    assert "table (60)" in capsys.readouterr().out
    for body in load_bodies(fresh, material="any"):
        np.testing.assert_array_equal(body.triangles_m, office[body.name].triangles_m)
    assert len(load_bodies(fresh, material="any")) == len(office)
    assert OFFICE.stat().st_size < 200_000


def test_the_office_has_the_bodies_and_areas_of_its_plan(office):
    assert list(office) == [
        "floor",
        "ceiling",
        "outer_walls",
        "partition",
        "door_leaf",
        "cabinet",
        "table",
    ]
    plan = 7 * 6 - 1.5 * 2.5
    assert office["floor"].area_m2 == pytest.approx(plan, rel=1e-6)
    assert office["ceiling"].area_m2 == pytest.approx(plan - 0.6 * 0.6, rel=1e-6)
    assert office["outer_walls"].area_m2 == pytest.approx(2 * (7 + 6) * 3 - 0.9 * 2.1, rel=1e-6)
    assert office["partition"].area_m2 == pytest.approx(2.5 * 3 - 0.9 * 2.1, rel=1e-6)
    np.testing.assert_array_equal(office["outer_walls"].bounds_m, [(-1, -1, 0), (6, 5, 3)])


def test_there_is_floor_around_the_start_and_ceiling_above_the_tags(office):
    for angle in np.linspace(0.0, 2 * np.pi, 16, endpoint=False):
        assert covers(office["floor"], (0.6 * np.cos(angle), 0.6 * np.sin(angle)))
    for tag in ((2.0, 0.5), (3.5, 2.0), (2.0, 3.5), (4.0, 3.5)):
        assert covers(office["ceiling"], tag)
        assert not covers(office["cabinet"], tag)
    assert not covers(office["ceiling"], (-0.3, 0.9))  # the missing panel
    assert not covers(office["floor"], (0.0, 4.0))  # the notch of the L


def test_the_straight_way_from_tag_to_tag_is_clear_of_furniture(office):
    points = np.array([(0, 0), (2, 0.5), (3.5, 2), (2, 3.5), (4, 3.5)], dtype=float)
    way = np.concatenate(
        [a + np.linspace(0, 1, 101)[:, None] * (b - a) for a, b in itertools.pairwise(points)]
    )
    for name in ("cabinet", "table", "door_leaf", "partition"):
        low, high = office[name].bounds_m[:, :2]
        gap = np.linalg.norm(np.maximum(0.0, np.maximum(low - way, way - high)), axis=1)
        assert gap.min() > 0.5


def test_the_office_is_open_and_unevenly_meshed():
    audit = audit_mesh(OFFICE)
    assert {f.kind for f in audit.findings} == {"free_edges", "t_junctions"}
    assert audit.t_junctions > 100
    assert audit.free_edges > 0
    assert audit.edge_lengths_m[2] > 20 * audit.edge_lengths_m[0]
