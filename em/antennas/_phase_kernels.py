# mypy: allow-untyped-defs
"""Compiled sine and cosine of a phase, both at once, and angles; inlined and without a branch.

The library's take one call each, and with them a third of the time of a path's field.
"""

import numpy as np

from octant.geometries.kernels import kernel

_TWO_OVER_PI = 2.0 / np.pi
# pi/2 in two parts, of which the first has 33 bits: its multiples are exact for a million radians.
_HALF_PI_HIGH = 1.57079632673412561417
_HALF_PI_LOW = 6.07710050650619224932e-11


@kernel(forceinline=True)
def sine_cosine(phase):
    """Return sine and cosine of a phase to 2e-16; beyond 1e6 rad to the phase's own rounding.

    Reduced to [-pi/4, pi/4] after Cody and Waite (Software Manual for the Elementary Functions,
    1980), where the series up to the 16th power is exact to rounding.
    """
    quarter = np.floor(phase * _TWO_OVER_PI + 0.5)
    y = (phase - quarter * _HALF_PI_HIGH) - quarter * _HALF_PI_LOW
    z = y * y
    sine = 1.0 / 6227020800.0 - z * (1.0 / 1307674368000.0)
    sine = 1.0 / 362880.0 - z * (1.0 / 39916800.0 - z * sine)
    sine = 1.0 / 6.0 - z * (1.0 / 120.0 - z * (1.0 / 5040.0 - z * sine))
    sine = y - y * z * sine
    cosine = 1.0 / 479001600.0 - z * (1.0 / 87178291200.0 - z * (1.0 / 20922789888000.0))
    cosine = 1.0 / 720.0 - z * (1.0 / 40320.0 - z * (1.0 / 3628800.0 - z * cosine))
    cosine = 1.0 - z * (0.5 - z * (1.0 / 24.0 - z * cosine))
    half = 0.5 * quarter
    odd = half != np.floor(half)
    back = np.floor(half) != 2.0 * np.floor(0.5 * half)  # quarters 2 and 3
    sine, cosine = (cosine if odd else sine), (-sine if odd else cosine)
    return (-sine if back else sine), (-cosine if back else cosine)


@kernel(forceinline=True)
def angle_of(y, x):
    """Return the angle of the point x, y from the x axis [rad] to 5e-16; 0 of the origin.

    The arc tangent up to tan(pi/8) is the rational function of Moshier (Methods and Programs for
    Mathematical Functions, 1989), beyond it is pi/4 more of (y - x) / (y + x).
    """
    least, most = min(abs(x), abs(y)), max(abs(x), abs(y))
    steep = least > 0.41421356237309503 * most
    up = least - most if steep else least
    down = least + most if steep else most
    t = up / (down if down > 0.0 else 1.0)
    z = t * t
    p = 75.00855792314704667340 + z * (16.15753718733365076637 + z * 0.8750608600031904122785)
    p = 64.85021904942025371773 + z * (122.8866684490136173410 + z * p)
    q = 165.0270098316988542046 + z * (24.85846490142306297962 + z)
    q = 485.3903996359136964868 + z * (432.8810604912902668951 + z * q)
    q = 194.5506571482613964425 + z * q
    angle = t - t * (z * p / q)
    angle = angle + 0.25 * np.pi if steep else angle
    angle = 0.5 * np.pi - angle if abs(y) > abs(x) else angle
    angle = np.pi - angle if x < 0.0 else angle
    return -angle if y < 0.0 else angle
