"""Networks of coils and capacitors between an antenna and a receiver: closed forms, real values.

A ladder's parts stand in order from the antenna to the receiver, each in series or across. Ladders
of two parts (L) and of three (Pi) match an antenna at one frequency by closed forms.
"""

import itertools
import math
import re
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from octant.geometries._checks import positive_number
from octant.geometries.errors import AntennaError

ComplexArray = npt.NDArray[np.complex128]
Place = Literal["in series", "across"]
LShape = Literal["antenna", "source"]

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
UNITS = {"pH": 1e-12, "nH": 1e-9, "uH": 1e-6, "fF": 1e-15, "pF": 1e-12, "nF": 1e-9}
"""Units in which parts are written, in [H] or [F]."""
_PART = re.compile(
    r"\s*(?P<value>\d+\.?\d*(?:e[+-]?\d+)?)\s*(?P<unit>[a-z][HF])\s+(?P<place>in series|across)\s*"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """A coil or a capacitor.

    Parameters
    ----------
    kind, value : ``L`` [H] or ``C`` [F].
    quality : Reactance over resistance [-], the same at all frequencies; inf: without losses.
    """

    kind: Literal["L", "C"]
    value: float
    quality: float = math.inf

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
        ideal = s * self.value if self.kind == "L" else 1.0 / (s * self.value)
        return np.asarray(ideal + np.abs(ideal) / self.quality)

    def e24(self, steps: int = 0) -> "Part":
        """Return the same with the nearest value of the E24 series, by ratio, or one beside it.

        Parameters
        ----------
        steps : How many values above it, or below where negative.
        """
        decade = math.floor(math.log10(self.value))
        near = min(
            range(len(E24) + 1),
            key=lambda i: abs(math.log(_e24_value(decade, i) / self.value)),
        )
        return replace(self, value=_e24_value(decade, near + steps))

    def __str__(self) -> str:
        scale, unit = (1e9, "nH") if self.kind == "L" else (1e12, "pF")
        return f"{scale * self.value:.3g} {unit}"


def _e24_value(decade: int, index: int) -> float:
    """Return a value of the series, counted from the first of a decade."""
    over, step = divmod(index, len(E24))
    return float(f"{E24[step]}e{decade + over - 1}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Ladder:
    """Parts between an antenna and a receiver.

    Parameters
    ----------
    parts : From the antenna to the receiver: where each stands, and what it is.
    """

    parts: tuple[tuple[Place, Part], ...]

    @classmethod
    def of_text(cls, text: str) -> "Ladder":
        """Return the ladder that a text describes, such as ``0.82 pF across, 6.8 nH in series``.

        Parameters
        ----------
        text : Parts from the antenna to the receiver, in nH and pF, with commas between them.
        """
        parts: list[tuple[Place, Part]] = []
        for word in text.split(","):
            found = _PART.fullmatch(word)
            known = found is not None and found["unit"] in UNITS and float(found["value"]) > 0.0
            if found is None or not known:
                msg = (
                    f"{text!r} is no network: {word.strip()!r} is not read; write parts from the "
                    'antenna to the receiver, such as "0.82 pF across, 6.8 nH in series".'
                )
                raise AntennaError(msg)
            value = float(found["value"]) * UNITS[found["unit"]]
            kind: Literal["L", "C"] = "L" if found["unit"].endswith("H") else "C"
            place: Place = "across" if found["place"] == "across" else "in series"
            parts.append((place, Part(kind=kind, value=value)))
        return cls(parts=tuple(parts))

    @property
    def kind(self) -> tuple[tuple[Place, str], ...]:
        """Where which kind of part stands."""
        return tuple((place, part.kind) for place, part in self.parts)

    def of_parts(self, parts: tuple[Part, ...]) -> "Ladder":
        """Return the same with other parts in their places.

        Parameters
        ----------
        parts : From the antenna to the receiver.
        """
        places = (place for place, _ in self.parts)
        return Ladder(parts=tuple(zip(places, parts, strict=True)))

    def with_quality(self, *, coil: float, capacitor: float) -> "Ladder":
        """Return the same with parts that have losses.

        Parameters
        ----------
        coil, capacitor : Reactance over resistance [-].
        """
        return self.of_parts(
            tuple(
                replace(part, quality=coil if part.kind == "L" else capacitor)
                for _, part in self.parts
            )
        )

    @property
    def nearest_e24(self) -> "Ladder":
        """The same with the nearest values of the E24 series."""
        return self.of_parts(tuple(part.e24() for _, part in self.parts))

    def corners(self, tolerance: float) -> tuple["Ladder", ...]:
        """Return the ladders whose parts are all at one end of their tolerance or the other.

        Parameters
        ----------
        tolerance : Greatest relative error of a part [-].
        """
        ends = itertools.product((1.0 - tolerance, 1.0 + tolerance), repeat=len(self.parts))
        return tuple(
            self.of_parts(
                tuple(
                    replace(part, value=factor * part.value)
                    for factor, (_, part) in zip(factors, self.parts, strict=True)
                )
            )
            for factors in ends
        )

    def seen_by_antenna_ohm(
        self, frequency_hz: npt.ArrayLike, *, source_ohm: npt.ArrayLike
    ) -> ComplexArray:
        """Return the impedance at the antenna's end, the other ended by the source [ohm].

        Parameters
        ----------
        frequency_hz, source_ohm : Frequency [Hz]; impedance of the source [ohm].
        """
        return self._through(frequency_hz, source_ohm, self.parts[::-1])

    def seen_by_source_ohm(
        self, frequency_hz: npt.ArrayLike, *, antenna_ohm: npt.ArrayLike
    ) -> ComplexArray:
        """Return the impedance at the source's end, the other ended by the antenna [ohm].

        Parameters
        ----------
        frequency_hz, antenna_ohm : Frequency [Hz]; impedance of the antenna there [ohm].
        """
        return self._through(frequency_hz, antenna_ohm, self.parts)

    @staticmethod
    def _through(
        frequency_hz: npt.ArrayLike, end_ohm: npt.ArrayLike, parts: tuple[tuple[Place, Part], ...]
    ) -> ComplexArray:
        seen = np.asarray(end_ohm, dtype=np.complex128)
        for place, part in parts:
            z = part.impedance_ohm(frequency_hz)
            seen = seen + z if place == "in series" else seen * z / (seen + z)
        return np.asarray(seen)

    def chain(self, frequency_hz: float) -> ComplexArray:
        """Return the chain matrix (2, 2) from the antenna to the receiver [1, ohm; S, 1].

        Parameters
        ----------
        frequency_hz : Frequency [Hz].
        """
        chain = np.eye(2, dtype=np.complex128)
        for place, part in self.parts:
            z = complex(part.impedance_ohm(frequency_hz))
            step = [[1.0, z], [0.0, 1.0]] if place == "in series" else [[1.0, 0.0], [1.0 / z, 1.0]]
            chain = chain @ np.array(step, dtype=np.complex128)
        return chain

    def __str__(self) -> str:
        return ", ".join(f"{part} {place}" for place, part in self.parts)


NEGLIGIBLE = 1e-8
"""Reactance or susceptance [-], over the impedances it stands between, that is taken as none: it
changes the reflection by as much, and below it rounding would."""


def l_networks(
    antenna_ohm: complex, *, source_ohm: float, frequency_hz: float
) -> tuple[Ladder, ...]:
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
    _check_ends(antenna_ohm, source_ohm, frequency_hz)
    r, x, r0 = antenna_ohm.real, antenna_ohm.imag, source_ohm
    found: list[tuple[LShape, float, float]] = []
    square = r * r + x * x
    if square - r0 * r >= 0.0:
        root = math.sqrt(r / r0) * math.sqrt(square - r0 * r)
        for sign in (1.0, -1.0):
            b = (x + sign * root) / square
            if abs(b * antenna_ohm) > NEGLIGIBLE:
                found.append(("antenna", 1.0 / b + x * r0 / r - r0 / (b * r), b))
    if r <= r0:
        for sign in (1.0, -1.0):
            b = sign * math.sqrt((r0 - r) / r) / r0
            found.append(("source", sign * math.sqrt(r * (r0 - r)) - x, b))
    ladders = []
    for shape, series, b in found:
        if abs(series) > NEGLIGIBLE * r0 and abs(b) * r0 > NEGLIGIBLE:
            in_series: tuple[Place, Part] = ("in series", Part.of_reactance(series, frequency_hz))
            across: tuple[Place, Part] = ("across", Part.of_reactance(-1.0 / b, frequency_hz))
            parts = (across, in_series) if shape == "antenna" else (in_series, across)
            ladders.append(Ladder(parts=parts))
    return tuple(ladders)


def pi_networks(
    antenna_ohm: complex, *, source_ohm: float, frequency_hz: float, quality: float
) -> tuple[Ladder, ...]:
    """Return the Pi-networks, up to four, that match an antenna to a source at one frequency.

    Parameters
    ----------
    antenna_ohm, source_ohm, frequency_hz : As for `l_networks` [ohm], [Hz].
    quality : Susceptance over conductance at the end of the higher parallel resistance [-]; with
        less than the two resistances need there is none.

    Notes
    -----
    Two L-networks back to back at a virtual resistance R_v = max(R_p, R_0) / (1 + Q²), R_p the
    antenna's parallel resistance: C. Bowick, RF Circuit Design, 2nd ed. (2008), chapter 4. The part
    across the antenna takes its own susceptance in.
    """
    _check_ends(antenna_ohm, source_ohm, frequency_hz)
    y = 1.0 / antenna_ohm
    parallel_ohm = 1.0 / y.real
    virtual_ohm = max(parallel_ohm, source_ohm) / (1.0 + quality * quality)
    if not virtual_ohm < min(parallel_ohm, source_ohm):
        return ()
    q_antenna = math.sqrt(parallel_ohm / virtual_ohm - 1.0)
    q_source = math.sqrt(source_ohm / virtual_ohm - 1.0)
    ladders = []
    for first, last in itertools.product((1.0, -1.0), repeat=2):
        at_antenna = first * q_antenna / parallel_ohm - y.imag
        series = virtual_ohm * (first * q_antenna + last * q_source)
        if abs(at_antenna) * parallel_ohm > NEGLIGIBLE and abs(series) > NEGLIGIBLE * virtual_ohm:
            susceptances = (at_antenna, last * q_source / source_ohm)
            ends = [Part.of_reactance(-1.0 / b, frequency_hz) for b in susceptances]
            middle = Part.of_reactance(series, frequency_hz)
            ladders.append(
                Ladder(parts=(("across", ends[0]), ("in series", middle), ("across", ends[1])))
            )
    return tuple(ladders)


def _check_ends(antenna_ohm: complex, source_ohm: float, frequency_hz: float) -> None:
    positive_number(source_ohm, name="source_ohm", unit="ohm")
    positive_number(frequency_hz, name="frequency_hz", unit="Hz")
    if not antenna_ohm.real > 0.0 or not np.isfinite(antenna_ohm):
        msg = f"antenna_ohm is {antenna_ohm:g} ohm, but its resistance must be above 0 ohm."
        raise AntennaError(msg)
