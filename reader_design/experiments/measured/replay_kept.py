"""The tracker over a log, tag by tag, each kept once it is done."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.navigation.logs.rounds import Rounds
from octant.navigation.navigators.place_particles import PlaceFilter
from octant.reader_design.experiments.measured.replay import Said, tracker_said
from octant.reader_design.keeping.keeper import RecordCodec, map_cases
from octant.reader_design.keeping.progress import Progress

FloatArray = npt.NDArray[np.float64]

CASES = "cases"
"""Folder of what is kept of a replay."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerTask:
    """What the tracker is given, the same for all tags.

    Parameters
    ----------
    rounds, seed : The log's rounds; of the particles.
    filters : By the number of the source.
    """

    rounds: Rounds
    seed: int
    filters: tuple[PlaceFilter, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class TagAnswers:
    """What the tracker says at each round of one tag.

    Parameters
    ----------
    bearing_rad, spread_m : (k,) float64 — As in `Said` [rad], [m].
    place_m : (k, 2) float64 — As in `Said` [m].
    """

    bearing_rad: FloatArray
    place_m: FloatArray
    spread_m: FloatArray

    def said(self) -> Iterator[Said]:
        """Yield the same, round by round [rad], [m]."""
        for bearing, (ahead, left), spread in zip(
            self.bearing_rad.tolist(), self.place_m.tolist(), self.spread_m.tolist(), strict=True
        ):
            yield Said(bearing_rad=bearing, place_m=(ahead, left), spread_m=spread)


def answers_of_tag(task: TrackerTask, source: int) -> TagAnswers:
    """Return what the tracker says of one tag [rad], [m].

    Parameters
    ----------
    task, source : What it is given, and the number of the tag.
    """
    filters = {source: task.filters[source]}
    said = list(tracker_said(task.rounds, filters, seed=task.seed))
    return TagAnswers(
        bearing_rad=np.array([one.bearing_rad for one in said]),
        place_m=np.array([one.place_m for one in said]).reshape(-1, 2),
        spread_m=np.array([one.spread_m for one in said]),
    )


def kept_said(
    task: TrackerTask, folder: Path, *, workers: int | None, cluster: str | None, progress: Progress
) -> Iterator[Said]:
    """Yield what the tracker says of each round, in order; tags that the folder holds are read.

    Parameters
    ----------
    task, folder : What it is given; where each tag's answers are kept.
    workers, cluster, progress : Who shares the tags; shows how many are done.
    """
    kept = map_cases(
        answers_of_tag,
        range(len(task.filters)),
        context=task,
        folder=folder / CASES,
        codec=RecordCodec(TagAnswers),
        workers=workers,
        cluster=cluster,
        progress=progress,
        label="tags",
    )
    each = [one.value.said() for one in kept]
    for source in task.rounds.sources.tolist():
        yield next(each[source])
