"""Solution of the moment equations: one factorisation, or one small one per rotational mode."""

import math

import numpy as np
import numpy.typing as npt

from octant.em.reader.fullwave.basis import SurfaceBasis
from octant.geometries.errors import GeometryError


def solve_currents(
    basis: SurfaceBasis,
    matrix: npt.NDArray[np.complex128],
    excitation: npt.NDArray[np.complex128] | npt.NDArray[np.float64],
) -> npt.NDArray[np.complex128]:
    """Return the functions' factors for any number of excitations [A/m].

    Parameters
    ----------
    basis : Functions.
    matrix : (functions, sectors, functions) complex128 — What `impedance_matrix` returns [ohm m^2];
        overwritten when there is one sector.
    excitation : (k, sectors, functions) float64 or complex128 — Products of the functions with the
        impressed field [V m].

    Returns
    -------
    (k, sectors, functions) complex128
        Factors [A/m].

    Notes
    -----
    With M sectors the matrix is block-circulant: the discrete Fourier transform over sectors leaves
    M systems of one sector's size. Mode M - k has the transpose of mode k's matrix, so M/2 + 1 are
    factorised. Half-functions on the axis are free in all modes but that of order 0, where those
    of an edge must add up to nothing.
    """
    from scipy.linalg import lu_solve

    if basis.sectors == 1:
        # The matrix is symmetric: its transpose is the Fortran order that LAPACK wants.
        factors = _factorised(matrix[:, 0, :].T)
        single: npt.NDArray[np.complex128] = lu_solve(
            factors, excitation[:, 0, :].T, check_finite=False
        ).T[:, None, :]
        return single
    sectors = basis.sectors
    modes = np.arange(sectors)
    turns = np.exp(2j * math.pi * np.outer(modes, modes) / sectors)
    spectrum = np.einsum("ksm,qs->qkm", excitation, turns.conj(), optimize=True)
    result = np.empty_like(spectrum)
    for mode in range(sectors // 2 + 1):
        part = np.zeros((basis.functions, basis.functions), dtype=np.complex128, order="F")
        for d in range(sectors):
            part += turns[mode, d] * matrix[:, d, :]
        if mode == 0:
            free = _free_of_axis(basis)
            factors = _factorised(np.asfortranarray(free.T @ part @ free))
            reduced = lu_solve(factors, free.T @ spectrum[0].T, check_finite=False)
            result[0] = (free @ reduced).T
            continue
        factors = _factorised(part)
        result[mode] = lu_solve(factors, spectrum[mode].T, check_finite=False).T
        other = sectors - mode
        if other != mode:
            result[other] = lu_solve(factors, spectrum[other].T, trans=1, check_finite=False).T
    solution: npt.NDArray[np.complex128] = np.einsum(
        "qkm,qs->ksm", result, turns / sectors, optimize=True
    )
    return solution


def _free_of_axis(basis: SurfaceBasis) -> npt.NDArray[np.float64]:
    """Return (functions, free) the combinations whose flux into every edge on the axis vanishes."""
    dropped = np.array([group[0] for group in basis.axis_groups], dtype=np.int64)
    kept = np.setdiff1d(np.arange(basis.functions), dropped)
    free = np.zeros((basis.functions, len(kept)))
    free[kept, np.arange(len(kept))] = 1.0
    for group in basis.axis_groups:
        free[group[0], np.searchsorted(kept, group[1:])] = -1.0
    return free


def _factorised(
    matrix: npt.NDArray[np.complex128],
) -> tuple[npt.NDArray[np.complex128], npt.NDArray[np.int32]]:
    """Return the LU factors of a matrix in Fortran order, which is overwritten."""
    from scipy.linalg.lapack import zgetrf

    factors, pivots, info = zgetrf(matrix, overwrite_a=1)
    least = float(np.abs(np.diagonal(factors)).min()) if info == 0 else 0.0
    if info != 0 or not least > 1e-14 * float(np.abs(np.diagonal(factors)).max()):
        msg = (
            "the moment equations are singular; look for triangles that lie on each other, or for "
            "a closed surface at an interior resonance, and change the mesh or the frequency."
        )
        raise GeometryError(msg)
    return factors, pivots
