"""A picture of a room in three dimensions: cut open towards the viewer, with tags and paths."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from octant.geometries.appearance import looks_of
from octant.geometries.errors import ConfigError
from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS
from octant.reader_design.showing.plan import TAG_COLOUR
from octant.reader_design.showing.scene_faces import Face, hidden_points, scene_faces
from octant.reader_design.showing.style import figure_style, math_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]


ColourBy = Literal["gain", "order"]

ORDER_COLOURS = ("#332288", "#cc6677", "#117733", "#ddaa33", "#88ccee", "#aa4499", "#999933")
"""One colour for each order of a path, line of sight first."""
GAIN_SPAN_DB = 40.0
"""Greatest span of the colour bar of gains [dB], down from the strongest path."""
PIECES_PER_EXTENT = 80
"""Pieces [-] into which a line across the whole room is cut to find what is hidden."""

_TX_COLOUR, _RX_COLOUR, _READER_COLOUR = "#0b7a75", "#1f4e9c", "#444444"


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawnPaths:
    """Paths to be drawn, strongest first.

    Parameters
    ----------
    vertices_m : Source, interactions and receiver of each path [m].
    gain_db, order : (k,) — Gain [dB] and number of interactions [-] of each path.
    of : Number of paths from which these are the strongest.
    """

    vertices_m: tuple[FloatArray, ...]
    gain_db: FloatArray
    order: npt.NDArray[np.int64]
    of: int


def short_material(label: str) -> str:
    """Return the label of a material as a person would say it, such as "glass 6 mm".

    Parameters
    ----------
    label : Of a body.
    """
    named = re.fullmatch(r"(?:name = )?([^,=]+?)(?:, thickness_m = ([\d.e-]+))?", label)
    if named is None:
        return label
    return named[1] if named[2] is None else f"{named[1]} {1e3 * float(named[2]):g} mm"


class SceneDrawing:
    """What is drawn into empty axes, from back to front; ``towards`` points to the viewer."""

    def __init__(
        self,
        axes: Any,  # noqa: ANN401
        scene: Scene,
        faces: list[Face],
        towards: FloatArray,
    ) -> None:
        self.axes = axes
        self.faces = faces
        self.towards = towards
        self.piece_m = scene.extent_m / PIECES_PER_EXTENT
        self.marks: list[Any] = []
        self.orders: list[Any] = []
        self.mappable: Any = None
        self.extend = "neither"

    def walls(self) -> None:
        """Draw what closes the room: translucent, or cut away but for its rim."""
        for face in self.faces:
            if not face.wall:
                continue
            if not face.cut_away:
                self._fill([face], alpha=0.42, zorder=1.0)
                self._rim(face.rim_m, colour="#5a5a5a", width=0.9, zorder=1.5)
        for face in self.faces:
            if face.wall and face.cut_away:
                self._rim(face.rim_m, colour="#9a9a9a", width=0.6, zorder=4.5)

    def objects(self) -> None:
        """Draw furniture and inner sheets, shaded, with the edges that are seen."""
        inner = [face for face in self.faces if not face.wall]
        self._fill(inner, alpha=1.0, zorder=3.0)
        for face in inner:
            middle, legs = self._pieces(face.rim_m)
            shown = ~hidden_points(self.faces, middle + LENGTHS.step_m * self.towards, self.towards)
            self._rim(legs[shown], colour="#2e2e2e", width=0.7, zorder=3.5)

    def reader(self, triangles_m: FloatArray) -> None:
        """Draw the reader's body.

        Parameters
        ----------
        triangles_m : (t, 3, 3) float64 — Its triangles in the room [m].
        """
        from matplotlib.lines import Line2D
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection

        self._add(
            Poly3DCollection(
                triangles_m,
                facecolors=_READER_COLOUR,
                edgecolors="#bbbbbb",
                linewidths=0.1,
                alpha=0.95,
                zorder=5.5,
            )
        )
        self.marks.append(
            Line2D([], [], marker="s", color=_READER_COLOUR, linestyle="", label="reader")
        )

    def paths(self, paths: DrawnPaths, colour_by: ColourBy) -> None:
        """Draw paths, weak ones first; what objects hide is thin.

        Parameters
        ----------
        paths, colour_by : The paths [m]; their colour shows "gain" or "order".
        """
        from matplotlib.lines import Line2D

        if colour_by == "gain":
            colours = self._gain_colours(paths)
        else:
            colours = [ORDER_COLOURS[min(n, len(ORDER_COLOURS) - 1)] for n in paths.order]
            for n in np.unique(paths.order):
                name = "line of sight" if n == 0 else f"order {n}"
                colour = ORDER_COLOURS[min(int(n), len(ORDER_COLOURS) - 1)]
                self.orders.append(Line2D([], [], color=colour, linewidth=2.0, label=name))
        for k in range(len(paths.order))[::-1]:
            vertices = paths.vertices_m[k]
            middle, legs = self._pieces(np.stack((vertices[:-1], vertices[1:]), axis=1))
            hidden = hidden_points(self.faces, middle, self.towards)
            self._rim(legs[~hidden], colour=colours[k], width=1.5, zorder=5.0, alpha=0.95)
            self._rim(legs[hidden], colour=colours[k], width=0.6, zorder=4.0, alpha=0.6)

    def tags(self, tags: Mapping[str, FloatArray]) -> None:
        """Draw tags with their names.

        Parameters
        ----------
        tags : Names and places [m].
        """
        from matplotlib.patheffects import withStroke

        halo = [withStroke(linewidth=2.5, foreground="white")]
        floor = self.axes.get_zlim()[0]
        for name, place in tags.items():
            x, y, z = (float(c) for c in place)
            self.axes.plot(
                [x, x], [y, y], [floor, z], ":", color=TAG_COLOUR, linewidth=0.8, zorder=6
            )
            self._mark(place, colour=TAG_COLOUR, marker="v", size=8, label="tag")
            self.axes.text(
                x, y, z, f"  {name}", fontsize=8, color="#222222", zorder=8, path_effects=halo
            )

    def ends(self, ends_m: Mapping[str, FloatArray]) -> None:
        """Draw transmitter and receiver.

        Parameters
        ----------
        ends_m : ``transmitter`` and ``receiver`` [m].
        """
        looks = {"transmitter": (_TX_COLOUR, "*", 13), "receiver": (_RX_COLOUR, "o", 8)}
        for name, place in ends_m.items():
            colour, marker, size = looks[name]
            self._mark(place, colour=colour, marker=marker, size=size, label=name)

    def handles(self) -> list[Any]:
        """Return what the legend shows: marks, orders of paths, materials."""
        from matplotlib.patches import Patch

        marks = {mark.get_label(): mark for mark in self.marks}
        names = dict.fromkeys(face.material for face in self.faces)
        patches = [
            Patch(
                facecolor=looks_of(name).colour,
                edgecolor="#555555",
                linewidth=0.6,
                label=short_material(name),
            )
            for name in names
        ]
        return [*marks.values(), *self.orders, *patches]

    def _mark(self, place: FloatArray, *, colour: str, marker: str, size: int, label: str) -> None:
        x, y, z = (float(c) for c in place)
        floor = self.axes.get_zlim()[0]
        self.axes.plot([x, x], [y, y], [floor, z], ":", color=colour, linewidth=0.8, zorder=6)
        self.marks += self.axes.plot(
            [x],
            [y],
            [z],
            marker,
            color=colour,
            markersize=size,
            markeredgecolor="white",
            markeredgewidth=0.9,
            label=label,
            zorder=7,
        )

    def _gain_colours(self, paths: DrawnPaths) -> list[str | tuple[float, ...]]:
        from matplotlib import colormaps
        from matplotlib.cm import ScalarMappable
        from matplotlib.colors import ListedColormap, Normalize

        finite = paths.gain_db[np.isfinite(paths.gain_db)]
        high = float(finite.max()) if finite.size else 0.0
        low = max(float(finite.min()), high - GAIN_SPAN_DB) if finite.size else -GAIN_SPAN_DB
        self.extend = "min" if (paths.gain_db < low).any() else "neither"
        # The palest end of plasma would be lost on the white page.
        chosen = ListedColormap(colormaps["plasma_r"](np.linspace(0.12, 1.0, 256)))
        norm = Normalize(low - 1e-3, high)
        self.mappable = ScalarMappable(norm=norm, cmap=chosen)
        return [tuple(chosen(norm(max(g, low)))) for g in paths.gain_db]

    def _fill(self, faces: Sequence[Face], *, alpha: float, zorder: float) -> None:
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection

        if not faces:
            return
        light = np.array([0.35, -0.45, 0.82])
        polygons: list[FloatArray] = []
        colours: list[tuple[float, ...]] = []
        for face in faces:
            looks = looks_of(face.material)
            shade = 0.72 + 0.28 * max(float(face.normal @ light), 0.0)
            opacity = alpha * looks.opacity
            polygons += face.outlines_m
            tint = (*(shade * c for c in looks.colour), opacity)
            colours += [tint] * len(face.outlines_m)
        self._add(
            Poly3DCollection(
                polygons,
                facecolors=colours,
                edgecolors="none",
                antialiased=alpha >= 1.0,
                zorder=zorder,
            )
        )

    def _add(self, collection: Any) -> None:  # noqa: ANN401  a matplotlib collection
        collection.set_clip_on(False)  # the picture may be larger than its axes
        self.axes.add_collection3d(collection, autolim=False)

    def _rim(
        self,
        legs_m: FloatArray,
        *,
        colour: str | tuple[float, ...],
        width: float,
        zorder: float,
        alpha: float = 1.0,
    ) -> None:
        from mpl_toolkits.mplot3d.art3d import Line3DCollection

        if len(legs_m):
            self._add(
                Line3DCollection(
                    list(legs_m),
                    colors=[colour],
                    linewidths=width,
                    alpha=alpha,
                    zorder=zorder,
                    capstyle="round",
                )
            )

    def _pieces(self, legs_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return middles (k, 3) and ends (k, 2, 3) of short pieces of legs [m]."""
        if len(legs_m) == 0:
            return np.zeros((0, 3)), np.zeros((0, 2, 3))
        pieces = []
        for start, end in legs_m:
            count = max(1, int(np.ceil(np.linalg.norm(end - start) / self.piece_m)))
            points = start + np.linspace(0.0, 1.0, count + 1)[:, None] * (end - start)
            pieces.append(np.stack((points[:-1], points[1:]), axis=1))
        legs = np.concatenate(pieces)
        return legs.mean(axis=1), legs


