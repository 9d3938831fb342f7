# mypy: allow-untyped-defs
"""Compiled phase factors of a far field."""

import numpy as np

from octant.em.reader.fullwave._rwg_kernels import C4, C6, C8, C10, S3, S5, S7, S9, S11
from octant.geometries.kernels import kernel

TWO_OVER_PI = 0.6366197723675814
HALF_PI_HIGH = 1.5707963267341256  # 33 bits of pi / 2
HALF_PI_LOW = 6.077100506506192e-11
C12, C14 = 1 / 479001600, -1 / 87178291200
S13 = 1 / 6227020800


@kernel(nogil=True)
def fill_phases(direction, point, begin, end, out):
    """Fill out[i] = exp(j direction[begin + i] . point), for points (3, p) already times k.

    Sine and cosine by Taylor series about the nearest multiple of pi / 2, without branches so that
    the loop vectorises; off by less than 1e-14 below 1000 rad.
    """
    count = point.shape[1]
    for i in range(begin, end):
        dx, dy, dz = direction[i, 0], direction[i, 1], direction[i, 2]
        row = i - begin
        for p in range(count):
            x = dx * point[0, p] + dy * point[1, p] + dz * point[2, p]
            quarter = np.floor(x * TWO_OVER_PI + 0.5)
            x = (x - quarter * HALF_PI_HIGH) - quarter * HALF_PI_LOW
            t = x * x
            co = C8 + t * (C10 + t * (C12 + t * C14))
            co = 1.0 + t * (-0.5 + t * (C4 + t * (C6 + t * co)))
            si = S9 + t * (S11 + t * S13)
            si = x * (1.0 + t * (S3 + t * (S5 + t * (S7 + t * si))))
            turn = quarter - 4.0 * np.floor(0.25 * quarter)  # 0, 1, 2 or 3
            odd = turn - 2.0 * np.floor(0.5 * turn)
            swap = 1.0 - odd
            # cos: co, -si, -co, si; sin: si, co, -si, -co
            cosine_sign = (1.0 - 2.0 * odd) * (1.0 - 2.0 * np.floor(0.5 * turn))
            sine_sign = 1.0 - 2.0 * np.floor(0.5 * turn)
            out[row, p] = complex(
                cosine_sign * (swap * co + odd * si), sine_sign * (swap * si + odd * co)
            )
