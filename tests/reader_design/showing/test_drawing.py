"""Figures are the same files whoever draws them."""

import io
import pickle
from functools import partial

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from octant.reader_design.keeping.workers import GivenExecutor
from octant.reader_design.showing.drawing import drawn_figures
from octant.reader_design.showing.style import NamedFigure, figure_png, figure_style, new_figure


def two_figures(section):
    for number in range(2):
        with figure_style():
            figure, axes = new_figure(width_in=3.0, height_in=2.0, title=f"{section} {number}")
            axes[0, 0].plot([0.0, 1.0 + number])
        yield NamedFigure(
            file=f"{section}{number}.png",
            section=section,
            title="a line",
            caption="A line.",
            figure=figure,
        )


class Elsewhere(GivenExecutor):
    """Runs calls at once, what goes in and out pickled as between processes."""

    def __init__(self):
        super().__init__(None)

    def submit(self, call, /, *arguments):
        from concurrent.futures import Future

        call, arguments = pickle.loads(pickle.dumps((call, arguments)))  # noqa: S301
        future = Future()
        future.set_result(pickle.loads(pickle.dumps(call(*arguments))))  # noqa: S301
        return future


def test_workers_draw_the_figures_that_one_process_draws_in_the_same_order():
    groups = [partial(two_figures, "sweep"), partial(two_figures, "room")]
    here = list(drawn_figures(groups, None))
    assert [one.file for one in here] == ["sweep0.png", "sweep1.png", "room0.png", "room1.png"]
    assert list(drawn_figures(groups, Elsewhere())) == here
    assert all(one.png.startswith(b"\x89PNG") for one in here)


def test_a_figure_of_any_canvas_becomes_a_file_and_stays_as_it_was():
    figure = Figure(dpi=72)
    figure.add_subplot().plot([1, 2])
    canvas = figure.canvas
    assert figure_png(figure) == figure_png(figure)
    assert figure.canvas is canvas
    assert figure.dpi == 72


def test_the_colours_of_a_file_are_those_that_were_drawn_and_white_stays_white():
    with figure_style():
        figure, axes = new_figure(width_in=4.0, height_in=3.0, title="a ramp and a point")
        axes[0, 0].pcolormesh(np.linspace(0.0, 1.0, 10_000).reshape(100, 100), cmap="viridis")
        axes[0, 0].plot([50.0], [50.0], "x", color="#cc3311")
    canvas = FigureCanvasAgg(figure)
    figure.dpi = 150.0
    canvas.draw()
    drawn = np.asarray(canvas.buffer_rgba())[..., :3].astype(float)
    with Image.open(io.BytesIO(figure_png(figure))) as image:
        assert image.mode == "P"
        assert image.info["dpi"] == pytest.approx((150.0, 150.0), abs=0.1)
        kept = np.asarray(image.convert("RGB")).astype(float)
    assert np.abs(kept - drawn).max() < 24.0
    assert np.sqrt(((kept - drawn) ** 2).mean()) < 3.0
    assert (kept[drawn.min(axis=-1) == 255.0] == 255.0).all()
