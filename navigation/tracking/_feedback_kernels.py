# mypy: allow-untyped-defs
"""The output feedback loop u = K z of thesis chapter 6: its cost and its gradient."""

import math

import numpy as np

from octant.geometries.kernels import kernel
from octant.navigation.tracking._optimal_kernels import (
    _forward,
    _pull_back,
    _running_cost,
)


@kernel
def _read_tags(x, y, tags, alpha, beta, reach, rss, slope_x, slope_y):
    """Fill the RSS of (6.2) without noise, and its slopes along x and y; zero beyond reach."""
    for j in range(tags.shape[0]):
        dx, dy, dz = x - tags[j, 0], y - tags[j, 1], tags[j, 2]
        distance = math.sqrt(dx * dx + dy * dy + dz * dz)
        if distance > reach:
            rss[j] = slope_x[j] = slope_y[j] = 0.0
            continue
        rss[j] = alpha * math.exp(beta * distance)
        rate = beta * rss[j] / distance
        slope_x[j], slope_y[j] = rate * dx, rate * dy


@kernel
def feedback_cost(
    gains,
    noise,
    tags,
    alpha,
    beta,
    reach,
    start,
    reference,
    q_weight,
    p_weight,
    period_s,
    radius,
    axle,
    limit,
    poses,
    rates,
    read,
    gradient,
):
    """Return the cost of u = K z for one noise record; ADD dJ/dK to ``gradient`` (n, 2, s).

    Fills poses (n + 1, 3), rates (n, 2) and what was read (n, s).
    """
    steps, s = noise.shape
    slope, slope_u, costate = np.empty(3), np.empty(2), np.empty(3)
    slope_x, slope_y = np.empty((steps, s)), np.empty((steps, s))
    poses[0] = start
    cost = 0.0
    for k in range(steps):
        _read_tags(
            poses[k, 0], poses[k, 1], tags, alpha, beta, reach, read[k], slope_x[k], slope_y[k]
        )
        for w in range(2):
            wanted = 0.0
            for j in range(s):
                if w == 0 and read[k, j] != 0.0:
                    read[k, j] += noise[k, j]
                wanted += gains[k, w, j] * read[k, j]
            rates[k, w] = min(max(wanted, -limit), limit)
        cost += period_s * _running_cost(
            poses[k, 0], poses[k, 1], poses[k, 2], reference[k], q_weight, slope
        )
        _forward(poses, k, rates[k, 0], rates[k, 1], period_s, radius, axle)
    cost += _running_cost(
        poses[steps, 0], poses[steps, 1], poses[steps, 2], reference[steps], p_weight, costate
    )
    for k in range(steps - 1, -1, -1):
        _pull_back(costate, poses[k, 2], rates[k, 0], rates[k, 1], period_s, radius, axle, slope_u)
        for w in range(2):
            if abs(rates[k, w]) < limit:
                for j in range(s):
                    gradient[k, w, j] += slope_u[w] * read[k, j]
                    costate[0] += slope_u[w] * gains[k, w, j] * slope_x[k, j]
                    costate[1] += slope_u[w] * gains[k, w, j] * slope_y[k, j]
        _running_cost(poses[k, 0], poses[k, 1], poses[k, 2], reference[k], q_weight, slope)
        costate += period_s * slope
    return cost


@kernel(nogil=True)
def mean_cost(
    gains,
    noise,
    tags,
    alpha,
    beta,
    reach,
    start,
    reference,
    q_weight,
    p_weight,
    period_s,
    radius,
    axle,
    limit,
    poses,
    rates,
    read,
    gradient,
    square,
):
    """Return the cost averaged over noise records; fill the gradient and mean |z|² likewise."""
    records = noise.shape[0]
    gradient[:] = 0.0
    square[:] = 0.0
    cost = 0.0
    for i in range(records):
        cost += feedback_cost(
            gains,
            noise[i],
            tags,
            alpha,
            beta,
            reach,
            start,
            reference,
            q_weight,
            p_weight,
            period_s,
            radius,
            axle,
            limit,
            poses,
            rates,
            read,
            gradient,
        )
        for k in range(square.size):
            for j in range(read.shape[1]):
                square[k] += read[k, j] * read[k, j] / records
    gradient /= records
    return cost / records
