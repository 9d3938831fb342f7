"""NGMN BASTA patterns (JSON): attenuation below a gain, on a regular grid or row by row.

``Theta_Sampling`` and ``Phi_Sampling`` (first, step, last) make a regular grid, theta by theta;
without them the rows hold ``Theta`` and ``Phi``. Rows hold ``MagAttenuationTP`` (total power),
``MagAttenuationCo`` and ``MagAttenuationCr`` [dB] below ``Gain``, perhaps ``PhaseCo`` and
``PhaseCr``. Coordinates: Polar (theta from the zenith, phi counter-clockwise), CW and CCW (theta
from the horizon downwards, phi clockwise or not), Geo (theta from the nadir, phi clockwise); the
main direction is near +x. Source: NGMN Alliance, "Recommendation on Base Station Antenna Standards"
(BASTA AA, white paper 3.0 and later), "3D radiation pattern" files.
"""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.em.antennas.pattern_files._grids import fold
from octant.em.antennas.pattern_files._lines import HERTZ, checked_gain_dbi, read_lines, refusal
from octant.em.antennas.pattern_files.common import NO_PHASE_WARNING, PatternTable, amplitude
from octant.em.antennas.pattern_files.msi import DIPOLE_DBI
from octant.em.decibels import decibels

FloatArray = npt.NDArray[np.float64]

_SYSTEMS = {
    "SPCS_POLAR": (1.0, 0.0, 1.0),
    "SPCS_ERICSSON": (1.0, 0.0, 1.0),
    "SPCS_CCW": (1.0, 90.0, 1.0),
    "SPCS_CW": (1.0, 90.0, -1.0),
    "SPCS_GEO": (-1.0, 180.0, -1.0),
}
"""Sign and offset [deg] of theta, and sign of phi, by the name of the coordinates."""
_TOTAL, _CO, _CROSS = "MagAttenuationTP", "MagAttenuationCo", "MagAttenuationCr"
_PHASES = ("PhaseCo", "PhaseCr")
_AGREEMENT_DB, _FAINT_DB = 0.1, 40.0
_MOST_SAMPLES = 20_000_000


def read_ngmn(path: Path) -> tuple[PatternTable, ...]:
    """Return the patterns of an NGMN BASTA file: gain, with phase where both components have one.

    Parameters
    ----------
    path : The file: one pattern, or a list of them.
    """
    text = "\n".join(read_lines(path))
    try:
        content = json.loads(text)
    except json.JSONDecodeError as exc:
        raise refusal(path, exc.lineno, f"the file is no JSON ({exc.msg}); it is cut off?") from exc
    except RecursionError as exc:
        raise refusal(path, 1, "the file is nested too deeply to be a pattern.") from exc
    patterns = content if isinstance(content, list) else [content]
    if not patterns:
        raise refusal(path, 1, "the file holds no pattern; give one with a Data_Set.")
    return tuple(_table(path, one, i) for i, one in enumerate(patterns))


def _table(path: Path, one: object, number: int) -> PatternTable:
    if not isinstance(one, dict) or "Data_Set" not in one:
        raise refusal(path, 1, f"pattern {number + 1} has no Data_Set; give an NGMN BASTA file.")
    columns, angles = _rows(path, one)
    system = str(one.get("Coordinate_System", "")).upper()
    if system not in _SYSTEMS:
        what = f"Coordinate_System is {system[:20]!r}; read are {', '.join(_SYSTEMS)}."
        raise refusal(path, 1, what)
    sign, offset_deg, turn = _SYSTEMS[system]
    theta_deg, phi_deg = offset_deg + sign * angles[0], turn * angles[1]
    if theta_deg.min() < -1e-6 or theta_deg.max() > 180.0 + 1e-6:
        what = f"Theta leaves the sphere in {system}; correct the sampling or the coordinates."
        raise refusal(path, 1, what)
    gain_dbi = _gain(path, one)
    power, notes = _powers(path, columns)
    field, known, note = _field(path, one, columns, power)
    field = field * amplitude(gain_dbi)
    theta_axis, phi_axis, gridded = _gridded(path, theta_deg, phi_deg, field)
    theta_rad, phi_rad, folded = fold(path, 1, theta_axis, phi_axis, gridded, signed=known)
    name = " ".join(str(one.get(key, "")) for key in ("Antenna_Model", "RF_Port")).strip()
    source = f"{path}, pattern {number + 1}"
    return PatternTable(
        frequency_hz=_frequency(path, one),
        theta_rad=theta_rad,
        phi_rad=phi_rad,
        field=folded,
        kind="gain",
        phase_known=known,
        name=name or path.stem,
        source=source,
        warnings=(*(() if known else (NO_PHASE_WARNING.format(source=path),)), *notes, *note),
    )


