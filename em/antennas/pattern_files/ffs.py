"""CST far-field sources (``.ffs``, version 3): complex r E with the powers it belongs to.

CST uses e^{+j w t} and peak values [V], phase at the file's position. The header gives radiated,
accepted and stimulated (incident) mean power per frequency; F is realised gain, |F|^2 = 2 pi |rE|^2
/ (eta P_stimulated). Unknown powers may be -1 (the radiated one then follows by integration) or
efficiencies with a minus sign. Source: CST Studio Suite online help, "Farfield Source File Format".
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.antennas.pattern_files._grids import fold, loop_grid
from octant.em.antennas.pattern_files._lines import Row, numbers, read_lines, refusal, whole_number
from octant.em.antennas.pattern_files.common import (
    VOLT_PER_ROOT_WATT,
    PatternTable,
    mean_over_sphere,
)

_COLUMNS = 6  # phi, theta, Re(E_theta), Im(E_theta), Re(E_phi), Im(E_phi)


def read_ffs(path: Path) -> tuple[PatternTable, ...]:
    """Return a CST ``.ffs`` file's realised gains, one table a frequency, phase at its position.

    Parameters
    ----------
    path : The file, version 3 with data type Farfield, axes not turned.
    """
    sections = list(_sections(path))
    header = {name: (line, rows) for line, name, rows in reversed(sections)}
    frequencies = whole_number(path, *_first(path, header, "#frequencies"))
    kind_line, kind = _first(path, header, "data type")
    if kind.lower() != "farfield":
        raise refusal(path, kind_line, f"data type {kind!r}; only Farfield is read.")
    origin = _vector(path, header, "position", (0.0, 0.0, 0.0))
    for name, axis in (("zaxis", (0.0, 0.0, 1.0)), ("xaxis", (1.0, 0.0, 0.0))):
        vector = _vector(path, header, name, axis)
        if np.linalg.norm(vector - np.linalg.norm(vector) * np.array(axis)) > 1e-6:
            what = f"{name} is turned; export the far field in the global axes."
            raise refusal(path, header[name][0], what)
    powers = _powers(path, header, frequencies)
    grids = [(line, rows) for line, name, rows in sections if name.startswith(">> total #phi")]
    blocks = [(line, rows) for line, name, rows in sections if name.startswith(">> phi, theta")]
    if len(grids) == 1:
        grids *= len(blocks)
    if not len(grids) == len(blocks) == frequencies:
        what = f"{len(blocks)} far fields where {frequencies} are announced; some are missing."
        raise refusal(path, sections[-1][0], what)
    return tuple(
        _table(path, grid, block, power, origin)
        for grid, block, power in zip(grids, blocks, powers, strict=True)
    )


def _sections(path: Path) -> Iterator[tuple[int, str, list[tuple[int, list[str]]]]]:
    """Yield line, lower-case name and content lines of every ``//`` section."""
    name, start = "", 0
    content: list[tuple[int, list[str]]] = []
    for line, text in enumerate(read_lines(path), start=1):
        stripped = text.strip()
        if stripped.startswith("//"):
            if start:
                yield start, name, content
            name, start, content = stripped[2:].strip(" :").lower(), line, []
        elif stripped and not start:
            raise refusal(path, line, "content before the header '// CST Farfield Source File'.")
        elif stripped:
            content.append((line, stripped.split()))
    if start:
        yield start, name, content
    else:
        raise refusal(path, 1, "no '//' section is in the file; it is not a far-field source.")


_Header = dict[str, tuple[int, list[tuple[int, list[str]]]]]


def _first(path: Path, header: _Header, name: str) -> tuple[int, str]:
    """Return line and first word of a section."""
    if name not in header or not header[name][1]:
        line = header[name][0] if name in header else 1
        raise refusal(path, line, f"section '// {name}' is missing or empty; add it.")
    line, tokens = header[name][1][0]
    return line, tokens[0]


def _vector(
    path: Path, header: _Header, name: str, default: Sequence[float]
) -> npt.NDArray[np.float64]:
    """Return the three numbers of a section."""
    if name not in header:
        return np.array(default)
    _first(path, header, name)
    line, tokens = header[name][1][0]
    return np.array(numbers(path, line, tokens, 3).values)


