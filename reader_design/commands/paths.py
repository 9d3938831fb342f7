"""``octant paths``: every path between a transmitter and receivers."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from octant.geometries.errors import ConfigError
from octant.reader_design.commands.ends import Place, Point, command_link, path_options, tx_option
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import POINT, common_options, json_option, study_argument
from octant.reader_design.terminal.completion import files

if TYPE_CHECKING:
    from octant.reader_design.face.paths import Block, End

LISTED_RECEIVERS = 50
"""Receivers that are listed beside a CSV file, and up to which their paths are."""
LISTED_PATHS = 20
"""Paths that are listed without ``--all``, shared by the receivers."""


@click.command()
@study_argument
@tx_option()
@click.option("--rx", type=POINT, multiple=True, help="Receiver [m]; may be repeated.")
@click.option(
    "--rx-file",
    type=click.Path(path_type=Path),
    shell_complete=files(".csv"),
    help="Receivers: CSV with x_m,y_m,z_m.",
)
@click.option("--all", "every", is_flag=True, help="List every path, not only the strongest.")
@path_options
@click.option("--csv", "csv_file", metavar="FILE", help="Write one row a path here; - for stdout.")
@click.option("--verbose", "-v", is_flag=True, help="Say what the search considered and left out.")
@json_option
@common_options
def paths(
    *,
    study: Path | None,
    tx: Place,
    rx: tuple[Point, ...],
    rx_file: Path | None,
    every: bool,
    max_reflections: int | None,
    antennas: tuple["End", "End"],
    csv_file: str | None,
    verbose: bool,
    as_json: bool,
    force: bool,
    quiet: bool,
) -> None:
    """Find every path from --tx to each --rx in the room of STUDY.

    Lists the strongest paths: R is a reflection, D a diffraction, T a transmission; the gain is
    that between the two antennas, free-space loss included; angles are theta from +z and phi from
    +x. Receivers are numbered from 0 in the order given, --rx before --rx-file. A receiver that no
    path reaches is a result too. Coherent: |sum of the gains|^2; power sum: sum of |gain|^2.
    """
    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.face.path_texts import path_lines, paths_document, search_lines
    from octant.reader_design.face.paths import (
        PATH_COLUMNS,
        path_rows,
        receiver_sums,
        summary_lines,
    )
    from octant.reader_design.showing.tables import put_table, read_columns
    from octant.reader_design.terminal.documents import json_text

    if as_json and csv_file is not None:
        msg = "--json and --csv are both given, but one of them says it all; give one."
        raise ConfigError(msg)
    if csv_file not in {None, "-"}:
        refuse_overwrite(Path(str(csv_file)), force=force)
    given = np.array(rx, dtype=np.float64).reshape(-1, 3)
    if rx_file is not None:
        given = np.concatenate([given, read_columns(rx_file, ["x_m", "y_m", "z_m"])])
    if len(given) == 0:
        msg = "no receiver is given; add --rx X,Y,Z or --rx-file FILE.csv."
        raise ConfigError(msg)
    progress = Progress(quiet=quiet)
    link = command_link(
        study, tx, given, antennas=antennas, max_reflections=max_reflections, progress=progress
    )
    bars = replace(progress, bars=link.block_count > 1)
    sums, listed = [], []
    most = None if every else max(1, LISTED_PATHS // len(given))
    few = every or len(given) <= LISTED_RECEIVERS

    def summed() -> "Iterator[Block]":
        for block in link.blocks():
            sums.append(receiver_sums(block))
            yield block

    with bars.track(summed(), total=link.block_count, label="receivers") as blocks:
        if as_json:
            click.echo(json_text(paths_document(link, list(blocks), study=study)))
            return
        if csv_file is not None:
            rows = (row for block in blocks for row in path_rows(block))
            put_table(csv_file, PATH_COLUMNS, rows, force=force)
        else:
            for block in blocks:
                listed += list(path_lines(block, most=most)) if few else []
    shown = None if csv_file is None else LISTED_RECEIVERS
    for line in summary_lines(link, np.concatenate(sums), most=shown):
        click.echo(line, err=csv_file == "-")
    for line in listed:
        click.echo(line)
    if verbose:
        for line in search_lines(link):
            click.echo(line, err=True)
