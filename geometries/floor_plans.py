"""Floor plans as rooms: ROS' map_server maps (YAML and image), pictures, DXF drawings, extruded.

Source: ROS 2 Navigation, ``nav2_map_server`` (map_io.cpp: trinary, scale and raw modes).
"""

import io
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import GeometryError
from octant.geometries.xml_files import URL

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]
PlanPart = tuple[str, FloatArray, IntArray]

PICTURES = ("png", "jpg", "jpeg", "pgm", "bmp", "tif", "tiff")
"""Extensions of pictures, which are floor plans where their scale is given."""
PLANS = ("yaml", "yml", "dxf", *PICTURES)
"""Extensions of floor plans."""
DARK = 0.5
"""Share of black above which a pixel of a picture is wall [-]."""
DEFAULT_HEIGHT_M = 2.5
"""Height of walls of which nothing is said [m]."""
STRAIGHTENED_CELLS = 0.75
"""How far an outline of cells may be moved [cells]: stairs of an oblique wall become one line."""
MOST_CELLS = 25_000_000
"""Pixels of the largest map that is read [-]."""
ARC_STEP_M = 0.25
"""Length of the straight pieces of arcs in a drawing, about [m]."""
MARGIN_M = 0.05
"""How far the floor of a drawing reaches beyond its lines [m]."""

OPENINGS_M = {"door": (0.0, 2.0), "opening": (0.0, 2.0), "window": (0.9, 2.1)}
"""Heights between which lines of a drawing are open [m], by what the name of their layer holds."""
_DXF_METRES = {1: 0.0254, 2: 0.3048, 4: 0.001, 5: 0.01, 6: 1.0, 10: 0.9144, 14: 0.1}
_KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh", "mode")


def read_plan(path: Path, height_m: float, metres_per_pixel: float | None = None) -> list[PlanPart]:
    """Return walls and floor of a floor plan [m].

    Of a map the outlines of occupied cells stand as walls, straight within `STRAIGHTENED_CELLS`,
    and its free cells are the floor; unknown cells are neither, so that they are outside the room.
    Of a DXF drawing every line and arc is a wall without a thickness, on a rectangular floor; on a
    layer whose name holds door, opening or window (`OPENINGS_M`) a line is an opening, of which
    what is above and below it stands, and an arc, a leaf's swing, is nothing. A picture by
    itself is a map whose dark pixels (`DARK`) are wall; light ones are floor, but for the margin
    around the outer walls where these are closed. There is no ceiling.

    Parameters
    ----------
    path : YAML of a map, DXF, or a picture.
    height_m : Height of the walls [m].
    metres_per_pixel : Scale of a picture, which it needs [m].
    """
    kind = path.suffix.lower().removeprefix(".")
    if kind == "dxf":
        return _drawing(path, height_m)
    header = _picture(path, metres_per_pixel) if kind in PICTURES else _map_header(path)
    occupied, free = _cells(path, header)
    if kind in PICTURES:
        free = _inside(free)
    if not occupied.any():
        msg = (
            f"{path}: no cell of {header.image.name} is occupied, so there is no wall; check "
            "negate and occupied_thresh."
        )
        raise GeometryError(msg)
    walls = _walls(_outlines(occupied), height_m / header.resolution_m)
    parts = [("walls", *walls)]
    if free.any():
        parts.append(("floor", *_rectangles(free)))
    x, y, yaw = header.origin
    cos, sin = math.cos(yaw), math.sin(yaw)
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    shift = np.array([x, y, 0.0])
    return [
        (name, (header.resolution_m * vertices) @ turn.T + shift, faces)
        for name, vertices, faces in parts
    ]


def plan_files(path: Path) -> tuple[Path, ...]:
    """Return the image of a map, if it can be found; of a drawing or a picture nothing.

    Parameters
    ----------
    path : As for `read_plan`.
    """
    if path.suffix.lower() not in {".yaml", ".yml"}:
        return ()
    try:
        return (_map_header(path).image,)
    except GeometryError:  # it is refused with a sentence where it is loaded
        return ()