def _powers(path: Path, header: _Header, frequencies: int) -> list[tuple[Row, Row, Row, Row]]:
    """Return radiated, accepted, stimulated power and frequency of every far field."""
    name = next((key for key in header if key.startswith("radiated/accepted/stimulated")), "")
    if not name:
        what = "section '// Radiated/Accepted/Stimulated Power , Frequency' is missing; add it."
        raise refusal(path, 1, what)
    start, content = header[name]
    words = [numbers(path, line, [token], 1) for line, tokens in content for token in tokens]
    if len(words) != 4 * frequencies:
        what = f"{len(words)} numbers where 4 a frequency ({4 * frequencies}) are needed."
        raise refusal(path, content[-1][0] if content else start, what)
    return [(words[i], words[i + 1], words[i + 2], words[i + 3]) for i in range(0, len(words), 4)]


def _table(
    path: Path,
    grid: tuple[int, list[tuple[int, list[str]]]],
    block: tuple[int, list[tuple[int, list[str]]]],
    power: tuple[Row, Row, Row, Row],
    origin: npt.NDArray[np.float64],
) -> PatternTable:
    """Return one far field as a table."""
    if not grid[1]:
        raise refusal(path, grid[0], "the numbers of phi and theta samples are missing; add them.")
    line, tokens = grid[1][0]
    phis, thetas = (whole_number(path, line, str(x)) for x in numbers(path, line, tokens, 2).values)
    rows = [numbers(path, line, tokens, _COLUMNS) for line, tokens in block[1]]
    if len(rows) != phis * thetas:
        what = f"{len(rows)} directions where {phis} x {thetas} are announced."
        raise refusal(path, rows[-1].line if rows else block[0], what)
    theta_deg, phi_deg, values = loop_grid(path, rows, theta_column=1, phi_column=0)
    if (len(theta_deg), len(phi_deg)) != (thetas, phis):
        what = f"the grid is {len(phi_deg)} x {len(theta_deg)}, not {phis} x {thetas} (phi, theta)."
        raise refusal(path, rows[-1].line, what)
    field_v = np.stack((values[2] + 1j * values[3], values[4] + 1j * values[5]))
    theta_rad, phi_rad, field_v = fold(path, rows[0].line, theta_deg, phi_deg, field_v)
    square_v2 = np.sum(np.abs(field_v) ** 2, axis=0)
    integral_w = mean_over_sphere(theta_rad, phi_rad, square_v2) / VOLT_PER_ROOT_WATT**2
    stimulated_w, warnings = _stimulated(path, power, integral_w)
    frequency_hz = power[3].values[0]
    if frequency_hz <= 0.0:
        raise refusal(path, power[3].line, f"frequency {frequency_hz:g} Hz; give more than 0 Hz.")
    return PatternTable(
        frequency_hz=frequency_hz,
        theta_rad=theta_rad,
        phi_rad=phi_rad,
        field=field_v / (VOLT_PER_ROOT_WATT * np.sqrt(stimulated_w)),
        kind="realised_gain",
        name=path.stem,
        source=f"{path}, line {rows[0].line}",
        origin_m=origin,
        warnings=warnings,
    )


def _stimulated(
    path: Path, power: tuple[Row, Row, Row, Row], integral_w: float
) -> tuple[float, tuple[str, ...]]:
    """Return the stimulated power [W], by the rules for unknown powers, and doubts."""
    radiated_w, _, stimulated_w, _ = (row.values[0] for row in power)
    warnings: tuple[str, ...] = ()
    if radiated_w > 0.0 and integral_w > 0.0:
        ratio = integral_w / radiated_w
        if not 0.8 < ratio < 1.25:
            text = (
                f"{path}, line {power[0].line}: the field integrates to {ratio:.3g} times the "
                "radiated power that the header gives: levels are in doubt"
            )
            warnings = (text,)
    elif radiated_w < 0.0:
        radiated_w = integral_w
    if stimulated_w < 0.0:  # an efficiency with a minus sign; -1 stands for a perfect antenna
        stimulated_w = radiated_w / -stimulated_w
    if not stimulated_w > 0.0:
        what = "the stimulated power must be above 0 W, or -1 where it is not known."
        raise refusal(path, power[2].line, what)
    return stimulated_w, warnings
