"""The parts of a tracking study, each computed and kept by itself, and what they leave."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.navigation.estimators.ekf_slam import SlamRecord
from octant.navigation.tracking.neighbouring import StabilityReport
from octant.reader_design.experiments.tracking.chapters import NominalRun, RssFits
from octant.reader_design.experiments.tracking.cost_scalings import CostScaling
from octant.reader_design.experiments.tracking.costs import CostRow
from octant.reader_design.experiments.tracking.results import Outcome
from octant.reader_design.experiments.tracking.room import RoomRuns
from octant.reader_design.experiments.tracking.settings import Settings
from octant.reader_design.showing.style import NamedFigure

FloatArray = npt.NDArray[np.float64]
Row = tuple[str | float | int | None, ...]
"""A row of a chapter's own table."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """One case of a tracking study.

    Parameters
    ----------
    chapter : One of ``track.chapters``; ``wheel noise`` belongs to ``neighbouring``.
    task, method : What is computed of it; empty where the chapter has one part.
    run, sigma : Number of the run or of the mesh of tags, and noise of the wheels [rad/s].
    """

    chapter: str
    task: str = ""
    method: str = ""
    run: int = 0
    sigma: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class PartRecord:
    """What a part computed; empty or None where it has no such thing.

    Parameters
    ----------
    outcomes : Errors and poses.
    fits, costs : Tables 6.1 and 8.1.
    nominal, slam, room : A nominal problem, runs of EKF SLAM, runs with RSS of the room solver.
    stability, scalings : Stability along a nominal trajectory, and how costs grow.
    rows, notes : Rows of the tables of a chapter of `further`, and the models' warnings.
    """

    outcomes: tuple[Outcome, ...] = ()
    fits: RssFits | None = None
    nominal: NominalRun | None = None
    stability: StabilityReport | None = None
    slam: SlamRecord | None = None
    room: RoomRuns | None = None
    costs: tuple[CostRow, ...] = ()
    scalings: tuple[CostScaling, ...] = ()
    rows: tuple[Row, ...] = ()
    notes: tuple[str, ...] = ()


Records = Sequence[tuple[Part, PartRecord]]
"""Parts with what they left."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChapterTable:
    """A table of a chapter: a CSV file, and shown on the page.

    Parameters
    ----------
    file, caption : Name of the file, and what it says.
    header, rows : Columns with their units in their names [m, s, deg], and values; None: none.
    """

    file: str
    caption: str
    header: tuple[str, ...]
    rows: tuple[Row, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FurtherChapter:
    """A chapter that is computed where a study names it.

    Parameters
    ----------
    heading : On the page.
    parts : Settings to its parts.
    compute : Settings and one of them to what it leaves.
    said : Settings and records to the sentences on the page.
    tables, figures : The same to its tables and figures.
    """

    heading: str
    parts: Callable[[Settings], Sequence[Part]]
    compute: Callable[[Settings, Part], PartRecord]
    said: Callable[[Settings, Records], tuple[str, ...]]
    tables: Callable[[Settings, Records], tuple[ChapterTable, ...]]
    figures: Callable[[Settings, Records], Iterator[NamedFigure]]


def rows_of(records: Records, task: str = "") -> tuple[Row, ...]:
    """Return the rows that parts left, in their order.

    Parameters
    ----------
    records, task : Parts with what they left; of which task, empty for all.
    """
    return tuple(row for part, one in records if task in ("", part.task) for row in one.rows)


def outcomes_of(records: Records) -> tuple[Outcome, ...]:
    """Return the outcomes that parts left, in their order ([m], [rad]).

    Parameters
    ----------
    records : Parts with what they left.
    """
    return tuple(outcome for _, one in records for outcome in one.outcomes)


def middle_and_90(values: FloatArray) -> tuple[float, float]:
    """Return the median and the 90 % quantile over the runs, in the unit of the values [any].

    Parameters
    ----------
    values : (r,) float64 — One for each run [any].
    """
    return float(np.median(values)), float(np.quantile(values, 0.9))
