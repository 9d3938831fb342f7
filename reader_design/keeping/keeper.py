"""The keeper: computes cases once, keeps each in a file of its own, and goes on where it stopped.

Every case has a key (:mod:`octant.reader_design.keeping.keys`) and a file named by it, written
under a temporary name and then renamed. Whatever ends a run, only the cases in computation are
lost; running again computes what is missing. The process that started the run writes all files, so
that workers need not see its disk.
"""

import pickle
import time
import warnings
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, wait
from concurrent.futures import CancelledError as FutureCancelledError
from contextlib import closing, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

import msgspec
import numpy as np
import numpy.typing as npt

from octant.em.blocks import cores, one_blas_thread
from octant.geometries.errors import OctantError, PhysicsWarning, SweepStateError
from octant.reader_design.keeping.folder import (
    FAILED,
    case_path,
    claimed,
    read_case,
    write_case,
)
from octant.reader_design.keeping.interrupts import swallowed_interrupts
from octant.reader_design.keeping.keys import case_keys
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.versions import versions
from octant.reader_design.keeping.workers import Crew, open_crew

Case = TypeVar("Case")
Record = TypeVar("Record")

AHEAD = 2
"""Cases handed out for each worker: one that it computes and one that waits for it."""


class Codec(Protocol):
    """How a record becomes the content of a file, and back.

    Attributes
    ----------
    suffix : Ending of the files' names, with its dot.
    """

    suffix: str

    def encode(self, record: Any, case: Any) -> bytes:  # noqa: ANN401  any record of any case
        """Return the content of the file of a record; called where the case was computed.

        Parameters
        ----------
        record, case : What the computation returned, and what was computed.
        """

    def decode(self, content: bytes, case: Any) -> Any:  # noqa: ANN401  any record of any case
        """Return what the run gets for a file's content, whether it is new or was kept.

        Parameters
        ----------
        content, case : From ``encode``, and what was computed.
        """


class RecordCodec(Generic[Record]):
    """Keeps any dataclass or msgspec struct of numbers, text, arrays and records, bit by bit.

    Parameters
    ----------
    kind : Class of the records.
    """

    suffix = ".msgpack"

    def __init__(self, kind: type[Record]) -> None:
        self.kind = kind

    def encode(self, record: Record, case: object) -> bytes:
        """Return the record in MessagePack."""
        del case
        return msgspec.msgpack.encode(record, enc_hook=_plain_array)

    def decode(self, content: bytes, case: object) -> Record:
        """Return the record."""
        del case
        return msgspec.msgpack.decode(content, type=self.kind, dec_hook=_array)


def _plain_array(value: Any) -> Any:  # noqa: ANN401  the signature is msgspec's own
    if isinstance(value, np.generic):
        return value.item()
    if not isinstance(value, np.ndarray) or value.dtype.hasobject:
        msg = f"a {type(value).__name__} cannot be kept in a file."
        raise TypeError(msg)
    return [value.dtype.str, value.shape, np.ascontiguousarray(value).tobytes()]


def _array(kind: Any, value: Any) -> npt.NDArray[Any]:  # noqa: ANN401  the signature is msgspec's
    del kind
    dtype, shape, content = value
    return np.frombuffer(content, dtype=dtype).reshape(shape).copy()


@dataclass(frozen=True, slots=True, kw_only=True)
class Kept(Generic[Record]):
    """One case after a run: its record, or why there is none.

    Attributes
    ----------
    key : Key of the case.
    record : What was computed; None when it failed.
    reason : Why it failed; empty when it did not.
    unexpected : True: it failed for a reason that is not its own, such as want of memory, and the
        next run tries it again.
    seconds : Time that it took [s].
    path : Its file.
    """

    key: str
    record: Record | None = None
    reason: str = ""
    unexpected: bool = False
    seconds: float = 0.0
    path: Path

    @property
    def value(self) -> Record:
        """The record; a failed case raises its reason as a SweepStateError."""
        if self.record is None:
            raise SweepStateError(self.reason)
        return self.record


