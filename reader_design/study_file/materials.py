"""The materials that a study names: where they stand, what they mean, whether they exist."""

from collections.abc import Iterator, Sequence
from typing import Any

from octant.geometries.errors import ConfigError, MaterialRangeError
from octant.reader_design.study_file.room import (
    LayerTable,
    MaterialSpec,
    MaterialTable,
    MeshObject,
    Room,
    RoomMaterial,
    RoomObject,
)
from octant.reader_design.study_file.schema import Study

SURFACES = ("walls", "floor", "ceiling")
"""Surfaces of a parametric room that may have a material of their own."""
LAYER_KEYS = ("material", "name", "eps_r", "sigma_s_per_m", "thickness_m")
"""Keys of one layer."""


def material_arguments(spec: MaterialSpec | RoomMaterial) -> str | dict[str, Any]:
    """Return a material of the study file as `octant.em.medium.materials.material` takes it.

    Parameters
    ----------
    spec : A name, or a table ([-], [S/m], [m]); of a `RoomMaterial` its own keys, not its surfaces.
    """
    if isinstance(spec, str):
        return spec
    given = _given(spec, ("name", "eps_r", "sigma_s_per_m", "thickness_m"))
    if spec.layers is not None:
        return given | {"layers": [_given(layer, LAYER_KEYS) for layer in spec.layers]}
    return given["name"] if set(given) == {"name"} else given


def material_label(spec: MaterialSpec | RoomMaterial) -> str:
    """Return the label that bodies of a material carry: its name, or a table's keys and values.

    Parameters
    ----------
    spec : As the study file gives it.
    """
    arguments = material_arguments(spec)
    if isinstance(arguments, str):
        return arguments
    return " | ".join(
        ", ".join(f"{key} = {value}" for key, value in table.items())
        for table in arguments.get("layers", [arguments])
    )


def surface_labels(room: Room) -> dict[str, str]:
    """Return the label of walls, floor and ceiling of a parametric room.

    Parameters
    ----------
    room : A room given by ``box_m`` or ``outline_m``.
    """
    given = room_material(room) or "concrete"
    if isinstance(given, RoomMaterial) and given.walls is not None:
        return {surface: material_label(getattr(given, surface)) for surface in SURFACES}
    return dict.fromkeys(SURFACES, material_label(given))


def material_specs(study: Study) -> Iterator[tuple[str, MaterialSpec]]:
    """Yield every material that a study names, with its key path.

    Parameters
    ----------
    study : Any study.
    """
    yield from _room_materials("room", study.room)
    for i, layout in enumerate(study.layouts):
        if layout.room is not None:
            yield from _room_materials(f"layout[{i}].room", layout.room)
        yield from _object_materials(f"layout[{i}]", layout.objects)


def room_material(room: Room) -> str | RoomMaterial | None:
    """Return a room's material, by default ``concrete``; None: free space, or meshes' own ones.

    Parameters
    ----------
    room : The room.
    """
    parametric = room.box_m is not None or room.outline_m is not None
    return room.material or ("concrete" if parametric else None)


def check_material(path: str, spec: MaterialSpec, frequencies_hz: Sequence[float]) -> None:
    """Refuse a material that does not exist or does not cover the frequencies.

    Parameters
    ----------
    path, spec : Where the study names it, and what stands there.
    frequencies_hz : Where it is needed [Hz].
    """
    from octant.em.medium.materials import material

    if isinstance(spec, MaterialTable) and spec.layers is not None:
        _check_layers(path, spec)
    elif isinstance(spec, MaterialTable) and (spec.name is None) == (spec.eps_r is None):
        msg = (
            f"{path} gives {'both' if spec.name else 'neither'} name and eps_r, but a material "
            "table needs exactly one of them; write a known name, or eps_r and sigma_s_per_m."
        )
        raise ConfigError(msg)
    if isinstance(spec, MaterialTable) and spec.name and spec.sigma_s_per_m is not None:
        msg = (
            f"{path} gives sigma_s_per_m beside the name {spec.name!r}, which fixes it already; "
            "leave out one of the two."
        )
        raise ConfigError(msg)
    try:
        chosen = material(material_arguments(spec))
        for frequency_hz in frequencies_hz:
            chosen.layer_stack(frequency_hz)
    except MaterialRangeError as exc:
        msg = f"{path}: {exc}"
        raise ConfigError(msg) from exc


def _check_layers(path: str, spec: MaterialTable) -> None:
    beside = _given(spec, ("name", "eps_r", "sigma_s_per_m", "thickness_m"))
    if beside:
        msg = f"{path} gives {', '.join(beside)} beside layers; give these in each layer instead."
        raise ConfigError(msg)
    for i, layer in enumerate(spec.layers or ()):
        named = [key for key in ("material", "name", "eps_r") if getattr(layer, key) is not None]
        if len(named) != 1:
            msg = (
                f"{path}.layers[{i}] gives {' and '.join(named) or 'neither name nor eps_r'}, but "
                "a layer needs exactly one of material (or name) and eps_r."
            )
            raise ConfigError(msg)


def _given(table: MaterialTable | RoomMaterial | LayerTable, keys: Sequence[str]) -> dict[str, Any]:
    return {key: getattr(table, key) for key in keys if getattr(table, key) is not None}


def _room_materials(path: str, room: Room) -> Iterator[tuple[str, MaterialSpec]]:
    if isinstance(room.material, RoomMaterial):
        for surface in SURFACES:
            spec = getattr(room.material, surface)
            if spec is not None:
                yield f"{path}.material.{surface}", spec
        own = material_arguments(room.material)
        if own:
            yield f"{path}.material", _as_table(room.material)
    elif isinstance(chosen := room_material(room), str):
        yield f"{path}.material", chosen
    for name, spec in room.materials.items():
        yield f"{path}.materials.{name}", spec
    for i, mesh in enumerate(room.mesh if isinstance(room.mesh, tuple) else ()):
        if mesh.material is not None:
            yield f"{path}.mesh[{i}].material", mesh.material
        for name, spec in mesh.materials.items():
            yield f"{path}.mesh[{i}].materials.{name}", spec
    yield from _object_materials(path, room.objects)


def _object_materials(
    path: str, objects: Sequence[RoomObject]
) -> Iterator[tuple[str, MaterialSpec]]:
    for i, item in enumerate(objects):
        yield f"{path}.object[{i}].material", item.material
        if isinstance(item, MeshObject):
            for name, spec in item.materials.items():
                yield f"{path}.object[{i}].materials.{name}", spec


def _as_table(material: RoomMaterial) -> MaterialTable:
    return MaterialTable(
        name=material.name,
        eps_r=material.eps_r,
        sigma_s_per_m=material.sigma_s_per_m,
        thickness_m=material.thickness_m,
        layers=material.layers,
    )
