# mypy: allow-untyped-defs
"""How well supposed poses of the robot explain readings of several tags, by their field maps."""

import math

import numpy as np

from octant.geometries.kernels import kernel


@kernel(nogil=True)
def pose_log_likelihood(
    poses, grid, levels, node_grid, means, powers, ring, shift, rss_db, level_db, level_variance,
    gain_db, shares, floors, noise_db, fading_db, outlier_db, trust, trusted, logs,
    parts,
):  # fmt: skip
    """Write log-likelihoods (m,) of all tags' readings, and probabilities (m, t, s + 1).

    poses (3, m): x, y [m], heading [rad]; grid, node_grid (4,): lowest x, y and cells [m] of levels
    (t, nx, ny, r, h) and means (t, cx, cy, r, h), codes that powers (t, 256) translate; rss_db
    (t, n), -inf where nothing was received: that tells nothing here. level_db, level_variance (t,),
    gain_db (n,): what is known of the tags' and antennas' levels. shares (s,): power of the error
    field over the local mean; floors (t,) [W]: what is added to it everywhere. The probabilities
    are those of each share after the reading, before it trusted (t, s + 1); the last one is an
    outlier's.
    """
    per_rad = levels.shape[4] / (2.0 * math.pi)
    headings, hypotheses = levels.shape[4], shares.size
    n = ring.size
    weight, first = np.empty(hypotheses + 1), np.empty(hypotheses + 1)
    second, spread = np.empty(hypotheses + 1), np.empty(hypotheses + 1)
    for k in range(poses.shape[1]):
        u, v = (poses[0, k] - grid[0]) / grid[2], (poses[1, k] - grid[1]) / grid[3]
        i = min(max(int(u), 0), levels.shape[1] - 2)
        j = min(max(int(v), 0), levels.shape[2] - 2)
        u, v = min(max(u - i, 0.0), 1.0), min(max(v - j, 0.0), 1.0)
        w00, w01, w10, w11 = (1.0 - u) * (1.0 - v), (1.0 - u) * v, u * (1.0 - v), u * v
        a = int((poses[0, k] - node_grid[0]) / node_grid[2] + 0.5)
        b = int((poses[1, k] - node_grid[1]) / node_grid[3] + 0.5)
        a = min(max(a, 0), means.shape[1] - 1)
        b = min(max(b, 0), means.shape[2] - 1)
        logs[k] = 0.0
        for t in range(levels.shape[0]):
            weight[:] = 0.0
            first[:] = 0.0
            second[:] = 0.0
            spread[:] = 1.0
            heard, sums, squares = 0, 0.0, 0.0
            table = powers[t]
            fading = fading_db[t] * fading_db[t]
            lower = 2.51 * fading_db[t] / 5.57
            for c in range(n):
                if rss_db[t, c] == -np.inf:
                    continue
                heard += 1
                h = poses[2, k] * per_rad + shift[c]
                g = math.floor(h)
                w = h - g
                g = int(g) % headings
                f = (g + 1) % headings
                r = ring[c]
                here = (1.0 - w) * (
                    w00 * table[levels[t, i, j, r, g]]
                    + w01 * table[levels[t, i, j + 1, r, g]]
                    + w10 * table[levels[t, i + 1, j, r, g]]
                    + w11 * table[levels[t, i + 1, j + 1, r, g]]
                ) + w * (
                    w00 * table[levels[t, i, j, r, f]]
                    + w01 * table[levels[t, i, j + 1, r, f]]
                    + w10 * table[levels[t, i + 1, j, r, f]]
                    + w11 * table[levels[t, i + 1, j + 1, r, f]]
                )
                mean = (1.0 - w) * table[means[t, a, b, r, g]] + w * table[means[t, a, b, r, f]]
                mean = max(mean, table[1])
                known = rss_db[t, c] - level_db[t] - gain_db[c]
                for s in range(hypotheses - 1):
                    diffuse = shares[s] * mean + floors[t]
                    total = here + diffuse
                    part = diffuse / total
                    part *= 2.0 - part
                    variance = noise_db * noise_db + fading * part
                    error = known - 4.342944819032518 * math.log(total) + lower * part
                    accuracy = 1.0 / variance
                    weight[s] += accuracy
                    first[s] += error * accuracy
                    second[s] += error * error * accuracy
                    spread[s] *= variance
                error = known - 4.342944819032518 * math.log(mean + floors[t]) + lower
                sums += error
                squares += error * error
            # Where all fading is unknown, and for an outlier, the variance is one for all antennas.
            for s in range(hypotheses - 1, hypotheses + 1):
                variance = outlier_db * outlier_db
                if s < hypotheses:
                    variance = noise_db * noise_db + fading
                weight[s], first[s] = heard / variance, sums / variance
                second[s], spread[s] = squares / variance, variance**heard
            for s in range(hypotheses + 1):
                parts[k, t, s] = 0.0
                if heard > 0:
                    common = weight[s] + 1.0 / level_variance[t]
                    square = second[s] - first[s] * first[s] / common
                    parts[k, t, s] = (
                        -0.5 * trust * (square + math.log(spread[s] * common * level_variance[t]))
                    )
            most, total = -np.inf, 0.0
            for s in range(hypotheses + 1):
                most = max(most, parts[k, t, s])
            for s in range(hypotheses + 1):
                parts[k, t, s] = trusted[t, s] * math.exp(parts[k, t, s] - most)
                total += parts[k, t, s]
            for s in range(hypotheses + 1):
                parts[k, t, s] /= total
            logs[k] += most + math.log(total)
