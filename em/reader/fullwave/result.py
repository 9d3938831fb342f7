"""What a full-wave solution holds: matrices, embedded patterns, currents, powers."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.em.reader.fullwave._circuit import (
    embedded_voltages,
    realised_weights,
    scattering,
    turned_pattern,
)
from octant.em.reader.fullwave.basis import SurfaceBasis
from octant.em.reader.fullwave.far_field import CurrentSamples
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import AntennaError


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorEstimate:
    """How far a solution is from that on a finer mesh.

    Parameters
    ----------
    finer_cells_per_wavelength : Density of the finer mesh [-].
    strong_db : Greatest rms difference of any antenna's gain where it is within 10 dB of its
        maximum [dB].
    weak_db : The same from 10 to 20 dB below the maximum [dB].
    impedance : Greatest relative difference of the input impedances [-].
    """

    finer_cells_per_wavelength: float
    strong_db: float
    weak_db: float
    impedance: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FullwaveResult:
    """Matrices, patterns and powers of n antennas on a metal body, with loads on all ports.

    Parameters
    ----------
    frequency_hz : Frequency [Hz].
    load_ohm : (n,) complex128 — Impedance of every port's source and load [ohm].
    admittance_s : (n, n) complex128 — Currents at the ports per volt at each, without loads [S].
    samples : Currents of one volt at each port in turn, the others shorted [A m per V].
    halves_a_per_m : (n, f, 3) complex128 — The same currents as factors of the half-functions [A/m
        per V].
    basis : Functions and triangles.
    sheet_ohm : (f,) complex128 — Surface impedance of the basis' triangles [ohm].
    radiated_share : (n,) float64 — Radiated over available power, each port driven in turn, from
        the far field [-].
    accepted_share : (n,) float64 — The same from the ports [-]: what neither returns to the source
        nor ends in loads.
    lost_share : (n,) float64 — Share that heats sheets of finite impedance [-].
    port_step : Ports by which a turn by one sector moves on; 0 when it does not map ports to ports.
    seconds : Wall-clock time of each step [s].
    error : What a finer mesh changes, where it was tried.
    warnings : What makes the result doubtful.
    """

    frequency_hz: float
    load_ohm: npt.NDArray[np.complex128]
    admittance_s: npt.NDArray[np.complex128]
    samples: CurrentSamples
    halves_a_per_m: npt.NDArray[np.complex128]
    basis: SurfaceBasis
    sheet_ohm: npt.NDArray[np.complex128]
    radiated_share: npt.NDArray[np.float64]
    accepted_share: npt.NDArray[np.float64]
    lost_share: npt.NDArray[np.float64]
    port_step: int = 0
    seconds: Mapping[str, float] = field(default_factory=dict)
    error: ErrorEstimate | None = None
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n = len(self.admittance_s)
        for name, shape, dtype in (
            ("load_ohm", (n,), np.complex128),
            ("admittance_s", (n, n), np.complex128),
            ("halves_a_per_m", (n, None, 3), np.complex128),
            ("sheet_ohm", (len(self.basis.faces),), np.complex128),
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
        """Number of ports."""
        return len(self.admittance_s)

    @property
    def unknowns(self) -> int:
        """Number of independent functions."""
        return self.basis.unknowns

    @property
    def impedance_ohm(self) -> npt.NDArray[np.complex128]:
        """Return (n, n) the open-circuit impedance matrix Z [ohm]."""
        inverse: npt.NDArray[Any] = np.linalg.inv(self.admittance_s)
        return inverse

    @property
    def s_matrix(self) -> npt.NDArray[np.complex128]:
        """Return (n, n) the scattering matrix of power waves, ports referred to their loads [-]."""
        return scattering(self.admittance_s, self.load_ohm)

    @property
    def input_impedance_ohm(self) -> npt.NDArray[np.complex128]:
        """Return (n,) the impedance seen by each source, the other ports loaded [ohm]."""
        voltage = self.embedded_voltages_v
        current = np.diagonal(voltage @ self.admittance_s.T)
        seen: npt.NDArray[np.complex128] = np.diagonal(voltage) / current
        return seen

    @property
    def reflected_share(self) -> npt.NDArray[np.float64]:
        """Return (n,) the share of the available power that returns to each driven source [-]."""
        reflected: npt.NDArray[np.float64] = np.abs(np.diagonal(self.s_matrix)) ** 2
        return reflected

    @property
    def coupled_share(self) -> npt.NDArray[np.float64]:
        """Return (n,) the share of the available power that ends in the other ports' loads [-]."""
        everything = (np.abs(self.s_matrix) ** 2).sum(axis=0)
        coupled: npt.NDArray[np.float64] = everything - self.reflected_share
        return coupled

    @property
    def balance_error(self) -> float:
        """Greatest of |radiated + lost - accepted| over accepted power [-]."""
        off = self.radiated_share + self.lost_share - self.accepted_share
        return float(np.abs(off / self.accepted_share).max())

    @property
    def embedded_voltages_v(self) -> npt.NDArray[np.complex128]:
        """Return (n, n) port voltages, a row for each port driven by a source of one volt [V]."""
        return embedded_voltages(self.admittance_s, self.load_ohm)

    def far_field(
        self, theta_rad: npt.ArrayLike, phi_rad: npt.ArrayLike
    ) -> npt.NDArray[np.complex128]:
        """Return the embedded realised patterns towards any directions, from the currents [-].

        Parameters
        ----------
        theta_rad, phi_rad : array_like — Directions [rad], broadcast against each other.

        Returns
        -------
        (n, ..., 2) complex128
            F_theta and F_phi [-], |F|^2 = realised gain for a source of the port's load
            impedance, the other ports loaded; phase at the ground plane's centre, source of phase
            0, factor exp(-jkR) / R dropped.
        """
        shorted = self.samples.far_field(theta_rad, phi_rad)
        weights = realised_weights(self.admittance_s, self.load_ohm)
        patterns: npt.NDArray[np.complex128] = np.tensordot(weights, shorted, axes=(1, 0))
        return patterns

    def pattern_grid(self, theta_rad: npt.ArrayLike, columns: int) -> npt.NDArray[np.complex128]:
        """Return the patterns of `far_field` on a grid, computed for one sector only if possible.

        Parameters
        ----------
        theta_rad : (t,) array_like — Values of theta [rad].
        columns : Number of even steps of phi from 0 to, not including, 2 pi.

        Returns
        -------
        (n, t, columns, 2) complex128
            F_theta and F_phi [-].
        """
        return turned_pattern(
            self.samples,
            realised_weights(self.admittance_s, self.load_ohm),
            np.asarray(theta_rad, dtype=np.float64),
            columns,
            sectors=self.basis.sectors,
            port_step=self.port_step,
        )

    def surface_currents(self, port: int) -> npt.NDArray[np.complex128]:
        """Return the surface currents at the centroids with one port driven [A/m].

        Parameters
        ----------
        port : Driven port, from 0; its source has 1 W available, the others are loaded.

        Returns
        -------
        (f, 3) complex128
            Sum of the currents on both sides of every triangle of ``basis`` [A/m], peak values.
        """
        source_v = math.sqrt(8.0 * float(self.load_ohm[port].real))
        halves = source_v * np.tensordot(
            self.embedded_voltages_v[port], self.halves_a_per_m, axes=(0, 0)
        )
        corners = self.basis.corners_m
        outward = corners.mean(axis=1, keepdims=True) - corners
        scale = halves * self.basis.edge_lengths_m / (2.0 * self.basis.areas_m2[:, None])
        currents: npt.NDArray[np.complex128] = np.einsum("fi,fic->fc", scale, outward)
        return currents
