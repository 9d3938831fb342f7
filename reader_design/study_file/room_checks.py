"""What one key of a room demands of another: ``[room]``, its objects, and those of layouts."""

from collections.abc import Iterator
from pathlib import PurePath

from octant.geometries.errors import ConfigError, GeometryError
from octant.reader_design.study_file.materials import SURFACES, material_arguments
from octant.reader_design.study_file.room import (
    MeshObject,
    Room,
    RoomMaterial,
    RoomMesh,
)
from octant.reader_design.study_file.schema import Study

PICTURES, WORLDS = ("png", "jpg", "jpeg", "pgm", "bmp", "tif", "tiff"), ("sdf", "world", "urdf")
PLANS = ("yaml", "yml", "dxf", *PICTURES)
"""Extensions of floor plans, and of worlds, as `octant.geometries.mesh_files` reads them."""


def check_rooms(study: Study, *, shapes: bool) -> None:
    """Refuse rooms whose keys contradict each other, lengths in [m].

    Parameters
    ----------
    study : Its own room and those of its layouts.
    shapes : False: leave out whether walls fit together.
    """
    _check_room("room", study.room, shapes=shapes)
    for i, layout in enumerate(study.layouts):
        if layout.room is not None:
            _check_room(f"layout[{i}].room", layout.room, shapes=shapes)
    for path, unit in _units(study):
        _check_unit(path, unit)
    for path, item in _mesh_objects(study):
        _check_mesh_keys(path, item)


def _units(study: Study) -> Iterator[tuple[str, str]]:
    rooms = [("room", study.room)]
    rooms += [(f"layout[{i}].room", e.room) for i, e in enumerate(study.layouts) if e.room]
    objects = [(path, room.objects) for path, room in rooms]
    objects += [(f"layout[{i}]", layout.objects) for i, layout in enumerate(study.layouts)]
    for path, room in rooms:
        meshes = room.mesh if isinstance(room.mesh, tuple) else ()
        named = [(path, room.unit), *((f"{path}.mesh[{i}]", m.unit) for i, m in enumerate(meshes))]
        yield from ((f"{where}.unit", unit) for where, unit in named if unit is not None)
    for path, items in objects:
        for i, item in enumerate(items):
            if isinstance(item, MeshObject) and item.unit is not None:
                yield f"{path}.object[{i}].unit", item.unit


def _mesh_objects(study: Study) -> Iterator[tuple[str, MeshObject]]:
    tables = [("room", study.room.objects), ("reader", study.reader.objects)]
    for i, layout in enumerate(study.layouts):
        tables.append((f"layout[{i}]", layout.objects))
        if layout.room is not None:
            tables.append((f"layout[{i}].room", layout.room.objects))
    for path, items in tables:
        for i, item in enumerate(items):
            if isinstance(item, MeshObject):
                yield f"{path}.object[{i}]", item


def _check_unit(path: str, unit: str) -> None:
    from octant.geometries.mesh_files import metres_per_unit

    try:
        metres_per_unit(unit)
    except GeometryError as exc:
        msg = f"{path}: {exc}"
        raise ConfigError(msg) from exc


def _check_room(path: str, room: Room, *, shapes: bool) -> None:
    kinds = {
        "box_m": room.box_m is not None,
        "outline_m": room.outline_m is not None,
        "mesh": room.mesh is not None,
        "free_space": room.free_space,
    }
    given = [key for key, there in kinds.items() if there]
    if len(given) != 1:
        what = " and ".join(given) if given else "none of box_m, outline_m, mesh and free_space"
        msg = f"{path} has {what}, but exactly one of box_m, outline_m, mesh, free_space is needed."
        raise ConfigError(msg)
    _check_belongs(path, room, given[0])
    parametric = given[0] in {"box_m", "outline_m"}
    if isinstance(room.material, RoomMaterial):
        _check_surfaces(path, room.material, parametric=parametric)
    if parametric and shapes:
        _check_shape(path, room)


