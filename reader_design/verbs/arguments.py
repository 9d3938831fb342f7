"""Parameter types and options that several verbs share."""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from octant.geometries.errors import ConfigError

if TYPE_CHECKING:
    from octant.em.antennas import Antenna

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


def antenna_options(command: Decorated) -> Decorated:
    """Return a command that also takes the antennas at both ends of a path.

    Parameters
    ----------
    command : callable
        With the parameters ``tx_antenna``, ``tx_axis``, ``tx_azimuth_deg`` and those of ``rx`` [-].

    Returns
    -------
    callable
        The same, with six options [-].
    """
    known = "dipole, monopole, patch, isotropic_theta or a pattern file."
    for end in ("rx", "tx"):
        for option in (
            click.option(
                f"--{end}-azimuth-deg", type=float, default=0.0, help="Turn about the axis [deg]."
            ),
            click.option(
                f"--{end}-axis", type=POINT, help="Its direction; default: up, a patch down."
            ),
            click.option(f"--{end}-antenna", default="dipole", show_default=True, help=f"{known}"),
        ):
            command = option(command)
    return command


def end_antenna(
    end: str,
    frequency_hz: float,
    *,
    name: str,
    axis: tuple[float, float, float] | None,
    azimuth_deg: float,
) -> "Antenna":
    """Return the antenna that the options of one end name.

    Parameters
    ----------
    end : str
        ``tx`` or ``rx``, for messages.
    frequency_hz : float
        Frequency [Hz].
    name : str
        Kind or pattern file.
    axis : (3,) tuple of float or None
        Direction [-].
    azimuth_deg : float
        Turn about the axis [deg].

    Returns
    -------
    Antenna
        In the room's frame.

    Raises
    ------
    ConfigError
        When there is no such antenna, or its angle is not finite.
    """
    from octant.reader_design.rooms.antennas import named_antenna

    if not math.isfinite(azimuth_deg):
        msg = f"--{end}-azimuth-deg is {azimuth_deg} degrees, but a finite number is needed."
        raise ConfigError(msg)
    return named_antenna(
        name, frequency_hz, key=f"--{end}-antenna", axis=axis, azimuth_deg=azimuth_deg
    )


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
