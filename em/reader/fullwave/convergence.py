"""How a reader's solution moves as its mesh gets finer."""

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.em.decibels import decibels
from octant.em.reader.fullwave.result import ErrorEstimate, FullwaveResult
from octant.geometries.errors import GeometryError

DENSITIES = (7.0, 10.0, 14.0, 20.0)
"""Default elements per wavelength of a study [-]."""

STRONG_DB, WEAK_DB = 10.0, 20.0
"""Levels below the maximum [dB] that bound strong and weak parts of a pattern."""

STEP_DEG = 5.0
"""Step of the grid [deg] on which patterns are compared."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ConvergenceStudy:
    """Solutions of one reader at rising mesh density, each compared with the last.

    Parameters
    ----------
    cells_per_wavelength : Densities, rising [-].
    results : Solution at each density; all but the last carry their ``error``.
    """

    cells_per_wavelength: tuple[float, ...]
    results: tuple[FullwaveResult, ...]

    def lines(self) -> list[str]:
        """Return the study as lines of text: density, unknowns, impedance, differences."""
        lines = []
        for cells, result in zip(self.cells_per_wavelength, self.results, strict=True):
            z = result.input_impedance_ohm[0]
            line = (
                f"1/{cells:g} wavelength: {result.unknowns} unknowns, antenna 1 "
                f"{z.real:.1f}{z.imag:+.1f}j ohm, power balance {result.balance_error:.1e}"
            )
            if result.error is not None:
                line += (
                    f"; to 1/{result.error.finer_cells_per_wavelength:g}: "
                    f"{result.error.strong_db:.3f} dB where strong, {result.error.weak_db:.3f} dB "
                    f"where weak, impedance {100.0 * result.error.impedance:.1f} %"
                )
            lines.append(line)
        return lines


def convergence_study(
    solve: Callable[[float], FullwaveResult],
    cells_per_wavelength: Sequence[float] = DENSITIES,
) -> ConvergenceStudy:
    """Return the solutions of a reader at several mesh densities, compared with the finest.

    Parameters
    ----------
    solve : Gives the solution for a number of elements per wavelength [-].
    cells_per_wavelength : Densities, at least two, rising [-].
    """
    densities = tuple(float(cells) for cells in cells_per_wavelength)
    if len(densities) < 2 or any(b <= a for a, b in itertools.pairwise(densities)):
        msg = f"cells_per_wavelength is {densities}, but at least two rising densities are needed."
        raise GeometryError(msg)
    results = [solve(cells) for cells in densities]
    finest = results[-1]
    checked = [
        replace(
            result, error=error_estimate(result, finest, finer_cells_per_wavelength=densities[-1])
        )
        for result in results[:-1]
    ]
    return ConvergenceStudy(cells_per_wavelength=densities, results=(*checked, finest))


def error_estimate(
    result: FullwaveResult, finer: FullwaveResult, *, finer_cells_per_wavelength: float
) -> ErrorEstimate:
    """Return how far a solution is from a finer one.

    Parameters
    ----------
    result : Solution to judge.
    finer : Solution of the same reader on a finer mesh.
    finer_cells_per_wavelength : Density of the finer mesh [-].
    """
    theta = np.radians(np.arange(0.0, 180.0 + STEP_DEG, STEP_DEG))
    columns = round(360.0 / STEP_DEG)
    found, best = (_gain_db(r.pattern_grid(theta, columns)) for r in (result, finer))
    strong_db = weak_db = 0.0
    for ours, theirs in zip(found, best, strict=True):
        below = theirs.max() - theirs
        strong_db = max(strong_db, _rms((ours - theirs)[below < STRONG_DB]))
        weak_db = max(weak_db, _rms((ours - theirs)[(below >= STRONG_DB) & (below < WEAK_DB)]))
    off = np.abs(result.input_impedance_ohm / finer.input_impedance_ohm - 1.0)
    return ErrorEstimate(
        finer_cells_per_wavelength=finer_cells_per_wavelength,
        strong_db=strong_db,
        weak_db=weak_db,
        impedance=float(off.max()),
    )


def _gain_db(pattern: npt.NDArray[np.complex128]) -> npt.NDArray[np.float64]:
    """Return the gains of patterns [dB]; nothing is taken as -300 dB."""
    return decibels((np.abs(pattern) ** 2).sum(axis=-1) + 1e-30)


def _rms(values: npt.NDArray[np.float64]) -> float:
    """Return the root of the mean square; 0 of nothing."""
    return math.sqrt(float((values**2).mean())) if values.size else 0.0
