"""Parameter types and options that several verbs share."""

import math
from collections.abc import Callable
from functools import wraps
from typing import Any, TypeVar, cast

import click

from octant.reader_design.keeping.progress import Progress

Decorated = TypeVar("Decorated", bound=Callable[..., Any])


class PointType(click.ParamType[tuple[float, float, float]]):
    """A point X,Y,Z [m] of the command line."""

    name = "X,Y,Z"

    def convert(
        self,
        value: Any,  # noqa: ANN401  click hands over text or a default
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> tuple[float, float, float]:
        """Return the three coordinates of a point.

        Parameters
        ----------
        value : str
            Three numbers with commas between them [m].
        param : click.Parameter or None
            The option it belongs to.
        ctx : click.Context or None
            Of the call.

        Returns
        -------
        (3,) tuple of float
            x, y, z [m].

        Raises
        ------
        click.BadParameter
            When these are not three finite numbers.
        """
        if isinstance(value, tuple):
            return value
        try:
            numbers = tuple(float(part) for part in str(value).split(","))
        except ValueError:
            numbers = ()
        if len(numbers) != 3 or not all(math.isfinite(n) for n in numbers):
            self.fail(
                f"{value!r} is not a point; write three finite numbers in m as X,Y,Z.", param, ctx
            )
        return numbers[0], numbers[1], numbers[2]


POINT = PointType()


def common_options(command: Decorated) -> Decorated:
    """Return a command that also takes ``--quiet`` and ``--force``, and announces compilation.

    Parameters
    ----------
    command : callable
        With the parameters ``quiet`` and ``force``.

    Returns
    -------
    callable
        The same, with the two options.
    """

    @wraps(command)
    def announcing(*args: Any, quiet: bool, **options: Any) -> Any:  # noqa: ANN401
        from octant.reader_design.compilation import FIRST_USE, recorded_compilation

        with recorded_compilation(lambda: Progress(quiet=quiet).say(FIRST_USE)):
            return command(*args, quiet=quiet, **options)

    force = click.option("--force", is_flag=True, help="Overwrite files that exist.")
    quiet = click.option("--quiet", "-q", is_flag=True, help="No progress and no messages.")
    return cast("Decorated", quiet(force(announcing)))


def worker_options(command: Decorated) -> Decorated:
    """Return a command that also takes ``--workers`` and ``--cluster``, but not both.

    Parameters
    ----------
    command : callable
        With the parameters ``workers`` and ``cluster``.

    Returns
    -------
    callable
        The same, with the two options.
    """

    @wraps(command)
    def checked(*args: Any, workers: int | None, cluster: str | None, **options: Any) -> Any:  # noqa: ANN401
        if workers is not None and cluster is not None:
            msg = "--workers and --cluster are both given, but cells are computed by one of them."
            raise click.UsageError(msg)
        return command(*args, workers=workers, cluster=cluster, **options)

    processes = click.option(
        "--workers",
        type=click.IntRange(min=1),
        metavar="N",
        help="Processes on this machine; by default one for each core.",
    )
    scheduler = click.option(
        "--cluster",
        metavar="ADDRESS",
        help="A dask scheduler that computes instead, or local:N to start N workers here.",
    )
    return cast("Decorated", processes(scheduler(checked)))
