"""A drawing of a reader from which a workshop can build it: top view, side view, all lengths."""

import math
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.geometries.files import whole_file
from octant.geometries.reader_body import ground_plane_outline_m
from octant.reader_design.showing.style import figure_style
from octant.reader_design.study_file.reader import Reader

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Rectangle

FloatArray = npt.NDArray[np.float64]

PAPER_MM = (297.0, 210.0)
"""Sheet: A4, landscape [mm]."""
SCALES = (1.0, 2.0, 2.5, 5.0, 10.0, 20.0)
"""Real lengths over lengths on the sheet that a drawing may have [-]."""
VIEW_MM = (136.0, 136.0)
"""Room for one view on the sheet, dimensions included [mm]."""
MARGIN = 0.36
"""Room around the ground plane for dimensions, as a share of its size [-]."""

ROW_LETTERS = 112
"""Letters of a row of the parts list; what is longer goes on below [-]."""

INK, METAL, PLATE, WIRE, DIMENSION = "#222222", "#eceff1", "#5c6670", "#b5333f", "#2b4c7e"
MM = 1e3
DIMENSION_LINE, DIMENSION_TEXT = "dimension-line-", "dimension-text-"
"""How dimensions are marked: a line and its text end in the same number."""


def drawing(design: Reader, *, frequency_hz: float, title: str) -> "Figure":
    """Return a drawing to scale of a reader: top view, side view, parts list; lengths in [mm].

    The side view is a section through antenna 1 and the opposite one; the plates are turned into
    its plane, so that they show their true shape.

    Parameters
    ----------
    design : Any design that can be built.
    frequency_hz : Frequency at which antennas without a length are cut [Hz].
    title : Name in the title block.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    body = design.body()
    length_mm = MM * (design.element(frequency_hz).length_m or 0.0)
    scale = drawing_scale(design)
    with figure_style():
        figure = Figure(figsize=(PAPER_MM[0] / 25.4, PAPER_MM[1] / 25.4))
        figure.set_layout_engine("none")
        FigureCanvasAgg(figure)
        top = _view(figure, (8.0, 62.0), VIEW_MM, scale)
        side = _view(figure, (152.0, 62.0), VIEW_MM, scale)
        _draw_top(top, design, body.plate_azimuths_rad, body.plate_outer_radius_m)
        _draw_side(side, design, length_mm, MM * body.plate_outline_m)
        _title_block(figure, _parts(design, length_mm, frequency_hz), title=title, scale=scale)
    return figure


def drawing_scale(design: Reader) -> float:
    """Return real lengths over lengths on the sheet of a reader's drawing [-].

    Parameters
    ----------
    design : The reader.
    """
    size_mm = MM * _extent_m(design) * 2.0
    return next((s for s in SCALES if (1.0 + MARGIN) * size_mm / s <= VIEW_MM[0]), SCALES[-1])


def save_drawing(figure: "Figure", path: Path) -> None:
    """Write a drawing whole or not at all; equal drawings give equal files.

    Parameters
    ----------
    figure : From :func:`drawing`.
    path : File ending in ``.png`` (200 dots per inch), ``.svg`` or ``.pdf``.
    """
    from matplotlib import rc_context

    kind = path.suffix.removeprefix(".")
    stamp = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with figure_style(), rc_context({"svg.hashsalt": "octant"}), whole_file(path) as part:
        figure.savefig(part, format=kind, dpi=200, metadata=stamp[kind])


def _extent_m(design: Reader) -> float:
    """Return the farthest point of ground plane and antennas from the axis, along x or y [m]."""
    rim = ground_plane_outline_m(
        design.ground_plane_m, shape=design.ground_plane_shape, antennas=design.antennas
    )
    outer_m = design.antenna_radius_m + 0.5e-3 * _own_plane_mm(design)
    return max(float(np.abs(rim).max()), outer_m)


def networks_text(networks: tuple[str, ...]) -> str:
    """Return the antennas' networks of coils and capacitors, those that are alike named together.

    Parameters
    ----------
    networks : ``match`` of ``[reader.feed]``: one for all or one each.
    """
    if len(set(networks)) == 1:
        return f"at each feed, from antenna to cable: {networks[0]}"
    named = (
        f"antennas {', '.join(str(i + 1) for i, one in enumerate(networks) if one == kind)}: {kind}"
        for kind in dict.fromkeys(networks)
    )
    return f"from antenna to cable; {'; '.join(named)}"


def _own_plane_mm(design: Reader) -> float:
    """Return the side of each monopole's own plane [mm]; 0 where there is none."""
    return MM * design.body().fitted_monopole_plane_m if design.antenna == "monopole" else 0.0


