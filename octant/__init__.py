"""Octant: design bearing-sensitive RFID readers, and drive robots with them."""

from pathlib import Path

_ROOT = Path(__file__).resolve().parent.parent
if (_ROOT / "geometries" / "scene.py").is_file():
    # A clone that is not installed: the layers stand beside this folder instead of inside it.
    __path__.append(str(_ROOT))