@dataclass(frozen=True, slots=True, kw_only=True)
class _Header:
    """The YAML of a map: image, cell [m], lowest corner and turn ([m], [rad]), thresholds."""

    image: Path
    resolution_m: float
    origin: tuple[float, float, float]
    negate: bool
    occupied: float
    free: float
    mode: str


def _picture(path: Path, metres_per_pixel: float | None) -> _Header:
    """Return what a picture says as a map, its lower left corner in the origin."""
    if metres_per_pixel is None:
        msg = (
            f"{path} is a picture without a scale; give room.metres_per_pixel, such as 0.05 "
            "(octant init: --metres-per-pixel 0.05)."
        )
        raise GeometryError(msg)
    return _Header(
        image=path,
        resolution_m=metres_per_pixel,
        origin=(0.0, 0.0, 0.0),
        negate=False,
        occupied=DARK,
        free=DARK,
        mode="scale",
    )


def _inside(free: BoolArray) -> BoolArray:
    """Return free cells without those that reach the border; all, where no others are left."""
    from scipy.ndimage import label

    parts, _ = label(np.pad(free, 1, constant_values=True))
    kept: BoolArray = free & (parts != parts[0, 0])[1:-1, 1:-1]
    return kept if kept.any() else free


def _map_header(path: Path) -> _Header:
    try:
        text = path.read_text("utf-8")
    except (UnicodeDecodeError, OSError) as exc:
        msg = f"{path} cannot be read as the YAML of a map; check the file."
        raise GeometryError(msg) from exc
    given = _flat_yaml(text)
    missing = [key for key in ("image", "resolution", "origin") if not given.get(key)]
    if missing:
        msg = (
            f"{path} lacks {', '.join(missing)}, but the YAML of a map (ROS map_server) has "
            f"{', '.join(_KEYS)}; complete it."
        )
        raise GeometryError(msg)
    image = given["image"][0]
    file = path.parent / image
    inside = file.resolve().is_relative_to(path.parent.resolve())
    if URL.match(image) or not inside:
        msg = f"{path}: its image {image[:200]!r} must lie beside it, or below; copy it there."
        raise GeometryError(msg)
    if not file.is_file():
        msg = f"{path} > {image}: this image does not exist; put it beside the YAML file."
        raise GeometryError(msg)
    (resolution,) = _numbers(given, "resolution", 1, path)
    origin = _numbers(given, "origin", 3, path)
    (occupied,) = _numbers(given, "occupied_thresh", 1, path, ("0.65",))
    (free,) = _numbers(given, "free_thresh", 1, path, ("0.196",))
    mode = given.get("mode", ["trinary"])[0]
    if not 1e-4 <= resolution <= 100.0 or mode not in {"trinary", "scale", "raw"}:
        msg = (
            f"{path} has the resolution {resolution:g} m and the mode {mode!r}, but 0.0001 to 100 "
            "m and trinary, scale or raw are possible; correct it."
        )
        raise GeometryError(msg)
    return _Header(
        image=file,
        resolution_m=resolution,
        origin=(origin[0], origin[1], origin[2]),
        negate=given.get("negate", ["0"])[0].lower() in {"1", "true"},
        occupied=occupied,
        free=free,
        mode=mode,
    )


def _flat_yaml(text: str) -> dict[str, list[str]]:
    """Return the values of a flat YAML: ``key: value``, ``key: [a, b]``, or items on own lines."""
    found: dict[str, list[str]] = {}
    key = ""
    for raw in text.splitlines():
        line = re.sub(r"(^|\s)#.*$", "", raw).rstrip()
        pair = re.match(r"^([A-Za-z_]\w*)\s*:\s*(.*)$", line)
        item = re.match(r"^\s*-\s+(\S.*)$", line)
        if pair:
            key, value = pair[1], pair[2].strip()
            inner = value[1:-1].split(",") if value.startswith("[") else [value]
            found[key] = [part.strip().strip("'\"") for part in inner if part.strip()]
        elif item and key:
            found[key].append(item[1].strip().strip("'\""))
    return found


