"""Plots of one reader: RSS and error over azimuth, the distribution of the error, patterns."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna
from octant.em.decibels import decibels, power_dbm
from octant.navigation.angles import wrap_angle
from octant.reader_design.setting.measures import leaders, vector_sum_bearing_rad
from octant.reader_design.showing.style import (
    antenna_legend,
    draw_antennas,
    figure_style,
    new_figure,
    with_projection,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

STYLES = (("#332288", "-"), ("#332288", "--"), ("#cc6677", "-"), ("#cc6677", "--"))
FLOOR_DBI = -30.0
"""Gain at which a pattern figure ends [dBi]."""


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
    azimuths_rad, rss_w : (a,), (a, n) float64 — Tag in the reader frame, ascending [rad]; RSS [W].
    element_azimuths_rad : (n,) float64 — Azimuths of the antennas [rad], marked in both panels.
    distance_m, title : Horizontal distance of the tag [m], for the caption; text above.
    """
    order = np.argsort(azimuths_rad)
    azimuth = np.append(azimuths_rad[order], azimuths_rad[order][0] + 2.0 * np.pi)
    level = power_dbm(np.maximum(np.vstack([rss_w[order], rss_w[order][:1]]), 1e-30))
    peak = float(level.max())
    with figure_style():
        figure, axes = new_figure(width_in=9.6, height_in=4.2, title=title, rows=1, columns=2)
        polar = with_projection(axes[0, 0], "polar")
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

    Median (line) and the range from 10 % to 90 % (band) over distances or places.

    Parameters
    ----------
    surroundings : Name, azimuths of the tag [rad], (distance or place, azimuth, antenna) RSS [W].
    element_azimuths_rad, title : (n,) float64 — Azimuths of the antennas [rad]; text above.
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


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorCurve:
    """One curve of a distribution.

    Attributes
    ----------
    label, error_rad : In the legend; (...) float64 — errors of either sign [rad].
    weight : (...) float64 or None — Weight of each [-]; None: equal.
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
    panels, title : Name and curves of each surrounding; text above the figure.
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
    antenna, title : Vertical, in its own frame, so alike at every azimuth; text above.
    """
    theta = np.radians(np.linspace(0.0, 360.0, 721))
    folded = np.minimum(theta, 2.0 * np.pi - theta)
    field = antenna.far_field(folded, np.where(theta <= np.pi, 0.0, np.pi))
    gain = np.maximum((np.abs(field) ** 2).sum(axis=-1), 1e-12)
    gain_dbi = decibels(gain)
    with figure_style():
        figure, axes = new_figure(width_in=8.6, height_in=4.0, title=title, columns=2)
        polar = with_projection(axes[0, 0], "polar")
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
