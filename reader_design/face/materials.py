"""What needs no study: the table of materials, and what is wrong with a mesh."""

import math
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from octant.em.constants import VACUUM_PERMITTIVITY_F_PER_M
from octant.em.medium.materials import material_table
from octant.geometries.audit import MeshAudit, audit_mesh
from octant.geometries.errors import MaterialRangeError, PhysicsWarning
from octant.reader_design.face.shown import text_html
from octant.reader_design.showing.netcdf import variable

if TYPE_CHECKING:
    import xarray as xr


def materials(*, frequency_hz: float = 2.4e9) -> "xr.Dataset":
    """Return the materials that a room can name: permittivity, conductivity [S/m], range [Hz].

    After ITU-R P.2040-4, a little beyond its range too; NaN where a study cannot use the model;
    infinite conductivity: a perfect conductor.

    Parameters
    ----------
    frequency_hz : Where they are evaluated [Hz].

    Examples
    --------
    >>> import octant
    >>> table = octant.materials(frequency_hz=2.4e9)
    >>> round(float(table["eps_r"].sel(material="concrete")), 2)
    5.24
    """
    import xarray as xr

    rows = []
    for entry in material_table():
        eps_r, sigma = math.nan, math.inf if entry.is_pec else math.nan
        if not entry.is_pec:
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", PhysicsWarning)  # the table shows the range
                    permittivity = entry.relative_permittivity(frequency_hz)
            except MaterialRangeError:
                pass
            else:
                omega = 2.0 * math.pi * frequency_hz
                eps_r = permittivity.real
                sigma = -permittivity.imag * omega * VACUUM_PERMITTIVITY_F_PER_M
        rows.append((eps_r, sigma, *entry.frequency_range_hz))
    names = [entry.name for entry in material_table()]
    columns = (
        ("eps_r", "1", "real part of the relative permittivity"),
        ("sigma", "S/m", "conductivity"),
        ("valid_from", "Hz", "lowest frequency"),
        ("valid_to", "Hz", "highest frequency"),
    )
    values = np.array(rows)
    return xr.Dataset(
        {
            name: variable(["material"], values[:, i], units=units, long_name=text)
            for i, (name, units, text) in enumerate(columns)
        },
        coords={"material": variable(["material"], names, units="1", long_name="material")},
        attrs={"frequency_hz": frequency_hz},
    )


class Audit:
    """What is wrong with a mesh file, and what it means for rays; ``found`` has the numbers."""

    __slots__ = ("found",)

    def __init__(self, found: MeshAudit) -> None:
        self.found = found

    def lines(self) -> list[str]:
        """Return the findings as sentences."""
        return self.found.lines()

    def __repr__(self) -> str:
        return "\n".join(self.lines())

    def _repr_html_(self) -> str:
        return text_html(repr(self))


def audit(
    mesh: str | Path, *, unit: str | None = None, up: Literal["y", "z", "auto"] | None = None
) -> Audit:
    """Return what is wrong with a mesh file, and what it means for rays.

    Parameters
    ----------
    mesh, unit : The file, in any format that `Room.load` reads; its length unit, if it is neither
        declared nor guessed right.
    up : Its vertical axis; by default that of the format, ``auto`` as it is guessed.

    Examples
    --------
    >>> import octant
    >>> report = octant.audit("tests/reference/peers/room.ply", unit="m")
    >>> report.found.faces
    12
    """
    return Audit(audit_mesh(mesh, unit=unit, up=up))
