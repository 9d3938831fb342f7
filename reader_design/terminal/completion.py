"""What the shell may complete: studies, tags, materials, antennas and meshes."""

from collections.abc import Callable, Iterable
from pathlib import Path

import click
from click.shell_completion import CompletionItem

Completer = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]

MESH_FILES = (".glb", ".gltf", ".obj", ".stl", ".ply", ".off", ".3mf", ".dae", ".xml", ".sdf")
"""Endings of files that hold a room."""
PATTERN_FILES = (".ffe", ".ffd", ".ffs", ".nec", ".out", ".msi", ".pln", ".csv")
"""Endings of files that hold an antenna's pattern."""


def files(*suffixes: str, names: Callable[[], Iterable[str]] = tuple) -> Completer:
    """Return what completes files of some endings, folders, and names.

    Parameters
    ----------
    *suffixes : Endings with their dot.
    names : Returns names that may stand in place of a file.
    """

    def complete(
        _ctx: click.Context, _param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        folder, slash, start = incomplete.rpartition("/")
        place = Path(folder + slash) if slash else Path()
        found = [name for name in names() if name.startswith(incomplete)]
        for entry in sorted(place.iterdir()) if place.is_dir() else ():
            if not entry.name.startswith(start) or entry.name.startswith("."):
                continue
            shown = f"{folder}{slash}{entry.name}"
            if entry.is_dir():
                found.append(f"{shown}/")
            elif entry.suffix.lower() in suffixes:
                found.append(shown)
        return [CompletionItem(value) for value in found]

    return complete


def built_in_studies() -> list[str]:
    """Return the names of the built-in studies."""
    from octant.reader_design.study_file.loading import BUILT_IN

    return list(BUILT_IN)


def built_in_antennas() -> list[str]:
    """Return the kinds of antennas that an end of a path can have."""
    from octant.reader_design.study_file.checks import TAG_ANTENNAS

    return sorted(TAG_ANTENNAS)


def tags(ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Return the tags of the study on the line, or of the built-in one.

    Parameters
    ----------
    ctx, _param, incomplete : As click gives them.
    """
    from octant.geometries.errors import OctantError
    from octant.reader_design.study_file.loading import load_study

    try:
        ids = [tag.id for tag in load_study(ctx.params.get("study")).tags]
    except OctantError:
        return []
    return [CompletionItem(tag) for tag in ids if tag.startswith(incomplete)]


def materials(
    _ctx: click.Context, _param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Return the materials that a study can name.

    Parameters
    ----------
    _ctx, _param, incomplete : As click gives them.
    """
    from octant.em.medium.materials import material_table

    names = [entry.name for entry in material_table()]
    return [CompletionItem(name) for name in names if name.startswith(incomplete)]