def _numbers(
    given: dict[str, list[str]], key: str, count: int, path: Path, default: Sequence[str] = ()
) -> list[float]:
    words = given.get(key) or list(default)
    try:
        found = [float(word) for word in words]
    except ValueError:
        found = []
    if len(found) != count or not all(math.isfinite(number) for number in found):
        msg = f"{path}: {key} is {' '.join(words)[:60]!r}, but {count} number(s) are needed."
        raise GeometryError(msg)
    return found


def _cells(path: Path, header: _Header) -> tuple[BoolArray, BoolArray]:
    """Return which cells (nx, ny), lowest corner first, are occupied, and which are free."""
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(header.image) as image:
            if image.width * image.height > MOST_CELLS:
                msg = (
                    f"{path} > {header.image.name} has {image.width} x {image.height} pixels, more "
                    f"than {MOST_CELLS}; make it coarser."
                )
                raise GeometryError(msg)
            grey = np.asarray(image.convert("RGB"), dtype=np.float64).mean(axis=2)
    except (UnidentifiedImageError, OSError, ValueError, SyntaxError) as exc:
        msg = f"{path} > {header.image.name} cannot be read as an image; save it again."
        raise GeometryError(msg) from exc
    cells = grey[::-1].T
    if header.mode == "raw":
        return cells >= 100.0 * header.occupied, cells <= 100.0 * header.free
    share = cells / 255.0 if header.negate else 1.0 - cells / 255.0
    return share > header.occupied, share < header.free


def _outlines(occupied: BoolArray) -> list[FloatArray]:
    """Return closed outlines (n, 2) of the occupied cells [cells], each on its left."""
    padded = np.pad(occupied, 1)
    follows: dict[tuple[int, int], list[tuple[int, int]]] = {}
    # Each side of an occupied cell that a free one shares, with the occupied cell on its left.
    for dx, dy, start, stop in (
        (0, -1, (0, 0), (1, 0)), (1, 0, (1, 0), (1, 1)),
        (0, 1, (1, 1), (0, 1)), (-1, 0, (0, 1), (0, 0)),
    ):  # fmt: skip
        beside = np.roll(padded, (-dx, -dy), axis=(0, 1))
        for i, j in np.argwhere(padded & ~beside) - 1:
            a = (int(i) + start[0], int(j) + start[1])
            follows.setdefault(a, []).append((int(i) + stop[0], int(j) + stop[1]))
    outlines = []
    while follows:
        first = next(iter(follows))
        place, way = first, [first]
        ahead: tuple[int, int] | None = None
        while True:
            choices = follows[place]
            chosen = choices[0]
            if len(choices) > 1 and ahead is not None:  # two corners touch: keep to one cell
                left = (place[0] - ahead[1], place[1] + ahead[0])
                chosen = left if left in choices else chosen
            choices.remove(chosen)
            if not choices:
                del follows[place]
            ahead = (chosen[0] - place[0], chosen[1] - place[1])
            place = chosen
            if place == first:
                break
            way.append(place)
        outlines.append(_straightened(np.array(way, dtype=np.float64)))
    return outlines


def _straightened(way: FloatArray) -> FloatArray:
    """Return a closed outline without what lies within `STRAIGHTENED_CELLS` of straight lines."""
    before, after = np.roll(way, 1, axis=0), np.roll(way, -1, axis=0)
    turns = (way[:, 0] - before[:, 0]) * (after[:, 1] - way[:, 1]) - (way[:, 1] - before[:, 1]) * (
        after[:, 0] - way[:, 0]
    )
    corners: FloatArray = way[turns != 0.0]
    if len(corners) <= 4:
        return corners
    start = int(np.argmin(corners.sum(axis=1)))
    ring = np.roll(corners, -start, axis=0)
    far = int(np.argmax(((ring - ring[0]) ** 2).sum(axis=1)))
    halves = (ring[: far + 1], np.concatenate((ring[far:], ring[:1])))
    kept = np.concatenate([_douglas_peucker(half)[:-1] for half in halves])
    return kept if len(kept) > 2 and not _crosses_itself(kept) else corners


