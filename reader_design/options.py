"""Parameter types and options that several verbs share."""

import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import click

from octant.em.blocks import free_memory_bytes
from octant.geometries.errors import ConfigError
from octant.reader_design.cli import InterruptedRunError
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.terminal.colour import Kind, painted
from octant.reader_design.terminal.completion import built_in_studies, files

if TYPE_CHECKING:
    from octant.reader_design.setting.cost import Cost
    from octant.reader_design.study_file.schema import Study

Decorated = TypeVar("Decorated", bound=Callable[..., Any])


MENTIONED_S, MENTIONED_BYTES = 60.0, 1.5e9
"""Time [s] and memory [B] above which a command says before it starts what it will take: a minute,
and a gigabyte besides the program itself."""
LONGEST_S = 12.0 * 3600.0
"""Time [s] above which it starts only with ``--yes``."""
FARTHEST_M = 1e7
"""Greatest coordinate [m], as of a study file."""
YES = "octant.yes"
"""Where a call keeps whether ``--yes`` was given."""
FAILED_CASES = 3
"""Exit code of an experiment that finished, but not with a result for every case."""


def number(kind: Any) -> click.IntRange | click.FloatRange:  # noqa: ANN401  an annotated type
    """Return the type of an option that has the range of a kind of quantity.

    Parameters
    ----------
    kind : Of `octant.reader_design.study_file.quantities`.
    """
    from octant.reader_design.study_file.quantities import limits

    found = limits(kind)
    assert found is not None  # noqa: S101  every kind has limits
    base, meta = found
    given = {"min": meta.ge, "max": meta.le}
    return click.IntRange(**given) if base is int else _FiniteRange(**given)  # type: ignore[arg-type]


class _FiniteRange(click.FloatRange):
    """A range that NaN is not in, and whose zero has no sign."""

    def convert(
        self,
        value: Any,  # noqa: ANN401  the signature is click's own
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> Any:  # noqa: ANN401  the signature is click's own
        """Return the number; refuse one that is outside, or is none.

        Parameters
        ----------
        value, param, ctx : As click gives them.
        """
        found = super().convert(value, param, ctx)
        if math.isnan(found):
            self.fail(f"{value} is not in the range {self._describe_range()}.", param, ctx)
        return found + 0.0  # -0 is 0, but numpy refuses it as a deviation


def point(text: str) -> tuple[float, float, float]:
    """Return a point X,Y,Z of the command line [m].

    Parameters
    ----------
    text : Three numbers with commas between them [m].
    """
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) != 3 or not all(abs(n) <= FARTHEST_M for n in numbers):
        shown = text if len(text) <= 60 else f"{text[:57]}..."
        msg = (
            f"{shown!r} is not a point; write three numbers in m as X,Y,Z, each from "
            f"{-FARTHEST_M:.0f} to {FARTHEST_M:.0f}."
        )
        raise click.BadParameter(msg)
    return numbers[0], numbers[1], numbers[2]


POINT = click.types.FuncParamType(point)
POINT.name = "X,Y,Z"  # as help and messages call it


MOST_FREQUENCIES = 1001
"""Frequencies that one call takes at most [-]."""


def frequencies(text: str, *, gigahertz: bool = False) -> tuple[float, ...]:
    """Return the frequencies of the command line, rising [Hz].

    Parameters
    ----------
    text : FROM:TO:COUNT with both ends, or numbers with commas between them.
    gigahertz : Whether they are in [GHz] instead of [Hz].
    """
    unit_hz = 1e9 if gigahertz else 1.0
    numbers: list[float] = []
    try:
        if ":" in text:
            first, last, count = text.split(":")
            low, high, steps = unit_hz * float(first), unit_hz * float(last), int(count) - 1
            if low < high and 0 < steps < MOST_FREQUENCIES:
                share = [k / steps for k in range(steps + 1)]
                numbers = [(1.0 - t) * low + t * high for t in share]
        else:
            numbers = sorted({unit_hz * float(part) for part in text.split(",")})
    except ValueError:
        numbers = []
    if not 2 <= len(numbers) <= MOST_FREQUENCIES or not all(
        math.isfinite(f) and f > 0.0 for f in numbers
    ):
        msg = (
            f"{text[:60]!r} is no band; write FROM:TO:COUNT or frequencies with commas between "
            f"them, 2 to {MOST_FREQUENCIES} of them, "
            f"{'in GHz, such as 2.3:2.5:41' if gigahertz else 'in Hz, such as 865e6:928e6:22'}."
        )
        raise click.BadParameter(msg)
    return tuple(numbers)