def _view(
    figure: "Figure", corner_mm: tuple[float, float], size_mm: tuple[float, float], scale: float
) -> "Axes":
    """Return bare axes at a place of the sheet, in real millimetres around their middle."""
    (x, y), (w, h) = corner_mm, size_mm
    ax = figure.add_axes((x / PAPER_MM[0], y / PAPER_MM[1], w / PAPER_MM[0], h / PAPER_MM[1]))
    ax.set_xlim(-0.5 * w * scale, 0.5 * w * scale)
    ax.set_ylim(-0.5 * h * scale, 0.5 * h * scale)
    ax.set_axis_off()
    return ax


def _dimension(
    ax: "Axes",
    start: tuple[float, float],
    end: tuple[float, float],
    *,
    away: tuple[float, float],
    text: str,
) -> None:
    """Draw a dimension between two points, its line moved away from them [mm]."""
    a, b = np.add(start, away), np.add(end, away)
    for point, foot in ((start, a), (end, b)):
        if np.any(foot != np.asarray(point)):
            ax.plot(*zip(point, foot, strict=True), color=DIMENSION, linewidth=0.4, zorder=4)
    style = {
        "arrowstyle": "<|-|>",
        "color": DIMENSION,
        "linewidth": 0.6,
        "shrinkA": 0,
        "shrinkB": 0,
    }
    arrow = {**style, "mutation_scale": 6}
    line = ax.annotate("", xy=(b[0], b[1]), xytext=(a[0], a[1]), arrowprops=arrow)
    line.set_gid(f"{DIMENSION_LINE}{len(ax.texts)}")
    x, y = 0.5 * (a + b)
    turn = math.degrees(math.atan2(*(b - a)[::-1]))
    turn = turn - 180.0 if turn > 90.0 + 1e-6 else turn + 180.0 if turn <= -90.0 + 1e-6 else turn
    ax.text(
        x,
        y,
        text,
        ha="center",
        va="center",
        rotation=turn,
        fontsize=7.5,
        color=DIMENSION,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},
        zorder=5,
        gid=f"{DIMENSION_TEXT}{len(ax.texts)}",
    )


def _polar(radius: float, azimuth_rad: float) -> tuple[float, float]:
    return radius * math.cos(azimuth_rad), radius * math.sin(azimuth_rad)


