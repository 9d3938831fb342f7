"""Patterns on other grids: around in phi, over the poles in theta, phase moved to any centre."""

import math
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from octant.em.antennas.pattern_files.common import PatternTable
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.directions import POLE_MISMATCH, angle_grid
from octant.geometries.errors import PatternFileError

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]
BoolArray = npt.NDArray[np.bool_]

Outside = Literal["error", "zero"]
"""What directions that a file does not cover become."""

_SAME_RAD = 1e-6

STEP_RATIO = 30.0
"""Ratio [-] of neighbouring amplitudes from which a pattern counts as ending in a step (30 dB)."""

STEP_SHARE = 0.03
"""Amplitude before a step, over the table's greatest [-], below which its ringing does not count.
"""

SILENCE = 1e-6
"""Amplitude [-], over the table's greatest, that may fall to zero without being a step (120 dB)."""


def half_turn_steps(step_deg: float) -> int:
    """Return how many steps make half a turn, 180 deg over the step.

    Parameters
    ----------
    step_deg : Step [deg] of a grid, at most 45.
    """
    steps = round(180.0 / step_deg) if 0.01 < step_deg <= 45.0 else 0
    if steps < 4 or abs(steps * step_deg - 180.0) > 1e-9:
        msg = f"step_deg = {step_deg} deg does not divide 180 deg; give a step such as 1.5 deg."
        raise PatternFileError(msg)
    return steps


def turned(table: PatternTable, turn_rad: float) -> PatternTable:
    """Return a table turned about its z axis, its origin with it.

    Parameters
    ----------
    table : The pattern.
    turn_rad : Turn from +x towards +y [rad].
    """
    if turn_rad == 0.0:
        return table
    around = 2.0 * math.pi
    phi = np.mod(table.phi_rad + turn_rad, around)
    phi[around - phi < 1e-9] = 0.0  # rounding must not leave the seam's direction behind it
    order = np.argsort(phi)
    c, s = math.cos(turn_rad), math.sin(turn_rad)
    x, y, z = np.asarray(table.origin_m)
    return replace(
        table,
        phi_rad=phi[order],
        field=table.field[:, :, order],
        origin_m=(c * x - s * y, s * x + c * y, z),
    )


def move_phase(
    table: PatternTable, frequency_hz: float, centre_m: npt.ArrayLike = (0.0, 0.0, 0.0)
) -> ComplexArray:
    """Return F_theta, F_phi [-] times e^{j k (origin - centre) . u}: phase at another point.

    Amplitudes without phase stay as they are: they count as real about the new centre.

    Parameters
    ----------
    table : The pattern.
    frequency_hz : Frequency [Hz].
    centre_m : (3,) float — Point [m] of the file's frame that the phase is to be referred to.
    """
    if not table.phase_known:
        return np.array(table.field)
    shift = np.asarray(table.origin_m) - np.asarray(centre_m, dtype=np.float64)
    theta, phi = table.theta_rad[:, None], table.phi_rad[None, :]
    along = np.sin(theta) * (shift[0] * np.cos(phi) + shift[1] * np.sin(phi))
    along = along + shift[2] * np.cos(theta)
    moved: ComplexArray = table.field * np.exp(
        2j * math.pi * frequency_hz / SPEED_OF_LIGHT_M_PER_S * along
    )
    return moved


def check_coverage(table: PatternTable, *, outside: Outside = "error") -> None:
    """Refuse a table that leaves directions open.

    Parameters
    ----------
    table : The pattern.
    outside : {"error", "zero"} — ``zero`` lets theta end short of a pole (above a ground plane).
    """
    if outside not in get_args(Outside):
        msg = f"outside = {outside!r} is unknown; allowed are {', '.join(get_args(Outside))}."
        raise PatternFileError(msg)
    theta, phi = table.theta_rad, table.phi_rad
    if len(theta) < 3 or len(phi) < 3:
        msg = (
            f"{table.source}: {len(theta)} values of theta and {len(phi)} of phi are a cut, not a "
            "pattern; give the full sphere."
        )
        raise PatternFileError(msg)
    closing = phi[0] + 2.0 * math.pi - phi[-1]
    if closing > 1.5 * float(np.diff(phi).max()) + 1e-3:
        msg = (
            f"{table.source}: phi covers {np.degrees(phi[0]):g} to {np.degrees(phi[-1]):g} deg "
            "only; directions are missing, give all around."
        )
        raise PatternFileError(msg)
    step = 1.5 * float(np.diff(theta).max()) + 1e-3
    if outside == "error" and (theta[0] > step or math.pi - theta[-1] > step):
        msg = (
            f"{table.source}: theta covers {np.degrees(theta[0]):g} to {np.degrees(theta[-1]):g} "
            "deg only; directions are missing: give the full sphere, or outside = 'zero' where "
            "nothing is radiated there."
        )
        raise PatternFileError(msg)


