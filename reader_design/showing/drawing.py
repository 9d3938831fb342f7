"""Figures drawn by workers: in groups, for what a group shows is handed over once."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import NamedTuple

from octant.reader_design.keeping.workers import Crew, begun
from octant.reader_design.showing.style import NamedFigure, figure_png

Group = Callable[[], Iterable[NamedFigure]]
"""Makes figures that belong together; picklable, such as a ``functools.partial``."""


class DrawnFigure(NamedTuple):
    """A figure as a file: section, title and caption as in `NamedFigure`."""

    file: str
    section: str
    title: str
    caption: str
    png: bytes


def drawn_figures(groups: Sequence[Group], crew: Crew | None) -> Iterator[DrawnFigure]:
    """Return the figures of all groups, in order; workers begin to draw them at once.

    Parameters
    ----------
    groups, crew : What makes them; workers that share the groups, None: this process draws.
    """
    if crew is None:
        return (one for group in groups for one in _drawn(group))
    begins = [begun(crew, _all_drawn, group) for group in groups]
    return (one for drawn in begins for one in drawn())


def _all_drawn(group: Group) -> list[DrawnFigure]:
    return list(_drawn(group))


def _drawn(group: Group) -> Iterator[DrawnFigure]:
    for one in group():
        yield DrawnFigure(one.file, one.section, one.title, one.caption, figure_png(one.figure))
