# mypy: allow-untyped-defs
"""How well supposed places of a tag explain one reading: log-likelihoods over a pattern table."""

import math

import numpy as np
import numpy.typing as npt
from numba import njit

_Floats = npt.NDArray[np.float64]


@njit(cache=True, error_model="numpy")
def place_log_likelihood(
    ahead: _Floats,
    left: _Floats,
    diffuse_db: _Floats,
    heading: _Floats,
    reach: float,
    power: _Floats,
    rss_db: _Floats,
    noise_db: float,
    fading_db: float,
    level_db: float,
    null_share: float,
    result: _Floats,
) -> None:
    """Write the log-likelihood of each supposed place and diffuse level into result (m,).

    ahead, left (m,): the place in the robot's frame [m]; diffuse_db (m,): power from everywhere;
    heading (m,): of the robot [rad]; power (r, b, s, n): the table, like diffuse_db in the unit of
    rss_db (n,): the reading, -inf where nothing was received, which tells nothing here. null_share
    of the mean direct power is added to each antenna: deeper nulls are not known.
    """
    rows, bearings, sides, antennas = power.shape
    turn = 2.0 * math.pi
    direct = np.empty(antennas)
    for p in range(ahead.size):
        rho = math.sqrt(ahead[p] ** 2 + left[p] ** 2)
        phi = math.atan2(left[p], ahead[p])
        u = min(math.sqrt(rho / reach) * (rows - 1), rows - 1.000001)
        v = (phi / turn) % 1.0 * bearings
        w = ((heading[p] + phi) / turn + 0.5) % 1.0 * sides
        i, j, k = int(u), int(v), int(w)
        u -= i
        v -= j
        w -= k
        j %= bearings
        k %= sides
        j_next, k_next = (j + 1) % bearings, (k + 1) % sides
        mean = 0.0
        for a in range(antennas):
            near = (1.0 - v) * ((1.0 - w) * power[i, j, k, a] + w * power[i, j, k_next, a]) + v * (
                (1.0 - w) * power[i, j_next, k, a] + w * power[i, j_next, k_next, a]
            )
            far = (1.0 - v) * (
                (1.0 - w) * power[i + 1, j, k, a] + w * power[i + 1, j, k_next, a]
            ) + v * ((1.0 - w) * power[i + 1, j_next, k, a] + w * power[i + 1, j_next, k_next, a])
            direct[a] = (1.0 - u) * near + u * far
            mean += direct[a] / antennas
        diffuse = 10.0 ** (0.1 * diffuse_db[p]) + null_share * mean
        weight, first, second, spread = 0.0, 0.0, 0.0, 0.0
        for a in range(antennas):
            if rss_db[a] == -np.inf:
                continue
            total = direct[a] + diffuse
            share = diffuse / total
            variance = noise_db**2 + fading_db**2 * share * (2.0 - share)
            error = rss_db[a] - 10.0 * math.log10(total)
            weight += 1.0 / variance
            first += error / variance
            second += error * error / variance
            spread += math.log(variance)
        common = weight + 1.0 / level_db**2
        result[p] = -0.5 * (
            second - first * first / common + spread + math.log(common * level_db**2)
        )
