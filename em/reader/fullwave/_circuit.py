"""Loads on the ports of a solved structure, by circuit theory."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.em.reader.fullwave.rwg import VACUUM_IMPEDANCE_OHM

ComplexArray = npt.NDArray[np.complex128]
"""Complex values [any unit]."""


def embedded_voltages(admittance_s: ComplexArray, load_ohm: ComplexArray) -> ComplexArray:
    """Return (n, n) port voltages [V], a row for each port driven by one volt behind its load."""
    loaded = np.eye(len(load_ohm)) + load_ohm[:, None] * admittance_s
    rows: npt.NDArray[Any] = np.linalg.inv(loaded).T
    return rows


def scattering(admittance_s: ComplexArray, load_ohm: ComplexArray) -> ComplexArray:
    """Return (n, n) the scattering matrix of power waves [-], each port referred to its load.

    K. Kurokawa, IEEE Trans. Microw. Theory Tech. 13 (1965) 194, equations 1 and 18.
    """
    one = np.eye(len(load_ohm))
    root = np.sqrt(load_ohm.real)
    incident = one + load_ohm[:, None] * admittance_s
    reflected = one - load_ohm.conj()[:, None] * admittance_s
    matrix: npt.NDArray[Any] = np.linalg.solve(incident.T, reflected.T).T
    matrix *= root / root[:, None]
    return matrix


def admittance_of(s_matrix: ComplexArray, load_ohm: ComplexArray) -> ComplexArray:
    """Return (n, n) the admittance matrix [S] that has a scattering matrix of power waves."""
    root = np.sqrt(load_ohm.real)
    plain = s_matrix * root[:, None] / root
    left = plain * load_ohm + np.diag(load_ohm.conj())
    matrix: npt.NDArray[Any] = np.linalg.solve(left, np.eye(len(load_ohm)) - plain)
    return matrix


def realised_weights(admittance_s: ComplexArray, load_ohm: ComplexArray) -> ComplexArray:
    """Return (n, n) factors from fields of one volt at each port to realised patterns [1/V]."""
    scale = np.sqrt(16.0 * math.pi * load_ohm.real / VACUUM_IMPEDANCE_OHM)
    weights: ComplexArray = scale[:, None] * embedded_voltages(admittance_s, load_ohm)
    return weights
