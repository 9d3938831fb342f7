# mypy: allow-untyped-defs
"""Euler rollouts of the wheeled robot, and the exact gradients of their cost (discrete adjoint)."""

import math

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy")
def _running_cost(x, y, heading, reference, weight, slope):
    """Return half of e'We; ``slope`` becomes We."""
    ex, ey, eh = x - reference[0], y - reference[1], heading - reference[2]
    for i in range(3):
        slope[i] = weight[i, 0] * ex + weight[i, 1] * ey + weight[i, 2] * eh
    return 0.5 * (ex * slope[0] + ey * slope[1] + eh * slope[2])


@njit(cache=True, error_model="numpy")
def _forward(poses, j, right, left, step_s, radius, axle):
    half = 0.5 * radius * (right + left)
    heading = poses[j, 2]
    poses[j + 1, 0] = poses[j, 0] + step_s * half * math.cos(heading)
    poses[j + 1, 1] = poses[j, 1] + step_s * half * math.sin(heading)
    poses[j + 1, 2] = heading + step_s * radius * (right - left) / axle


@njit(cache=True, error_model="numpy")
def _pull_back(costate, heading, right, left, step_s, radius, axle, slope_u):
    """Take the costate one Euler step back, without the cost; ``slope_u`` becomes dJ/du."""
    c, s = math.cos(heading), math.sin(heading)
    along = 0.5 * step_s * radius * (costate[0] * c + costate[1] * s)
    turn = step_s * radius * costate[2] / axle
    slope_u[0], slope_u[1] = along + turn, along - turn
    half = 0.5 * step_s * radius * (right + left)
    costate[2] += half * (-s * costate[0] + c * costate[1])


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def _descend_step(gains, previous, gradient, square, step, momentum):
    """Take one step K - step dJ/dK / |z|² + momentum (K - K_before); arrays (n, 2, s), (n,)."""
    for k in range(gains.shape[0]):
        scale = step / max(square[k], 1e-300)
        for w in range(2):
            for i in range(gains.shape[2]):
                now = gains[k, w, i]
                gains[k, w, i] = (
                    now - scale * gradient[k, w, i] + momentum * (now - previous[k, w, i])
                )
                previous[k, w, i] = now


@njit(cache=True, error_model="numpy")
def descend(
    cost,
    lowest,
    step,
    momentum,
    gains,
    best,
    previous,
    gradient,
    kept,
    square,
    kept_square,
):
    """Step on from a lower cost, else half as far from the best gains; return lowest and step."""
    if cost < lowest:
        best[:] = gains
        kept[:] = gradient
        kept_square[:] = square
        step *= 1.02
        _descend_step(gains, previous, gradient, square, step, momentum)
        return cost, step
    step *= 0.5
    gains[:] = best
    previous[:] = best
    _descend_step(gains, previous, kept, kept_square, step, 0.0)
    return lowest, step


@njit(cache=True, error_model="numpy")
def descend_gains(
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
    momentum,
    first_step,
    tolerance,
    costs,
):
    """Return the iterations done; ``gains`` become the best found, ``costs`` J of each."""
    steps = gains.shape[0] * substeps
    poses, rates = np.empty((steps + 1, 3)), np.empty((steps, 2))
    gradient, kept = np.empty(gains.shape), np.empty(gains.shape)
    square, kept_square = np.empty(gains.shape[0]), np.empty(gains.shape[0])
    best, previous = gains.copy(), gains.copy()
    lowest, step = np.inf, first_step
    done = 0
    for i in range(costs.size):
        cost = gain_cost(
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
        )
        costs[i] = cost
        done = i + 1
        for k in range(gains.shape[0]):
            square[k] = 0.0
            for j in range(k * substeps, (k + 1) * substeps):
                for c in range(3):
                    square[k] += poses[j, c] ** 2 / substeps
        if cost <= tolerance or np.sum(gradient * gradient) <= tolerance:
            if cost < lowest:
                best[:] = gains
            break
        lowest, step = descend(
            cost,
            lowest,
            step,
            momentum,
            gains,
            best,
            previous,
            gradient,
            kept,
            square,
            kept_square,
        )
    gains[:] = best
    return done
