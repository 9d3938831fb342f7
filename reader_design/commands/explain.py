"""``octant explain``: one path's budget in decibels."""

from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from octant.geometries.errors import ConfigError
from octant.reader_design.commands.ends import Place, Point, command_link, path_options, tx_option
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import POINT, common_options, json_option, study_argument

if TYPE_CHECKING:
    from octant.reader_design.face.paths import End


@click.command()
@study_argument
@tx_option()
@click.option("--rx", type=POINT, required=True, help="Receiver [m].")
@click.option(
    "--path",
    "number",
    type=click.IntRange(0, 10**9),
    metavar="N",
    help="Number of the path, as in octant paths.",
)
@click.option("--strongest", is_flag=True, help="The strongest path; so without --path.")
@path_options
@click.option(
    "--csv",
    "csv_file",
    metavar="FILE",
    help="Write one row a line of the budget here; - for stdout.",
)
@json_option
@common_options
def explain(
    *,
    study: Path | None,
    tx: Place,
    rx: Point,
    number: int | None,
    strongest: bool,
    antennas: tuple["End", "End"],
    max_reflections: int | None,
    csv_file: str | None,
    as_json: bool,
    force: bool,
    quiet: bool,
) -> None:
    """Explain one path from --tx to --rx in the room of STUDY: where its decibels go.

    Every line is what one step does to the level; they add up to the path's gain_db in octant
    paths. An interaction's line is the loss that the field suffers as it is polarised there; beside
    it stand the coefficients of both polarisations and the share of the power that arrives in TE.
    """
    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.face.path_texts import explanation_document
    from octant.reader_design.face.paths import BUDGET_COLUMNS, Paths
    from octant.reader_design.showing.tables import put_table
    from octant.reader_design.terminal.documents import json_text

    if number is not None and strongest:
        msg = "--path and --strongest are both given, but one path is explained; give one."
        raise ConfigError(msg)
    if as_json and csv_file is not None:
        msg = "--json and --csv are both given, but one of them says it all; give one."
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
        if as_json:
            click.echo(json_text(explanation_document(None, study=study)))
            return
        click.echo("no path arrives there, so there is nothing to explain.", err=csv_file == "-")
        return
    if number is not None and number >= len(found):
        msg = f"--path is {number}, but the paths are numbered 0 to {len(found) - 1}."
        raise ConfigError(msg)
    explanation = found.explain(number)
    if as_json:
        click.echo(json_text(explanation_document(explanation, study=study)))
        return
    if csv_file is not None:
        put_table(csv_file, BUDGET_COLUMNS, explanation.rows(), force=force)
    for line in explanation.lines():
        click.echo(line, err=csv_file == "-")
