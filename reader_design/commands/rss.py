"""``octant rss``: what each antenna of the reader receives, pose by pose."""

from collections.abc import Iterator
from pathlib import Path

import click
import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import (
    approve,
    common_options,
    json_option,
    number,
    seed_option,
    study_argument,
)
from octant.reader_design.study_file.quantities import Count, Deviation
from octant.reader_design.terminal.completion import files, tags

POSES_PER_BLOCK, READINGS_PER_BLOCK = 1000, 100_000
"""Rows that are held at a time, at most."""


@click.command()
@study_argument
@click.option(
    "--tag",
    "tag_id",
    metavar="TAG",
    shell_complete=tags,
    required=True,
    help="Tag of the study that transmits.",
)
@click.option(
    "--poses",
    type=click.Path(path_type=Path),
    shell_complete=files(".csv"),
    required=True,
    help="CSV with x_m,y_m,heading_deg.",
)
@click.option("--csv", "csv_file", metavar="FILE", help="Write the RSS here; default: stdout.")
@click.option("--dbm", is_flag=True, help="Add columns rss_1_dbm ... rss_n_dbm at the end.")
@click.option(
    "--readings",
    type=number(Count),
    metavar="N",
    help="Give so many readings of each pose by the receiver of [sensor]; default: exact power.",
)
@click.option(
    "--noise-db",
    type=number(Deviation),
    metavar="DB",
    help="Noise of each reading [dB]; default: that of [mission] or [dock], or none.",
)
@seed_option
@json_option
@common_options
def rss(
    *,
    study: Path | None,
    tag_id: str,
    poses: Path,
    csv_file: str | None,
    dbm: bool,
    readings: int | None,
    noise_db: float | None,
    seed: int | None,
    as_json: bool,
    force: bool,
    quiet: bool,
) -> None:
    """Compute what each antenna of the reader of STUDY receives from one tag, pose by pose.

    Writes the poses and rss_1_w ... rss_n_w, coherent power in watts. With --readings each pose has
    a row a reading, as the receiver of the table [sensor] reads it with the robot at rest; the
    column reading counts them, and what is not received is 0. With --dbm the same power follows in
    dBm, empty or -inf where nothing is received.
    """
    from octant.em.decibels import power_dbm
    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.face.rss_map import pose_rss_w, rss_columns, rss_link
    from octant.reader_design.face.rss_readings import READINGS_STREAM, readings_w, study_noise_db
    from octant.reader_design.setting.cost import field_cost, reader_cost, readings_cost
    from octant.reader_design.showing.tables import put_table, read_columns
    from octant.reader_design.study_file.loading import load_study
    from octant.reader_design.terminal.documents import json_text

    loaded = load_study(study)
    if as_json and csv_file is not None:
        msg = "--json and --csv are both given, but one of them says it all; give one."
        raise ConfigError(msg)
    if readings is None and (noise_db is not None or seed is not None):
        msg = "--noise-db and --seed are of readings, but --readings is not given; give it too."
        raise ConfigError(msg)
    if csv_file not in {None, "-"}:
        refuse_overwrite(Path(str(csv_file)), force=force)
    given = read_columns(poses, ["x_m", "y_m", "heading_deg"])
    progress = Progress(quiet=quiet)
    cost = field_cost(loaded, len(given), tags=1, causes=("poses",))
    if readings is not None:
        cost = cost.and_then(readings_cost(readings * len(given), causes=("--readings",)))
    approve(reader_cost(loaded).and_then(cost), progress)
    link = rss_link(loaded, tag_id, given, progress=progress)
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

    antennas = slice(3, 3 + link.antennas)
    columns = list(rss_columns(link.antennas))
    levels = [f"{name.removesuffix('_w')}_dbm" for name in columns[antennas]] if dbm else []
    columns += [*([] if readings is None else ["reading"]), *levels]
    step = min(POSES_PER_BLOCK, max(1, READINGS_PER_BLOCK // (readings or 1)))
    blocks = (block(given[i : i + step]) for i in range(0, len(given), step))

    def rows() -> Iterator[list[float]]:
        for found in blocks:
            more = [power_dbm(found[:, antennas])] if dbm else []
            yield from np.column_stack([found, *more]).tolist()

    if as_json:
        document = {
            "verb": "rss",
            "study": study,
            "tag": tag_id,
            "frequency_hz": loaded.radio.frequency_hz,
            "rows": [
                {
                    "x_m": row[0],
                    "y_m": row[1],
                    "heading_deg": row[2],
                    "reading": None if readings is None else int(row[-1]),
                    "rss_w": row[antennas],
                    "rss_dbm": power_dbm(np.array(row[antennas])),
                }
                for found in blocks
                for row in found.tolist()
            ],
        }
        click.echo(json_text(document))
        return
    put_table(csv_file, columns, rows(), force=force)
