"""The bodies of a study's room and furniture, and the materials that their labels stand for."""

from collections.abc import Sequence
from dataclasses import replace

import msgspec
import numpy as np

from octant.em.medium.materials import Material, material
from octant.geometries.bodies import Body
from octant.geometries.furniture import box, cabinet, cylinder, sphere
from octant.geometries.mesh_files import Reading, load_bodies, mesh_object
from octant.geometries.rooms import Doorway, box_room, prism_room
from octant.reader_design.study_file.materials import (
    material_arguments,
    material_label,
    material_specs,
    surface_labels,
)
from octant.reader_design.study_file.room import (
    Cabinet,
    Cylinder,
    MeshObject,
    Room,
    RoomMaterial,
    RoomMesh,
    RoomObject,
    Sphere,
)
from octant.reader_design.study_file.schema import Study


def study_materials(study: Study) -> dict[str, Material]:
    """Return the meaning of every label of a study.

    Parameters
    ----------
    study : A checked study.
    """
    specs = (spec for _, spec in material_specs(study))
    return {material_label(spec): material(material_arguments(spec)) for spec in specs}


def room_bodies(room: Room) -> tuple[Body, ...]:
    """Return the room itself, without its objects; nothing in free space.

    Parameters
    ----------
    room : Any room of a study [m].
    """
    if room.free_space:
        return ()
    if isinstance(room.mesh, str):
        only = RoomMesh(
            file=room.mesh,
            unit=room.unit,
            up=room.up,
            materials=room.materials,
            geometry=room.geometry,
            height_m=room.height_m,
            metres_per_pixel=room.metres_per_pixel,
            resource_path=room.resource_path,
        )
        return _moved(_loaded(only, room.material), room.origin_m)
    if room.mesh is not None:
        loaded = [body for mesh in room.mesh for body in _loaded(mesh, room.material)]
        return _moved(tuple(loaded), room.origin_m)
    labels = surface_labels(room)
    doorways = [Doorway(**msgspec.structs.asdict(door)) for door in room.doorways]
    if room.box_m is not None:
        return box_room(room.box_m, origin_m=room.origin_m, materials=labels, doorways=doorways)
    return prism_room(
        room.outline_m or (),
        room.height_m or 0.0,
        origin_m=room.origin_m,
        materials=labels,
        doorways=doorways,
    )


def object_bodies(objects: Sequence[RoomObject]) -> tuple[Body, ...]:
    """Return the furniture and other objects of a room.

    Parameters
    ----------
    objects : The tables ``[[room.object]]`` [m], [deg].
    """
    bodies: list[Body] = []
    for i, item in enumerate(objects):
        bodies.extend(_object(item, name=item.name or f"{type(item).__name__.lower()} {i + 1}"))
    return tuple(bodies)


def _object(item: RoomObject, *, name: str) -> tuple[Body, ...]:
    label = material_label(item.material)
    where, yaw = item.position_m, item.yaw_deg
    if isinstance(item, MeshObject):
        return mesh_object(
            item.file,
            unit=item.unit,
            up=item.up,
            material=label,
            materials_by_name=_labels(item),
            position_m=where,
            yaw_deg=yaw,
            name=name,
            reading=_reading(item),
        )
    if isinstance(item, Cylinder):
        size = (item.radius_m, item.height_m)
        return (cylinder(*size, material=label, position_m=where, yaw_deg=yaw, name=name),)
    if isinstance(item, Sphere):
        return (sphere(item.radius_m, material=label, position_m=where, yaw_deg=yaw, name=name),)
    make = cabinet if isinstance(item, Cabinet) else box
    return (make(item.size_m, material=label, position_m=where, yaw_deg=yaw, name=name),)


def _loaded(mesh: RoomMesh, default: str | RoomMaterial | None) -> tuple[Body, ...]:
    given = mesh.material if mesh.material is not None else default
    return load_bodies(
        mesh.file,
        unit=mesh.unit,
        up=mesh.up,
        material=None if given is None else material_label(given),
        materials_by_name=_labels(mesh),
        reading=_reading(mesh),
    )


def _labels(mesh: RoomMesh | MeshObject) -> dict[str, str]:
    return {name: material_label(spec) for name, spec in mesh.materials.items()}


def _reading(mesh: RoomMesh | MeshObject) -> Reading:
    return Reading(
        geometry=mesh.geometry or "visual",
        height_m=mesh.height_m,
        metres_per_pixel=mesh.metres_per_pixel,
        resource_path=mesh.resource_path,
    )


def _moved(bodies: tuple[Body, ...], origin_m: tuple[float, float, float]) -> tuple[Body, ...]:
    shift = np.array(origin_m)
    return tuple(replace(body, vertices_m=body.vertices_m + shift) for body in bodies)
