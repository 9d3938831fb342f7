"""Whether a reader is matched, and what would match it, in sentences."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from octant.em.reader.matching import (
    MATCHED_DB,
    Match,
    best_real_load_ohm,
    match_reader,
    matched_band_hz,
    port_reflection_db,
    vswr,
)

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]


def matching_lines(
    admittance_s: ComplexArray, frequencies_hz: npt.ArrayLike, *, at_hz: float, load_ohm: float
) -> Iterator[str]:
    """Yield whether all ports are matched at a frequency, over which band, and else what would do.

    Parameters
    ----------
    admittance_s, frequencies_hz : (f, n, n) admittances of the ports [S] at frequencies, (f,) [Hz].
    at_hz : Where they are to be matched [Hz]; the nearest of the frequencies counts.
    load_ohm : Resistance of source and load of every port [ohm].
    """
    f = np.atleast_1d(np.asarray(frequencies_hz, dtype=np.float64))
    carrier = int(np.abs(f - at_hz).argmin())
    level_db = port_reflection_db(admittance_s, load_ohm).max(axis=1)
    found = _level_text(level_db, f, carrier)
    if level_db[carrier] <= MATCHED_DB:
        yield f"Matched to {load_ohm:g} ohm: {found}."
        return
    yield f"Not matched to {load_ohm:g} ohm: {found}, where {MATCHED_DB:g} dB or less is usual."
    best_ohm = best_real_load_ohm(admittance_s[carrier : carrier + 1])
    with_load = port_reflection_db(admittance_s, best_ohm).max(axis=1)
    yield (
        f"The best real load at that frequency is {best_ohm:.3g} ohm (reader.load_ohm): "
        f"{_level_text(with_load, f, carrier)}."
    )
    match = match_reader(admittance_s, f, at_hz=float(f[carrier]), source_ohm=load_ohm)
    if match is None:
        yield "No L-network matches all ports at once."
        return
    yield from _network_lines(match, admittance_s, f, carrier)


def _network_lines(
    match: Match, admittance_s: ComplexArray, f: FloatArray, carrier: int
) -> Iterator[str]:
    """Yield the networks and what they reach, ideal and with parts that can be bought."""
    ideal = match.reflection_db(admittance_s, f).max(axis=1)
    bought = match.nearest_e24
    real = bought.reflection_db(admittance_s, f).max(axis=1)
    kinds = list(dict.fromkeys(str(network) for network in match.networks))
    parts = "; ".join(
        f"antenna {_numbers(match, kind)}: {kind}" if len(kinds) > 1 else kind for kind in kinds
    )
    each = "an L-network at each antenna" if len(kinds) == 1 else "L-networks"
    yield (
        f"Or {each} ({parts}; parts without losses), applied to all: "
        f"{_level_text(ideal, f, carrier, floor_db=-40.0)}."
    )
    shown = list(dict.fromkeys(str(network) for network in bought.networks))
    yield (
        f"With the nearest values of the E24 series ({'; '.join(shown)}): "
        f"{_level_text(real, f, carrier, floor_db=-40.0)}."
    )


def _numbers(match: Match, kind: str) -> str:
    return ", ".join(str(i + 1) for i, n in enumerate(match.networks) if str(n) == kind)


def _level_text(
    level_db: FloatArray, f: FloatArray, carrier: int, *, floor_db: float | None = None
) -> str:
    """Return the reflection at the carrier and over which band it is low enough, in words."""
    level = float(level_db[carrier])
    ratio = float(vswr(10.0 ** (0.1 * level)))
    least = floor_db is not None and level < floor_db
    shown = f"below {floor_db:g} dB" if least else f"up to {level:.1f} dB (VSWR {ratio:.2g})"
    text = f"reflection {shown} at {f[carrier] / 1e9:.4g} GHz"
    band = matched_band_hz(f, level_db, around_hz=float(f[carrier])) if len(f) > 1 else None
    if band is None:
        return text
    low, high = band
    if low == f[0] and high == f[-1]:
        return f"{text}, {MATCHED_DB:g} dB or less over the whole band"
    return (
        f"{text}, {MATCHED_DB:g} dB or less from {low / 1e9:.4g} to {high / 1e9:.4g} GHz "
        f"({(high - low) / 1e6:.3g} MHz)"
    )
