"""Antennas given by pattern files, measured or from another solver: one or a whole reader."""

import math
import warnings
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import GRID_STEP_DEG, ReaderResponse
from octant.em.antennas.kinds import Antenna
from octant.em.antennas.pattern_files.common import PatternTable, mean_over_sphere
from octant.em.antennas.pattern_files.reading import read_pattern
from octant.em.antennas.pattern_files.resample import (
    Outside,
    half_turn_steps,
    response_pattern,
    turned,
)
from octant.em.directions import angle_grid
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import PatternFileError, PhysicsWarning

FREQUENCY_TOLERANCE = 1e-3
"""Relative difference [-] up to which a table's frequency counts as the wanted one."""

WIDEST_INTERPOLATION = 0.05
"""Relative distance [-] of two tables up to which patterns are interpolated between them."""

_MOST_EFFICIENCY = 1.05
_SAME_RAD = 1e-6
_WIDEST_DEG = 60.0
_DIRECTIVE = 0.1
"""Share [-] of a pattern's power over azimuth in its first harmonic, from which it faces one way:
the length of the mean of unit vectors, weighted by power; 0 where it is equal all around."""


def reader_from_pattern_files(
    paths: Sequence[str | Path],
    *,
    azimuths_rad: npt.ArrayLike,
    frequency_hz: float,
    phase_centres_m: npt.ArrayLike | None = None,
    turns_rad: npt.ArrayLike = 0.0,
    load_ohm: float = 50.0,
    incident_power_w: float | None = None,
    step_deg: float | None = None,
    outside: Outside = "error",
) -> ReaderResponse:
    """Return a reader's response that is given entirely by pattern files (model ``files``).

    Files that are malformed, leave directions open or miss the frequency are refused. What they
    leave open (phase, realised gain, more power out than in) and what is not likely (one file for
    several antennas, a pattern that faces away from its antenna) is warned of and kept in its
    warnings.

    Parameters
    ----------
    paths : A file each, in order, in the reader's frame, phase at its centre or the file's origin.
    azimuths_rad : (n,) float — Azimuth [rad] of each antenna, antenna 1 at 0.
    frequency_hz : Frequency [Hz]: a file's table within 0.1 %, or its two nearest, at most 5 %
        apart around it, interpolated linearly.
    phase_centres_m : (n, 3) float — Where each antenna stands [m]: the phase is moved there, which
        keeps tables smooth; patterns without phase are centred there. None: the reader's centre.
    turns_rad : (n,) float, or one for all — Turn of each file about the reader's axis [rad], origin
        and phase with it: the antennas' azimuths where all files are of antenna 1.
    load_ohm : Load [ohm] of realised gain where a file gives the input impedance.
    incident_power_w : Power [W] behind files that do not tell it; see `read_pattern`.
    step_deg : Step [deg] of the response's grid; must divide 180 deg. None: about 1.5, so that the
        files' own directions are on it where they can be.
    outside : {"error", "zero"} — What to do where a file does not cover theta down to a pole.
    """
    azimuths = frozen_array(
        azimuths_rad, name="azimuths_rad", shape=(None,), error=PatternFileError
    )
    n = len(azimuths)
    if len(paths) != n or n < 1:
        msg = f"{len(paths)} pattern files for {n} antennas; give one file an antenna."
        raise PatternFileError(msg)
    for name, value in (("frequency_hz", frequency_hz), ("load_ohm", load_ohm)):
        if not (math.isfinite(value) and value > 0.0):
            msg = f"{name} = {value}; give a number above 0."
            raise PatternFileError(msg)
    centres = frozen_array(
        np.zeros((n, 3)) if phase_centres_m is None else phase_centres_m,
        name="phase_centres_m",
        shape=(n, 3),
        error=PatternFileError,
    )
    turns = frozen_array(
        np.broadcast_to(turns_rad, (n,)), name="turns_rad", shape=(n,), error=PatternFileError
    )
    read = {path: _read(Path(path), incident_power_w) for path in dict.fromkeys(paths)}
    if step_deg is None:
        step_deg = _grid_step_deg([table for tables in read.values() for table in tables])
    half_turn = half_turn_steps(step_deg)
    notes: dict[str, None] = {}
    patterns = []
    steps = np.zeros((half_turn, 2 * half_turn), dtype=np.bool_)
    for path, centre_m, turn_rad in zip(paths, centres, turns.tolist(), strict=True):
        pattern = np.zeros((2, half_turn + 1, 2 * half_turn), dtype=np.complex128)
        parts = _at_frequency(read[path], frequency_hz, notes)
        for weight, table in parts:
            matched = turned(_realised(table, load_ohm, notes), turn_rad)
            sampled, at_steps = response_pattern(
                matched,
                frequency_hz=table.frequency_hz or frequency_hz,
                phase_centre_m=centre_m,
                rows=half_turn + 1,
                columns=2 * half_turn,
                outside=outside,
            )
            pattern += weight * sampled
            steps |= at_steps
        _check_power(Path(path), pattern, notes)
        patterns.append(pattern)
    if n > 1:
        _check_directions(paths, turns, azimuths, np.stack(patterns), notes)
    for text in notes:
        warnings.warn(text, PhysicsWarning, stacklevel=2)
    return ReaderResponse(
        model="files",
        frequency_hz=frequency_hz,
        azimuths_rad=azimuths,
        phase_centres_m=centres,
        pattern=np.stack(patterns),
        warnings=tuple(notes),
        steps=steps if steps.any() else None,
    )


