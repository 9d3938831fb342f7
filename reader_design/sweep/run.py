"""The sweep over designs: a plan, one small file for each cell, and going on where it stopped.

Every cell's file is named by the hash of its full input, written under a temporary name and then
renamed: whatever ends a sweep, only cells in flight are lost, and running it again computes what is
missing. The process that started the sweep writes all files, so an executor's workers need not see
its disk.
"""

import itertools
from collections.abc import Iterator
from concurrent.futures import Executor, Future, as_completed
from dataclasses import dataclass, replace
from pathlib import Path

from octant.geometries.errors import SweepStateError
from octant.reader_design.config.schema import Study, Sweep
from octant.reader_design.progress import Progress
from octant.reader_design.sweep.cell_files import read_cell, write_cell
from octant.reader_design.sweep.cells import (
    Cell,
    SweepContext,
    cell_key,
    compute_cell,
    failed_cell,
    scene_fingerprint,
)
from octant.reader_design.sweep.design import ReaderDesign, design_of


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepPlan:
    """What a sweep will compute.

    Attributes
    ----------
    context : SweepContext
        Study, room and sampling.
    designs : tuple of ReaderDesign
        The designs, lengths in [m].
    keys : tuple of str
        Name of each design's cell [-].
    """

    context: SweepContext
    designs: tuple[ReaderDesign, ...]
    keys: tuple[str, ...]


def designs_of(study: Study) -> tuple[ReaderDesign, ...]:
    """Return every combination of the study's sweep lists as a design; lengths in [m].

    Parameters
    ----------
    study : Study
        With its lists; an empty list leaves the reader's own value.

    Returns
    -------
    tuple of ReaderDesign
        The first list varies slowest.
    """
    base = design_of(study.reader)
    names = [name for name in Sweep.__struct_fields__ if getattr(study.sweep, name)]
    lists = [getattr(study.sweep, name) for name in names]
    return tuple(
        replace(base, **dict(zip(names, values, strict=True)))
        for values in itertools.product(*lists)
    )


def plan_sweep(context: SweepContext) -> SweepPlan:
    """Return the cells that a study asks for; lengths in [m].

    Parameters
    ----------
    context : SweepContext
        Study, room and sampling.

    Returns
    -------
    SweepPlan
        Nothing is computed yet.
    """
    designs = designs_of(context.study)
    fingerprint = scene_fingerprint(context.built)
    keys = tuple(cell_key(context, design, fingerprint=fingerprint) for design in designs)
    return SweepPlan(context=context, designs=designs, keys=keys)


def cell_path(folder: Path, key: str) -> Path:
    """Return where a cell's file lies [-].

    Parameters
    ----------
    folder : Path
        Folder of the sweep's cells.
    key : str
        Name of the cell.

    Returns
    -------
    Path
        A netCDF file named by the first 32 digits of the key.
    """
    return folder / f"{key[:32]}.nc"


def run_sweep(
    plan: SweepPlan,
    folder: Path,
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> tuple[Cell, ...]:
    """Return the cells of a plan, read from their files or computed and written [-].

    Parameters
    ----------
    plan : SweepPlan
        From :func:`plan_sweep`.
    folder : Path
        Where the cells' files lie; made when missing.
    executor : concurrent.futures.Executor, optional
        Computes cells elsewhere: threads, processes (start method ``spawn``) or a cluster's. By
        default cells are computed one after another in this process, whose kernels use all cores.
    progress : Progress, optional
        Told about cells, and about files that cannot be read.

    Returns
    -------
    tuple of Cell
        In the order of the plan; a cell that failed carries its reason.

    Raises
    ------
    KeyboardInterrupt
        Passed on after the cells that have not begun are cancelled; finished ones are on disk.

    Notes
    -----
    A design that cannot be built is a result and is kept. A cell that failed for another reason
    (no memory, a broken worker) is reported but not kept, so that the next run tries it again.
    """
    progress = progress or Progress()
    cells: dict[str, Cell] = {}
    missing: list[tuple[ReaderDesign, str]] = []
    for design, key in zip(plan.designs, plan.keys, strict=True):
        found = _kept(folder, design, key, progress)
        if found is None:
            missing.append((design, key))
        else:
            cells[key] = found
    if cells:
        progress.say(f"{len(cells)} of {len(plan.keys)} designs are computed already.")
    work = _computed(plan.context, missing, executor)
    for cell, keep in progress.track(work, total=len(missing), label="designs"):
        if keep:
            write_cell(cell_path(folder, cell.key), cell, plan.context)
        if cell.reason:
            progress.say(f"{cell.design.label()} failed: {cell.reason}")
        cells[cell.key] = cell
    return tuple(cells[key] for key in plan.keys)


def _kept(folder: Path, design: ReaderDesign, key: str, progress: Progress) -> Cell | None:
    """Return the cell of a file, or None when there is none that can be used."""
    path = cell_path(folder, key)
    if not path.exists():
        return None
    try:
        return read_cell(path, design, key)
    except SweepStateError as exc:
        progress.say(f"{exc} It is computed again.")
        return None


def _computed(
    context: SweepContext, missing: list[tuple[ReaderDesign, str]], executor: Executor | None
) -> Iterator[tuple[Cell, bool]]:
    """Yield each missing cell when it is there, and whether to keep it."""
    if executor is None:
        for design, key in missing:
            yield _attempt(Future(), context, design, key)
        return
    futures = {
        executor.submit(compute_cell, context, design, key): (design, key)
        for design, key in missing
    }
    try:
        for future in as_completed(futures):
            yield _outcome(future, *futures[future])
    finally:
        for future in futures:
            future.cancel()


def _attempt(
    future: "Future[Cell]", context: SweepContext, design: ReaderDesign, key: str
) -> tuple[Cell, bool]:
    """Return a cell computed here, as a future of an executor would hold it."""
    try:
        future.set_result(compute_cell(context, design, key))
    except Exception as exc:  # noqa: BLE001  one cell's failure must not stop the others
        future.set_exception(exc)
    return _outcome(future, design, key)


def _outcome(future: "Future[Cell]", design: ReaderDesign, key: str) -> tuple[Cell, bool]:
    """Return a future's cell and True, or a failed cell and False."""
    error = future.exception()
    if error is None:
        return future.result(), True
    reason = f"unexpected {type(error).__name__}: {error}"
    return failed_cell(design, key, reason), False
