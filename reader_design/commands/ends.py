"""The two ends of a path on the command line: places, antennas, and the link between them."""

from collections.abc import Callable
from dataclasses import replace as with_values
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click
import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.geometries.names import nearest_name
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import POINT, approve, number, point
from octant.reader_design.study_file.quantities import Angle
from octant.reader_design.terminal.completion import (
    PATTERN_FILES,
    built_in_antennas,
    files,
    tags,
)

if TYPE_CHECKING:
    from octant.reader_design.face.paths import End, PathLink
    from octant.reader_design.study_file.schema import Study

Decorated = TypeVar("Decorated", bound=Callable[..., Any])
Point = tuple[float, float, float]
Place = Point | str
"""A point [m], or the name of a tag of the study."""


def place(text: str) -> Place:
    """Return a point X,Y,Z [m], or the text itself where it names a tag.

    Parameters
    ----------
    text : What was typed.
    """
    return point(text) if "," in text else text


PLACE = click.types.FuncParamType(place)
PLACE.name = "X,Y,Z|TAG"


def tx_option(*, required: bool = True) -> Callable[[Any], Any]:
    """Return the decorator for ``--tx``, a point or a tag of the study.

    Parameters
    ----------
    required : Whether it must be given.
    """
    text = "Transmitter: a point [m], or a tag of STUDY with its antenna."
    return click.option("--tx", type=PLACE, required=required, shell_complete=tags, help=text)


def path_options(command: Decorated) -> Decorated:
    """Return a command that also takes the antennas at both ends and the order of its paths.

    Parameters
    ----------
    command : With the parameters ``antennas``, a pair of `End`, and ``max_reflections``.
    """

    @wraps(command)
    def with_antennas(**given: Any) -> Any:  # noqa: ANN401
        ends = tuple(_end(end, given) for end in ("tx", "rx"))
        return command(antennas=ends, **given)

    options: list[Any] = [
        click.option(
            "--max-reflections",
            type=click.IntRange(0, 12),
            metavar="N",
            help="Highest order, 0 to 12; default: the study's.",
        )
    ]
    for end, own in (("tx", "its own for a tag, else dipole"), ("rx", "dipole")):
        options += [
            click.option(
                f"--{end}-antenna",
                metavar="KIND|FILE",
                shell_complete=files(*PATTERN_FILES, names=built_in_antennas),
                help="dipole, monopole, patch, conical_patch, isotropic_theta or a pattern file; "
                f"default: {own}.",
            ),
            click.option(
                f"--{end}-axis", type=POINT, help="Its direction; default: up, patches down."
            ),
            click.option(
                f"--{end}-azimuth-deg",
                type=number(Angle),
                metavar="DEG",
                default=None,
                help="Turn about the axis [deg]; default: 0.",
            ),
        ]
    wrapped: Any = with_antennas
    for option in reversed(options):
        wrapped = option(wrapped)
    result: Decorated = wrapped
    return result


def _end(end: str, given: dict[str, Any]) -> "End":
    from octant.reader_design.face.paths import End

    name, axis, azimuth_deg = (
        given.pop(f"{end}_{what}") for what in ("antenna", "axis", "azimuth_deg")
    )
    return End(
        place_key=f"--{end}",
        antenna_key=f"--{end}-antenna",
        antenna=name or "",
        axis=axis,
        azimuth_deg=azimuth_deg or 0.0,
    )


def _placed(study: "Study", tx: Place, end: "End") -> tuple[Point, "End"]:
    """Return the transmitter's place [m] and antenna; a tag's own where none is given."""
    if not isinstance(tx, str):
        return tx, with_values(end, antenna=end.antenna or "dipole")
    tag = next((tag for tag in study.tags if tag.id == tx), None)
    if tag is None:
        ids = [tag.id for tag in study.tags]
        near = nearest_name(tx, ids, least_likeness=0.5)
        hint = f"did you mean {near!r}?" if near else f"its tags are {', '.join(ids) or 'none'}."
        msg = f"--tx is {tx!r}, which is neither a point X,Y,Z [m] nor a tag of the study; {hint}"
        raise ConfigError(msg)
    if end.antenna:
        return tag.position_m, end
    return tag.position_m, with_values(
        end,
        antenna=tag.antenna,
        axis=end.axis or tag.axis,
        azimuth_deg=end.azimuth_deg or tag.azimuth_deg,
    )


def command_link(
    study: Path | None,
    tx: Place,
    receivers: npt.ArrayLike,
    *,
    antennas: tuple["End", "End"],
    max_reflections: int | None,
    progress: Progress,
) -> "PathLink":
    """Return the link between two ends in the room of a study file, after saying what was moved.

    Parameters
    ----------
    study, antennas : The study file (None: the built-in one); transmitting and receiving antenna.
    tx, receivers : Transmitter, a point or a tag, and (m, 3) array_like receivers [m].
    max_reflections : Highest order; None: the study's.
    progress : Says which antennas were moved off a surface.
    """
    from octant.reader_design.face.paths import path_link
    from octant.reader_design.setting.cost import field_cost
    from octant.reader_design.study_file.loading import load_study, replace

    loaded = load_study(study)
    solver = loaded.solver
    if max_reflections is not None:
        solver = replace(solver, max_reflections=max_reflections)
    asked = replace(loaded, solver=solver, reader=replace(loaded.reader, antennas=3))
    count = len(np.asarray(receivers).reshape(-1, 3))
    approve(field_cost(asked, count, tags=1, causes=("receivers",)), progress)
    point_m, transmitter = _placed(loaded, tx, antennas[0])
    link = path_link(
        loaded,
        point_m,
        receivers,
        tx=transmitter,
        rx=with_values(antennas[1], antenna=antennas[1].antenna or "dipole"),
        max_reflections=max_reflections,
    )
    for line in link.notes:
        progress.say(line)
    return link
