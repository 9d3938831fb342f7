"""Antennas other than upright dipoles, as named parts of metal strips: for `ported_mesh`.

Each is drawn on the +x side of the reader, its flat side towards x, and copied around the z axis.
A strip stands for a wire of a quarter of its width.
"""

import itertools
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from octant.em.reader.fullwave.ported import ruled_sheet, strip
from octant.geometries._plane_geometry import FloatArray, IntArray
from octant.geometries.errors import GeometryError
from octant.geometries.tolerances import LENGTHS

Part = tuple[str, FloatArray, IntArray]
"""Name, vertices [m] and triangles [-]."""

CELLS_OF_DIPOLE = 24
"""Cells along half a wave [-]: fine enough for the feed and the tips."""


def copied_around(parts: Sequence[Part], name: str, *, around: int) -> list[Part]:
    """Return parts turned about z in even steps, named ``name.part`` or ``name 1.part`` and so on.

    Parameters
    ----------
    parts, name : What is copied, and what it is called.
    around : Number of copies; the first stays.
    """
    copies = []
    for i in range(around):
        c, s = math.cos(2.0 * math.pi * i / around), math.sin(2.0 * math.pi * i / around)
        turn = np.array(((c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0)))
        head = f"{name} {i + 1}" if around > 1 else name
        copies += [(f"{head}.{part}", points @ turn, faces) for part, points, faces in parts]
    return copies


