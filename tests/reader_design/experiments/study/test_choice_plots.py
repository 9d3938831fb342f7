"""Laws of the figures of a choice: every design drawn, every axis named, fronts where they are."""

import msgspec
import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.reader_design.experiments.study.choice_plots import (
    ParallelAxis,
    ParetoScore,
    parallel_figure,
    pareto_figure,
)
from octant.reader_design.experiments.study.reader_plots import (
    ErrorCurve,
    element_pattern_figure,
    error_distribution_figure,
)
from octant.reader_design.experiments.study.sweep_figures import parameter_axes
from octant.reader_design.showing.style import save_figure
from octant.reader_design.study_file.reader import Reader

DESIGN = Reader(
    antenna="dipole",
    antenna_radius_m=0.10,
    plate_height_m=0.08,
    ground_plane_m=0.2,
    ground_plane_shape="square",
    antennas=8,
    gap_m=0.005,
    monopole_plane_m=0.04,
    height_m=0.3,
    load_ohm=50.0,
)


def changed(**values):
    return msgspec.structs.replace(DESIGN, **values)


def test_axes_are_the_parameters_in_which_designs_differ_in_centimetres():
    designs = [
        changed(gap_m=0.005, ground_plane_shape="square", plate_outer_radius_m=None),
        changed(gap_m=0.02, ground_plane_shape="round", plate_outer_radius_m=0.09),
    ]
    axes = {axis.title: axis.values for axis in parameter_axes(designs)}
    assert axes == {
        "gap [cm]": (0.5, 2.0),
        "ground plane shape": ("square", "round"),
        "plate outer radius m": ("default", "0.09"),
    }
    assert parameter_axes([DESIGN, DESIGN]) == []


def test_places_on_an_axis_run_from_the_least_to_the_greatest_value():
    heights, ticks = ParallelAxis(title="h_p [cm]", values=(8.0, 0.0, 15.0)).places()
    np.testing.assert_allclose(heights, [8 / 15, 0.0, 1.0])
    assert [t for _, t in ticks] == ["0", "8", "15"]
    heights, ticks = ParallelAxis(title="antenna", values=("b", "a", "b")).places()
    assert heights.tolist() == [0.0, 1.0, 0.0]
    assert ticks == [(0.0, "b"), (1.0, "a")]
    heights, ticks = ParallelAxis(title="x", values=(2.0, 2.0)).places()
    assert heights.tolist() == [0.5, 0.5]
    _, ticks = ParallelAxis(title="x", values=tuple(np.linspace(0, 1, 50))).places()
    assert len(ticks) == 5


@pytest.mark.parametrize("count", [2, 1000])
def test_parallel_coordinates_draw_two_designs_and_a_thousand(count, tmp_path):
    rng = np.random.default_rng(1)
    rank = rng.permutation(count) + 1
    axes = [
        ParallelAxis(title=f"p{k} [cm]", values=tuple(rng.uniform(size=count))) for k in range(5)
    ]
    figure = parallel_figure(axes, rank, title="sweep")
    ax = figure.axes[0]
    assert len(ax.collections[0].get_paths()) == count - 1
    chosen = ax.get_lines()[0].get_ydata()
    best = int(np.argmin(rank))
    np.testing.assert_allclose(chosen, [a.places()[0][best] for a in axes])
    assert [t.get_text() for t in ax.get_xticklabels()] == [a.title for a in axes]
    save_figure(figure, tmp_path / "p.png")


def test_pareto_panels_join_the_front_of_their_own_two_scores():
    x = ParetoScore(title="error [°]", values=np.array([1.0, 2.0, 3.0, 2.5]), maximise=False)
    y = ParetoScore(
        title="level [dBm]", values=np.array([-50.0, -40.0, -30.0, -45.0]), maximise=True
    )
    front = np.array([True, True, True, False])
    figure = pareto_figure([(x, y)], front, np.array([2, 1, 3, 4]), title="front")
    ax = figure.axes[0]
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("error [°]", "level [dBm]")
    assert ax.get_lines()[0].get_xdata().tolist() == [1.0, 2.0, 3.0]
    assert ax.get_lines()[1].get_xdata().tolist() == [2.5]  # dominated
    assert ax.get_lines()[3].get_xdata().tolist() == [2.0]  # chosen: first of the ranking
    assert "left and up" in ax.get_title(loc="left")


def test_distribution_crosses_half_at_the_median():
    errors = np.radians([10.0, -20.0, 30.0, 120.0])
    figure = error_distribution_figure(
        [("room", [ErrorCurve(label="a", error_rad=errors)])], title="errors"
    )
    ax = figure.axes[0]
    x, y = ax.get_lines()[0].get_data()
    np.testing.assert_allclose(x, [0.0, 10.0, 20.0, 30.0, 120.0])
    np.testing.assert_allclose(y, [0.0, 25.0, 50.0, 75.0, 100.0])
    assert "[°]" in ax.get_xlabel()
    assert "[%]" in ax.get_ylabel()


def test_pattern_of_a_half_wave_dipole_peaks_at_the_horizon_with_2_15_dbi():
    figure = element_pattern_figure(make_antenna("dipole", 2.4e9), title="dipole")
    line = figure.axes[0].get_lines()[0]
    theta, gain = line.get_data()
    assert theta[np.argmax(gain)] == pytest.approx(90.0)
    assert 10 * np.log10(gain.max()) == pytest.approx(2.15, abs=0.01)
    assert gain[0] < 1e-9
    assert "2.15 dBi" in figure.axes[0].get_legend().get_texts()[0].get_text()
