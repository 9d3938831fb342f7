# mypy: allow-untyped-defs
"""How well supposed poses of the robot explain readings of several tags, by their field maps.

Poses are worked on in blocks, antenna after antenna: loops over the poses of a block, of few arrays
each, are what a processor does several of at once. A last block is worked on whole.
"""

import math

import numpy as np

from octant.em._decibel_kernels import natural_log
from octant.geometries.kernels import kernel

_BLOCK = 64
_DB = 10.0 / math.log(10.0)


@kernel
def _heard_levels(rss_db, level_db, gain_db, antenna, known):
    """Write which antennas heard a tag, and their levels without what is known; return how many."""
    heard = 0
    for c in range(rss_db.size):
        if rss_db[c] > -np.inf:
            antenna[heard] = c
            known[heard] = rss_db[c] - level_db - gain_db[c]
            heard += 1
    return heard


@kernel
def _add_antenna(here, mean, known, share, floor_w, noise, fading, lower, work, sums):
    """Add the level that one antenna reads to the sums of each of a block's poses."""
    part, total, accuracy, error = work[0], work[1], work[2], work[3]
    for b in range(here.size):
        total[b] = here[b] + share * mean[b] + floor_w
    for b in range(here.size):
        ratio = (share * mean[b] + floor_w) / total[b]
        part[b] = ratio * (2.0 - ratio)
    for b in range(here.size):
        accuracy[b] = 1.0 / (noise + fading * part[b])
    for b in range(here.size):
        error[b] = known - _DB * natural_log(total[b]) + lower * part[b]
    weight, first, second, spread = sums[0], sums[1], sums[2], sums[3]
    for b in range(here.size):
        weight[b] += accuracy[b]
    for b in range(here.size):
        spread[b] *= accuracy[b]
    for b in range(here.size):
        first[b] += error[b] * accuracy[b]
    for b in range(here.size):
        second[b] += error[b] * error[b] * accuracy[b]


@kernel
def _add_faded(mean, known, floor_w, lower, work, sums):
    """Add the same of an antenna whose fading is unknown, with an accuracy of one."""
    error, first, second = work[0], sums[1], sums[2]
    for b in range(mean.size):
        error[b] = known - _DB * natural_log(mean[b] + floor_w) + lower
    for b in range(mean.size):
        first[b] += error[b]
    for b in range(mean.size):
        second[b] += error[b] * error[b]


@kernel
def _close_sums(sums, factor, spread_factor, level_variance, trust, out):
    """Write the log-likelihoods of a block's poses, all accuracies times a factor."""
    weight, first, second, spread = sums[0], sums[1], sums[2], sums[3]
    known = 1.0 / level_variance
    for b in range(out.size):
        common = factor * weight[b] + known
        square = factor * second[b] - factor * factor * first[b] * first[b] / common
        size = common * level_variance / (spread[b] * spread_factor)
        out[b] = -0.5 * trust * (square + natural_log(size))


@kernel
def _reading_parts(
    here, mean, known, level_variance, shares, floor_w, noise_db, fading_db, outlier_db, trust,
    work, out,
):  # fmt: skip
    """Write the log-likelihood of one tag's reading under each share, and of an outlier.

    here, mean (k, b): coherent power and local mean that the antennas which heard it expect at each
    pose [W], above zero; known (k,): see `_heard_levels`; shares (s,): the last one makes all
    fading unknown; work (8, b): scratch; out (s + 1, b).
    """
    hypotheses, heard = shares.size, known.size
    if heard == 0:
        out[:] = 0.0
        return
    noise, fading = noise_db * noise_db, fading_db * fading_db
    lower = 2.51 * fading_db / 5.57
    sums = work[4:]
    for s in range(hypotheses):
        sums[:3] = 0.0
        sums[3] = 1.0
        for c in range(heard):
            if s < hypotheses - 1:
                _add_antenna(
                    here[c], mean[c], known[c], shares[s], floor_w, noise, fading,
                    lower, work, sums,
                )  # fmt: skip
            else:
                _add_faded(mean[c], known[c], floor_w, lower, work, sums)
        if s < hypotheses - 1:
            _close_sums(sums, 1.0, 1.0, level_variance, trust, out[s])
    # Where all fading is unknown, and for an outlier, the variance is one for all antennas.
    sums[0] = heard
    for s, accuracy in enumerate((1.0 / (noise + fading), 1.0 / (outlier_db * outlier_db))):
        _close_sums(sums, accuracy, accuracy**heard, level_variance, trust, out[hypotheses - 1 + s])


