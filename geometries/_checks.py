"""Checks of single values shared by the modules that build geometry."""

import math
from collections.abc import Iterable, Mapping

from octant.geometries.errors import GeometryError
from octant.geometries.names import nearest_name


def finite_number(value: float, *, name: str, unit: str = "m") -> float:
    """Return a value as a float once it is known to be a finite number."""
    try:
        number = float(value)
    except (TypeError, ValueError) as exc:
        msg = f"{name} must be a number [{unit}], but {value!r} was given."
        raise GeometryError(msg) from exc
    if not math.isfinite(number):
        msg = f"{name} is {number} {unit}, but it must be finite."
        raise GeometryError(msg)
    return number


def positive_number(value: float, *, name: str, unit: str = "m", allow_zero: bool = False) -> float:
    """Return a value as a float once it is known to be finite and positive."""
    number = finite_number(value, name=name, unit=unit)
    if number < 0.0 or (number == 0.0 and not allow_zero):
        allowed = "zero or positive" if allow_zero else "positive"
        msg = f"{name} is {number:g} {unit}, but it must be {allowed}."
        raise GeometryError(msg)
    return number


def refuse_unknown_keys(given: Mapping[str, object], *, allowed: Iterable[str], name: str) -> None:
    """Raise when a mapping has a key that is not allowed, naming the nearest allowed one."""
    known = list(allowed)
    for key in given:
        if key not in known:
            listed = ", ".join(repr(k) for k in known)
            msg = (
                f"{name} names {key!r}, but only {listed} exist; "
                f"did you mean {nearest_name(str(key), known)!r}?"
            )
            raise GeometryError(msg)
