"""The full-wave solution of a reader: matrices, embedded patterns, currents, power balance."""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.fullwave.basis import SurfaceBasis, best_sectors, surface_basis
from octant.em.fullwave.far_field import CurrentSamples, current_samples, sphere_rule
from octant.em.fullwave.linear_solve import solve_currents
from octant.em.fullwave.mesh import ReaderMesh
from octant.em.fullwave.ports import feed_excitation
from octant.em.fullwave.rwg import VACUUM_IMPEDANCE_OHM, impedance_matrix
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import AntennaError

BALANCE_LIMIT = 1e-3
"""Radiated and lost power less accepted power, over the latter [-], above which a run warns."""


STEPS = ("functions", "assembly", "solution", "power balance")
"""Steps of a run whose times are kept [-]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FullwaveResult:
    """Matrices, patterns and powers of n antennas on a metal body, with loads on all ports.

    Parameters
    ----------
    frequency_hz : float
        Frequency [Hz].
    load_ohm : (n,) complex128
        Impedance of every port's source and load [ohm].
    admittance_s : (n, n) complex128
        Currents at the ports per volt at each, without loads [S].
    samples : CurrentSamples
        Currents of one volt at each port in turn, the others shorted [A m per V].
    halves_a_per_m : (n, f, 3) complex128
        The same currents as factors of the half-functions [A/m per V].
    basis : SurfaceBasis
        Functions and triangles.
    radiated_share : (n,) float64
        Radiated over available power, each port driven in turn, from the far field [-].
    accepted_share : (n,) float64
        The same from the ports [-]: what neither returns to the source nor ends in loads.
    lost_share : (n,) float64
        Share that heats sheets of finite impedance [-].
    port_step : int
        Ports by which a turn by one sector moves on [-]; 0 when it does not map ports to ports.
    seconds : mapping
        Wall-clock time of each step [s].
    warnings : tuple of str
        What makes the result doubtful.
    """

    frequency_hz: float
    load_ohm: npt.NDArray[np.complex128]
    admittance_s: npt.NDArray[np.complex128]
    samples: CurrentSamples
    halves_a_per_m: npt.NDArray[np.complex128]
    basis: SurfaceBasis
    radiated_share: npt.NDArray[np.float64]
    accepted_share: npt.NDArray[np.float64]
    lost_share: npt.NDArray[np.float64]
    port_step: int = 0
    seconds: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.admittance_s)
        for name, shape, dtype in (
            ("load_ohm", (n,), np.complex128),
            ("admittance_s", (n, n), np.complex128),
            ("halves_a_per_m", (n, None, 3), np.complex128),
            ("radiated_share", (n,), np.float64),
            ("accepted_share", (n,), np.float64),
            ("lost_share", (n,), np.float64),
        ):
            value = frozen_array(
                getattr(self, name), name=name, shape=shape, dtype=dtype, error=AntennaError
            )
            object.__setattr__(self, name, value)
        object.__setattr__(self, "seconds", MappingProxyType(dict(self.seconds)))

    @property
    def ports(self) -> int:
        """Number of ports [-]."""
        return len(self.admittance_s)

    @property
    def unknowns(self) -> int:
        """Number of independent functions [-]."""
        return self.basis.unknowns

    @property
    def impedance_ohm(self) -> npt.NDArray[np.complex128]:
        """Return (n, n) the open-circuit impedance matrix Z [ohm]."""
        inverse: npt.NDArray[Any] = np.linalg.inv(self.admittance_s)
        return inverse

    @property
    def s_matrix(self) -> npt.NDArray[np.complex128]:
        """Return (n, n) the scattering matrix of power waves, ports referred to their loads [-]."""
        return _scattering(self.admittance_s, self.load_ohm)

    @property
    def input_impedance_ohm(self) -> npt.NDArray[np.complex128]:
        """Return (n,) the impedance seen by each source, the other ports loaded [ohm]."""
        voltage = self.embedded_voltages_v
        current = np.diagonal(voltage @ self.admittance_s.T)
        seen: npt.NDArray[np.complex128] = np.diagonal(voltage) / current
        return seen

    @property
    def balance_error(self) -> float:
        """Greatest of |radiated + lost - accepted| over accepted power [-]."""
        off = self.radiated_share + self.lost_share - self.accepted_share
        return float(np.abs(off / self.accepted_share).max())

    @property
    def embedded_voltages_v(self) -> npt.NDArray[np.complex128]:
        """Return (n, n) port voltages, a row for each port driven by a source of one volt [V]."""
        return _embedded_voltages(self.admittance_s, self.load_ohm)

    def far_field(
        self, theta_rad: npt.ArrayLike, phi_rad: npt.ArrayLike
    ) -> npt.NDArray[np.complex128]:
        """Return the embedded realised patterns towards any directions, from the currents [-].

        Parameters
        ----------
        theta_rad, phi_rad : array_like
            Directions [rad], broadcast against each other.

        Returns
        -------
        (n, ..., 2) complex128
            F_theta and F_phi [-], |F|^2 = realised gain for a source of the port's load
            impedance, the other ports loaded; phase at the ground plane's centre, source of phase
            0, factor exp(-jkR) / R dropped.
        """
        shorted = self.samples.far_field(theta_rad, phi_rad)
        weights = _realised_weights(self.admittance_s, self.load_ohm)
        patterns: npt.NDArray[np.complex128] = np.tensordot(weights, shorted, axes=(1, 0))
        return patterns

    def pattern_grid(self, theta_rad: npt.ArrayLike, columns: int) -> npt.NDArray[np.complex128]:
        """Return the patterns of `far_field` on a grid, computed for one sector only if possible.

        Parameters
        ----------
        theta_rad : (t,) array_like
            Values of theta [rad].
        columns : int
            Number of even steps of phi from 0 to, not including, 2 pi [-].

        Returns
        -------
        (n, t, columns, 2) complex128
            F_theta and F_phi [-].
        """
        return _pattern_grid(
            self.samples,
            _realised_weights(self.admittance_s, self.load_ohm),
            np.asarray(theta_rad, dtype=np.float64),
            columns,
            sectors=self.basis.sectors,
            port_step=self.port_step,
        )


def _pattern_grid(
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


def _realised_weights(
    admittance_s: npt.NDArray[np.complex128], load_ohm: npt.NDArray[np.complex128]
) -> npt.NDArray[np.complex128]:
    """Return (n, n) factors from fields of one volt at each port to realised patterns [1/V]."""
    scale = np.sqrt(16.0 * math.pi * load_ohm.real / VACUUM_IMPEDANCE_OHM)
    weights: npt.NDArray[np.complex128] = scale[:, None] * _embedded_voltages(
        admittance_s, load_ohm
    )
    return weights


def _embedded_voltages(
    admittance_s: npt.NDArray[np.complex128], load_ohm: npt.NDArray[np.complex128]
) -> npt.NDArray[np.complex128]:
    """Return (n, n) port voltages [V], a row for each port driven by one volt behind its load."""
    loaded = np.eye(len(load_ohm)) + load_ohm[:, None] * admittance_s
    rows: npt.NDArray[Any] = np.linalg.inv(loaded).T
    return rows


def solve_reader(
    mesh: ReaderMesh,
    *,
    frequency_hz: float | None = None,
    load_ohm: npt.ArrayLike = 50.0,
    surface_impedance_ohm: npt.ArrayLike = 0.0,
    symmetry: bool = True,
) -> FullwaveResult:
    """Return the full-wave solution of a meshed reader.

    Parameters
    ----------
    mesh : ReaderMesh
        Triangles and feeds.
    frequency_hz : float or None
        Frequency [Hz]; None takes the one that the mesh was made for.
    load_ohm : complex or (n,) array_like
        Impedance of source and load of every port [ohm], its resistance above 0.
    surface_impedance_ohm : complex or (f,) array_like
        Surface impedance of each triangle [ohm], in the order of ``mesh.faces``.
    symmetry : bool
        Use the rotational symmetry that the mesh has.

    Returns
    -------
    FullwaveResult
        Matrices, patterns, powers.

    Raises
    ------
    AntennaError
        When the resistance of a load is not positive.
    GeometryError
        When a feed meets no edge, or the moment equations are singular.
    """
    frequency = mesh.frequency_hz if frequency_hz is None else frequency_hz
    load = np.broadcast_to(np.asarray(load_ohm, dtype=np.complex128), (mesh.antennas,))
    if not (np.isfinite(load).all() and (load.real > 0.0).all()):
        msg = f"load_ohm is {load_ohm!r} ohm, but every load must have a resistance above 0 ohm."
        raise AntennaError(msg)
    clock = [time.perf_counter()]
    sheet = np.zeros(len(mesh.faces), dtype=np.complex128) + np.asarray(surface_impedance_ohm)
    sectors = 1
    if symmetry and len(np.unique(sheet)) == 1:
        n = mesh.antennas
        divisors = tuple(d for d in range(n, 1, -1) if n % d == 0)
        sectors = best_sectors(mesh.vertices_m, mesh.faces, divisors)
    basis = surface_basis(mesh.vertices_m, mesh.faces, sectors=sectors)
    sheet = sheet[basis.given_face]
    excitation = _excitations(basis, mesh)
    clock.append(time.perf_counter())
    matrix = impedance_matrix(basis, frequency_hz=frequency, surface_impedance_ohm=sheet)
    clock.append(time.perf_counter())
    currents = solve_currents(basis, matrix, excitation)
    del matrix
    clock.append(time.perf_counter())
    admittance = np.einsum("ism,jsm->ij", excitation, currents, optimize=True)
    halves = basis.half_coefficients(currents)
    samples = current_samples(basis, halves, frequency_hz=frequency)
    step = _port_step(excitation)
    s_matrix_power = np.abs(_scattering(admittance, load)) ** 2
    radiated = _radiated_shares(samples, admittance, load, sectors=sectors, port_step=step)
    lost = _lost_shares(basis, halves, sheet, admittance, load)
    clock.append(time.perf_counter())
    result = FullwaveResult(
        frequency_hz=frequency,
        load_ohm=load,
        admittance_s=admittance,
        samples=samples,
        halves_a_per_m=halves,
        basis=basis,
        radiated_share=radiated,
        accepted_share=1.0 - s_matrix_power.sum(axis=0),
        lost_share=lost,
        port_step=step,
        seconds=dict(zip(STEPS, np.diff(clock).tolist(), strict=True)),
        warnings=mesh.warnings,
    )
    if result.balance_error <= BALANCE_LIMIT:
        return result
    doubt = (
        f"radiated and accepted power differ by {100.0 * result.balance_error:.2g} %, more than "
        f"{100.0 * BALANCE_LIMIT:g} %: the mesh is too coarse somewhere"
    )
    return replace(result, warnings=(*result.warnings, doubt))


def _scattering(
    admittance_s: npt.NDArray[np.complex128], load_ohm: npt.NDArray[np.complex128]
) -> npt.NDArray[np.complex128]:
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


def _excitations(basis: SurfaceBasis, mesh: ReaderMesh) -> npt.NDArray[np.float64]:
    """Return (n, sectors, functions) products of the functions with one volt at each feed [V m]."""
    owner = mesh.antenna_of_face[basis.given_face]
    halves = [
        feed_excitation(basis, np.flatnonzero(owner == i), bottom, top)
        for i, (bottom, top) in enumerate(zip(mesh.feed_bottom_m, mesh.feed_top_m, strict=True))
    ]
    return basis.gathered(np.array(halves))


def _port_step(excitation: npt.NDArray[np.float64]) -> int:
    """Return the ports that a turn by one sector moves on [-], 0 when ports do not map to ports."""
    ports, sectors, _ = excitation.shape
    if sectors == 1 or ports % sectors:
        return 0
    step = ports // sectors
    turned = np.roll(np.roll(excitation, step, axis=0), -1, axis=1)
    same = np.allclose(turned, excitation, rtol=0.0, atol=1e-9 * float(np.abs(excitation).max()))
    return step if same else 0


def _radiated_shares(
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
    pattern = _pattern_grid(
        samples,
        _realised_weights(admittance_s, load_ohm),
        theta,
        columns,
        sectors=sectors,
        port_step=port_step,
    )
    shares: npt.NDArray[np.float64] = np.einsum("t,ntpc->n", weights, np.abs(pattern) ** 2)
    return shares


def _lost_shares(
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
    driven = np.tensordot(_embedded_voltages(admittance_s, load_ohm), halves_a_per_m, axes=(1, 0))
    heat = np.einsum("kfi,fij,kfj->kf", driven.conj(), gram, driven, optimize=True).real
    shares: npt.NDArray[np.float64] = 4.0 * load_ohm.real * (heat @ sheet_ohm.real)
    return shares
