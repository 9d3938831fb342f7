"""HFSS far fields (``.ffd``): complex r E on a grid that two header lines define.

HFSS uses e^{+j w t} and peak values [V], e^{-jkr} taken out, phase at the coordinate system's
origin. Power is not in the file: |F|^2 = 2 pi |rE|^2 / (eta P), with P the incident power, 1 W
unless set otherwise, so that F is realised gain. Source: Ansys HFSS online help, "Far Field Data
file format (.ffd)".
"""

import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from octant.em.antennas.pattern_files._grids import fold
from octant.em.antennas.pattern_files._lines import (
    HERTZ,
    Row,
    number,
    numbers,
    read_lines,
    refusal,
    whole_number,
)
from octant.em.antennas.pattern_files.common import VOLT_PER_ROOT_WATT, PatternTable
from octant.geometries.errors import PatternFileError


def read_ffd(path: Path, *, incident_power_w: float = 1.0) -> tuple[PatternTable, ...]:
    """Return the realised gains of an HFSS ``.ffd`` file, one table a frequency (or None).

    Parameters
    ----------
    path : The file.
    incident_power_w : Power [W] incident on the port when the fields were exported.
    """
    if not (math.isfinite(incident_power_w) and incident_power_w > 0.0):
        msg = f"{path}: incident_power_w = {incident_power_w} W; give a power above 0 W."
        raise PatternFileError(msg)
    lines = [
        (line, text.split())
        for line, text in enumerate(read_lines(path), start=1)
        if text.strip() and not text.lstrip().startswith(("#", "!"))
    ]
    if len(lines) < 3:
        raise refusal(path, lines[-1][0] if lines else 1, "the file ends within its header.")
    theta_deg, phi_deg = (_axis(path, *line) for line in lines[:2])
    count = len(theta_deg) * len(phi_deg)
    tables = []
    for line, frequency_hz, rows in _blocks(path, lines[2:], count):
        values = np.array([row.values for row in rows]).reshape(len(theta_deg), len(phi_deg), 4)
        field_v = np.stack(
            (values[..., 0] + 1j * values[..., 1], values[..., 2] + 1j * values[..., 3])
        )
        field = field_v / (VOLT_PER_ROOT_WATT * math.sqrt(incident_power_w))
        theta_rad, phi_rad, field = fold(path, line, theta_deg, phi_deg, field)
        tables.append(
            PatternTable(
                frequency_hz=frequency_hz,
                theta_rad=theta_rad,
                phi_rad=phi_rad,
                field=field,
                kind="realised_gain",
                name=path.stem,
                source=f"{path}, line {line}",
            )
        )
    return tuple(tables)


def _axis(
    path: Path, line: int, tokens: Sequence[str]
) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return the angles [deg] of a header line: start, stop, number."""
    start, stop = numbers(path, line, tokens, 3).values[:2]
    count = whole_number(path, line, tokens[2])
    if count < 2 or count > 100_000 or not start < stop:
        what = f"{start:g} to {stop:g} deg in {count} values do not make an axis; correct it."
        raise refusal(path, line, what)
    return np.linspace(start, stop, count)


def _blocks(
    path: Path, lines: Sequence[tuple[int, list[str]]], count: int
) -> Iterator[tuple[int, float | None, list[Row]]]:
    """Yield first line, frequency [Hz] and rows of every frequency."""
    begin, announced = 0, 0
    head = lines[0][1]
    if head[0].lower().startswith("freq") and head[0].lower() != "frequency":
        announced = whole_number(path, lines[0][0], head[1] if len(head) > 1 else "")
        begin = 1
    found = 0
    while begin < len(lines):
        line, tokens = lines[begin]
        frequency_hz = None
        if tokens[0].lower() == "frequency":
            frequency_hz = _frequency(path, line, tokens[1:])
            begin += 1
        elif announced or found:
            what = "the grid is full; a 'Frequency' line or the end of the file must follow."
            raise refusal(path, line, what)
        rows = lines[begin : begin + count]
        made = [_row(path, place, row) for place, row in rows]
        if len(rows) < count:
            what = f"the file ends after {len(rows)} of {count} directions; directions are missing."
            raise refusal(path, lines[-1][0], what)
        yield line, frequency_hz, made
        begin += count
        found += 1
    if found != max(announced, 1):
        what = f"{found} frequencies where {max(announced, 1)} are announced; correct the header."
        raise refusal(path, lines[-1][0], what)


def _row(path: Path, line: int, tokens: Sequence[str]) -> Row:
    """Return one direction's four numbers."""
    if tokens[0].lower() == "frequency":
        raise refusal(
            path, line, "a 'Frequency' line before the grid is full; directions are missing."
        )
    return numbers(path, line, tokens, 4)


def _frequency(path: Path, line: int, tokens: Sequence[str]) -> float:
    """Return a frequency [Hz] of a ``Frequency`` line, with or without a unit."""
    text = "".join(tokens)
    found = re.fullmatch(r"([-+.\deE]+)([kKmMgG]?[hH][zZ])?", text)
    if not found:
        raise refusal(path, line, f"{text[:40]!r} is not a frequency; give a number of Hz.")
    frequency_hz = number(path, line, found.group(1)) * HERTZ[(found.group(2) or "HZ").upper()]
    if frequency_hz <= 0.0:
        raise refusal(path, line, f"frequency {text} is not a frequency; give more than 0 Hz.")
    return frequency_hz
