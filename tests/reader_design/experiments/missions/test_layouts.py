"""The layouts of examples/layouts: each loads, its meshes are sound, its tags can be reached."""

import importlib.util
from collections import deque
from pathlib import Path

import numpy as np
import pytest

from octant.geometries.audit import audit_mesh
from octant.geometries.mesh_files import load_bodies
from octant.reader_design.experiments.missions.comparison import plan_comparison
from octant.reader_design.experiments.missions.comparison_table import load_comparison
from octant.reader_design.experiments.missions.compute import mission_space
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import load_study

FOLDER = Path(__file__).resolve().parents[4] / "examples" / "layouts"
COMPARISONS = sorted(FOLDER.glob("compare*.toml"))
STUDIES = sorted(set(FOLDER.glob("*.toml")) - set(COMPARISONS))
MESHES = sorted(FOLDER.glob("*.glb"))
SPACING_M = 0.1


def stem(path):
    return path.stem


def reached_from(start_m, space, low_m, high_m):
    """Places of a grid to which the robot can drive from its start."""
    count = np.ceil((high_m - low_m) / SPACING_M).astype(int) + 1
    grid = np.stack(np.meshgrid(*(np.arange(n) for n in count), indexing="ij"), axis=-1)
    places = low_m + SPACING_M * grid.reshape(-1, 2)
    free = space(places).reshape(count)
    first = tuple(np.round((np.array(start_m) - low_m) / SPACING_M).astype(int))
    seen, queue = {first}, deque([first])
    while queue:
        i, j = queue.popleft()
        for step in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            inside = 0 <= step[0] < count[0] and 0 <= step[1] < count[1]
            if inside and step not in seen and free[step]:
                seen.add(step)
                queue.append(step)
    return low_m + SPACING_M * np.array(sorted(seen))


def test_there_are_the_ten_layouts_and_the_room_in_which_the_robot_arrives():
    names = {load_study(path).name for path in STUDIES}
    assert len(STUDIES) == 11
    assert len(names) == 11


@pytest.mark.parametrize("path", STUDIES, ids=stem)
def test_the_robot_can_drive_to_every_tag_of_a_layout(path):
    study = load_study(path)
    setting = build_setting(study)
    table = setting.mission
    assert len(table.tags) >= 4
    space = mission_space(setting)
    points = np.array([setting.tag(tag_id).point_m for tag_id in table.tags])
    assert space(np.vstack([points, table.start_m])).all()
    low, high = setting.scene.bounds_m[:, :2]
    if study.room.free_space:
        low, high = np.array([-1.0, -1.0]), np.array([6.0, 6.0])
    places = reached_from(table.start_m, space, low, high)
    nearest = np.linalg.norm(places[:, None] - points, axis=2).min(axis=0)
    assert nearest.max() <= SPACING_M


@pytest.mark.parametrize("path", MESHES, ids=stem)
def test_the_meshes_have_no_fault_that_a_ray_would_notice(path):
    audit = audit_mesh(load_bodies(path))
    harmless = {"up", "free_edges"} if path.stem == "shelf" else {"up"}
    assert {finding.kind for finding in audit.findings} <= harmless


def test_the_meshes_are_what_the_script_makes(tmp_path, monkeypatch):
    file = FOLDER / "make_metal_objects.py"
    spec = importlib.util.spec_from_file_location("make_metal_objects", file)
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    monkeypatch.setattr("sys.argv", ["make_metal_objects.py", str(tmp_path)])
    script.main()
    assert [p.name for p in sorted(tmp_path.iterdir())] == [p.name for p in MESHES]
    for made, kept in zip(sorted(tmp_path.iterdir()), MESHES, strict=True):
        (a,), (b,) = load_bodies(made), load_bodies(kept)
        np.testing.assert_allclose(
            a.vertices_m[a.faces], b.vertices_m[b.faces], rtol=0.0, atol=1e-6
        )


@pytest.mark.parametrize("path", COMPARISONS, ids=stem)
def test_every_cell_of_the_comparisons_is_a_study(path):
    comparison = load_comparison(path)
    cells = plan_comparison(comparison)
    sizes = [
        len(entries)
        for entries in (
            comparison.layouts,
            comparison.links,
            comparison.readers,
            comparison.controllers,
            comparison.every_world(),
        )
    ]
    assert len(cells) == np.prod(sizes)
    for cell in cells:
        named = [kind for kind in ("conical patch", "patch") if kind in cell.link]
        antenna = named[0].replace(" ", "_") if named else "dipole"
        assert {tag.antenna for tag in cell.study.tags} == {antenna}
        assert {tag.axis for tag in cell.study.tags} == {(0.0, 0.0, -1.0 if named else 1.0)}
        assert len(cell.study.radio.frequencies_hz) == (16 if "16" in cell.link else 1)