def kept_cases(
    compute: Callable[[Any, Case], object],
    cases: Sequence[Case],
    *,
    context: object,
    folder: Path,
    codec: Codec,
    leave_out: Sequence[str] = (),
    progress: Progress | None = None,
) -> tuple[Kept[Any] | None, ...]:
    """Return what the folder holds of each case, without computing; None where there is nothing.

    Parameters
    ----------
    compute, cases, context, folder, codec, leave_out, progress
        As in :func:`map_cases`.
    """
    keys = case_keys(compute, cases, context=context, leave_out=leave_out)
    say = (progress or Progress()).say
    found: dict[str, Kept[Any] | None] = {}
    for key, case in zip(keys, cases, strict=True):
        if key not in found:
            found[key] = _read(folder, key, case, codec, say)
    return tuple(found[key] for key in keys)


def _read(
    folder: Path, key: str, case: object, codec: Codec, say: Callable[[str], None]
) -> Kept[Any] | None:
    for suffix in (codec.suffix, FAILED):
        path = case_path(folder, key, suffix)
        try:
            there = read_case(path, key)
            if there is not None:
                return _kept(*there, path=path, case=case, codec=codec)
        except SweepStateError as exc:
            say(f"{exc} It is computed again.")
    return None


def _kept(
    content: bytes, facts: Mapping[str, Any], *, path: Path, case: object, codec: Codec
) -> Kept[Any]:
    try:
        record = codec.decode(content, case) if content else None
    except Exception as exc:
        msg = f"the file {path} cannot be used ({type(exc).__name__}: {exc})."
        raise SweepStateError(msg) from exc
    return Kept(record=record, path=path, **facts)


def map_cases(
    compute: Callable[[Any, Case], object],
    cases: Sequence[Case],
    *,
    context: object,
    folder: Path,
    codec: Codec,
    leave_out: Sequence[str] = (),
    workers: int | None = 1,
    cluster: str | None = None,
    crew: Crew | None = None,
    progress: Progress | None = None,
    label: str = "cases",
    name: Callable[[Case], str] | None = None,
    raises: tuple[type[Exception], ...] = (),
) -> tuple[Kept[Any], ...]:
    """Return every case computed, in the order given; what the folder holds is not computed again.

    The bits are the same with any workers: every computation uses one thread for linear algebra.
    Finished cases stay in files when a run ends with a ConfigError (a file cannot be written, the
    cluster does not answer), a SweepStateError (the cluster is lost, or a worker runs another
    version of Octant) or a KeyboardInterrupt (cases that have not begun are cancelled).

    Parameters
    ----------
    compute : ``compute(context, case) -> record``, a function of a module. An ``OctantError`` that
        it raises is a result: the case failed for that reason. Any other exception is recorded, and
        the next run tries the case again.
    cases : What to compute; equal ones are computed once.
    context : What all cases share. Context and cases must be picklable, and of the types that
        :func:`octant.reader_design.keeping.keys.case_keys` reads.
    folder : Where the files lie; made when missing.
    codec : How records are kept, for example ``RecordCodec(Record)``.
    leave_out : Fields without effect on records, each as ``Class.field``.
    workers : Processes of this machine, no more than there are cases; 1: this process computes;
        None: one for each core. A script that starts processes must guard its main part with ``if
        __name__ == "__main__"``.
    cluster : Address of a dask scheduler, or ``local:N``; in place of ``workers``.
    crew : Workers that are there already, from
        :func:`octant.reader_design.keeping.workers.open_crew`; in place of both.
    progress : Shows a bar with the time left, failures, and files that cannot be used.
    label : What the cases are called, in the plural.
    name : Returns the name of a case for messages.
    raises : Errors of ``compute`` that end the run instead of being recorded.
    """
    progress = progress or Progress()
    keys = case_keys(compute, cases, context=context, leave_out=leave_out)
    by_key = dict(zip(keys, cases, strict=True))
    with claimed(folder):
        done: dict[str, Kept[Any]] = {}
        for key, case in by_key.items():
            found = _read(folder, key, case, codec, progress.say)
            if found is not None and not found.unexpected:
                done[key] = found
        missing = {key: case for key, case in by_key.items() if key not in done}
        if done and missing:
            progress.say(f"{len(done)} of {len(by_key)} {label} are computed already.")
        job = _Job(compute=compute, context=context, codec=codec, raises=raises)
        if not missing:
            return tuple(done[key] for key in keys)
        with (
            swallowed_interrupts() as raise_swallowed,
            _crew_for(len(missing), workers, cluster, crew) as hands,
            closing(_computed(job, missing, hands, progress)) as results,
            progress.track(results, total=len(missing), label=label) as tracked,
        ):
            for key, (content, measured) in tracked:
                suffix = codec.suffix if content else FAILED
                path = case_path(folder, key, suffix)
                facts = {"key": key, **measured}
                write_case(path, content, facts)
                if content:
                    case_path(folder, key, FAILED).unlink(missing_ok=True)
                elif name is not None:
                    progress.say(f"{name(by_key[key])} failed: {facts['reason']}")
                done[key] = _kept(content, facts, path=path, case=by_key[key], codec=codec)
                raise_swallowed()
    return tuple(done[key] for key in keys)


