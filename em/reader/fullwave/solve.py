"""The full-wave solution of a meshed reader."""

import math
import time
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave._circuit import lost_shares, radiated_shares, scattering
from octant.em.reader.fullwave._symmetry import turns_of
from octant.em.reader.fullwave.basis import SurfaceBasis, best_sectors, surface_basis
from octant.em.reader.fullwave.far_field import current_samples
from octant.em.reader.fullwave.linear_solve import solve_currents
from octant.em.reader.fullwave.mesh import ReaderMesh
from octant.em.reader.fullwave.ports import feed_excitation
from octant.em.reader.fullwave.result import FullwaveResult
from octant.em.reader.fullwave.rwg import impedance_matrix
from octant.geometries.errors import AntennaError, GeometryError

BALANCE_LIMIT = 1e-3
"""Radiated and lost power less accepted power, over the latter [-], above which a run warns."""


MOST_GIB = 8.0
"""Greatest size of the moment matrix [GiB]."""

STEPS = ("functions", "assembly", "solution", "power balance")
"""Steps of a run whose times are kept [-]."""


def solve_reader(
    mesh: ReaderMesh,
    *,
    frequency_hz: float | None = None,
    load_ohm: npt.ArrayLike = 50.0,
    surface_impedance_ohm: npt.ArrayLike = 0.0,
    symmetry: bool = True,
) -> FullwaveResult:
    """Return the full-wave solution of a meshed reader.

    Parameters
    ----------
    mesh : Triangles and feeds.
    frequency_hz : Frequency [Hz]; None takes the one that the mesh was made for.
    load_ohm : Impedance of source and load of every port [ohm], its resistance above 0.
    surface_impedance_ohm : Surface impedance of each triangle [ohm], in the order of
        ``mesh.faces``.
    symmetry : Use the rotational symmetry that the mesh has.
    """
    frequency = mesh.frequency_hz if frequency_hz is None else frequency_hz
    load = np.broadcast_to(np.asarray(load_ohm, dtype=np.complex128), (mesh.antennas,))
    if not (np.isfinite(load).all() and (load.real > 0.0).all()):
        msg = f"load_ohm is {load_ohm!r} ohm, but every load must have a resistance above 0 ohm."
        raise AntennaError(msg)
    clock = [time.perf_counter()]
    sheet = np.zeros(len(mesh.faces), dtype=np.complex128) + np.asarray(surface_impedance_ohm)
    sectors = 1
    if symmetry and len(np.unique(sheet)) == 1:
        sectors = best_sectors(mesh.vertices_m, mesh.faces, turns_of(mesh.antennas))
    basis = surface_basis(mesh.vertices_m, mesh.faces, sectors=sectors)
    sheet = sheet[basis.given_face]
    _refuse_too_large(basis, mesh)
    excitation = _excitations(basis, mesh)
    clock.append(time.perf_counter())
    matrix = impedance_matrix(basis, frequency_hz=frequency, surface_impedance_ohm=sheet)
    clock.append(time.perf_counter())
    currents = solve_currents(basis, matrix, excitation)
    del matrix
    clock.append(time.perf_counter())
    admittance = np.einsum("ism,jsm->ij", excitation, currents, optimize=True)
    halves = basis.half_coefficients(currents)
    samples = current_samples(basis, halves, frequency_hz=frequency)
    step = _port_step(excitation)
    s_matrix_power = np.abs(scattering(admittance, load)) ** 2
    radiated = radiated_shares(samples, admittance, load, sectors=sectors, port_step=step)
    lost = lost_shares(basis, halves, sheet, admittance, load)
    clock.append(time.perf_counter())
    result = FullwaveResult(
        frequency_hz=frequency,
        load_ohm=load,
        admittance_s=admittance,
        samples=samples,
        halves_a_per_m=halves,
        basis=basis,
        sheet_ohm=sheet,
        radiated_share=radiated,
        accepted_share=1.0 - s_matrix_power.sum(axis=0),
        lost_share=lost,
        port_step=step,
        seconds=dict(zip(STEPS, np.diff(clock).tolist(), strict=True)),
        warnings=mesh.warnings,
    )
    if result.balance_error <= BALANCE_LIMIT:
        return result
    doubt = (
        f"radiated and accepted power differ by {100.0 * result.balance_error:.2g} %, more than "
        f"{100.0 * BALANCE_LIMIT:g} %: the mesh is too coarse somewhere"
    )
    return replace(result, warnings=(*result.warnings, doubt))


def _refuse_too_large(basis: SurfaceBasis, mesh: ReaderMesh) -> None:
    """Raise before a matrix is made that no workstation holds; say what makes it large."""
    size_gib = 16.0 * basis.functions**2 * basis.sectors / 2**30
    if size_gib <= MOST_GIB:
        return
    cells = SPEED_OF_LIGHT_M_PER_S / mesh.frequency_hz / mesh.coarse_m
    beside = mesh.beside[basis.given_face]
    area, whole = basis.areas_m2, f"{basis.unknowns} unknowns"
    advice = [f"take fewer cells_per_wavelength than {cells:g}"]
    if beside.any():
        # A closed mesh has three functions for every two triangles.
        whole += f", about {1.5 * beside.sum():.0f} of them on the metal beside the reader"
        advice.append("give less of that metal, as what is far from the reader matters little")
        used, own = np.unique(mesh.faces[~mesh.beside], return_inverse=True)
        own = own.reshape(-1, 3)
        alone = best_sectors(mesh.vertices_m[used], own, turns_of(mesh.antennas))
        if alone > basis.sectors:
            advice.append(
                "put its middle on the reader's axis, where rotations that it shares with the "
                "reader make the matrix smaller"
            )
    elif len(area) > 2.0 * area.sum() / (math.sqrt(0.1875) * mesh.coarse_m**2):
        advice.append("keep the antennas farther from the sheets, where the mesh is finer")
    else:
        advice.append("give smaller sheets")
    msg = (
        f"the mesh has {whole}, and its matrix takes {size_gib:.1f} GiB, but at most "
        f"{MOST_GIB:g} GiB is allowed; {', or '.join(advice)}."
    )
    raise GeometryError(msg)


def _excitations(basis: SurfaceBasis, mesh: ReaderMesh) -> npt.NDArray[np.float64]:
    """Return (n, sectors, functions) products of the functions with one volt at each feed [V m]."""
    owner = mesh.antenna_of_face[basis.given_face]
    halves = [
        feed_excitation(basis, np.flatnonzero(owner == strip), bottom, top)
        for strip, bottom, top in zip(
            mesh.strip_of_feed, mesh.feed_bottom_m, mesh.feed_top_m, strict=True
        )
    ]
    return basis.gathered(np.array(halves))


def _port_step(excitation: npt.NDArray[np.float64]) -> int:
    """Return the ports that a turn by one sector moves on, 0 when ports do not map to ports."""
    ports, sectors, _ = excitation.shape
    if sectors == 1 or ports % sectors:
        return 0
    step = ports // sectors
    turned = np.roll(np.roll(excitation, step, axis=0), -1, axis=1)
    same = np.allclose(turned, excitation, rtol=0.0, atol=1e-9 * float(np.abs(excitation).max()))
    return step if same else 0
