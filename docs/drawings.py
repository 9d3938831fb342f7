"""The drawings of the concepts: ``python docs/drawings.py [FOLDER]`` draws them, light and dark.

The builds draw them when this file has changed. What has axes is computed here from the formulas
that the pages state, not sketched.
"""

import hashlib
import math
import sys
from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, Rectangle, Wedge

from octant.reader_design.showing.style import ANTENNA_COLOURS, figure_style

LIGHT = {"ink": "#222222", "soft": "#777777", "paper": "#ffffff", "fill": "#e8eef3"}
DARK = {"ink": "#e8e8e8", "soft": "#9a9a9a", "paper": "#131416", "fill": "#26323a"}
GOOD, BAD, WAVE, TAG = "#2b9348", "#d1495b", "#1f77b4", "#e09f3e"
AZIMUTHS = np.radians(np.arange(8) * 45.0)
WAVELENGTH_M = 299_792_458.0 / 2.4e9
Palette = dict[str, str]


def plain_axes(axes: Axes) -> None:
    """Make a plan: equal scales and no frame.

    Parameters
    ----------
    axes : Where it is drawn.
    """
    axes.set_aspect("equal")
    axes.axis("off")


def arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], **look: object) -> None:
    """Draw an arrow from one point to another.

    Parameters
    ----------
    axes, start, end : Where, from and to.
    **look : Of matplotlib's arrows.
    """
    given = {"arrowstyle": "-|>", "shrinkA": 0, "shrinkB": 0, "linewidth": 1.6} | look
    axes.annotate("", end, start, arrowprops=given)


def rss_of(bearing_rad: float, beam: float = 1.6) -> np.ndarray:
    """Return the RSS of eight antennas for a wave from a direction, the greatest near 1 [-].

    Parameters
    ----------
    bearing_rad, beam : Where the wave comes from [rad]; how narrow each antenna's beam is [-].
    """
    return np.asarray(((1.03 + np.cos(AZIMUTHS - bearing_rad)) / 2.03) ** (2.0 * beam))


def reader_plan(axes: Axes, colours: Palette, *, scale: float = 1.0, numbers: bool = True) -> None:
    """Draw the reader from above: ground plane, plates, antennas; antenna 3 is the front.

    Parameters
    ----------
    axes, colours, scale, numbers : Where and how; size [-]; whether antennas have numbers.
    """
    axes.add_patch(Circle((0, 0), scale, facecolor=colours["fill"], edgecolor=colours["soft"]))
    for k in range(8):
        turn = AZIMUTHS[k] + math.radians(22.5)
        axes.plot(
            [0, scale * math.cos(turn)], [0, scale * math.sin(turn)], color=colours["soft"], lw=2.2
        )
        x, y = 0.68 * scale * math.cos(AZIMUTHS[k]), 0.68 * scale * math.sin(AZIMUTHS[k])
        axes.add_patch(Circle((x, y), 0.085 * scale, color=ANTENNA_COLOURS[k], zorder=3))
        if numbers:
            axes.text(
                1.36 * x, 1.36 * y, str(k + 1), ha="center", va="center", color=colours["ink"]
            )


