"""``octant paths``, ``octant explain`` and ``octant rss``: how outsiders check the physics."""

from collections.abc import Callable, Iterator
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click
import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import POINT, approve, common_options, number
from octant.reader_design.study_file.quantities import Angle, Count, Deviation, Seed

if TYPE_CHECKING:
    from octant.reader_design.face.paths import Block, End, PathLink

Decorated = TypeVar("Decorated", bound=Callable[..., Any])
Point = tuple[float, float, float]

LISTED_RECEIVERS = 50


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
            help="Highest order; default: the study's.",
        )
    ]
    for end in ("tx", "rx"):
        options += [
            click.option(
                f"--{end}-antenna",
                default="dipole",
                show_default=True,
                help="dipole, monopole, patch, isotropic_theta or a pattern file.",
            ),
            click.option(
                f"--{end}-axis", type=POINT, help="Its direction; default: up, a patch down."
            ),
            click.option(
                f"--{end}-azimuth-deg",
                type=number(Angle),
                default=0.0,
                help="Turn about the axis [deg].",
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
        antenna=name,
        axis=axis,
        azimuth_deg=azimuth_deg,
    )


def command_link(
    study: Path,
    tx: Point,
    receivers: Any,  # noqa: ANN401  array-like
    *,
    antennas: tuple["End", "End"],
    max_reflections: int | None,
    progress: Progress,
) -> "PathLink":
    """Return the link between two ends in the room of a study file, after saying what was moved.

    Parameters
    ----------
    study, antennas : The study file; transmitting and receiving antenna.
    tx, receivers : (3,) and (m, 3) array_like — Transmitter and receivers [m].
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
    approve(field_cost(asked, len(receivers), tags=1, causes=("receivers",)), progress)
    link = path_link(
        loaded,
        tx,
        receivers,
        tx=antennas[0],
        rx=antennas[1],
        max_reflections=max_reflections,
    )
    for line in link.notes:
        progress.say(line)
    return link


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option("--tx", type=POINT, required=True, help="Transmitter [m].")
@click.option("--rx", type=POINT, multiple=True, help="Receiver [m]; may be repeated.")
@click.option("--rx-file", type=click.Path(path_type=Path), help="CSV with x_m,y_m,z_m.")
@path_options
@click.option("--csv", "csv_file", help="Write one row a path here; - for stdout.")
@common_options
def paths(
    *,
    study: Path,
    tx: Point,
    rx: tuple[Point, ...],
    rx_file: Path | None,
    max_reflections: int | None,
    antennas: tuple["End", "End"],
    csv_file: str | None,
    force: bool,
    quiet: bool,
) -> None:
    """Find every path from --tx to each --rx in the room of STUDY.

    The gain between the two antennas includes the free-space loss. Receivers are numbered from 0 in
    the order given, --rx before --rx-file. A receiver that no path reaches is a result too.
    Coherent: |sum of the gains|^2; power sum: sum of |gain|^2.
    """
    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.face.paths import (
        PATH_COLUMNS,
        path_rows,
        receiver_sums,
        summary_lines,
    )
    from octant.reader_design.showing.tables import put_table, read_columns

    if csv_file not in {None, "-"}:
        refuse_overwrite(Path(str(csv_file)), force=force)
    given = np.array(rx, dtype=np.float64).reshape(-1, 3)
    if rx_file is not None:
        given = np.concatenate([given, read_columns(rx_file, ["x_m", "y_m", "z_m"])])
    if len(given) == 0:
        msg = "no receiver is given; add --rx X,Y,Z or --rx-file FILE.csv."
        raise ConfigError(msg)
    link = command_link(
        study,
        tx,
        given,
        antennas=antennas,
        max_reflections=max_reflections,
        progress=Progress(quiet=quiet),
    )
    sums = []

    def summed() -> "Iterator[Block]":
        for block in link.blocks():
            sums.append(receiver_sums(block))
            yield block

    if csv_file is None:
        for _ in summed():
            pass
    else:
        rows = (row for block in summed() for row in path_rows(block))
        put_table(csv_file, PATH_COLUMNS, rows, force=force)
    most = None if csv_file is None else LISTED_RECEIVERS
    for line in summary_lines(link, np.concatenate(sums), most=most):
        click.echo(line, err=csv_file == "-")


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option("--tx", type=POINT, required=True, help="Transmitter [m].")
@click.option("--rx", type=POINT, required=True, help="Receiver [m].")
@click.option(
    "--path",
    "number",
    type=click.IntRange(0, 10**9),
    help="Number of the path, as in octant paths.",
)
@click.option("--strongest", is_flag=True, help="The strongest path; so without --path.")
@path_options
@click.option("--csv", "csv_file", help="Write one row a line of the budget here; - for stdout.")
@common_options
def explain(
    *,
    study: Path,
    tx: Point,
    rx: Point,
    number: int | None,
    strongest: bool,
    antennas: tuple["End", "End"],
    max_reflections: int | None,
    csv_file: str | None,
    force: bool,
    quiet: bool,
) -> None:
    """Explain one path from --tx to --rx in the room of STUDY: where its decibels go.

    Every line is what one step does to the level; they add up to the path's gain_db in octant
    paths. An interaction's line is the loss that the field suffers as it is polarised there; beside
    it stand the coefficients of both polarisations and the share of the power that arrives in TE.
    """
    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.face.paths import BUDGET_COLUMNS, Paths
    from octant.reader_design.showing.tables import put_table

    if number is not None and strongest:
        msg = "--path and --strongest are both given, but one path is explained; give one."
        raise ConfigError(msg)
    if csv_file not in {None, "-"}:
        refuse_overwrite(Path(str(csv_file)), force=force)
    link = command_link(
        study,
        tx,
        np.array([rx]),
        antennas=antennas,
        max_reflections=max_reflections,
        progress=Progress(quiet=quiet),
    )
    found = Paths(link=link, blocks=tuple(link.blocks()))
    if len(found) == 0:
        click.echo("no path arrives there, so there is nothing to explain.", err=csv_file == "-")
        return
    if number is not None and number >= len(found):
        msg = f"--path is {number}, but the paths are numbered 0 to {len(found) - 1}."
        raise ConfigError(msg)
    explanation = found.explain(number)
    if csv_file is not None:
        put_table(csv_file, BUDGET_COLUMNS, explanation.rows(), force=force)
    for line in explanation.lines():
        click.echo(line, err=csv_file == "-")


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option("--tag", "tag_id", required=True, help="Tag of the study that transmits.")
@click.option(
    "--poses", type=click.Path(path_type=Path), required=True, help="CSV: x_m,y_m,heading_deg."
)
@click.option("--csv", "csv_file", help="Write the RSS here; default: stdout.")
@click.option(
    "--readings",
    type=number(Count),
    help="Give so many readings of each pose by the receiver of [sensor]; default: exact power.",
)
@click.option(
    "--noise-db",
    type=number(Deviation),
    help="Noise of each reading [dB]; default: that of [mission] or [dock], or none.",
)
@click.option("--seed", type=number(Seed), help="Seed of the readings; default: the study's.")
@common_options
def rss(
    *,
    study: Path,
    tag_id: str,
    poses: Path,
    csv_file: str | None,
    readings: int | None,
    noise_db: float | None,
    seed: int | None,
    force: bool,
    quiet: bool,
) -> None:
    """Compute what each antenna of the reader of STUDY receives from one tag, pose by pose.

    Writes the poses and rss_1_w ... rss_n_w, coherent power in watts. With --readings each pose has
    a row a reading, as the receiver of the table [sensor] reads it with the robot at rest; the last
    column counts them, and what is not received is 0.
    """
    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.face.rss_map import pose_rss_w, rss_columns, rss_link
    from octant.reader_design.face.rss_readings import READINGS_STREAM, readings_w, study_noise_db
    from octant.reader_design.setting.cost import field_cost, reader_cost
    from octant.reader_design.showing.tables import put_table, read_columns
    from octant.reader_design.study_file.loading import load_study

    loaded = load_study(study)
    if readings is None and (noise_db is not None or seed is not None):
        msg = "--noise-db and --seed are of readings, but --readings is not given; give it too."
        raise ConfigError(msg)
    if csv_file not in {None, "-"}:
        refuse_overwrite(Path(str(csv_file)), force=force)
    given = read_columns(poses, ["x_m", "y_m", "heading_deg"])
    progress = Progress(quiet=quiet)
    cost = field_cost(loaded, len(given), tags=1, causes=("poses",))
    approve(reader_cost(loaded).and_then(cost), progress)
    link = rss_link(loaded, tag_id, given, progress=progress)
    columns = rss_columns(link.antennas)
    rng = np.random.default_rng((loaded.seed if seed is None else seed, READINGS_STREAM))

    def block(places: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        power_w = pose_rss_w(link, places)
        if readings is None:
            return np.column_stack([places, power_w])
        read = readings_w(
            loaded,
            power_w,
            link.azimuths_rad,
            rng,
            readings=readings,
            noise_db=study_noise_db(loaded) if noise_db is None else noise_db,
        )
        numbers = np.tile(np.arange(readings, dtype=np.float64), len(places))
        rows = read.reshape(-1, link.antennas)
        return np.column_stack([np.repeat(places, readings, axis=0), rows, numbers])

    blocks = (block(given[i : i + 1000]) for i in range(0, len(given), 1000))
    put_table(
        csv_file,
        columns if readings is None else [*columns, "reading"],
        (row for block in blocks for row in block.tolist()),
        force=force,
    )
