"""Patterns as CSV: complex grids, grids of gain, and pairs of cuts.

The header's names say what a file is; columns may stand in any order, ``#`` opens a comment.

- complex grid: ``theta_deg, phi_deg, f_theta_re, f_theta_im, f_phi_re, f_phi_im``, |F|^2 = gain;
- gains: ``theta_deg, phi_deg, gain_theta_db, gain_phi_db`` or only ``gain_db`` (then all theta);
- two cuts: ``cut, angle_deg, gain_db`` with ``horizontal`` (azimuth from the main direction +x,
  counter-clockwise; along the horizon, or through a tilted beam) and ``vertical`` (elevation in
  the plane of the main direction, upwards).

Further columns are optional: ``table`` and ``frequency_hz`` (a new value starts a new table),
``name``, ``kind`` (directivity, gain, realised_gain; gain where it is left out) and ``origin_x_m``,
``origin_y_m``, ``origin_z_m`` (what the phase is referred to). Phase is that of e^{+j w t}.
"""

import csv
import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import cast, get_args

import numpy as np
import numpy.typing as npt

from octant.em.antennas.pattern_files._grids import fold, loop_grid
from octant.em.antennas.pattern_files._lines import (
    Row,
    checked_gain_dbi,
    number,
    read_lines,
    refusal,
)
from octant.em.antennas.pattern_files._two_cuts import (
    closed_cut,
    cut_step_deg,
    spread_two_cuts,
    two_cuts_warnings,
)
from octant.em.antennas.pattern_files.common import (
    NO_PHASE_WARNING,
    PatternKind,
    PatternTable,
    amplitude,
)
from octant.geometries.errors import PatternFileError
from octant.geometries.files import write_text

_COMPLEX = ("f_theta_re", "f_theta_im", "f_phi_re", "f_phi_im")
_GAINS = ("gain_theta_db", "gain_phi_db")
_ORIGIN = ("origin_x_m", "origin_y_m", "origin_z_m")
_ALL_THETA = "{source} does not name the polarisation: all of its gain is taken as theta (vertical)"
_TEXT = ("table", "name", "kind", "cut")
_ANGLES = ("theta_deg", "phi_deg", "angle_deg")
_KNOWN = (*_TEXT, "frequency_hz", *_ANGLES, "gain_db", *_COMPLEX, *_GAINS, *_ORIGIN)


@dataclass(slots=True)
class _Group:
    """The rows of one table while the file is read."""

    line: int
    text: dict[str, str]
    rows: list[tuple[int, dict[str, float], str]] = field(default_factory=list)


def read_csv(path: Path) -> tuple[PatternTable, ...]:
    """Return the patterns of a CSV file, in its order.

    Parameters
    ----------
    path : The file, in one of this module's three forms.
    """
    names, groups = _groups(path)
    if "cut" in names:
        return tuple(_two_cuts(path, group) for group in groups)
    return tuple(_grid(path, names, group) for group in groups)


def _groups(path: Path) -> tuple[list[str], list[_Group]]:
    """Return the column names and the rows, split into tables."""
    names: list[str] = []
    groups: list[_Group] = []
    key: tuple[str, ...] = ()
    for line, cells in _cells(path):
        if not names:
            names = _header(path, line, [cell.lower() for cell in cells])
            continue
        if len(cells) != len(names):
            what = f"{len(cells)} columns where {len(names)} are needed; correct the line."
            raise refusal(path, line, what)
        record = dict(zip(names, cells, strict=True))
        text = {name: record.pop(name) for name in _TEXT if name in record}
        values = {name: number(path, line, cell) for name, cell in record.items()}
        new_key = (text.get("table", ""), record.get("frequency_hz", ""))
        if not groups or new_key != key:
            groups.append(_Group(line=line, text=text))
            key = new_key
        groups[-1].rows.append((line, values, text.get("cut", "").lower()))
    if not names:
        raise refusal(path, 1, "no header is in the file; name the columns in its first line.")
    if not groups:
        raise refusal(path, 1, "the file has a header but no directions; add them.")
    return names, groups


