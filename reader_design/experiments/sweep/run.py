"""The sweep: one small file for each cell, and going on where it stopped.

Every cell's file is named by the hash of its full input, written under a temporary name and then
renamed: whatever ends a sweep, only cells in flight are lost, and running it again computes what is
missing. The process that started the sweep writes all files, so workers need not see its disk.
"""

import hashlib
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from concurrent.futures import CancelledError as FutureCancelledError
from dataclasses import dataclass, replace
from pathlib import Path

from octant.geometries.errors import SweepStateError
from octant.reader_design.experiments.sweep.cell_files import cell_bytes, put_bytes, read_cell
from octant.reader_design.experiments.sweep.plan import PlannedCell, SweepPlan
from octant.reader_design.keeping.folder import cell_path, sweep_folder
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.versions import versions
from octant.reader_design.keeping.workers import Crew, GivenExecutor
from octant.reader_design.setting.evaluation import Cell, compute_cell, failed_cell

AHEAD = 2
"""Cells handed out for each worker [-]: one that it computes and one that waits for it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WrittenCell:
    """A cell that has just been computed and lies on disk.

    Attributes
    ----------
    planned : PlannedCell
        What was asked for.
    cell : Cell
        What came out.
    sha256 : str
        Hash of its file's content.
    """

    planned: PlannedCell
    cell: Cell
    sha256: str


def run_sweep(
    plan: SweepPlan,
    folder: Path,
    *,
    executor: Executor | None = None,
    crew: Crew | None = None,
    progress: Progress | None = None,
) -> tuple[Cell, ...]:
    """Return the cells of a plan, read from their files or computed and written.

    Parameters
    ----------
    plan : SweepPlan
        From :func:`octant.reader_design.experiments.sweep.plan.plan_sweep`.
    folder : Path
        Where the cells' files lie; made when missing.
    executor : concurrent.futures.Executor, optional
        Computes cells elsewhere: threads, processes (start method ``spawn``) or a cluster's.
    crew : Crew, optional
        The same, from :func:`octant.reader_design.keeping.workers.open_crew`. With neither, cells
        are computed one after another in this process.
    progress : Progress, optional
        Told about cells, and about files that cannot be read.

    Returns
    -------
    tuple of Cell
        In the order of the plan; a cell that failed carries its reason.

    Raises
    ------
    ConfigError
        When a file cannot be written; those written before are kept.
    KeyboardInterrupt
        Passed on after the cells that have not begun are cancelled; finished ones are on disk.

    Notes
    -----
    A design that cannot be built is a result and is kept. A cell that failed for another reason
    (no memory, a killed worker) is kept with its reason too, but the next run tries it again.
    """
    progress = progress or Progress()
    if executor is not None:
        crew = GivenExecutor(executor)
    cells: dict[str, Cell] = {}
    missing: list[PlannedCell] = []
    with sweep_folder(folder):
        for planned in plan.cells:
            found = _kept(folder, planned, progress)
            if found is None:
                missing.append(planned)
            else:
                cells[planned.key] = found
        if cells:
            progress.say(f"{len(cells)} of {len(plan.cells)} designs are computed already.")
        for written in compute_missing(missing, folder, crew=crew, progress=progress):
            cells[written.planned.key] = written.cell
    return tuple(replace(cells[p.key], label=p.label) for p in plan.cells)


def _kept(folder: Path, planned: PlannedCell, progress: Progress) -> Cell | None:
    """Return the cell of a file, or None when there is none that can be used."""
    path = cell_path(folder, planned.key)
    if not path.exists():
        return None
    try:
        cell = read_cell(path, planned.design, planned.key)
    except SweepStateError as exc:
        progress.say(f"{exc} It is computed again.")
        return None
    return None if cell.unexpected else cell


def compute_missing(
    missing: Sequence[PlannedCell], folder: Path, *, crew: Crew | None, progress: Progress
) -> Iterator[WrittenCell]:
    """Yield cells as they are computed and written, in any order; powers in [W].

    Parameters
    ----------
    missing : sequence of PlannedCell
        What to compute; cells of one name are computed once.
    folder : Path
        Where their files go.
    crew : Crew or None
        Who computes; None: this process.
    progress : Progress
        Told about cells and failures.

    Yields
    ------
    WrittenCell
        Its file is on disk.

    Raises
    ------
    ConfigError
        When a file cannot be written; those written before are kept.
    """
    once = {planned.key: planned for planned in missing}
    refused = [(p, _refused(p)) for p in once.values() if p.reason]
    tasks = [p for p in once.values() if not p.reason]
    work = _here(tasks) if crew is None else _by_crew(tasks, crew, progress)
    results = _chained(refused, work)
    for planned, (cell, content) in progress.track(results, total=len(once), label="designs"):
        put_bytes(cell_path(folder, planned.key), content)
        if cell.reason:
            progress.say(f"{planned.label} failed: {cell.reason}")
        yield WrittenCell(planned=planned, cell=cell, sha256=hashlib.sha256(content).hexdigest())


Computed = tuple[Cell, bytes]
"""A cell and the content of its file."""


def _chained(
    first: Sequence[tuple[PlannedCell, Computed]], then: Iterator[tuple[PlannedCell, Computed]]
) -> Iterator[tuple[PlannedCell, Computed]]:
    yield from first
    yield from then


def computed_cell(planned: PlannedCell, version: str) -> Computed:
    """Return a cell and the content of its file; what workers are asked for; powers in [W].

    Parameters
    ----------
    planned : PlannedCell
        What to compute.
    version : str
        Version of Octant that planned it.

    Returns
    -------
    Cell
        The cell, with its reason where it failed.
    bytes
        Its file.

    Raises
    ------
    SweepStateError
        When this worker runs another version of Octant.
    """
    here = versions()["octant_version"]
    if here != version:
        msg = f"the worker runs Octant {here}, but the sweep was planned by {version}; update it."
        raise SweepStateError(msg)
    cell = compute_cell(planned.context, planned.design, planned.key)
    return _with_file(planned, cell)


def _with_file(planned: PlannedCell, cell: Cell) -> Computed:
    named = replace(cell, label=planned.label)
    return named, cell_bytes(named, planned.context)


def _refused(planned: PlannedCell) -> Computed:
    return _with_file(planned, failed_cell(planned.design, planned.key, planned.reason))


def _failed(planned: PlannedCell, reason: str) -> Computed:
    cell = failed_cell(planned.design, planned.key, reason, unexpected=True)
    return _with_file(planned, cell)


def _here(tasks: Sequence[PlannedCell]) -> Iterator[tuple[PlannedCell, Computed]]:
    """Yield cells computed in this process, one after another."""
    version = versions()["octant_version"]
    for planned in tasks:
        try:
            result = computed_cell(planned, version)
        except Exception as exc:  # noqa: BLE001  one cell's failure must not stop the others
            result = _failed(planned, _unexpected(exc))
        yield planned, result


def _unexpected(exc: BaseException) -> str:
    return f"unexpected {type(exc).__name__}: {' '.join(str(exc).split())}"


def _by_crew(
    tasks: Sequence[PlannedCell], crew: Crew, progress: Progress
) -> Iterator[tuple[PlannedCell, Computed]]:
    """Yield cells as a crew computes them.

    The first goes alone: kernels that are not compiled yet are compiled by one worker, and the
    others find them on disk.
    """
    version = versions()["octant_version"]
    waiting = deque(tasks)
    pending: dict[Future[Computed], PlannedCell] = {}
    most = 1
    try:
        while waiting or pending:
            suspects: list[PlannedCell] = []
            while waiting and len(pending) < most and not suspects:
                planned = waiting.popleft()
                try:
                    pending[crew.submit(computed_cell, planned, version)] = planned
                except BrokenExecutor:
                    suspects.append(planned)
            done, _ = wait(pending, return_when=FIRST_COMPLETED)
            most = AHEAD * crew.size
            for future in done:
                planned = pending.pop(future)
                if isinstance(_error(future), BrokenExecutor):
                    suspects.append(planned)
                else:
                    yield planned, _outcome(planned, future)
            if suspects:
                suspects += [pending.pop(future) for future in list(pending)]
                yield from _one_at_a_time(suspects, crew, version, progress)
    except BaseException:
        for future in pending:
            future.cancel()
        crew.stop()
        raise


def _error(future: "Future[Computed]") -> BaseException | None:
    try:
        return future.exception()
    except FutureCancelledError as exc:
        return exc


def _outcome(planned: PlannedCell, future: "Future[Computed]") -> Computed:
    """Return a future's cell, or a failed one."""
    error = _error(future)
    if error is None:
        return future.result()
    if isinstance(error, FutureCancelledError):
        msg = (
            "the cluster was lost while cells were being computed; what was computed is kept, and "
            "the same command goes on from there."
        )
        raise SweepStateError(msg) from error
    return _failed(planned, _unexpected(error))


def _one_at_a_time(
    suspects: Sequence[PlannedCell], crew: Crew, version: str, progress: Progress
) -> Iterator[tuple[PlannedCell, Computed]]:
    """Yield the cells that were in flight when a worker died, each tried alone to find the one."""
    progress.say(
        "A worker was killed, most likely by the system for want of memory; the cells that were in "
        "flight are computed one at a time."
    )
    for planned in suspects:
        crew.renew()
        try:
            future = crew.submit(computed_cell, planned, version)
            broken = isinstance(_error(future), BrokenExecutor)
        except BrokenExecutor:
            broken = True
        if broken:
            reason = (
                "its worker was killed, most likely by the system for want of memory; give fewer "
                "--workers or a coarser mesh (reader.cells_per_wavelength)."
            )
            yield planned, _failed(planned, reason)
        else:
            yield planned, _outcome(planned, future)
    crew.renew()
