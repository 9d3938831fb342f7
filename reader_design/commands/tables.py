"""``octant materials`` and ``octant audit``: tables that need no study."""

import math
from dataclasses import asdict, fields
from pathlib import Path
from typing import Annotated, Literal

import click
from msgspec import Meta

from octant.geometries.errors import ConfigError
from octant.reader_design.options import json_option, number, quiet_option
from octant.reader_design.terminal.completion import MESH_FILES, files
from octant.reader_design.terminal.completion import materials as completed_materials

HERTZ_PER_GIGAHERTZ = 1e9


@click.command()
@click.argument("names", metavar="[MATERIAL]...", nargs=-1, shell_complete=completed_materials)
@click.option(
    "--frequency-ghz",
    type=number(Annotated[float, Meta(ge=1e-3, le=1e3)]),
    metavar="GHZ",
    default=2.4,
    show_default=True,
    help="Where permittivity and conductivity are evaluated [GHz].",
)
@json_option
@quiet_option
def materials(*, names: tuple[str, ...], frequency_ghz: float, as_json: bool, quiet: bool) -> None:
    """List the materials that a study can name, or those given, at one frequency.

    Permittivity and conductivity follow ITU-R P.2040-4. Outside the range that a model was fitted
    to, up to a factor of 2.5 and floorboard down to 0.4 GHz, it is extrapolated; a dash stands
    where a study cannot use it.
    """
    from octant.em.medium.materials import material
    from octant.reader_design.face.materials import materials as table
    from octant.reader_design.study_file.errors import unknown_name
    from octant.reader_design.terminal.documents import json_text, rows_of

    del quiet  # it says nothing besides its table
    data = table(frequency_hz=frequency_ghz * HERTZ_PER_GIGAHERTZ)
    known = data["material"].to_numpy().tolist()
    for name in names:
        if name not in known:
            material(name)  # refuses a word that is none, with the material that is meant
            raise ConfigError(unknown_name("MATERIAL", name, known, what="material"))
    if names:
        data = data.sel(material=list(dict.fromkeys(names)))
    columns = ("eps_r", "sigma", "valid_from", "valid_to")
    if as_json:
        keys = ("material", "eps_r", "sigma_s_per_m", "valid_from_hz", "valid_to_hz")
        cells = [data[name].to_numpy().tolist() for name in ("material", *columns)]
        document = {
            "verb": "materials",
            "frequency_hz": data.attrs["frequency_hz"],
            "materials": rows_of(keys, list(zip(*cells, strict=True))),
        }
        click.echo(json_text(document))
        return
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
@click.argument("mesh", type=click.Path(path_type=Path), shell_complete=files(*MESH_FILES))
@click.option(
    "--unit",
    metavar="UNIT",
    help="Length unit of the file (m, cm, mm, in ...), if it declares none.",
)
@click.option(
    "--up",
    type=click.Choice(["y", "z", "auto"]),
    help="Vertical axis of the file; by default that of its format, auto as it is guessed.",
)
@json_option
@quiet_option
def audit(
    *,
    mesh: Path,
    unit: str | None,
    up: Literal["y", "z", "auto"] | None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Say what is wrong with a MESH file, and what it means for rays.

    Also the bodies, how many flat faces they make in the scene, and which unit and vertical axis
    the file seems to have, with the reason.
    """
    from octant.reader_design.face.materials import audit as audited
    from octant.reader_design.terminal.documents import json_text

    del quiet  # it says nothing besides its findings
    found = audited(mesh, unit=unit, up=up)
    if as_json:
        numbers = {field.name: getattr(found.found, field.name) for field in fields(found.found)}
        findings = [asdict(finding) for finding in found.found.findings]
        click.echo(json_text({"verb": "audit", **numbers, "findings": findings}))
        return
    for line in found.lines():
        click.echo(line)
