# mypy: allow-untyped-defs
"""How well supposed places of a tag explain one reading: log-likelihoods over a pattern table."""

import math

import numpy as np
import numpy.typing as npt

from octant.geometries.kernels import kernel

_Floats = npt.NDArray[np.float64]


@kernel
def place_log_likelihood(
    places: _Floats,
    reach: float,
    power: _Floats,
    reference_db: float,
    rss_db: _Floats,
    noise_db: float,
    fading_db: float,
    trust: float,
    null_share: float,
    independent: float,
    result: _Floats,
) -> None:
    """Write how each supposed place explains a reading into result (3, m).

    places (9, m): ahead and to the left of the robot [m], diffuse power over the reference [dB],
    heading of the robot [rad], the level over the table's of the tag and of the way [dB], variance
    of the first, covariance, variance of the second [dB²]; power (r, b, s, n): the table,
    reference_db in the unit of rss_db (n,): the reading, -inf where nothing was received, which
    tells nothing here. null_share of the mean direct power is added to each antenna: deeper nulls
    are not known. The reading counts as trust of one, and more antennas than independent ones count
    as those. Rows of result: log-likelihood; by how much the reading is above the supposed level
    [dB], and the variance of that from the antennas [dB²].
    """
    rows, bearings, sides, antennas = power.shape
    turn = 2.0 * math.pi
    direct = np.empty(antennas)
    for p in range(places.shape[1]):
        ahead, left = places[0, p], places[1, p]
        rho = math.sqrt(ahead**2 + left**2)
        phi = math.atan2(left, ahead)
        u = min(math.sqrt(rho / reach) * (rows - 1), rows - 1.000001)
        v = (phi / turn) % 1.0 * bearings
        w = ((places[3, p] + phi) / turn + 0.5) % 1.0 * sides
        i, j, k = int(u), int(v), int(w)
        u -= i
        v -= j
        w -= k
        j %= bearings
        k %= sides
        j_next, k_next = (j + 1) % bearings, (k + 1) % sides
        mean, heard = 0.0, 0
        for a in range(antennas):
            if rss_db[a] == -np.inf:
                continue
            near = (1.0 - v) * ((1.0 - w) * power[i, j, k, a] + w * power[i, j, k_next, a]) + v * (
                (1.0 - w) * power[i, j_next, k, a] + w * power[i, j_next, k_next, a]
            )
            far = (1.0 - v) * (
                (1.0 - w) * power[i + 1, j, k, a] + w * power[i + 1, j, k_next, a]
            ) + v * ((1.0 - w) * power[i + 1, j_next, k, a] + w * power[i + 1, j_next, k_next, a])
            direct[a] = (1.0 - u) * near + u * far
            mean += direct[a]
            heard += 1
        mean /= heard
        diffuse = 10.0 ** (0.1 * (places[2, p] + reference_db)) + null_share * mean
        share = diffuse / (mean + diffuse)
        shared = fading_db**2 * share * (2.0 - share) / trust
        supposed = places[4, p] + places[5, p]
        weight, first, second, spread = 0.0, 0.0, 0.0, 0.0
        for a in range(antennas):
            if rss_db[a] == -np.inf:
                continue
            total = direct[a] + diffuse
            share = diffuse / total
            variance = noise_db**2 + fading_db**2 * share * (2.0 - share)
            error = rss_db[a] - 10.0 * math.log10(total) - supposed
            weight += 1.0 / variance
            first += error / variance
            second += error * error / variance
            spread += math.log(variance)
        counted = trust * min(1.0, independent / heard)
        weight *= counted
        first *= counted
        second *= counted
        spread *= counted
        level = places[6, p] + 2.0 * places[7, p] + places[8, p] + shared
        common = weight + 1.0 / level
        result[0, p] = -0.5 * (second - first * first / common + spread + math.log(common * level))
        result[1, p] = first / weight
        result[2, p] = 1.0 / weight + shared
