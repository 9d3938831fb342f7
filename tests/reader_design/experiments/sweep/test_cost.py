"""What a sweep announces before it starts is what its solutions take, metal beside included."""

from pathlib import Path

import pytest

from octant.em.reader.fullwave.basis import best_sectors, surface_basis
from octant.em.reader.fullwave.mesh import reader_mesh
from octant.reader_design.experiments.sweep.cost import cell_cost
from octant.reader_design.experiments.sweep.plan import plan_sweep
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import parse_study

STUDY = """
name = "cost"
[room]
free_space = true
[[tag]]
id = "a"
position_m = [0.0, 0.0, 3.0]
antenna = "dipole"
[reader]
cells_per_wavelength = 7
"""
ROBOT = """
[[reader.object]]
kind = "box"
size_m = [0.2, 0.2, 0.1]
position_m = [{x}, -0.1, -0.15]
material = "metal"
"""


@pytest.mark.parametrize(
    "text",
    [
        "",
        'antenna = "monopole"\nplate_height_m = 0.15\n',
        'ground_plane_shape = "octagon"\n' + ROBOT.format(x=-0.1),
        'ground_plane_shape = "octagon"\n' + ROBOT.format(x=-0.12),
        ROBOT.format(x=-0.1) + ROBOT.format(x=-0.5),
    ],
    ids=["dipole", "monopole", "robot in the middle", "robot off it", "two"],
)
def test_a_cell_is_announced_with_the_unknowns_and_sectors_of_its_mesh(text):
    study = parse_study(STUDY + text, source="test", directory=Path.cwd())
    (cell,) = plan_sweep(build_setting(study)).cells
    design, cost = cell.design, cell_cost(cell)
    mesh = reader_mesh(
        design.body(),
        frequency_hz=2.4e9,
        antenna=design.antenna,
        gap_m=design.gap_m,
        cells_per_wavelength=7.0,
        surroundings=design.surroundings,
    )
    count = surface_basis(mesh.vertices_m, mesh.faces).unknowns
    sectors = best_sectors(mesh.vertices_m, mesh.faces, (8, 4, 2))
    assert 0.75 * count < cost.unknowns < 1.33 * count
    matrix_bytes = 16.0 * cost.unknowns**2 / sectors
    assert matrix_bytes < cost.memory_bytes - 4e8 < 3.0 * matrix_bytes + 1e8
