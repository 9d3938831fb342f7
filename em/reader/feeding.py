"""What lies between a reader's antennas and its receiver, as one orders it; at any frequency.

Loads, networks of coils and capacitors, two-ports from files, cables and a multiplexer. All of it
is put on a solution by network algebra: nothing is solved again.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave.feeds import REFERENCE_OHM, Feeds, in_line, of_chain
from octant.em.reader.fullwave.loads import LoadedReader
from octant.em.reader.fullwave.port_files import (
    loads_of_file,
    reflection_of_file,
    two_port_of_file,
)
from octant.em.reader.ladders import Ladder
from octant.geometries.errors import AntennaError

ComplexArray = npt.NDArray[np.complex128]

Solution = TypeVar("Solution", bound=LoadedReader)
Item = TypeVar("Item")

_PASSIVE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Cable:
    """A cable of equal loss per length; its loss grows with the root of the frequency.

    Parameters
    ----------
    length_m : Length [m].
    loss_db_per_m, loss_at_hz : Loss [dB/m], and the frequency at which it has it [Hz].
    velocity : Speed of its wave over that of light [-].
    impedance_ohm : Wave impedance, real [ohm].
    """

    length_m: float
    loss_db_per_m: float = 0.0
    loss_at_hz: float = 2.4e9
    velocity: float = 0.7
    impedance_ohm: float = 50.0

    def chain(self, frequency_hz: float) -> ComplexArray:
        """Return the chain matrix (2, 2) at a frequency [1, ohm; S, 1].

        Parameters
        ----------
        frequency_hz : Frequency [Hz].
        """
        loss_db = self.loss_db_per_m * math.sqrt(frequency_hz / self.loss_at_hz)
        phase = 2.0 * math.pi * frequency_hz / (self.velocity * SPEED_OF_LIGHT_M_PER_S)
        way = (loss_db * math.log(10.0) / 20.0 + 1j * phase) * self.length_m
        cosh, sinh, z = np.cosh(way), np.sinh(way), self.impedance_ohm
        return np.array([[cosh, z * sinh], [sinh / z, cosh]])

    def seen_ohm(self, frequency_hz: float, end_ohm: complex) -> complex:
        """Return the impedance at one end, the other ended by another [ohm].

        Parameters
        ----------
        frequency_hz, end_ohm : Frequency [Hz]; what ends it [ohm].
        """
        (a, b), (c, d) = self.chain(frequency_hz)
        return complex((a * end_ohm + b) / (c * end_ohm + d))


@dataclass(frozen=True, slots=True, kw_only=True)
class Multiplexer:
    """A switch that connects one antenna after the other to a single receiver.

    Parameters
    ----------
    loss_db : Loss of the connected way [dB]; the switch itself is matched to 50 ohm.
    leakage_db : Level [dB] at which each other antenna's wave reaches the receiver, in phase with
        the connected one, which is about the worst; None: none does. Counted to the first order:
        up to -20 dB.
    off_ohm : What ends the ways that are not connected [ohm]; 0 is a short.
    off_file : Touchstone file of one port that says it instead.
    """

    loss_db: float
    leakage_db: float | None = None
    off_ohm: complex = 50.0
    off_file: str | None = None

    def states(self, frequency_hz: float, ports: int) -> ComplexArray:
        """Return the S-matrices (n, n + 1, n + 1) of all states, receiver first [-].

        Parameters
        ----------
        frequency_hz, ports : Frequency [Hz]; number of antennas.
        """
        off = (self.off_ohm - REFERENCE_OHM) / (self.off_ohm + REFERENCE_OHM)
        if self.off_file is not None:
            off = reflection_of_file(self.off_file, frequency_hz)
        leak = 0.0 if self.leakage_db is None else 10.0 ** (self.leakage_db / 20.0)
        states = np.zeros((ports, ports + 1, ports + 1), dtype=np.complex128)
        for j, state in enumerate(states):
            state[0, 1:] = state[1:, 0] = leak
            state[0, j + 1] = state[j + 1, 0] = 10.0 ** (-self.loss_db / 20.0)
            np.fill_diagonal(state[1:, 1:], off)
            state[j + 1, j + 1] = 0.0
        passed = float((np.abs(states[0, 0]) ** 2).sum())
        if passed > 1.0 + _PASSIVE:
            msg = (
                f"a multiplexer of {self.loss_db:g} dB loss and {self.leakage_db:g} dB leakage "
                f"would pass {100.0 * passed:.4g} % of what {ports} antennas receive together; "
                "raise its loss or lower its leakage."
            )
            raise AntennaError(msg)
        return states


@dataclass(frozen=True, slots=True, kw_only=True)
class Feeding:
    """All that lies between a reader's antennas and its receiver, in this order.

    Parameters
    ----------
    loads_ohm : Impedance of the receiver, one for all antennas or one each [ohm].
    load_file : Touchstone file that says it instead.
    ladders : Networks of coils and capacitors at the antennas, one for all or one each; nothing:
        none.
    network_files : Touchstone files of two-ports behind them, first port towards the antenna, one
        for all or one each.
    cable : The cable of each antenna; None: no length.
    multiplexer : None: each antenna has a receiver of its own.
    """

    loads_ohm: tuple[complex, ...]
    load_file: str | None = None
    ladders: tuple[Ladder, ...] = ()
    network_files: tuple[str, ...] = ()
    cable: Cable | None = None
    multiplexer: Multiplexer | None = None

    def loads_at(self, frequency_hz: float, ports: int) -> ComplexArray:
        """Return the impedance of the receiver in each state, (n,) [ohm].

        Parameters
        ----------
        frequency_hz, ports : Frequency [Hz]; number of antennas.
        """
        if self.load_file is not None:
            return loads_of_file(Path(self.load_file), frequency_hz, ports=ports)
        return np.array(_each(self.loads_ohm, ports), dtype=np.complex128)

    def feeds_at(self, frequency_hz: float, ports: int) -> Feeds | None:
        """Return the feed at a frequency; None where the receivers are at the antennas.

        Parameters
        ----------
        frequency_hz, ports : Frequency [Hz]; number of antennas.
        """
        plain = not (self.ladders or self.network_files or self.cable)
        if plain and self.multiplexer is None:
            return None
        loads = self.loads_at(frequency_hz, ports)
        ladders = self.ladders or (Ladder(parts=()),)
        chains = tuple(ladder.chain(frequency_hz) for ladder in ladders)
        lines = [of_chain(chain) for chain in _each(chains, ports)]
        if self.network_files:
            files = {name: two_port_of_file(name, frequency_hz) for name in self.network_files}
            names = _each(self.network_files, ports)
            lines = [in_line(s, files[name]) for s, name in zip(lines, names, strict=True)]
        if self.cable is not None:
            cable = of_chain(self.cable.chain(frequency_hz))
            lines = [in_line(s, cable) for s in lines]
        if self.multiplexer is None:
            states = _own_receivers(loads)
        else:
            states = self.multiplexer.states(frequency_hz, ports)
        return Feeds(lines=np.array(lines), states=states, receiver_ohm=loads)

    def on(self, solution: Solution) -> Solution:
        """Return a solution with this between its antennas and the receiver.

        Parameters
        ----------
        solution : Any; its own loads and feeds do not count.
        """
        place = (solution.frequency_hz, solution.ports)
        return replace(solution, load_ohm=self.loads_at(*place), feeds=self.feeds_at(*place))


def _own_receivers(loads_ohm: ComplexArray) -> ComplexArray:
    """Return the states (n, n + 1, n + 1) of antennas with a receiver each [-]."""
    n = len(loads_ohm)
    states = np.zeros((n, n + 1, n + 1), dtype=np.complex128)
    ended = (loads_ohm - REFERENCE_OHM) / (loads_ohm + REFERENCE_OHM)
    for j, state in enumerate(states):
        np.fill_diagonal(state[1:, 1:], ended)
        state[j + 1, j + 1] = 0.0
        state[0, j + 1] = state[j + 1, 0] = 1.0
    return states


def _each(items: tuple[Item, ...], ports: int) -> tuple[Item, ...]:
    """Return one item a port, a single one repeated."""
    return items * ports if len(items) == 1 else items
