"""Solution of the moment equations: one factorisation, or one small one per rotational mode."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.em.blocks import MOST_SHARE, memory_bytes
from octant.em.reader.fullwave.basis import SurfaceBasis
from octant.geometries.errors import GeometryError

SINGLE_FROM = 2000
"""Functions of a block from which it is factorised in single precision [-]."""

REFINED, MOST_REFINEMENTS = 1e-13, 12
"""Change over the greatest value at which a refined solution is left [-]; rounds at most."""


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

    Large blocks are factorised in single precision, and the solution is refined by residuals in
    double precision until it stands still, in half the time [1]_; where it does not, they are
    factorised in double precision after all.

    References
    ----------
    .. [1] N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed. (2002), chapter 12.
    """
    return _solved(basis, (_mode(basis, matrix, k) for k in _modes(basis)), excitation)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class KeptFactors:
    """The factorised matrix, for solutions one after the other.

    Parameters
    ----------
    basis : Functions.
    modes : Factors of each mode that has some of its own.
    """

    basis: SurfaceBasis
    modes: tuple["_Factors", ...]

    @classmethod
    def of(cls, basis: SurfaceBasis, matrix: npt.NDArray[np.complex128]) -> "KeptFactors":
        """Return the factors of a matrix [ohm m^2].

        Parameters
        ----------
        basis, matrix : As for `solve_currents` [ohm m^2].
        """
        return cls(basis=basis, modes=tuple(_mode(basis, matrix, k) for k in _modes(basis)))

    def solve(
        self, excitation: npt.NDArray[np.complex128] | npt.NDArray[np.float64]
    ) -> npt.NDArray[np.complex128]:
        """Return (k, sectors, functions) the functions' factors [A/m], as `solve_currents`.

        Parameters
        ----------
        excitation : (k, sectors, functions) float64 or complex128 — As there [V m].
        """
        return _solved(self.basis, self.modes, excitation)


