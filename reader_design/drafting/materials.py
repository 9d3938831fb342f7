"""What each body of an unknown room is made of, guessed from its name and shape."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.medium.materials import Material, material
from octant.geometries.bodies import Body
from octant.geometries.errors import MaterialRangeError
from octant.geometries.material_names import SHEETS, THICKNESS_M, USUAL, guess_material

FLAT = 0.1
"""Thickness by width up to which a body is a sheet [-]."""
AT_EDGE = 0.02
"""Share of the room within which a wall is an outer one [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyMaterial:
    """The material of one body, and where it comes from.

    Parameters
    ----------
    body : Its name.
    name : Name of the material table; None: the file gives properties, which stay.
    thickness_m : Thickness of a sheet that waves pass [m]; None: it is opaque.
    why : Where this comes from, in words.
    """

    body: str
    name: str | None
    thickness_m: float | None
    why: str


def body_materials(
    bodies: Sequence[Body], own: Mapping[str, str], *, frequency_hz: float
) -> tuple[BodyMaterial, ...]:
    """Return the material of each body.

    The file's own where it is one of the table or has numbers; else what its name in the file, or
    the body's name, suggests; else `USUAL`. Flat inner sheets of walls, windows, doors and boards
    have the usual thickness [m] of their material, so that waves pass them; what closes the room,
    closed bodies and metal are opaque.

    Parameters
    ----------
    bodies : In their places [m].
    own : Label that the file gives, by body.
    frequency_hz : At which the material must exist [Hz].
    """
    low = np.min([b.bounds_m[0] for b in bodies], axis=0)
    high = np.max([b.bounds_m[1] for b in bodies], axis=0)
    bounds = np.stack((low, high))
    return tuple(_of_body(body, own.get(body.name), bounds, frequency_hz) for body in bodies)


def _of_body(
    body: Body, label: str | None, bounds_m: npt.NDArray[np.float64], frequency_hz: float
) -> BodyMaterial:
    known = None if label is None else _known(label, frequency_hz)
    if label is not None and known is not None and "=" in label:
        return BodyMaterial(body=body.name, name=None, thickness_m=None, why=label)
    if known is not None:
        name, why = known.name, "from the file"
    elif label is not None and (found := guess_material(label)):
        name, why = found[0], f"guessed from its material {label!r} in the file"
    elif found := guess_material(body.name):
        name, why = found[0], f"guessed from {found[1]!r}"
    else:
        name, why = USUAL, "guessed: the name says nothing"
    if _known(name, frequency_hz) is None:
        name, why = USUAL, f"{why}, but {name} is not known at this frequency"
    thickness = THICKNESS_M.get(name) if _is_inner_sheet(body, bounds_m) else None
    if thickness is not None:
        why += "; a sheet, thickness guessed"
    return BodyMaterial(body=body.name, name=name, thickness_m=thickness, why=why)


def _known(label: str, frequency_hz: float) -> Material | None:
    try:
        found = material(label)
        found.layer_stack(frequency_hz)
    except MaterialRangeError:
        return None
    return found


def _is_inner_sheet(body: Body, bounds_m: npt.NDArray[np.float64]) -> bool:
    """Return whether a body is one flat sheet that does not close the room."""
    if not SHEETS.search(body.name) or _is_closed(body):
        return False
    corners = body.triangles_m
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normal, axis=1)
    if area.sum() <= 0.0:
        return False
    main = normal[int(np.argmax(area))] / area.max()
    depth = float(np.ptp(corners.reshape(-1, 3) @ main))
    if depth > FLAT * float(np.sqrt(0.5 * area.sum())):
        return False
    size = np.ptp(bounds_m, axis=0)
    axis = int(np.argmax(np.abs(main)))
    middle = float(corners[..., axis].mean())
    gaps = np.abs(bounds_m[:, axis] - middle)
    upright = axis < 2
    return bool(not upright or gaps.min() > AT_EDGE * size[axis])


def _is_closed(body: Body) -> bool:
    """Return whether every edge of a body belongs to two triangles."""
    places = np.round(body.vertices_m / max(1e-6, 1e-6 * float(np.ptp(body.vertices_m))))
    _, number = np.unique(places, axis=0, return_inverse=True)
    faces = number.reshape(-1)[body.faces]
    edges = np.sort(np.concatenate((faces[:, :2], faces[:, 1:], faces[:, [2, 0]])), axis=1)
    _, count = np.unique(edges, axis=0, return_counts=True)
    return bool((count == 2).all())