def antenna_from_pattern_file(
    path: str | Path,
    *,
    frequency_hz: float,
    axis: npt.ArrayLike = (0.0, 0.0, 1.0),
    azimuth_rad: float = 0.0,
) -> Antenna:
    """Return the antenna of a pattern file, put into the room's frame.

    Of kind ``pattern``: gain as the file holds it (realised, into 50 ohm, where it gives the
    impedance), phase at the file's origin. What the file leaves open is warned of.

    Parameters
    ----------
    path : FEKO .ffe, HFSS .ffd, CST .ffs, NEC output, MSI/Planet or CSV, over the full sphere.
    frequency_hz : Frequency [Hz]: a table within 0.1 %, or two tables at most 5 % apart around it.
    axis : (3,) float — Where the file's z axis points in the room [-].
    azimuth_rad : Turn of the file's x axis about it [rad], see `octant.em.antennas.kinds.Antenna`.
    """
    table = reader_from_pattern_files([path], azimuths_rad=[0.0], frequency_hz=frequency_hz)
    return Antenna(
        kind="pattern",
        length_m=0.0,
        frequency_hz=frequency_hz,
        axis=axis,  # type: ignore[arg-type]  # checked and frozen there
        azimuth_rad=azimuth_rad,
        pattern=table.pattern[0],
        steps=table.steps,
    )