def _modes(basis: SurfaceBasis) -> range:
    """Return the modes that are factorised; the others have a transposed matrix of one of them."""
    return range(basis.sectors // 2 + 1) if basis.sectors > 1 else range(1)


def _turns(sectors: int) -> npt.NDArray[np.complex128]:
    """Return (sectors, sectors) the factors exp(2 pi j k s / sectors) [-]."""
    modes = np.arange(sectors)
    turns: npt.NDArray[np.complex128] = np.exp(2j * math.pi * np.outer(modes, modes) / sectors)
    return turns


def _mode(basis: SurfaceBasis, matrix: npt.NDArray[np.complex128], mode: int) -> "_Factors":
    """Return the factors of one rotational mode, or of the whole matrix of one sector."""
    if basis.sectors == 1:
        # The matrix is symmetric: its transpose is the Fortran order that LAPACK wants.
        return _factors(matrix[:, 0, :].T)
    part: npt.NDArray[np.complex128] = _turns(basis.sectors)[mode] @ matrix
    if mode:
        return _factors(np.asfortranarray(part))
    kept, dropped = _free_of_axis(basis)
    rows = _without_dropped(part, kept, dropped)
    return _factors(np.asfortranarray(_without_dropped(rows.T, kept, dropped).T))


def _solved(
    basis: SurfaceBasis,
    modes: Iterable["_Factors"],
    excitation: npt.NDArray[np.complex128] | npt.NDArray[np.float64],
) -> npt.NDArray[np.complex128]:
    """Return the functions' factors [A/m] by the factors of the modes, each used once in order."""
    sectors = basis.sectors
    if sectors == 1:
        (whole,) = modes
        return whole.solve(excitation[:, 0, :].T).T[:, None, :]
    turns = _turns(sectors)
    spectrum = np.einsum("ksm,qs->qkm", excitation, turns.conj(), optimize=True)
    result = np.empty_like(spectrum)
    for mode, factors in enumerate(modes):
        if mode == 0:
            kept, dropped = _free_of_axis(basis)
            result[0, :, kept] = factors.solve(_without_dropped(spectrum[0].T, kept, dropped))
            for group in basis.axis_groups:
                result[0, :, group[0]] = -result[0][:, group[1:]].sum(axis=1)
            continue
        result[mode] = factors.solve(spectrum[mode].T).T
        other = sectors - mode
        if other != mode:
            result[other] = factors.solve(spectrum[other].T, transposed=True).T
    solution: npt.NDArray[np.complex128] = np.einsum(
        "qkm,qs->ksm", result, turns / sectors, optimize=True
    )
    return solution


def _free_of_axis(
    basis: SurfaceBasis,
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the functions kept where the flux into every edge on the axis vanishes.

    And for each the one that takes its flux back, -1 for those off the axis.
    """
    back = np.full(basis.functions, -1, dtype=np.int64)
    for group in basis.axis_groups:
        back[group[1:]] = group[0]
    dropped = np.array([group[0] for group in basis.axis_groups], dtype=np.int64)
    kept = np.setdiff1d(np.arange(basis.functions), dropped)
    return kept, back[kept]


def _without_dropped(
    rows: npt.NDArray[np.complex128],
    kept: npt.NDArray[np.int64],
    dropped: npt.NDArray[np.int64],
) -> npt.NDArray[np.complex128]:
    """Return the rows of the kept functions, less those of the functions that take flux back."""
    result = rows[kept]
    on_axis = np.flatnonzero(dropped >= 0)
    result[on_axis] -= rows[dropped[on_axis]]
    return result


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Factors:
    """LU factors of a matrix, or those of its single-precision copy beside the matrix itself."""

    factors: npt.NDArray[np.complex128] | npt.NDArray[np.complex64]
    pivots: npt.NDArray[np.int32]
    matrix: npt.NDArray[np.complex128] | None = None

    def solve(
        self, right: npt.NDArray[Any], *, transposed: bool = False
    ) -> npt.NDArray[np.complex128]:
        """Return the (n, k) solutions of A x = right, or of those of the transposed matrix."""
        from scipy.linalg import lu_solve

        factors, trans = (self.factors, self.pivots), int(transposed)
        if self.matrix is None:
            plain: npt.NDArray[np.complex128] = lu_solve(
                factors, right, trans=trans, check_finite=False
            )
            return plain
        matrix = self.matrix.T if transposed else self.matrix
        found = np.zeros(right.shape, dtype=np.complex128)
        rest, before = right.astype(np.complex128), math.inf
        tiny = np.finfo(np.float64).tiny
        for _ in range(MOST_REFINEMENTS):
            size = np.maximum(np.abs(rest).max(axis=0), tiny)
            step = lu_solve(
                factors, (rest / size).astype(np.complex64), trans=trans, check_finite=False
            )
            found += step * size
            change = np.abs(step).max(axis=0) * size
            moved = float((change / np.maximum(np.abs(found).max(axis=0), tiny)).max())
            if moved <= REFINED:
                return found
            if not moved < 0.5 * before:
                break
            before = moved
            rest = right - matrix @ found
        again = _factorised(self.matrix.copy(order="F"))
        return again.solve(right, transposed=transposed)


def _factors(matrix: npt.NDArray[np.complex128]) -> _Factors:
    """Return the factors of a matrix in Fortran order, which is overwritten where it is small."""
    from scipy.linalg.lapack import cgetrf

    room = 1.5 * matrix.nbytes <= MOST_SHARE * memory_bytes()
    if len(matrix) < SINGLE_FROM or not room:
        return _factorised(matrix)
    factors, pivots, info = cgetrf(matrix.astype(np.complex64, order="F"), overwrite_a=1)
    if info != 0 or not np.isfinite(factors).all():
        return _factorised(matrix)
    return _Factors(factors=factors, pivots=pivots, matrix=matrix)


def _factorised(matrix: npt.NDArray[np.complex128]) -> _Factors:
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
    return _Factors(factors=factors, pivots=pivots)