def _crew_for(missing: int, workers: int | None, cluster: str | None, crew: Crew | None) -> Any:  # noqa: ANN401  a context of a crew or of None
    """Return a context with the workers for so many cases; None: this process computes."""
    if crew is not None:
        return nullcontext(crew)
    return open_crew(workers=min(cores() if workers is None else workers, missing), cluster=cluster)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Job:
    """What a worker is asked to do with a case."""

    compute: Callable[[Any, Any], object]
    context: object
    codec: Codec
    raises: tuple[type[Exception], ...]


Computed = tuple[bytes, dict[str, Any]]
"""Content of a case's file and the facts that stand beside it."""


def computed_by_worker(packed: bytes, version: str) -> Computed:
    """Return what `computed_case` returns; this is what workers run.

    Parameters
    ----------
    packed : A job and a case, pickled: what a worker cannot import is an error with a sentence,
        where the pool's own unpickling would end the worker.
    version : As in `computed_case`.
    """
    try:
        job, case = pickle.loads(packed)  # noqa: S301  from the process that started this worker
    except (AttributeError, ImportError) as exc:
        raise SweepStateError(_not_importable(exc)) from exc
    return computed_case(job, case, version)


def computed_case(job: _Job, case: object, version: str) -> Computed:
    """Return the content and the facts of a case's file.

    Parameters
    ----------
    job, case : How to compute, and what.
    version : Version of Octant that asks; a worker with another one refuses.
    """
    here = versions()["octant_version"]
    if here != version:
        msg = f"the worker runs Octant {here}, but this run was started by {version}; update it."
        raise SweepStateError(msg)
    began = time.perf_counter()
    try:
        with one_blas_thread(), warnings.catch_warnings():
            warnings.simplefilter("ignore", PhysicsWarning)  # records carry what must be known
            record = job.compute(job.context, case)
            content = job.codec.encode(record, case)
    except job.raises:
        raise
    except OctantError as exc:
        return _failure(str(exc), unexpected=False, seconds=time.perf_counter() - began)
    except Exception as exc:  # noqa: BLE001  one case's failure must not stop the others
        return _failure(_reason(exc), unexpected=True, seconds=time.perf_counter() - began)
    return content, {"seconds": time.perf_counter() - began}


def _failure(reason: str, *, unexpected: bool, seconds: float = 0.0) -> Computed:
    return b"", {"reason": reason, "unexpected": unexpected, "seconds": seconds}


def _reason(exc: BaseException) -> str:
    return f"unexpected {type(exc).__name__}: {' '.join(str(exc).split())}"