def _read(path: Path, incident_power_w: float | None) -> tuple[PatternTable, ...]:
    """Return the tables of a file; they hold its warnings, which are reported once, later."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PhysicsWarning)
        return read_pattern(path, incident_power_w=incident_power_w)


def _grid_step_deg(tables: Sequence[PatternTable]) -> float:
    """Return the greatest step [deg] up to ``GRID_STEP_DEG`` that meets the tables' own theta.

    Steps of a pattern then stand where the file has them. Tables that differ, are finer than half
    of it, or do not run evenly from pole to pole have ``GRID_STEP_DEG`` itself.
    """
    counts = {len(table.theta_rad) for table in tables}
    even = all(
        np.abs(t.theta_rad - np.linspace(0.0, math.pi, len(t.theta_rad))).max() < _SAME_RAD
        for t in tables
    )
    cells = min(counts) - 1
    own_deg = 180.0 / max(cells, 1)
    if len(counts) > 1 or not even or not 0.5 * GRID_STEP_DEG <= own_deg <= _WIDEST_DEG:
        return GRID_STEP_DEG
    return 180.0 / (cells * math.ceil(own_deg / GRID_STEP_DEG - 1e-9))


def _at_frequency(
    tables: Sequence[PatternTable], frequency_hz: float, notes: dict[str, None]
) -> list[tuple[float, PatternTable]]:
    """Return the tables of a file that make its pattern at a frequency, with their weights."""
    nameless = [table for table in tables if table.frequency_hz is None]
    known = [(table.frequency_hz, table) for table in tables if table.frequency_hz is not None]
    near = [t for f, t in known if abs(f - frequency_hz) <= FREQUENCY_TOLERANCE * frequency_hz]
    if nameless and not known:
        near = nameless
    if len(near) > 1:
        best = min(abs((t.frequency_hz or 0.0) - frequency_hz) for t in near)
        near = [t for t in near if abs((t.frequency_hz or 0.0) - frequency_hz) == best]
    whole = [table for table in near if _is_whole(table)]
    if len(near) > 1 and len(whole) == 1:
        notes[f"{whole[0].source}: of {len(near)} patterns the one over the full sphere counts"] = (
            None
        )
        near = whole
    if len(near) > 1:
        msg = (
            f"{near[1].source}: a second pattern at {frequency_hz:.6g} Hz; keep one pattern of one "
            "antenna a file."
        )
        raise PatternFileError(msg)
    if near:
        notes.update(dict.fromkeys(near[0].warnings))
        return [(1.0, near[0])]
    below = max(((f, t) for f, t in known if f < frequency_hz), key=lambda x: x[0], default=None)
    above = min(((f, t) for f, t in known if f > frequency_hz), key=lambda x: x[0], default=None)
    if below is None or above is None or above[0] - below[0] > WIDEST_INTERPOLATION * frequency_hz:
        given = ", ".join(f"{f:.6g}" for f, _ in known)
        msg = (
            f"{tables[0].source}: patterns at {given} Hz, but {frequency_hz:.6g} Hz is needed; "
            "give that frequency, or two at most 5 % apart around it."
        )
        raise PatternFileError(msg)
    notes.update(dict.fromkeys((*below[1].warnings, *above[1].warnings)))
    share = (frequency_hz - below[0]) / (above[0] - below[0])
    return [(1.0 - share, below[1]), (share, above[1])]


def _is_whole(table: PatternTable) -> bool:
    """Return whether a table goes from pole to pole, and all around."""
    widest = max(float(np.diff(table.phi_rad).max(initial=0.0)), math.radians(_WIDEST_DEG))
    around = 2.0 * math.pi - float(np.ptp(table.phi_rad)) <= widest + _SAME_RAD
    to_poles = table.theta_rad[0] < _SAME_RAD and table.theta_rad[-1] > math.pi - _SAME_RAD
    return bool(to_poles and around and len(table.phi_rad) > 1)


def _realised(table: PatternTable, load_ohm: float, notes: dict[str, None]) -> PatternTable:
    """Return a table of realised gain as far as the file allows it."""
    if table.kind == "realised_gain":
        return table
    if table.kind == "gain" and table.impedance_ohm is not None:
        z = table.impedance_ohm
        if z.real < 0.0:
            msg = f"{table.source}: input impedance {z:.4g} ohm gives power away; check the feed."
            raise PatternFileError(msg)
        passed = 4.0 * z.real * load_ohm / abs(z + load_ohm) ** 2
        return replace(table, field=table.field * math.sqrt(passed), kind="realised_gain")
    left = "losses and mismatch are" if table.kind == "directivity" else "mismatch is"
    notes[f"{table.source} holds {table.kind}, not realised gain: {left} left out"] = None
    return table


def _check_power(path: Path, pattern: npt.NDArray[np.complex128], notes: dict[str, None]) -> None:
    """Note a pattern that radiates more power than comes in."""
    gain = np.sum(np.abs(pattern) ** 2, axis=0)
    share = mean_over_sphere(*angle_grid(*pattern.shape[1:]), gain)
    if share > _MOST_EFFICIENCY:
        text = f"{path} radiates {share:.3g} times the power that comes in: its level is in doubt"
        notes[text] = None


def _check_directions(
    paths: Sequence[str | Path],
    turns_rad: npt.NDArray[np.float64],
    azimuths_rad: npt.NDArray[np.float64],
    patterns: npt.NDArray[np.complex128],
    notes: dict[str, None],
) -> None:
    """Note antennas of one file, and patterns that face away from their antenna's azimuth."""
    given: dict[tuple[str, float], list[int]] = {}
    for number, (path, turn_rad) in enumerate(zip(paths, turns_rad.tolist(), strict=True), start=1):
        given.setdefault((str(path), turn_rad), []).append(number)
    for (path, _), numbers in given.items():
        if len(numbers) > 1:
            text = (
                f"{path} is the file of antennas {', '.join(map(str, numbers))}, which then all "
                "receive alike: a file is in the reader's frame, and that of one antenna has to be "
                'turned to each (reader.pattern_turn = "each")'
            )
            notes[text] = None
    theta, phi = angle_grid(*patterns.shape[2:])
    around = np.einsum("nctp,t->np", np.abs(patterns) ** 2, np.sin(theta))
    mean = around @ np.exp(1j * phi) / np.maximum(around.sum(axis=1), 1e-300)
    off_rad = np.abs(np.angle(mean * np.exp(-1j * azimuths_rad)))
    wrong = np.flatnonzero((np.abs(mean) > _DIRECTIVE) & (off_rad > math.pi / len(azimuths_rad)))
    if wrong.size:
        first = int(wrong[0])
        text = (
            f"the patterns of antennas {', '.join(str(i + 1) for i in wrong)} face away from where "
            f"these stand, by more than half a sector: antenna {first + 1} stands at azimuth "
            f"{math.degrees(azimuths_rad[first]):.0f} deg, {paths[first]} is strongest around "
            f"{math.degrees(float(np.angle(mean[first]))) % 360.0:.0f} deg: are files and antennas "
            "in the same order and frame?"
        )
        notes[text] = None


def pattern_tables(
    response: ReaderResponse, *, step_deg: float | None = None
) -> tuple[PatternTable, ...]:
    """Return a reader's tables of realised gain for files, one an antenna, phase at its centre.

    Parameters
    ----------
    response : The reader.
    step_deg : Step [deg] of theta and phi, a divisor of 180; None: the response's own grid.
    """
    theta_rad, phi_rad = response.theta_rad, response.phi_rad
    if step_deg is not None:
        half_turn = half_turn_steps(step_deg)
        theta_rad, phi_rad = angle_grid(half_turn + 1, 2 * half_turn)
    fields = response.far_field(theta_rad[:, None], phi_rad[None, :])
    return tuple(
        PatternTable(
            frequency_hz=response.frequency_hz,
            theta_rad=theta_rad,
            phi_rad=phi_rad,
            field=np.moveaxis(field, -1, 0),
            kind="realised_gain",
            name=f"antenna {index}",
            source=f"antenna {index} of the reader ({response.model})",
        )
        for index, field in enumerate(fields, start=1)
    )
