# mypy: allow-untyped-defs
"""Iterative LQR with bounded inputs (control-limited DDP, Gauss-Newton) for the wheeled robot."""

import math

import numpy as np

from octant.geometries.kernels import kernel
from octant.navigation.tracking._optimal_kernels import _forward, _running_cost


@kernel
def _roll_out(
    rates, wanted, reference, q_weight, p_weight, r_weight, step_s, substeps, radius, axle, poses
):
    """Return the cost of inputs held for ``substeps`` Euler steps, R on their deviation."""
    slope = np.empty(3)
    cost = 0.0
    for k in range(rates.shape[0]):
        right, left = rates[k, 0] - wanted[k, 0], rates[k, 1] - wanted[k, 1]
        cost += (
            0.5
            * substeps
            * step_s
            * (
                r_weight[0, 0] * right * right
                + 2.0 * r_weight[0, 1] * right * left
                + r_weight[1, 1] * left * left
            )
        )
        for j in range(k * substeps, (k + 1) * substeps):
            cost += step_s * _running_cost(
                poses[j, 0], poses[j, 1], poses[j, 2], reference[j], q_weight, slope
            )
            _forward(poses, j, rates[k, 0], rates[k, 1], step_s, radius, axle)
    last = rates.shape[0] * substeps
    return cost + _running_cost(
        poses[last, 0], poses[last, 1], poses[last, 2], reference[last], p_weight, slope
    )


@kernel
def _value_of_step(value, slope, heading, right, left, step_s, radius, axle, q_weight, slope_q):
    """Take V and s of y = (q, u), (5, 5) and (5,), an Euler step y' = A y back, in place.

    V becomes A'V A + h Q, the slope s A's + h Q e.
    """
    half = 0.5 * radius * step_s
    c, s = math.cos(heading), math.sin(heading)
    way = half * (right + left)
    spin = step_s * radius / axle
    for row in range(5):  # V A: columns of A differ from the identity in 2 (heading), 3, 4
        vx, vy, vh = value[row, 0], value[row, 1], value[row, 2]
        value[row, 2] = vh + way * (-s * vx + c * vy)
        value[row, 3] += half * (c * vx + s * vy) + spin * vh
        value[row, 4] += half * (c * vx + s * vy) - spin * vh
    for col in range(5):  # A'(V A)
        vx, vy, vh = value[0, col], value[1, col], value[2, col]
        value[2, col] = vh + way * (-s * vx + c * vy)
        value[3, col] += half * (c * vx + s * vy) + spin * vh
        value[4, col] += half * (c * vx + s * vy) - spin * vh
    sx, sy, sh = slope[0], slope[1], slope[2]
    slope[2] = sh + way * (-s * sx + c * sy)
    slope[3] += half * (c * sx + s * sy) + spin * sh
    slope[4] += half * (c * sx + s * sy) - spin * sh
    for i in range(3):
        slope[i] += step_s * slope_q[i]
        for j in range(3):
            value[i, j] += step_s * q_weight[i, j]


@kernel
def _bounded_step(a, b, d, g0, g1, low, high, step, free):
    """Minimise a u²/2 + b u v + d v²/2 + g0 u + g1 v in a box; ``free`` says which are not cut."""
    det = a * d - b * b
    u, v = (b * g1 - d * g0) / det, (b * g0 - a * g1) / det
    free[0] = free[1] = True
    if low[0] <= u <= high[0] and low[1] <= v <= high[1]:
        step[0], step[1] = u, v
        return
    best = np.inf
    for fixed in range(2):  # the minimum lies on an edge: all four of them
        for side in range(2):
            bound = low[fixed] if side == 0 else high[fixed]
            other = 1 - fixed
            bend, pull = (d, g1) if fixed == 0 else (a, g0)
            best_other = -(pull + b * bound) / bend
            cut = min(max(best_other, low[other]), high[other])
            u, v = (bound, cut) if fixed == 0 else (cut, bound)
            cost = 0.5 * a * u * u + b * u * v + 0.5 * d * v * v + g0 * u + g1 * v
            if cost < best:
                best = cost
                step[0], step[1] = u, v
                free[fixed], free[other] = False, cut == best_other


