"""The workshop's drawing as DXF: real millimetres, layers by what a line is, true dimensions."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from octant.geometries.errors import ConfigError
from octant.geometries.files import whole_file
from octant.reader_design.showing.workshop import (
    DIMENSION,
    DIMENSION_LINE,
    DIMENSION_TEXT,
    INK,
    PAPER_MM,
    PLATE,
    WIRE,
)

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LAYERS: dict[str, tuple[str, int]] = {
    INK: ("OUTLINE", 7),
    PLATE: ("PLATES", 8),
    WIRE: ("ANTENNAS", 1),
    DIMENSION: ("DIMENSIONS", 5),
}
"""Layer and its AutoCAD colour by the colour of the drawing."""
_OTHER = ("NOTES", 7)
_TEXT_MM_PER_POINT = 0.25
_MARKER_MM = 0.5


def check_dxf() -> None:
    """Refuse DXF where the package that writes it is missing."""
    _ezdxf()


def write_dxf(figure: "Figure", path: Path, *, scale: float) -> None:
    """Write a drawing of `workshop.drawing` as DXF of version R2010 in real millimetres.

    Views stand as on the sheet; every dimension is a DIMENSION, which CAD programs measure.

    Parameters
    ----------
    figure, scale : The drawing, and the scale that it has (real lengths over those of the
        sheet) [-].
    path : The file, replaced where it exists.
    """
    ezdxf = _ezdxf()
    document = ezdxf.new("R2010", setup=True, units=4)
    document.header["$INSUNITS"] = 4
    # Same drawing, same bytes: no times, no random names.
    for key in ("$TDCREATE", "$TDUCREATE", "$TDUPDATE", "$TDUUPDATE"):
        document.header[key] = 2451544.5
    for name, colour in (*LAYERS.values(), _OTHER):
        if name not in document.layers:
            document.layers.add(name, color=colour)
    space = document.modelspace()
    for ax in figure.axes:
        _write_axes(space, ax, scale)
    with whole_file(path) as part:
        document.saveas(part)


def _ezdxf() -> Any:  # noqa: ANN401  an optional module
    try:
        import ezdxf
    except ImportError as exc:
        msg = 'DXF files are written by ezdxf; install it: pip install "octant[cad]".'
        raise ConfigError(msg) from exc
    ezdxf.options.write_fixed_meta_data_for_testing = True
    return ezdxf


def _write_axes(space: Any, ax: "Axes", scale: float) -> None:  # noqa: ANN401  ezdxf's own
    """Write what stands on axes whose units are millimetres: real ones, or those of the sheet."""
    box = ax.get_position()
    corner = scale * np.array([box.x0 * PAPER_MM[0], box.y0 * PAPER_MM[1]])
    (x0, x1), y0 = ax.get_xlim(), ax.get_ylim()[0]
    stretch = scale * box.width * PAPER_MM[0] / (x1 - x0)

    def placed(points: Any) -> list[tuple[float, float]]:  # noqa: ANN401  any points
        moved = corner + stretch * (np.asarray(points, dtype=float).reshape(-1, 2) - (x0, y0))
        return [(float(x), float(y)) for x, y in moved]

    for patch in ax.patches:
        _write_patch(space, patch, placed, stretch)
    for line in ax.lines:
        points = placed(np.column_stack([line.get_xdata(), line.get_ydata()]))
        layer = {"layer": _layer(line.get_color())}
        if len(points) == 1:
            space.add_circle(points[0], _MARKER_MM * stretch, dxfattribs=layer)
            continue
        if line.get_linestyle() == "-.":
            layer["linetype"] = "CENTER"
        space.add_lwpolyline(points, dxfattribs=layer)
    texts = {str(text.get_gid()): text for text in ax.texts}
    for gid, text in texts.items():
        if gid.startswith(DIMENSION_LINE):
            number = int(gid.removeprefix(DIMENSION_LINE))
            label = texts[f"{DIMENSION_TEXT}{number}"].get_text()
            _write_dimension(space, placed([text.xyann, text.xy]), label, scale)  # type: ignore[attr-defined]
    for text in ax.texts:
        if not str(text.get_gid()).startswith((DIMENSION_LINE, DIMENSION_TEXT)):
            _write_text(space, text, placed, scale)


def _layer(colour: object) -> str:
    from matplotlib.colors import to_hex

    return LAYERS.get(to_hex(colour), _OTHER)[0]  # type: ignore[arg-type]


def _write_patch(space: Any, patch: "Artist", placed: Any, stretch: float) -> None:  # noqa: ANN401
    from matplotlib.patches import Arc, Circle, Polygon, Rectangle

    shape: Any = patch
    edge = shape.get_edgecolor()
    layer = {"layer": _layer(edge if edge[3] > 0.0 else shape.get_facecolor())}
    if isinstance(shape, Arc):
        middle, radius = placed([shape.center])[0], 0.5 * stretch * shape.width
        space.add_arc(middle, radius, shape.theta1, shape.theta2, dxfattribs=layer)
    elif isinstance(shape, Circle):
        if shape.get_linestyle() in ("-.", "dashdot"):
            layer["linetype"] = "CENTER"
        middle = placed([shape.center])[0]
        space.add_circle(middle, stretch * shape.radius, dxfattribs=layer)
    elif isinstance(shape, Polygon):
        space.add_lwpolyline(placed(shape.get_xy()[:-1]), close=True, dxfattribs=layer)
    elif isinstance(shape, Rectangle):
        space.add_lwpolyline(placed(shape.get_corners()), close=True, dxfattribs=layer)


def _write_dimension(
    space: Any,  # noqa: ANN401  ezdxf's own
    ends: list[tuple[float, float]],
    text: str,
    scale: float,
) -> None:
    """Write a dimension along its own line: its extension lines are drawn already."""
    first, second = sorted(ends, key=lambda end: (round(end[0], 6), end[1]))  # text reads upright
    dimension = space.add_aligned_dim(
        p1=first,
        p2=second,
        distance=0.0,
        text=_plain(text),
        override={
            "dimtxt": 7.5 * _TEXT_MM_PER_POINT * scale,
            "dimasz": 2.0 * scale,
            "dimexo": 0.0,
            "dimexe": 0.0,
            "dimlfac": 1.0,
            "dimtad": 1,
        },
        dxfattribs={"layer": LAYERS[DIMENSION][0]},
    )
    dimension.render()


def _write_text(space: Any, text: "Artist", placed: Any, scale: float) -> None:  # noqa: ANN401
    from matplotlib.text import Annotation

    one: Any = text
    layer = _layer(one.get_color())
    attributes = {"layer": layer if layer != "OUTLINE" else _OTHER[0]}
    if isinstance(one, Annotation):
        start, tip = placed([one.xyann, one.xy])
        space.add_leader([tip, start], override={"dimasz": 2.0 * scale}, dxfattribs=attributes)
        place = start
    else:
        place = placed([one.get_position()])[0]
    if not one.get_text():
        return
    found = space.add_text(
        _plain(one.get_text()),
        height=one.get_fontsize() * _TEXT_MM_PER_POINT * scale,
        rotation=one.get_rotation(),
        dxfattribs=attributes,
    )
    from ezdxf.enums import TextEntityAlignment

    aligned = {
        "center": TextEntityAlignment.MIDDLE_CENTER,
        "left": TextEntityAlignment.MIDDLE_LEFT,
    }
    found.set_placement(place, align=aligned[one.get_ha()])


def _plain(text: str) -> str:
    """Return a text without the marks of formulas."""
    return text.replace("$", "")
