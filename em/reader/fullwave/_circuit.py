"""Loads on the ports of a solved structure, and where the power of each driven port goes."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.em.reader.fullwave.basis import SurfaceBasis
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


def realised_scale(load_ohm: ComplexArray) -> npt.NDArray[np.float64]:
    """Return (n,) the realised pattern of a far field of one volt from one volt's source [1/V]."""
    scale: npt.NDArray[np.float64] = np.sqrt(16.0 * math.pi * load_ohm.real / VACUUM_IMPEDANCE_OHM)
    return scale


def heat_matrix(
    basis: SurfaceBasis,
    halves_a_per_m: npt.NDArray[np.complex128],
    sheet_ohm: npt.NDArray[np.complex128],
) -> ComplexArray:
    """Return (n, n) the matrix H that gives twice the heat v* H v of port voltages v [S]."""
    count = len(halves_a_per_m)
    if not sheet_ohm.real.any():
        return np.zeros((count, count), dtype=np.complex128)
    corners = basis.corners_m
    offset = corners - corners.mean(axis=1, keepdims=True)
    spread = (offset**2).sum(axis=(1, 2)) / 12.0
    dots = np.einsum("fic,fjc->fij", offset, offset) + spread[:, None, None]
    edge = basis.edge_lengths_m
    gram = dots * edge[:, :, None] * edge[:, None, :] / (4.0 * basis.areas_m2[:, None, None])
    gram *= sheet_ohm.real[:, None, None]
    heat: ComplexArray = np.einsum(
        "kfi,fij,lfj->kl", halves_a_per_m.conj(), gram, halves_a_per_m, optimize=True
    )
    return heat


def powers_of(matrix: ComplexArray, rows: ComplexArray) -> npt.NDArray[np.float64]:
    """Return (n,) x* M x for the rows x of a matrix [the rows' unit squared times M's]."""
    power: npt.NDArray[np.float64] = np.einsum(
        "ni,ij,nj->n", rows.conj(), matrix, rows, optimize=True
    ).real
    return power
