"""``octant explain``: one path's budget in dB, interaction by interaction."""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.reader_design.commands.ends import EndAntenna, PathLink, path_options, study_link
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import POINT, common_options

if TYPE_CHECKING:
    from octant.em.fields.explain import BudgetLine, PathBudget
    from octant.em.fields.gains import PathGains
    from octant.em.records import PathSet

COLUMNS = (
    "step",
    "change_db",
    "level_db",
    "element",
    "material",
    "incidence_deg",
    "te_db",
    "te_phase_deg",
    "tm_db",
    "tm_phase_deg",
    "te_share",
    "x_m",
    "y_m",
    "z_m",
    "detail",
)
NANOSECONDS_PER_SECOND = 1e9


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option("--tx", type=POINT, required=True, help="Transmitter [m].")
@click.option("--rx", type=POINT, required=True, help="Receiver [m].")
@click.option(
    "--path", "number", type=click.IntRange(min=0), help="Number of the path, as in octant paths."
)
@click.option("--strongest", is_flag=True, help="The strongest path; so without --path.")
@path_options
@click.option("--csv", "csv_file", help="Write one row a line of the budget here; - for stdout.")
@common_options
def explain(
    *,
    study: Path,
    tx: tuple[float, float, float],
    rx: tuple[float, float, float],
    number: int | None,
    strongest: bool,
    antennas: tuple[EndAntenna, EndAntenna],
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
    from octant.em.fields.explain import explain_path
    from octant.em.fields.gains import path_gains
    from octant.em.paths.tracing import trace_paths
    from octant.geometries.files import refuse_overwrite
    from octant.reader_design.showing.tables import put_table

    if number is not None and strongest:
        msg = "--path and --strongest are both given, but one path is explained; give one."
        raise ConfigError(msg)
    if csv_file not in {None, "-"}:
        refuse_overwrite(Path(str(csv_file)), force=force)
    link = study_link(
        study,
        tx,
        np.array([rx]),
        antennas=antennas,
        max_reflections=max_reflections,
        progress=Progress(quiet=quiet),
    )
    found = trace_paths(link.radio, link.candidates, link.receivers_m)
    ends = {"transmitter": link.transmitter, "receiver": link.receiver}
    gains = path_gains(link.radio, found, **ends)
    chosen = _chosen(gains.gain, number)
    if chosen is None:
        click.echo("no path arrives there, so there is nothing to explain.", err=csv_file == "-")
        return
    budget = explain_path(link.radio, found, chosen, **ends)
    if csv_file is not None:
        put_table(csv_file, COLUMNS, _rows(budget), force=force)
    for line in (*_head(link, found, gains, chosen), "", *_table(budget)):
        click.echo(line, err=csv_file == "-")


def _chosen(gain: npt.NDArray[np.complex128], number: int | None) -> int | None:
    """Return the row of the path that is asked for, or None where there is none at all."""
    if len(gain) == 0:
        return None
    if number is None:
        return int(np.argmax(np.abs(gain)))
    if number >= len(gain):
        msg = f"--path is {number}, but the paths are numbered 0 to {len(gain) - 1}."
        raise ConfigError(msg)
    return number


def _head(link: PathLink, found: "PathSet", gains: "PathGains", chosen: int) -> Iterator[str]:
    """Yield what path this is."""
    strength = np.abs(gains.gain)
    rank = int((strength > strength[chosen]).sum()) + 1
    order = int(found.order[chosen])
    of_order = "line of sight" if order == 0 else f"order {order}"
    yield (
        f"path {chosen} of {len(found)} ({of_order}; rank {rank} by power), "
        f"{link.radio.frequency_hz / 1e9:g} GHz"
    )
    yield (
        f"length {gains.length_m[chosen]:.6g} m, delay "
        f"{NANOSECONDS_PER_SECOND * gains.delay_s[chosen]:.6g} ns"
    )
    places = (f"({x:.4g}, {y:.4g}, {z:.4g})" for x, y, z in found.vertices_of(chosen))
    yield " -> ".join(places) + " m"


def _table(budget: "PathBudget") -> Iterator[str]:
    """Yield the budget as people read it."""
    width = max(len(line.detail) for line in budget.lines) + 1
    coefficients = f"{'incid.':>7} {'TE':>15} {'TM':>15} {'in TE':>6}"
    yield f"{'':<19}{'':<{width}} {coefficients} {'change':>9} {'level':>9}"
    yield (
        f"{'':<19}{'':<{width}} {'deg':>7} {'dB':>8} {'deg':>6} {'dB':>8} {'deg':>6} {'%':>6} "
        f"{'dB':>9} {'dB':>9}"
    )
    level = 0.0
    for line in budget.lines:
        level += line.change_db
        yield (
            f"{line.step:<19}{line.detail:<{width}} {_coefficients(line)} "
            f"{line.change_db:>+9.3f} {level:>9.3f}"
        )
    phase = math.degrees(math.atan2(budget.gain.imag, budget.gain.real))
    total = f"gain {budget.gain_db:.3f} dB, phase {phase:.2f} deg"
    yield f"{'together':<19}{total}"


def _coefficients(line: "BudgetLine") -> str:
    if line.te is None or line.tm is None or line.incidence_rad is None:
        return " " * 46
    share = "" if line.te_share is None else f"{100.0 * line.te_share:.0f}"
    te, tm = (f"{_db(c):>8.2f} {_deg(c):>6.1f}" for c in (line.te, line.tm))
    return f"{math.degrees(line.incidence_rad):>7.2f} {te} {tm} {share:>6}"


def _rows(budget: "PathBudget") -> Iterator[Sequence[object]]:
    """Yield the budget's lines for a CSV; what a line does not have stays empty."""
    level = 0.0
    for line in budget.lines:
        level += line.change_db
        both = [None] * 4 if line.te is None or line.tm is None else [
            _db(line.te), _deg(line.te), _db(line.tm), _deg(line.tm)
        ]  # fmt: skip
        incidence = None if line.incidence_rad is None else math.degrees(line.incidence_rad)
        yield (
            line.step,
            line.change_db,
            level,
            line.element,
            line.material,
            incidence,
            *both,
            line.te_share,
            *(line.place_m or (None, None, None)),
            line.detail,
        )


def _db(coefficient: complex) -> float:
    return 20.0 * math.log10(abs(coefficient)) if coefficient else -math.inf


def _deg(coefficient: complex) -> float:
    return math.degrees(math.atan2(coefficient.imag, coefficient.real))
