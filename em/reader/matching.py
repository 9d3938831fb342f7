"""How well antennas are matched, and what would match them: other loads, L-networks.

Loads and networks are circuit theory on the admittances of the ports: nothing is solved again.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from octant.em.reader.fullwave._circuit import embedded_voltages, scattering
from octant.geometries._checks import positive_number
from octant.geometries.errors import AntennaError

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]

MATCHED_DB = -10.0
"""Reflection up to which a port counts as matched [dB]: a tenth of the power."""
E24 = (
    10,
    11,
    12,
    13,
    15,
    16,
    18,
    20,
    22,
    24,
    27,
    30,
    33,
    36,
    39,
    43,
    47,
    51,
    56,
    62,
    68,
    75,
    82,
    91,
)
"""Steps of a decade of the E24 series, IEC 60063 [-]."""
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A coil or a capacitor without losses.

    Parameters
    ----------
    kind, value : ``L`` [H] or ``C`` [F].
    """

    kind: Literal["L", "C"]
    value: float

    @classmethod
    def of_reactance(cls, reactance_ohm: float, frequency_hz: float) -> "Part":
        """Return the part that has a reactance at a frequency.

        Parameters
        ----------
        reactance_ohm, frequency_hz : Positive of a coil, negative of a capacitor [ohm]; [Hz].
        """
        omega = 2.0 * math.pi * frequency_hz
        if reactance_ohm >= 0.0:
            return cls(kind="L", value=reactance_ohm / omega)
        return cls(kind="C", value=-1.0 / (omega * reactance_ohm))

    def impedance_ohm(self, frequency_hz: npt.ArrayLike) -> ComplexArray:
        """Return its impedance [ohm].

        Parameters
        ----------
        frequency_hz : Frequency [Hz].
        """
        s = 2j * math.pi * np.asarray(frequency_hz, dtype=np.float64)
        return np.asarray(s * self.value if self.kind == "L" else 1.0 / (s * self.value))

    @property
    def nearest_e24(self) -> "Part":
        """The same with the nearest value of the E24 series, by ratio."""
        decade = 10.0 ** math.floor(math.log10(self.value))
        steps = [decade * step / 10.0 for step in (*E24, 100)]
        near = min(steps, key=lambda step: abs(math.log(step / self.value)))
        return Part(kind=self.kind, value=near)

    def __str__(self) -> str:
        scale, unit = (1e9, "nH") if self.kind == "L" else (1e12, "pF")
        return f"{scale * self.value:.3g} {unit}"


@dataclass(frozen=True, slots=True, kw_only=True)
class LNetwork:
    """Two parts between a source and an antenna: one in series, one across.

    Parameters
    ----------
    series, shunt : The parts.
    shunt_at : Whether the part across lies at the ``antenna`` or at the ``source``.
    """

    series: Part
    shunt: Part
    shunt_at: Literal["antenna", "source"]

    def seen_by_antenna_ohm(
        self, frequency_hz: npt.ArrayLike, *, source_ohm: float
    ) -> ComplexArray:
        """Return the impedance at the antenna's end, the other ended by the source [ohm].

        Parameters
        ----------
        frequency_hz, source_ohm : Frequency [Hz]; resistance of the source [ohm].
        """
        series = self.series.impedance_ohm(frequency_hz)
        shunt = self.shunt.impedance_ohm(frequency_hz)
        if self.shunt_at == "antenna":
            return np.asarray(1.0 / (1.0 / (series + source_ohm) + 1.0 / shunt))
        return np.asarray(series + 1.0 / (1.0 / shunt + 1.0 / source_ohm))

    def seen_by_source_ohm(
        self, frequency_hz: npt.ArrayLike, *, antenna_ohm: npt.ArrayLike
    ) -> ComplexArray:
        """Return the impedance at the source's end, the other ended by the antenna [ohm].

        Parameters
        ----------
        frequency_hz, antenna_ohm : Frequency [Hz]; impedance of the antenna there [ohm].
        """
        z = np.asarray(antenna_ohm, dtype=np.complex128)
        series = self.series.impedance_ohm(frequency_hz)
        shunt = self.shunt.impedance_ohm(frequency_hz)
        if self.shunt_at == "antenna":
            return np.asarray(series + 1.0 / (1.0 / shunt + 1.0 / z))
        return np.asarray(1.0 / (1.0 / shunt + 1.0 / (series + z)))

    @property
    def nearest_e24(self) -> "LNetwork":
        """The same with the nearest values of the E24 series."""
        return LNetwork(
            series=self.series.nearest_e24, shunt=self.shunt.nearest_e24, shunt_at=self.shunt_at
        )

    def __str__(self) -> str:
        side = "the antenna" if self.shunt_at == "antenna" else "the reader's side"
        return f"{self.series} in series and {self.shunt} across {side}"


