"""What depends on a scene alone, computed once for all sources in it, and forgotten with it."""

import weakref
from collections.abc import Callable, Hashable
from typing import Any, TypeVar, cast

from octant.geometries.scene import Scene

Value = TypeVar("Value")

MOST_KEPT = 16
"""Values [-] kept for one scene; the oldest goes first."""

_KEPT: dict[int, dict[Hashable, Any]] = {}


def once(scene: Scene, key: Hashable, compute: Callable[[], Value]) -> Value:
    """Return what a function computes of a scene; the same object when it is asked for again.

    Threads that ask at once may compute it twice.

    Parameters
    ----------
    scene : The scene, by identity.
    key : What the value is, and all else that it depends on.
    compute : Returns a value that nobody changes.
    """
    number = id(scene)
    if number not in _KEPT:
        _KEPT[number] = {}
        weakref.finalize(scene, _KEPT.pop, number, None)
    kept = _KEPT[number]
    if key not in kept:
        kept[key] = compute()
        while len(kept) > MOST_KEPT:
            kept.pop(next(iter(kept)))
    return cast("Value", kept[key])
