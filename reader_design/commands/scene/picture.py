"""A picture of a room in three dimensions: cut open towards the viewer, with tags and paths."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, get_args

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.geometries.scene import Scene
from octant.reader_design.commands.scene.drawing import ColourBy, DrawnPaths, SceneDrawing
from octant.reader_design.commands.scene.faces import scene_faces
from octant.reader_design.showing.style import figure_style, math_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

PAGE = (1.0, 0.88)
"""Width and height of the page's free part [-], over the diagonal that Matplotlib gives a box."""


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """Where the viewer stands, far away.

    Parameters
    ----------
    azimuth_deg : float
        From +x towards +y [deg].
    elevation_deg : float
        Above the horizon [deg], more than 0 and at most 90.
    """

    azimuth_deg: float = -60.0
    elevation_deg: float = 35.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.azimuth_deg) and 0.0 < self.elevation_deg <= 90.0):
            msg = (
                f"the view from azimuth {self.azimuth_deg} and elevation {self.elevation_deg} "
                "degrees is none; give an elevation above 0 and up to 90 degrees."
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
    """Return a picture of a room with everything in it, axes in [m] and equal.

    Parameters
    ----------
    scene : Scene
        Room and objects.
    title : str
        Above the picture.
    tags : mapping of str to (3,) float64
        Names and places of the tags [m].
    ends_m : mapping of str to (3,) float64, optional
        ``transmitter`` and ``receiver`` [m].
    reader_m : (t, 3, 3) float64, optional
        Triangles of the reader's body in the room [m].
    paths : DrawnPaths, optional
        Paths between the ends.
    colour_by : {"gain", "order"}
        What their colour tells.
    view : View, optional
        From where it is seen.

    Returns
    -------
    Figure
        Orthographic. Walls between the viewer and the room are cut away but for their rims; what an
        object hides of a path is drawn thin.

    Raises
    ------
    ConfigError
        When ``colour_by`` is unknown.
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
    """Return equal three-dimensional axes around a scene and points, without panes."""
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
    """Return how much larger than by default a box may be drawn to fill the page, labels included.

    Matplotlib draws a box of any size with the same diagonal; its outline from this view decides.
    """
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
