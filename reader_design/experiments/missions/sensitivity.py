"""Errors of what navigators are told, swept until missions break: how exact a survey must be."""

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import msgspec
from msgspec import Meta

from octant.geometries.errors import ConfigError
from octant.reader_design.study_file.quantities import Name, Number, Word
from octant.reader_design.study_file.room import RoomObject, Table
from octant.reader_design.study_file.truth import Truth

if TYPE_CHECKING:
    from octant.reader_design.experiments.missions.comparison import CellOutcome

OBJECT = "object"
"""Key of ``[truth]`` whose value is how many of the error's own objects stand there."""

Keys = dict[Word, Any]


class ErrorEntry(Table, frozen=True, kw_only=True):
    """An error of what navigators are told, swept until missions break: ``[[error]]``.

    Parameters
    ----------
    name : Name in the results.
    key : The key of ``[truth]`` that is swept, or ``object``: how many of ``objects`` stand there.
    values : Its values, from the least error to the greatest, in the unit of the key.
    truth : The keys of ``[truth]`` that hold beside.
    objects : What the navigator does not know of: the tables ``[[error.object]]``.
    """

    name: Name
    key: Word
    values: Annotated[tuple[Number, ...], Meta(min_length=1, max_length=1000)]
    truth: Keys = msgspec.field(default_factory=dict)
    objects: tuple[RoomObject, ...] = msgspec.field(default=(), name="object")


def check_error(entry: ErrorEntry) -> None:
    """Refuse a key that ``[truth]`` does not have, and numbers of objects that are not given.

    Parameters
    ----------
    entry : One table ``[[error]]``.
    """
    known = sorted({field.encode_name for field in msgspec.structs.fields(Truth)})
    if entry.key not in known:
        msg = (
            f"[[error]] {entry.name!r} has the key {entry.key!r}, but [truth] has none of that "
            f"name; give one of {', '.join(known)}."
        )
        raise ConfigError(msg)
    if entry.key != OBJECT:
        return
    for value in entry.values:
        if value != int(value) or not 0 <= value <= len(entry.objects):
            msg = (
                f"[[error]] {entry.name!r} has the value {value:g}, but of {len(entry.objects)} "
                "[[error.object]] so many cannot stand there; give whole numbers up to that."
            )
            raise ConfigError(msg)


def error_truths(entry: ErrorEntry) -> Iterator[tuple[float, Keys]]:
    """Yield each value of an error, in the unit of its key, and the keys of ``[truth]`` for it.

    Parameters
    ----------
    entry : One table ``[[error]]``.
    """
    counts = entry.key == OBJECT or isinstance(getattr(Truth(), entry.key), int)
    for value in entry.values:
        given: object = int(value) if counts and value == int(value) else value
        if entry.key == OBJECT:
            given = [msgspec.to_builtins(thing) for thing in entry.objects[: int(value)]]
        yield value, {**entry.truth, entry.key: given}


def sweeps(outcomes: Sequence["CellOutcome"]) -> dict[tuple[str, str, str], list["CellOutcome"]]:
    """Return the outcomes of swept errors by layout, error and what else they have in common.

    Parameters
    ----------
    outcomes : Of all cells, the least error first.
    """
    found: dict[tuple[str, str, str], list[CellOutcome]] = {}
    for outcome in outcomes:
        cell = outcome.cell
        if cell.error:
            found.setdefault((cell.layout, cell.error, cell.driven), []).append(outcome)
    return found


BREAK_HEADER = ("layout", "error", "navigator", "bears", "breaks at", "kinds of failure there")


def break_rows(outcomes: Sequence["CellOutcome"], breaks_below: float) -> list[tuple[str, ...]]:
    """Return for each sweep up to which value missions arrive, and at which they break.

    Parameters
    ----------
    outcomes, breaks_below : Of all cells; the share of successes below which it is broken [-].
    """
    rows: list[tuple[str, ...]] = []
    for (layout, error, driven), group in sweeps(outcomes).items():
        tried = [o for o in group if o.runs]
        broken = [o for o in tried if o.successes < breaks_below * o.runs]
        fine = [o for o in tried if o not in broken]
        unbroken = f"not up to {tried[-1].cell.value:g}" if tried else "not driven"
        rows.append(
            (
                layout,
                error,
                driven,
                share_text(fine[-1]) if fine else "–",
                share_text(broken[0]) if broken else unbroken,
                failures_text(broken[0] if broken else tried[-1]) if tried else "–",
            )
        )
    return rows


def share_text(outcome: "CellOutcome") -> str:
    """Return the value of a swept error, and the runs that arrived there, in the key's unit.

    Parameters
    ----------
    outcome : A driven cell.
    """
    low, high = (100.0 * end for end in outcome.success_interval)
    share = f"{outcome.successes} of {outcome.runs}, {low:.0f} to {high:.0f} %"
    return f"{outcome.cell.value:g} ({share})"


def failures_text(outcome: "CellOutcome") -> str:
    """Return the kinds of a cell's failures and how often each, in words; no unit.

    Parameters
    ----------
    outcome : A driven cell.
    """
    return "; ".join(f"{count} {kind}" for kind, count in outcome.failures) or "none"


def broke_before(group: Sequence["CellOutcome"], breaks_below: float) -> float:
    """Return the value at which a sweep broke, in the unit of its key; NaN: it has not.

    Parameters
    ----------
    group, breaks_below : The outcomes so far; as for `break_rows` [-].
    """
    for outcome in group:
        if outcome.runs and outcome.successes < breaks_below * outcome.runs:
            return outcome.cell.value
    return math.nan
