"""Figures of one reader, and the look that all figures share.

Every function takes arrays and returns a Matplotlib figure; none touches pyplot or any other
global state. `room` has the maps and missions.
"""

import importlib.resources
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.geometries.files import whole_file
from octant.navigation.angles import wrap_angle
from octant.reader_design.setting.measures import (
    leaders,
    vector_sum_bearing_rad,
)

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
"""One colour for each antenna number, told apart also with colour-blind eyes; cycled beyond 8."""
ANTENNA_DASHES = ("-", "--", "-.", ":")
"""Line styles by antenna: symmetric partners (2 and 8, 3 and 7, 4 and 6) differ in style."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NamedFigure:
    """A figure with its file name and what to see in it.

    Attributes
    ----------
    file : str
        File name.
    section : str
        ``sweep``, ``reader``, ``room`` or ``mission``.
    title : str
        Its name.
    caption : str
        One sentence, with the units that matter [m, dB, deg].
    figure : Figure
        The figure.
    """

    file: str
    section: str
    title: str
    caption: str
    figure: "Figure"


@contextmanager
def figure_style() -> Iterator[None]:
    """Yield inside Octant's style sheet; the settings of the caller come back afterwards.

    Yields
    ------
    None
        While it is open, figures are made in the style of ``octant.mplstyle``.
    """
    from matplotlib import rc_context, rcdefaults

    sheet = importlib.resources.files(__package__).joinpath("octant.mplstyle")
    with importlib.resources.as_file(sheet) as path, rc_context():
        rcdefaults()
        with rc_context(fname=str(path)):
            yield


def save_figure(figure: "Figure", path: Path) -> None:
    """Return nothing; write a figure as PNG, whole or not at all, at 150 dots per inch.

    Parameters
    ----------
    figure : Figure
        From one of the functions here.
    path : Path
        File ending in ``.png``.
    """
    with figure_style(), whole_file(path) as part:
        figure.savefig(part, format="png", metadata={"Software": None})


def new_figure(
    *, width_in: float, height_in: float, title: str, rows: int = 1, columns: int = 1
) -> tuple["Figure", npt.NDArray[np.object_]]:
    """Return an empty figure and its (rows, columns) axes; sizes in inches [in].

    Parameters
    ----------
    width_in, height_in : float
        Size [in].
    title : str
        Line above all panels.
    rows, columns : int
        Number of panels.

    Returns
    -------
    Figure
        Drawn by Agg when it is saved.
    (rows, columns) ndarray of Axes
        Its panels.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_in, height_in), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(
        math_text(title), x=0.012, ha="left", fontsize=12, fontweight="bold", color="#222222"
    )
    return figure, figure.subplots(rows, columns, squeeze=False)


def math_text(label: str) -> str:
    """Return a label with r_a and h_p set as symbols, for Matplotlib.

    Parameters
    ----------
    label : str
        E.g. a design's label.

    Returns
    -------
    str
        With mathematical markup.
    """
    return label.replace("r_a", "$r_a$").replace("h_p", "$h_p$")


