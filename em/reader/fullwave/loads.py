"""A solved reader's ports: without loads, which is what is kept, and with any loads put on them.

Loads are circuit theory: the admittances without loads and the fields of one volt at each port,
the others shorted, give everything for all of them.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.em.blocks import one_blas_thread
from octant.em.reader.fullwave._circuit import (
    embedded_voltages,
    powers_of,
    realised_scale,
    scattering,
)
from octant.em.reader.fullwave.far_field import FarField
from octant.em.reader.fullwave.feeds import Feeds
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import AntennaError

BELOW_RAD = 0.5 * np.pi + 1e-9
"""Theta beyond which a direction points below an infinite plane [rad]."""

BALANCE_LIMIT = 1e-3
"""Radiated and lost power less accepted power, over the latter [-], above which a run warns."""


def checked_loads(load_ohm: npt.ArrayLike, ports: int) -> npt.NDArray[np.complex128]:
    """Return (ports,) the loads [ohm], one value repeated for all; refuse those that take no power.

    Parameters
    ----------
    load_ohm, ports : One load or one for each port [ohm]; number of ports.
    """
    given = np.asarray(load_ohm, dtype=np.complex128)
    if not (np.isfinite(given).all() and (given.real > 0.0).all()):
        msg = f"load_ohm is {load_ohm!r} ohm, but every load must have a resistance above 0 ohm."
        raise AntennaError(msg)
    loads = np.broadcast_to(given, (ports,))
    return frozen_array(loads, name="load_ohm", shape=(ports,), dtype=np.complex128)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class UnloadedReader:
    """What a solution knows of n ports before loads are put on them.

    Parameters
    ----------
    frequency_hz : Frequency [Hz].
    admittance_s : (n, n) complex128 — Currents at the ports per volt at each [S].
    heat_s : (n, n) complex128 — Matrix H of twice the heat v* H v in lossy sheets, for port
        voltages v [S].
    shorted_v : Far fields times distance of one volt at each port, the others shorted [V].
    phase_centres_m : (n, 3) float64 — Middle of each dipole, foot of each monopole [m].
    unknowns : Number of independent functions solved for.
    doubts : What makes the solution doubtful, whatever the loads.
    half_space : The far fields go on below an infinite plane, z = 0, as if its images were there;
        they count above it only.
    """

    frequency_hz: float
    admittance_s: npt.NDArray[np.complex128]
    heat_s: npt.NDArray[np.complex128]
    shorted_v: FarField
    phase_centres_m: npt.NDArray[np.float64]
    unknowns: int
    doubts: tuple[str, ...] = ()
    half_space: bool = False

    def __post_init__(self) -> None:
        n = len(self.admittance_s)
        for name, shape, dtype in (
            ("admittance_s", (n, n), np.complex128),
            ("heat_s", (n, n), np.complex128),
            ("phase_centres_m", (n, 3), np.float64),
        ):
            value = frozen_array(
                getattr(self, name), name=name, shape=shape, dtype=dtype, error=AntennaError
            )
            object.__setattr__(self, name, value)
        if len(self.shorted_v.values) != n:
            msg = f"shorted_v has {len(self.shorted_v.values)} fields, but there are {n} ports."
            raise AntennaError(msg)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoadedReader:
    """Matrices, patterns and powers of n antennas on a metal body, with loads on all ports.

    Parameters
    ----------
    unloaded : The ports without loads.
    load_ohm : (n,) complex128 — Impedance of every port's source and load [ohm], its resistance
        above 0; one value serves all.
    feeds : What lies between the antennas and their receiver, whose impedance then is ``load_ohm``;
        None: each antenna has its load at its port.
    """

    unloaded: UnloadedReader
    load_ohm: npt.NDArray[np.complex128]
    feeds: Feeds | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "load_ohm", checked_loads(self.load_ohm, self.ports))

    @property
    def frequency_hz(self) -> float:
        """Frequency [Hz]."""
        return self.unloaded.frequency_hz

    @property
    def admittance_s(self) -> npt.NDArray[np.complex128]:
        """Return (n, n) the currents at the ports per volt at each, without loads [S]."""
        return self.unloaded.admittance_s

    @property
    def ports(self) -> int:
        """Number of ports."""
        return len(self.unloaded.admittance_s)

    @property
    def unknowns(self) -> int:
        """Number of independent functions."""
        return self.unloaded.unknowns

    @property
    def impedance_ohm(self) -> npt.NDArray[np.complex128]:
        """Return (n, n) the open-circuit impedance matrix Z [ohm]."""
        inverse: npt.NDArray[Any] = np.linalg.inv(self.admittance_s)
        return inverse

    @property
    def s_matrix(self) -> npt.NDArray[np.complex128]:
        """Return (n, n) the scattering matrix of power waves, ports referred to their loads [-].

        Behind networks and cables it is that at their far ends, before a multiplexer.
        """
        if self.feeds is not None:
            return self.feeds.outer_scattering(self.admittance_s)
        return scattering(self.admittance_s, self.load_ohm)

    @property
    def embedded_voltages_v(self) -> npt.NDArray[np.complex128]:
        """Return (n, n) port voltages, a row for each port driven by a source of one volt [V]."""
        if self.feeds is not None:
            return self.feeds.driven(self.admittance_s)[0]
        return embedded_voltages(self.admittance_s, self.load_ohm)

    @property
    def realised_weights(self) -> npt.NDArray[np.complex128]:
        """Return (n, n) factors from fields of one volt at each port to realised patterns [1/V]."""
        weights: npt.NDArray[np.complex128] = (
            realised_scale(self.load_ohm)[:, None] * self.embedded_voltages_v
        )
        return weights

    @property
    def input_impedance_ohm(self) -> npt.NDArray[np.complex128]:
        """Return (n,) the impedance seen by each source, the other ports loaded [ohm]."""
        if self.feeds is not None:
            _, volts, amperes = self.feeds.driven(self.admittance_s)
            at_receiver: npt.NDArray[np.complex128] = volts / amperes
            return at_receiver
        voltage = self.embedded_voltages_v
        current = np.diagonal(voltage @ self.admittance_s.T)
        seen: npt.NDArray[np.complex128] = np.diagonal(voltage) / current
        return seen

    @property
    def reflected_share(self) -> npt.NDArray[np.float64]:
        """Return (n,) the share of the available power that returns to each driven source [-]."""
        if self.feeds is not None:
            _, volts, amperes = self.feeds.driven(self.admittance_s)
            returned: npt.NDArray[np.float64] = np.abs(volts - self.load_ohm.conj() * amperes) ** 2
            return returned
        reflected: npt.NDArray[np.float64] = np.abs(np.diagonal(self.s_matrix)) ** 2
        return reflected

    @property
    def coupled_share(self) -> npt.NDArray[np.float64]:
        """Return (n,) the share that ends in the other ports' loads, and in what feeds them [-]."""
        if self.feeds is not None:
            return 1.0 - self.reflected_share - self.accepted_share
        everything = (np.abs(self.s_matrix) ** 2).sum(axis=0)
        coupled: npt.NDArray[np.float64] = everything - self.reflected_share
        return coupled

    @property
    def accepted_share(self) -> npt.NDArray[np.float64]:
        """Return (n,) the share that neither returns to the source nor ends in loads [-]."""
        if self.feeds is not None:
            voltages = self.embedded_voltages_v
            return 4.0 * self.load_ohm.real * powers_of(self.admittance_s, voltages)
        accepted: npt.NDArray[np.float64] = 1.0 - (np.abs(self.s_matrix) ** 2).sum(axis=0)
        return accepted

    @property
    def radiated_share(self) -> npt.NDArray[np.float64]:
        """Return (n,) the radiated over the available power, from the far field [-]."""
        share = 0.5 if self.unloaded.half_space else 1.0
        return share * powers_of(self.unloaded.shorted_v.power_matrix(), self.realised_weights)

    @property
    def lost_share(self) -> npt.NDArray[np.float64]:
        """Return (n,) the share of the available power that heats sheets [-]."""
        return 4.0 * self.load_ohm.real * powers_of(self.unloaded.heat_s, self.embedded_voltages_v)

    @property
    def radiation_efficiency(self) -> npt.NDArray[np.float64]:
        """Return (n,) the radiated power over what is radiated or heats sheets and hybrids [-]."""
        radiated = self.radiated_share
        return radiated / (radiated + self.lost_share)

    @property
    def balance_error(self) -> float:
        """Greatest of |radiated + lost - accepted| over accepted power [-]."""
        accepted = self.accepted_share
        off = self.radiated_share + self.lost_share - accepted
        return float(np.abs(off / accepted).max())

    @property
    def warnings(self) -> tuple[str, ...]:
        """What makes the result doubtful."""
        error = self.balance_error
        if error <= BALANCE_LIMIT:
            return self.unloaded.doubts
        doubt = (
            f"radiated and accepted power differ by {100.0 * error:.2g} %, more than "
            f"{100.0 * BALANCE_LIMIT:g} %: the mesh is too coarse somewhere"
        )
        return (*self.unloaded.doubts, doubt)

    @one_blas_thread()
    def pattern_grid(self, theta_rad: npt.ArrayLike, columns: int) -> npt.NDArray[np.complex128]:
        """Return the embedded realised patterns on a grid, within 1e-8 of their maximum [-].

        Parameters
        ----------
        theta_rad : (t,) array_like — Values of theta [rad].
        columns : Number of even steps of phi from 0 to, not including, 2 pi.

        Returns
        -------
        (n, t, columns, 2) complex128
            F_theta and F_phi [-], |F|^2 = realised gain for a source of the port's load impedance,
            the other ports loaded; phase at the ground plane's centre, source of phase 0, factor
            exp(-jkR) / R dropped. Read the other way, |F|^2 is what arrives at the receiver.
        """
        loaded = np.tensordot(self.realised_weights, self.unloaded.shorted_v.values, axes=(1, 0))
        pattern = FarField(values=loaded).on_grid(theta_rad, columns)
        if self.unloaded.half_space:
            pattern[:, np.asarray(theta_rad) > BELOW_RAD] = 0.0
        return pattern

    @one_blas_thread()
    def pattern_towards(
        self, theta_rad: npt.NDArray[np.float64], phi_rad: npt.NDArray[np.float64]
    ) -> npt.NDArray[np.complex128]:
        """Return the patterns of `pattern_grid` towards single directions, (n, d, 2) [-].

        Parameters
        ----------
        theta_rad, phi_rad : (d,) float64 — Directions [rad].
        """
        fields = self.unloaded.shorted_v.towards(theta_rad, phi_rad)
        patterns: npt.NDArray[np.complex128] = np.tensordot(
            self.realised_weights, fields, axes=(1, 0)
        )
        if self.unloaded.half_space:
            patterns[:, theta_rad > BELOW_RAD] = 0.0
        return patterns
