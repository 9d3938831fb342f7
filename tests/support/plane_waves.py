"""Scattering of plane waves by metal meshes: radar cross-sections, to check the solver by."""

import math

import numpy as np
import numpy.typing as npt

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave.basis import SEVEN_POINTS, SEVEN_WEIGHTS, SurfaceBasis
from octant.em.reader.fullwave.far_field import CurrentSamples, current_samples
from octant.em.reader.fullwave.linear_solve import solve_currents
from octant.em.reader.fullwave.rwg import impedance_matrix
from octant.geometries._arrays import frozen_array


def scattered_currents(
    basis: SurfaceBasis,
    *,
    frequency_hz: float,
    travel: npt.ArrayLike,
    polarisation: npt.ArrayLike,
    surface_impedance_ohm: npt.ArrayLike = 0.0,
) -> CurrentSamples:
    """Return the currents [A m] that plane waves of 1 V/m raise on a metal mesh, a case for each.

    4 pi |E R|^2 of a case's far field is the radar cross-section [m^2].
    """
    along = frozen_array(travel, name="travel", shape=(None, 3))
    field = frozen_array(
        polarisation, name="polarisation", shape=(len(along), 3), dtype=np.complex128
    )
    wavenumber = 2.0 * math.pi * frequency_hz / SPEED_OF_LIGHT_M_PER_S
    corners = basis.corners_m
    points = np.einsum("ab,fbc->fac", SEVEN_POINTS, corners)
    phase = np.exp(-1j * wavenumber * np.einsum("fac,kc->kfa", points, along)) * SEVEN_WEIGHTS
    # l / (2A) (r - corner), integrated by weights times A
    mean = np.einsum("kfa,fac,kc->kf", phase, points, field, optimize=True)
    at_corner = np.einsum("fic,kc->kfi", corners, field)
    halves = (
        0.5 * basis.edge_lengths_m * (mean[:, :, None] - phase.sum(axis=2)[:, :, None] * at_corner)
    )
    matrix = impedance_matrix(
        basis, frequency_hz=frequency_hz, surface_impedance_ohm=surface_impedance_ohm
    )
    currents = solve_currents(basis, matrix, basis.gathered(halves))
    return current_samples(basis, basis.half_coefficients(currents), frequency_hz=frequency_hz)