def resample(
    table: PatternTable,
    theta_rad: npt.ArrayLike,
    phi_rad: npt.ArrayLike,
    *,
    outside: Outside = "error",
) -> ComplexArray:
    """Return F_theta, F_phi [-] of a table on another grid, phase at the table's own origin.

    Periodic cubic splines around phi, then along great circles through both poles, beyond which
    both components change sign; the table's own values come back. Where a table ends in a step,
    as above a ground plane, splines run on either side of it and the step is a straight line, so
    that nothing rings: between zeros there is zero. The phase turns by k r between
    neighbouring directions of an antenna r off the origin: move it there first
    (`reader_from_pattern_files` does). Amplitudes without phase never fall below 0.

    Parameters
    ----------
    table : The pattern, covering the sphere.
    theta_rad, phi_rad : (T,), (P,) float — Angles from +z, 0..pi, and azimuths of any turn [rad].
    outside : {"error", "zero"} — What to do where theta is not covered.
    """
    return _resampled(
        table,
        np.asarray(table.field),
        np.atleast_1d(np.asarray(theta_rad, dtype=np.float64)),
        np.atleast_1d(np.asarray(phi_rad, dtype=np.float64)),
        outside,
    )[0]


@dataclass(frozen=True, slots=True)
class _Straight:
    """Where a table was interpolated along straight lines because it has a step there.

    Parameters
    ----------
    circle_rad : (c + 1,) float64 — Ends of the cells along a great circle [rad].
    along_theta : (c, p) bool — Straight cells along the circles of the wanted azimuths.
    theta_rad, phi_rad : (t,), (m,) float64 — Angles of the table [rad].
    along_phi : (t, m) bool — Straight cells around, one row for each theta of the table.
    """

    circle_rad: FloatArray
    along_theta: BoolArray
    theta_rad: FloatArray
    phi_rad: FloatArray
    along_phi: BoolArray


def _resampled(
    table: PatternTable,
    field: ComplexArray,
    theta_rad: FloatArray,
    phi_rad: FloatArray,
    outside: Outside,
) -> tuple[ComplexArray, _Straight]:
    """Return a field on the table's grid at other directions, and where it has steps."""
    check_coverage(table, outside=outside)
    theta, phi = table.theta_rad, table.phi_rad
    turn = 2.0 * math.pi
    peak = float(np.abs(field).max())
    wanted = np.concatenate((phi_rad, phi_rad + math.pi))
    across, around = _along(phi, field, wanted, axis=2, period=turn, peak=peak)
    here, there = across[:, :, : len(phi_rad)], across[:, :, len(phi_rad) :]
    sign = -1.0 if table.phase_known else 1.0
    if theta[0] > 1.5 * np.diff(theta).max() or math.pi - theta[-1] > 1.5 * np.diff(theta).max():
        covered = (theta_rad >= theta[0] - _SAME_RAD) & (theta_rad <= theta[-1] + _SAME_RAD)
        inside, straight = _along(theta, here, theta_rad, axis=1, period=None, peak=peak)
        out = np.where(covered[None, :, None], inside, 0.0)
        circle = np.concatenate(([-math.pi], theta, [turn]))
        edge = np.ones((1, *straight.shape[1:]), dtype=np.bool_)
        straight = np.concatenate((edge, straight, edge))  # nothing beyond the ends: steps
    else:
        poles = (theta[0] < _SAME_RAD, math.pi - theta[-1] < _SAME_RAD)
        back = slice(len(theta) - 2 if poles[1] else len(theta) - 1, 0 if poles[0] else None, -1)
        circle = np.concatenate((theta, turn - theta[back]))
        values = np.concatenate((here, sign * there[:, back]), axis=1)
        broken = np.zeros((len(circle), *values.shape[::2]), dtype=np.bool_)
        for at, row, cell in ((poles[0], 0, -1), (poles[1], len(theta) - 1, len(theta) - 1)):
            if at:  # one direction with two values: the far side is another pattern
                two = np.abs(here[:, row] - sign * there[:, row]) > POLE_MISMATCH * peak
                broken[cell] = two
        out, straight = _along(
            circle, values, theta_rad, axis=1, period=turn, peak=peak, broken=broken
        )
        circle = np.append(circle, circle[0] + turn)
    if not table.phase_known:
        out = np.maximum(out.real, 0.0).astype(np.complex128)
    along_theta, along_phi = (np.logical_or.reduce(cells, axis=1) for cells in (straight, around))
    return out, _Straight(circle, along_theta, theta, phi, along_phi.T)


