"""What a user should know about a room: where its floor is assumed, how its walls are drawn."""

import numpy as np
import numpy.typing as npt

from octant.em.medium.materials import Material
from octant.geometries.errors import ConfigError
from octant.geometries.occlusion import segments_blocked
from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS
from octant.reader_design.study_file.bodies import study_materials
from octant.reader_design.study_file.room import Room
from octant.reader_design.study_file.schema import Study

FloatArray = npt.NDArray[np.float64]

GRID = 16
"""Rays along each side of a room that look for its floor [-]."""

HALVINGS = 30
"""Steps that find the height of a surface [-]: to a micrometre in a kilometre."""

THIN_M = 0.5
"""Thickness [m] up to which a closed part is taken for a wall drawn with both its faces."""

FLAT = 0.1
"""Thickness [-] by width up to which it is a wall, and no cabinet."""

TALL = 0.7
"""Share of a room's height [-] from which an upright facet in it is an inner wall."""

MOST_WALLS = 300
"""Inner walls [-], the widest, that are looked at."""

OPAQUE_S_PER_M = 1e6
"""Conductivity [S/m] from which a material lets nothing through, however thin."""


def seen_floor_m(study: Study, scene: Scene, room: Room) -> float | None:
    """Return where the floor seems to be [m], if not where it is taken, or None.

    Rays fall from the height of the lowest tag: below the tags, the starts and a grid over the
    room. The level on which most of them end is a floor, if a quarter of them do, unless the study
    says in ``room.floor_m`` what is.

    Parameters
    ----------
    study, scene : A study and one of its rooms [m].
    room : The table of that room.
    """
    if room.mesh is None or room.floor_m is not None or not study.tags:
        return None
    tags = np.array([tag.position_m for tag in study.tags]).reshape(-1, 3)
    starts = [] if study.mission is None else [study.mission.start_m, *study.mission.starts]
    low, high = scene.bounds_m[:, :2]
    shares = (np.arange(GRID) + 0.5) / GRID
    grid = np.stack(np.meshgrid(*(low + np.outer(shares, high - low)).T), axis=-1).reshape(-1, 2)
    places = np.concatenate((tags[:, :2], [start[:2] for start in starts] or grid[:0], grid))
    top = np.full(len(places), tags[:, 2].min() - LENGTHS.step_m)
    from_m = np.column_stack((places, top))
    from_m = from_m[scene.inside_room(from_m) & ~scene.inside_solid(from_m)]
    levels, counts = np.unique(np.round(_surfaces_below_m(scene, from_m), 3), return_counts=True)
    if len(levels) == 0 or 4 * counts.max() < counts.sum():
        return None
    level = float(levels[int(np.argmax(counts))]) + 0.0
    return level if level - scene.floor_height_m > LENGTHS.step_m else None


def floor_note(scene: Scene, seen_m: float) -> str:
    """Return a line that says where the floor is taken, and where it seems to be.

    Parameters
    ----------
    scene : The room.
    seen_m : Of `seen_floor_m` [m].
    """
    floor = scene.floor_height_m
    return (
        f"the floor is taken at the mesh's lowest point, z = {floor:.6g} m, but most of what "
        f"tags see below them is at z = {seen_m:.6g} m; if that is the floor, give "
        f"room.floor_m = {seen_m:.6g} (or {floor:.6g}, to keep it)."
    )


def refuse_under_floor(scene: Scene, seen_m: float | None, z_m: float, *, name: str) -> None:
    """Refuse a reader or a map at or below the floor that the tags see.

    Parameters
    ----------
    scene : The room.
    seen_m : Of `seen_floor_m` [m].
    z_m : Height coordinate of the reader or the map [m].
    name : Which of the two.
    """
    if seen_m is not None and z_m <= seen_m:
        raise ConfigError(f"{name} would be at z = {z_m:.6g} m: {floor_note(scene, seen_m)}")


def _surfaces_below_m(scene: Scene, from_m: FloatArray) -> FloatArray:
    """Return the height [m] of the first surface below each place (n, 3) that has one."""
    high, low = from_m[:, 2].copy(), np.full(len(from_m), scene.bounds_m[0, 2] - 1.0)

    def blocked(z_m: FloatArray) -> npt.NDArray[np.bool_]:
        return segments_blocked(scene.bvh, from_m, np.column_stack((from_m[:, :2], z_m)))

    found = blocked(low)
    for _ in range(HALVINGS):
        middle = 0.5 * (high + low)
        hit = blocked(middle)
        low, high = np.where(hit, middle, low), np.where(hit, high, middle)
    below: FloatArray = low[found]
    return below


def refuse_buried(scene: Scene, points_m: npt.ArrayLike, *, name: str) -> None:
    """Refuse places of receivers outside the room or in a solid.

    Parameters
    ----------
    scene : The room.
    points_m : (n, 3) array_like — Places [m].
    name : What a place is called, such as "pose".
    """
    points = np.asarray(points_m, dtype=np.float64).reshape(-1, 3)
    in_solid = scene.inside_solid(points)
    hidden = in_solid | ~scene.inside_room(points)
    if not hidden.any():
        return
    first = int(np.argmax(hidden))
    where = ", ".join(f"{c:.6g}" for c in points[first])
    msg = (
        f"{name} {first + 1} puts the reader at ({where}) m, "
        f"{'inside a solid object' if in_solid[first] else 'outside the room'}; move it."
    )
    raise ConfigError(msg)