def _draw_top(ax: "Axes", design: Reader, plates_rad: FloatArray, reach_m: float) -> None:
    """Draw the reader from above, antenna 1 to the right, the robot's front up."""
    from matplotlib.patches import Arc, Circle, Polygon

    half, extent = 0.5 * MM * design.ground_plane_m, MM * _extent_m(design)
    r_a, reach = MM * design.antenna_radius_m, MM * reach_m
    if design.ground_plane_shape == "round":
        ax.add_patch(Circle((0.0, 0.0), half, facecolor=METAL, edgecolor=INK, linewidth=1.0))
    else:
        rim = MM * ground_plane_outline_m(
            design.ground_plane_m, shape=design.ground_plane_shape, antennas=design.antennas
        )
        ax.add_patch(Polygon(rim, facecolor=METAL, edgecolor=INK, linewidth=1.0))
    for azimuth in plates_rad:
        ax.plot(*zip((0.0, 0.0), _polar(reach, azimuth), strict=True), color=PLATE, linewidth=1.3)
    ax.add_patch(Circle((0, 0), r_a, fill=False, edgecolor=INK, linewidth=0.5, linestyle="-."))
    own = 0.5 * _own_plane_mm(design)
    square = np.array([(-own, -own), (own, -own), (own, own), (-own, own)])
    for i in range(design.antennas):
        azimuth = 2.0 * math.pi * i / design.antennas
        if own:
            radial = np.array(_polar(1.0, azimuth))
            across = np.array((-radial[1], radial[0]))
            corners = (r_a + square[:, :1]) * radial + square[:, 1:] * across
            ax.add_patch(Polygon(corners, facecolor="white", edgecolor=INK, linewidth=0.8))
        ax.plot(*_polar(r_a, azimuth), marker="o", markersize=4.0, color=WIRE, zorder=6)
        ax.text(
            *_polar(r_a - 0.1 * half, azimuth), f"{i + 1}", ha="center", va="center", fontsize=8
        )
    ax.text(0.0, extent * 1.29, "top view", ha="center", fontsize=9, fontweight="bold")
    shape = {"square": "square", "round": "Ø", "octagon": "octagon"}[design.ground_plane_shape]
    _dimension(
        ax,
        (-half, -0.4 * half),
        (half, -0.4 * half),
        away=(0.0, 0.4 * half - extent * 1.14),
        text=f"{shape} {_mm(2.0 * half)}",
    )
    middle = 1.5 * 2.0 * math.pi / design.antennas + math.pi
    tip = _polar(r_a, middle + math.pi / design.antennas)
    ax.annotate(
        f"antennas on Ø {_mm(2.0 * r_a)}",
        xy=tip,
        xytext=(-extent * 1.28, -extent * 1.30),
        fontsize=7.5,
        color=DIMENSION,
        arrowprops={"arrowstyle": "-|>", "color": DIMENSION, "linewidth": 0.6},
    )
    step = 360.0 / design.antennas
    for radius, start, end, text in (
        (0.42, 0.0, step, f"{step:g}°"),
        (0.66, 0.0, 0.5 * step, f"{0.5 * step:g}°"),
    ):
        if end < step and not len(plates_rad):
            continue
        arc = 2.0 * radius * half
        ax.add_patch(
            Arc((0, 0), arc, arc, theta1=start, theta2=end, color=DIMENSION, linewidth=0.6)
        )
        at = math.radians(0.5 * (start + end))
        box = {"facecolor": METAL, "edgecolor": "none", "pad": 0.4}
        place = _polar(radius * half, at)
        ax.text(*place, text, fontsize=6.5, color=DIMENSION, ha="center", va="center", bbox=box)
    ax.plot((0.0, r_a), (0.0, 0.0), color=INK, linewidth=0.4, linestyle="-.")
    front = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.0}
    ax.annotate("", xy=(0, extent * 1.22), xytext=(0, extent * 1.06), arrowprops=front)
    ax.text(extent * 0.05, extent * 1.1, "front of the robot", fontsize=7.5)


