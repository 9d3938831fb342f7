"""FEKO far fields (``.ffe``): blocks of complex field and gain, one block a request and frequency.

FEKO uses e^{+j w t} and peak values of r E [V], phase at the block's origin. Gain columns [dB] give
the level; a block of fields without them needs the incident power. Source: Altair Feko 2021 User
Guide, appendix "Far Fields (.FFE)" and "General File Format".
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.antennas.pattern_files._grids import fold, loop_grid
from octant.em.antennas.pattern_files._lines import (
    Row,
    checked_gain_dbi,
    number,
    numbers,
    read_lines,
    refusal,
    whole_number,
)
from octant.em.antennas.pattern_files.common import (
    DBI_FLOOR,
    NO_PHASE_WARNING,
    VOLT_PER_ROOT_WATT,
    PatternKind,
    PatternTable,
    amplitude,
)
from octant.em.decibels import decibels
from octant.geometries.errors import PatternFileError
from octant.geometries.files import write_text

_REALISED_COMMENT = "the gain columns hold realised gain"
_FIELD_COLUMNS = ("theta", "phi", "re(etheta)", "im(etheta)", "re(ephi)", "im(ephi)")
_KINDS: dict[str, PatternKind] = {
    "directivity": "directivity",
    "gain": "gain",
    "realisedgain": "realised_gain",
    "realizedgain": "realised_gain",
}
_AGREEMENT_DB = 0.1


@dataclass(slots=True)
class _Block:
    """One solution block while it is read."""

    line: int
    keys: dict[str, tuple[int, str]] = field(default_factory=dict)
    columns: list[str] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)
    realised: bool = False


def read_ffe(path: Path, *, incident_power_w: float | None = None) -> tuple[PatternTable, ...]:
    """Return the far fields of a FEKO ``.ffe`` file, one table a block.

    Parameters
    ----------
    path : The file.
    incident_power_w : Power [W] incident on the port, for blocks that have no gain columns.
    """
    tables = tuple(_table(path, block, incident_power_w) for block in _blocks(path))
    if not tables:
        raise refusal(path, 1, "no far field is in the file; a block starts with '#Frequency:'.")
    return tables


def _blocks(path: Path) -> Iterator[_Block]:
    """Yield the solution blocks of a file."""
    block: _Block | None = None
    carried: dict[str, tuple[int, str]] = {}
    realised = False
    for line, raw in enumerate(read_lines(path), start=1):
        realised = realised or (raw.startswith("**") and _REALISED_COMMENT in raw.lower())
        text = raw.split("**", 1)[0].strip()
        if not text or text.startswith("##"):
            continue
        if text.startswith("#"):
            if block is None or block.rows:
                if block is not None:
                    yield block
                    carried = {k: v for k, v in block.keys.items() if k.endswith(" name")}
                block = _Block(line=line, keys=dict(carried), realised=realised)
            key, colon, value = text[1:].partition(":")
            if colon and '"' not in key:
                block.keys[key.strip().lower()] = (line, value.strip())
            else:
                names = text[1:].split('"')[1::2] or text[1:].split()
                block.columns = ["".join(name.lower().split()) for name in names]
            continue
        if block is None:
            raise refusal(path, line, "numbers before any header; '#Frequency:' is missing.")
        tokens = text.split()
        wanted = len(block.columns) or (9 if block.rows == [] and len(tokens) == 9 else 6)
        if block.rows and not block.columns:
            wanted = len(block.rows[0].values)
        block.rows.append(numbers(path, line, tokens, wanted))
    if block is not None:
        yield block


def _table(path: Path, block: _Block, incident_power_w: float | None) -> PatternTable:
    """Return one block as a table."""
    frequency_hz = _frequency(path, block)
    _check_header(path, block)
    columns = block.columns
    if not columns:
        gains = ["gain(theta)", "gain(phi)", "gain(total)"]
        columns = [*_FIELD_COLUMNS, *gains][: len(block.rows[0].values)]
    lacking = [name for name in _FIELD_COLUMNS[:2] if name not in columns]
    if lacking:
        raise refusal(path, block.line, f'column "{lacking[0]}" is missing in the block.')
    theta_deg, phi_deg, grid = loop_grid(
        path,
        block.rows,
        theta_column=columns.index("theta"),
        phi_column=columns.index("phi"),
    )
    _check_counts(path, block, len(theta_deg), len(phi_deg))
    kind, parts = _gain_columns(columns)
    if "realis" in block.keys.get("result type", (0, ""))[1].lower() or block.realised:
        kind = "realised_gain"
    field_v: npt.NDArray[np.complex128] = np.zeros((2, *grid.shape[1:]), dtype=np.complex128)
    if all(name in columns for name in _FIELD_COLUMNS):
        re_t, im_t, re_p, im_p = (grid[columns.index(name)] for name in _FIELD_COLUMNS[2:])
        field_v = np.stack((re_t + 1j * im_t, re_p + 1j * im_p))
    source = f"{path}, line {block.line}"
    warnings: tuple[str, ...] = ()
    phase_known = bool(field_v.any())
    if phase_known:
        total = parts.get("total")
        scale = _scale(path, block.rows, columns, total, incident_power_w)
        kind = kind if total is not None else "realised_gain"
        pattern: npt.NDArray[np.complex128] = scale * field_v
    else:
        pattern, note = _amplitudes(path, block.rows, grid, parts)
        warnings = (NO_PHASE_WARNING.format(source=source), *note)
    theta_rad, phi_rad, pattern = fold(
        path, block.rows[0].line, theta_deg, phi_deg, pattern, signed=phase_known
    )
    name = block.keys.get("request name", block.keys.get("configuration name", (0, path.stem)))[1]
    return PatternTable(
        frequency_hz=frequency_hz,
        theta_rad=theta_rad,
        phi_rad=phi_rad,
        field=pattern,
        kind=kind,
        phase_known=phase_known,
        name=name,
        source=source,
        origin_m=_origin(path, block),
        warnings=warnings,
    )


def _frequency(path: Path, block: _Block) -> float:
    """Return the block's frequency [Hz]."""
    if "frequency" not in block.keys:
        raise refusal(path, block.line, "'#Frequency:' is missing in the block's header; add it.")
    line, text = block.keys["frequency"]
    frequency_hz = number(path, line, (text.split() or [""])[0])
    if frequency_hz <= 0.0:
        raise refusal(path, line, f"frequency {text} Hz is not a frequency; give more than 0 Hz.")
    return frequency_hz


