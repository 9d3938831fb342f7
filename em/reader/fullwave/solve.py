"""The full-wave solution of a meshed reader."""

import math
import time
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from octant.em.blocks import MOST_SHARE, memory_bytes, one_blas_thread
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave._circuit import heat_matrix
from octant.em.reader.fullwave._symmetry import turns_of
from octant.em.reader.fullwave.basis import SurfaceBasis, best_basis, best_sectors
from octant.em.reader.fullwave.far_field import band_limited, current_samples
from octant.em.reader.fullwave.linear_solve import solve_currents
from octant.em.reader.fullwave.loads import UnloadedReader, checked_loads
from octant.em.reader.fullwave.mesh import BESIDE, ReaderMesh
from octant.em.reader.fullwave.ported import PortedMesh
from octant.em.reader.fullwave.ports import feed_excitation
from octant.em.reader.fullwave.result import FullwaveResult
from octant.em.reader.fullwave.rwg import impedance_matrix
from octant.geometries.errors import GeometryError

MOST_GIB = 8.0
"""Greatest size of the moment matrix [GiB], on any machine."""

STEPS = ("functions", "assembly", "solution", "far field")
"""Steps of a run whose times are kept [-]."""


@one_blas_thread()
def solve_reader(
    mesh: ReaderMesh | PortedMesh,
    *,
    frequency_hz: float | None = None,
    load_ohm: npt.ArrayLike = 50.0,
    surface_impedance_ohm: npt.ArrayLike | None = None,
    symmetry: bool = True,
) -> FullwaveResult:
    """Return the full-wave solution of a meshed reader.

    Parameters
    ----------
    mesh : Triangles and feeds, of a reader or of any metal.
    frequency_hz : Frequency [Hz]; None takes the one that the mesh was made for.
    load_ohm : Impedance of source and load of every port [ohm], its resistance above 0.
    surface_impedance_ohm : Surface impedance of each triangle [ohm], in the order of
        ``mesh.faces``; None: that of the mesh's conductor.
    symmetry : Use the rotational symmetry that the mesh has.
    """
    frequency = mesh.frequency_hz if frequency_hz is None else frequency_hz
    load = checked_loads(load_ohm, mesh.antennas)
    clock = [time.perf_counter()]
    sheet = mesh.surface_impedance_ohm(frequency)
    if surface_impedance_ohm is not None:
        sheet = np.zeros_like(sheet) + np.asarray(surface_impedance_ohm)
    basis, sheet = basis_with(mesh, sheet, symmetry=symmetry)
    refuse_too_large(basis, mesh)
    excitation = excitations(basis, mesh)
    clock.append(time.perf_counter())
    matrix = impedance_matrix(basis, frequency_hz=frequency, surface_impedance_ohm=sheet)
    clock.append(time.perf_counter())
    currents = solve_currents(basis, matrix, excitation)
    half = isinstance(mesh, PortedMesh) and mesh.ground
    del matrix
    clock.append(time.perf_counter())
    result = result_of(
        basis,
        basis.half_coefficients(currents),
        (0.5 if half else 1.0) * np.einsum("ism,jsm->ij", excitation, currents, optimize=True),
        half_space=half,
        frequency_hz=frequency,
        load_ohm=load,
        sheet_ohm=sheet,
        port_step=port_step_of(excitation),
        phase_centres_m=mesh.phase_centres_m,
        doubts=mesh.warnings,
    )
    clock.append(time.perf_counter())
    return replace(result, seconds=dict(zip(STEPS, np.diff(clock).tolist(), strict=True)))


def basis_with(
    mesh: ReaderMesh | PortedMesh, sheet_ohm: npt.NDArray[np.complex128], *, symmetry: bool = True
) -> tuple[SurfaceBasis, npt.NDArray[np.complex128]]:
    """Return the functions of a mesh, and the surface impedance of their triangles [ohm].

    They have the rotations that both the mesh and its surface impedances have.

    Parameters
    ----------
    mesh, symmetry : As for `solve_reader`.
    sheet_ohm : (f,) complex128 — Surface impedances in the order of ``mesh.faces`` [ohm].
    """
    turns = turns_of(mesh.antennas) if symmetry else ()
    basis = best_basis(mesh.vertices_m, mesh.faces, turns)
    sectors = sheet_ohm[basis.given_face].reshape(basis.sectors, -1)
    if not (sectors == sectors[0]).all():
        basis = best_basis(mesh.vertices_m, mesh.faces, ())
    return basis, sheet_ohm[basis.given_face]


