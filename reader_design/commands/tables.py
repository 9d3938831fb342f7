"""``octant materials`` and ``octant audit``: tables that need no study."""

import math
from pathlib import Path
from typing import Annotated, Literal

import click
from msgspec import Meta

from octant.reader_design.options import number

HERTZ_PER_GIGAHERTZ = 1e9


@click.command()
@click.option(
    "--frequency-ghz",
    type=number(Annotated[float, Meta(ge=1e-3, le=1e3)]),
    default=2.4,
    show_default=True,
    help="Where permittivity and conductivity are evaluated [GHz].",
)
def materials(frequency_ghz: float) -> None:
    """List the materials that a study can name, at one frequency.

    Permittivity and conductivity follow ITU-R P.2040-4. Outside the range that a model was fitted
    to, up to a factor of 2.5 and floorboard down to 0.4 GHz, it is extrapolated; a dash stands
    where a study cannot use it.
    """
    from octant.reader_design.face.materials import materials as table

    data = table(frequency_hz=frequency_ghz * HERTZ_PER_GIGAHERTZ)
    columns = ("eps_r", "sigma", "valid_from", "valid_to")
    click.echo(f"{'material':<20}{'eps_r':>10}{'sigma [S/m]':>14}  valid [GHz]")
    for name, *numbers in zip(
        data["material"].to_numpy(), *(data[c].to_numpy() for c in columns), strict=True
    ):
        eps_r, sigma, low, high = (float(n) for n in numbers)
        shown = "-" if math.isnan(eps_r) else f"{eps_r:.4g}"
        conducts = "-" if math.isnan(sigma) else f"{sigma:.4g}"
        valid = f"{low / 1e9:g} to {high / 1e9:g}" if math.isfinite(high) else "any"
        if math.isfinite(eps_r) and not low <= data.attrs["frequency_hz"] <= high:
            valid += " (extrapolated)"
        conducts = "infinite" if math.isinf(sigma) else conducts
        click.echo(f"{name:<20}{shown:>10}{conducts:>14}  {valid}")


@click.command()
@click.argument("mesh", type=click.Path(path_type=Path))
@click.option("--unit", help="Length unit of the file (m, cm, mm, in ...), if it declares none.")
@click.option(
    "--up",
    type=click.Choice(["y", "z", "auto"]),
    help="Vertical axis of the file; by default that of its format, auto as it is guessed.",
)
def audit(mesh: Path, unit: str | None, up: Literal["y", "z", "auto"] | None) -> None:
    """Say what is wrong with a MESH file, and what it means for rays.

    Also the bodies, how many flat faces they make in the scene, and which unit and vertical axis
    the file seems to have, with the reason.
    """
    from octant.reader_design.face.materials import audit as audited

    for line in audited(mesh, unit=unit, up=up).lines():
        click.echo(line)