def _draw_side(ax: "Axes", design: Reader, length_mm: float, outline_mm: FloatArray) -> None:
    """Draw the section through antenna 1 and the opposite side, plates turned into its plane."""
    from matplotlib.patches import Polygon, Rectangle

    half, extent = 0.5 * MM * design.ground_plane_m, MM * _extent_m(design)
    r_a, foot = MM * design.antenna_radius_m, _foot_mm(design)
    axis_mm, (reach, rim_mm) = float(outline_mm[0, 1]), outline_mm[-1].tolist()
    top = max(foot + length_mm, float(outline_mm[:, 1].max()))
    down = -0.35 * extent  # the ground plane's height on the view
    ax.text(
        0.0,
        extent * 1.29,
        "side view, plates turned into the plane",
        ha="center",
        fontsize=9,
        fontweight="bold",
    )
    ax.add_patch(Rectangle((-half, down - 1.2), 2.0 * half, 1.2, facecolor=INK, edgecolor=INK))
    if max(rim_mm, axis_mm) > 0.0:
        for side in (-1.0, 1.0):
            corners = [(0.0, 0.0), (reach, 0.0), *outline_mm[::-1].tolist()]
            shape = [(side * x, y + down) for x, y in corners]
            ax.add_patch(Polygon(shape, facecolor=METAL, edgecolor=PLATE, linewidth=1.0))
        _dimension(ax, (0, down), (0, down + axis_mm), away=(0, 0), text=_mm(axis_mm))
        _dimension(
            ax, (0, down), (reach, down), away=(0, -0.16 * extent), text=f"plate {_mm(reach)}"
        )
        for x, y in outline_mm[1:-1].tolist():
            _dimension(ax, (x, down), (x, down + y), away=(0, 0), text=_mm(y))
        left = (-reach, down), (-reach, down + rim_mm)
        _dimension(ax, *left, away=(reach - extent * 1.12, 0), text=f"rim {_mm(rim_mm)}")
    for side in (-1.0, 1.0):
        _draw_antenna(ax, design, side * r_a, down + foot, length_mm)
    low, high = (r_a, down + foot), (r_a, down + foot + length_mm)
    _dimension(ax, low, high, away=(extent * 1.15 - r_a, 0), text=_mm(length_mm))
    if own := _own_plane_mm(design):
        ends = (-r_a - 0.5 * own, down + foot), (-r_a + 0.5 * own, down + foot)
        _dimension(ax, *ends, away=(0.0, -0.5 * foot), text=f"own plane {_mm(own)}")
    if foot > 0.0:
        ax.annotate(
            f"gap {_mm(foot)}",
            xy=(r_a, down + 0.5 * foot),
            xytext=(extent * 1.02, down - 0.2 * extent),
            fontsize=7.5,
            color=DIMENSION,
            arrowprops={"arrowstyle": "-|>", "color": DIMENSION, "linewidth": 0.6},
        )
    _dimension(ax, (0, down), (-r_a, down), away=(0, -0.16 * extent), text=f"$r_a$ {_mm(r_a)}")
    highest = (-half, down), (-half, down + top)
    _dimension(ax, *highest, away=(half - extent * 1.28, 0), text=f"overall {_mm(top)}")
    ax.plot(
        (0, 0),
        (down - 0.05 * extent, down + top + 0.08 * extent),
        color=INK,
        linewidth=0.4,
        linestyle="-.",
    )
    ax.annotate(
        f"feed {_mm(MM * design.feed_gap_m)}, {design.load_ohm:g} Ω",
        xy=(r_a, down + foot + (0.5 * length_mm if design.antenna == "dipole" else 0.0)),
        xytext=(extent * 0.55, down + top + 0.25 * extent),
        fontsize=7.5,
        color=WIRE,
        arrowprops={"arrowstyle": "-|>", "color": WIRE, "linewidth": 0.6},
    )


def _draw_antenna(
    ax: "Axes", design: Reader, x_mm: float, foot_mm: float, length_mm: float
) -> None:
    feed = max(MM * design.feed_gap_m, 1.0)
    wide = max(2.0 * MM * design.wire_radius_m, 1.2)
    start = foot_mm + (0.5 * (length_mm - feed) if design.antenna == "dipole" else 0.0)
    parts = [(foot_mm, start), (start + feed, foot_mm + length_mm)]
    for low, high in parts:
        ax.add_patch(_bar(x_mm, wide, low, high))
    ax.plot(
        x_mm,
        start + 0.5 * feed,
        marker="o",
        markersize=3.2,
        color="white",
        zorder=7,
        markeredgecolor=WIRE,
    )
    if own := _own_plane_mm(design):
        ax.plot((x_mm - 0.5 * own, x_mm + 0.5 * own), (foot_mm, foot_mm), color=INK, linewidth=1.4)


def _bar(x_mm: float, wide_mm: float, low_mm: float, high_mm: float) -> "Rectangle":
    from matplotlib.patches import Rectangle

    corner = (x_mm - 0.5 * wide_mm, low_mm)
    return Rectangle(corner, wide_mm, high_mm - low_mm, facecolor=WIRE, edgecolor="none", zorder=6)


def _foot_mm(design: Reader) -> float:
    """Return the height of an antenna's lower end above the ground plane [mm]."""
    joined = design.antenna == "monopole" and design.monopole_plane_m == 0.0
    return 0.0 if joined else MM * design.gap_m


def _mm(value: float) -> str:
    """Return a length with a tenth of a millimetre where it has one."""
    return f"{value:.1f}".removesuffix(".0")