PAGE = (1.0, 0.88)
"""Width and height of the page's free part [-], over the diagonal that Matplotlib gives a box."""


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """Where the viewer stands, far away.

    Parameters
    ----------
    azimuth_deg, elevation_deg : From +x towards +y; above the horizon, in (0, 90] [deg].
    """

    azimuth_deg: float = -60.0
    elevation_deg: float = 35.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.azimuth_deg) and 0.0 < self.elevation_deg <= 90.0):
            msg = (
                f"the view from azimuth {self.azimuth_deg} and elevation {self.elevation_deg} "
                "degrees is not possible; give an elevation above 0 and up to 90 degrees."
            )
            raise ConfigError(msg)

    @property
    def towards(self) -> FloatArray:
        """Unit vector [-] from the scene to the viewer, (3,)."""
        azimuth, elevation = np.radians([self.azimuth_deg, self.elevation_deg])
        level = np.cos(elevation)
        return np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])


def scene_figure(
    scene: Scene,
    *,
    title: str,
    tags: Mapping[str, FloatArray],
    ends_m: Mapping[str, FloatArray] | None = None,
    reader_m: FloatArray | None = None,
    paths: DrawnPaths | None = None,
    colour_by: ColourBy = "gain",
    view: View | None = None,
) -> "Figure":
    """Return an orthographic picture of a room with everything in it, axes in [m] and equal.

    Walls between the viewer and the room are cut away but for their rims; what an object hides of a
    path is drawn thin.

    Parameters
    ----------
    scene : Room and objects.
    title : Above the picture.
    tags, ends_m : Places of the tags by name; of ``transmitter`` and ``receiver`` [m].
    reader_m : (t, 3, 3) float64 — Triangles of the reader's body in the room [m].
    paths, colour_by : Paths between the ends; their colour shows "gain" or "order".
    view : From where it is seen.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    if colour_by not in get_args(ColourBy):
        msg = f"paths can be coloured by {' or '.join(get_args(ColourBy))}, not by {colour_by!r}."
        raise ConfigError(msg)
    seen = view or View()
    faces = scene_faces(scene, seen.towards)
    with figure_style():
        figure = Figure(figsize=(10.4, 7.0))
        figure.set_layout_engine("none")
        FigureCanvasAgg(figure)
        figure.suptitle(
            math_text(title), x=0.015, y=0.985, ha="left", fontsize=12, fontweight="bold"
        )
        axes = _empty_axes(figure, scene, [*tags.values(), *(ends_m or {}).values()], seen)
        drawing = SceneDrawing(axes, scene, faces, seen.towards)
        drawing.walls()
        drawing.objects()
        if reader_m is not None:
            drawing.reader(reader_m)
        if paths is not None:
            drawing.paths(paths, colour_by)
        drawing.tags(tags)
        drawing.ends(ends_m or {})
        figure.legend(
            handles=drawing.handles(),
            loc="upper right",
            bbox_to_anchor=(0.99, 0.94),
            handlelength=1.4,
            labelspacing=0.6,
        )
        if drawing.mappable is not None:
            place = figure.add_axes((0.915, 0.08, 0.014, 0.36))
            bar = figure.colorbar(drawing.mappable, cax=place, extend=drawing.extend)
            bar.set_label("gain between the antennas [dB]")
            bar.outline.set_visible(False)
    return figure


def _empty_axes(figure: Any, scene: Scene, points: Sequence[FloatArray], view: View) -> Any:  # noqa: ANN401
    corners = [scene.bounds_m] if scene.bodies else []
    around = np.concatenate([*corners, *(np.atleast_2d(p) for p in points)])
    low, high = around.min(axis=0), around.max(axis=0)
    if not scene.bodies:
        low, high = low - 0.5, high + 0.5
    high = np.maximum(high, low + 0.05 * float((high - low).max()))
    axes = figure.add_axes((-0.03, 0.02, 0.86, 0.94), projection="3d", computed_zorder=False)
    axes.set_proj_type("ortho")
    axes.view_init(elev=view.elevation_deg, azim=view.azimuth_deg)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_zlim(low[2], high[2])
    axes.set_box_aspect(high - low, zoom=_zoom(high - low, view))
    for axis, name in ((axes.xaxis, "x"), (axes.yaxis, "y"), (axes.zaxis, "z")):
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.line.set_color("#999999")
        axis.set_label_text(f"{name} [m]")
        axis.set_major_locator(_metres(float((high - low).max())))
    axes.grid(visible=False)
    return axes


def _zoom(size_m: FloatArray, view: View) -> float:
    """Return how much larger than Matplotlib's fixed diagonal a box is drawn to fill the page."""
    azimuth, elevation = np.radians([view.azimuth_deg, view.elevation_deg])
    right = np.array([np.sin(azimuth), np.cos(azimuth), 0.0])
    up = np.array(
        [
            np.sin(elevation) * np.cos(azimuth),
            np.sin(elevation) * np.sin(azimuth),
            np.cos(elevation),
        ]
    )
    unit = size_m / np.linalg.norm(size_m)
    width, height = float(unit @ np.abs(right)), float(unit @ np.abs(up))
    return min(PAGE[0] / width, PAGE[1] / height)


def _metres(extent_m: float) -> Any:  # noqa: ANN401  a matplotlib locator
    from matplotlib.ticker import MultipleLocator

    steps = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0)
    return MultipleLocator(next((s for s in steps if extent_m / s <= 8.0), 1000.0))
