"""Scattering matrices as Touchstone files (.s8p)."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from octant.em.fullwave.result import FullwaveResult
from octant.geometries.errors import AntennaError

PAIRS_PER_LINE = 4
"""Complex values in a line [-], as the format has it for three ports and more."""


def write_touchstone(path: Path | str, results: Sequence[FullwaveResult]) -> None:
    """Return nothing; write the scattering matrices [-] of solutions to a Touchstone 1.1 file.

    Parameters
    ----------
    path : Path or str
        File to write; its name should end in .sNp for N ports, such as .s8p.
    results : sequence of FullwaveResult
        Solutions, one for each frequency, rising; all ports loaded with one resistance.

    Raises
    ------
    AntennaError
        When there is no solution, frequencies do not rise, or the loads are not all one resistance.

    References
    ----------
    .. [1] EIA/IBIS Open Forum, Touchstone File Format Specification, version 1.1 (2003).
    """
    frequencies = np.array([result.frequency_hz for result in results])
    loads = np.concatenate([result.load_ohm for result in results]) if results else np.zeros(0)
    if not len(results) or not (np.diff(frequencies) > 0.0).all():
        msg = f"frequencies are {frequencies.tolist()} Hz, but at least one, rising, are needed."
        raise AntennaError(msg)
    if not np.allclose(loads, loads[0].real, rtol=1e-12, atol=0.0):
        msg = (
            f"load_ohm is {loads.tolist()} ohm, but a Touchstone file has one resistance for all "
            "ports; solve with equal loads."
        )
        raise AntennaError(msg)
    lines = [
        f"! Octant, method of moments, {results[0].ports} ports, {results[0].unknowns} unknowns",
        f"# Hz S RI R {loads[0].real:.12g}",
    ]
    for result in results:
        matrix = result.s_matrix
        if result.ports == 2:  # the one case that runs by columns, on one line
            matrix = matrix.T.reshape(1, -1)
        for row, values in enumerate(matrix):
            for first in range(0, len(values), PAIRS_PER_LINE):
                head = f"{result.frequency_hz:.12g}" if row == 0 and first == 0 else ""
                pairs = values[first : first + PAIRS_PER_LINE]
                text = " ".join(f"{z.real:.12e} {z.imag:.12e}" for z in pairs)
                lines.append(f"{head} {text}")
    Path(path).write_text("\n".join(lines) + "\n", encoding="ascii")
