"""Antennas of two ports each, fed through an ideal hybrid: circular and slanted polarisation."""

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.em.blocks import one_blas_thread
from octant.em.reader.fullwave._circuit import admittance_of, embedded_voltages, scattering
from octant.em.reader.fullwave.far_field import FarField
from octant.em.reader.fullwave.loads import UnloadedReader
from octant.em.reader.fullwave.result import FullwaveResult

ComplexArray = npt.NDArray[np.complex128]

HYBRID_OHM = 50.0
"""Impedance of all ports of the hybrids [ohm]."""


@one_blas_thread()
def with_hybrids(unloaded: UnloadedReader, shares: ComplexArray) -> UnloadedReader:
    """Return the ports of a solution behind ideal hybrids, as ports of one antenna each.

    Parameters
    ----------
    unloaded : The solution without loads, of N ports.
    shares : (n, N) complex128 — What of a wave into each antenna's hybrid comes to each port [-]; a
        row's squares add up to 1.

    Notes
    -----
    A hybrid is matched, without losses, and isolated: what its antenna's ports give back out of
    step ends in its fourth port's load, and counts as lost with the heat.
    """
    return _changed(unloaded, shares, _voltages(unloaded, shares))


@one_blas_thread()
def result_with_hybrids(result: FullwaveResult, shares: ComplexArray) -> FullwaveResult:
    """Return a solution with its currents behind ideal hybrids, loads as before.

    Parameters
    ----------
    result : The solution; all loads are the same [ohm].
    shares : (n, N) complex128 — As for `with_hybrids` [-].
    """
    volts = _voltages(result.unloaded, shares)
    moments = np.tensordot(volts, result.samples.moments_a_m, axes=(1, 0))
    return replace(
        result,
        unloaded=_changed(result.unloaded, shares, volts),
        load_ohm=result.load_ohm[: len(shares)],
        samples=replace(result.samples, moments_a_m=moments),
        halves_a_per_m=np.tensordot(volts, result.halves_a_per_m, axes=(1, 0)),
        port_step=0,
    )


def axial_ratio_db(field: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return the ratio of the axes of the polarisation ellipse: 0 is circular, inf linear [dB].

    Parameters
    ----------
    field : (..., 2) complex — F_theta and F_phi [any unit].
    """
    parts = np.asarray(field, dtype=np.complex128)
    theta, phi = parts[..., 0], parts[..., 1]
    whole = np.abs(theta) ** 2 + np.abs(phi) ** 2
    linear = np.abs(theta * theta + phi * phi)
    with np.errstate(divide="ignore"):
        ratio = np.sqrt((whole + linear) / np.maximum(whole - linear, 0.0))
        return np.asarray(20.0 * np.log10(ratio))


def _behind(unloaded: UnloadedReader, shares: ComplexArray) -> ComplexArray:
    """Return the admittances (n, n) of the hybrids' inputs [S]."""
    n, ports = shares.shape
    inner = scattering(unloaded.admittance_s, np.full(ports, HYBRID_OHM + 0j))
    return admittance_of(shares @ inner @ shares.T, np.full(n, HYBRID_OHM + 0j))


def _voltages(unloaded: UnloadedReader, shares: ComplexArray) -> ComplexArray:
    """Return (n, N) the voltages at all ports for one volt at each input, the others shorted."""
    n, ports = shares.shape
    outer = embedded_voltages(_behind(unloaded, shares), np.full(n, HYBRID_OHM + 0j))
    inner = embedded_voltages(unloaded.admittance_s, np.full(ports, HYBRID_OHM + 0j))
    volts: npt.NDArray[Any] = np.linalg.solve(outer, shares @ inner)
    return volts


def _changed(unloaded: UnloadedReader, shares: ComplexArray, volts: ComplexArray) -> UnloadedReader:
    taken = _behind(unloaded, shares)
    passed = volts.conj() @ _real_part(unloaded.admittance_s) @ volts.T
    heat = volts.conj() @ unloaded.heat_s @ volts.T
    weight = np.abs(shares) ** 2
    return replace(
        unloaded,
        admittance_s=taken,
        heat_s=heat + _real_part(taken) - passed,
        shorted_v=FarField(values=np.tensordot(volts, unloaded.shorted_v.values, axes=(1, 0))),
        phase_centres_m=weight @ unloaded.phase_centres_m,
    )


def _real_part(matrix: ComplexArray) -> npt.NDArray[Any]:
    half: npt.NDArray[Any] = 0.5 * (matrix + matrix.conj().T)
    return half
