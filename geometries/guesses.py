"""Guesses about a mesh that its file leaves open: unit, vertical axis; each with its reason."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

ROOM_HEIGHTS_M = (2.0, 6.0)
"""Heights of ordinary rooms [m]."""
ROOM_LENGTHS_M = (2.0, 100.0)
"""Greatest horizontal extents of rooms and floors of buildings [m]."""
HALL_HEIGHTS_M, HALL_LENGTHS_M = (1.5, 30.0), (2.0, 300.0)
"""The same of halls and sites [m]."""
LONGEST_SITE_M = 2000.0
"""Extent [m] up to which a mesh without a better unit is taken to be in metres: a site outdoors."""
ODD_RATIO = 1.5
"""How many times higher than wide [-] a room must be before it is said to lie on its side."""
FLAT = 0.05
"""Thickness by width [-] up to which a body called a floor says which axis is vertical."""

UNITS: Mapping[str, float] = MappingProxyType(
    {"m": 1.0, "mm": 0.001, "cm": 0.01, "in": 0.0254, "ft": 0.3048}
)
"""Length of each unit that is tried, in this order [m]."""

_LEVEL = re.compile(r"floor(?!board|.?lamp)|ground|ceiling|slab|roof|boden|decke", re.IGNORECASE)
_AXES = "xyz"
_ROOM = (ROOM_LENGTHS_M, ROOM_HEIGHTS_M)


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameGuess:
    """What a mesh file seems to be drawn in.

    Parameters
    ----------
    unit : Unit of its coordinates, a key of `UNITS`; None: the one that the file declares.
    metres : Length of that unit [m].
    up : Its vertical axis, "y" or "z".
    unit_reason, up_reason : Why, in a few words [m].
    against : Whether the shape speaks against the axis that the format prescribes.
    """

    unit: str | None
    metres: float
    up: str
    unit_reason: str
    up_reason: str
    against: bool = False


def guess_frame(
    parts: Sequence[tuple[str, FloatArray]],
    *,
    declared_m: float | None,
    declared_up: str | None,
    says: str,
    fixed: bool = False,
) -> FrameGuess:
    """Return unit and vertical axis of a mesh, from its file, its names and its size [m].

    What the file declares is believed, but for two mistakes of exporters: a unit in which it would
    be shorter than 1 m or longer than `LONGEST_SITE_M`, where another makes a room of it; and an
    axis that the shape contradicts: bodies called floor or ceiling are flat along another one, or
    the room has an ordinary height along the other axis, and `ODD_RATIO` times that along this.

    Parameters
    ----------
    parts : Name and (n, 3) float64 corners of each body, as in the file [unit of the file].
    declared_m, declared_up : Unit [m] and axis that the file or its format says; None: nothing.
    says : Who says so, such as "glTF".
    fixed : Whether the declared unit cannot be another.
    """
    used = [(name, v[np.isfinite(v).all(axis=1)]) for name, v in parts]
    size = np.ptp(np.concatenate([v for _, v in used]), axis=0)
    conventional = declared_up or "z"
    other = "z" if conventional == "y" else "y"
    level, named = _level_axis(used)
    unit, metres, unit_reason = _unit_of(
        size,
        (level,) if level else (conventional, other),
        declared_m=declared_m,
        says=says,
        fixed=fixed,
    )
    said = f"{says} says {conventional} is up" if declared_up else f"z is usual in {says}"
    up, up_reason = conventional, said
    if level:
        up = level
        up_reason = f"{named}, and {said}" if level == conventional else f"{named}, though {said}"
    elif _lies_on_its_side(size * metres, conventional, other):
        height, wrong = (float(metres * size[_AXES.index(axis)]) for axis in (other, conventional))
        up = other
        up_reason = (
            f"along {other} it is {height:.3g} m, an ordinary height, along {conventional} "
            f"{wrong:.3g} m, though {said}"
        )
    return FrameGuess(
        unit=unit,
        metres=metres,
        up=up,
        unit_reason=unit_reason,
        up_reason=up_reason,
        against=up != conventional,
    )


def frame_lines(
    guess: FrameGuess, *, metres: float | None = None, up: str | None = None
) -> tuple[str, ...]:
    """Return what a file's unit and vertical axis are taken to be, and why, in sentences [m].

    Parameters
    ----------
    guess : What they seem to be.
    metres, up : What was given instead: a unit's length [m] and an axis; None: nothing.
    """
    unit = guess.unit or ("m" if guess.metres == 1.0 else f"{guess.metres:g} m")
    lines = [f"unit: {unit}, because {guess.unit_reason}"]
    if metres is not None:
        lines = [f"unit: {metres:g} m, as given"]
    if up is not None:
        lines.append(f"up: {up}")
        if up != guess.up:
            lines[-1] += f", but {guess.up} seems to be up, because {guess.up_reason}"
    else:
        lines.append(f"up: {guess.up}, because {guess.up_reason}")
    return tuple(lines)


def odd_shape(size_m: npt.ArrayLike) -> str:
    """Return a remark on a room whose shape is odd, or "".

    Parameters
    ----------
    size_m : (3,) array_like — Extent along x, y and z, z up [m].
    """
    size = np.asarray(size_m, dtype=np.float64)
    width = float(size[:2].min())
    if size[2] > ROOM_HEIGHTS_M[0] and width > 0.0 and size[2] > ODD_RATIO * width:
        return f"{size[2]:.3g} m high and {width:.3g} m wide"
    return ""


def _level_axis(parts: Sequence[tuple[str, FloatArray]]) -> tuple[str, str]:
    """Return the axis along which bodies called floor or ceiling are flat, and why; or ""."""
    weight, named = np.zeros(3), ["", "", ""]
    for name, vertices in parts:
        if not _LEVEL.search(name) or len(vertices) == 0:
            continue
        size = np.ptp(vertices, axis=0)
        order = np.argsort(size)
        if size[order[0]] <= FLAT * size[order[1]]:
            weight[order[0]] += size[order[1]] * size[order[2]]
            named[order[0]] = named[order[0]] or name
    best = int(np.argmax(weight))
    if weight[best] <= 0.0 or best == 0 or weight[best] < 0.8 * weight.sum():
        return "", ""
    return _AXES[best], f"body {named[best]!r} is flat along {_AXES[best]}"


def _unit_of(
    size: FloatArray, candidates: Sequence[str], *, declared_m: float | None, says: str, fixed: bool
) -> tuple[str | None, float, str]:
    """Return the unit, None where the declared one is believed, its length [m] and why."""
    longest = float(size.max())
    if declared_m is not None:
        metres = declared_m * longest
        found = _room_unit(size, candidates)
        if fixed or not found or _within(metres, (1.0, LONGEST_SITE_M)):
            return None, declared_m, f"{says} says so"
        unit, reason = found
        return unit, UNITS[unit], f"{reason}, though {says} makes it {metres:.3g} m long"
    if found := _room_unit(size, candidates):
        unit, reason = found
        return unit, UNITS[unit], reason
    for unit, metres in UNITS.items():
        limits = (1.0, LONGEST_SITE_M) if unit == "m" else ROOM_LENGTHS_M
        if _within(metres * longest, limits):
            return unit, metres, f"in {unit} it is {metres * longest:.3g} m long"
    return "m", 1.0, f"no unit makes a room of it: it is {longest:.3g} units long"


def _room_unit(size: FloatArray, candidates: Sequence[str]) -> tuple[str, str] | None:
    """Return the first unit in which a mesh has the size of a room, and why.

    Metres may make a hall of it: a room drawn in feet would be one too, but is less usual.
    """
    for unit, metres in UNITS.items():
        lengths, heights = (HALL_LENGTHS_M, HALL_HEIGHTS_M) if unit == "m" else _ROOM
        for axis in candidates:
            height = metres * float(size[_AXES.index(axis)])
            across = metres * float(np.delete(size, _AXES.index(axis)).max())
            level = height < FLAT * across
            if _within(across, lengths) and (level or _within(height, heights)):
                high = "flat" if level else f"{height:.3g} m high"
                return unit, f"in {unit} it is {across:.3g} m long and {high}, which fits a room"
    return None


def _within(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] <= value <= limits[1]


def _lies_on_its_side(size_m: FloatArray, up: str, other: str) -> bool:
    height, wanted = size_m[_AXES.index(up)], size_m[_AXES.index(other)]
    return bool(
        wanted <= size_m.min() and _within(wanted, ROOM_HEIGHTS_M) and height > ODD_RATIO * wanted
    )
