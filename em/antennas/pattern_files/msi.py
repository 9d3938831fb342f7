"""MSI/Planet antenna files (``.msi``, ``.pln``): two cuts of attenuation below the maximum gain.

No phase and one polarisation. GAIN is in dBd unless ``dBi`` follows it. HORIZONTAL runs clockwise
seen from above, 0 at the main direction (+x here, so phi = -angle); VERTICAL from the horizon there
downwards: 90 is straight down, 180 behind. Source: Radio Mobile, "Definitions: MSI".
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from octant.em.antennas.pattern_files._lines import (
    HERTZ,
    Row,
    checked_gain_dbi,
    number,
    numbers,
    read_lines,
    refusal,
    whole_number,
)
from octant.em.antennas.pattern_files._two_cuts import (
    closed_cut,
    spread_two_cuts,
    two_cuts_warnings,
)
from octant.em.antennas.pattern_files.common import NO_PHASE_WARNING, PatternTable, amplitude

DIPOLE_DBI = 2.15
"""Gain [dBi] of the half-wave dipole that dBd refers to."""


@dataclass(slots=True)
class _File:
    """Fields and cuts while the file is read."""

    fields: dict[str, tuple[int, list[str]]] = field(default_factory=dict)
    cuts: dict[str, list[Row]] = field(default_factory=dict)


def read_msi(path: Path) -> tuple[PatternTable, ...]:
    """Return the pattern of an MSI/Planet file: one table of gain, no phase, main direction +x.

    Parameters
    ----------
    path : The file.
    """
    content = _parse(path)
    for name in ("HORIZONTAL", "VERTICAL"):
        if name not in content.cuts:
            raise refusal(path, 1, f"the {name} cut is missing; an MSI file needs both cuts.")
    gain_dbi = _gain(path, content)
    horizontal, vertical = (_cut(path, content, name) for name in ("HORIZONTAL", "VERTICAL"))
    # clockwise and downwards in the file; the spreading counts counter-clockwise and upwards
    turned = [np.roll(cut[::-1], 1) for cut in (horizontal, vertical)]
    theta_rad, phi_rad, level_db = spread_two_cuts(*turned)
    total = amplitude(np.minimum(gain_dbi + level_db, 100.0))
    share, notes = _polarisation(path, content)
    source = f"{path}, line 1"
    return (
        PatternTable(
            frequency_hz=_frequency(path, content),
            theta_rad=theta_rad,
            phi_rad=phi_rad,
            field=np.stack((share[0] * total, share[1] * total)).astype(np.complex128),
            kind="gain",
            phase_known=False,
            name=" ".join(content.fields.get("NAME", (1, [path.stem]))[1]) or path.stem,
            source=source,
            warnings=(
                NO_PHASE_WARNING.format(source=path),
                *two_cuts_warnings(str(path), *turned),
                *notes,
            ),
        ),
    )


def _parse(path: Path) -> _File:
    """Return the fields and the cuts of a file."""
    content = _File()
    rows: list[Row] = []
    due = 0
    last = 1
    for line, text in enumerate(read_lines(path), start=1):
        tokens = text.replace(",", " ").split() if due else text.split()
        if not tokens:
            continue
        last = line
        if due:
            rows.append(numbers(path, line, tokens, 2))
            due -= 1
            continue
        key = tokens[0].upper()
        if key in ("HORIZONTAL", "VERTICAL"):
            if key in content.cuts:
                raise refusal(path, line, f"{key} is given twice; keep one.")
            due = whole_number(path, line, tokens[1] if len(tokens) > 1 else "")
            rows = content.cuts[key] = []
        elif line == 1 and key != "NAME":
            content.fields["NAME"] = (line, tokens)  # some makers leave the keyword out
        elif key[0].isdigit() or key[0] in "+-.":
            raise refusal(
                path, line, "numbers outside a cut; HORIZONTAL or VERTICAL announces them."
            )
        else:
            content.fields.setdefault(key, (line, tokens[1:]))
    if due:
        raise refusal(
            path, last, f"the file ends {due} angles before the cut does; they are missing."
        )
    return content


def _cut(path: Path, content: _File, name: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return the level [dB] of a cut, at 0..359 deg, relative to the maximum gain."""
    rows = content.cuts[name]
    angle_deg, loss_db = np.array([row.values for row in rows]).T
    for row in rows:
        if row.values[1] < -0.5:
            what = f"attenuation {row.values[1]:g} dB; the file's losses are positive numbers."
            raise refusal(path, row.line, what)
    return -closed_cut(path, rows[0].line, angle_deg, loss_db)


def _gain(path: Path, content: _File) -> float:
    """Return the maximum gain [dBi]."""
    if "GAIN" not in content.fields:
        raise refusal(path, 1, "the GAIN line is missing; add one such as 'GAIN 2.15 dBi'.")
    line, tokens = content.fields["GAIN"]
    joined = "".join(tokens).lower()
    isotropic = joined.endswith("dbi")
    text = joined.removesuffix("dbi").removesuffix("dbd")
    return checked_gain_dbi(
        path, line, number(path, line, text) + (0.0 if isotropic else DIPOLE_DBI)
    )


def _frequency(path: Path, content: _File) -> float | None:
    """Return the frequency [Hz]; MHz where no unit is given; None for a band or no line."""
    line, tokens = content.fields.get("FREQUENCY", (1, []))
    joined = "".join(tokens).upper()
    if not tokens or re.match(r"[\d.]+([KMG]?HZ)?[-/~]", joined):
        return None
    unit = next((u for u in ("KHZ", "MHZ", "GHZ", "HZ") if joined.endswith(u)), "")
    value_hz = number(path, line, joined.removesuffix(unit)) * HERTZ[unit or "MHZ"]
    if value_hz <= 0.0:
        raise refusal(path, line, f"frequency {joined} is not a frequency; give more than 0 MHz.")
    return value_hz


def _polarisation(path: Path, content: _File) -> tuple[Sequence[float], tuple[str, ...]]:
    """Return the shares of F_theta and F_phi, and what was assumed."""
    text = "".join(content.fields.get("POLARIZATION", (1, [""]))[1]).upper()
    if text.startswith("V"):
        return (1.0, 0.0), ()
    if text.startswith("H"):
        return (0.0, 1.0), ()
    if "45" in text:
        return (0.5**0.5, -(0.5**0.5) if text.startswith("-") else 0.5**0.5), ()
    note = f"{path} names no known polarisation: its gain is taken as theta (vertical)"
    return (1.0, 0.0), (note,)