def _douglas_peucker(line: FloatArray) -> FloatArray:
    """Return a line without the points that lie near the rest (Douglas and Peucker, 1973)."""
    keep = np.zeros(len(line), dtype=np.bool_)
    keep[[0, -1]] = True
    waiting = [(0, len(line) - 1)]
    while waiting:
        a, b = waiting.pop()
        if b - a < 2:
            continue
        along = line[b] - line[a]
        away = line[a + 1 : b] - line[a]
        length = float(np.hypot(*along))
        if length > 0.0:
            distance = np.abs(along[0] * away[:, 1] - along[1] * away[:, 0]) / length
        else:
            distance = np.hypot(away[:, 0], away[:, 1])
        worst = int(np.argmax(distance))
        if distance[worst] > STRAIGHTENED_CELLS:
            keep[a + 1 + worst] = True
            waiting += [(a, a + 1 + worst), (a + 1 + worst, b)]
    return line[keep]


def _crosses_itself(ring: FloatArray) -> bool:
    """Return whether two sides of a closed outline that are no neighbours meet."""
    start, stop = ring, np.roll(ring, -1, axis=0)
    count = len(ring)
    for i in range(count - 2):
        others = slice(i + 2, count - (i == 0))
        a, b, c, d = start[i], stop[i], start[others], stop[others]

        def side(p: Any, q: Any, r: Any) -> FloatArray:  # noqa: ANN401
            turn: FloatArray = (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (
                q[..., 1] - p[..., 1]
            ) * (r[..., 0] - p[..., 0])
            return turn

        apart = (side(a, b, c) * side(a, b, d) > 0) | (side(c, d, a) * side(c, d, b) > 0)
        if not apart.all():
            return True
    return False


def _walls(outlines: Sequence[FloatArray], height: float) -> tuple[FloatArray, IntArray]:
    """Return upright rectangles on closed outlines, their normals away from what is on the left."""
    legs = [np.stack((ring, np.roll(ring, -1, axis=0)), axis=1) for ring in outlines]
    return _extruded(np.concatenate(legs), height)


def _extruded(
    legs: FloatArray, height: float, *, foot_m: float = 0.0
) -> tuple[FloatArray, IntArray]:
    """Return upright rectangles on legs (n, 2, 2), from a foot up to a height [m]."""
    low = np.zeros((len(legs), 2, 1))
    foot = np.concatenate((legs, low + foot_m), axis=2)
    top = np.concatenate((legs[:, ::-1], low + height), axis=2)
    vertices = np.concatenate((foot, top), axis=1).reshape(-1, 3)
    quad = np.array([(0, 1, 2), (0, 2, 3)])
    faces = (quad[None] + 4 * np.arange(len(legs))[:, None, None]).reshape(-1, 3)
    return vertices, faces


def _rectangles(cells: BoolArray) -> tuple[FloatArray, IntArray]:
    """Return level rectangles that cover cells: runs along x, joined over equal neighbours."""
    done: list[tuple[int, int, int, int]] = []
    open_: dict[tuple[int, int], int] = {}
    count_y = cells.shape[1]
    for j in range(count_y + 1):
        runs: set[tuple[int, int]] = set()
        if j < count_y:
            edges = np.flatnonzero(np.diff(np.pad(cells[:, j].astype(np.int8), 1)))
            runs = {(int(a), int(b)) for a, b in edges.reshape(-1, 2)}
        ended = [run for run in open_ if run not in runs]
        done += [(*run, open_.pop(run), j) for run in ended]
        for run in runs:
            open_.setdefault(run, j)
    boxes = np.array(sorted(done), dtype=np.float64)
    x0, x1, y0, y1 = boxes.T
    ring = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    vertices = np.stack([np.stack((x, y, 0.0 * x), axis=1) for x, y in ring], axis=1)
    quad = np.array([(0, 1, 2), (0, 2, 3)])
    faces = (quad[None] + 4 * np.arange(len(boxes))[:, None, None]).reshape(-1, 3)
    return vertices.reshape(-1, 3), faces


def _drawing(path: Path, height_m: float) -> list[PlanPart]:
    """Return the walls of a DXF drawing by layer (lower case), and a floor below them [m]."""
    import trimesh

    try:
        text = path.read_text("utf-8", errors="replace")
        drawing = trimesh.load_path(io.BytesIO(path.read_bytes()), file_type="dxf")
        legs: dict[str, list[FloatArray]] = {}
        metres = _dxf_metres(text, path)
        layers = drawing.layers if len(drawing.layers) == len(drawing.entities) else None
        for number, entity in enumerate(drawing.entities):
            step = max(ARC_STEP_M / metres, 1e-9)
            line = np.asarray(
                entity.discrete(drawing.vertices, scale=step * 20.0), dtype=np.float64
            )
            name = str(layers[number]).lower() if layers is not None and layers[number] else "walls"
            pair = np.stack((line[:-1, :2], line[1:, :2]), axis=1) * metres
            long = np.hypot(*(pair[:, 1] - pair[:, 0]).T) > 1e-6
            if _opening_m(name) is None or len(line) == 2:
                legs.setdefault(name, []).append(pair[long])
    except GeometryError:
        raise
    except Exception as exc:  # trimesh's readers raise anything at all on a damaged file
        msg = (
            f"{path} cannot be read as a DXF drawing of lines and arcs; save it again as ASCII DXF "
            "2000 or later, with blocks exploded."
        )
        raise GeometryError(msg) from exc
    found = {name: np.concatenate(pieces) for name, pieces in legs.items()}
    found = {name: piece for name, piece in found.items() if len(piece)}
    if not found:
        msg = f"{path} holds no lines or arcs; explode its blocks and save it again."
        raise GeometryError(msg)
    parts = [part for name, piece in found.items() for part in _standing(name, piece, height_m)]
    everything = np.concatenate(list(found.values())).reshape(-1, 2)
    x0, y0 = everything.min(axis=0) - MARGIN_M
    x1, y1 = everything.max(axis=0) + MARGIN_M
    corners = np.array([(x0, y0, 0.0), (x1, y0, 0.0), (x1, y1, 0.0), (x0, y1, 0.0)])
    name = "floor" if "floor" not in found else "floor_of_plan"
    return [*parts, (name, corners, np.array([(0, 1, 2), (0, 2, 3)]))]


def _opening_m(layer: str) -> tuple[float, float] | None:
    """Return between which heights the lines of a layer are open [m]; None: they are walls."""
    return next((heights for word, heights in OPENINGS_M.items() if word in layer), None)


def _standing(layer: str, legs: FloatArray, height_m: float) -> list[PlanPart]:
    """Return what stands on the lines of a layer: walls, or what an opening leaves of them."""
    opening = _opening_m(layer)
    if opening is None:
        return [(layer, *_extruded(legs, height_m))]
    low_m, high_m = opening
    parts: list[PlanPart] = []
    if low_m > 0.0:
        parts.append((f"{layer} parapet", *_extruded(legs, min(low_m, height_m))))
    if high_m < height_m:
        parts.append((f"{layer} lintel", *_extruded(legs, height_m, foot_m=high_m)))
    return parts


def _dxf_metres(text: str, path: Path) -> float:
    found = re.search(r"\$INSUNITS\s*\r?\n\s*70\s*\r?\n\s*(\d+)", text)
    code = int(found[1]) if found else 0
    if code not in _DXF_METRES:
        msg = (
            f"{path} says {'no unit' if code == 0 else f'the unit {code}'} ($INSUNITS); set it in "
            "the drawing (4 millimetres, 5 centimetres, 6 metres, 1 inches, 2 feet)."
        )
        raise GeometryError(msg)
    return _DXF_METRES[code]
