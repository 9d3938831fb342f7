# mypy: allow-untyped-defs
"""Cosine, sine and logarithm in loops that the processor runs several values at a time."""

import numpy as np

from octant.geometries.kernels import kernel

# Taylor's, of the cosine and the sine
C4, C6, C8, C10, C12 = 1 / 24, -1 / 720, 1 / 40320, -1 / 3628800, 1 / 479001600
C14 = -1 / 87178291200
S3, S5, S7, S9, S11, S13 = -1 / 6, 1 / 120, -1 / 5040, 1 / 362880, -1 / 39916800, 1 / 6227020800

TWO_OVER_PI = 0.6366197723675814
HALF_PI_HIGH = 1.5707963267341256  # 33 bits of pi / 2
HALF_PI_LOW = 6.077100506506192e-11

ONE_BITS = 1023 << 52  # of the number 1.0
FRACTION_BITS = (1 << 52) - 1
ROOT_TWO = 1.4142135623730951
LOG_TWO = 0.6931471805599453


@kernel(nogil=True, forceinline=True)
def cosine_sine(x):
    """Return the cosine and the sine of x [rad], off by less than 3e-14 below 1000 rad.

    By Taylor series about the nearest multiple of pi / 2, without branches.
    """
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
    sine_sign = 1.0 - 2.0 * np.floor(0.5 * turn)
    cosine_sign = (1.0 - 2.0 * odd) * sine_sign
    return cosine_sign * (swap * co + odd * si), sine_sign * (swap * si + odd * co)


@kernel(nogil=True)
def logarithms(values, bits, exponent, count):
    """Replace the first values, each at least 1, by their logarithms, off by 1e-15 of them.

    ``bits`` are the same values seen as int64, ``exponent`` is scratch. A value is m 2^e; log m is
    twice the inverse hyperbolic tangent of (m - 1) / (m + 1), below 0.172.
    """
    for i in range(count):
        whole = bits[i]
        exponent[i] = (whole >> 52) - 1023
        bits[i] = (whole & FRACTION_BITS) | ONE_BITS
    for i in range(count):
        high = 1.0 if values[i] > ROOT_TWO else 0.0
        m = values[i] * (1.0 - 0.5 * high)
        f = (m - 1.0) / (m + 1.0)
        t = f * f
        tail = 1 / 13 + t * (1 / 15 + t * (1 / 17 + t * (1 / 19 + t * (1 / 21))))
        tail = 1 / 3 + t * (1 / 5 + t * (1 / 7 + t * (1 / 9 + t * (1 / 11 + t * tail))))
        values[i] = (exponent[i] + high) * LOG_TWO + 2.0 * (f + f * t * tail)