def _check_header(path: Path, block: _Block) -> None:
    """Refuse blocks that are not an antenna pattern in global spherical coordinates."""
    line, system = block.keys.get("coordinate system", (block.line, "Spherical"))
    if system.lower() != "spherical":
        raise refusal(path, line, f"coordinate system {system!r}; only Spherical is read.")
    line, result = block.keys.get("result type", (block.line, "Gain"))
    if "rcs" in result.lower() or any("rcs" in name for name in block.columns):
        raise refusal(
            path, line, "a radar cross-section is not an antenna pattern; export the gain."
        )
    for key, axis in (("u-vector", (1.0, 0.0, 0.0)), ("v-vector", (0.0, 1.0, 0.0))):
        if key in block.keys:
            line, text = block.keys[key]
            vector = np.subtract(_triple(path, line, text), _origin(path, block))
            if np.linalg.norm(vector - np.array(axis) * np.linalg.norm(vector)) > 1e-6:
                what = f"{key} {text} turns the axes; export in the global coordinate system."
                raise refusal(path, line, what)
    if not block.rows:
        raise refusal(path, block.line, "the block has a header but no directions; add them.")


def _check_counts(path: Path, block: _Block, thetas: int, phis: int) -> None:
    """Refuse a block whose header announces another number of samples."""
    for key, found in (("no. of theta samples", thetas), ("no. of phi samples", phis)):
        if key not in block.keys:
            raise refusal(path, block.line, f"'#{key}' is missing in the block's header; add it.")
        line, text = block.keys[key]
        if whole_number(path, line, text) != found:
            what = f"the header announces {text} ({key}) but {found} are there; directions differ."
            raise refusal(path, block.rows[-1].line, what)


