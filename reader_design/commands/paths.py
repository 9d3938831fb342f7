"""``octant paths`` and ``octant rss``: how outsiders check the physics; their columns are fixed."""

from collections import deque
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np
import numpy.typing as npt

from octant.em.decibels import decibels
from octant.geometries.errors import ConfigError
from octant.reader_design.commands.ends import EndAntenna, PathLink, path_options, study_link
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import (
    POINT,
    common_options,
)

if TYPE_CHECKING:
    from octant.em.fields.gains import PathGains
    from octant.em.records import PathSet

FloatArray = npt.NDArray[np.float64]

PATH_COLUMNS = (
    "rx",
    "path",
    "order",
    "interactions",
    "length_m",
    "delay_ns",
    "departure_theta_deg",
    "departure_phi_deg",
    "arrival_theta_deg",
    "arrival_phi_deg",
    "gain_db",
    "phase_deg",
    "vertices",
)
NANOSECONDS_PER_SECOND = 1e9
RECEIVERS_PER_BLOCK = 512
LISTED_RECEIVERS = 50


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
    tx: tuple[float, float, float],
    rx: tuple[tuple[float, float, float], ...],
    rx_file: Path | None,
    max_reflections: int | None,
    antennas: tuple[EndAntenna, EndAntenna],
    csv_file: str | None,
    force: bool,
    quiet: bool,
) -> None:
    """Find every path from --tx to each --rx in the room of STUDY.

    The gain between the two antennas includes the free-space loss. Receivers are numbered from 0 in
    the order given, --rx before --rx-file. One without any path is a result.
    Coherent: |sum of the gains|^2; power sum: sum of |gain|^2.
    """
    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.showing.tables import put_table, read_columns

    if csv_file not in {None, "-"}:
        refuse_overwrite(Path(str(csv_file)), force=force)
    given = np.array(rx, dtype=np.float64).reshape(-1, 3)
    if rx_file is not None:
        given = np.concatenate([given, read_columns(rx_file, ["x_m", "y_m", "z_m"])])
    if len(given) == 0:
        msg = "no receiver is given; add --rx X,Y,Z or --rx-file FILE.csv."
        raise ConfigError(msg)
    link = study_link(
        study,
        tx,
        given,
        antennas=antennas,
        max_reflections=max_reflections,
        progress=Progress(quiet=quiet),
    )
    sums = np.zeros((len(link.receivers_m), 3))
    blocks = _traced(link, sums)
    if csv_file is None:
        deque(blocks, maxlen=0)
    else:
        rows = (row for block in blocks for row in _rows(*block))
        put_table(csv_file, PATH_COLUMNS, rows, force=force)
    for line in _summary(link, sums, shorten=csv_file is not None):
        click.echo(line, err=csv_file == "-")


def _traced(link: PathLink, sums: FloatArray) -> "Iterator[tuple[int, PathSet, PathGains]]":
    """Yield blocks of paths; ``sums`` gets paths, |sum g|^2 and sum |g|^2 per receiver."""
    from octant.em.fields.gains import path_gains
    from octant.em.paths.tracing import trace_paths

    for first in range(0, len(link.receivers_m), RECEIVERS_PER_BLOCK):
        block = link.receivers_m[first : first + RECEIVERS_PER_BLOCK]
        found = trace_paths(link.radio, link.candidates, block)
        gains = path_gains(link.radio, found, transmitter=link.transmitter, receiver=link.receiver)
        field = np.zeros(len(block), dtype=np.complex128)
        np.add.at(field, found.receiver, gains.gain)
        part = sums[first : first + len(block)]
        part[:, 0] = np.bincount(found.receiver, minlength=len(block))
        part[:, 1] = np.abs(field) ** 2
        np.add.at(part[:, 2], found.receiver, np.abs(gains.gain) ** 2)
        yield first, found, gains


def _rows(first: int, found: "PathSet", gains: "PathGains") -> Iterator[Sequence[object]]:
    """Yield the CSV's rows of one block, whose first receiver has the number ``first``."""
    departure, arrival = _angles_deg(gains.departure), _angles_deg(gains.arrival)
    delay_ns = NANOSECONDS_PER_SECOND * gains.delay_s
    gain_db, phase_deg = decibels(np.abs(gains.gain) ** 2), np.angle(gains.gain, deg=True)
    number = np.arange(len(found)) - np.searchsorted(found.receiver, found.receiver)
    for k in range(len(found)):
        yield (
            first + int(found.receiver[k]),
            int(number[k]),
            int(found.order[k]),
            ",".join(found.letters_of(k)),
            float(gains.length_m[k]),
            float(delay_ns[k]),
            *departure[k].tolist(),
            *arrival[k].tolist(),
            float(gain_db[k]),
            float(phase_deg[k]),
            ";".join(":".join(repr(c) for c in v) for v in found.vertices_of(k).tolist()),
        )