def l_networks(
    antenna_ohm: complex, *, source_ohm: float, frequency_hz: float
) -> tuple[LNetwork, ...]:
    """Return the L-networks, up to four, that match an antenna to a source at one frequency.

    Parameters
    ----------
    antenna_ohm, source_ohm : Impedance of the antenna, its resistance above 0, and of the source,
        real [ohm].
    frequency_hz : Frequency [Hz].

    Notes
    -----
    D. M. Pozar, Microwave Engineering, 4th ed. (2012), equations (5.3) and (5.6): the part across
    at the antenna where R² + X² >= R_0 R, at the source where R <= R_0. A part of no reactance is
    left to those networks that need none of it: they are not listed.
    """
    positive_number(source_ohm, name="source_ohm", unit="ohm")
    positive_number(frequency_hz, name="frequency_hz", unit="Hz")
    r, x, r0 = antenna_ohm.real, antenna_ohm.imag, source_ohm
    if not r > 0.0 or not np.isfinite(antenna_ohm):
        msg = f"antenna_ohm is {antenna_ohm:g} ohm, but its resistance must be above 0 ohm."
        raise AntennaError(msg)
    found: list[tuple[Literal["antenna", "source"], float, float]] = []
    square = r * r + x * x
    if square - r0 * r >= 0.0:
        root = math.sqrt(r / r0) * math.sqrt(square - r0 * r)
        for sign in (1.0, -1.0):
            b = (x + sign * root) / square
            if b != 0.0:
                found.append(("antenna", 1.0 / b + x * r0 / r - r0 / (b * r), b))
    if r <= r0:
        for sign in (1.0, -1.0):
            b = sign * math.sqrt((r0 - r) / r) / r0
            found.append(("source", sign * math.sqrt(r * (r0 - r)) - x, b))
    return tuple(
        LNetwork(
            series=Part.of_reactance(series, frequency_hz),
            shunt=Part.of_reactance(-1.0 / b, frequency_hz),
            shunt_at=place,
        )
        for place, series, b in found
        if series != 0.0 and b != 0.0
    )


def port_reflection_db(admittance_s: ComplexArray, load_ohm: npt.ArrayLike) -> FloatArray:
    """Return the reflection at each port with loads on all of them, (f, n) [dB].

    Behind a network without losses it is also that at the network's other end.

    Parameters
    ----------
    admittance_s : (f, n, n) complex128 — Admittances of the ports without loads [S].
    load_ohm : (f, n) or less — Loads, also as sources of the driven port [ohm].
    """
    f, n = admittance_s.shape[:2]
    loads = np.broadcast_to(np.asarray(load_ohm, dtype=np.complex128), (f, n))
    size = [
        np.abs(np.diagonal(scattering(y, load)))
        for y, load in zip(admittance_s, loads, strict=True)
    ]
    return np.asarray(20.0 * np.log10(np.maximum(np.array(size), 1e-10)))


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


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Match:
    """L-networks, one at each port of a reader.

    Parameters
    ----------
    networks, source_ohm : Of the ports in order; resistance of source and load behind them [ohm].
    """

    networks: tuple[LNetwork, ...]
    source_ohm: float

    def reflection_db(
        self, admittance_s: ComplexArray, frequencies_hz: npt.ArrayLike
    ) -> FloatArray:
        """Return the reflection at the networks' other ends, (f, n) [dB].

        Parameters
        ----------
        admittance_s, frequencies_hz : (f, n, n) admittances [S] at frequencies, (f,) [Hz].
        """
        ended = [
            network.seen_by_antenna_ohm(frequencies_hz, source_ohm=self.source_ohm)
            for network in self.networks
        ]
        return port_reflection_db(admittance_s, np.stack(ended, axis=-1))

    @property
    def nearest_e24(self) -> "Match":
        """The same with the nearest values of the E24 series."""
        networks = tuple(network.nearest_e24 for network in self.networks)
        return Match(networks=networks, source_ohm=self.source_ohm)


def match_reader(
    admittance_s: ComplexArray, frequencies_hz: npt.ArrayLike, *, at_hz: float, source_ohm: float
) -> Match | None:
    """Return the L-networks that match all ports at once at one frequency; None without any.

    Of the kinds of network that all ports can have, that with the least reflection over the band.

    Parameters
    ----------
    admittance_s : (f, n, n) complex128 — Admittances of the ports over the band [S].
    frequencies_hz, at_hz, source_ohm : (f,) [Hz]; one of them [Hz]; source and load [ohm].
    """
    f = np.atleast_1d(np.asarray(frequencies_hz, dtype=np.float64))
    seen = conjugate_match_ohm(admittance_s[int(np.abs(f - at_hz).argmin())])
    if seen is None:
        return None
    by_kind: dict[tuple[str, str, str], list[LNetwork]] = {}
    for impedance in seen:
        for network in l_networks(complex(impedance), source_ohm=source_ohm, frequency_hz=at_hz):
            kind = (network.shunt_at, network.series.kind, network.shunt.kind)
            by_kind.setdefault(kind, []).append(network)
    matches = [
        Match(networks=tuple(networks), source_ohm=source_ohm)
        for networks in by_kind.values()
        if len(networks) == len(seen)
    ]
    return min(
        matches, key=lambda match: float(match.reflection_db(admittance_s, f).max()), default=None
    )
