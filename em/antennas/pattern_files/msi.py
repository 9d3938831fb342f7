"""MSI/Planet antenna files (``.msi``, ``.pln``): two cuts of attenuation below the maximum gain.

No phase and one polarisation. GAIN is in dBd unless ``dBi`` stands with it. Dialects: comments
(``!``, ``#``, ``;``, ``//``), keywords with ``:`` or ``=``, cuts without a count, finer steps than
1 deg, levels (negative) in place of losses. HORIZONTAL runs clockwise
seen from above, 0 at the main direction (+x here, so phi = -angle); VERTICAL from the horizon there
downwards: 90 is straight down, 180 behind. Source: Radio Mobile, "Definitions: MSI".
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

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
    cut_step_deg,
    spread_two_cuts,
    two_cuts_warnings,
)
from octant.em.antennas.pattern_files.common import NO_PHASE_WARNING, PatternTable, amplitude

FloatArray = npt.NDArray[np.float64]

DIPOLE_DBI = 2.15
"""Gain [dBi] of the half-wave dipole that dBd refers to."""
_PEAK_DB = 0.01
_OTHER_WORDS = {"POLARISATION": "POLARIZATION", "POL": "POLARIZATION", "FREQ": "FREQUENCY"}


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
    gain_dbi, gain_notes = _gain(path, content)
    given = {name: _losses(path, content, name) for name in ("HORIZONTAL", "VERTICAL")}
    step_deg = cut_step_deg(*(angle for angle, _ in given.values()))
    horizontal, vertical = (
        -closed_cut(path, content.cuts[name][0].line, angle, loss, step_deg=step_deg)
        for name, (angle, loss) in given.items()
    )
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
                *gain_notes,
                *_doubts(path, content, horizontal, vertical),
                *notes,
            ),
        ),
    )


def _parse(path: Path) -> _File:
    """Return the fields and the cuts of a file."""
    content = _File()
    rows: list[Row] | None = None
    due: int | None = 0  # rows of the cut that are still to come; None: the file does not say
    last, first = 1, True
    for line, raw in enumerate(read_lines(path), start=1):
        text = re.split(r"(?:^|\s)(?:!|#|;|//)", raw, maxsplit=1)[0]
        tokens = text.replace(",", " ").split() if rows is not None and due != 0 else text.split()
        if not tokens:
            continue
        last = line
        is_number = re.match(r"[-+.]?\d", tokens[0]) is not None
        if rows is not None and (due if due is not None else is_number):
            rows.append(numbers(path, line, tokens, 2))
            due = None if due is None else due - 1
            continue
        key, *rest = re.sub(r"^\s*(\w+)\s*[:=]", r"\1 ", text).split()
        key = key.upper()
        if key in ("HORIZONTAL", "VERTICAL"):
            if key in content.cuts:
                raise refusal(path, line, f"{key} is given twice; keep one.")
            due = whole_number(path, line, rest[0]) if rest else None
            rows = content.cuts[key] = []
        elif first and key != "NAME":
            content.fields["NAME"] = (line, tokens)  # some makers leave the keyword out
        elif is_number or key[0] in "+-.":
            raise refusal(
                path, line, "numbers outside a cut; HORIZONTAL or VERTICAL announces them."
            )
        else:
            content.fields.setdefault(_OTHER_WORDS.get(key, key), (line, rest))
        first = False
    if due:
        raise refusal(
            path, last, f"the file ends {due} angles before the cut does; they are missing."
        )
    return content


def _losses(path: Path, content: _File, name: str) -> tuple[FloatArray, FloatArray]:
    """Return angles [deg] and losses [dB] of a cut; levels, which are negative, are turned."""
    rows = content.cuts[name]
    if not rows:
        raise refusal(path, 1, f"the {name} cut has no angles; add them.")
    angle_deg, loss_db = np.array([row.values for row in rows]).T
    everything = [row.values[1] for cut in content.cuts.values() for row in cut]
    if max(everything) <= 0.5 and 2 * sum(value < 0.0 for value in everything) > len(everything):
        return angle_deg, -loss_db
    for row in rows:
        if row.values[1] < -0.5:
            what = f"attenuation {row.values[1]:g} dB; the file's losses are positive numbers."
            raise refusal(path, row.line, what)
    return angle_deg, loss_db


def _doubts(
    path: Path, content: _File, horizontal_db: FloatArray, vertical_db: FloatArray
) -> tuple[str, ...]:
    """Return notes where no cut reaches the gain, and where the beam tilts the other way."""
    notes = []
    peak_db = max(float(horizontal_db.max()), float(vertical_db.max()))
    if peak_db < -_PEAK_DB:
        notes.append(
            f"{path}: the cuts stay {-peak_db:.2f} dB below GAIN, which they do not show: "
            "the pattern keeps their levels"
        )
    step_deg = 360.0 / len(vertical_db)
    down_deg = (float(np.argmax(vertical_db)) * step_deg + 180.0) % 360.0 - 180.0
    for key in ("ELECTRICAL_TILT", "TILT"):
        _, words = content.fields.get(key, (1, []))
        found = re.match(r"-?\d+(\.\d+)?", words[0]) if words else None
        tilt_deg = float(found[0]) if found else 0.0
        if abs(tilt_deg) >= 2.0 and abs(down_deg + tilt_deg) < 0.5 * abs(tilt_deg):
            notes.append(
                f"{path}: {key} is {tilt_deg:g} deg, but the vertical cut is strongest "
                f"{abs(down_deg):g} deg {'above' if down_deg < 0.0 else 'below'} the horizon: is "
                "it given upwards?"
            )
            break
    return tuple(notes)


def _gain(path: Path, content: _File) -> tuple[float, tuple[str, ...]]:
    """Return the maximum gain [dBi], and a note where its unit is not told."""
    if "GAIN" not in content.fields:
        raise refusal(path, 1, "the GAIN line is missing; add one such as 'GAIN 2.15 dBi'.")
    line, tokens = content.fields["GAIN"]
    joined = "".join(tokens).lower().strip("()")
    unit = next((name for name in ("dbi", "dbd") if name in joined), "")
    text = joined.replace(unit, "", 1).strip("()") if unit else joined
    if re.fullmatch(r"[-+]?\d+,\d+", text):
        text = text.replace(",", ".")
    gain_dbi = number(path, line, text) + (0.0 if unit == "dbi" else DIPOLE_DBI)
    note = f"{path}: GAIN has no unit, so that dBd is taken, as the format has it"
    return checked_gain_dbi(path, line, gain_dbi), () if unit else (note,)


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
