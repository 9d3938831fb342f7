# ruff: noqa: ANN401  numba's objects carry no types
"""Which kernels a piece of work will need, as a list, so that another process can compile them.

A list is a JSON object of two tables. ``records`` has the kinds of the fields of each named tuple
that kernels take, ``kernels`` the kinds of the arguments of each kernel:
``"octant.geometries._bvh_kernels:build": ["float64[2C]", "int64"]``; a list of kinds is a tuple.
Further kinds of the same kernel or named tuple stand under its name with ``#2`` behind it.
"""

import importlib
import inspect
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, Self

from numba import types

from octant.geometries.kept_code import KeptCode
from octant.geometries.kernels import Kernel

ARRAY = re.compile(r"(\w+)\[(\d)([CFA])\]$")


def compile_listed(listed: dict[str, Any], names: Iterable[str]) -> int:
    """Compile kernels of a list, so that they are kept; return how many could be [-].

    A kernel that the list describes wrongly is left out: who needs it compiles it.

    Parameters
    ----------
    listed, names : The list, and the names of kernels in it, in the order in which to compile.
    """
    done = 0
    for name in names:
        try:
            kernel = kernel_named(name)
            kinds = tuple(_kind(text, listed["records"]) for text in listed["kernels"][name])
            if len(inspect.signature(kernel.py_func).parameters) == len(kinds):
                kernel.prepare(kinds)
                done += 1
        except Exception:  # noqa: BLE001, S112  see above: nothing may end the process
            continue
    return done


def kernel_named(name: str) -> Kernel:
    """Return a kernel.

    Parameters
    ----------
    name : As in lists.
    """
    found: Kernel = _named(name)
    return found


@contextmanager
def looked_up(seen: Callable[[Any, tuple[Any, ...]], None]) -> Iterator[None]:
    """Have a function called with each kernel that is looked up on disk while the block runs.

    Parameters
    ----------
    seen : Takes the kernel's Python function and the kinds of its arguments.
    """
    load = KeptCode.load_overload

    def loading(keeper: KeptCode, sig: Any, context: Any) -> Any:
        seen(keeper.function, getattr(sig, "args", sig))
        return load(keeper, sig, context)

    KeptCode.load_overload = loading
    try:
        yield
    finally:
        KeptCode.load_overload = load


class Recorded:
    """The kernels that are looked up on disk while the block runs: ``names``, in order of need.

    Parameters
    ----------
    listed : List to which they are added; None: an empty one.
    """

    def __init__(self, listed: dict[str, Any] | None = None) -> None:
        self.listed: dict[str, Any] = listed or {"records": {}, "kernels": {}}
        self.names: list[str] = []
        self._watched = looked_up(self._add)

    def __enter__(self) -> Self:
        self._watched.__enter__()
        return self

    def __exit__(self, *_: object) -> None:
        self._watched.__exit__(None, None, None)

    def _add(self, function: Any, kinds: tuple[Any, ...]) -> None:
        texts = [self._text(kind) for kind in kinds]
        name = _entered(self.listed["kernels"], function, texts)
        if name not in self.names:
            self.names.append(name)

    def _text(self, kind: Any) -> Any:
        if isinstance(kind, types.Array):
            return f"{kind.dtype}[{kind.ndim}{kind.layout}]"
        if not isinstance(kind, types.BaseTuple):
            return str(kind)
        texts = [self._text(each) for each in kind.types]
        if isinstance(kind, types.BaseNamedTuple):
            return _entered(self.listed["records"], kind.instance_class, texts)
        return texts


def _entered(table: dict[str, Any], thing: Any, texts: list[Any]) -> str:
    name = f"{thing.__module__}:{thing.__qualname__}"
    number, key = 1, name
    while table.setdefault(key, texts) != texts:
        number += 1
        key = f"{name}#{number}"
    return key


def _kind(text: Any, records: dict[str, Any]) -> Any:
    if isinstance(text, list):
        return types.BaseTuple.from_types([_kind(each, records) for each in text])
    if ":" in text:
        fields = [_kind(each, records) for each in records[text]]
        return types.BaseTuple.from_types(fields, _named(text))
    array = ARRAY.match(text)
    if array is None:
        return types.boolean if text == "bool" else getattr(types, text)
    return types.Array(_kind(array[1], records), int(array[2]), array[3])


def _named(name: str) -> Any:
    module, _, inside = name.partition("#")[0].partition(":")
    return getattr(importlib.import_module(module), inside)