def _summary(link: PathLink, sums: FloatArray, *, shorten: bool) -> Iterator[str]:
    coherent_db, power_db = decibels(sums[:, 1]), decibels(sums[:, 2])
    names = ("rx", "x_m", "y_m", "z_m", "paths", "coherent_db", "power_sum_db")
    widths = (6, 9, 9, 9, 6, 12, 13)
    yield " ".join(f"{name:>{width}}" for name, width in zip(names, widths, strict=True))
    shown = LISTED_RECEIVERS if shorten and len(sums) > LISTED_RECEIVERS else len(sums)
    for i in range(shown):
        x, y, z = link.receivers_m[i]
        yield (
            f"{i:>6} {x:>9.4f} {y:>9.4f} {z:>9.4f} {int(sums[i, 0]):>6} "
            f"{coherent_db[i]:>12.4f} {power_db[i]:>13.4f}"
        )
    if shown < len(sums):
        yield f"   ... and {len(sums) - shown} more receivers: see the CSV."
    yield f"{int(sums[:, 0].sum())} paths to {len(sums)} receiver{'' if len(sums) == 1 else 's'}."
    tree, edges = link.candidates.images, link.candidates.edges
    for order in range(tree.max_order + 1):
        yield (
            f"order {order}: {tree.considered[order]} sequences considered, "
            f"{tree.pruned[order]} pruned, {tree.merged[order]} merged, "
            f"{tree.kept[order]} images kept."
        )
    if edges is not None:
        yield (
            f"edges: {edges.considered} ways over {len(link.radio.wedges)} wedges considered, "
            f"{edges.considered - edges.kept} pruned, {edges.kept} kept."
        )


def _angles_deg(directions: FloatArray) -> FloatArray:
    """Return (k, 2) angles [deg]: theta from +z, phi from +x towards +y in [0, 360)."""
    across = np.hypot(directions[:, 0], directions[:, 1])
    theta = np.degrees(np.arctan2(across, directions[:, 2]))
    phi = np.degrees(np.arctan2(directions[:, 1], directions[:, 0])) % 360.0
    return np.column_stack([theta, np.where(phi >= 360.0, 0.0, phi)])


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option("--tag", "tag_id", required=True, help="Tag of the study that transmits.")
@click.option(
    "--poses", type=click.Path(path_type=Path), required=True, help="CSV: x_m,y_m,heading_deg."
)
@click.option("--csv", "csv_file", help="Write the RSS here; default: stdout.")
@common_options
def rss(
    *, study: Path, tag_id: str, poses: Path, csv_file: str | None, force: bool, quiet: bool
) -> None:
    """Compute what each antenna of the reader of STUDY receives from one tag, pose by pose.

    Writes the poses and rss_1_w ... rss_n_w, coherent power in watts.
    """
    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.setting.links import study_responses, tag_link
    from octant.reader_design.setting.setting import build_setting
    from octant.reader_design.showing.tables import put_table, read_columns
    from octant.reader_design.study_file.loading import load_study

    loaded = load_study(study)
    if csv_file not in {None, "-"}:
        refuse_overwrite(Path(str(csv_file)), force=force)
    given = read_columns(poses, ["x_m", "y_m", "heading_deg"])
    built = build_setting(loaded)
    tag = built.tag(tag_id)
    progress = Progress(quiet=quiet)
    for note in built.notes:
        progress.say(note)
    link = tag_link(loaded, built, tag, study_responses(loaded))
    radians = given * (1.0, 1.0, np.pi / 180.0)
    header = ["x_m", "y_m", "heading_deg", *(f"rss_{i + 1}_w" for i in range(link.antennas))]
    blocks = (
        np.column_stack([given[i : i + 1000], link.rss_w(radians[i : i + 1000])])
        for i in range(0, len(given), 1000)
    )
    put_table(csv_file, header, (row for block in blocks for row in block.tolist()), force=force)