def _along(
    x: FloatArray,
    values: ComplexArray,
    wanted: FloatArray,
    *,
    axis: int,
    period: float | None,
    peak: float,
    broken: BoolArray | None = None,
) -> tuple[ComplexArray, BoolArray]:
    """Return values along an axis by cubic splines, and the cells (c, ...) that are straight lines.

    Splines do not run over steps, nor over cells that are ``broken``.
    """
    from scipy.interpolate import CubicSpline

    lines = np.moveaxis(values, axis, 0)
    straight = _steps(np.abs(lines), peak, closed=period is not None)
    if broken is not None:
        straight |= broken
    nodes, closed, ends = x, values, "not-a-knot"
    if period is not None:
        first = np.take(values, [0], axis=axis)
        nodes, ends = np.append(x, x[0] + period), "periodic"
        closed = np.concatenate((values, first), axis=axis)
    out: ComplexArray = CubicSpline(nodes, closed, axis=axis, bc_type=ends)(wanted)
    cells = straight.reshape(len(straight), -1)
    if not cells.any():
        return out, straight
    flat = lines.reshape(len(lines), -1)
    made = np.moveaxis(out, axis, 0).reshape(len(wanted), -1).copy()
    stepped = np.flatnonzero(cells.any(axis=0))
    kinds, kind = np.unique(cells[:, stepped].T, axis=0, return_inverse=True)
    for number, pattern in enumerate(kinds):
        chosen = stepped[kind.ravel() == number]
        made[:, chosen] = _in_pieces(x, flat[:, chosen], wanted, pattern, period)
    return np.moveaxis(made.reshape(len(wanted), *lines.shape[1:]), 0, axis), straight


def _steps(amplitude: FloatArray, peak: float, *, closed: bool) -> BoolArray:
    """Return the cells (c, ...) of lines (n, ...) that hold a step, and those on its upper side.

    A step falls by `STEP_RATIO` and stays down; a null, which rises again, is none. A fall to exact
    zeros is a step from a small amplitude too, so that nothing leaks between them.
    """
    if closed:
        before, here, there, beyond = (np.roll(amplitude, -k, axis=0) for k in (-1, 0, 1, 2))
    else:
        padded = np.concatenate((amplitude[:1], amplitude, amplitude[-1:]))
        before, here, there, beyond = (padded[k : len(padded) - 3 + k] for k in range(4))

    def falls(top: FloatArray, foot: FloatArray, on: FloatArray) -> tuple[BoolArray, BoolArray]:
        least = np.maximum(foot, on)
        deep = (top > STEP_SHARE * peak) & (STEP_RATIO * least <= top)
        return deep, deep | ((least == 0.0) & (top > SILENCE * peak))

    (down_deep, down), (up_deep, up) = falls(here, there, beyond), falls(there, here, before)
    earlier, later = np.roll(down_deep, -1, axis=0), np.roll(up_deep, 1, axis=0)
    if not closed:
        earlier[-1], later[0] = False, False
    return down | up | earlier | later