def _parts(design: Reader, length_mm: float, frequency_hz: float) -> list[tuple[str, str]]:
    """Return the parts list: names and what to make."""
    half = 0.5 * MM * design.ground_plane_m
    plane = {
        "square": f"square, side {_mm(2 * half)}",
        "round": f"disc, diameter {_mm(2 * half)}",
        "octagon": f"octagon, {_mm(2 * half)} across flats, "
        f"side {_mm(2 * half * math.tan(math.pi / 8))}, a flat under antenna 1",
    }[design.ground_plane_shape]
    body = design.body()
    axis, rim = MM * body.plate_height_axis_m, MM * body.plate_height_m
    parts = [("ground plane", f"1, {plane}, thin sheet")]
    if body.has_plates:
        between = "".join(f"{_mm(y)} at {_mm(x)}, " for x, y in MM * body.plate_outline_m[1:-1])
        plates = (
            f"{design.antennas}, thin sheet, {_mm(MM * body.plate_outer_radius_m)} long, "
            f"{_mm(axis)} high at the axis, {between}{_mm(rim)} at the rim; joined to the plane "
            "and to each other"
        )
        parts.append(("plates", plates))
    arms = ""
    if design.antenna == "dipole":
        arms = f", two arms of {0.5 * (length_mm - MM * design.feed_gap_m):.2f} about the feed"
    radius = MM * design.wire_radius_m
    antennas = (
        f"{design.antennas} {design.antenna}s, {_mm(length_mm)} over all{arms}, wire Ø "
        f"{_mm(2.0 * radius)} or strip {_mm(4.0 * radius)} wide, lower end "
        f"{_mm(_foot_mm(design))} above the plane"
    )
    if own := _own_plane_mm(design):
        planes = (
            f"{design.antennas}, square, side {_mm(own)}, turned to the radius, "
            f"{_mm(_foot_mm(design))} above the plane, not joined to it, held by an insulator"
        )
        parts.append(("own planes", planes))
    parts.append(("antennas", antennas))
    loads = design.loads_text().replace(" (reader.feed)", "").replace("ohm", "Ω")
    how = "balanced"
    if design.antenna != "dipole":
        on = "the middle of its own plane" if own else "the ground plane"
        how = f"between {on} and the wire's foot"
    feed = f"{_mm(MM * design.feed_gap_m)} long, {how}, each into {loads}"
    parts.append(("feeds", feed))
    if design.line is not None and design.line.match:
        parts.append(("networks", networks_text(design.line.match)))
    parts.append(("frequency", f"{frequency_hz / 1e9:g} GHz"))
    return parts


def _title_block(
    figure: "Figure", parts: list[tuple[str, str]], *, title: str, scale: float
) -> None:
    from matplotlib.patches import Rectangle

    w, h = PAPER_MM
    ax = figure.add_axes((0.0, 0.0, 1.0, 1.0), zorder=-1)
    ax.set_xlim(0.0, w)
    ax.set_ylim(0.0, h)
    ax.set_axis_off()
    ax.add_patch(Rectangle((6, 6), w - 12, h - 12, fill=False, edgecolor=INK, linewidth=1.0))
    ax.add_patch(Rectangle((6, 6), w - 12, 48, fill=False, edgecolor=INK, linewidth=1.0))
    ax.plot((216, 216), (6, 54), color=INK, linewidth=0.8)
    rows = [
        ("" if k else name, line)
        for name, text in parts
        for k, line in enumerate(wrap(text, ROW_LETTERS, break_on_hyphens=False))
    ]
    step = min(8.0, 38.0 / max(len(rows) - 1, 1))
    for i, (name, text) in enumerate(rows):
        y = 47.5 - step * i
        ax.text(10, y, name, fontsize=7.5, fontweight="bold", va="center")
        ax.text(36, y, text, fontsize=7.5, va="center")
    lines = (
        (title, 10.0, "bold"),
        ("bearing-sensitive reader", 8.0, "normal"),
        (f"all lengths in mm, scale 1:{scale:g} on A4", 8.0, "normal"),
        ("sheets have no thickness in the model", 8.0, "normal"),
    )
    for i, (text, size, weight) in enumerate(lines):
        ax.text(220, 46.5 - 10.5 * i, text, fontsize=size, fontweight=weight, va="center")