def _band_ghz(text: str) -> tuple[float, ...]:
    return frequencies(text, gigahertz=True)


FREQUENCIES = click.types.FuncParamType(frequencies)
BAND_GHZ = click.types.FuncParamType(_band_ghz)
FREQUENCIES.name = BAND_GHZ.name = "FROM:TO:COUNT"


def approve(cost: "Cost", progress: Progress) -> None:
    """Say what a command will take where that is much, before it starts; refuse what is too much.

    Above a minute or a gigabyte it is said; above `LONGEST_S` ``--yes`` is needed; what the machine
    has no memory for is refused.

    Parameters
    ----------
    cost : What is expected.
    progress : Says it.
    """
    less = f"ask for less: {', '.join(cost.causes)}"
    free = free_memory_bytes()
    if cost.memory_bytes > free:
        from octant.reader_design.setting.cost import gigabytes_text

        msg = f"{cost.text()} are expected, but {gigabytes_text(free)} are free; {less}."
        raise ConfigError(msg)
    context = click.get_current_context(silent=True)
    allowed = context is not None and context.meta.get(YES, False)
    if cost.seconds > LONGEST_S and not allowed:
        msg = (
            f"{cost.text()} are expected, which is more than {LONGEST_S / 3600.0:g} h; "
            f"give --yes to start it all the same, or {less}."
        )
        raise ConfigError(msg)
    if cost.seconds > MENTIONED_S or cost.memory_bytes > MENTIONED_BYTES:
        progress.say(f"expected: {cost.text()}.")


def common_options(command: Decorated) -> Decorated:
    """Return a command that also takes ``--quiet``, ``--force`` and ``--yes``.

    It announces compilation.

    Parameters
    ----------
    command : With the parameters ``quiet`` and ``force``.
    """

    @wraps(command)
    def announcing(*args: Any, quiet: bool, yes: bool, **options: Any) -> Any:  # noqa: ANN401
        context = click.get_current_context()
        context.meta[YES] = yes
        from octant.em.blocks import cores
        from octant.reader_design.compilation import (
            FIRST_USE,
            compiled_ahead,
            counted_kernels,
            recorded_compilation,
        )

        def first() -> None:
            Progress(quiet=quiet).say(FIRST_USE)
            start()
            show()

        verb = context.command.name or ""
        bar = Progress(quiet=quiet or not sys.stderr.isatty())
        with (
            compiled_ahead(verb, lambda: cores() > 1) as start,
            counted_kernels(verb, lambda n: bar.count(n, label="kernels")) as show,
            recorded_compilation(first),
        ):
            return command(*args, quiet=quiet, **options)

    force = click.option("--force", is_flag=True, help="Overwrite files that exist.")
    yes = click.option(
        "--yes",
        is_flag=True,
        help=f"Start although more than {LONGEST_S / 3600.0:g} h are expected.",
    )
    return cast("Decorated", quiet_option(force(yes(announcing))))


quiet_option = click.option("--quiet", "-q", is_flag=True, help="No progress and no messages.")

json_option = click.option(
    "--json",
    "as_json",
    is_flag=True,
    help="Print the result as one JSON document, and nothing else, on stdout.",
)

dry_run_option = click.option(
    "--dry-run", is_flag=True, help="Say what would be computed, and leave."
)

quick_option = click.option(
    "--quick", is_flag=True, help="A quick look: coarse sampling, few runs, less compared."
)


