"""Running cases: one small file each, by whole files, resumable, on any number of workers."""

import hashlib
import json
from collections.abc import Iterator, Sequence
from concurrent.futures import (
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
    as_completed,
)
from contextlib import ExitStack
from dataclasses import asdict
from multiprocessing import get_context
from pathlib import Path

from octant.geometries.errors import SweepStateError
from octant.geometries.files import write_text
from octant.reader_design.experiments.tolerance.cases import (
    Case,
    CaseScores,
    ToleranceContext,
    case_key,
    compute_case,
)
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.keys import scene_fingerprint
from octant.reader_design.study_file.scores import Scores


def case_path(folder: Path, key: str) -> Path:
    """Return where a case's file lies.

    Parameters
    ----------
    folder : Path
        Folder of the cases.
    key : str
        Name of the case.

    Returns
    -------
    Path
        A JSON file named by the first 32 digits of the key.
    """
    return folder / f"{key[:32]}.json"


def write_case(path: Path, scores: CaseScores) -> None:
    """Return nothing; write a case's scores whole or not at all.

    Parameters
    ----------
    path : Path
        Its file.
    scores : CaseScores
        Every number as written ([rad], [dB], [dBm], [W],).

    Raises
    ------
    ConfigError
        When the folder cannot be written to.
    """
    content = asdict(scores)
    write_text(path, json.dumps({"digest": _digest(content), **content}, indent=1) + "\n")


def read_case(path: Path, key: str) -> CaseScores:
    """Return the scores of a file, checked against the key and its own digest.

    Parameters
    ----------
    path : Path
        The file.
    key : str
        Expected name of the case.

    Returns
    -------
    CaseScores
        As written, bit by bit ([rad], [dB], [dBm], [W],).

    Raises
    ------
    SweepStateError
        When the file cannot be read, is damaged, or belongs to another case.
    """
    try:
        content = json.loads(path.read_text("utf-8"))
        told = content.pop("digest")
        intact = told == _digest(content) and content["key"] == key
        for name in ("free", "room"):
            content[name] = None if content[name] is None else Scores(**content[name])
        content["levels_dbm"] = tuple(content["levels_dbm"])
        scores = CaseScores(**content)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as exc:
        msg = f"the case file {path} cannot be read ({exc}); delete it, or let it be overwritten."
        raise SweepStateError(msg) from exc
    if not intact:
        msg = f"the case file {path} is damaged or another case's; delete it."
        raise SweepStateError(msg)
    return scores


def run_cases(
    context: ToleranceContext,
    cases: Sequence[Case],
    folder: Path,
    *,
    workers: int = 1,
    executor: Executor | None = None,
    progress: Progress | None = None,
    label: str = "readers",
) -> tuple[CaseScores, ...]:
    """Return the scores of cases, read from their files or computed and written.

    Parameters
    ----------
    context : ToleranceContext
        What all cases share.
    cases : sequence of Case
        Designs and deviations.
    folder : Path
        Where the cases' files lie; made when missing.
    workers : int
        Processes; 1 stays in this one, whose kernels use all cores.
    executor : concurrent.futures.Executor, optional
        Computes cases in place of ``workers`` own processes.
    progress : Progress, optional
        Told about cases, and about files that cannot be read.
    label : str
        What the progress bar calls them.

    Returns
    -------
    tuple of CaseScores
        In the order of the cases; the same bits at any number of workers.

    Raises
    ------
    SweepStateError
        When a worker dies; what was finished is on disk.
    KeyboardInterrupt
        Passed on after the cases that have not begun are cancelled; finished ones are on disk.
    """
    progress = progress or Progress()
    fingerprint = scene_fingerprint(context.sweep.built)
    keys = [case_key(context, case, fingerprint) for case in cases]
    done: dict[str, CaseScores] = {}
    missing: dict[str, Case] = {}
    for key, case in zip(keys, cases, strict=True):
        found = None if key in done or key in missing else _kept(folder, key, progress)
        if found is not None:
            done[key] = found
        elif key not in done:
            missing[key] = case
    if done:
        progress.say(f"{len(done)} of {len(set(keys))} {label} are computed already.")
    with ExitStack() as stack:
        if executor is None and workers > 1 and missing:
            # Not forked: the solver's threads would not survive in a forked child.
            pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"))
            executor = stack.enter_context(pool)
        work = _computed(context, missing, executor)
        for scores in progress.track(work, total=len(missing), label=label):
            write_case(case_path(folder, scores.key), scores)
            if scores.reason:
                progress.say(f"one of the {label} cannot be built: {scores.reason}")
            done[scores.key] = scores
    return tuple(done[key] for key in keys)


def _digest(content: dict[str, object]) -> str:
    """Return a hash by which a damaged file is found out."""
    rest = {name: value for name, value in content.items() if name != "digest"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()


def _kept(folder: Path, key: str, progress: Progress) -> CaseScores | None:
    """Return the scores of a file, or None when there is none that can be used."""
    path = case_path(folder, key)
    if not path.exists():
        return None
    try:
        return read_case(path, key)
    except SweepStateError as exc:
        progress.say(f"{exc} It is computed again.")
        return None


def _computed(
    context: ToleranceContext, missing: dict[str, Case], executor: Executor | None
) -> Iterator[CaseScores]:
    """Yield the scores of each missing case when they are there."""
    if executor is None:
        for key, case in missing.items():
            yield compute_case(context, case, key)
        return
    futures: list[Future[CaseScores]] = [
        executor.submit(compute_case, context, case, key) for key, case in missing.items()
    ]
    broken: BaseException | None = None
    try:
        for future in as_completed(futures):
            error = future.exception()
            if isinstance(error, BrokenExecutor):
                broken = error  # what others have finished is still to be fetched
            else:
                yield future.result()
    finally:
        for future in futures:
            future.cancel()
    if broken is not None:
        msg = (
            f"a worker ended before its reader was solved ({broken}), perhaps for want of memory; "
            "what was computed is kept: run again, with fewer workers."
        )
        raise SweepStateError(msg) from broken
