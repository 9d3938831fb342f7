"""The tables of a study file that describe a room, its materials and what stands in it."""

from typing import Annotated, ClassVar, Literal

import msgspec
from msgspec import Meta

from octant.reader_design.study_file.quantities import (
    Angle,
    Conductivity,
    Coordinate,
    CountOrZero,
    Distance,
    Extent,
    FileName,
    Permittivity,
    Point,
    Size,
    Spot,
    Thickness,
    Word,
)

UpAxis = Literal["y", "z"]
WorldGeometry = Literal["visual", "collision"]


class Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One table of the study file: immutable, keys by name only, unknown keys refused."""


class LayerTable(Table, frozen=True, kw_only=True):
    """One layer of a wall: ``layers = [{material = "plasterboard", thickness_m = 0.0125}, ...]``.

    Parameters
    ----------
    material, name : Name of the material table in force (`octant materials`); either key, instead
        of ``eps_r``.
    eps_r : Real part of the relative permittivity [-], at least 1.
    sigma_s_per_m : Conductivity [S/m].
    thickness_m : Thickness [m]; only the last layer may go without, and then fills all that lies
        behind.
    """

    material: Word | None = None
    name: Word | None = None
    eps_r: Permittivity | None = None
    sigma_s_per_m: Conductivity | None = None
    thickness_m: Thickness | None = None


Layers = Annotated[tuple[LayerTable, ...], Meta(min_length=2, max_length=100)]


class MaterialTable(Table, frozen=True, kw_only=True):
    """A material written out in the study file.

    Parameters
    ----------
    name : Name of the material table in force (`octant materials`); instead of ``eps_r``.
    eps_r : Real part of the relative permittivity [-], at least 1.
    sigma_s_per_m : Conductivity [S/m].
    thickness_m : Thickness [m] of a finite slab; None makes the wall a half-space.
    layers : Layers from the front (where the mesh's outward normal points; in a parametric room the
        inside) to the back, instead of all the other keys.
    """

    name: Word | None = None
    eps_r: Permittivity | None = None
    sigma_s_per_m: Conductivity | None = None
    thickness_m: Thickness | None = None
    layers: Layers | None = None


MaterialSpec = Word | MaterialTable


class RoomMaterial(Table, frozen=True, kw_only=True):
    """The material of a parametric room: one for all surfaces, or one for each kind of surface.

    Parameters
    ----------
    name, eps_r, sigma_s_per_m, thickness_m, layers : As in `MaterialTable`: one material for the
        whole room ([-], [S/m], [m]).
    walls, floor, ceiling : A material for each kind of surface; all three are given, or none.
    """

    name: Word | None = None
    eps_r: Permittivity | None = None
    sigma_s_per_m: Conductivity | None = None
    thickness_m: Thickness | None = None
    layers: Layers | None = None
    walls: MaterialSpec | None = None
    floor: MaterialSpec | None = None
    ceiling: MaterialSpec | None = None


class Placed(Table, frozen=True, kw_only=True):
    """What every object of a room has.

    Parameters
    ----------
    name : Name of the body; None numbers it by its kind.
    position_m : (3,) tuple of float — Lowest corner (box, cabinet), centre of the base (cylinder),
        centre (sphere) or origin (mesh), in the frame of the room, or of the reader [m].
    yaw_deg : Turn about the vertical through ``position_m``, counter-clockwise from above [deg].
    """

    name: Word | None = None
    position_m: Point
    yaw_deg: Angle = 0.0


class Cabinet(Placed, frozen=True, kw_only=True, tag_field="kind", tag="cabinet"):
    """A closed file cabinet: ``[[room.object]]`` with ``kind = "cabinet"``.

    Parameters
    ----------
    size_m : (3,) tuple of float — Extent along its own x, y and z [m].
    material : Its material.
    """

    placed_by: ClassVar[str] = "its lowest corner"
    size_m: Size
    material: MaterialSpec = "metal"


class Box(Placed, frozen=True, kw_only=True, tag_field="kind", tag="box"):
    """A solid box: ``[[room.object]]`` with ``kind = "box"``.

    Parameters
    ----------
    size_m : (3,) tuple of float — Extent along its own x, y and z [m].
    material : Its material.
    """

    placed_by: ClassVar[str] = "its lowest corner"
    size_m: Size
    material: MaterialSpec


class Cylinder(Placed, frozen=True, kw_only=True, tag_field="kind", tag="cylinder"):
    """An upright solid cylinder: ``[[room.object]]`` with ``kind = "cylinder"``.

    Parameters
    ----------
    radius_m, height_m : Radius and height [m].
    material : Its material.
    """

    placed_by: ClassVar[str] = "the centre of its base"
    radius_m: Extent
    height_m: Extent
    material: MaterialSpec


class Sphere(Placed, frozen=True, kw_only=True, tag_field="kind", tag="sphere"):
    """A solid sphere: ``[[room.object]]`` with ``kind = "sphere"``.

    Parameters
    ----------
    radius_m : Radius [m].
    material : Its material.
    """

    placed_by: ClassVar[str] = "its centre"
    radius_m: Extent
    material: MaterialSpec


class MeshObject(Placed, frozen=True, kw_only=True, tag_field="kind", tag="mesh"):
    """An object read from a mesh file: ``[[room.object]]`` with ``kind = "mesh"``.

    Parameters
    ----------
    file : Mesh file, relative to the study file.
    unit : Length unit of the file, such as m, cm, mm, in; needed unless the format declares one.
    up : The file's vertical axis, ``y`` or ``z``; None: y for GLB and GLTF, z for the others.
    material : Material of every body that ``materials`` does not name.
    materials : Material by the name of the body in the file.
    geometry, height_m, metres_per_pixel, resource_path : As in ``[[room.mesh]]`` ([m]).
    """

    placed_by: ClassVar[str] = "the origin of its file"
    file: FileName
    unit: Word | None = None
    up: UpAxis | None = None
    material: MaterialSpec
    materials: dict[Word, MaterialSpec] = {}
    geometry: WorldGeometry | None = None
    height_m: Extent | None = None
    metres_per_pixel: Distance | None = None
    resource_path: Annotated[tuple[FileName, ...], Meta(max_length=100)] = ()


RoomObject = Cabinet | Box | Cylinder | Sphere | MeshObject


class RoomMesh(Table, frozen=True, kw_only=True):
    """One mesh file of a room: ``[[room.mesh]]``.

    Parameters
    ----------
    file : Mesh file, relative to the study file.
    unit : Length unit of the file, such as m, cm, mm, in; needed unless the format declares one.
    up : The file's vertical axis, ``y`` or ``z``; None: y for GLB and GLTF, z for the others.
    material : Material of every body that ``materials`` does not name.
    materials : Material by the name of the body in the file.
    geometry : Of SDF and URDF files: ``visual``, what is seen, or ``collision``.
    height_m : Height of the walls of a floor plan (YAML of a map, picture, DXF) [m]; None: 2.5 m.
    metres_per_pixel : Scale of a floor plan that is a picture (PNG, JPEG, ...), which needs it [m].
    resource_path : Folders in which an SDF or URDF file finds ``model://`` and ``package://``,
        besides its own, its ``models`` folders and those of GZ_SIM_RESOURCE_PATH.
    """

    file: FileName
    unit: Word | None = None
    up: UpAxis | None = None
    material: MaterialSpec | None = None
    materials: dict[Word, MaterialSpec] = {}
    geometry: WorldGeometry | None = None
    height_m: Extent | None = None
    metres_per_pixel: Distance | None = None
    resource_path: Annotated[tuple[FileName, ...], Meta(max_length=100)] = ()


class DoorwayTable(Table, frozen=True, kw_only=True):
    """An opening in a wall of a parametric room, from the floor up: ``[[room.doorway]]``.

    Parameters
    ----------
    wall : Number of the wall: wall i runs from corner i of the outline to corner i + 1; in a box,
        wall 0 is at the lowest y and the others follow counter-clockwise.
    offset_m : Distance from the wall's first corner to the opening [m].
    width_m : Width [m].
    height_m : Height [m], less than the room's.
    """

    wall: CountOrZero
    offset_m: Extent
    width_m: Extent
    height_m: Extent


class Room(Table, frozen=True, kw_only=True):
    """The room and what stands in it: table ``[room]``.

    Exactly one of ``box_m``, ``outline_m``, ``mesh`` and ``free_space`` says what the room is.

    Parameters
    ----------
    box_m : (3,) tuple of float or None — Inner size of a box room along x, y and z [m].
    outline_m : Corners (x, y) of a room of any outline with vertical walls [m], at least three.
    height_m : Height of the room that ``outline_m`` describes, or of the walls where ``mesh`` is a
        floor plan (YAML of a map, picture, DXF; None: 2.5 m) [m].
    metres_per_pixel : As in ``[[room.mesh]]``, where ``mesh`` is one picture [m].
    mesh : Mesh file, SDF or URDF world, or floor plan; or several ``[[room.mesh]]`` tables.
    unit : Length unit of ``mesh`` where that is one file.
    up : Vertical axis of ``mesh``, ``y`` or ``z``, where that is one file.
    geometry, resource_path : As in ``[[room.mesh]]``, where ``mesh`` is one file.
    free_space : True: no room at all, only the objects.
    origin_m : (3,) tuple of float — Where the lowest corner of ``box_m``, the origin of
        ``outline_m`` or of the meshes lies [m].
    floor_m : Height coordinate of the floor of ``mesh``, or in free space of the objects, above
        which ``reader.height_m`` and ``map.height_m`` count [m]; None: the lowest point.
    material : Material of a parametric room, or of the bodies of ``mesh``.
    materials : Material by body name, where ``mesh`` is one file.
    doorways : Openings in the walls of a parametric room: the tables ``[[room.doorway]]``.
    objects : Furniture and other objects: the tables ``[[room.object]]``.
    """

    box_m: Size | None = None
    outline_m: Annotated[tuple[Spot, ...], Meta(min_length=3, max_length=10_000)] | None = None
    height_m: Extent | None = None
    metres_per_pixel: Distance | None = None
    mesh: FileName | tuple[RoomMesh, ...] | None = None
    unit: Word | None = None
    up: UpAxis | None = None
    geometry: WorldGeometry | None = None
    resource_path: Annotated[tuple[FileName, ...], Meta(max_length=100)] = ()
    free_space: bool = False
    origin_m: Point = (0.0, 0.0, 0.0)
    floor_m: Coordinate | None = None
    material: Word | RoomMaterial | None = None
    materials: dict[Word, MaterialSpec] = {}
    doorways: tuple[DoorwayTable, ...] = msgspec.field(default=(), name="doorway")
    objects: tuple[RoomObject, ...] = msgspec.field(default=(), name="object")