def drive_options(command: Decorated) -> Decorated:
    """Return a command that takes ``--export KIND`` and ``--export-run N``, both repeatable.

    Parameters
    ----------
    command : With the parameters ``export`` and ``export_run``, tuples.
    """
    kinds = click.option(
        "--export",
        type=click.Choice(["mcap", "tum", "csv"]),
        multiple=True,
        help="Also write the drive into the folder drives: MCAP for Foxglove and RViz, TUM or CSV; "
        "may be repeated.",
    )
    numbers = click.option(
        "--export-run",
        type=click.IntRange(0),
        multiple=True,
        metavar="N",
        help="Run that --export writes; may be repeated; default: run 0.",
    )
    return kinds(numbers(command))


QUICK_RUNS, QUICK_SAMPLES = 3, 8
"""Runs of each drive, and readers built with errors, in a quick look [-]."""


def runs_wanted(runs: int | None, *, quick: bool) -> int | None:
    """Return the number of runs that was asked for; None: the study's.

    Parameters
    ----------
    runs, quick : Given number, which counts; whether a quick look is enough.
    """
    return QUICK_RUNS if runs is None and quick else runs


STUDY_ARGUMENT = click.argument(
    "study",
    type=click.Path(path_type=Path),
    required=False,
    shell_complete=files(".toml", names=built_in_studies),
)
"""A study file, or the name of a built-in study; without it the built-in one that serves."""


def study_argument(command: Decorated) -> Decorated:
    """Return a command that takes STUDY: a file, a built-in study's name, or neither.

    Parameters
    ----------
    command : With the parameter ``study``, a path or None.
    """
    return STUDY_ARGUMENT(command)


def out_option(default: str, help_text: str = "Folder for results.") -> Callable[[Any], Any]:
    """Return the decorator for ``--out``.

    Parameters
    ----------
    default, help_text : Folder without the option; its line of help.
    """
    place = click.Path(path_type=Path)
    return click.option(
        "--out", type=place, default=Path(default), show_default=True, help=help_text
    )


def seed_option(command: Decorated) -> Decorated:
    """Return a command that takes ``--seed``.

    Parameters
    ----------
    command : With the parameter ``seed``, a number or None.
    """
    from octant.reader_design.study_file.quantities import Seed

    text = "Seed of all random numbers; default: the study's."
    return click.option("--seed", type=number(Seed), metavar="N", help=text)(command)


@dataclass(frozen=True, slots=True, kw_only=True)
class RunOptions:
    """What every experiment is asked for on the command line, besides its study.

    Parameters
    ----------
    out, force : Folder of the results; whether they replace those of another study.
    workers : Processes of this machine; None: one for each core.
    cluster : Address of a dask scheduler, or ``local:N``; in place of ``workers``.
    seed : Of all random numbers; None: the study's.
    dry_run, quiet : Only say what would be computed; no progress and no messages.
    """

    out: Path
    force: bool
    workers: int | None
    cluster: str | None
    seed: int | None
    dry_run: bool
    quiet: bool

    @property
    def progress(self) -> Progress:
        """Bars and messages on stderr, unless quiet."""
        return Progress(quiet=self.quiet)

    def seeded(self, study: "Study") -> "Study":
        """Return the study with the seed that was asked for.

        Parameters
        ----------
        study : As loaded.
        """
        from msgspec.structs import replace

        return study if self.seed is None else replace(study, seed=self.seed)

    def approve(self, cost: "Cost") -> None:
        """Say or refuse what the experiment takes on these workers, as `approve` does.

        Parameters
        ----------
        cost : On one core.
        """
        from octant.reader_design.setting.cost import shared

        if not self.dry_run:
            approve(shared(cost, None if self.cluster else self.workers), self.progress)


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """How an experiment ended.

    Parameters
    ----------
    lines, failed : What a person wants to read; whether some cases have no result.
    written, tables : Every file and folder that holds results; those of them whose rows belong into
        a JSON document.
    verdict : How good the result is, which the first line says in colour; None: it is not judged.
    """

    lines: tuple[str, ...]
    failed: bool = False
    written: tuple[Path, ...] = ()
    tables: tuple[Path, ...] = ()
    verdict: Kind | None = None


