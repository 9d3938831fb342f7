"""The impedance matrix of Rao-Wilton-Glisson functions."""

import math

import numpy as np
import numpy.typing as npt

from octant.em.blocks import run_blocks
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave import _near_kernels, _rwg_kernels
from octant.em.reader.fullwave._rwg_kernels import FunctionArrays
from octant.em.reader.fullwave.basis import SurfaceBasis
from octant.geometries._checks import positive_number

VACUUM_PERMEABILITY = 4e-7 * math.pi
"""Permeability of vacuum [H/m]."""

VACUUM_IMPEDANCE_OHM = VACUUM_PERMEABILITY * SPEED_OF_LIGHT_M_PER_S
"""Wave impedance of vacuum [ohm]."""

NEAR = 1.5
"""Distance of centroids over the sum of both radii [-] below which 1/R is integrated exactly."""

CLOSE = 1.001
"""The same [-] below which the rule for triangles that touch is taken; those that do are never
farther apart than 1."""

MID = 8.0
"""The same [-] below which seven points are taken instead of three: it keeps the power balance of
antennas deep between plates, which radiate a thousandth of what they store."""

ROWS_PER_BLOCK = 16
"""Triangles that a thread takes at a time [-]."""

TILE = 32
"""Side of the tiles in which the matrix is mirrored [entries, -]."""


def _colours(basis: SurfaceBasis) -> list[npt.NDArray[np.int64]]:
    """Return the first sector's triangles in groups that share no function [-]."""
    count = basis.triangles_per_sector
    members: list[list[int]] = [[] for _ in range(basis.functions)]
    own: list[list[int]] = [[] for _ in range(count)]
    for t in range(count):
        for m in basis.function[basis.start[t] : basis.start[t + 1]].tolist():
            members[m].append(t)
            own[t].append(m)
    colour = [-1] * count
    for t in range(count):
        taken = {colour[other] for m in own[t] for other in members[m]}
        colour[t] = next(c for c in range(count + 1) if c not in taken)
    array = np.array(colour)
    return [np.flatnonzero(array == c) for c in range(array.max() + 1)]


def impedance_matrix(
    basis: SurfaceBasis,
    *,
    frequency_hz: float,
    surface_impedance_ohm: npt.ArrayLike = 0.0,
    near: float = NEAR,
    mid: float = MID,
    close: float = CLOSE,
    drawn: SurfaceBasis | None = None,
    changed_only: bool = False,
) -> npt.NDArray[np.complex128]:
    """Return the matrix of the electric-field integral equation [ohm m^2].

    Parameters
    ----------
    basis : Functions.
    frequency_hz : Frequency [Hz].
    surface_impedance_ohm : Tangential field over sheet current of every triangle [ohm]; 0 is a
        perfect conductor.
    near : Distance of centroids over the sum of radii [-] below which 1/R is integrated exactly.
    mid : The same [-] below which seven points are taken instead of three.
    close : The same [-] below which 48 points that gather towards the edges are taken.
    drawn : The functions that these were moved from, whose distances decide how pairs are
        integrated, so that the matrix is a smooth function of the move; None: distances here.
    changed_only : Leave out what the move from ``drawn`` does not change.

    Returns
    -------
    (functions, sectors, functions) complex128
        Entry (m, d, n): function m of the first sector tested by function n of sector d. It holds
        the same sum, bit for bit, whatever the number of threads.

    Notes
    -----
    Z = j w mu <f, A> + <div f, div-potential> / (j w eps) with exp(-jkR) / (4 pi R); functions test
    themselves (Galerkin). Near pairs take the closed forms of [2]_ over one triangle, and the mean
    of both orders. What remains over the other has t log t at a distance t from an edge that both
    share: 48 points leave 1e-4 of a triangle's interaction with itself or a neighbour, where seven
    leave 5e-3. A closed surface has no solution at its interior resonances.

    References
    ----------
    .. [1] S. M. Rao, D. R. Wilton, A. W. Glisson, IEEE Trans. Antennas Propag. 30 (1982) 409,
       equations 10, 17-19.
    .. [2] D. R. Wilton et al., IEEE Trans. Antennas Propag. 32 (1984) 276, equations 5 and 6;
       R. D. Graglia, ibid. 41 (1993) 1448.
    """
    frequency = positive_number(frequency_hz, name="frequency_hz", unit="Hz")
    omega = 2.0 * math.pi * frequency
    wavenumber = omega / SPEED_OF_LIGHT_M_PER_S
    triangles = basis.triangle_arrays(drawn, changed_only=changed_only)
    functions = FunctionArrays(basis.start, basis.function, basis.turn, basis.local, basis.sign)
    sheet = np.zeros(len(basis.faces), dtype=np.complex128) + np.asarray(surface_impedance_ohm)
    counts = np.zeros(basis.triangles_per_sector, dtype=np.int64)
    _near_kernels.near_counts(triangles, near, counts)
    near_start = np.concatenate(([0], np.cumsum(counts)))
    near_list = np.empty(near_start[-1], dtype=np.int64)
    _near_kernels.near_lists(triangles, near, near_start, near_list)
    vector = 1j * omega * VACUUM_PERMEABILITY / (16.0 * math.pi)
    scalar = VACUUM_IMPEDANCE_OHM / (4j * math.pi * wavenumber)
    size = basis.functions
    z = np.zeros((size, basis.sectors, size), dtype=np.complex128)
    for rows in _colours(basis):

        def work(begin: int, end: int, rows: npt.NDArray[np.int64] = rows) -> None:
            _rwg_kernels.add_far(
                triangles, functions, rows, begin, end, wavenumber, near, mid, vector, scalar, z
            )
            _near_kernels.add_near(
                triangles,
                functions,
                rows,
                begin,
                end,
                near_start,
                near_list,
                wavenumber,
                close,
                vector,
                scalar,
                sheet,
                z,
            )

        run_blocks(work, len(rows), block_size=ROWS_PER_BLOCK)

    def mirror(begin: int, end: int) -> None:
        _rwg_kernels.add_mirror(z, TILE, begin, end)

    run_blocks(mirror, -(-size // TILE), block_size=2)
    return z
