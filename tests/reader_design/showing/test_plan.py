"""Laws of the plan of a room: what is drawn where; and of the look."""

import matplotlib as mpl
import numpy as np
import pytest

from octant.geometries.furniture import box
from octant.geometries.rooms import Doorway, box_room, prism_room
from octant.geometries.scene import build_scene, free_space_scene
from octant.reader_design.showing.plan import MapPanel, cut_triangles, map_figure, plan_of
from octant.reader_design.showing.style import figure_style, math_text


def box_scene():
    cabinet = box((1.0, 0.5, 1.0), position_m=(0.0, 1.0, 0.0), material="metal")
    return build_scene(box_room((4.0, 3.0, 2.5)), objects=(cabinet,))


def lengths(segments):
    return np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)


def test_style_is_in_force_only_inside():
    with figure_style():
        assert mpl.rcParams["axes.spines.top"] is False
    assert mpl.rcParams["axes.spines.top"] is mpl.rcParamsDefault["axes.spines.top"]


def test_map_shows_each_value_at_its_own_place():
    x, y = np.array([0.0, 1.0, 2.0]), np.array([10.0, 20.0])
    values = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    figure = map_figure(
        x,
        y,
        [MapPanel(title="", values=values, tags={})],
        plan_of(free_space_scene(), 0.3),
        title="t",
        bar_label="RSS [dBm]",
    )
    mesh = figure.axes[0].collections[0]
    np.testing.assert_array_equal(np.asarray(mesh.get_array()).reshape(2, 3), values)
    assert figure.axes[0].get_xlim()[0] <= 0.0 <= 2.0 <= figure.axes[0].get_xlim()[1]


def test_box_room_is_cut_along_its_outline():
    cut = plan_of(build_scene(box_room((4.0, 3.0, 2.5), origin_m=(-1.0, 0.0, 0.0))), 0.3).cuts_m
    assert lengths(cut).sum() == pytest.approx(2 * (4.0 + 3.0))
    assert cut[..., 0].min() == pytest.approx(-1.0)


def test_doorway_is_a_gap_in_the_plan():
    corners = ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0))
    door = Doorway(wall=0, offset_m=1.0, width_m=0.9, height_m=2.0)
    closed, opened = (
        build_scene(prism_room(corners, 2.5, doorways=doors)) for doors in ((), (door,))
    )
    for height, gap in ((0.3, 0.9), (2.2, 0.0)):
        missing = (
            lengths(plan_of(closed, height).cuts_m).sum()
            - lengths(plan_of(opened, height).cuts_m).sum()
        )
        assert missing == pytest.approx(gap)


def test_objects_show_their_footprint_even_above_their_top():
    plan = plan_of(box_scene(), 2.0)
    a, b, c = (plan.solids_m[:, k] for k in range(3))
    ab, ac = b - a, c - a
    area = 0.5 * np.abs(ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]).sum()
    assert area == pytest.approx(2 * 1.0 * 0.5)  # top and bottom
    assert lengths(plan.cuts_m).sum() == pytest.approx(14.0)
    assert lengths(plan_of(box_scene(), 0.5).cuts_m).sum() == pytest.approx(14.0 + 3.0)


def test_plane_through_a_corner_cuts_no_triangle_twice():
    triangle = np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]])
    assert len(cut_triangles(triangle, 0.0)) == 0
    assert len(cut_triangles(triangle, 1.0)) == 1
    np.testing.assert_allclose(lengths(cut_triangles(triangle, 0.5)), 0.5)


def test_symbols_are_set_as_mathematics():
    assert math_text("r_a = 5 cm h_p = 8 cm") == "$r_a$ = 5 cm $h_p$ = 8 cm"
