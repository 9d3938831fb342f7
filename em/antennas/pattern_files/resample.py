"""Patterns on other grids: around in phi, over the poles in theta, phase moved to any centre."""

import math
from dataclasses import replace
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from octant.em.antennas.pattern_files.common import PatternTable
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.directions import angle_grid
from octant.geometries.errors import PatternFileError

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]

Outside = Literal["error", "zero"]
"""What directions that a file does not cover become."""

_SAME_RAD = 1e-6


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
    both components change sign; the table's own values come back. The phase turns by k r between
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
    )


def _resampled(
    table: PatternTable,
    field: ComplexArray,
    theta_rad: FloatArray,
    phi_rad: FloatArray,
    outside: Outside,
) -> ComplexArray:
    """Return a field on the table's grid at other directions."""
    from scipy.interpolate import CubicSpline

    check_coverage(table, outside=outside)
    theta, phi = table.theta_rad, table.phi_rad
    around = np.append(phi, phi[0] + 2.0 * math.pi)
    closed = np.concatenate((field, field[:, :, :1]), axis=2)
    spline = CubicSpline(around, closed, axis=2, bc_type="periodic")
    here, there = spline(phi_rad), spline(phi_rad + math.pi)
    sign = -1.0 if table.phase_known else 1.0
    if theta[0] > 1.5 * np.diff(theta).max() or math.pi - theta[-1] > 1.5 * np.diff(theta).max():
        covered = (theta_rad >= theta[0] - _SAME_RAD) & (theta_rad <= theta[-1] + _SAME_RAD)
        inside = CubicSpline(theta, here, axis=1)(theta_rad)
        out = np.where(covered[None, :, None], inside, 0.0)
    else:
        back = slice(
            len(theta) - 2 if math.pi - theta[-1] < _SAME_RAD else len(theta) - 1,
            0 if theta[0] < _SAME_RAD else None,
            -1,
        )
        circle = np.concatenate((theta, 2.0 * math.pi - theta[back]))
        values = np.concatenate((here, sign * there[:, back]), axis=1)
        circle = np.append(circle, circle[0] + 2.0 * math.pi)
        values = np.concatenate((values, values[:, :1]), axis=1)
        out = CubicSpline(circle, values, axis=1, bc_type="periodic")(theta_rad)
    if not table.phase_known:
        out = np.maximum(out.real, 0.0).astype(np.complex128)
    result: ComplexArray = out
    return result


def response_pattern(
    table: PatternTable,
    *,
    frequency_hz: float,
    phase_centre_m: npt.ArrayLike,
    rows: int,
    columns: int,
    outside: Outside = "error",
) -> ComplexArray:
    """Return F_theta, F_phi [-] of a table on the uniform grid of a `ReaderResponse`.

    Parameters
    ----------
    table : The pattern, in the reader's frame.
    frequency_hz : Frequency [Hz] for the phase.
    phase_centre_m : (3,) float — Point [m] of the reader's frame that the phase is referred to.
    rows, columns : Values of theta from 0 to pi, and of phi from 0 to below 2 pi.
    outside : {"error", "zero"} — What to do where theta is not covered.
    """
    return _resampled(
        table,
        move_phase(table, frequency_hz, phase_centre_m),
        *angle_grid(rows, columns),
        outside,
    )