def solid_wall_notes(study: Study, scene: Scene) -> tuple[str, ...]:
    """Return a line for each material of walls that are drawn with two faces, with transmission.

    Parameters
    ----------
    study, scene : A study and one of its rooms [m].
    """
    if not study.solver.transmission:
        return ()
    materials = study_materials(study)
    notes: dict[str, str] = {}
    for number, corners in enumerate(scene.solids):
        thickness, width = _plate_m(corners)
        labels = np.unique(scene.facets.facet_material[scene.facet_part == number])
        for label in (scene.material_names[i] for i in labels):
            here = materials.get(label)
            if here is not None and (text := _solid_wall(here, thickness, width)):
                notes.setdefault(label, text)
    return tuple(notes.values())


def _solid_wall(material: Material, solid_m: float, width_m: float) -> str:
    wall_m = material.thickness_m or sum(layer.thickness_m or 0.0 for layer in material.layers)
    where = f"a closed part of {material.name!r}, {solid_m:.3g} m thick,"
    if wall_m > 0.0 and solid_m < max(3.0 * wall_m, LENGTHS.step_m):
        return (
            f"{where} has a material {wall_m:.3g} m thick on both its faces, so that what passes "
            "it loses as in two walls; draw the wall as one sheet in its middle."
        )
    conducts = material.is_pec or material.sigma_c_s_per_m >= OPAQUE_S_PER_M
    flat = solid_m <= min(THIN_M, FLAT * width_m)
    if wall_m == 0.0 and flat and not conducts:
        return (
            f"{where} lets nothing through, since a material without thickness_m fills all behind "
            f"its face; draw the wall as one sheet of thickness_m = {solid_m:.3g}."
        )
    return ""


def _plate_m(corners_m: FloatArray) -> tuple[float, float]:
    """Return a closed part's thickness across its largest triangle, and width by its area [m]."""
    a, b, c = np.moveaxis(corners_m - corners_m[0, 0], 1, 0)
    normal = np.cross(b - a, c - a)
    twice = np.linalg.norm(normal, axis=1)
    largest = int(np.argmax(twice))
    across = (corners_m - corners_m[0, 0]) @ (normal[largest] / twice[largest])
    return float(np.ptp(across)), 0.5 * float(twice.sum()) ** 0.5


def opaque_wall_note(study: Study, scene: Scene, unreached: int) -> str:
    """Return a line of advice where places stay without a path behind walls of known thickness.

    Parameters
    ----------
    study, scene : A study and one of its rooms.
    unreached : Places without any path [-].
    """
    if unreached == 0 or study.solver.transmission:
        return ""
    materials = study_materials(study)
    walls = [
        here.name
        for label in scene.material_names
        if (here := materials.get(label)) is not None
        and not here.is_pec
        and (here.thickness_m or here.layers)
    ]
    if not walls:
        return ""
    return (
        f"{unreached} places are without a path, and walls of {walls[0]} have a thickness, but let "
        "nothing through unless the study asks: solver.transmission = true."
    )


def opaque_sheet_note(study: Study, scene: Scene) -> str:
    """Return a line of advice where inner walls that waves pass in truth let nothing through.

    Inner walls: upright facets, nearly as high as the room, inside its hull, of a material that is
    not metal and has a thickness, or drawn with both faces.

    Parameters
    ----------
    study, scene : A study and one of its rooms.
    """
    if study.solver.transmission or not scene.has_room:
        return ""
    materials = study_materials(study)
    inner = _inner_walls(scene)
    for label in dict.fromkeys(scene.material_names[m] for m, _ in inner):
        here = materials.get(label)
        if here is None or here.is_pec or here.sigma_c_s_per_m >= OPAQUE_S_PER_M:
            continue
        walls = [box for m, box in inner if scene.material_names[m] == label]
        if not (here.thickness_m or here.layers) and not _face_each_other(walls):
            continue
        thickness = "" if here.thickness_m or here.layers else " and the walls a thickness_m"
        return (
            f"inner walls of {here.name} let nothing through, since solver.transmission is off: "
            f"rooms behind them get no signal, where a real wall costs some dB; give "
            f"solver.transmission = true{thickness}."
        )
    return ""


def _inner_walls(scene: Scene) -> list[tuple[int, FloatArray]]:
    """Return material and bounds (2, 3) [m] of the largest upright facets in the room's hull."""
    corners, facet = scene.triangle_corners_m, scene.triangle_facet
    normal = scene.facets.plane_normal[scene.facets.facet_plane]
    inside = scene.supporting_side[scene.facets.facet_plane] == 0
    height = float(np.ptp(scene.bounds_m[:, 2]))
    count = len(normal)
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, facet, corners.min(axis=1))
    np.maximum.at(high, facet, corners.max(axis=1))
    size = high - low
    tall = inside & (np.abs(normal[:, 2]) < FLAT) & (size[:, 2] >= TALL * height)
    found = np.flatnonzero(tall)
    largest = found[np.argsort(-np.hypot(size[found, 0], size[found, 1]))][:MOST_WALLS]
    index = scene.facets.facet_material
    return [(int(index[i]), np.stack([low[i], high[i]])) for i in largest]


def _face_each_other(walls: list[FloatArray]) -> bool:
    """Return whether two of some upright facets stand close, as a wall's two faces do."""
    for i, one in enumerate(walls):
        for other in walls[i + 1 :]:
            gap = np.maximum(one[0], other[0]) - np.minimum(one[1], other[1])
            if np.sum(gap[:2] < -LENGTHS.step_m) == 1 and 0.0 < gap[:2].max() <= THIN_M:
                return True
    return False
