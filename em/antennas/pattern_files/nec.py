"""NEC output: the RADIATION PATTERNS tables of NEC-2, nec2c, nec2++ and NEC-4 listings.

NEC uses e^{+j w t} and peak values [V], phase at the origin; an RP card's range puts e^{-jkr}/r
into the fields, taken out again. The level comes from the POWER BUDGET's input power (gain, not
realised gain: the mismatch is left to the reader), else from the total-gain column, printed to 0.01
dB. Source: G. J. Burke, A. J. Poggio, NEC, Part III: User's Guide, Lawrence Livermore Laboratory
(1981), RP card and "NEC output".
"""

import cmath
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from octant.em.antennas.pattern_files._grids import fold, loop_grid
from octant.em.antennas.pattern_files._lines import (
    HERTZ,
    Row,
    checked_gain_dbi,
    number,
    numbers,
    read_lines,
    refusal,
)
from octant.em.antennas.pattern_files.common import (
    DBI_FLOOR,
    VOLT_PER_ROOT_WATT,
    PatternKind,
    PatternTable,
)
from octant.em.decibels import decibels

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][-+]?\d+)?"
_AGREEMENT_DB = 0.1
_SAME_RAD, _SAME_FIELD = 1e-6, 1e-3
_COLUMNS = 11
_THETA, _PHI, _TOTAL, _E_THETA, _E_PHI = 0, 1, 4, 7, 9


@dataclass(slots=True)
class _State:
    """What the listing has given so far for the current frequency."""

    frequency_hz: float | None = None
    impedances: list[complex] = field(default_factory=list)
    input_w: float | None = None
    radiated_w: float | None = None
    spread: complex = 1.0  # e^{-jkr}/r of the running table
    directive: bool = False


@dataclass(slots=True)
class _Table:
    """One RP table while it is read."""

    line: int
    state: _State
    rows: list[Row] = field(default_factory=list)
    end: int = 0  # the line that ended it


def read_nec(path: Path) -> tuple[PatternTable, ...]:
    """Return the patterns of a NEC listing, one table a run and frequency.

    Gain or directivity, as it says; the input impedance where one source fed the structure. RP
    cards of one run that give parts of the sphere, such as its two halves, are put together, and
    of patterns that are repeated one stays; others remain tables of their own.

    Parameters
    ----------
    path : The listing.
    """
    tables: list[_Table] = []
    state = _State()
    section = ""
    for line, text in enumerate(read_lines(path), start=1):
        upper = " ".join(text.upper().split())
        frequency = re.search(rf"\bFREQUENCY ?[=:] ?({_NUMBER}) ?([KMG]?HZ)", upper)
        if frequency:
            value_hz = number(path, line, frequency.group(1)) * HERTZ[frequency.group(2)]
            state, section = _State(frequency_hz=value_hz), ""
        elif "ANTENNA INPUT PARAMETERS" in upper:
            # a new run at the same frequency: what the last run gave no longer holds
            section, state = "input", _State(frequency_hz=state.frequency_hz)
        elif "POWER BUDGET" in upper:
            section = "budget"
        elif re.search("- ?RADIATION PATTERNS ?-", upper):
            section = "head"
            state = replace(state, spread=1.0, directive=False)  # this table's own copy
            tables.append(_Table(line=line, state=state))
        elif "EXCITATION" in upper and "PLANE WAVE" in upper:
            raise refusal(path, line, "a plane wave excites the structure; feed it at its port.")
        elif section == "input":
            _input_line(path, line, state, upper)
        elif section == "budget":
            _budget_line(path, line, state, upper)
        elif section in ("head", "rows", "after"):
            section = _pattern_line(path, line, upper, tables[-1], section)
    if not tables:
        what = "no 'RADIATION PATTERNS' table is in the listing; add an RP card and run it again."
        raise refusal(path, 1, what)
    return _put_together(path, tables)


def _put_together(path: Path, tables: Sequence[_Table]) -> tuple[PatternTable, ...]:
    """Return the patterns, those of one run that are parts of one sphere as one."""
    found: list[tuple[_State, PatternTable]] = []
    for table in tables:
        made, run = _pattern(path, table), replace(table.state, spread=1.0)
        for i, (other, before) in enumerate(found):
            joined = _joined(before, made) if other == run else None
            if joined is not None:
                found[i] = (run, joined)
                break
        else:
            found.append((run, made))
    return tuple(table for _, table in found)


def _joined(first: PatternTable, second: PatternTable) -> PatternTable | None:
    """Return two sections of one run as one table; None: they do not belong together."""
    phi = first.phi_rad
    if len(phi) != len(second.phi_rad) or np.abs(phi - second.phi_rad).max() > _SAME_RAD:
        return None
    theta = np.concatenate([first.theta_rad, second.theta_rad])
    field_f = np.concatenate([first.field, second.field], axis=1)
    order = np.argsort(theta, kind="stable")
    theta, field_f = theta[order], field_f[:, order]
    twice = np.flatnonzero(np.diff(theta) < _SAME_RAD)
    off = np.abs(field_f[:, twice + 1] - field_f[:, twice])
    if off.size and off.max() > _SAME_FIELD * np.abs(field_f).max():
        return None
    theta, field_f = np.delete(theta, twice + 1), np.delete(field_f, twice + 1, axis=1)
    steps = np.diff(theta)
    if steps.size and steps.max() > 1.5 * max(
        float(np.diff(one.theta_rad).max(initial=0.0)) for one in (first, second)
    ):
        return None  # a gap lies between them
    return replace(first, theta_rad=theta, field=field_f)