@kernel
def _probabilities(out, b, trusted, parts):
    """Write the probability of each share and of an outlier, (s + 1,); return the log of all."""
    most, total = -np.inf, 0.0
    for s in range(trusted.size):
        most = max(most, out[s, b])
    for s in range(trusted.size):
        parts[s] = trusted[s] * math.exp(out[s, b] - most)
        total += parts[s]
    for s in range(trusted.size):
        parts[s] /= total
    return most + math.log(total)


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
    headings, n, tags = levels.shape[4], ring.size, levels.shape[0]
    here, mean = np.ones((n, _BLOCK)), np.ones((n, _BLOCK))
    work, out = np.empty((8, _BLOCK)), np.empty((shares.size + 1, _BLOCK))
    antenna, known = np.empty((tags, n), dtype=np.int64), np.empty((tags, n))
    heard = np.empty(tags, dtype=np.int64)
    for t in range(tags):
        heard[t] = _heard_levels(rss_db[t], level_db[t], gain_db, antenna[t], known[t])
    for first in range(0, poses.shape[1], _BLOCK):
        count = min(_BLOCK, poses.shape[1] - first)
        for t in range(tags):
            table = powers[t]
            for b in range(count):
                x, y, heading = poses[0, first + b], poses[1, first + b], poses[2, first + b]
                u, v = (x - grid[0]) / grid[2], (y - grid[1]) / grid[3]
                i = min(max(int(u), 0), levels.shape[1] - 2)
                j = min(max(int(v), 0), levels.shape[2] - 2)
                u, v = min(max(u - i, 0.0), 1.0), min(max(v - j, 0.0), 1.0)
                w00, w01, w10, w11 = (1.0 - u) * (1.0 - v), (1.0 - u) * v, u * (1.0 - v), u * v
                p = int((x - node_grid[0]) / node_grid[2] + 0.5)
                q = int((y - node_grid[1]) / node_grid[3] + 0.5)
                p = min(max(p, 0), means.shape[1] - 1)
                q = min(max(q, 0), means.shape[2] - 1)
                for c in range(heard[t]):
                    h = heading * per_rad + shift[antenna[t, c]]
                    g = math.floor(h)
                    w = h - g
                    g = int(g) % headings
                    f = (g + 1) % headings
                    r = ring[antenna[t, c]]
                    here[c, b] = (1.0 - w) * (
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
                    near = (1.0 - w) * table[means[t, p, q, r, g]] + w * table[means[t, p, q, r, f]]
                    mean[c, b] = max(near, table[1])
            _reading_parts(
                here, mean, known[t, : heard[t]], level_variance[t], shares, floors[t], noise_db,
                fading_db[t], outlier_db, trust, work, out,
            )  # fmt: skip
            for b in range(count):
                told = _probabilities(out, b, trusted[t], parts[first + b, t])
                logs[first + b] = told if t == 0 else logs[first + b] + told


@kernel(nogil=True)
def offset_log_likelihood(
    powers, means, rss_db, level_db, level_variance, gain_db, shares, floor_w, noise_db, fading_db,
    outlier_db, trust, trusted, each, logs, parts,
):  # fmt: skip
    """Write log-likelihoods of one tag's reading: for poses and places of the tag, and for poses.

    powers (m, k, n): coherent power of a tag at each of k places that are equally likely [W]; means
    (m, n): local mean [W]; the rest as for `pose_log_likelihood`, of one tag. each (m, k); logs
    (m,): of the mean over the places; parts (m, s + 1): probabilities of the shares after it.
    """
    places, n = powers.shape[1], rss_db.size
    here, mean = np.ones((n, _BLOCK)), np.ones((n, _BLOCK))
    work, out = np.empty((8, _BLOCK)), np.empty((shares.size + 1, _BLOCK))
    antenna, known, one = np.empty(n, dtype=np.int64), np.empty(n), np.empty(shares.size + 1)
    heard = _heard_levels(rss_db, level_db, gain_db, antenna, known)
    pairs = powers.shape[0] * places
    best, whole = -np.inf, 0.0
    for first in range(0, pairs, _BLOCK):
        count = min(_BLOCK, pairs - first)
        for b in range(count):
            m, k = (first + b) // places, (first + b) % places
            for c in range(heard):
                here[c, b], mean[c, b] = powers[m, k, antenna[c]], means[m, antenna[c]]
        _reading_parts(
            here, mean, known[:heard], level_variance, shares, floor_w, noise_db, fading_db,
            outlier_db, trust, work, out,
        )  # fmt: skip
        for b in range(count):
            m, k = (first + b) // places, (first + b) % places
            if k == 0:
                parts[m] = 0.0
                best, whole = -np.inf, 0.0
            told = _probabilities(out, b, trusted, one)
            each[m, k] = told
            if told > best:
                shrink = math.exp(best - told) if whole > 0.0 else 0.0
                for s in range(one.size):
                    parts[m, s] *= shrink
                whole, best = whole * shrink, told
            size = math.exp(told - best)
            whole += size
            for s in range(one.size):
                parts[m, s] += size * one[s]
            if k == places - 1:
                logs[m] = best + math.log(whole / places)
                for s in range(one.size):
                    parts[m, s] /= whole