@kernel
def _backward(
    rates,
    wanted,
    reference,
    q_weight,
    p_weight,
    r_weight,
    step_s,
    substeps,
    radius,
    axle,
    limit,
    damping,
    poses,
    steps,
    gains,
):
    """Fill the open-loop steps (n, 2) and the feedback gains (n, 2, 3); return the cost's slope."""
    n = rates.shape[0]
    value, slope, slope_q = np.zeros((5, 5)), np.zeros(5), np.empty(3)
    low, high, free = np.empty(2), np.empty(2), np.empty(2, dtype=np.bool_)
    last = n * substeps
    _running_cost(
        poses[last, 0], poses[last, 1], poses[last, 2], reference[last], p_weight, slope_q
    )
    value[:3, :3] = p_weight
    slope[:3] = slope_q
    expected = 0.0
    for k in range(n - 1, -1, -1):
        value[3:, :] = 0.0
        value[:, 3:] = 0.0
        slope[3:] = 0.0
        for j in range((k + 1) * substeps - 1, k * substeps - 1, -1):
            _running_cost(poses[j, 0], poses[j, 1], poses[j, 2], reference[j], q_weight, slope_q)
            _value_of_step(
                value,
                slope,
                poses[j, 2],
                rates[k, 0],
                rates[k, 1],
                step_s,
                radius,
                axle,
                q_weight,
                slope_q,
            )
        period = substeps * step_s
        for w in range(2):
            for i in range(2):
                value[3 + w, 3 + i] += period * r_weight[w, i]
                slope[3 + w] += period * r_weight[w, i] * (rates[k, i] - wanted[k, i])
            low[w], high[w] = -limit - rates[k, w], limit - rates[k, w]
        a, b, d = value[3, 3] + damping, value[3, 4], value[4, 4] + damping
        _bounded_step(a, b, d, slope[3], slope[4], low, high, steps[k], free)
        for i in range(3):
            g0, g1 = value[3, i], value[4, i]
            if free[0] and free[1]:
                det = a * d - b * b
                gains[k, 0, i] = (b * g1 - d * g0) / det
                gains[k, 1, i] = (b * g0 - a * g1) / det
            else:
                gains[k, 0, i] = -g0 / a if free[0] else 0.0
                gains[k, 1, i] = -g1 / d if free[1] else 0.0
        # V of q alone: substitute u = steps + gains q.
        for i in range(3):
            for w in range(2):
                bend = value[3 + w, 3] * steps[k, 0] + value[3 + w, 4] * steps[k, 1]
                slope[i] += gains[k, w, i] * (slope[3 + w] + bend) + value[i, 3 + w] * steps[k, w]
        for i in range(3):
            for j in range(i, 3):
                total = value[i, j]
                for w in range(2):
                    total += gains[k, w, i] * value[3 + w, j] + value[i, 3 + w] * gains[k, w, j]
                    for x in range(2):
                        total += gains[k, w, i] * value[3 + w, 3 + x] * gains[k, x, j]
                value[i, j] = total
        for i in range(3):
            for j in range(i):
                value[i, j] = value[j, i]
        expected += steps[k, 0] * slope[3] + steps[k, 1] * slope[4]
    return expected


@kernel
def ilqr(
    rates,
    wanted,
    start,
    reference,
    q_weight,
    p_weight,
    r_weight,
    step_s,
    substeps,
    radius,
    axle,
    limit,
    tolerance,
    poses,
    costs,
):
    """Return the iterations done; ``rates`` (n, 2) are the first guess and become the solution."""
    n = rates.shape[0]
    steps, gains = np.empty((n, 2)), np.empty((n, 2, 3))
    tried, tried_poses = np.empty((n, 2)), np.empty(poses.shape)
    poses[0] = start
    cost = _roll_out(
        rates,
        wanted,
        reference,
        q_weight,
        p_weight,
        r_weight,
        step_s,
        substeps,
        radius,
        axle,
        poses,
    )
    damping = 1e-6
    done = 0
    for i in range(costs.size):
        _backward(
            rates,
            wanted,
            reference,
            q_weight,
            p_weight,
            r_weight,
            step_s,
            substeps,
            radius,
            axle,
            limit,
            damping,
            poses,
            steps,
            gains,
        )
        share, better = 1.0, False
        new_cost = cost
        while share > 1e-3 and not better:
            tried_poses[0] = start
            for k in range(n):
                j = k * substeps
                for w in range(2):
                    rate = rates[k, w] + share * steps[k, w]
                    for c in range(3):
                        rate += gains[k, w, c] * (tried_poses[j, c] - poses[j, c])
                    tried[k, w] = min(max(rate, -limit), limit)
                for m in range(substeps):
                    _forward(tried_poses, j + m, tried[k, 0], tried[k, 1], step_s, radius, axle)
            new_cost = _roll_out(
                tried,
                wanted,
                reference,
                q_weight,
                p_weight,
                r_weight,
                step_s,
                substeps,
                radius,
                axle,
                tried_poses,
            )
            better = new_cost < cost
            share *= 0.5
        done = i + 1
        gain = cost - new_cost
        if better:
            rates[:] = tried
            poses[:] = tried_poses
            cost = new_cost
            damping = max(0.2 * damping, 1e-12)
        else:
            damping *= 10.0
        costs[i] = cost
        if (better and gain <= tolerance * cost) or damping > 1e6:
            break
    return done


@kernel
def plan_first_rates(
    wanted,
    starts,
    reference,
    q_weight,
    p_weight,
    r_weight,
    step_s,
    radius,
    axle,
    limit,
    iterations,
    first_rates,
):
    """Plan from every start, beginning with the wanted rates; keep the first of each plan."""
    poses, costs = np.empty(reference.shape), np.empty(iterations)
    for i in range(starts.shape[0]):
        rates = wanted.copy()
        ilqr(
            rates,
            wanted,
            starts[i],
            reference,
            q_weight,
            p_weight,
            r_weight,
            step_s,
            1,
            radius,
            axle,
            limit,
            1e-6,
            poses,
            costs,
        )
        first_rates[i] = rates[0]
