"""Parameter types and options that several verbs share."""

import math
from collections.abc import Callable
from typing import Any, TypeVar

import click

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

PATH_KERNELS = ("em._path_kernels", "em._field_kernels")
"""Kernels that single paths need."""
POWER_KERNELS = ("em._power_kernels", "em._response_kernels")
"""Kernels that received power needs."""
DRIVE_KERNELS = (*POWER_KERNELS, "navigation._fuzzy_kernels")
"""Kernels that missions need."""
TRACK_KERNELS = (
    *PATH_KERNELS,
    "em._image_field_kernels",
    "navigation._fuzzy_kernels",
    "navigation._rss_map_kernels",
    "navigation.tracking._feedback_kernels",
    "navigation.tracking._ilqr_kernels",
    "navigation.tracking._optimal_kernels",
)
"""Kernels that trajectory tracking needs."""
FULLWAVE_KERNELS = ("em.fullwave._rwg_kernels", "em.fullwave._far_kernels")
"""Kernels that the full-wave response of the reader needs."""


def kernels_for(model: str, *needed: str) -> tuple[str, ...]:
    """Return the kernels that are needed, with those of the reader's model.

    Parameters
    ----------
    model : str
        ``reader.response`` of the study [-].
    *needed : str
        Kernels that are needed in any case.

    Returns
    -------
    tuple of str
        For :meth:`octant.reader_design.progress.Progress.announce_compilation` [-].
    """
    return (*FULLWAVE_KERNELS, *needed) if model == "fullwave" else needed


def common_options(command: Decorated) -> Decorated:
    """Return a command that also takes ``--quiet`` and ``--force``.

    Parameters
    ----------
    command : callable
        With the parameters ``quiet`` and ``force``.

    Returns
    -------
    callable
        The same, with the two options [-].
    """
    force = click.option("--force", is_flag=True, help="Overwrite files that exist.")
    quiet = click.option("--quiet", "-q", is_flag=True, help="No progress and no messages.")
    return quiet(force(command))
