"""Names: the nearest of those that exist, and one that is still free."""

import difflib
from collections.abc import Iterable


def nearest_name(given: str, allowed: Iterable[str], *, least_likeness: float = 0.0) -> str | None:
    """Return the allowed name most like a mistyped one, or None; case does not count.

    Parameters
    ----------
    given : The name that was not found.
    allowed : The names that exist.
    least_likeness : Likeness from 0 to 1 [-] that it must reach; with 0 every name is near enough.
    """
    folded = {name.casefold(): name for name in allowed}
    hits = difflib.get_close_matches(given.casefold(), folded, n=1, cutoff=least_likeness)
    return folded[hits[0]] if hits else None


def unused_name(name: str, used: set[str]) -> str:
    """Return the name, or ``name_2``, ``name_3`` ... when it is taken, and note it as taken.

    Parameters
    ----------
    name : The name wanted.
    used : The names taken so far; the result is added.
    """
    unique, copy = name, 1
    while unique in used:
        copy += 1
        unique = f"{name}_{copy}"
    used.add(unique)
    return unique