def reader_and_bearing(colours: Palette) -> Figure:
    """Return the reader from above, a tag, and the RSS of its antennas as a rose.

    Parameters
    ----------
    colours : Of paper and ink.
    """
    figure = Figure(figsize=(7.6, 3.4))
    left, right = figure.subplots(1, 2, width_ratios=(1.25, 1))
    plain_axes(left)
    reader_plan(left, colours)
    bearing = math.radians(63.0)
    tag = (2.05 * math.cos(bearing), 2.05 * math.sin(bearing))
    left.plot(*tag, "s", color=TAG, ms=11)
    left.text(tag[0] + 0.16, tag[1], "tag", va="center", color=colours["ink"])
    arrow(left, tag, (1.08 * math.cos(bearing), 1.08 * math.sin(bearing)), color=WAVE)
    arrow(left, (0, 1.02), (0, 1.55), color=colours["soft"])
    left.text(-0.08, 1.62, "front", ha="center", color=colours["soft"])
    left.text(-1.12, -1.05, "antenna", ha="right", color=colours["soft"])
    arrow(left, (-1.1, -0.98), (-0.56, -0.54), color=colours["soft"], linewidth=0.9)
    left.text(1.2, -0.35, "metal plate", color=colours["soft"])
    arrow(left, (1.18, -0.3), (0.86, -0.36), color=colours["soft"], linewidth=0.9)
    left.set(xlim=(-2.2, 2.2), ylim=(-1.2, 2.1))
    left.set_title("The reader from above", color=colours["ink"])
    plain_axes(right)
    rss = rss_of(bearing)
    for k, power in enumerate(rss):
        turn = math.degrees(AZIMUTHS[k])
        right.add_patch(Wedge((0, 0), power, turn - 17, turn + 17, color=ANTENNA_COLOURS[k]))
        right.text(
            1.12 * math.cos(AZIMUTHS[k]), 1.12 * math.sin(AZIMUTHS[k]), str(k + 1),
            ha="center", va="center", color=colours["ink"],
        )  # fmt: skip
    total = (rss * np.exp(1j * AZIMUTHS)).sum()
    angle = float(np.angle(total))
    arrow(right, (0, 0), (1.45 * math.cos(angle), 1.45 * math.sin(angle)), color=colours["ink"])
    right.text(
        1.5 * math.cos(angle),
        1.5 * math.sin(angle),
        "vector sum",
        color=colours["ink"],
        va="bottom",
    )
    right.set(xlim=(-1.3, 2.0), ylim=(-1.3, 1.6))
    right.set_title("Received power, antenna by antenna", color=colours["ink"])
    return figure


def coherent_and_local_mean(colours: Palette) -> Figure:
    """Return the power along a line in a room with four mirror images, in two ways.

    Parameters
    ----------
    colours : Of paper and ink.
    """
    figure = Figure(figsize=(7.6, 3.2))
    axes = figure.subplots()
    x = np.linspace(0.5, 3.5, 1500)
    image = np.array(
        [[0, 0, 2.5], [0, 0, -2.5], [-4, 0, 2.5], [10, 0, 2.5], [0, 6, 2.5], [0, -5, 2.5]]
    )
    loss = np.array([1.0, 0.45, 0.4, 0.4, 0.35, 0.35])
    receiver = np.stack([x, np.zeros_like(x), np.full_like(x, 0.3)], axis=1)
    away = np.linalg.norm(receiver[:, None] - image[None], axis=2)
    field = loss * WAVELENGTH_M / (4 * math.pi * away)
    phase = np.exp(-2j * math.pi * away / WAVELENGTH_M)
    coherent = 30 + 20 * np.log10(np.abs((field * phase).sum(axis=1)))
    mean = 30 + 10 * np.log10((field**2).sum(axis=1))
    axes.plot(x, coherent, color=WAVE, label="coherent: fields added with their phases")
    axes.plot(x, mean, color=BAD, lw=2.4, label="local mean: powers added")
    axes.set(xlabel="way along the floor [m]", ylabel="received power [dBm]", xlim=(0.5, 3.5))
    axes.set_title("One direct ray and five reflections, 1 W at 2.4 GHz", color=colours["ink"])
    axes.legend(loc="lower left")
    return figure