def _triple(path: Path, line: int, text: str) -> tuple[float, ...]:
    """Return three numbers of a header line such as ``(0, 0, 0)``."""
    return numbers(path, line, re.sub(r"[(),;]", " ", text).split(), 3).values


def _origin(path: Path, block: _Block) -> tuple[float, ...]:
    """Return the block's origin [m]."""
    line, text = block.keys.get("origin", (block.line, "(0, 0, 0)"))
    return _triple(path, line, text)


def _gain_columns(columns: Sequence[str]) -> tuple[PatternKind, dict[str, int]]:
    """Return what the gain columns hold, and where theta, phi and total stand."""
    kind: PatternKind = "gain"
    parts: dict[str, int] = {}
    for at, name in enumerate(columns):
        prefix, _, part = name.rstrip(")").partition("(")
        if prefix in _KINDS and part in ("theta", "phi", "total"):
            kind, parts[part] = _KINDS[prefix], at
    return kind, parts


def _scale(
    path: Path,
    rows: Sequence[Row],
    columns: Sequence[str],
    total: int | None,
    incident_power_w: float | None,
) -> float:
    """Return the factor [1/V] from the field to F, from gain columns or the incident power."""
    if total is None:
        if incident_power_w is None:
            what = "the block has fields but no gain columns; give incident_power_w [W] with it."
            raise refusal(path, rows[0].line, what)
        return 1.0 / (VOLT_PER_ROOT_WATT * math.sqrt(incident_power_w))
    places = [columns.index(name) for name in _FIELD_COLUMNS[2:]]
    table = np.array([row.values for row in rows])
    power_v2 = np.sum(table[:, places] ** 2, axis=1)
    gain_db = np.array([checked_gain_dbi(path, row.line, row.values[total]) for row in rows])
    strong = gain_db > max(gain_db.max() - 20.0, DBI_FLOOR)
    if not strong.any() or not power_v2[strong].any():
        raise refusal(path, rows[0].line, "the gain columns say that nothing is radiated.")
    gain = 10.0 ** (gain_db / 10.0)
    squared = float(gain[strong].sum() / power_v2[strong].sum())
    off_db = np.abs(decibels(np.maximum(squared * power_v2, 1e-30)) - gain_db)
    wrong = np.flatnonzero(strong & (off_db > _AGREEMENT_DB))
    if wrong.size:
        row = rows[int(wrong[0])]
        what = (
            f"field and gain disagree by {off_db[wrong[0]]:.2f} dB; |E|^2 and the total gain must "
            "keep one ratio over the block."
        )
        raise refusal(path, row.line, what)
    return math.sqrt(squared)


def _amplitudes(
    path: Path, rows: Sequence[Row], grid: npt.NDArray[np.float64], parts: dict[str, int]
) -> tuple[npt.NDArray[np.complex128], tuple[str, ...]]:
    """Return |F| of both components from gain columns alone, and what was assumed."""
    if not parts:
        raise refusal(path, rows[0].line, "neither field nor gain columns; export one of them.")
    for row in rows:
        for at in parts.values():
            checked_gain_dbi(path, row.line, row.values[at])
    if "theta" in parts and "phi" in parts:
        both = amplitude(np.stack((grid[parts["theta"]], grid[parts["phi"]])))
        total = amplitude(grid[parts["total"]]) if "total" in parts else np.hypot(*both)
        # some programs fill only the total and leave zeros in the parts
        if both.any() and np.abs(np.hypot(*both) - total).max() < 0.05 * total.max():
            return both.astype(np.complex128), ()
    if "total" not in parts:
        raise refusal(
            path, rows[0].line, "one polarisation's gain alone; export both or the total."
        )
    total = amplitude(grid[parts["total"]])
    note = f"{path} does not name the polarisation: all of its gain is taken as theta (vertical)"
    return np.stack((total, np.zeros_like(total))).astype(np.complex128), (note,)