def _computed(
    job: _Job, missing: Mapping[str, object], crew: Crew | None, progress: Progress
) -> Generator[tuple[str, Computed]]:
    """Yield cases as they are computed: by a crew, or here, one after another."""
    version = versions()["octant_version"]
    if crew is not None:
        yield from _by_crew(job, missing, crew, progress)
        return
    for key, case in missing.items():
        yield key, computed_case(job, case, version)


def _by_crew(
    job: _Job, missing: Mapping[str, object], crew: Crew, progress: Progress
) -> Iterator[tuple[str, Computed]]:
    """Yield cases as a crew computes them.

    The first goes alone: kernels that are not compiled yet are compiled by one worker, and the
    others find them on disk.
    """
    version = versions()["octant_version"]
    waiting = deque(missing.items())
    pending: dict[Future[Computed], tuple[str, object]] = {}
    most = 1
    try:
        while waiting or pending:
            suspects: list[tuple[str, object]] = []
            while waiting and len(pending) < most and not suspects:
                key, case = waiting.popleft()
                try:
                    pending[_submitted(crew, job, case, version)] = key, case
                except BrokenExecutor:
                    suspects.append((key, case))
            done, _ = wait(pending, return_when=FIRST_COMPLETED)
            most = AHEAD * crew.size
            for future in done:
                key, case = pending.pop(future)
                if isinstance(_error(future), BrokenExecutor):
                    suspects.append((key, case))
                else:
                    yield key, _outcome(job, future)
            if suspects:
                suspects += [pending.pop(future) for future in list(pending)]
                yield from _one_at_a_time(job, suspects, crew, version, progress)
    except BaseException:
        for future in pending:
            future.cancel()
        crew.stop()
        raise


def _submitted(crew: Crew, job: _Job, case: object, version: str) -> "Future[Computed]":
    """Return the future of a case that a crew computes."""
    try:
        packed = pickle.dumps((job, case))
    except (pickle.PicklingError, AttributeError, TypeError) as exc:
        raise SweepStateError(_not_importable(exc)) from exc
    return crew.submit(computed_by_worker, packed, version)


def _not_importable(exc: Exception) -> str:
    return (
        f"a worker cannot import what it has to compute ({exc}); define that function in a module "
        "that can be imported, or give workers = 1."
    )


def _error(future: "Future[Computed]") -> BaseException | None:
    try:
        return future.exception()
    except FutureCancelledError as exc:
        return exc


def _outcome(job: _Job, future: "Future[Computed]") -> Computed:
    """Return what a future computed, or a failure."""
    error = _error(future)
    if error is None:
        return future.result()
    if isinstance(error, FutureCancelledError):
        msg = (
            "the cluster was lost while cases were being computed; what was computed is kept, and "
            "the same command goes on from there."
        )
        raise SweepStateError(msg) from error
    if isinstance(error, (SweepStateError, *job.raises)):
        raise error
    return _failure(_reason(error), unexpected=True)


def _one_at_a_time(
    job: _Job,
    suspects: Sequence[tuple[str, object]],
    crew: Crew,
    version: str,
    progress: Progress,
) -> Iterator[tuple[str, Computed]]:
    """Yield the cases that were in computation when a worker died, each tried alone."""
    progress.say(
        "A worker was killed, most likely by the system for want of memory; the cases that were in "
        "computation are computed one at a time."
    )
    for key, case in suspects:
        crew.renew()
        try:
            future = _submitted(crew, job, case, version)
            broken = isinstance(_error(future), BrokenExecutor)
        except BrokenExecutor:
            broken = True
        if broken:
            reason = (
                "its worker was killed, most likely by the system for want of memory; give fewer "
                "--workers or a coarser mesh (reader.cells_per_wavelength)."
            )
            yield key, _failure(reason, unexpected=True)
        else:
            yield key, _outcome(job, future)
    crew.renew()