def _check_belongs(path: str, room: Room, kind: str) -> None:
    one_file = isinstance(room.mesh, str)
    is_plan = isinstance(room.mesh, str) and _suffix(room.mesh) in PLANS
    is_world = isinstance(room.mesh, str) and _suffix(room.mesh) in WORLDS
    needs = {
        "height_m": (
            room.height_m is not None,
            kind == "outline_m" or is_plan,
            "outline_m or a floor plan (.yaml, .dxf, a picture)",
        ),
        "metres_per_pixel": (
            room.metres_per_pixel is not None,
            isinstance(room.mesh, str) and _suffix(room.mesh) in PICTURES,
            "a picture of a floor plan",
        ),
        "geometry": (room.geometry is not None, is_world, "mesh = FILE.sdf, .world or .urdf"),
        "resource_path": (bool(room.resource_path), is_world, "mesh = FILE.sdf, .world or .urdf"),
        "unit": (room.unit is not None, one_file, "mesh = FILE"),
        "up": (room.up is not None, one_file, "mesh = FILE"),
        "materials": (bool(room.materials), one_file, "mesh = FILE"),
        "floor_m": (room.floor_m is not None, kind in {"mesh", "free_space"}, "mesh or free_space"),
        "doorway": (bool(room.doorways), kind in {"box_m", "outline_m"}, "box_m or outline_m"),
        "material": (room.material is not None, kind != "free_space", "a room with walls"),
    }
    for key, (given, fits, owner) in needs.items():
        if given and not fits:
            this = f"a {_suffix(room.mesh)} file" if isinstance(room.mesh, str) else kind
            msg = f"{path}.{key} is given, but it belongs to {owner} only, and this room is {this}."
            raise ConfigError(msg)
    if kind == "outline_m" and room.height_m is None:
        msg = f"{path}.height_m is missing, but a room given by outline_m needs its height in m."
        raise ConfigError(msg)
    if isinstance(room.mesh, tuple) and not room.mesh:
        msg = f"{path}.mesh is an empty list, but a room needs at least one mesh file."
        raise ConfigError(msg)
    for i, mesh in enumerate(room.mesh if isinstance(room.mesh, tuple) else ()):
        _check_mesh_keys(f"{path}.mesh[{i}]", mesh)
        _check_mesh_material(f"{path}.mesh[{i}]", mesh, room)
    if isinstance(room.mesh, str) and room.material is None and not room.materials:
        _check_own_materials(path, room.mesh)


def _check_mesh_keys(path: str, mesh: RoomMesh | MeshObject) -> None:
    kind = _suffix(mesh.file)
    keys = {
        "height_m": (mesh.height_m is not None, PLANS),
        "metres_per_pixel": (mesh.metres_per_pixel is not None, PICTURES),
        "geometry": (mesh.geometry is not None, WORLDS),
        "resource_path": (bool(mesh.resource_path), WORLDS),
    }
    for key, (given, kinds) in keys.items():
        if given and kind not in kinds:
            listed = ", ".join(f".{k}" for k in kinds)
            msg = f"{path}.{key} is given, but it belongs to {listed} files, and this is .{kind}."
            raise ConfigError(msg)


def _suffix(file: str) -> str:
    return PurePath(file).suffix.lower().removeprefix(".")


def _check_own_materials(path: str, file: str) -> None:
    from octant.geometries.mesh_files import carries_materials

    if not carries_materials(file):
        msg = f"{path}.material is missing, but a mesh needs one (or materials by body name)."
        raise ConfigError(msg)


def _check_mesh_material(path: str, mesh: RoomMesh, room: Room) -> None:
    if mesh.material is None and not mesh.materials and room.material is None:
        _check_own_materials(path, mesh.file)


def _check_surfaces(path: str, material: RoomMaterial, *, parametric: bool) -> None:
    surfaces = [s for s in SURFACES if getattr(material, s) is not None]
    if not surfaces:
        return
    if not parametric:
        msg = (
            f"{path}.material names {surfaces[0]}, but only a box_m or outline_m room has walls, "
            "floor and ceiling; give materials by body name instead."
        )
        raise ConfigError(msg)
    if material_arguments(material) or len(surfaces) < len(SURFACES):
        msg = (
            f"{path}.material names {', '.join(surfaces)}, but either one material for the whole "
            "room or all of walls, floor and ceiling are needed."
        )
        raise ConfigError(msg)


def _check_shape(path: str, room: Room) -> None:
    from octant.reader_design.study_file.bodies import room_bodies

    try:
        room_bodies(room)
    except GeometryError as exc:
        msg = f"{path}: {exc}"
        raise ConfigError(msg) from exc
