"""Derivatives of a solution with respect to what moves its mesh, from the factorised matrix.

A parameter moves the corners of a mesh of fixed triangles. With Z x = e for the volt at each port,
dx = Z^-1 (de - dZ x) needs no new factors, and the admittances Y = e.x change by
dY = de.x + x.de - x.dZ x, as Z is its own transpose. dZ and de are central differences over a
thousandth of the thinnest strip: of the fill alone, and only of pairs that do not move alike.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.em.blocks import one_blas_thread
from octant.em.reader.fullwave._circuit import heat_matrix
from octant.em.reader.fullwave.basis import SurfaceBasis
from octant.em.reader.fullwave.far_field import FarField, band_limited, current_samples, order_of
from octant.em.reader.fullwave.linear_solve import KeptFactors
from octant.em.reader.fullwave.loads import UnloadedReader
from octant.em.reader.fullwave.mesh import ReaderMesh
from octant.em.reader.fullwave.rwg import impedance_matrix
from octant.em.reader.fullwave.solve import (
    basis_with,
    excitations,
    port_step_of,
    refuse_too_large,
)
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import GeometryError

ComplexArray = npt.NDArray[np.complex128]

STEP_M = 1e-6
"""Half of the difference over which parameters that are lengths are moved [m]: what is left of
third order is 1e-7 of a derivative, rounding 1e-9."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Move:
    """One parameter: a mesh with it a little less and a little more, all else equal.

    Parameters
    ----------
    before, after : The same triangles as those of the mesh that is solved, moved.
    step : Half of the parameter's difference between them [unit of the parameter].
    """

    before: ReaderMesh
    after: ReaderMesh
    step: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PortDerivative:
    """What one parameter changes of an `UnloadedReader`, per unit of it.

    Parameters
    ----------
    admittance_s, shorted_v, phase_centres_m : Derivatives of the fields of those names ([S], [V],
        [m] per unit of the parameter).
    """

    admittance_s: ComplexArray
    shorted_v: ComplexArray
    phase_centres_m: npt.NDArray[np.float64]

    def __post_init__(self) -> None:
        n = len(self.admittance_s)
        for name, shape, dtype in (
            ("admittance_s", (n, n), np.complex128),
            ("shorted_v", (n, None, None, 2), np.complex128),
            ("phase_centres_m", (n, 3), np.float64),
        ):
            value = frozen_array(getattr(self, name), name=name, shape=shape, dtype=dtype)
            object.__setattr__(self, name, value)

    def along(self, solution: UnloadedReader, step: float) -> UnloadedReader:
        """Return the ports a step further on the tangent, from which anything else follows.

        Parameters
        ----------
        solution : The ports where the derivative was taken.
        step : Change of the parameter [its unit].
        """
        return replace(
            solution,
            admittance_s=solution.admittance_s + step * self.admittance_s,
            shorted_v=FarField(values=solution.shorted_v.values + step * self.shorted_v),
            phase_centres_m=solution.phase_centres_m + step * self.phase_centres_m,
        )


def along_all(
    solution: UnloadedReader,
    derivatives: Sequence[PortDerivative],
    amounts: npt.NDArray[np.float64],
) -> UnloadedReader:
    """Return the ports with several parameters changed at once, to first order.

    Parameters
    ----------
    solution, derivatives : What `solve_with_derivatives` returns.
    amounts : (k,) float64 — Change of each parameter [its unit].
    """
    admittance, centres = solution.admittance_s.copy(), solution.phase_centres_m.copy()
    fields = solution.shorted_v.values.copy()
    for one, amount in zip(derivatives, amounts.tolist(), strict=True):
        admittance += amount * one.admittance_s
        fields += amount * one.shorted_v
        centres += amount * one.phase_centres_m
    return replace(
        solution,
        admittance_s=admittance,
        shorted_v=FarField(values=fields),
        phase_centres_m=centres,
    )