def _cells(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Yield line number and cells of every line that is not a comment."""
    for line, text in enumerate(read_lines(path), start=1):
        if text.strip() and not text.lstrip().startswith("#"):
            try:
                cells = next(csv.reader([text], strict=True, skipinitialspace=True))
            except csv.Error as exc:
                raise refusal(path, line, f"the line is not CSV ({exc}); correct it.") from exc
            yield line, [cell.strip() for cell in cells]


def _header(path: Path, line: int, names: list[str]) -> list[str]:
    """Return the column names, checked."""
    unknown = [name for name in names if name not in _KNOWN]
    if unknown or len(set(names)) < len(names):
        what = (
            f"column {(unknown or names)[0][:40]!r} is unknown, or a column comes twice; the "
            f"columns are {', '.join(_KNOWN)}."
        )
        raise refusal(path, line, what)
    wanted: tuple[str, ...] = ("angle_deg", "gain_db")
    if "cut" not in names:
        wanted = ("theta_deg", "phi_deg")
        if any(name in names for name in _COMPLEX):
            wanted = (*wanted, *_COMPLEX)
        elif any(name in names for name in _GAINS):
            wanted = (*wanted, *_GAINS)
        else:
            wanted = (*wanted, "gain_db")
    lacking = [name for name in wanted if name not in names]
    if lacking:
        raise refusal(path, line, f"column {lacking[0]!r} is missing in the header; add it.")
    return names


def _grid(path: Path, names: Sequence[str], group: _Group) -> PatternTable:
    """Return one table on a grid of directions."""
    columns = [name for name in names if name not in _TEXT]
    rows = [
        Row(line=line, values=tuple(values[name] for name in columns))
        for line, values, _ in group.rows
    ]
    theta_deg, phi_deg, grid = loop_grid(
        path,
        rows,
        theta_column=columns.index("theta_deg"),
        phi_column=columns.index("phi_deg"),
    )
    place = {name: at for at, name in enumerate(columns)}
    phase_known = "f_theta_re" in place
    source = f"{path}, line {group.line}"
    warnings: tuple[str, ...] = ()
    if phase_known:
        re_t, im_t, re_p, im_p = (grid[place[name]] for name in _COMPLEX)
        pattern = np.stack((re_t + 1j * im_t, re_p + 1j * im_p))
    else:
        gains = [name for name in (*_GAINS, "gain_db") if name in place]
        for line, values, _ in group.rows:
            for name in gains:
                checked_gain_dbi(path, line, values[name])
        warnings = (NO_PHASE_WARNING.format(source=source),)
        if gains[0] in _GAINS:
            pattern = amplitude(np.stack([grid[place[name]] for name in _GAINS])) + 0j
        else:
            total = amplitude(grid[place["gain_db"]])
            pattern = np.stack((total, np.zeros_like(total))) + 0j
            warnings = (*warnings, _ALL_THETA.format(source=source))
    theta_rad, phi_rad, pattern = fold(
        path, group.line, theta_deg, phi_deg, pattern, signed=phase_known
    )
    return _made(path, group, (theta_rad, phi_rad, pattern), phase_known, warnings)


def _two_cuts(path: Path, group: _Group) -> PatternTable:
    """Return one table spread from two cuts."""
    given = []
    for wanted in ("horizontal", "vertical"):
        rows = [(line, values) for line, values, cut in group.rows if cut == wanted]
        if not rows:
            raise refusal(path, group.line, f"the {wanted} cut is missing; both cuts are needed.")
        level = [checked_gain_dbi(path, line, values["gain_db"]) for line, values in rows]
        angle = np.array([values["angle_deg"] for _, values in rows])
        given.append((rows[0][0], angle, np.array(level)))
    for line, _, cut in group.rows:
        if cut not in ("horizontal", "vertical"):
            what = f"cut {cut[:20]!r} is unknown; allowed are horizontal and vertical."
            raise refusal(path, line, what)
    step_deg = cut_step_deg(*(angle for _, angle, _ in given))
    cuts = [closed_cut(path, *one, step_deg=step_deg) for one in given]
    theta_rad, phi_rad, level_db = spread_two_cuts(*cuts)
    total = amplitude(level_db)
    pattern = np.stack((total, np.zeros_like(total))).astype(np.complex128)
    source = f"{path}, line {group.line}"
    warnings = (
        NO_PHASE_WARNING.format(source=source),
        *two_cuts_warnings(source, *cuts),
        _ALL_THETA.format(source=source),
    )
    return _made(path, group, (theta_rad, phi_rad, pattern), False, warnings)


def _made(
    path: Path,
    group: _Group,
    grid: tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], npt.NDArray[np.complex128]],
    phase_known: bool,
    warnings: tuple[str, ...],
) -> PatternTable:
    """Return the table of a group, with what its optional columns say."""
    line, values, _ = group.rows[0]
    kind = group.text.get("kind", "") or "gain"
    if kind not in get_args(PatternKind):
        what = f"kind {kind[:20]!r} is unknown; allowed are {', '.join(get_args(PatternKind))}."
        raise refusal(path, line, what)
    frequency_hz = values.get("frequency_hz")
    if frequency_hz is not None and frequency_hz <= 0.0:
        raise refusal(path, line, f"frequency {frequency_hz:g} Hz; give more than 0 Hz.")
    return PatternTable(
        frequency_hz=frequency_hz,
        theta_rad=grid[0],
        phi_rad=grid[1],
        field=grid[2],
        kind=cast("PatternKind", kind),
        phase_known=phase_known,
        name=group.text.get("name", "") or path.stem,
        source=f"{path}, line {group.line}",
        origin_m=tuple(values.get(name, 0.0) for name in _ORIGIN),
        warnings=warnings,
    )


def write_csv(path: str | Path, tables: Sequence[PatternTable]) -> None:
    """Write tables as a CSV grid that comes back exactly.

    Parameters
    ----------
    path : The file; replaced where it exists.
    tables : All with phase (complex grid) or all without (gains); all with a frequency or none.
    """
    path = Path(path)
    known = {(table.phase_known, table.frequency_hz is None) for table in tables}
    if len(known) != 1:
        msg = (
            f"{path}: {len(tables)} tables that differ in phase or frequency do not make one CSV; "
            "write those with and those without to separate files."
        )
        raise PatternFileError(msg)
    phase_known, no_frequency = next(iter(known))
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    middle = [] if no_frequency else ["frequency_hz"]
    ends = _COMPLEX if phase_known else _GAINS
    writer.writerow(["table", "name", "kind", *_ORIGIN, *middle, "theta_deg", "phi_deg", *ends])
    for index, table in enumerate(tables, start=1):
        name = " ".join(table.name.split())
        start = [str(index), name, table.kind, *(repr(float(x)) for x in table.origin_m)]
        start += [] if table.frequency_hz is None else [repr(float(table.frequency_hz))]
        theta_deg, phi_deg = np.degrees(table.theta_rad), np.degrees(table.phi_rad)
        gain_db = 20.0 * np.log10(np.maximum(np.abs(table.field), 1e-20))
        for i, theta in enumerate(theta_deg):
            for j, phi in enumerate(phi_deg):
                f_t, f_p = table.field[:, i, j]
                values = (f_t.real, f_t.imag, f_p.real, f_p.imag)
                tail = values if phase_known else tuple(gain_db[:, i, j])
                writer.writerow([*start, *(repr(float(x)) for x in (theta, phi, *tail))])
    write_text(path, out.getvalue())
