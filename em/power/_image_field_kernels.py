# mypy: allow-untyped-defs
"""Coherent power of many sources at places, from image points and slowly varying amplitudes."""

import math

import numpy as np

from octant.geometries.kernels import kernel


@kernel(nogil=True)
def image_power(
    places,
    begin,
    end,
    low_x,
    low_y,
    cell_x,
    cell_y,
    z,
    amplitude,
    images,
    first_image,
    wavenumber,
    wavenumber_step,
    channel_weight,
    power,
):
    """Fill ``power`` (m, t) of rows begin to end: the channels' weighted mean of |sum of paths|².

    amplitude (nx, ny, p) is each path's gain without its phase e^{-jkL}; first_image (t + 1,)
    says which images belong to which source; channel c has the wavenumber k + c dk.
    """
    channels = channel_weight.size
    real, imag = np.empty(channels), np.empty(channels)
    nx, ny = amplitude.shape[0], amplitude.shape[1]
    for m in range(begin, end):
        u, v = (places[m, 0] - low_x) / cell_x, (places[m, 1] - low_y) / cell_y
        i, j = min(max(int(u), 0), nx - 2), min(max(int(v), 0), ny - 2)
        u, v = u - i, v - j
        w00, w10, w01, w11 = (1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v
        for t in range(first_image.size - 1):
            real[:] = 0.0
            imag[:] = 0.0
            for p in range(first_image[t], first_image[t + 1]):
                dx, dy, dz = (
                    places[m, 0] - images[p, 0],
                    places[m, 1] - images[p, 1],
                    z - images[p, 2],
                )
                length = math.sqrt(dx * dx + dy * dy + dz * dz)
                a = (
                    w00 * amplitude[i, j, p]
                    + w10 * amplitude[i + 1, j, p]
                    + w01 * amplitude[i, j + 1, p]
                    + w11 * amplitude[i + 1, j + 1, p]
                )
                c, s = math.cos(wavenumber * length), -math.sin(wavenumber * length)
                re, im = a.real * c - a.imag * s, a.real * s + a.imag * c
                real[0] += re
                imag[0] += im
                if channels > 1:
                    c, s = math.cos(wavenumber_step * length), -math.sin(wavenumber_step * length)
                    for n in range(1, channels):
                        re, im = re * c - im * s, re * s + im * c
                        real[n] += re
                        imag[n] += im
            total = 0.0
            for n in range(channels):
                total += channel_weight[n] * (real[n] * real[n] + imag[n] * imag[n])
            power[m, t] = total