def write_ffe(path: str | Path, tables: Sequence[PatternTable]) -> None:
    """Write tables as a FEKO ``.ffe`` file, one block a table.

    Parameters
    ----------
    path : The file; replaced where it exists.
    tables : Each with a frequency. The field [V peak] is that for 1 W of the table's kind
        (incident, accepted, radiated); zero without phase, with the gain alone.
    """
    path = Path(path)
    if not tables:
        msg = f"{path}: no table is given to write; give at least one."
        raise PatternFileError(msg)
    out = ["##File Type: Far field", "##File Format: 4", "##Source: octant"]
    kinds = {table.kind for table in tables}
    if "realised_gain" in kinds:
        if len(kinds) > 1:
            msg = f"{path}: realised gain and {kinds} do not go in one .ffe file; write two files."
            raise PatternFileError(msg)
        out.append(f"** {_REALISED_COMMENT}")
    for table in tables:
        out += _block_lines(path, table)
    write_text(path, "\n".join(out) + "\n")


def _block_lines(path: Path, table: PatternTable) -> list[str]:
    """Return one block's lines."""
    if table.frequency_hz is None:
        msg = f"{path}: table {table.name!r} has no frequency, which .ffe needs; give it one."
        raise PatternFileError(msg)
    field, phi_deg, theta_deg = table.field, np.degrees(table.phi_rad), np.degrees(table.theta_rad)
    if len(phi_deg) > 1 and abs(phi_deg[0] + 360.0 - phi_deg[-1] - np.diff(phi_deg)[0]) < 1e-6:
        phi_deg = np.append(phi_deg, 360.0 + phi_deg[0])
        field = np.concatenate((field, field[:, :, :1]), axis=2)
    label = "Directivity" if table.kind == "directivity" else "Gain"
    origin = ", ".join(repr(float(x)) for x in table.origin_m)
    heads = ("Theta", "Phi", "Re(Etheta)", "Im(Etheta)", "Re(Ephi)", "Im(Ephi)")
    gains = [f"{label}({part})" for part in ("Theta", "Phi", "Total")]
    lines = [
        "",
        f"#Request Name: {' '.join(table.name.split()) or 'octant'}",
        f"#Frequency: {float(table.frequency_hz)!r}",
        "#Coordinate System: Spherical",
        f"#Origin: ({origin})",
        f"#No. of Theta Samples: {len(theta_deg)}",
        f"#No. of Phi Samples: {len(phi_deg)}",
        f"#Result Type: {label}",
        "#No. of Header Lines: 1",
        "#  " + "  ".join(f'"{name}"' for name in (*heads, *gains)),
    ]
    volts = field * VOLT_PER_ROOT_WATT if table.phase_known else np.zeros_like(field)
    power = np.abs(field) ** 2
    power = np.concatenate((power, power.sum(axis=0, keepdims=True)))
    gain_db = decibels(np.maximum(power, 1e-99))
    # One column a quantity, theta running first.
    e_t, e_p = np.swapaxes(volts, 1, 2).reshape(2, -1)
    gains_db = np.swapaxes(gain_db, 1, 2).reshape(3, -1)
    angles = (np.tile(theta_deg, len(phi_deg)), np.repeat(phi_deg, len(theta_deg)))
    columns = (*angles, e_t.real, e_t.imag, e_p.real, e_p.imag, *gains_db)
    rows = np.stack(columns, axis=1).astype(np.float64).tolist()
    lines += [" ".join(map(repr, row)) for row in rows]
    return lines
