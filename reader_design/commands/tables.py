"""``octant materials`` and ``octant audit``: tables that need no study."""

import math
from pathlib import Path

import click

from octant.em.constants import VACUUM_PERMITTIVITY_F_PER_M
from octant.geometries.errors import ConfigError, MaterialRangeError

HERTZ_PER_GIGAHERTZ = 1e9


@click.command()
@click.option(
    "--frequency-ghz",
    type=float,
    default=2.4,
    show_default=True,
    help="Where permittivity and conductivity are evaluated [GHz].",
)
def materials(frequency_ghz: float) -> None:
    """List the materials that a study can name, at one frequency.

    Permittivity and conductivity follow ITU-R P.2040-4; a dash stands where the recommendation
    gives no value at this frequency.
    """
    from octant.em.medium.materials import material_table

    if not (math.isfinite(frequency_ghz) and frequency_ghz > 0.0):
        msg = f"--frequency-ghz is {frequency_ghz:g} GHz, but a finite positive number is needed."
        raise ConfigError(msg)
    frequency_hz = frequency_ghz * HERTZ_PER_GIGAHERTZ
    click.echo(f"{'material':<20}{'eps_r':>10}{'sigma [S/m]':>14}  valid [GHz]")
    for entry in material_table():
        low, high = (bound / HERTZ_PER_GIGAHERTZ for bound in entry.frequency_range_hz)
        valid = f"{low:g} to {high:g}" if math.isfinite(high) else "any"
        if entry.is_pec:
            eps_r, sigma = "-", "infinite"
        else:
            try:
                permittivity = entry.relative_permittivity(frequency_hz)
            except MaterialRangeError:
                eps_r, sigma = "-", "-"
            else:
                omega = 2.0 * math.pi * frequency_hz
                eps_r = f"{permittivity.real:.4g}"
                sigma = f"{-permittivity.imag * omega * VACUUM_PERMITTIVITY_F_PER_M:.4g}"
        click.echo(f"{entry.name:<20}{eps_r:>10}{sigma:>14}  {valid}")


@click.command()
@click.argument("mesh", type=click.Path(path_type=Path))
@click.option("--unit", help="Length unit of the file (m, cm, mm, in ...), if it declares none.")
def audit(mesh: Path, unit: str | None) -> None:
    """Say what is wrong with a MESH file, and what it means for rays."""
    from octant.geometries.audit import audit_mesh

    for line in audit_mesh(mesh, unit=unit).lines():
        click.echo(line)
