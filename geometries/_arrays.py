"""One place where arrays are checked and made read-only before they enter a frozen dataclass."""

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import GeometryError

Value = TypeVar("Value")


def read_only(value: Value) -> Value:
    """Return an array as a read-only view, or a tuple of arrays, also a named one, as such views.

    A record that is frozen hands these out, so that nobody changes what it holds.
    """
    result: Any = value
    if isinstance(value, np.ndarray):
        result = value.view()
        result.setflags(write=False)
    elif isinstance(value, tuple):
        parts = map(read_only, value)
        result = type(value)(*parts) if hasattr(value, "_fields") else tuple(parts)
    return result  # type: ignore[no-any-return]


def frozen_array(
    value: npt.ArrayLike,
    *,
    name: str,
    shape: Sequence[int | None],
    dtype: npt.DTypeLike = np.float64,
    finite: bool = True,
    error: type[Exception] = GeometryError,
) -> npt.NDArray[Any]:
    """Return a read-only, contiguous copy, once shape and values are checked; else raise ``error``.

    Parameters
    ----------
    value : What the caller was given, in the unit that ``name`` carries.
    name : The name that an error message uses.
    shape : Expected length of each axis; None allows any length.
    dtype : Element type of the result.
    finite : Refuse NaN and infinity.
    error : Exception class to raise.
    """
    wanted = "(" + ", ".join("any" if n is None else str(n) for n in shape) + ")"
    try:
        array = np.array(value, dtype=dtype, order="C")
    except (TypeError, ValueError) as exc:
        msg = f"{name} must be an array of numbers of shape {wanted}, but {value!r} is not."
        raise error(msg) from exc
    fits = array.ndim == len(shape) and all(
        n is None or n == m for n, m in zip(shape, array.shape, strict=True)
    )
    if not fits:
        msg = f"{name} has shape {array.shape}, but {wanted} is needed."
        raise error(msg)
    if finite and array.dtype.kind in "fc" and not np.isfinite(array).all():
        msg = f"{name} holds NaN or infinite values; give finite numbers only."
        raise error(msg)
    array.setflags(write=False)
    return array