def result_of(
    basis: SurfaceBasis,
    halves_a_per_m: npt.NDArray[np.complex128],
    admittance_s: npt.NDArray[np.complex128],
    *,
    frequency_hz: float,
    load_ohm: npt.NDArray[np.complex128],
    sheet_ohm: npt.NDArray[np.complex128],
    port_step: int,
    phase_centres_m: npt.NDArray[np.float64],
    doubts: tuple[str, ...],
    half_space: bool = False,
) -> FullwaveResult:
    """Return the result of currents: their far field, and the loads put on.

    Parameters
    ----------
    basis : Functions.
    halves_a_per_m, admittance_s, sheet_ohm, port_step : As in `FullwaveResult`.
    frequency_hz, phase_centres_m, doubts : As in `UnloadedReader`.
    load_ohm : Impedance of source and load of every port [ohm].
    half_space : The currents are those of metal over a plane and of its image, whose fields count
        above the plane only.
    """
    samples = current_samples(basis, halves_a_per_m, frequency_hz=frequency_hz)
    return FullwaveResult(
        unloaded=UnloadedReader(
            frequency_hz=frequency_hz,
            admittance_s=admittance_s,
            heat_s=(0.5 if half_space else 1.0) * heat_matrix(basis, halves_a_per_m, sheet_ohm),
            shorted_v=band_limited(samples, sectors=basis.sectors, port_step=port_step),
            phase_centres_m=phase_centres_m,
            unknowns=basis.unknowns,
            doubts=doubts,
            half_space=half_space,
        ),
        load_ohm=load_ohm,
        samples=samples,
        halves_a_per_m=halves_a_per_m,
        basis=basis,
        sheet_ohm=sheet_ohm,
        port_step=port_step,
    )


def refuse_too_large(basis: SurfaceBasis, mesh: ReaderMesh | PortedMesh) -> None:
    """Raise before a matrix is made that no workstation holds; say what makes it large.

    Parameters
    ----------
    basis, mesh : Functions of a mesh.
    """
    size_gib = 16.0 * basis.functions**2 * basis.sectors / 2**30
    limit_gib = min(MOST_GIB, MOST_SHARE * memory_bytes() / 2**30)
    if size_gib <= limit_gib:
        return
    cells = SPEED_OF_LIGHT_M_PER_S / mesh.frequency_hz / mesh.coarse_m
    beside = mesh.antenna_of_face == BESIDE
    area, whole = basis.areas_m2, f"{basis.unknowns} unknowns"
    advice = [f"take fewer cells_per_wavelength than {cells:g}"]
    if beside.any():
        # A closed mesh has three functions for every two triangles.
        whole += f", about {1.5 * beside.sum():.0f} of them on the metal beside the reader"
        advice.append("give less of that metal, as what is far from the reader matters little")
        used, own = np.unique(mesh.faces[~beside], return_inverse=True)
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
        f"{limit_gib:.3g} GiB is allowed here; {', or '.join(advice)}."
    )
    raise GeometryError(msg)


def excitations(basis: SurfaceBasis, mesh: ReaderMesh | PortedMesh) -> npt.NDArray[np.float64]:
    """Return (n, sectors, functions) products of the functions with one volt at each feed [V m].

    Parameters
    ----------
    basis, mesh : Functions of a mesh, and its feeds.
    """
    if isinstance(mesh, PortedMesh):
        return basis.gathered(mesh.half_excitations(basis))
    owner = mesh.antenna_of_face[basis.given_face]
    halves = [
        feed_excitation(basis, np.flatnonzero(owner == strip), bottom, top)
        for strip, bottom, top in zip(
            mesh.strip_of_feed, mesh.feed_bottom_m, mesh.feed_top_m, strict=True
        )
    ]
    return basis.gathered(np.array(halves))


def port_step_of(excitation: npt.NDArray[np.float64]) -> int:
    """Return the ports that a turn by one sector moves on, 0 when ports do not map to ports [-].

    Parameters
    ----------
    excitation : What `excitations` returns [V m].
    """
    ports, sectors, _ = excitation.shape
    if sectors == 1 or ports % sectors:
        return 0
    step = ports // sectors
    turned = np.roll(np.roll(excitation, step, axis=0), 1, axis=1)
    same = np.allclose(turned, excitation, rtol=0.0, atol=1e-9 * float(np.abs(excitation).max()))
    return step if same else 0
