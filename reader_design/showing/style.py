"""The look that all figures share.

Nothing here touches pyplot or any other global state.
"""

import importlib.resources
import io
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from octant.geometries.files import whole_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

ANTENNA_COLOURS = (
    "#332288",
    "#88ccee",
    "#117733",
    "#ddaa33",
    "#cc6677",
    "#aa4499",
    "#44aa99",
    "#777777",
)
"""One colour for each antenna number, that colour-blind readers can tell apart; cycled beyond 8."""
COLOURS = 256
"""Colours of an image in a file [-]: as many as one byte a pixel can name."""
ANTENNA_DASHES = ("-", "--", "-.", ":")
"""Line styles by antenna: symmetric partners (2 and 8, 3 and 7, 4 and 6) differ in style."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NamedFigure:
    """A figure with its file name and what to see in it.

    Attributes
    ----------
    file : File name.
    section : ``sweep``, ``reader``, ``room`` or ``mission``.
    title : Its name.
    caption : One sentence, with the units that matter [m, dB, deg].
    figure : The figure.
    """

    file: str
    section: str
    title: str
    caption: str
    figure: "Figure"


@contextmanager
def figure_style() -> Iterator[None]:
    """Yield inside Octant's style sheet; the settings of the caller come back afterwards."""
    from matplotlib import rc_context, rcdefaults

    sheet = importlib.resources.files(__package__).joinpath("octant.mplstyle")
    with importlib.resources.as_file(sheet) as path, rc_context():
        rcdefaults()
        with rc_context(fname=str(path)):
            yield


def save_figure(figure: "Figure", path: Path) -> None:
    """Write a figure as PNG, whole or not at all, at 150 dots per inch.

    Parameters
    ----------
    figure : From one of the functions here.
    path : File ending in ``.png``.
    """
    content = figure_png(figure)
    with whole_file(path) as part:
        part.write_bytes(content)


def figure_png(figure: "Figure") -> bytes:
    """Return a figure as the content of a PNG file of 256 colours, at 150 dots per inch.

    Parameters
    ----------
    figure : From one of the functions here.
    """
    from matplotlib import rcParams
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    shown, shown_dpi = figure.canvas, figure.dpi
    with figure_style():
        try:
            canvas: Any = FigureCanvasAgg(figure)
            figure.dpi = dots = rcParams["savefig.dpi"]
            canvas.draw()  # `savefig` draws twice
        finally:
            figure.set_canvas(shown)
            figure.dpi = shown_dpi
    return _few_colours(np.asarray(canvas.buffer_rgba()), dots)


def _few_colours(rgba: npt.NDArray[np.uint8], dots_per_inch: float) -> bytes:
    """Return an opaque image as PNG with those 256 colours that come nearest to all of its own.

    A page embeds it as it stands: a third of the size in full colour, and as quick to write.
    """
    from PIL import Image

    few = Image.fromarray(rgba[..., :3]).quantize(
        COLOURS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE
    )
    content = io.BytesIO()
    few.save(content, "PNG", dpi=(dots_per_inch, dots_per_inch), compress_level=6)
    return content.getvalue()


def new_figure(
    *, width_in: float, height_in: float, title: str, rows: int = 1, columns: int = 1
) -> tuple["Figure", npt.NDArray[np.object_]]:
    """Return an empty figure and its (rows, columns) axes; sizes in inches [in].

    Parameters
    ----------
    width_in, height_in : Size [in].
    title : Line above all panels.
    rows, columns : Number of panels.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(
        math_text(title), x=0.012, ha="left", fontsize=12, fontweight="bold", color="#222222"
    )
    return figure, figure.subplots(rows, columns, squeeze=False)


def with_projection(axes: "Axes", projection: str) -> Any:  # noqa: ANN401  none for all kinds
    """Return new axes of another projection in the place of given ones, which are removed.

    Parameters
    ----------
    axes : Axes that `new_figure` made.
    projection : "polar" or "3d".
    """
    figure: Any = axes.get_figure()
    place = axes.get_subplotspec()
    axes.remove()
    return figure.add_subplot(place, projection=projection)


def math_text(label: str) -> str:
    """Return a label with r_a and h_p set as symbols, for Matplotlib.

    Parameters
    ----------
    label : E.g. a design's label.
    """
    return label.replace("r_a", "$r_a$").replace("h_p", "$h_p$")


def draw_antennas(axes: "Axes", x: npt.ArrayLike, rss_dbm: FloatArray) -> None:
    """Draw one line for each antenna, RSS [dBm] over any abscissa.

    Parameters
    ----------
    axes : Where to draw.
    x : (k,) array_like — Abscissa, in the unit of the axis [m, deg or s].
    rss_dbm : (k, n) float64 — RSS [dBm]; minus infinity leaves a gap.
    """
    level = np.where(np.isfinite(rss_dbm), rss_dbm, np.nan)
    for i in range(level.shape[1]):
        axes.plot(
            np.asarray(x),
            level[:, i],
            color=ANTENNA_COLOURS[i % len(ANTENNA_COLOURS)],
            linestyle=ANTENNA_DASHES[(i * 4 // level.shape[1]) % len(ANTENNA_DASHES)],
            label=f"antenna {i + 1}",
            linewidth=1.3,
        )


def antenna_legend(figure: "Figure", axes: "Axes", *, title: str | None = None) -> None:
    """Put one legend of the antennas at the figure's right side.

    Parameters
    ----------
    figure, axes : The figure, and the panel that holds the lines.
    title : Above the legend.
    """
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right center", title=title, handlelength=2.6)