def draw_antennas(axes: "Axes", x: npt.ArrayLike, rss_dbm: FloatArray) -> None:
    """Return nothing; draw one line for each antenna, RSS [dBm] over any abscissa.

    Parameters
    ----------
    axes : Axes
        Where to draw.
    x : (k,) array_like
        Abscissa, in the unit of the axis [m, deg or s].
    rss_dbm : (k, n) float64
        RSS [dBm]; minus infinity leaves a gap.
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
    """Return nothing; put one legend of the antennas at the figure's right side.

    Parameters
    ----------
    figure : Figure
        The figure.
    axes : Axes
        Panel that holds the lines.
    title : str, optional
        Above the legend.
    """
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right center", title=title, handlelength=2.6)


def rss_azimuth_figure(
    azimuths_rad: FloatArray,
    rss_w: FloatArray,
    element_azimuths_rad: FloatArray,
    *,
    distance_m: float,
    title: str,
) -> "Figure":
    """Return RSS of all antennas against the tag's azimuth, polar [dB] and Cartesian [dBm].

    Parameters
    ----------
    azimuths_rad : (a,) float64
        Azimuth of the tag in the reader frame [rad], ascending over the circle.
    rss_w : (a, n) float64
        RSS [W].
    element_azimuths_rad : (n,) float64
        Azimuths of the antennas [rad], marked in both panels.
    distance_m : float
        Horizontal distance of the tag [m], for the caption.
    title : str
        Above the figure.

    Returns
    -------
    Figure
        Two panels.
    """
    order = np.argsort(azimuths_rad)
    azimuth = np.append(azimuths_rad[order], azimuths_rad[order][0] + 2.0 * np.pi)
    level = power_dbm(np.maximum(np.vstack([rss_w[order], rss_w[order][:1]]), 1e-30))
    peak = float(level.max())
    with figure_style():
        figure, axes = new_figure(width_in=9.6, height_in=4.2, title=title, rows=1, columns=2)
        axes[0, 0].remove()
        polar: Any = figure.add_subplot(1, 2, 1, projection="polar")
        span = 30.0
        draw_antennas(polar, azimuth, np.maximum(level - peak, -span))
        polar.set_ylim(-span, 2.0)
        polar.set_yticks([-30, -20, -10, 0])
        polar.set_rlabel_position(np.degrees(element_azimuths_rad[0]) + 11.0)
        polar.set_xticks(np.sort(element_azimuths_rad % (2.0 * np.pi)))
        polar.set_title(f"relative to the maximum [dB], {distance_m:g} m away", pad=14, x=-0.1)
        ax = axes[0, 1]
        draw_antennas(ax, np.degrees(azimuth), level)
        for element in element_azimuths_rad:
            ax.axvline(np.degrees(element) % 360.0, color="#bbbbbb", linewidth=0.7, zorder=0)
        ax.set_xlim(0.0, 360.0)
        ax.set_xticks(np.arange(0, 361, 45))
        ax.set_ylim(max(peak - 40.0, float(level.min()) - 2.0), peak + 2.0)
        ax.set_xlabel("azimuth of the tag in the reader frame [°]")
        ax.set_ylabel("RSS [dBm]")
        ax.set_title(f"received power, {distance_m:g} m away")
        antenna_legend(figure, ax)
    return figure


def _mean_errors_rad(
    rss_w: FloatArray, azimuths_rad: FloatArray, element_azimuths_rad: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the (d, a) bearing errors of the strongest antenna and of the vector sum [rad]."""
    weight = leaders(rss_w)
    error = np.abs(wrap_angle(element_azimuths_rad - azimuths_rad[:, None]))
    strongest = (weight * error).sum(axis=-1)
    strongest = np.where(weight.sum(axis=-1) > 0.0, strongest, np.pi)
    vector = np.abs(wrap_angle(vector_sum_bearing_rad(rss_w, element_azimuths_rad) - azimuths_rad))
    return strongest, np.where(np.isnan(vector), np.pi, vector)


def bearing_error_figure(
    surroundings: Sequence[tuple[str, FloatArray, FloatArray]],
    element_azimuths_rad: FloatArray,
    *,
    title: str,
) -> "Figure":
    """Return the bearing error [deg] against the tag's azimuth, a panel for each surrounding.

    Parameters
    ----------
    surroundings : sequence of (str, (a,) float64, (d, a, n) float64)
        Name, azimuths of the tag [rad], and RSS [W] by distance or place, azimuth, antenna.
    element_azimuths_rad : (n,) float64
        Azimuths of the antennas [rad].
    title : str
        Above the figure.

    Returns
    -------
    Figure
        Median (line) and the range from 10 % to 90 % (band) over distances or places.
    """
    with figure_style():
        count = len(surroundings)
        figure, axes = new_figure(
            width_in=2.2 + 3.7 * count, height_in=3.6, title=title, columns=count
        )
        for ax, (name, azimuths, rss) in zip(axes[0], surroundings, strict=True):
            errors = _mean_errors_rad(rss, azimuths, element_azimuths_rad)
            degrees = np.append(np.degrees(azimuths), 360.0 + np.degrees(azimuths[0]))
            labels = ("strongest antenna", "RSS-weighted vector sum")
            for error, label, colour in zip(errors, labels, ("#cc6677", "#332288"), strict=True):
                closed = np.hstack([error, error[:, :1]])
                low, middle, high = np.degrees(np.quantile(closed, [0.1, 0.5, 0.9], axis=0))
                ax.fill_between(degrees, low, high, color=colour, alpha=0.16, linewidth=0)
                ax.plot(degrees, middle, color=colour, label=label)
            ax.set_title(name)
            ax.set_xlim(0.0, 360.0)
            ax.set_xticks(np.arange(0, 361, 45))
            ax.set_ylim(bottom=-0.015 * ax.get_ylim()[1])  # keeps a line at zero in sight
            ax.set_xlabel("azimuth of the tag in the reader frame [°]")
        axes[0, 0].set_ylabel("absolute bearing error [°]")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure
