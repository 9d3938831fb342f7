"""Runs of one job that differ in their seed only, kept a few to a file."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from octant.geometries.errors import OctantError
from octant.reader_design.keeping.keeper import RecordCodec, kept_cases, map_cases
from octant.reader_design.keeping.keys import case_keys
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.workers import Crew

Result = TypeVar("Result")

RUNS_A_CASE = 5
"""Runs in one file: the same for any number of runs and of workers, so that more runs later on
find the first ones."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SeededJob:
    """A job and its base seed.

    Attributes
    ----------
    job : Makes one run from its seed; a dataclass, for its fields are part of the key.
    seed : Run i takes child i of its numpy SeedSequence.
    """

    job: Callable[[np.random.SeedSequence], object]
    seed: int


def compute_runs(context: SeededJob, case: tuple[int, ...]) -> tuple[object, ...]:
    """Return some runs of a job.

    Parameters
    ----------
    context, case : The job and the numbers of the runs.
    """
    seeds = np.random.SeedSequence(context.seed).spawn(max(case) + 1)
    return tuple(context.job(seeds[run]) for run in case)


def run_cases(runs: int) -> tuple[tuple[int, ...], ...]:
    """Return the numbers of runs, case by case.

    Parameters
    ----------
    runs : How many there are.
    """
    starts = range(0, runs, RUNS_A_CASE)
    return tuple(tuple(range(start, min(start + RUNS_A_CASE, runs))) for start in starts)


def map_seeded(
    job: Callable[[np.random.SeedSequence], Result],
    *,
    runs: int,
    seed: int,
    kind: type[Result],
    folder: Path,
    crew: Crew | None = None,
    progress: Progress | None = None,
    label: str = "runs",
) -> tuple[Result, ...]:
    """Return many runs of one job, run 0 first; those that the folder holds are read.

    Parameters
    ----------
    job : Makes one run from its seed; a picklable dataclass.
    runs, seed : Number of runs, and their base seed.
    kind : Class of the results, a dataclass of numbers, text and arrays.
    folder : Where they are kept.
    crew : From :func:`octant.reader_design.keeping.workers.open_crew`; None: this process computes.
    progress : Shows how many are done.
    label : What the runs are called in the bar.
    """
    kept = map_cases(
        compute_runs,
        run_cases(runs),
        context=SeededJob(job=job, seed=seed),
        folder=folder,
        codec=_codec(kind),
        crew=crew,
        progress=progress,
        label=f"groups of {RUNS_A_CASE} {label}",
        raises=(OctantError,),
    )
    return tuple(result for one in kept for result in one.value)


def count_seeded(
    job: Callable[[np.random.SeedSequence], Result],
    *,
    runs: int,
    seed: int,
    kind: type[Result],
    folder: Path,
) -> int:
    """Return how many of the runs the folder holds.

    Parameters
    ----------
    job, runs, seed, kind, folder : As in `map_seeded`.
    """
    cases = run_cases(runs)
    kept = kept_cases(
        compute_runs,
        cases,
        context=SeededJob(job=job, seed=seed),
        folder=folder,
        codec=_codec(kind),
    )
    return sum(len(case) for case, one in zip(cases, kept, strict=True) if one is not None)


def runs_key(job: Callable[[np.random.SeedSequence], object], *, runs: int, seed: int) -> str:
    """Return a key of all that decides the runs of a job, 64 hexadecimal digits.

    Parameters
    ----------
    job, runs, seed
        As in `map_seeded`.
    """
    return case_keys(compute_runs, [runs], context=SeededJob(job=job, seed=seed))[0]


def _codec(kind: type[Result]) -> RecordCodec[Any]:
    return RecordCodec(tuple[kind, ...])  # type: ignore[valid-type]
