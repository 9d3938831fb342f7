"""Directions of a file as a grid: rows in loop order, folded onto theta 0..180, phi 0..360."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.antennas.pattern_files._lines import Row, refusal

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]

ROUNDING_DEG = 0.011
"""Angles [deg] closer than this are the same: files print as few as two decimals."""

SEAM_TOLERANCE = 0.05
"""Greatest difference [-], over the table's maximum, between two entries of one direction."""


def loop_grid(
    path: Path, rows: Sequence[Row], *, theta_column: int = 0, phi_column: int = 1
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return theta (T,) and phi (P,) [deg] and all columns (C, T, P) of rows in loop order.

    Either angle may vary faster, up or down, in equal steps.
    """
    if len(rows) < 2:
        line = rows[0].line if rows else 1
        raise refusal(
            path, line, "fewer than two directions do not make a pattern; give a whole grid."
        )
    table = np.array([row.values for row in rows], dtype=np.float64)
    angles = table[:, [theta_column, phi_column]]
    change = np.abs(angles[1] - angles[0]) > 1e-9
    if change.all() or not change.any():
        raise _out_of_order(path, rows[1], theta_column, phi_column)
    fast = 0 if change[0] else 1
    slow = 1 - fast
    turned = np.flatnonzero(np.abs(angles[:, slow] - angles[0, slow]) > 1e-9)
    inner = int(turned[0]) if turned.size else len(rows)
    outer = -(-len(rows) // inner)
    places = np.arange(len(rows))
    expected = np.empty_like(angles)
    expected[:, fast] = angles[places % inner, fast]
    expected[:, slow] = angles[(places // inner) * inner, slow]
    wrong = np.flatnonzero((np.abs(angles - expected) > 1e-6).any(axis=1))
    if wrong.size:
        raise _out_of_order(path, rows[int(wrong[0])], theta_column, phi_column)
    if len(rows) != inner * outer:
        what = (
            f"the grid ends after {len(rows)} directions where {inner * outer} are needed; "
            "directions are missing."
        )
        raise refusal(path, rows[-1].line, what)
    _check_steps(path, rows, angles[:inner, fast], 1)
    _check_steps(path, rows, angles[::inner, slow], inner)
    grid = table.reshape(outer, inner, -1)
    grid = np.moveaxis(grid, 2, 0)
    if fast == 0:
        grid = grid.swapaxes(1, 2)
    return grid[theta_column, :, 0], grid[phi_column, 0, :], grid


def _out_of_order(path: Path, row: Row, theta_column: int, phi_column: int) -> Exception:
    """Return the error for a row that breaks the loop."""
    theta, phi = row.values[theta_column], row.values[phi_column]
    what = (
        f"direction theta = {theta:g} deg, phi = {phi:g} deg breaks the order of the grid; every "
        "theta is needed once with every phi, one of them running faster."
    )
    return refusal(path, row.line, what)


def _check_steps(path: Path, rows: Sequence[Row], axis: FloatArray, stride: int) -> None:
    """Refuse an axis whose steps differ by more than the rounding of printed angles."""
    steps = np.diff(axis)
    if not steps.size:
        return
    uneven = np.abs(steps - steps[0]) > max(2.0 * ROUNDING_DEG, 1e-3 * abs(steps[0]))
    if uneven.any():
        at = int(np.flatnonzero(uneven)[0])
        what = (
            f"the angle goes from {axis[at]:g} to {axis[at + 1]:g} deg after steps of "
            f"{steps[0]:g} deg; the grid must be sorted and regular."
        )
        raise refusal(path, rows[(at + 1) * stride].line, what)


def fold(
    path: Path,
    line: int,
    theta_deg: FloatArray,
    phi_deg: FloatArray,
    field: ComplexArray,
    *,
    signed: bool = True,
) -> tuple[FloatArray, FloatArray, ComplexArray]:
    """Return ascending axes [rad] and field on theta 0..pi, phi 0..2 pi, each direction once.

    Beyond a pole (theta < 0 or > 180 deg) both unit vectors are reversed at the opposite azimuth:
    F(theta, phi + 180 deg) = -F(-theta, phi). Amplitudes (``signed`` false) keep their sign.
    |theta| <= 360 deg, |phi| <= 720 deg.
    """
    if np.abs(theta_deg).max() > 360.0 + 1e-6 or np.abs(phi_deg).max() > 720.0 + 1e-6:
        what = "theta beyond 360 deg or phi beyond 720 deg is not a direction; correct the angles."
        raise refusal(path, line, what)
    theta, phi = np.meshgrid(np.mod(theta_deg, 360.0), phi_deg, indexing="ij")
    beyond = theta > 180.0 + 0.5 * ROUNDING_DEG
    theta = np.where(beyond, 360.0 - theta, np.minimum(theta, 180.0))
    phi = np.mod(phi + np.where(beyond, 180.0, 0.0), 360.0)
    sign = np.where(beyond, -1.0, 1.0) if signed else np.ones(theta.shape)
    phi = np.where(phi > 360.0 - ROUNDING_DEG / 2, 0.0, phi)
    theta_axis, row = _merged(theta)
    phi_axis, column = _merged(phi)
    folded = np.full((2, len(theta_axis), len(phi_axis)), np.nan + 0j)
    values = (field * sign).reshape(2, -1)
    # where a direction comes twice, the first entry stays
    folded[:, row[::-1], column[::-1]] = values[:, ::-1]
    spread = np.abs(folded[:, row, column] - values).max()
    if spread > SEAM_TOLERANCE * max(float(np.abs(values).max()), 1e-300):
        what = "one direction is given twice with different values; keep one of them."
        raise refusal(path, line, what)
    _fill_poles(theta_axis, phi_axis, folded, signed=signed)
    missing = np.argwhere(np.isnan(folded[0]))
    if missing.size:
        i, j = missing[0]
        what = (
            f"direction theta = {theta_axis[i]:g} deg, phi = {phi_axis[j]:g} deg is missing; give "
            "every theta with every phi."
        )
        raise refusal(path, line, what)
    return np.radians(theta_axis), np.radians(phi_axis), folded


def _merged(angles_deg: FloatArray) -> tuple[FloatArray, npt.NDArray[np.intp]]:
    """Return the distinct angles, ascending, and the place of every entry among them."""
    distinct, inverse = np.unique(angles_deg.ravel(), return_inverse=True)
    first = np.concatenate(([True], np.diff(distinct) > ROUNDING_DEG))
    group = np.cumsum(first) - 1
    return distinct[first], group[inverse]


def _fill_poles(
    theta_deg: FloatArray, phi_deg: FloatArray, field: ComplexArray, *, signed: bool
) -> None:
    """Fill azimuths that a folded pole lacks from the opposite ones, in place."""
    for row in (0, len(theta_deg) - 1):
        if not (theta_deg[row] < ROUNDING_DEG or theta_deg[row] > 180.0 - ROUNDING_DEG):
            continue
        for column in np.flatnonzero(np.isnan(field[0, row])):
            opposite = np.mod(phi_deg[column] + 180.0, 360.0)
            apart = np.abs(np.mod(phi_deg - opposite + 180.0, 360.0) - 180.0)
            twin = int(np.argmin(apart))
            if apart[twin] < ROUNDING_DEG:
                field[:, row, column] = (-1.0 if signed else 1.0) * field[:, row, twin]
