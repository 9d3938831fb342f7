"""What lies between a reader's antennas and its receiver, as scattering matrices at one frequency.

A state of the feed has one antenna connected to the receiver. Everything is network algebra on the
ports of a solution, reciprocal and passive; nothing is solved again.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.em.reader.fullwave._circuit import scattering
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import AntennaError

ComplexArray = npt.NDArray[np.complex128]

REFERENCE_OHM = 50.0
"""To which the waves inside of a feed refer [ohm]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Feeds:
    """A feed at one frequency, in each of its states; waves refer to `REFERENCE_OHM`.

    Parameters
    ----------
    lines : (n, 2, 2) complex128 — S-matrix of each antenna's own network and cable [-]: first port
        at the antenna.
    states : (n, n + 1, n + 1) complex128 — S-matrix of what ends the lines [-], a state a row with
        that antenna connected: first port at the receiver, then one at each line.
    receiver_ohm : (n,) complex128 — Impedance of the receiver in each state [ohm].
    """

    lines: ComplexArray
    states: ComplexArray
    receiver_ohm: ComplexArray

    def __post_init__(self) -> None:
        n = len(self.lines)
        for name, shape in (
            ("lines", (n, 2, 2)),
            ("states", (n, n + 1, n + 1)),
            ("receiver_ohm", (n,)),
        ):
            value = frozen_array(
                getattr(self, name), name=name, shape=shape, dtype=np.complex128, error=AntennaError
            )
            object.__setattr__(self, name, value)

    @property
    def whole(self) -> ComplexArray:
        """Return (n, n + 1, n + 1) the S-matrices from the receiver to the antennas' ports [-]."""
        there, here = self.lines[:, 0, 1], self.lines[:, 1, 1]
        back, front = self.lines[:, 1, 0], self.lines[:, 0, 0]
        one = np.eye(len(here))
        found = np.empty_like(self.states)
        for state, made in zip(self.states, found, strict=True):
            inner = state[1:, 1:]
            outward = np.linalg.inv(one - inner * here)  # waves from the switch into the lines
            made[0, 0] = state[0, 0] + (state[0, 1:] * here) @ outward @ state[1:, 0]
            made[1:, 0] = there * (outward @ state[1:, 0])
            arriving = np.linalg.inv(one - here[:, None] * inner) * back
            made[0, 1:] = state[0, 1:] @ arriving
            made[1:, 1:] = np.diag(front) + there[:, None] * (inner @ arriving)
        return found

    def driven(self, admittance_s: ComplexArray) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """Return what a source of one volt behind the receiver's impedance does, state by state.

        Parameters
        ----------
        admittance_s : (n, n) complex128 — Currents at the antennas per volt at each [S].

        Returns
        -------
        tuple of (n, n), (n,), (n,) complex128
            Voltages at all antennas [V], a row a state; voltage [V] and current [A] at the
            receiver.
        """
        n = len(admittance_s)
        array = scattering(admittance_s, np.full(n, REFERENCE_OHM + 0j))
        one, root = np.eye(n), np.sqrt(REFERENCE_OHM)
        voltages = np.empty((n, n), dtype=np.complex128)
        at_receiver = np.empty((2, n), dtype=np.complex128)
        for j, (state, z) in enumerate(zip(self.whole, self.receiver_ohm, strict=True)):
            to_array = np.linalg.solve(one - state[1:, 1:] @ array, state[1:, 0])
            back = state[0, 0] + state[0, 1:] @ array @ to_array
            reflected = (z - REFERENCE_OHM) / (z + REFERENCE_OHM)
            forward = root / (REFERENCE_OHM + z) / (1.0 - reflected * back)
            voltages[j] = forward * root * ((one + array) @ to_array)
            at_receiver[:, j] = forward * root * (1.0 + back), forward / root * (1.0 - back)
        return voltages, at_receiver[0], at_receiver[1]

    def outer_scattering(self, admittance_s: ComplexArray) -> ComplexArray:
        """Return (n, n) the S-matrix at the lines' far ends, referred to the receiver [-].

        Parameters
        ----------
        admittance_s : (n, n) complex128 — Currents at the antennas per volt at each [S].
        """
        n = len(admittance_s)
        one = np.eye(n)
        array = scattering(admittance_s, np.full(n, REFERENCE_OHM + 0j))
        outgoing = np.linalg.solve(one - array * self.lines[:, 0, 0], array * self.lines[:, 0, 1])
        inside = np.diag(self.lines[:, 1, 1]) + self.lines[:, 1, 0][:, None] * outgoing
        return renormalised(inside, np.full(n, REFERENCE_OHM + 0j), self.receiver_ohm)


def renormalised(
    s_matrix: ComplexArray, old_ohm: ComplexArray, new_ohm: ComplexArray
) -> ComplexArray:
    """Return (n, n) an S-matrix of power waves referred to other impedances [-].

    Parameters
    ----------
    s_matrix : (n, n) complex128 — S-matrix [-].
    old_ohm, new_ohm : (n,) complex128 — Impedances that its ports refer to, and are to [ohm].
    """
    one, root = np.eye(len(s_matrix)), np.sqrt(old_ohm.real)[:, None]
    voltage = (np.diag(old_ohm.conj()) + old_ohm[:, None] * s_matrix) / root
    current = (one - s_matrix) / root
    scale = 2.0 * np.sqrt(new_ohm.real)[:, None]
    incident = (voltage + new_ohm[:, None] * current) / scale
    leaving = (voltage - new_ohm.conj()[:, None] * current) / scale
    matrix: npt.NDArray[Any] = np.linalg.solve(incident.T, leaving.T).T
    return matrix


def of_chain(chain: ComplexArray) -> ComplexArray:
    """Return the S-matrix (2, 2) of a chain matrix, at `REFERENCE_OHM` [-].

    Parameters
    ----------
    chain : (2, 2) complex128 — V1 = A V2 + B I2, I1 = C V2 + D I2 [1, ohm; S, 1].
    """
    a, b, c, d = chain[0, 0], chain[0, 1] / REFERENCE_OHM, chain[1, 0] * REFERENCE_OHM, chain[1, 1]
    whole = a + b + c + d
    determinant = chain[0, 0] * chain[1, 1] - chain[0, 1] * chain[1, 0]
    waves: ComplexArray = np.array([[a + b - c - d, 2.0 * determinant], [2.0, -a + b - c + d]])
    waves /= whole
    return waves


def in_line(first: ComplexArray, second: ComplexArray) -> ComplexArray:
    """Return the S-matrix (2, 2) of two two-ports in line, of equal references [-].

    Parameters
    ----------
    first, second : (2, 2) complex128 — That at the antenna; that behind it [-].
    """
    loop = 1.0 - first[1, 1] * second[0, 0]
    return np.array(
        [
            [
                first[0, 0] + first[0, 1] * second[0, 0] * first[1, 0] / loop,
                first[0, 1] * second[0, 1] / loop,
            ],
            [
                second[1, 0] * first[1, 0] / loop,
                second[1, 1] + second[1, 0] * first[1, 1] * second[0, 1] / loop,
            ],
        ]
    )