def experiment(
    *, out: str | None = None, workers: bool = True, seed: bool = True
) -> Callable[[Callable[..., Ended]], Callable[..., None]]:
    """Return a decorator that makes a function the verb of an experiment.

    The function takes ``study`` (a path, or None), ``options`` (`RunOptions`) and its own options.
    The verb prints the lines of what it returns, or with ``--json`` a document; exits with 3 when
    cases failed, 130 after Ctrl-C.

    Parameters
    ----------
    out : Default of ``--out``; None: ``octant-`` and the verb's name.
    workers, seed : Whether processes, and random numbers, mean anything to it.
    """

    def decorated(verb: Callable[..., Ended]) -> Callable[..., None]:
        @wraps(verb)
        def run(
            *,
            study: Path | None,
            out: Path,
            dry_run: bool,
            force: bool,
            quiet: bool,
            as_json: bool,
            workers: int | None = None,
            cluster: str | None = None,
            seed: int | None = None,
            **own: Any,  # noqa: ANN401  options of the verb
        ) -> None:
            if workers is not None and cluster is not None:
                msg = "--workers and --cluster are both given, but only one of them can compute."
                raise click.UsageError(msg)
            options = RunOptions(
                out=out,
                force=force,
                workers=workers,
                cluster=cluster,
                seed=seed,
                dry_run=dry_run,
                quiet=quiet,
            )
            try:
                ended = verb(study=study, options=options, **own)
            except KeyboardInterrupt as exc:
                msg = f"what was computed is kept in {out}; the same command goes on from there."
                raise InterruptedRunError(msg) from exc
            if as_json:
                _print_document(ended, verb.__name__, study, options)
            else:
                _print_lines(ended)
            if ended.failed:
                click.get_current_context().exit(FAILED_CASES)

        processes = (
            click.option(
                "--workers",
                type=click.IntRange(1, 1024),
                metavar="N",
                help="Processes on this machine; by default one for each core.",
            ),
            click.option(
                "--cluster",
                metavar="ADDRESS",
                help="A dask scheduler that computes instead, or local:N to start N workers here.",
            ),
        )
        parameters = (
            study_argument,
            out_option(out or f"octant-{verb.__name__}"),
            *(processes if workers else ()),
            *((seed_option,) if seed else ()),
            dry_run_option,
            json_option,
            common_options,
        )
        command: Callable[..., None] = run
        for parameter in reversed(parameters):
            command = parameter(command)
        return command

    return decorated


def _print_lines(ended: Ended) -> None:
    for number, line in enumerate(ended.lines):
        kind = ended.verdict if number == 0 else None
        click.echo(painted(line, kind, sys.stdout), color=True)
    if ended.written:
        click.echo(written_line(ended.written))


def print_plan(*lines: str, as_json: bool) -> None:
    """Print what would be computed.

    Parameters
    ----------
    *lines, as_json : Sentences; whether as a document.
    """
    if as_json:
        from octant.reader_design.terminal.documents import json_text

        click.echo(json_text({"dry_run": True, "summary": lines}))
        return
    for line in lines:
        click.echo(line)


def written_line(places: Sequence[Path]) -> str:
    """Return the line that names everything that was written.

    Parameters
    ----------
    places : Files and folders, at least one.
    """
    *first, last = map(str, places)
    return f"written: {', '.join(first)} and {last}" if first else f"written: {last}"


def _print_document(ended: Ended, verb: str, study: Path | None, options: RunOptions) -> None:
    from octant.reader_design.terminal.documents import csv_rows, json_text

    document = {
        "verb": verb,
        "study": study,
        "out": options.out,
        "dry_run": options.dry_run,
        "failed": ended.failed,
        "summary": ended.lines,
        "tables": {table.stem: csv_rows(table) for table in ended.tables if table.is_file()},
        "written": ended.written,
    }
    click.echo(json_text(document))
