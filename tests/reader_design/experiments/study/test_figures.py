"""Laws of the figures: what is drawn where, with names and units, without touching global state."""

import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest

from octant.geometries.furniture import box
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene
from octant.reader_design.experiments.missions.drive_figures import (
    Drive,
    percentile_figure,
    rss_time_figure,
    trajectory_figure,
)
from octant.reader_design.experiments.study.reader_plots import (
    bearing_error_figure,
    rss_azimuth_figure,
)
from octant.reader_design.experiments.study.sweep_plots import (
    DistancePanel,
    MatrixColumn,
    rss_distance_figure,
    sweep_matrix_figure,
)
from octant.reader_design.showing.plan import MapPanel, map_figure, plan_of
from octant.reader_design.showing.style import save_figure

ELEMENTS = np.arange(8) * np.pi / 4
AZIMUTHS = np.arange(48) * np.pi / 24
RSS = 1e-6 * (1.0 + 0.8 * np.cos(AZIMUTHS[:, None] - ELEMENTS))
STEPS = 30
DRIVE = Drive(
    time_s=np.arange(STEPS) * 1.0,
    path_m=np.column_stack([np.linspace(0, 2, STEPS), np.linspace(0, 1, STEPS)]),
    heading_rad=np.zeros(STEPS),
    rss_w=np.tile(RSS[0], (STEPS, 1)),
    target=np.repeat([0, 1], STEPS // 2),
    position_error_m=np.linspace(0.0, 0.2, STEPS),
    heading_error_rad=np.linspace(0.0, 0.1, STEPS),
)
TAGS = {"A": np.array([1.0, 0.5]), "B": np.array([2.0, 1.0])}


def box_scene():
    cabinet = box((1.0, 0.5, 1.0), position_m=(0.0, 1.0, 0.0), material="metal")
    return build_scene(box_room((4.0, 3.0, 2.5)), objects=(cabinet,))


def all_figures():
    plan = plan_of(box_scene(), 0.3)
    x, y = np.linspace(0, 4, 9), np.linspace(0, 3, 7)
    columns = [
        MatrixColumn(title="margin [dB]", values=np.arange(3.0), text="{:+.1f}", better="high")
    ]
    return {
        "distance": rss_distance_figure(
            np.linspace(0, 5, 48),
            [DistancePanel(title=f"h_p = {k} cm", rss_w=RSS) for k in range(5)],
            columns=3,
            title="distance",
        ),
        "azimuth": rss_azimuth_figure(AZIMUTHS, RSS, ELEMENTS, distance_m=2.0, title="azimuth"),
        "bearing": bearing_error_figure(
            [("free space", AZIMUTHS, RSS[None]), ("room", AZIMUTHS, RSS[None])],
            ELEMENTS,
            title="bearing",
        ),
        "matrix": sweep_matrix_figure(["a", "b", "c"], columns, title="matrix"),
        "map": map_figure(
            x,
            y,
            [MapPanel(title="tag A", values=np.zeros((7, 9)), tags={"A": TAGS["A"]})],
            plan,
            title="map",
            bar_label="RSS [dBm]",
        ),
        "trajectory": trajectory_figure([("room", DRIVE, plan)], TAGS, title="trajectory"),
        "percentile": percentile_figure([("room", DRIVE)], title="percentile"),
        "time": rss_time_figure(DRIVE, ["A", "B"], title="time"),
    }


def test_every_figure_has_a_title_and_every_labelled_axis_a_unit():
    for name, figure in all_figures().items():
        assert name in figure.get_suptitle()
        labels = [
            text
            for ax in figure.axes
            if ax.get_visible()
            for text in (ax.get_xlabel(), ax.get_ylabel())
            if text
        ]
        assert all("[" in text and "]" in text for text in labels), (name, labels)
        assert labels or name == "matrix"


def test_figures_leave_the_global_settings_alone():
    before = dict(mpl.rcParams)
    all_figures()
    assert dict(mpl.rcParams) == before


def test_pyplot_is_never_imported():
    code = (
        "import sys, numpy as np\n"
        "from octant.reader_design.experiments.study.reader_plots import rss_azimuth_figure\n"
        "from pathlib import Path\n"
        "a = np.arange(8.0); f = rss_azimuth_figure(a, np.ones((8, 3)), a[:3], "
        "distance_m=1.0, title='t')\n"
        "print('matplotlib.pyplot' in sys.modules)"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "False"


def test_saved_figure_is_a_png_of_150_dots_per_inch(tmp_path):
    figure = all_figures()["time"]
    save_figure(figure, tmp_path / "deep" / "time.png")
    data = (tmp_path / "deep" / "time.png").read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    width = int.from_bytes(data[16:20], "big")
    assert width == round(150 * figure.get_figwidth())
    assert [p.name for p in (tmp_path / "deep").iterdir()] == ["time.png"]


def test_each_antenna_is_one_line_in_its_own_colour():
    ax = rss_distance_figure(
        np.linspace(0, 5, 48), [DistancePanel(title="", rss_w=RSS)], columns=1, title="t"
    ).axes[0]
    assert [line.get_label() for line in ax.lines] == [f"antenna {i}" for i in range(1, 9)]
    assert len({line.get_color() for line in ax.lines}) == 8
    np.testing.assert_allclose(ax.lines[2].get_ydata(), 10 * np.log10(RSS[:, 2]) + 30)


def test_silence_leaves_a_gap_not_a_wrong_point():
    rss = RSS.copy()
    rss[5] = 0.0
    ax = rss_time_figure(
        Drive(
            time_s=np.arange(48.0),
            path_m=np.zeros((48, 2)),
            heading_rad=np.zeros(48),
            rss_w=rss,
            target=np.zeros(48, dtype=np.int64),
            position_error_m=np.zeros(48),
            heading_error_rad=np.zeros(48),
        ),
        ["A"],
        title="t",
    ).axes[0]
    assert np.isnan(ax.lines[0].get_ydata()[5])
    assert np.isfinite(ax.get_ylim()).all()


def test_unused_panels_are_hidden():
    figure = all_figures()["distance"]
    assert [ax.get_visible() for ax in figure.axes] == [True] * 5 + [False]


def test_bearing_error_of_a_perfect_reader_is_the_sector_saw_tooth():
    ax = bearing_error_figure([("free", AZIMUTHS, RSS[None])], ELEMENTS, title="t").axes[0]
    strongest, vector = (line.get_ydata() for line in ax.lines[:2])
    expected = np.abs((np.degrees([*AZIMUTHS, 0.0]) + 22.5) % 45.0 - 22.5)
    np.testing.assert_allclose(strongest, expected, atol=1e-9)
    np.testing.assert_allclose(vector, 0.0, atol=1e-9)


def test_matrix_marks_the_first_row_and_shades_good_values_dark():
    columns = [
        MatrixColumn(
            title="share [%]", values=np.array([90.0, 50.0]), text="{:.0f}", better="high"
        ),
        MatrixColumn(title="error [°]", values=np.array([9.0, 3.0]), text="{:.0f}", better="low"),
        MatrixColumn(title="same [-]", values=np.array([1.0, 1.0]), text="{:.0f}", better="low"),
    ]
    ax = sweep_matrix_figure(["first", "second"], columns, title="t").axes[0]
    np.testing.assert_allclose(ax.images[0].get_array(), [[1.0, 0.0, 0.5], [0.0, 1.0, 0.5]])
    assert [t.get_text() for t in ax.texts] == ["90", "50", "9", "3", "1", "1"]
    assert ax.get_yticklabels()[0].get_fontweight() == "bold"


def test_zero_has_no_sign_in_the_matrix():
    columns = [
        MatrixColumn(title="m [dB]", values=np.array([-0.01, 0.01]), text="{:+.1f}", better="high")
    ]
    ax = sweep_matrix_figure(["a", "b"], columns, title="t").axes[0]
    assert [t.get_text() for t in ax.texts] == ["0.0", "0.0"]


def test_trajectory_shows_desired_segments_path_and_tags():
    ax = trajectory_figure([("room", DRIVE, plan_of(box_scene(), 0.3))], TAGS, title="t").axes[0]
    desired, path = ax.lines[:2]
    np.testing.assert_allclose(desired.get_xydata(), [[0, 0], [1, 0.5], [2, 1]])
    np.testing.assert_allclose(path.get_xydata(), DRIVE.path_m)
    assert {"A", "B"} <= {t.get_text() for t in ax.texts}
    assert ax.get_aspect() == 1.0


def test_percentiles_grow_and_end_at_the_largest_error():
    left, right = percentile_figure([("room", DRIVE)], title="t").axes
    assert left.lines[0].get_ydata()[-1] == pytest.approx(20.0)
    assert right.lines[0].get_ydata()[-1] == pytest.approx(np.degrees(0.1))
    assert (np.diff(left.lines[0].get_ydata()) >= 0.0).all()


def test_change_of_the_target_is_marked_in_the_rss_over_time():
    ax = rss_time_figure(DRIVE, ["A", "B"], title="t").axes[0]
    assert [t.get_text() for t in ax.texts] == ["to A", "to B"]
    assert ax.lines[-1].get_xdata()[0] == DRIVE.time_s[STEPS // 2]
