"""Octant: design bearing-sensitive RFID readers, and drive robots with them.

``Room``, ``Tag``, ``Reader``, ``Mission`` and ``Study`` hold what a study file says; `sweep` varies
it, and `optimise` searches by a function of one's own; `Navigator` is the base of a navigator of
one's own; `open_results`, `audit` and `materials` read what lies on disk. They are imported when
they are first used.
"""

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from octant.reader_design.face.materials import audit, materials
    from octant.reader_design.face.mission import Mission
    from octant.reader_design.face.navigators import Command, Navigator, Odometry, Reading
    from octant.reader_design.face.optimise import optimise
    from octant.reader_design.face.reader import Reader
    from octant.reader_design.face.room import Room
    from octant.reader_design.face.study import Study, open_results
    from octant.reader_design.face.sweep import sweep
    from octant.reader_design.face.tables import Tag

__all__ = [
    "Command",
    "Mission",
    "Navigator",
    "Odometry",
    "Reader",
    "Reading",
    "Room",
    "Study",
    "Tag",
    "audit",
    "materials",
    "open_results",
    "optimise",
    "sweep",
]

_HOMES = {
    "Command": "navigators",
    "Mission": "mission",
    "Navigator": "navigators",
    "Odometry": "navigators",
    "Reader": "reader",
    "Reading": "navigators",
    "Room": "room",
    "Study": "study",
    "Tag": "tables",
    "audit": "materials",
    "materials": "materials",
    "open_results": "study",
    "optimise": "optimise",
    "sweep": "sweep",
}
"""Module of `octant.reader_design.face` that holds each name."""

_ROOT = Path(__file__).resolve().parent.parent
if (_ROOT / "geometries" / "scene.py").is_file():
    # A clone that is not installed: the layers stand beside this folder instead of inside it.
    __path__.append(str(_ROOT))


def __getattr__(name: str) -> Any:  # noqa: ANN401  a class or a function
    if name not in _HOMES:
        msg = f"module 'octant' has no attribute {name!r}; it has {', '.join(__all__)}"
        raise AttributeError(msg)
    found = getattr(import_module(f"octant.reader_design.face.{_HOMES[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