def image_method(colours: Palette) -> Figure:
    """Return a room with the mirror images of a tag and the two reflected paths that they give.

    Parameters
    ----------
    colours : Of paper and ink.
    """
    figure = Figure(figsize=(7.6, 3.6))
    axes = figure.subplots()
    plain_axes(axes)
    axes.add_patch(
        Rectangle((0, 0), 4, 3, facecolor=colours["fill"], edgecolor=colours["ink"], lw=2)
    )
    for x0, y0 in ((4, 0), (0, 3), (4, 3)):
        axes.add_patch(
            Rectangle((x0, y0), 4, 3, fill=False, edgecolor=colours["soft"], ls=":", lw=1.0)
        )
    tag, robot = np.array([1.0, 2.2]), np.array([2.6, 0.8])
    once, twice = np.array([8 - tag[0], tag[1]]), np.array([8 - tag[0], 6 - tag[1]])
    for image, name in ((once, "image in one wall"), (twice, "image in two walls")):
        axes.plot(*image, "s", mfc="none", mec=TAG, ms=10)
        axes.text(image[0], image[1] + 0.22, name, ha="center", color=colours["soft"])
        axes.plot(*np.stack([robot, image]).T, ls="--", color=colours["soft"], lw=0.9)
    axes.plot(*np.stack([tag, robot]).T, color=GOOD, lw=1.8)
    t = (4 - robot[0]) / (once - robot)[0]
    axes.plot(*np.stack([robot, robot + t * (once - robot), tag]).T, color=WAVE, lw=1.8)
    way = twice - robot
    points, mirrored = [robot], (way / np.linalg.norm(way)).copy()
    a = robot + way * (4 - robot[0]) / way[0]
    mirrored[0] *= -1
    b = a + mirrored * (3 - a[1]) / mirrored[1]
    points += [a, b, tag]
    axes.plot(*np.stack(points).T, color=BAD, lw=1.8)
    axes.plot(*tag, "s", color=TAG, ms=10)
    axes.plot(*robot, "o", color=colours["ink"], ms=9)
    axes.text(tag[0] - 0.12, tag[1] + 0.2, "tag", ha="right", color=colours["ink"])
    axes.text(robot[0], robot[1] - 0.34, "robot", ha="center", color=colours["ink"])
    axes.set(xlim=(-0.2, 8.2), ylim=(-0.2, 6.1))
    axes.set_title("A reflected path unfolded is a straight line to an image", color=colours["ink"])
    return figure