@one_blas_thread()
def solve_with_derivatives(
    mesh: ReaderMesh,
    moves: Sequence[Move],
    *,
    frequency_hz: float | None = None,
    symmetry: bool = True,
) -> tuple[UnloadedReader, tuple[PortDerivative, ...]]:
    """Return the ports of a meshed reader, and their derivative by each move.

    Parameters
    ----------
    mesh : Triangles and feeds.
    moves : Parameters; with ``symmetry`` all must leave the mesh the rotations that it has.
    frequency_hz : Frequency [Hz]; None takes the one that the mesh was made for.
    symmetry : Use the rotational symmetry that the mesh has.

    Notes
    -----
    Distances on the mesh that is not moved decide how pairs are integrated, so that the difference
    meets no step where a rule changes. The derivative is that of the discrete solution; a mesh made
    afresh for another value of the parameter has other triangles, and a solution that differs by
    their error. The heat in lossy metal is kept as it is: powers are not differentiated.
    """
    frequency = mesh.frequency_hz if frequency_hz is None else frequency_hz
    basis, sheet = basis_with(mesh, mesh.surface_impedance_ohm(frequency), symmetry=symmetry)
    refuse_too_large(basis, mesh)
    excitation = excitations(basis, mesh)
    step = port_step_of(excitation)
    matrix = impedance_matrix(basis, frequency_hz=frequency, surface_impedance_ohm=sheet)
    factors = KeptFactors.of(basis, matrix)
    currents = factors.solve(excitation)
    halves = basis.half_coefficients(currents)
    samples = current_samples(basis, halves, frequency_hz=frequency)
    solution = UnloadedReader(
        frequency_hz=frequency,
        admittance_s=np.einsum("ism,jsm->ij", excitation, currents, optimize=True),
        heat_s=heat_matrix(basis, halves, sheet),
        shorted_v=band_limited(samples, sectors=basis.sectors, port_step=step),
        phase_centres_m=mesh.phase_centres_m,
        unknowns=basis.unknowns,
        doubts=mesh.warnings,
    )
    tangent = _Tangent(
        basis=basis,
        factors=factors,
        currents=currents,
        step=step,
        order=order_of(samples),
        frequency_hz=frequency,
        sheet_ohm=sheet,
    )
    return solution, tuple(tangent.by(move) for move in moves)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Tangent:
    """A solution with its factors, and what moves of its mesh change of it."""

    basis: SurfaceBasis
    factors: KeptFactors
    currents: ComplexArray
    step: int
    order: int
    frequency_hz: float
    sheet_ohm: ComplexArray

    def by(self, move: Move) -> PortDerivative:
        """Return the derivative by one move."""
        ends = [(self._moved(end), end) for end in (move.after, move.before)]
        over = 0.5 / move.step
        plus, minus = (excitations(basis, mesh) for basis, mesh in ends)
        driving = over * (plus - minus)
        matrix = self._matrix(ends[0][0])
        matrix -= self._matrix(ends[1][0])
        matrix *= over
        count = self.step or len(self.currents)
        rest = driving[:count] - _times(matrix, self.currents[:count])
        columns = np.einsum("ism,jsm->ij", driving, self.currents[:count], optimize=True)
        columns += np.einsum("ism,jsm->ij", self.currents, rest, optimize=True)
        change = self._all_ports(self.factors.solve(rest))
        fields = [
            self._far_field(basis, self.currents + sign * move.step * change)
            for sign, (basis, _) in zip((1.0, -1.0), ends, strict=True)
        ]
        centres = move.after.phase_centres_m - move.before.phase_centres_m
        return PortDerivative(
            admittance_s=_turned_columns(columns),
            shorted_v=over * (fields[0] - fields[1]),
            phase_centres_m=over * centres,
        )

    def _moved(self, mesh: ReaderMesh) -> SurfaceBasis:
        """Return the functions on moved corners."""
        if len(mesh.vertices_m) != len(self.basis.vertices_m):
            msg = (
                f"a mesh of {len(mesh.vertices_m)} corners was given for a move, but the mesh that "
                f"is solved has {len(self.basis.vertices_m)}; move that one."
            )
            raise GeometryError(msg)
        return replace(self.basis, vertices_m=mesh.vertices_m)

    def _matrix(self, moved: SurfaceBasis) -> ComplexArray:
        return impedance_matrix(
            moved,
            frequency_hz=self.frequency_hz,
            surface_impedance_ohm=self.sheet_ohm,
            drawn=self.basis,
            changed_only=True,
        )

    def _all_ports(self, first: ComplexArray) -> ComplexArray:
        """Return the currents of all ports from those of the first sector's."""
        if not self.step:
            return first
        turned = [np.roll(first, s, axis=1) for s in range(self.basis.sectors)]
        return np.concatenate(turned)

    def _far_field(self, basis: SurfaceBasis, currents: ComplexArray) -> ComplexArray:
        samples = current_samples(
            basis, basis.half_coefficients(currents), frequency_hz=self.frequency_hz
        )
        field = band_limited(samples, sectors=basis.sectors, port_step=self.step, order=self.order)
        return field.values


def _times(matrix: ComplexArray, currents: ComplexArray) -> ComplexArray:
    """Return (k, sectors, functions) the block-circulant matrix times factors [V m]."""
    sectors = currents.shape[1]
    result = np.zeros_like(currents)
    for d in range(sectors):
        there = np.roll(currents, -d, axis=1)
        result += there @ np.ascontiguousarray(matrix[:, d, :].T)
    return result


def _turned_columns(columns: ComplexArray) -> ComplexArray:
    """Return (n, n) a matrix from its first columns, those of one sector's ports."""
    n, step = columns.shape
    turned = [np.roll(columns, s * step, axis=0) for s in range(n // step)]
    return np.concatenate(turned, axis=1)
