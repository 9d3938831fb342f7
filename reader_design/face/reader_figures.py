"""Figures of one reader's full-wave solution: gains, S-matrix, currents on its mesh."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from octant.em.decibels import decibels
from octant.reader_design.showing.style import (
    antenna_legend,
    draw_antennas,
    figure_style,
    new_figure,
    with_projection,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from mpl_toolkits.mplot3d import Axes3D

FloatArray = npt.NDArray[np.float64]

SPAN_DB = 30.0
"""Range of gain that polar cuts and solids of gain show below their top [dB]."""
CURRENT_SPAN_DB = 60.0
MOST_DRAWN = 100
"""Rows and columns of a solid of gain that are drawn, about [-]."""


def gain_dbi(pattern: npt.NDArray[np.complex128]) -> FloatArray:
    """Return the gain of both polarisations together over isotropic [dBi], not below -100 dBi.

    Parameters
    ----------
    pattern : (..., 2) complex128 — F_theta and F_phi [-].
    """
    power = np.sum(np.abs(pattern) ** 2, axis=-1)
    return decibels(np.maximum(power, 1e-10))


def element_figure(
    theta_rad: FloatArray, phi_rad: FloatArray, gain: FloatArray, *, title: str
) -> "Figure":
    """Return the gain of a single antenna: as a solid (thesis Fig. 5.8, 5.10) and a cut over theta.

    Parameters
    ----------
    theta_rad, phi_rad : Angles from the vertical; azimuths 0 to 2 pi, both ends included [rad].
    gain : (t, p) float64 — Gain [dBi].
    title : Above the figure.
    """
    with figure_style():
        figure, axes = new_figure(width_in=9.0, height_in=4.2, title=title, columns=2)
        solid = with_projection(axes[0, 0], "3d")
        _draw_solid(figure, solid, theta_rad, phi_rad, gain)
        ax = axes[0, 1]
        degrees = np.degrees(theta_rad)
        ax.plot(degrees, gain[:, 0], label="azimuth 0°")
        across = int(np.argmin(np.abs(phi_rad - 0.25 * np.pi)))
        if np.abs(gain[:, across] - gain[:, 0]).max() > 0.1:
            ax.plot(
                degrees, gain[:, across], "--", label=f"azimuth {np.degrees(phi_rad[across]):.0f}°"
            )
            ax.legend(loc="lower center")
        top, best = float(gain.max()), np.unravel_index(int(gain.argmax()), gain.shape)
        ax.axhline(top, color="#999999", linewidth=0.8, linestyle=":")
        ax.set_title(f"greatest gain {top:.2f} dBi at θ = {degrees[best[0]]:.0f}°")
        ax.set_xlim(0.0, 180.0)
        ax.set_xticks(np.arange(0, 181, 30))
        ax.set_ylim(top - SPAN_DB, top + 3.0)
        ax.set_xlabel("angle θ from the vertical [°]")
        ax.set_ylabel("gain [dBi]")
    return figure


def gain_figure(
    theta_rad: FloatArray, phi_rad: FloatArray, gain: FloatArray, *, title: str
) -> "Figure":
    """Return one antenna's realised gain as a solid, whose radius and colour are the gain [dBi].

    Parameters
    ----------
    theta_rad, phi_rad, gain, title : As in `element_figure` [rad], [dBi].
    """
    with figure_style():
        figure, axes = new_figure(width_in=6.4, height_in=5.4, title=title)
        solid = with_projection(axes[0, 0], "3d")
        _draw_solid(figure, solid, theta_rad, phi_rad, gain)
    return figure


def _draw_solid(
    figure: "Figure", axes: "Axes3D", theta_rad: FloatArray, phi_rad: FloatArray, gain: FloatArray
) -> None:
    """Draw gain as a solid, whose centre stands for `SPAN_DB` below the greatest gain."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.ticker import NullFormatter
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    top = float(gain.max())
    radius = np.maximum(gain - (top - SPAN_DB), 0.0) / SPAN_DB
    theta, phi = theta_rad[:, None], phi_rad[None, :]
    scale = Normalize(top - SPAN_DB, top)
    corners = np.stack(
        (
            radius * np.sin(theta) * np.cos(phi),
            radius * np.sin(theta) * np.sin(phi),
            radius * np.cos(theta),
        ),
        axis=-1,
    )
    # As arrays: one colour object for each of 10,000 pieces takes longer than the field's solution.
    rows, columns = (_drawn(size) for size in gain.shape)
    grid, colours = corners[np.ix_(rows, columns)], colormaps["viridis"](scale(gain))
    pieces = np.stack((grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]), axis=2)
    colour = colours[np.ix_(rows[:-1], columns[:-1])].reshape(-1, 4)
    axes.add_collection3d(
        Poly3DCollection(
            pieces.reshape(-1, 4, 3),
            facecolors=colour,
            edgecolors=colour,
            linewidth=0.0,
            antialiased=False,
        )
    )
    _space(axes, reach=1.0)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_major_formatter(NullFormatter())
    axes.set_xlabel("x (antenna 1)", labelpad=-10)
    axes.set_ylabel("y", labelpad=-10)
    axes.set_zlabel("z (up)", labelpad=-10)
    bar = figure.colorbar(
        ScalarMappable(scale, "viridis"), ax=axes, label="gain [dBi]", shrink=0.7, pad=0.08
    )
    bar.outline.set_visible(False)