def right_antenna_and_margin(colours: Palette) -> Figure:
    """Return two readings as bars: the right antenna leads, and a neighbour leads.

    Parameters
    ----------
    colours : Of paper and ink.
    """
    figure = Figure(figsize=(7.6, 3.1))
    right = 10 * np.log10(rss_of(math.radians(97.0), 1.4)) - 38.0
    wrong = right + np.array([1.5, -1.0, -4.5, 0.8, 3.4, 1.5, 0.6, 1.2])
    for axes, levels, good in zip(
        figure.subplots(1, 2, sharey=True), (right, wrong), (True, False), strict=True
    ):
        shown = [colours["soft"]] * 8
        shown[2] = GOOD if good else TAG
        best = int(np.argmax(levels))
        if not good:
            shown[best] = BAD
        axes.bar(
            np.arange(1, 9), np.maximum(levels, -62.0) + 65, bottom=-65, color=shown, width=0.7
        )
        rival = max(levels[1], levels[3])
        axes.plot([1.5, 5.6], [rival, rival], color=colours["ink"], lw=0.9, ls=":")
        axes.plot([2.6, 5.6], [levels[2]] * 2, color=colours["ink"], lw=0.9, ls=":")
        axes.annotate(
            "", (5.4, levels[2]), (5.4, rival),
            arrowprops={"arrowstyle": "<->", "color": colours["ink"], "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip
        axes.text(
            5.7, (levels[2] + rival) / 2, f"margin {levels[2] - rival:+.1f} dB",
            color=colours["ink"], va="center",
        )  # fmt: skip
        axes.set(xlabel="antenna (3 faces the tag)", xticks=np.arange(1, 9), ylim=(-65, -34))
        words = (
            "the right antenna leads" if good else f"antenna {best + 1} leads: not the right one"
        )
        axes.set_title(words, color=colours["ink"])
        if good:
            axes.set_ylabel("RSS [dBm]")
    return figure


def capture(colours: Palette) -> Figure:
    """Return a robot beside a metal cabinet whose reflection is stronger than the hidden tag.

    Parameters
    ----------
    colours : Of paper and ink.
    """
    figure = Figure(figsize=(7.6, 3.2))
    axes = figure.subplots()
    plain_axes(axes)
    wall = 3.0
    axes.add_patch(Rectangle((0, wall), 6.4, 0.28, facecolor=colours["soft"], edgecolor="none"))
    axes.text(0.1, wall + 0.4, "metal wall", color=colours["ink"])
    axes.add_patch(
        Rectangle((2.6, 1.1), 0.7, 0.9, facecolor=colours["fill"], edgecolor=colours["ink"])
    )
    axes.text(2.95, 0.85, "cabinet", ha="center", va="top", color=colours["ink"])
    tag, robot = np.array([1.0, 1.9]), np.array([5.2, 1.3])
    image = np.array([tag[0], 2 * wall - tag[1]])
    way = image - robot
    hit = robot + way * (wall - robot[1]) / way[1]
    axes.plot(*np.stack([tag, robot]).T, color=colours["soft"], ls="--", lw=1.4)
    axes.plot(*np.stack([tag, hit, robot]).T, color=BAD, lw=2.2)
    axes.plot(*np.stack([hit, image]).T, color=BAD, lw=0.9, ls=":")
    axes.plot(*image, "s", mfc="none", mec=TAG, ms=10)
    axes.text(
        image[0] + 0.2, image[1], "mirror image of the tag", va="center", color=colours["soft"]
    )
    axes.plot(*tag, "s", color=TAG, ms=10)
    axes.text(tag[0] - 0.18, tag[1], "tag", ha="right", va="center", color=colours["ink"])
    axes.plot(*robot, "o", color=colours["ink"], ms=10)
    arrow(
        axes, tuple(robot), tuple(robot + 0.75 * way / np.linalg.norm(way)), color=BAD, linewidth=3
    )
    axes.text(robot[0] + 0.2, robot[1], "robot", va="center", color=colours["ink"])
    axes.text(4.25, 1.2, "direct ray: weak", ha="center", va="top", color=colours["soft"])
    axes.text(4.55, 2.45, "reflection: strong", color=BAD, rotation=0)
    axes.set(xlim=(0, 7.2), ylim=(0.5, 4.5))
    axes.set_title(
        "Captured by a reflection: the strongest antenna points to the image", color=colours["ink"]
    )
    return figure


def under_the_tag(colours: Palette) -> Figure:
    """Return the patterns in elevation of three tags that hang over the robot.

    Parameters
    ----------
    colours : Of paper and ink.
    """
    figure = Figure(figsize=(7.6, 2.6))
    theta = np.radians(np.linspace(-90, 90, 721))
    size = 1.22 * math.pi
    from scipy.special import j1

    shapes = (
        (
            "dipole: no power straight down",
            np.cos(math.pi / 2 * np.cos(theta)) / (np.sin(theta) + 1e-12),
        ),
        ("conical_patch: a cone, vertical", j1(size * np.sin(theta)) / 0.582),
        ("patch: most power straight down", np.cos(math.pi / 2 * np.sin(theta)) * 1.0 + 0.0),
    )
    for axes, (title, field) in zip(figure.subplots(1, 3), shapes, strict=True):
        plain_axes(axes)
        power = field**2 / (field**2).max()
        axes.fill(power * np.sin(theta), -power * np.cos(theta), color=WAVE, alpha=0.45)
        axes.plot(power * np.sin(theta), -power * np.cos(theta), color=WAVE)
        axes.plot([-1.1, 1.1], [0, 0], color=colours["soft"], lw=2.5)
        axes.plot(0, 0, "s", color=TAG, ms=9)
        axes.plot([0, 0], [0, -1.15], color=colours["soft"], lw=0.9, ls=":")
        axes.plot(0, -1.2, "o", color=colours["ink"], ms=8)
        axes.set(xlim=(-1.15, 1.15), ylim=(-1.4, 0.12))
        axes.set_title(title, color=colours["ink"], fontsize=9)
    return figure


def bearing_angles(colours: Palette) -> Figure:
    """Return the room's and the robot's frames: heading, bearing, antenna azimuths.

    Parameters
    ----------
    colours : Of paper and ink.
    """
    figure = Figure(figsize=(5.6, 3.6))
    axes = figure.subplots()
    plain_axes(axes)
    arrow(axes, (-1.9, -1.3), (-1.0, -1.3), color=colours["soft"])
    arrow(axes, (-1.9, -1.3), (-1.9, -0.4), color=colours["soft"])
    axes.text(-0.95, -1.35, "x", color=colours["ink"])
    axes.text(-1.95, -0.32, "y", color=colours["ink"], ha="right")
    heading, tag = math.radians(30.0), math.radians(75.0)
    axes.add_patch(Circle((0, 0), 0.55, facecolor=colours["fill"], edgecolor=colours["soft"]))
    for k in range(8):
        turn = heading - math.pi / 2 + AZIMUTHS[k]
        axes.plot(0.42 * math.cos(turn), 0.42 * math.sin(turn), "o", color=ANTENNA_COLOURS[k], ms=5)
        place = (0.7 * math.cos(turn), 0.7 * math.sin(turn))
        middle = {"ha": "center", "va": "center", "fontsize": 8}
        axes.text(*place, str(k + 1), color=colours["soft"], **middle)
    arrow(axes, (0, 0), (1.7 * math.cos(heading), 1.7 * math.sin(heading)), color=colours["ink"])
    axes.text(
        1.75 * math.cos(heading),
        1.75 * math.sin(heading),
        "front (antenna 3)",
        color=colours["ink"],
    )
    end = (1.9 * math.cos(tag), 1.9 * math.sin(tag))
    axes.plot([0, end[0]], [0, end[1]], color=WAVE, lw=1.6)
    axes.plot(*end, "s", color=TAG, ms=10)
    axes.plot([0, 2.1], [0, 0], color=colours["soft"], ls=":", lw=1)
    axes.add_patch(Arc((0, 0), 2.3, 2.3, theta1=0, theta2=30, color=colours["ink"]))
    axes.text(1.2, 0.25, "heading", color=colours["ink"])
    axes.add_patch(Arc((0, 0), 2.6, 2.6, theta1=30, theta2=75, color=WAVE, lw=1.6))
    axes.text(0.86, 1.08, "bearing", color=WAVE)
    axes.set(xlim=(-2.2, 3.2), ylim=(-1.5, 2.1))
    return figure


DRAWINGS: tuple[Callable[[Palette], Figure], ...] = (
    reader_and_bearing,
    bearing_angles,
    coherent_and_local_mean,
    image_method,
    right_antenna_and_margin,
    capture,
    under_the_tag,
)


def draw_all(folder: Path) -> None:
    """Write every drawing as ``NAME.light.svg`` and ``NAME.dark.svg`` where it is out of date.

    Parameters
    ----------
    folder : Where they are written.
    """
    stamp, now = folder / "drawings.stamp", hashlib.sha256(Path(__file__).read_bytes()).hexdigest()
    if stamp.exists() and stamp.read_text("utf-8") == now:
        return
    folder.mkdir(parents=True, exist_ok=True)
    for draw in DRAWINGS:
        for name, colours in (("light", LIGHT), ("dark", DARK)):
            with figure_style(), mpl.rc_context(_look(colours)):
                figure = draw(colours)
                file = folder / f"{draw.__name__}.{name}.svg"
                figure.savefig(file, format="svg", metadata={"Date": None}, bbox_inches="tight")
    stamp.write_text(now, "utf-8")


def _look(colours: Palette) -> dict[str, object]:
    ink, paper = colours["ink"], colours["paper"]
    keys = (
        "text.color",
        "axes.labelcolor",
        "axes.titlecolor",
        "xtick.labelcolor",
        "ytick.labelcolor",
    )
    return dict.fromkeys(keys, ink) | {
        "figure.facecolor": paper,
        "savefig.facecolor": paper,
        "axes.facecolor": paper,
        "grid.color": colours["fill"],
        "svg.hashsalt": "octant",
        "svg.fonttype": "path",
    }


if __name__ == "__main__":
    draw_all(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "generated")
