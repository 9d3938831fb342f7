"""Figures of a reader over a band: Smith chart, isolation, efficiency and gain."""

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from octant.em.decibels import decibels
from octant.reader_design.showing.style import (
    ANTENNA_COLOURS,
    ANTENNA_DASHES,
    antenna_legend,
    draw_antennas,
    figure_style,
    new_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]

_RESISTANCES = (0.2, 0.5, 1.0, 2.0, 5.0)
_REACTANCES = (0.2, 0.5, 1.0, 2.0, 5.0)
_MATCHED = 10.0 ** (-10.0 / 20.0)


def smith_figure(s_matrices: ComplexArray, frequencies_hz: FloatArray, *, title: str) -> "Figure":
    """Return the reflection of every antenna in a Smith chart, normalised to the loads [-].

    Parameters
    ----------
    s_matrices, frequencies_hz : (f, n, n) [-] at frequencies, (f,) [Hz].
    title : Above the figure.
    """
    with figure_style():
        figure, axes = new_figure(width_in=7.2, height_in=5.8, title=title)
        ax = axes[0, 0]
        _draw_chart(ax)
        for i in range(s_matrices.shape[1]):
            gamma, colour = s_matrices[:, i, i], ANTENNA_COLOURS[i % len(ANTENNA_COLOURS)]
            dashes = ANTENNA_DASHES[(i * 4 // s_matrices.shape[1]) % len(ANTENNA_DASHES)]
            ax.plot(gamma.real, gamma.imag, dashes, color=colour, label=f"antenna {i + 1}")
            ax.plot(gamma[0].real, gamma[0].imag, "o", color=colour, markersize=4.5)
            ax.plot(gamma[-1].real, gamma[-1].imag, "s", color=colour, markersize=4.5)
        f = frequencies_hz / 1e9
        ax.plot([], [], "o", color="#555555", label=f"{f[0]:.4g} GHz")
        ax.plot([], [], "s", color="#555555", label=f"{f[-1]:.4g} GHz")
        figure.legend(*ax.get_legend_handles_labels(), loc="outside right center")
    return figure


def _draw_chart(ax: "Axes") -> None:
    """Draw circles of constant resistance and reactance, and the circle of -10 dB."""
    turn = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 361))
    style: dict[str, Any] = {"color": "#c4c4c4", "linewidth": 0.7, "zorder": 1.0}
    for r in _RESISTANCES:
        circle = r / (1.0 + r) + turn / (1.0 + r)
        ax.plot(circle.real, circle.imag, **style)
        ax.annotate(f"{r:g}", ((r - 1.0) / (r + 1.0), 0.01), fontsize=6.5, color="#777777")
    for x in _REACTANCES:
        for sign in (1.0, -1.0):
            z = np.concatenate([np.linspace(0.0, 1.0, 60), np.geomspace(1.0, 1e3, 120)])
            gamma = (z + 1j * sign * x - 1.0) / (z + 1j * sign * x + 1.0)
            ax.plot(gamma.real, gamma.imag, **style)
            place = 1.06 * gamma[0]
            text = f"{'+' if sign > 0 else '−'}j{x:g}"
            ax.annotate(
                text,
                (place.real, place.imag),
                fontsize=6.5,
                color="#777777",
                ha="center",
                va="center",
            )
    ax.plot([-1.0, 1.0], [0.0, 0.0], **style)
    ax.plot(turn.real, turn.imag, color="#666666", linewidth=1.0)
    inner = _MATCHED * turn
    ax.plot(inner.real, inner.imag, color="#117733", linewidth=1.0, linestyle="--", label="−10 dB")
    ax.set_aspect("equal")
    ax.set_xlim(-1.13, 1.13)
    ax.set_ylim(-1.13, 1.13)
    ax.set_axis_off()


def isolation_figure(
    s_matrices: ComplexArray, frequencies_hz: FloatArray, *, title: str
) -> "Figure":
    """Return the coupling between antennas over frequency, by how many places they are apart [dB].

    The greatest of all pairs that are equally far apart round the reader.

    Parameters
    ----------
    s_matrices, frequencies_hz : (f, n, n) [-] at frequencies, (f,) [Hz].
    title : Above the figure.
    """
    n = s_matrices.shape[1]
    number = np.arange(n)
    apart = np.abs(number[:, None] - number)
    apart = np.minimum(apart, n - apart)
    level = decibels(np.maximum(np.abs(s_matrices) ** 2, 1e-12))
    with figure_style():
        figure, axes = new_figure(width_in=7.6, height_in=4.0, title=title)
        ax = axes[0, 0]
        for step in range(1, n // 2 + 1):
            name = "neighbours" if step == 1 else f"{step} places apart"
            ax.plot(
                frequencies_hz / 1e9,
                level[:, apart == step].max(axis=1),
                color=ANTENNA_COLOURS[(step - 1) % len(ANTENNA_COLOURS)],
                label=name,
            )
        ax.set_xlabel("frequency [GHz]")
        ax.set_ylabel("coupling |S| [dB]")
        ax.set_xlim(float(frequencies_hz[0]) / 1e9, float(frequencies_hz[-1]) / 1e9)
        figure.legend(*ax.get_legend_handles_labels(), loc="outside right center")
    return figure


def band_gain_figure(
    frequencies_hz: FloatArray,
    efficiencies: tuple[FloatArray, FloatArray],
    gains_db: tuple[FloatArray, FloatArray, FloatArray],
    *,
    title: str,
) -> "Figure":
    """Return efficiencies [%], gain [dBi] and margin [dB] of every antenna over frequency.

    Parameters
    ----------
    frequencies_hz : (f,) [Hz].
    efficiencies, gains_db : Total and embedded [-]; greatest and own gain [dBi], margin [dB]; each
        (f, n).
    title : Above the figure.
    """
    panels = (
        ("total efficiency [%]", 100.0 * efficiencies[0]),
        ("embedded efficiency [%]", 100.0 * efficiencies[1]),
        ("gain towards its azimuth [dBi]", gains_db[1]),
        ("margin over the next antenna [dB]", gains_db[2]),
    )
    with figure_style():
        figure, axes = new_figure(width_in=9.2, height_in=6.4, title=title, rows=2, columns=2)
        for ax, (label, values) in zip(axes.ravel(), panels, strict=True):
            draw_antennas(ax, frequencies_hz / 1e9, values)
            ax.set_xlabel("frequency [GHz]")
            ax.set_ylabel(label)
            ax.set_xlim(float(frequencies_hz[0]) / 1e9, float(frequencies_hz[-1]) / 1e9)
        antenna_legend(figure, axes[0, 0])
    return figure
