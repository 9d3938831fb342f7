"""How well antennas are matched, and what would match them: loads, coils, capacitors.

Loads and networks are circuit theory on the admittances of the ports: nothing is solved again.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.em.reader.feeding import Cable, Feeding, Multiplexer
from octant.em.reader.fullwave._circuit import embedded_voltages, scattering
from octant.em.reader.ladders import Ladder, l_networks, pi_networks

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]

MATCHED_DB = -10.0
"""Reflection up to which a port counts as matched [dB]: a tenth of the power."""
PI_QUALITIES = tuple(np.geomspace(0.5, 8.0, 17).tolist())
"""Of the Pi-networks that are tried [-]."""
_BETTER_DB = 1e-6
_LEAST_OHM, _MOST_OHM = 1.0, 1e4
_LEAST_SHARE = 1e-3
"""Resistance over impedance [-] below which no coils and capacitors match: they have losses."""
_ROUNDS, _DAMPING, _SETTLED = 500, 0.5, 1e-10


def vswr(reflected_share: npt.ArrayLike) -> FloatArray:
    """Return the voltage standing wave ratio (1 + |Γ|) / (1 - |Γ|), inf for total reflection [-].

    Parameters
    ----------
    reflected_share : |Γ|² [-].
    """
    size = np.sqrt(np.asarray(reflected_share, dtype=np.float64))
    with np.errstate(divide="ignore"):
        return np.asarray((1.0 + size) / np.maximum(1.0 - size, 0.0))


def matched_band_hz(
    frequencies_hz: npt.ArrayLike,
    reflection_db: npt.ArrayLike,
    *,
    around_hz: float,
    level_db: float = MATCHED_DB,
) -> tuple[float, float] | None:
    """Return the ends of the band around a frequency with at most a reflection [Hz]; None: no such.

    Between the frequencies the level runs straight; a band that reaches the first or the last of
    them ends there.

    Parameters
    ----------
    frequencies_hz, reflection_db : (f,) array_like — Rising frequencies [Hz], reflection [dB].
    around_hz, level_db : Frequency that must be in it [Hz]; greatest reflection [dB].
    """
    f = np.asarray(frequencies_hz, dtype=np.float64)
    level = np.asarray(reflection_db, dtype=np.float64)
    inside = f[0] <= around_hz <= f[-1]
    if not inside or float(np.interp(around_hz, f, level)) > level_db:
        return None

    def end(order: Sequence[int], stop: float) -> float:
        last, last_db = around_hz, float(np.interp(around_hz, f, level))
        for i in order:
            if level[i] > level_db:
                share = (level_db - last_db) / (float(level[i]) - last_db)
                return last + share * (float(f[i]) - last)
            last, last_db = float(f[i]), float(level[i])
        return stop

    above = [i for i in range(len(f)) if f[i] > around_hz]
    below = [i for i in reversed(range(len(f))) if f[i] < around_hz]
    return end(below, float(f[0])), end(above, float(f[-1]))


def port_reflection_db(
    admittance_s: ComplexArray, load_ohm: npt.ArrayLike, *, off_ohm: npt.ArrayLike | None = None
) -> FloatArray:
    """Return the reflection at each port with loads on all of them, (f, n) [dB].

    Behind a network without losses it is also that at the network's other end.

    Parameters
    ----------
    admittance_s : (f, n, n) complex128 — Admittances of the ports without loads [S].
    load_ohm : (f, n) or less — Loads, also as sources of the driven port [ohm].
    off_ohm : (f, n) or less — What ends the ports that are not driven instead [ohm]; None: loads.
    """
    f, n = admittance_s.shape[:2]
    loads = np.broadcast_to(np.asarray(load_ohm, dtype=np.complex128), (f, n))
    if off_ohm is not None:
        volts, amperes = driven_alone(admittance_s, loads, off_ohm)
        size = np.abs(volts - loads.conj() * amperes)
    else:
        size = np.array(
            [
                np.abs(np.diagonal(scattering(y, load)))
                for y, load in zip(admittance_s, loads, strict=True)
            ]
        )
    return np.asarray(20.0 * np.log10(np.maximum(size, 1e-10)))


def driven_alone(
    admittance_s: ComplexArray, load_ohm: npt.ArrayLike, off_ohm: npt.ArrayLike
) -> tuple[ComplexArray, ComplexArray]:
    """Return voltage [V] and current [A] at each port, (f, n), while it is driven by one volt.

    Parameters
    ----------
    admittance_s : (f, n, n) complex128 — Admittances of the ports without loads [S].
    load_ohm, off_ohm : (f, n) or less — Impedance of the driven port's source; what ends the other
        ports meanwhile, which may be reactances alone [ohm].
    """
    f, n = admittance_s.shape[:2]
    loads = np.broadcast_to(np.asarray(load_ohm, dtype=np.complex128), (f, n))
    ends = np.broadcast_to(np.asarray(off_ohm, dtype=np.complex128), (f, n))
    one = np.eye(n)
    ended = np.where(one, loads[:, :, None], ends[:, None, :])  # frequency, driven port, port
    ended_ports = one + ended[..., None] * admittance_s[:, None]
    volts = np.linalg.solve(ended_ports, np.broadcast_to(one[..., None], (f, n, n, 1)))[..., 0]
    amperes = np.einsum("fij,fij->fi", admittance_s, volts)
    return np.diagonal(volts, axis1=1, axis2=2), amperes


def best_real_load_ohm(admittance_s: ComplexArray) -> float:
    """Return the resistance on all ports with the least of their greatest reflections [ohm].

    Parameters
    ----------
    admittance_s : (f, n, n) complex128 — Admittances at one or several frequencies [S].
    """
    from scipy.optimize import minimize_scalar

    found = minimize_scalar(
        lambda log_r: float(port_reflection_db(admittance_s, math.exp(log_r)).max()),
        bounds=(math.log(_LEAST_OHM), math.log(_MOST_OHM)),
        method="bounded",
        options={"xatol": 1e-6},
    )
    return math.exp(float(found.x))


def conjugate_match_ohm(admittance_s: ComplexArray) -> ComplexArray | None:
    """Return (n,) the impedances that ports show when each is ended by its conjugate [ohm].

    Parameters
    ----------
    admittance_s : (n, n) complex128 — Admittances of the ports without loads [S].

    Returns
    -------
    (n,) complex128 or None
        None where the loads do not settle, or of ports that hardly do more than react.
    """
    ended = np.conj(1.0 / np.diagonal(admittance_s))
    ended = np.maximum(ended.real, _LEAST_OHM) + 1j * ended.imag
    for _ in range(_ROUNDS):
        voltage = embedded_voltages(admittance_s, ended)
        current = np.diagonal(voltage @ admittance_s.T)
        seen = np.diagonal(voltage) / current
        if not (np.isfinite(seen).all() and (seen.real > 0.0).all()):
            return None
        off = np.conj(seen) - ended
        if float(np.abs(off / seen).max()) < _SETTLED:
            return None if (seen.real < _LEAST_SHARE * np.abs(seen)).any() else np.asarray(seen)
        ended = ended + _DAMPING * off
    return None


@dataclass(frozen=True, slots=True, kw_only=True)
class OffState:
    """What a multiplexer does with the antennas that are not connected.

    Parameters
    ----------
    off_ohm : What it ends them with [ohm].
    cable : What lies between each antenna's network and the multiplexer; None: no length.
    """

    off_ohm: complex
    cable: Cable | None = None

    def seen_ohm(self, frequency_hz: npt.ArrayLike) -> ComplexArray:
        """Return what the networks of those antennas are ended with [ohm].

        Parameters
        ----------
        frequency_hz : Frequency [Hz].
        """
        f = np.asarray(frequency_hz, dtype=np.float64)
        if self.cable is None:
            return np.full(f.shape, self.off_ohm, dtype=np.complex128)
        seen = [self.cable.seen_ohm(float(one), self.off_ohm) for one in f.ravel()]
        return np.array(seen).reshape(f.shape)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Match:
    """Networks without losses, one at each port of a reader.

    Parameters
    ----------
    networks, source_ohm : Of the ports in order; resistance of source and load behind them [ohm].
    off : How a multiplexer leaves the antennas that are not connected; None: each has a receiver.
    """

    networks: tuple[Ladder, ...]
    source_ohm: float
    off: OffState | None = None

    def reflection_db(
        self, admittance_s: ComplexArray, frequencies_hz: npt.ArrayLike
    ) -> FloatArray:
        """Return the reflection at the networks' other ends, (f, n) [dB].

        Parameters
        ----------
        admittance_s, frequencies_hz : (f, n, n) admittances [S] at frequencies, (f,) [Hz].
        """
        loads = self._ended_ohm(frequencies_hz, self.source_ohm)
        if self.off is None:
            return port_reflection_db(admittance_s, loads)
        off_ohm = self._ended_ohm(frequencies_hz, self.off.seen_ohm(frequencies_hz))
        return port_reflection_db(admittance_s, loads, off_ohm=off_ohm)

    def seen_ohm(self, admittance_s: ComplexArray, frequency_hz: float) -> ComplexArray:
        """Return (n,) the impedances that the connected antennas show at one frequency [ohm].

        Parameters
        ----------
        admittance_s, frequency_hz : (n, n) admittances [S] at a frequency [Hz].
        """
        behind = self.source_ohm if self.off is None else self.off.seen_ohm(frequency_hz)
        off_ohm = self._ended_ohm(frequency_hz, behind)
        volts, amperes = driven_alone(admittance_s[None], self.source_ohm, off_ohm)
        seen: ComplexArray = volts[0] / amperes[0]
        return seen

    def _ended_ohm(self, frequencies_hz: npt.ArrayLike, behind_ohm: npt.ArrayLike) -> ComplexArray:
        """Return (..., n) what the networks end the antennas with [ohm]."""
        ended = {
            str(network): network.seen_by_antenna_ohm(frequencies_hz, source_ohm=behind_ohm)
            for network in self.different
        }
        return np.stack([ended[str(network)] for network in self.networks], axis=-1)

    def feeding(self, *, multiplexer_loss_db: float = 0.0) -> Feeding:
        """Return the same as what lies between antennas and receivers.

        Parameters
        ----------
        multiplexer_loss_db : Loss of the multiplexer, if there is one [dB].
        """
        feeding = Feeding(loads_ohm=(complex(self.source_ohm),), ladders=self.networks)
        if self.off is None:
            return feeding
        multiplexer = Multiplexer(loss_db=multiplexer_loss_db, off_ohm=self.off.off_ohm)
        return replace(feeding, cable=self.off.cable, multiplexer=multiplexer)

    @property
    def nearest_e24(self) -> "Match":
        """The same with the nearest values of the E24 series."""
        return replace(self, networks=tuple(network.nearest_e24 for network in self.networks))

    @property
    def different(self) -> tuple[Ladder, ...]:
        """The networks that differ in what is written of them."""
        return tuple({str(network): network for network in self.networks}.values())

    def exchanged(self, old: Ladder, new: Ladder) -> "Match":
        """Return the same with another network wherever one stands.

        Parameters
        ----------
        old, new : Networks.
        """
        networks = tuple(new if str(one) == str(old) else one for one in self.networks)
        return replace(self, networks=networks)

    @property
    def alike(self) -> "Match":
        """The same kind of network at all ports, of the geometric means of their parts."""
        parts = []
        for each in zip(*(network.parts for network in self.networks), strict=True):
            mean = math.exp(sum(math.log(part.value) for _, part in each) / len(each))
            parts.append(replace(each[0][1], value=mean))
        one = self.networks[0].of_parts(tuple(parts))
        return replace(self, networks=(one,) * len(self.networks))

    def bought(self, admittance_s: ComplexArray, frequencies_hz: npt.ArrayLike) -> "Match":
        """Return networks of E24 values with the least of their greatest reflections over a band.

        From the nearest values part by part to those beside them, as long as that is better.

        Parameters
        ----------
        admittance_s, frequencies_hz : (f, n, n) admittances [S] at frequencies, (f,) [Hz].
        """
        best = self.nearest_e24
        worst_db = float(best.reflection_db(admittance_s, frequencies_hz).max())
        better = True
        while better:
            better = False
            for tried in best.neighbours():
                level_db = float(tried.reflection_db(admittance_s, frequencies_hz).max())
                if level_db < worst_db - _BETTER_DB:
                    best, worst_db, better = tried, level_db, True
                    break
        return best

    def neighbours(self) -> "Iterator[Match]":
        """Yield the same with one part of one kind of network a step of the E24 series off."""
        for network in self.different:
            for place in range(len(network.parts)):
                for step in (1, -1):
                    parts = [part for _, part in network.parts]
                    parts[place] = parts[place].e24(step)
                    yield self.exchanged(network, network.of_parts(tuple(parts)))

    def worst_db(
        self, admittance_s: ComplexArray, frequencies_hz: npt.ArrayLike, *, tolerance: float
    ) -> FloatArray:
        """Return the greatest reflection of all ports with parts at the ends of tolerance [dB].

        All antennas have the same errors: the reflection of one hardly knows the others' parts.

        Parameters
        ----------
        admittance_s, frequencies_hz : (f, n, n) admittances [S] at frequencies, (f,) [Hz].
        tolerance : Greatest relative error of a part [-].
        """
        each = zip(*(network.corners(tolerance) for network in self.networks), strict=True)
        levels = [
            replace(self, networks=corner).reflection_db(admittance_s, frequencies_hz).max(axis=1)
            for corner in each
        ]
        return np.asarray(np.max(levels, axis=0))


def match_reader(
    admittance_s: ComplexArray, frequencies_hz: npt.ArrayLike, *, at_hz: float, source_ohm: float
) -> Match | None:
    """Return networks that match all ports at once at one frequency; None without any.

    Of the kinds of L-network that all ports can have, that with the least reflection over the band;
    where that is above `MATCHED_DB`, of Pi-networks too.

    Parameters
    ----------
    admittance_s : (f, n, n) complex128 — Admittances of the ports over the band [S].
    frequencies_hz, at_hz, source_ohm : (f,) [Hz]; one of them [Hz]; source and load [ohm].
    """
    f = np.atleast_1d(np.asarray(frequencies_hz, dtype=np.float64))
    seen = conjugate_match_ohm(admittance_s[int(np.abs(f - at_hz).argmin())])
    if seen is None:
        return None

    def worst_db(match: Match) -> float:
        return float(match.reflection_db(admittance_s, f).max())

    ends = {"source_ohm": source_ohm, "frequency_hz": at_hz}
    matches = list(_alike([l_networks(complex(z), **ends) for z in seen], source_ohm))
    best = min(matches, key=worst_db, default=None)
    if best is not None and (len(f) == 1 or worst_db(best) <= MATCHED_DB):
        return best
    for quality in PI_QUALITIES:
        found = [pi_networks(complex(z), quality=quality, **ends) for z in seen]
        matches += _alike(found, source_ohm)
    return min(matches, key=worst_db, default=None)


def _alike(of_ports: Sequence[tuple[Ladder, ...]], source_ohm: float) -> Iterator[Match]:
    """Yield a match for each kind of network that all ports can have."""
    for networks in networks_by_kind(of_ports).values():
        yield Match(networks=networks, source_ohm=source_ohm)


def networks_by_kind(
    of_ports: Sequence[tuple[Ladder, ...]],
) -> dict[tuple[object, int], tuple[Ladder, ...]]:
    """Return the networks of all ports by their kind, for those kinds that all ports can have.

    Parameters
    ----------
    of_ports : The networks that each port can have; of two of a kind, the first is alike with the
        others' first.
    """
    by_kind: dict[tuple[object, int], list[Ladder]] = {}
    for networks in of_ports:
        kinds = [network.kind for network in networks]
        for i, network in enumerate(networks):
            by_kind.setdefault((network.kind, kinds[:i].count(network.kind)), []).append(network)
    return {kind: tuple(all_) for kind, all_ in by_kind.items() if len(all_) == len(of_ports)}
