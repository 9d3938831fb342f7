"""Figures of measured levels beside predicted ones: on the floor plan, against distance, walls."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.reader_design.showing.plan import Plan, draw_plan, draw_tags, plan_of, plan_shape
from octant.reader_design.showing.style import NamedFigure, figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection
    from matplotlib.figure import Figure

    from octant.reader_design.experiments.measured.observations import Observations
    from octant.reader_design.experiments.measured.predict import Rows
    from octant.reader_design.setting.setting import Setting

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

MOST_PANELS = 12
"""Sources whose residuals are drawn [-]."""
RANGE_DB = 10.0
"""Residual at the ends of the colours [dB]."""
MEASURED, LINE = "#332288", "#cc6677"


def residual_maps(
    setting: "Setting",
    rows: "Rows",
    observations: "Observations",
    residual_db: FloatArray,
    *,
    title: str,
) -> "Figure":
    """Return the residuals of each source's cells on the floor plan [dB], antennas averaged.

    Parameters
    ----------
    setting, rows, observations : The room, the readings, their local means.
    residual_db : (o,) float64 — Measured less predicted [dB].
    title : Above the figure.
    """
    plan = plan_of(setting.scene, setting.reader_z_m)
    sources = np.unique(observations.sources)[:MOST_PANELS]
    columns = min(3, len(sources))
    lines = -(-len(sources) // columns)
    shape = plan_shape(plan, *observations.places.T)
    with figure_style():
        figure, axes = new_figure(
            width_in=1.2 + 3.1 * columns,
            height_in=0.9 + lines * (0.7 + 3.0 * shape),
            title=title,
            rows=lines,
            columns=columns,
        )
        drawn: PathCollection | None = None
        panels: list[Axes] = list(axes.reshape(-1))
        for i, ax in enumerate(panels):
            if i >= len(sources):
                ax.set_visible(False)
                continue
            drawn = _draw_map(ax, plan, observations, residual_db, int(sources[i]))
            tag = rows.tags[int(sources[i])]
            name = rows.log.ids[int(sources[i])]
            draw_tags(ax, {name: setting.tags[tag].point_m})
            ax.set_title(name, fontsize=10)
        if drawn is not None:
            figure.colorbar(drawn, ax=panels, label="measured less predicted [dB]", shrink=0.8)
    return figure


def _draw_map(
    ax: "Axes", plan: Plan, o: "Observations", residual_db: FloatArray, source: int
) -> "PathCollection":
    draw_plan(ax, plan, extra_m=o.places)
    mine = (o.sources == source) & np.isfinite(residual_db)
    cells, index = np.unique(o.cells[mine], axis=0, return_inverse=True)
    index = index.reshape(-1)
    count = np.bincount(index, minlength=len(cells))
    mean = np.bincount(index, residual_db[mine], minlength=len(cells)) / np.maximum(count, 1)
    x, y = (np.bincount(index, o.places[mine, k], minlength=len(cells)) / count for k in (0, 1))
    return ax.scatter(
        x, y, c=mean, cmap="RdBu_r", vmin=-RANGE_DB, vmax=RANGE_DB, s=42, zorder=4,
        edgecolors="#555555", linewidths=0.3,
    )  # fmt: skip


def against_figure(
    distance_m: FloatArray, walls: IntArray, residual_db: FloatArray, *, title: str
) -> "Figure":
    """Return residuals against distance and against walls on the straight line [dB].

    Parameters
    ----------
    distance_m, walls, residual_db : (o,) — Distance [m], faces of walls, residual [dB].
    title : Above the figure.
    """
    finite = np.isfinite(residual_db)
    r, d, w = residual_db[finite], distance_m[finite], walls[finite]
    with figure_style():
        figure, axes = new_figure(width_in=9.0, height_in=3.6, title=title, columns=2)
        left, right = axes[0]
        left.plot(d, r, ".", color=MEASURED, markersize=3, alpha=0.6)
        edges = np.quantile(d, np.linspace(0.0, 1.0, 9)) if len(d) > 40 else np.array([])
        for a, b in pairwise(edges):
            mine = (d >= a) & (d <= b)
            left.plot([a, b], [np.median(r[mine])] * 2, color=LINE, linewidth=2.2)
        left.set_xlabel("distance to the source [m]")
        left.set_ylabel("measured less predicted [dB]")
        counts = np.unique(w)
        right.boxplot([r[w == n] for n in counts], showfliers=False)
        right.set_xticks(np.arange(1, len(counts) + 1), [str(n) for n in counts])
        right.set_xlabel("faces of walls on the straight line [-]")
        for ax in (left, right):
            ax.axhline(0.0, color="#222222", linewidth=0.8)
    return figure


def levels_figure(
    measured_dbm: FloatArray, predicted_dbm: FloatArray, groups: Sequence[str], *, title: str
) -> "Figure":
    """Return measured against predicted local means, a panel a source and antenna [dBm].

    Parameters
    ----------
    measured_dbm, predicted_dbm : (o,) float64 — Levels [dBm].
    groups : Name of the source and antenna of each.
    title : Above the figure.
    """
    names = list(dict.fromkeys(groups))[:MOST_PANELS]
    columns = min(4, len(names))
    lines = -(-len(names) // columns)
    of = np.array(groups)
    with figure_style():
        figure, axes = new_figure(
            width_in=0.9 + 2.4 * columns,
            height_in=0.9 + 2.4 * lines,
            title=title,
            rows=lines,
            columns=columns,
        )
        panels: list[Axes] = list(axes.reshape(-1))
        for i, ax in enumerate(panels):
            if i >= len(names):
                ax.set_visible(False)
                continue
            mine = (of == names[i]) & np.isfinite(measured_dbm) & np.isfinite(predicted_dbm)
            y, p = measured_dbm[mine], predicted_dbm[mine]
            ax.plot(p, y, ".", color=MEASURED, markersize=4, alpha=0.7)
            if len(p):
                ends = np.array([p.min(), p.max()])
                ax.plot(ends, ends + np.mean(y - p), color=LINE, linewidth=1.5)
            ax.set_title(names[i], fontsize=10)
            if i % columns == 0:
                ax.set_ylabel("measured [dBm]")
            ax.set_xlabel("predicted [dBm]")
    return figure


def compare_figures(parts: Mapping[str, "Figure"]) -> tuple[NamedFigure, ...]:
    """Return figures with their file names and captions ([dB], [m]).

    Parameters
    ----------
    parts : Figures by ``residuals``, ``against`` and ``levels``.
    """
    texts = {
        "residuals": (
            "Residuals on the floor plan",
            (
                "Measured less predicted local means [dB]. Patches of one colour near a source "
                "speak of its antenna, behind a wall of its material, elsewhere of what the mesh "
                "lacks."
            ),
        ),
        "against": (
            "Residuals against distance and walls",
            (
                "Measured less predicted [dB]; red: medians of equal counts. A trend with distance "
                "is a wrong height, antenna or diffuse field, one with walls a wrong material."
            ),
        ),
        "levels": (
            "Measured against predicted",
            "Local means [dBm]; the line has slope 1 and the mean difference.",
        ),
    }
    return tuple(
        NamedFigure(
            file=f"{name}.png",
            section="residuals",
            title=texts[name][0],
            caption=texts[name][1],
            figure=figure,
        )
        for name, figure in parts.items()
    )
