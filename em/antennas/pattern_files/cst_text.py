"""CST far fields exported as text: a header that names the columns, a rule, and rows of angles.

``Theta [deg.] Phi [deg.] Abs(Dir.)[dBi] Abs(Theta)[dBi] Phase(Theta)[deg.] Abs(Phi)[dBi] ...``.
The third column says what is plotted: Dir. (directivity), Gain, or Grlz and RlzdGain (realised
gain), in dBi or, with an empty unit, linear; components add up to it. CST uses e^{+j w t},
e^{-jkr}/r taken out. The file names no frequency. Source: CST Studio Suite online help, "Farfield
plot", "ASCII export".
"""

import math
import re
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.antennas.pattern_files._grids import fold, loop_grid
from octant.em.antennas.pattern_files._lines import (
    Row,
    checked_gain_dbi,
    numbers,
    read_lines,
    refusal,
)
from octant.em.antennas.pattern_files.common import PatternKind, PatternTable, amplitude
from octant.em.decibels import decibels

FloatArray = npt.NDArray[np.float64]

_KINDS: dict[str, PatternKind] = {
    "dir": "directivity",
    "directivity": "directivity",
    "gain": "gain",
    "gain(ieee)": "gain",
    "gainieee": "gain",
    "grlz": "realised_gain",
    "rlzdgain": "realised_gain",
    "realizedgain": "realised_gain",
    "realgain": "realised_gain",
}
_COLUMN = re.compile(r"([A-Za-z][A-Za-z. ]*?(?:\([^()]*(?:\([^()]*\))?[^()]*\))?)\s*\[([^\]]*)\]")
_AGREEMENT_DB = 0.1
_FAINT_DB = 40.0


def read_cst_text(path: Path) -> tuple[PatternTable, ...]:
    """Return the pattern of a CST text export: directivity, gain or realised gain, with phase.

    Parameters
    ----------
    path : The file.
    """
    lines = read_lines(path)
    head = next((i for i, text in enumerate(lines) if _COLUMN.search(text)), None)
    if head is None:
        raise refusal(path, 1, "no header 'Theta [deg.] Phi [deg.] Abs(...)[...]' is in the file.")
    names = [
        (re.sub(r"\s+", "", name).lower(), unit.strip().lower())
        for name, unit in _COLUMN.findall(lines[head])
    ]
    kind, at, linear = _columns(path, head + 1, names)
    rows = [
        numbers(path, line, text.replace(",", " ").split(), len(names))
        for line, text in enumerate(lines[head + 1 :], start=head + 2)
        if text.strip() and set(text.strip()) != {"-"}
    ]
    theta_deg, phi_deg, grid = loop_grid(path, rows, theta_column=at["theta"], phi_column=at["phi"])
    for row in rows:
        if not linear:
            checked_gain_dbi(path, row.line, row.values[at["total"]])
    total, along_theta, along_phi = (
        _level_db(path, head + 1, grid[at[name]], linear=linear)
        for name in ("total", "abs(theta)", "abs(phi)")
    )
    _check_sum(path, rows, grid, (total, along_theta, along_phi), at)
    field = np.stack(
        [
            amplitude(level) * np.exp(1j * np.radians(grid[at[phase]]))
            for level, phase in ((along_theta, "phase(theta)"), (along_phi, "phase(phi)"))
        ]
    )
    theta_rad, phi_rad, field = fold(path, head + 1, theta_deg, phi_deg, field)
    return (
        PatternTable(
            frequency_hz=None,
            theta_rad=theta_rad,
            phi_rad=phi_rad,
            field=field,
            kind=kind,
            name=path.stem,
            source=f"{path}, line {head + 1}",
            warnings=(f"{path} names no frequency: it is taken for any that is asked for",),
        ),
    )


def _columns(
    path: Path, line: int, names: list[tuple[str, str]]
) -> tuple[PatternKind, dict[str, int], bool]:
    """Return what is plotted, the columns by name, and whether levels are linear."""
    at = {name: i for i, (name, _) in enumerate(names)}
    plotted = next((i for i, (name, _) in enumerate(names) if name.startswith("abs(")), None)
    if plotted is None or not {"theta", "phi"} <= set(at):
        raise refusal(path, line, "the header needs the columns Theta, Phi and Abs(...).")
    what = names[plotted][0].removeprefix("abs(").removesuffix(")").rstrip(".")
    if what not in _KINDS:
        text = (
            f"the file holds {what[:20]!r}, whose level depends on a power and a distance that it "
            "does not tell; export Gain or Realized Gain, or a far-field source (.ffs)."
        )
        raise refusal(path, line, text)
    missing = [
        name for name in ("abs(theta)", "phase(theta)", "abs(phi)", "phase(phi)") if name not in at
    ]
    if missing:
        text = (
            f"the column {missing[0]} is missing; export linear components theta and phi "
            "(not Ludwig or circular ones)."
        )
        raise refusal(path, line, text)
    units = {names[i][1] for i in (plotted, at["abs(theta)"], at["abs(phi)"])}
    if len(units) != 1 or not units <= {"", "dbi", "db"}:
        text = f"the levels have the units {', '.join(sorted(units))}; dBi or linear are read."
        raise refusal(path, line, text)
    for name in ("theta", "phi", "phase(theta)", "phase(phi)"):
        if names[at[name]][1].rstrip(".") not in ("deg", "degree"):
            raise refusal(path, line, f"{name} is in {names[at[name]][1]!r}; degrees are read.")
    at["total"] = plotted
    return _KINDS[what], at, units == {""}


def _level_db(path: Path, line: int, values: FloatArray, *, linear: bool) -> FloatArray:
    if not linear:
        return values
    if (values < 0.0).any():
        raise refusal(path, line, "a linear gain is below 0; correct it.")
    found: FloatArray = decibels(np.maximum(values, 1e-30))
    return found


def _check_sum(
    path: Path,
    rows: list[Row],
    grid: FloatArray,
    levels: tuple[FloatArray, FloatArray, FloatArray],
    at: dict[str, int],
) -> None:
    """Refuse components that do not add up to what is plotted, where it is not faint."""
    total, along_theta, along_phi = levels
    added: FloatArray = decibels(
        np.maximum(amplitude(along_theta) ** 2 + amplitude(along_phi) ** 2, 1e-30)
    )
    off = np.where(total > total.max() - _FAINT_DB, np.abs(added - total), 0.0)
    if float(off.max()) <= _AGREEMENT_DB:
        return
    i, j = np.unravel_index(int(np.argmax(off)), off.shape)
    theta, phi = grid[at["theta"], i, j], grid[at["phi"], i, j]
    row = next(
        row
        for row in rows
        if math.isclose(row.values[at["theta"]], theta) and math.isclose(row.values[at["phi"]], phi)
    )
    what = f"theta and phi components are {off[i, j]:.2f} dB off the total; export again."
    raise refusal(path, row.line, what)
