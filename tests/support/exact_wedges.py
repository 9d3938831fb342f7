"""Exact fields about perfectly conducting wedges, by eigenfunctions and by Macdonald's integral.

Time e^{+jwt}; a wedge of air angle n pi, faces at phi = 0 and n pi. It shares nothing with the
package. The series is that of Bowman, Senior and Uslenghi (1969); the integral is
the diffracted part alone, Macdonald's, on its path of steepest descent.
"""

from functools import cache

import numpy as np
from scipy.special import erfc, hankel2, jv

SOFT, HARD = -1.0, 1.0

gauss = cache(np.polynomial.legendre.leggauss)


def line_source(k, n, near, far, kind):
    """Total field of H0(2)(k R) for two cylindrical places (rho, phi), near.rho < far.rho."""
    (r0, p0), (r1, p1) = near, far
    top = int(n * (k * r0 + 12.0 * (k * r0) ** (1.0 / 3.0) + 30.0))
    m = np.arange(top + 1)
    with np.errstate(over="ignore", invalid="ignore"):
        radial = jv(m / n, k * r0) * hankel2(m / n, k * r1)
    radial[~np.isfinite(radial)] = 0.0
    angular = np.cos(m * (p0 - p1) / n) + kind * np.cos(m * (p0 + p1) / n)
    return np.sum(np.where(m == 0, 1.0, 2.0) * radial * angular) / n


def plane_wave_half_plane(k, rho, phi, phi_in, kind):
    """Sommerfeld's total field, of unit incident amplitude at the edge."""

    def part(beta):
        z = -np.exp(0.25j * np.pi) * np.sqrt(2.0 * k * rho) * np.cos(beta / 2.0)
        return np.exp(1j * k * rho * np.cos(beta)) * 0.5 * erfc(z)

    return part(phi - phi_in) + kind * part(phi + phi_in)


def images(n, phi, phi_in):
    """Every image that reaches phi: (azimuth, number of reflections); boundaries count as lit."""
    found = []
    for count in range(-int(2.0 / n) - 2, int(2.0 / n) + 3):
        for azimuth, reflections in (
            (phi_in + 2.0 * n * np.pi * count, abs(2 * count)),
            (-phi_in + 2.0 * n * np.pi * count, abs(2 * count - 1)),
        ):
            if abs(phi - azimuth) <= np.pi + 1e-12:
                found.append((azimuth, reflections))
    places = {}
    for azimuth, reflections in found:  # images a full turn apart are one
        places[round(azimuth % (2.0 * np.pi), 9) % round(2.0 * np.pi, 9)] = (azimuth, reflections)
    return list(places.values())


def geometrical_optics(wave, n, source, receiver, kind):
    """Sum of ``wave(R)`` over the images; source and receiver are (rho, phi, z)."""
    (r0, p0, z0), (r1, p1, z1) = source, receiver
    total = 0.0
    for azimuth, reflections in images(n, p1, p0):
        square = r0**2 + r1**2 - 2.0 * r0 * r1 * np.cos(p1 - azimuth) + (z1 - z0) ** 2
        total = total + kind**reflections * wave(np.sqrt(square))
    return total


def point_source_diffracted(k, n, source, receiver, kind, points=200):
    """Diffracted part of the field of e^{-jkR}/R; total = images + this."""
    (r0, p0, z0), (r1, p1, z1) = source, receiver
    shortest = np.sqrt((r0 + r1) ** 2 + (z1 - z0) ** 2)
    # R = shortest - j v^2: the phase does not turn, and the square root at the start is gone.
    nodes, weights = gauss(points)
    end = np.sqrt(40.0 / k)
    v, dv = 0.5 * end * (nodes + 1.0), 0.5 * end * weights
    length = shortest - 1j * v**2
    hyperbolic = (length**2 - r0**2 - r1**2 - (z1 - z0) ** 2) / (2.0 * r0 * r1)
    # cosh(eta) - 1 without the loss of digits at v = 0; sinh(eta) / v stays finite.
    excess = -1j * (2.0 * shortest - 1j * v**2) / (2.0 * r0 * r1)  # (cosh(eta) - 1) / v^2
    sinh_over_v = np.sqrt(excess * (hyperbolic + 1.0))
    eta = 2.0 * np.arcsinh(v * np.sqrt(0.5 * excess))
    kernel = 0.0
    for sign in (1.0, -1.0):
        for beta, weight in ((p1 - p0, 1.0), (p1 + p0, kind)):
            angle = (np.pi + sign * beta) / n
            kernel = kernel + weight * np.sin(angle) / (np.cosh(eta / n) - np.cos(angle))
    measure = -2j * np.exp(-1j * k * shortest - k * v**2) / (r0 * r1 * sinh_over_v)
    return -np.sum(kernel * measure * dv) / (2.0 * np.pi * n)


def point_source(k, n, source, receiver, kind):
    """Total field of e^{-jkR}/R."""
    go = geometrical_optics(lambda r: np.exp(-1j * k * r) / r, n, source, receiver, kind)
    return go + point_source_diffracted(k, n, source, receiver, kind)


def two_knife_edges(wavenumber, spaces, heights):
    """Return the field behind two knife edges over that without them, paraxial.

    Huygens' integral over both planes (Vogler, Radio Sci. 17, 1982, p. 1541): the inner one is an
    error function, the outer one runs along the path of steepest descent of the whole.
    """
    s1, s2, s3 = spaces
    h1, h2 = heights
    a = 0.5j * wavenumber * (1.0 / s2 + 1.0 / s3)
    both = 0.5j * wavenumber * (1.0 / s1 + 1.0 / (s2 + s3))
    most = abs(h1) + abs(h2) + 12.0 * np.sqrt(sum(spaces) / wavenumber)
    x, weights = np.polynomial.legendre.leggauss(600)
    turn = np.exp(-0.25j * np.pi)
    z = h1 + turn * 0.5 * most * (x + 1.0)
    ahead = np.sqrt(a) * (h2 - z * s3 / (s2 + s3))
    beyond = np.exp(-both * z * z) * erfc(ahead)
    return 0.25 * most * turn * (weights @ beyond) * np.sqrt(both / np.pi)