def _drawn(size: int) -> npt.NDArray[np.int64]:
    """Return which rows or columns of a grid are drawn: all ends, and about a hundred between."""
    step = max(1, math.ceil(size / MOST_DRAWN))
    return np.append(np.arange(0, size - 1, step), size - 1)


def _space(axes: "Axes3D", *, reach: float) -> None:
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_zlim(-reach, reach)
    axes.set_box_aspect((1.0, 1.0, 1.0))
    axes.view_init(elev=24.0, azim=-58.0)


def cuts_figure(
    phi_rad: FloatArray,
    cuts: Sequence[tuple[float, FloatArray]],
    element_azimuths_rad: FloatArray,
    *,
    title: str,
) -> "Figure":
    """Return the antennas' realised gain over azimuth, a polar panel each elevation, of one scale.

    Parameters
    ----------
    phi_rad : (p,) float64 — Azimuths, 0 to 2 pi, both ends included [rad].
    cuts : Elevation over the horizon [deg] and the antennas' gain there [dBi].
    element_azimuths_rad : (n,) float64 — Azimuths of the antennas [rad].
    title : Above the figure.
    """
    columns = min(len(cuts), 2)
    rows = -(-len(cuts) // columns)
    top = 5.0 * np.ceil(max(float(gain.max()) for _, gain in cuts) / 5.0)
    with figure_style():
        figure, axes = new_figure(
            width_in=1.6 + 3.8 * columns,
            height_in=0.6 + 3.9 * rows,
            title=title,
            rows=rows,
            columns=columns,
        )
        polar: Any = None
        places = axes.ravel().tolist()
        for unused in places[len(cuts) :]:
            unused.remove()
        for ax, (elevation_deg, gain) in zip(places, cuts, strict=False):
            polar = with_projection(ax, "polar")
            draw_antennas(polar, phi_rad, np.maximum(gain, top - SPAN_DB).T)
            polar.set_ylim(top - SPAN_DB, top)
            polar.set_yticks(np.arange(top - SPAN_DB, top + 1.0, 10.0))
            polar.set_rlabel_position(float(np.degrees(element_azimuths_rad[0])) + 11.0)
            polar.set_xticks(np.sort(element_azimuths_rad % (2.0 * np.pi)))
            polar.set_title(f"elevation {elevation_deg:g}°", pad=14)
        antenna_legend(figure, polar, title="gain [dBi]")
    return figure


def s_matrix_figure(s_matrix: npt.NDArray[np.complex128], *, title: str) -> "Figure":
    """Return a coloured table of magnitudes [dB]: reflection on the diagonal, coupling beside it.

    Parameters
    ----------
    s_matrix : (n, n) complex128 — Scattering matrix [-].
    title : Above the figure.
    """
    level = 20.0 * np.log10(np.maximum(np.abs(s_matrix), 1e-10))
    count = len(level)
    with figure_style():
        figure, axes = new_figure(
            width_in=1.9 + 0.62 * count, height_in=1.2 + 0.56 * count, title=title
        )
        ax = axes[0, 0]
        low = max(float(level.min()), -60.0)
        mesh = ax.imshow(level, cmap="viridis", vmin=low, vmax=0.0, origin="upper")
        for (i, j), value in np.ndenumerate(level):
            colour = "white" if value < 0.55 * low else "#222222"
            ax.text(j, i, f"{value:.1f}", ha="center", va="center", fontsize=8, color=colour)
        names = [str(i + 1) for i in range(count)]
        ax.set_xticks(range(count), names)
        ax.set_yticks(range(count), names)
        ax.tick_params(length=0)
        ax.grid(visible=False)
        ax.set_xlabel("driven antenna")
        ax.set_ylabel("receiving antenna")
        bar = figure.colorbar(mesh, ax=ax, label="|S| [dB]", shrink=0.9)
        bar.outline.set_visible(False)
    return figure


def return_loss_figure(
    frequencies_hz: FloatArray,
    impedance_ohm: npt.NDArray[np.complex128],
    return_loss_db: FloatArray,
    *,
    title: str,
) -> "Figure":
    """Return every antenna's return loss [dB], resistance and reactance [ohm] over frequency.

    Parameters
    ----------
    frequencies_hz : (f,) float64 — Frequencies [Hz].
    impedance_ohm : (f, n) complex128 — Input impedances [ohm].
    return_loss_db : (f, n) float64 — Return loss [dB]; its axis runs downwards, so that a good
        match is a dip.
    title : Above the figure.
    """
    x = frequencies_hz / 1e9
    panels = (
        ("return loss [dB]", return_loss_db),
        ("resistance [ohm]", impedance_ohm.real),
        ("reactance [ohm]", impedance_ohm.imag),
    )
    with figure_style():
        figure, axes = new_figure(width_in=10.6, height_in=3.8, title=title, columns=len(panels))
        for ax, (label, values) in zip(axes[0], panels, strict=True):
            draw_antennas(ax, x, values)
            ax.set_xlabel("frequency [GHz]")
            ax.set_ylabel(label)
            ax.set_xlim(float(x[0]), float(x[-1]))
        axes[0, 0].set_ylim(max(float(return_loss_db.max()), 10.0) + 2.0, 0.0)
        antenna_legend(figure, axes[0, 0])
    return figure


def current_figure(corners_m: FloatArray, current_a_per_m: FloatArray, *, title: str) -> "Figure":
    """Return the surface current on a mesh, coloured over 60 dB below the greatest; axes in [cm].

    Parameters
    ----------
    corners_m : (f, 3, 3) float64 — Corners of the triangles [m].
    current_a_per_m : (f,) float64 — Current density in the middle of each triangle [A/m].
    title : Above the figure.
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    top = max(float(current_a_per_m.max()), 1e-30)
    level = 20.0 * np.log10(np.maximum(current_a_per_m / top, 1e-10))
    scale = Normalize(-CURRENT_SPAN_DB, 0.0)
    points = 100.0 * corners_m
    with figure_style():
        figure, axes = new_figure(width_in=7.6, height_in=5.6, title=title)
        ax = with_projection(axes[0, 0], "3d")
        faces = Poly3DCollection(
            points, facecolors=colormaps["inferno"](scale(level)), edgecolors="#ffffff30"
        )
        faces.set_linewidth(0.15)
        ax.add_collection3d(faces)
        low, high = points.min(axis=(0, 1)), points.max(axis=(0, 1))
        size = np.maximum(high - low, 1.0)
        ax.set_xlim(low[0], high[0])
        ax.set_ylim(low[1], high[1])
        ax.set_zlim(low[2], low[2] + size[2])
        ax.set_box_aspect(tuple(size / size.max()), zoom=1.05)
        ax.view_init(elev=38.0, azim=-35.0)
        ax.set_xlabel("x [cm]")
        ax.set_ylabel("y [cm]")
        ax.set_zlabel("z [cm]")
        bar = figure.colorbar(
            ScalarMappable(scale, "inferno"),
            ax=ax,
            label="surface current below its maximum [dB]",
            shrink=0.75,
            pad=0.1,
            extend="min",
        )
        bar.outline.set_visible(False)
    return figure
