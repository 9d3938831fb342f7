"""Loads on the ports of a solved structure, and where the power of each driven port goes."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave.basis import SurfaceBasis
from octant.em.reader.fullwave.far_field import CurrentSamples, sphere_rule
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


def turned_pattern(
    samples: CurrentSamples,
    weights: npt.NDArray[np.complex128],
    theta_rad: npt.NDArray[np.float64],
    columns: int,
    *,
    sectors: int,
    port_step: int,
) -> npt.NDArray[np.complex128]:
    """Return (n, t, columns, 2) realised patterns, the other sectors' by turning the first's."""
    phi = 2.0 * math.pi * np.arange(columns) / columns
    alone = port_step == 0 or columns % sectors != 0
    wide = columns if alone else columns // sectors
    shorted = samples.far_field(theta_rad[:, None], phi[:wide])
    part: npt.NDArray[np.complex128] = np.tensordot(weights, shorted, axes=(1, 0))
    if alone:
        return part
    turned = [np.roll(part, s * port_step, axis=0) for s in range(sectors)]
    return np.concatenate(turned, axis=2)


def radiated_shares(
    samples: CurrentSamples,
    admittance_s: npt.NDArray[np.complex128],
    load_ohm: npt.NDArray[np.complex128],
    *,
    sectors: int,
    port_step: int,
) -> npt.NDArray[np.float64]:
    """Return (n,) the mean realised gain over the sphere [-]."""
    wavenumber = 2.0 * math.pi * samples.frequency_hz / SPEED_OF_LIGHT_M_PER_S
    reach = float(np.linalg.norm(samples.points_m, axis=1).max())
    theta, columns, weights = sphere_rule(wavenumber, reach, multiple_of=sectors)
    pattern = turned_pattern(
        samples,
        realised_weights(admittance_s, load_ohm),
        theta,
        columns,
        sectors=sectors,
        port_step=port_step,
    )
    shares: npt.NDArray[np.float64] = np.einsum("t,ntpc->n", weights, np.abs(pattern) ** 2)
    return shares


def lost_shares(
    basis: SurfaceBasis,
    halves_a_per_m: npt.NDArray[np.complex128],
    sheet_ohm: npt.NDArray[np.complex128],
    admittance_s: npt.NDArray[np.complex128],
    load_ohm: npt.NDArray[np.complex128],
) -> npt.NDArray[np.float64]:
    """Return (n,) the share of the available power that heats the sheets [-]."""
    if not sheet_ohm.real.any():
        return np.zeros(len(load_ohm))
    corners = basis.corners_m
    offset = corners - corners.mean(axis=1, keepdims=True)
    spread = (offset**2).sum(axis=(1, 2)) / 12.0
    dots = np.einsum("fic,fjc->fij", offset, offset) + spread[:, None, None]
    edge = basis.edge_lengths_m
    gram = dots * edge[:, :, None] * edge[:, None, :] / (4.0 * basis.areas_m2[:, None, None])
    driven = np.tensordot(embedded_voltages(admittance_s, load_ohm), halves_a_per_m, axes=(1, 0))
    heat = np.einsum("kfi,fij,kfj->kf", driven.conj(), gram, driven, optimize=True).real
    shares: npt.NDArray[np.float64] = 4.0 * load_ohm.real * (heat @ sheet_ohm.real)
    return shares