def _in_pieces(
    x: FloatArray,
    values: ComplexArray,
    wanted: FloatArray,
    straight: BoolArray,
    period: float | None,
) -> ComplexArray:
    """Return lines (n, k) at wanted places: splines between the straight cells, lines in them."""
    from scipy.interpolate import CubicSpline

    if period is not None:  # begin behind a straight cell, so that no piece runs over the seam
        order = (int(np.argmax(straight)) + 1 + np.arange(len(x) + 1)) % len(x)
        x = np.unwrap(x[order], period=period)
        x[-1] = x[0] + period
        straight, values = straight[order[:-1]], values[order]
        wanted = x[0] + np.mod(wanted - x[0], period)
    cell = np.clip(np.searchsorted(x, wanted, side="right") - 1, 0, len(x) - 2)
    share = ((wanted - x[cell]) / (x[cell + 1] - x[cell]))[:, None]
    out: ComplexArray = (1.0 - share) * values[cell] + share * values[cell + 1]
    bounds = np.flatnonzero(np.diff(np.concatenate(([True], straight, [True])).astype(np.int8)))
    for begin, end in bounds.reshape(-1, 2):
        if end - begin >= 3:
            inside = (cell >= begin) & (cell < end)
            piece = CubicSpline(x[begin : end + 1], values[begin : end + 1])
            out[inside] = piece(wanted[inside])
    return out


def _linear_cells(straight: _Straight, rows: int, columns: int) -> BoolArray:
    """Return the cells (rows - 1, columns) of a uniform grid that lie at a step.

    Cells beside them count too, since their cubic stencil would reach into the step.
    """
    high, wide = math.pi / (rows - 1), 2.0 * math.pi / columns
    cells = np.zeros((rows - 1, columns), dtype=np.bool_)
    if not (straight.along_theta.any() or straight.along_phi.any()):
        return cells

    def rows_of(low_rad: float, high_rad: float) -> slice:
        first = math.floor(max(low_rad, 0.0) / high + 1e-9)
        return slice(first, max(first, math.ceil(min(high_rad, math.pi) / high - 1e-9)))

    for at in np.flatnonzero(straight.along_theta.any(axis=1)):
        touched = straight.along_theta[at] | np.roll(straight.along_theta[at], -1)
        for shift in (0.0, 2.0 * math.pi):  # the last cell may go on over the upper pole
            low, top = (straight.circle_rad[at : at + 2] - shift).tolist()
            cells[rows_of(low, top)] |= touched
    theta = np.concatenate(([0.0], straight.theta_rad, [math.pi]))
    phi = np.append(straight.phi_rad, straight.phi_rad[0] + 2.0 * math.pi)
    for at, cell in np.argwhere(straight.along_phi):
        first, last = math.floor(phi[cell] / wide + 1e-9), math.ceil(phi[cell + 1] / wide - 1e-9)
        cells[rows_of(theta[at], theta[at + 2]), np.arange(first, last) % columns] = True
    over = np.roll(cells[[0, -1]], columns // 2, axis=1)  # over the poles
    tall = np.concatenate((over[:1], cells, over[1:]))
    cells = tall[:-2] | tall[1:-1] | tall[2:]
    wider: BoolArray = cells | np.roll(cells, 1, axis=1) | np.roll(cells, -1, axis=1)
    return wider


def response_pattern(
    table: PatternTable,
    *,
    frequency_hz: float,
    phase_centre_m: npt.ArrayLike,
    rows: int,
    columns: int,
    outside: Outside = "error",
) -> tuple[ComplexArray, BoolArray]:
    """Return F_theta, F_phi [-] of a table on the uniform grid of a `ReaderResponse`, and steps.

    Steps are the grid's cells (rows - 1, columns) in which only straight lines between the corners
    keep the table's bounds.

    Parameters
    ----------
    table : The pattern, in the reader's frame.
    frequency_hz : Frequency [Hz] for the phase.
    phase_centre_m : (3,) float — Point [m] of the reader's frame that the phase is referred to.
    rows, columns : Values of theta from 0 to pi, and of phi from 0 to below 2 pi.
    outside : {"error", "zero"} — What to do where theta is not covered.
    """
    moved = move_phase(table, frequency_hz, phase_centre_m)
    field, straight = _resampled(table, moved, *angle_grid(rows, columns), outside)
    return field, _linear_cells(straight, rows, columns)
