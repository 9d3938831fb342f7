"""Distribution of the bearing error, and the patterns of single antennas."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna
from octant.em.decibels import decibels
from octant.reader_design.showing.style import figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

STYLES = (("#332288", "-"), ("#332288", "--"), ("#cc6677", "-"), ("#cc6677", "--"))
FLOOR_DBI = -30.0
"""Gain at which a pattern figure ends [dBi]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorCurve:
    """One curve of a distribution.

    Attributes
    ----------
    label : str
        In the legend.
    error_rad : (...) float64
        Errors of either sign [rad].
    weight : (...) float64 or None
        Weight of each [-]; None: equal.
    """

    label: str
    error_rad: FloatArray
    weight: FloatArray | None = None


def error_distribution_figure(
    panels: Sequence[tuple[str, Sequence[ErrorCurve]]], *, title: str
) -> "Figure":
    """Return the share of directions within each absolute bearing error [deg], [%].

    Parameters
    ----------
    panels : sequence of (str, sequence of ErrorCurve)
        Name and curves of each surrounding.
    title : str
        Above the figure.

    Returns
    -------
    Figure
        50 and 90 % as horizontal lines, 45 and 90 degrees as vertical ones.
    """
    with figure_style():
        figure, axes = new_figure(
            width_in=1.2 + 4.2 * len(panels), height_in=3.9, title=title, columns=len(panels)
        )
        for ax, (name, curves) in zip(axes[0], panels, strict=True):
            for curve, (colour, dashes) in zip(curves, STYLES, strict=False):
                size = np.degrees(np.abs(curve.error_rad)).ravel()
                weight = np.ones(size.size) if curve.weight is None else curve.weight.ravel()
                order = np.argsort(size, kind="stable")
                share = 100.0 * np.cumsum(weight[order]) / weight.sum()
                ax.step(
                    np.append(0.0, size[order]),
                    np.append(0.0, share),
                    where="post",
                    color=colour,
                    linestyle=dashes,
                    label=curve.label,
                )
            for level in (50.0, 90.0):
                ax.axhline(level, color="#999999", linewidth=0.8, linestyle=":")
            for limit in (45.0, 90.0):
                ax.axvline(limit, color="#999999", linewidth=0.8, linestyle=":")
            ax.set_title(name)
            ax.set_xscale("symlog", linthresh=1.0, linscale=0.35)
            ax.set_xticks(
                [0, 1, 2, 5, 10, 20, 45, 90, 180],
                ["0", "1", "2", "5", "10", "20", "45", "90", "180"],
            )
            ax.set_xlim(0.0, 180.0)
            ax.set_ylim(0.0, 101.0)
            ax.set_xlabel("absolute bearing error [°]")
        axes[0, 0].set_ylabel("share of places and headings [%]")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure


def element_pattern_figure(antenna: Antenna, *, title: str) -> "Figure":
    """Return the gain of one antenna alone over its elevation angle [dBi], as thesis Fig. 5.8.

    Parameters
    ----------
    antenna : Antenna
        Vertical, in its own frame.
    title : str
        Above the figure.

    Returns
    -------
    Figure
        Polar cut and Cartesian curve; the pattern is the same at every azimuth.
    """
    theta = np.radians(np.linspace(0.0, 360.0, 721))
    folded = np.minimum(theta, 2.0 * np.pi - theta)
    field = antenna.far_field(folded, np.where(theta <= np.pi, 0.0, np.pi))
    gain = np.maximum((np.abs(field) ** 2).sum(axis=-1), 1e-12)
    gain_dbi = decibels(gain)
    with figure_style():
        figure, axes = new_figure(width_in=8.6, height_in=4.0, title=title, columns=2)
        axes[0, 0].remove()
        polar: Any = figure.add_subplot(1, 2, 1, projection="polar")
        polar.set_theta_zero_location("N")
        polar.set_theta_direction(-1)
        polar.plot(theta, np.maximum(gain_dbi, FLOOR_DBI), color="#332288", label="gain")
        polar.set_ylim(FLOOR_DBI, 6.0)
        polar.set_yticks([-30, -20, -10, 0])
        polar.set_title("gain [dBi] over the elevation angle θ", pad=14)
        ax = axes[0, 1]
        half = theta <= np.pi
        ax.plot(
            np.degrees(theta[half]),
            gain[half],
            color="#332288",
            label=f"greatest gain {gain.max():.2f} ({gain_dbi.max():.2f} dBi)",
        )
        ax.set_xlim(0.0, 180.0)
        ax.set_xticks(np.arange(0, 181, 30))
        ax.set_ylim(0.0, 1.2 * float(gain.max()))
        ax.set_xlabel("elevation angle θ from the antenna's axis [°]")
        ax.set_ylabel("gain over isotropic [-]")
        ax.legend(loc="upper right")
    return figure