def dipole_parts(
    *,
    length_m: float,
    width_m: float,
    middle_m: Sequence[float],
    axis: Sequence[float],
    cell_m: float,
) -> list[Part]:
    """Return a dipole of any direction: parts ``low`` and ``high``, which meet at its feed.

    Parameters
    ----------
    length_m, width_m, middle_m : Length, width of the strip, place of the feed [m].
    axis : Direction from low to high [-].
    cell_m : Longest cell [m].
    """
    along = _direction(axis)
    across = np.cross(along, (1.0, 0.0, 0.0))
    if float(np.linalg.norm(across)) < 0.1:
        across = np.array((0.0, 1.0, 0.0))
    half, middle = 0.5 * length_m * along, np.asarray(middle_m, dtype=np.float64)
    rows = max(CELLS_OF_DIPOLE // 2, math.ceil(0.5 * length_m / cell_m))
    shape = {"width_m": width_m, "across": across, "rows": rows}
    return [
        ("low", *strip(middle - half, middle, **shape)),  # type: ignore[arg-type]
        ("high", *strip(middle, middle + half, **shape)),  # type: ignore[arg-type]
    ]


def loop_parts(
    *,
    size_m: tuple[float, float],
    width_m: float,
    middle_m: Sequence[float],
    cell_m: float,
) -> list[Part]:
    """Return a rectangular loop in the plane across x: a folded dipole where it is narrow.

    Parts ``low`` and ``high`` meet at the feed, in the middle of one upright side; ``rest`` closes
    the loop.

    Parameters
    ----------
    size_m : Extent along y and z of the strip's middle line [m].
    width_m, middle_m : Width of the strip; middle of the loop [m].
    cell_m : Longest cell [m].
    """
    y, z = 0.5 * size_m[0], 0.5 * size_m[1]
    h = 0.5 * width_m
    if min(y, z) <= h:
        msg = (
            f"a loop of {size_m[0]:g} x {size_m[1]:g} m is closed by its strip of {width_m:g} m; "
            "give a larger loop or a narrower strip."
        )
        raise GeometryError(msg)
    corners = [(-y, 0.0), (-y, z), (y, z), (y, -z), (-y, -z), (-y, 0.0)]
    inner: list[FloatArray] = []
    outer: list[FloatArray] = []
    for (a, b), (c, d) in itertools.pairwise(corners):
        rows = max(2, math.ceil(math.hypot(c - a, d - b) / cell_m))
        share = np.linspace(0.0, 1.0, rows + 1)[:-1, None]
        for lines, by in ((inner, -h), (outer, h)):
            start, end = (_moved_out(p, (y, z), by) for p in ((a, b), (c, d)))
            lines.append(start + share * (end - start))
    rims = []
    for lines, by in ((inner, -h), (outer, h)):
        line = np.concatenate([*lines, _moved_out(corners[-1], (y, z), by)[None]])
        rims.append(np.column_stack((np.zeros(len(line)), line)) + np.asarray(middle_m))
    cut, count = len(inner[0]), len(rims[0])
    places = {
        "high": slice(0, cut + 1),
        "rest": slice(cut, count - cut),
        "low": slice(count - cut - 1, count),
    }
    return [(name, *ruled_sheet(rims[0][s], rims[1][s])) for name, s in places.items()]


def _moved_out(
    place: tuple[float, float], half: tuple[float, float], by: float
) -> npt.NDArray[np.float64]:
    """Return a point of a rectangle's outline moved outwards, at its corners diagonally [m]."""
    return np.array(
        [
            p * (1.0 + by / h) if abs(abs(p) - h) < LENGTHS.place_m else p
            for p, h in zip(place, half, strict=True)
        ]
    )


def inverted_f_parts(
    *,
    height_m: float,
    arm_m: float,
    tap_m: float,
    width_m: float,
    foot_m: Sequence[float],
    cell_m: float,
) -> list[Part]:
    """Return an inverted-F antenna in the plane across x: parts ``metal`` and ``leg``.

    A post shorts one end of the arm to the plane below, the leg feeds it at its foot.

    Parameters
    ----------
    height_m, arm_m : Height of the arm's middle line, and its length from the post's outer side
        [m].
    tap_m : Distance of the leg from the post, middle to middle [m].
    width_m : Width of all strips [m].
    foot_m : (3,) — Middle of the post's foot [m].
    cell_m : Longest cell [m].
    """
    if not width_m < tap_m < arm_m - 1.5 * width_m or height_m <= width_m:
        msg = (
            f"an inverted F of {arm_m:g} x {height_m:g} m with a leg at {tap_m:g} m and strips of "
            f"{width_m:g} m has no room for its leg; widths must be less than the others' gaps."
        )
        raise GeometryError(msg)
    h = 0.5 * width_m
    marks = (-h, h, tap_m - h, tap_m + h, arm_m - h)
    steps = [_even(a, b, cell_m)[:-1] for a, b in itertools.pairwise(marks)]
    y = np.concatenate((*steps, [marks[-1]]))
    rim = np.column_stack((np.zeros_like(y), y, np.full_like(y, height_m - h)))
    arm = ruled_sheet(rim, rim + np.array((0.0, 0.0, width_m)))
    foot = np.asarray(foot_m, dtype=np.float64)
    parts = [("metal", arm[0] + foot, arm[1])]
    for name, place in (("metal", 0.0), ("leg", tap_m)):
        z = _even(0.0, height_m - h, cell_m)
        own = _even(place - h, place + h, cell_m)
        left = np.column_stack((np.zeros_like(z), np.full_like(z, own[0]), z))
        post = ruled_sheet(left, left + np.array((0.0, width_m, 0.0)), columns=len(own) - 1)
        parts.append((name, post[0] + foot, post[1]))
    return parts


def patch_parts(
    *,
    size_m: tuple[float, float],
    height_m: float,
    feed_m: float,
    middle_m: Sequence[float],
    cell_m: float,
) -> list[Part]:
    """Return a patch over the plane below, on air: parts ``patch`` and ``probe``.

    Parameters
    ----------
    size_m, height_m : Resonant length along y and width along x, height over the plane [m].
    feed_m : Distance of the probe from the middle along -y [m]; it is a strip as wide as a cell.
    middle_m : (3,) — Point of the plane below the middle [m].
    cell_m : Longest cell [m].
    """
    length, width = size_m
    columns = 2 * (math.ceil(width / cell_m) // 2) + 1
    rows = math.ceil(length / cell_m)
    y = np.linspace(-0.5 * length, 0.5 * length, rows + 1)
    row = int(np.abs(y + feed_m).argmin())
    left = np.column_stack((np.full_like(y, -0.5 * width), y, np.full_like(y, height_m)))
    cell = width / columns
    tall = max(1, math.ceil(height_m / cell_m))
    ends = (0.0, y[row], 0.0), (0.0, y[row], height_m)
    probe = strip(*ends, width_m=cell, across=(1.0, 0.0, 0.0), rows=tall)
    middle = np.asarray(middle_m, dtype=np.float64)
    sheet = ruled_sheet(left, left * (-1.0, 1.0, 1.0), columns=columns)
    return [("patch", sheet[0] + middle, sheet[1]), ("probe", probe[0] + middle, probe[1])]


def _even(start: float, end: float, step: float) -> FloatArray:
    return np.linspace(start, end, max(1, math.ceil((end - start) / step)) + 1)


def _direction(axis: Sequence[float]) -> FloatArray:
    given = np.asarray(axis, dtype=np.float64)
    size = float(np.linalg.norm(given))
    if not size > 0.0:
        msg = f"axis is {list(axis)}, but a direction is needed, such as [0, 0.7, 0.7]."
        raise GeometryError(msg)
    direction: FloatArray = given / size
    return direction
