# mypy: allow-untyped-defs
"""Euler rollouts of the wheeled robot, and the exact gradients of their cost (discrete adjoint)."""

import math

import numpy as np

from octant.geometries.kernels import kernel


@kernel
def _running_cost(x, y, heading, reference, weight, slope):
    """Return half of e'We; ``slope`` becomes We."""
    ex, ey, eh = x - reference[0], y - reference[1], heading - reference[2]
    for i in range(3):
        slope[i] = weight[i, 0] * ex + weight[i, 1] * ey + weight[i, 2] * eh
    return 0.5 * (ex * slope[0] + ey * slope[1] + eh * slope[2])


@kernel
def _forward(poses, j, right, left, step_s, radius, axle):
    half = 0.5 * radius * (right + left)
    heading = poses[j, 2]
    poses[j + 1, 0] = poses[j, 0] + step_s * half * math.cos(heading)
    poses[j + 1, 1] = poses[j, 1] + step_s * half * math.sin(heading)
    poses[j + 1, 2] = heading + step_s * radius * (right - left) / axle


@kernel
def _pull_back(costate, heading, right, left, step_s, radius, axle, slope_u):
    """Take the costate one Euler step back, without the cost; ``slope_u`` becomes dJ/du."""
    c, s = math.cos(heading), math.sin(heading)
    along = 0.5 * step_s * radius * (costate[0] * c + costate[1] * s)
    turn = step_s * radius * costate[2] / axle
    slope_u[0], slope_u[1] = along + turn, along - turn
    half = 0.5 * step_s * radius * (right + left)
    costate[2] += half * (-s * costate[0] + c * costate[1])


@kernel
def input_cost(
    rates, start, reference, q_weight, p_weight, step_s, substeps, radius, axle, poses, gradient
):
    """Return the cost of held inputs; fill ``poses`` (n m + 1, 3) and ``gradient`` (n, 2)."""
    slope, slope_u, costate = np.empty(3), np.empty(2), np.empty(3)
    steps = rates.shape[0] * substeps
    cost = 0.0
    poses[0] = start
    for j in range(steps):
        k = j // substeps
        cost += step_s * _running_cost(
            poses[j, 0], poses[j, 1], poses[j, 2], reference[j], q_weight, slope
        )
        _forward(poses, j, rates[k, 0], rates[k, 1], step_s, radius, axle)
    cost += _running_cost(
        poses[steps, 0], poses[steps, 1], poses[steps, 2], reference[steps], p_weight, costate
    )
    gradient[:] = 0.0
    for j in range(steps - 1, -1, -1):
        k = j // substeps
        _pull_back(costate, poses[j, 2], rates[k, 0], rates[k, 1], step_s, radius, axle, slope_u)
        gradient[k, 0] += slope_u[0]
        gradient[k, 1] += slope_u[1]
        _running_cost(poses[j, 0], poses[j, 1], poses[j, 2], reference[j], q_weight, slope)
        costate += step_s * slope
    return cost


@kernel(nogil=True)
def gain_cost(
    gains,
    start,
    reference,
    q_weight,
    p_weight,
    step_s,
    substeps,
    radius,
    axle,
    limit,
    poses,
    rates,
    gradient,
):
    """Return the cost of u = K q within ±limit; fill poses, ``rates`` (n m, 2) and dJ/dK (n, 2, 3).

    Where a wheel is at its limit its gain has no effect, and its gradient is zero.
    """
    slope, slope_u, costate = np.empty(3), np.empty(2), np.empty(3)
    steps = gains.shape[0] * substeps
    cost = 0.0
    poses[0] = start
    for j in range(steps):
        k = j // substeps
        for w in range(2):
            wanted = (
                gains[k, w, 0] * poses[j, 0]
                + gains[k, w, 1] * poses[j, 1]
                + gains[k, w, 2] * poses[j, 2]
            )
            rates[j, w] = min(max(wanted, -limit), limit)
        cost += step_s * _running_cost(
            poses[j, 0], poses[j, 1], poses[j, 2], reference[j], q_weight, slope
        )
        _forward(poses, j, rates[j, 0], rates[j, 1], step_s, radius, axle)
    cost += _running_cost(
        poses[steps, 0], poses[steps, 1], poses[steps, 2], reference[steps], p_weight, costate
    )
    gradient[:] = 0.0
    for j in range(steps - 1, -1, -1):
        k = j // substeps
        _pull_back(costate, poses[j, 2], rates[j, 0], rates[j, 1], step_s, radius, axle, slope_u)
        for w in range(2):
            if abs(rates[j, w]) < limit:
                for i in range(3):
                    gradient[k, w, i] += slope_u[w] * poses[j, i]
                    costate[i] += slope_u[w] * gains[k, w, i]
        _running_cost(poses[j, 0], poses[j, 1], poses[j, 2], reference[j], q_weight, slope)
        costate += step_s * slope
    return cost