def _input_line(path: Path, line: int, state: _State, text: str) -> None:
    """Take the input impedance from a row of the input parameters."""
    found = re.findall(_NUMBER, text)
    if len(found) == 11 and re.fullmatch(r"[-+\d.EDed\s]+", text):
        real, imaginary = (number(path, line, found[k]) for k in (6, 7))
        state.impedances.append(complex(real, imaginary))


def _budget_line(path: Path, line: int, state: _State, text: str) -> None:
    """Take a power [W] from a line of the power budget."""
    found = re.match(rf"(INPUT|RADIATED) POWER ?= ?({_NUMBER})", text)
    if found:
        watts = number(path, line, found.group(2))
        if found.group(1) == "INPUT":
            state.input_w = watts
        else:
            state.radiated_w = watts


def _pattern_line(path: Path, line: int, text: str, table: _Table, section: str) -> str:
    """Take one line of a pattern table; return the section that goes on.

    A line that does not begin with a number ends the rows: a blank one, or the echo of the next
    card, which nec2c prints without one. Rows that go on after it are refused.
    """
    tokens = text.split()
    if section != "head" and not re.fullmatch(_NUMBER, tokens[0] if tokens else ""):
        table.end = table.end or line
        return "after" if section == "rows" or not tokens else ""
    if section == "after":
        if len(tokens) in (_COLUMNS, _COLUMNS + 1):
            what = (
                "the line is no row of the pattern, but rows follow it; correct it or take it out."
            )
            raise refusal(path, table.end, what)
        return ""
    spread = re.search(rf"EXP\(-JKR\)/R ?[=:] ?({_NUMBER}) AT PHASE ?[=:]? ?({_NUMBER})", text)
    if spread:
        turn = math.radians(number(path, line, spread.group(2)))
        table.state.spread = number(path, line, spread.group(1)) * cmath.exp(1j * turn)
        if table.state.spread == 0:
            raise refusal(path, line, "e^{-jkr}/r is 0; give a range above 0 m.")
    elif "DIRECTIVE GAIN" in text:
        table.state.directive = True
    elif section == "rows" or re.match(rf"{_NUMBER} ", text):
        if len(tokens) == _COLUMNS + 1 and tokens[7].isalpha():
            del tokens[7]  # the sense of polarisation, blank where there is no field
        table.rows.append(numbers(path, line, tokens, _COLUMNS))
        return "rows"
    return section


def _pattern(path: Path, table: _Table) -> PatternTable:
    """Return one RP table."""
    state = table.state
    if state.frequency_hz is None or state.frequency_hz <= 0.0:
        raise refusal(
            path, table.line, "no frequency stands above the pattern; keep the listing whole."
        )
    if not table.rows:
        raise refusal(path, table.line, "the pattern has a header but no directions; add them.")
    theta_deg, phi_deg, grid = loop_grid(path, table.rows)
    field_v = np.stack(
        [grid[at] * np.exp(1j * np.radians(grid[at + 1])) for at in (_E_THETA, _E_PHI)]
    )
    field_v = field_v / state.spread
    kind: PatternKind = "directivity" if state.directive else "gain"
    power_w = state.radiated_w if state.directive else state.input_w
    scale = _scale(path, table.rows, power_w, abs(state.spread))
    theta_rad, phi_rad, field_f = fold(
        path, table.rows[0].line, theta_deg, phi_deg, scale * field_v
    )
    return PatternTable(
        frequency_hz=state.frequency_hz,
        theta_rad=theta_rad,
        phi_rad=phi_rad,
        field=field_f,
        kind=kind,
        name=path.stem,
        source=f"{path}, line {table.line}",
        impedance_ohm=state.impedances[0] if len(state.impedances) == 1 else None,
    )


def _scale(path: Path, rows: Sequence[Row], power_w: float | None, spread: float) -> float:
    """Return the factor [1/V] from r E to F; the gain column must agree."""
    square_v2 = np.array([row.values[_E_THETA] ** 2 + row.values[_E_PHI] ** 2 for row in rows])
    square_v2 = square_v2 / spread**2
    gain_db = np.array([checked_gain_dbi(path, row.line, row.values[_TOTAL]) for row in rows])
    strong = gain_db > max(gain_db.max() - 20.0, DBI_FLOOR)
    if not strong.any() or not square_v2[strong].any():
        raise refusal(
            path, rows[0].line, "the table says that nothing is radiated; check the feed."
        )
    if power_w is None:
        squared = float(np.sum(10.0 ** (gain_db[strong] / 10.0)) / square_v2[strong].sum())
    elif power_w > 0.0:
        squared = 1.0 / (VOLT_PER_ROOT_WATT**2 * power_w)
    else:
        what = f"the power budget gives {power_w:g} W; a pattern needs power above 0 W."
        raise refusal(path, rows[0].line, what)
    off_db = np.abs(decibels(np.maximum(squared * square_v2, 1e-30)) - gain_db)
    wrong = np.flatnonzero(strong & (off_db > _AGREEMENT_DB))
    if wrong.size:
        row = rows[int(wrong[0])]
        what = (
            f"field and gain disagree by {off_db[wrong[0]]:.2f} dB; keep the power budget of the "
            "same run in the listing."
        )
        raise refusal(path, row.line, what)
    return math.sqrt(squared)