def _rows(path: Path, one: dict[str, Any]) -> tuple[dict[str, FloatArray], FloatArray]:
    """Return the columns by name, and theta and phi (2, n) of every row in the file's system."""
    names = one.get("Data_Set_Row_Structure")
    try:
        table = np.array(one["Data_Set"], dtype=np.float64)
    except (TypeError, ValueError) as exc:
        raise refusal(path, 1, "Data_Set is no table of numbers; correct it.") from exc
    if (
        not isinstance(names, list)
        or len(set(map(str, names))) < len(names)
        or table.ndim != 2
        or table.shape[1] != len(names)
        or not 1 < len(table) <= _MOST_SAMPLES
    ):
        what = (
            f"Data_Set has the shape {table.shape}, Data_Set_Row_Structure names "
            f"{len(names) if isinstance(names, list) else 'no'} columns; correct the one that is "
            "wrong."
        )
        raise refusal(path, 1, what)
    if not np.isfinite(table).all():
        raise refusal(path, 1, "Data_Set holds values that are no finite numbers; correct them.")
    columns = {str(name): table[:, i] for i, name in enumerate(names)}
    if {"Theta", "Phi"} <= set(columns):
        return columns, np.stack([columns["Theta"], columns["Phi"]])
    axes = [_sampling(path, one, key) for key in ("Theta_Sampling", "Phi_Sampling")]
    if len(axes[0]) * len(axes[1]) != len(table):
        what = (
            f"{len(axes[0])} x {len(axes[1])} directions are sampled, but Data_Set has "
            f"{len(table)} rows; rows are missing or the sampling is wrong."
        )
        raise refusal(path, 1, what)
    theta, phi = np.meshgrid(*axes, indexing="ij")
    return columns, np.stack([theta.ravel(), phi.ravel()])


def _sampling(path: Path, one: dict[str, Any], key: str) -> FloatArray:
    given = one.get(key)
    try:
        first, step, last = (float(value) for value in given)  # type: ignore[union-attr]
    except (TypeError, ValueError) as exc:
        what = f"{key} is {str(given)[:40]}; give first, step and last, or Theta and Phi by row."
        raise refusal(path, 1, what) from exc
    count = (last - first) / step if step > 0.0 and last > first else math.nan
    if not 1.0 <= count < _MOST_SAMPLES or abs(count - round(count)) > 1e-3:
        raise refusal(path, 1, f"{key} {given} makes no axis; correct first, step and last.")
    return np.linspace(first, first + step * round(count), round(count) + 1)


def _powers(
    path: Path, columns: dict[str, FloatArray]
) -> tuple[tuple[FloatArray, FloatArray, FloatArray] | None, tuple[str, ...]]:
    """Return total, co and cross power below the maximum [-], as far as they are told."""
    told = [name for name in (_TOTAL, _CO, _CROSS) if name in columns]
    if not told or (told == [_CROSS]):
        what = f"no column {_TOTAL} or {_CO} is in Data_Set_Row_Structure; nothing can be read."
        raise refusal(path, 1, what)
    for name in told:
        if columns[name].min() < -0.5:
            what = f"{name} falls to {columns[name].min():g} dB; attenuation is positive."
            raise refusal(path, 1, what)
    power = {name: 10.0 ** (-columns[name] / 10.0) for name in told}
    if _CO not in power:
        return None, ()
    total = power.get(_TOTAL)
    if total is None:
        total = power[_CO] + power.get(_CROSS, 0.0)
    cross = power.get(_CROSS)
    if cross is None:
        cross = np.maximum(total - power[_CO], 0.0)
    added = power[_CO] + cross
    with np.errstate(divide="ignore"):
        off = np.abs(decibels(np.maximum(added, 1e-30)) - decibels(np.maximum(total, 1e-30)))
    worst = float(np.where(total > 10.0 ** (-_FAINT_DB / 10.0), off, 0.0).max())
    if worst > _AGREEMENT_DB:
        note = (
            f"{path}: co and cross polarisation are up to {worst:.1f} dB off the total power, "
            "which is kept; they say how it is shared"
        )
        return (total, power[_CO], cross), (note,)
    return (total, power[_CO], cross), ()


