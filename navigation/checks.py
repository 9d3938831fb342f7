"""Checks of single values that the navigation modules share."""

from collections.abc import Sequence

import numpy as np

from octant.geometries.errors import NavigationError


def check_positive(value: float, *, name: str, unit: str, allow_zero: bool = False) -> None:
    """Refuse a value that is not positive and finite.

    Parameters
    ----------
    value : What was given [unit as named].
    name, unit : Name and unit in the message.
    allow_zero : Accept zero too.
    """
    if not np.isfinite(value) or value < 0.0 or (value == 0.0 and not allow_zero):
        allowed = "zero or positive" if allow_zero else "positive"
        msg = f"{name} is {value:g} {unit}, but it must be {allowed} and finite: correct it."
        raise NavigationError(msg)


def check_choice(value: str, allowed: Sequence[str], *, name: str) -> None:
    """Refuse a name that is not among the allowed ones.

    Parameters
    ----------
    value : What was given.
    allowed : The names there are.
    name : Name in the message.
    """
    if value not in allowed:
        msg = f"{name} is {value!r}, but it must be one of {list(allowed)}: choose one."
        raise NavigationError(msg)
