"""Bodies: named triangle meshes of one material, in metres, z up."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries._checks import finite_number
from octant.geometries.errors import GeometryError

FARTHEST_M = 1e8
"""Greatest coordinate of a corner [m], where float64 still tells 0.01 µm apart."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Body:
    """A named triangle mesh of one material.

    Parameters
    ----------
    name : What messages, figures and material tables call it.
    vertices_m : (n, 3) float64 — Corners [m], z up; places may repeat, as facets join by position.
    faces : (m, 3) int64 — Vertices of each triangle [-], counter-clockwise seen from its normal.
    material : Label, such as "concrete" or "pec"; `octant.em` says what it means.
    rounding_m : How far its file's rounding has moved all its corners at least [m].
    """

    name: str
    vertices_m: npt.NDArray[np.float64]
    faces: npt.NDArray[np.int64]
    material: str
    rounding_m: float = 0.0

    def __post_init__(self) -> None:
        for field, label in (("name", self.name), ("material", self.material)):
            if not isinstance(label, str) or not label.strip() or not label.isprintable():
                msg = f"the {field} of a body must be a printable text, but {label!r} was given."
                raise GeometryError(msg)
        vertices = frozen_array(
            self.vertices_m, name=f"vertices_m of body {self.name!r}", shape=(None, 3)
        )
        farthest = float(np.abs(vertices).max(initial=0.0))
        if farthest > FARTHEST_M:
            msg = (
                f"body {self.name!r} has a corner at {farthest:.3g} m, but at most "
                f"{FARTHEST_M:g} m from the origin is possible; check the file and its unit."
            )
            raise GeometryError(msg)
        if len(vertices) == 0 or np.size(self.faces) == 0:
            msg = f"body {self.name!r} is empty; it needs at least one triangle."
            raise GeometryError(msg)
        if np.asarray(self.faces).dtype.kind not in "iu":
            msg = f"faces of body {self.name!r} must be whole numbers, the numbers of vertices."
            raise GeometryError(msg)
        faces = frozen_array(
            self.faces, name=f"faces of body {self.name!r}", shape=(None, 3), dtype=np.int64
        )
        if faces.min() < 0 or faces.max() >= len(vertices):
            wrong = int(faces.min() if faces.min() < 0 else faces.max())
            msg = (
                f"body {self.name!r} has a triangle that names vertex {wrong}, but its vertices "
                f"are numbered 0 to {len(vertices) - 1}."
            )
            raise GeometryError(msg)
        object.__setattr__(self, "vertices_m", vertices)
        object.__setattr__(self, "faces", faces)

    @property
    def triangles_m(self) -> npt.NDArray[np.float64]:
        """Corners of every triangle, (m, 3, 3) by triangle, corner, coordinate [m]."""
        corners: npt.NDArray[np.float64] = self.vertices_m[self.faces]
        return corners

    @property
    def bounds_m(self) -> npt.NDArray[np.float64]:
        """Lowest and highest corner of the box around the triangles, (2, 3) [m]."""
        used = self.vertices_m[self.faces.reshape(-1)]
        return np.stack([used.min(axis=0), used.max(axis=0)])

    @property
    def area_m2(self) -> float:
        """Sum of the triangles' areas, one side each [m²]."""
        a, b, c = np.moveaxis(self.triangles_m, 1, 0)
        return float(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def place(body: Body, *, position_m: npt.ArrayLike = (0.0, 0.0, 0.0), yaw_rad: float = 0.0) -> Body:
    """Return the body turned about the vertical through its own origin, then moved.

    Parameters
    ----------
    body : The body in its own frame.
    position_m : (3,) array_like — Where the origin of the body's frame comes to stand [m].
    yaw_rad : Turn about +z, from +x towards +y [rad]; a whole number of quarter turns is exact.
    """
    shift = frozen_array(position_m, name="position_m", shape=(3,))
    yaw = finite_number(yaw_rad, name="yaw_rad", unit="rad")
    quarter = round(yaw / (0.5 * math.pi))
    if math.isclose(yaw, quarter * 0.5 * math.pi, rel_tol=1e-15, abs_tol=1e-15):
        cos, sin = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[quarter % 4]
    else:
        cos, sin = math.cos(yaw), math.sin(yaw)
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return replace(body, vertices_m=body.vertices_m @ turn.T + shift)


def placed(body: Body, position_m: Sequence[float], yaw_deg: float) -> Body:
    """Return a body put in its place, as a study file says it.

    Parameters
    ----------
    body : The body in its own frame.
    position_m : (3,) sequence of float — Where the origin of the body's frame comes to stand [m].
    yaw_deg : Turn about the vertical through `position_m`, from +x towards +y [deg].
    """
    yaw = finite_number(yaw_deg, name=f"yaw_deg of {body.name!r}", unit="deg")
    where = frozen_array(position_m, name=f"position_m of {body.name!r}", shape=(3,))
    return place(body, position_m=where, yaw_rad=math.radians(yaw))