def _field(
    path: Path,
    one: dict[str, Any],
    columns: dict[str, FloatArray],
    power: tuple[FloatArray, FloatArray, FloatArray] | None,
) -> tuple[npt.NDArray[np.complex128], bool, tuple[str, ...]]:
    """Return F_theta and F_phi (2, n) below the maximum, whether phases are known, and notes."""
    named = str(one.get("Nominal_Polarization", "")).strip().upper()
    angle = {"V": 0.0, "H": 90.0, "+": 45.0, "-": -45.0, "4": 45.0}.get(named[:1])
    notes: tuple[str, ...] = ()
    if angle is None:
        angle = 0.0
        notes = (f"{path} names no known polarisation: it is taken as theta (vertical)",)
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    if power is None:
        total = amplitude(-columns[_TOTAL])
        return np.stack([abs(c) * total, s * total]).astype(np.complex128), False, notes
    total, co, cross = power
    level = np.sqrt(total / np.maximum(co + cross, 1e-300))
    parts = np.sqrt(np.stack([co, cross])).astype(np.complex128) * level
    known = all(name in columns for name in _PHASES)
    if known:
        parts *= np.exp(1j * np.radians(np.stack([columns[name] for name in _PHASES])))
        return np.stack([c * parts[0] - s * parts[1], s * parts[0] + c * parts[1]]), True, notes
    # Without phases only the powers along theta and phi can be told, as the mean over all phases.
    shares = np.array([[c * c, s * s], [s * s, c * c]]) @ np.abs(parts) ** 2
    signs = np.array([[1.0], [math.copysign(1.0, s)]])
    return (signs * np.sqrt(shares)).astype(np.complex128), False, notes


def _gridded(
    path: Path, theta_deg: FloatArray, phi_deg: FloatArray, field: npt.NDArray[np.complex128]
) -> tuple[FloatArray, FloatArray, npt.NDArray[np.complex128]]:
    """Return ascending axes [deg] and the field (2, T, P) of rows in any order."""
    theta, row = np.unique(np.round(theta_deg, 6), return_inverse=True)
    phi, column = np.unique(np.round(phi_deg, 6), return_inverse=True)
    if len(theta) * len(phi) > 4 * field.shape[1]:
        what = "the directions are scattered, not a grid; every Theta is needed with every Phi."
        raise refusal(path, 1, what)
    grid = np.full((2, len(theta), len(phi)), np.nan + 0j)
    grid[:, row, column] = field
    if len(np.unique(row * len(phi) + column)) < field.shape[1]:
        raise refusal(path, 1, "one direction is given twice; keep one of them.")
    missing = np.argwhere(np.isnan(grid[0]))
    if missing.size:
        i, j = missing[0]
        if theta[i] in (0.0, 180.0) and not np.isnan(grid[0, i]).all():
            pole = grid[:, i, ~np.isnan(grid[0, i])][:, 0]
            grid[:, i] = np.where(np.isnan(grid[0, i]), pole[:, None], grid[:, i])
            if not np.isnan(grid[0]).any():
                return theta, phi, grid
        what = (
            f"direction theta = {theta[i]:g} deg, phi = {phi[j]:g} deg is missing; give every "
            "theta with every phi."
        )
        raise refusal(path, 1, what)
    return theta, phi, grid


def _gain(path: Path, one: dict[str, Any]) -> float:
    """Return the gain that attenuations count from [dBi]."""
    value, unit = _quantity(path, one, "Gain")
    if unit.lower() not in ("dbi", "dbd"):
        raise refusal(path, 1, f"Gain is in {unit!r}; dBi or dBd are read.")
    return checked_gain_dbi(path, 1, value + (DIPOLE_DBI if unit.lower() == "dbd" else 0.0))


def _frequency(path: Path, one: dict[str, Any]) -> float | None:
    if "Frequency" not in one:
        return None
    value, unit = _quantity(path, one, "Frequency")
    if unit.upper() not in HERTZ or not value > 0.0:
        raise refusal(path, 1, f"Frequency {value:g} {unit[:10]} is no frequency; correct it.")
    return value * HERTZ[unit.upper()]


def _quantity(path: Path, one: dict[str, Any], key: str) -> tuple[float, str]:
    found = one.get(key)
    try:
        value, unit = float(found["value"]), str(found["unit"])  # type: ignore[index]
    except (TypeError, KeyError, ValueError) as exc:
        what = f'{key} is {str(found)[:40]}; give {{"value": ..., "unit": ...}}.'
        raise refusal(path, 1, what) from exc
    if not math.isfinite(value):
        raise refusal(path, 1, f"{key} is {value}; give a finite number.")
    return value, unit
