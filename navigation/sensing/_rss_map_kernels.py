# mypy: allow-untyped-defs
"""Bilinear interpolation of RSS maps of many tags."""

from octant.geometries.kernels import kernel


@kernel(nogil=True)
def interpolate(places, low_x, low_y, spacing_x, spacing_y, values, out):
    """Fill ``out`` (m, s) from ``values`` (nx, ny, s); outside the map its edge goes on."""
    nx, ny = values.shape[0], values.shape[1]
    for m in range(places.shape[0]):
        u = min(max((places[m, 0] - low_x) / spacing_x, 0.0), nx - 1.0)
        v = min(max((places[m, 1] - low_y) / spacing_y, 0.0), ny - 1.0)
        i, j = min(int(u), nx - 2), min(int(v), ny - 2)
        u, v = u - i, v - j
        w00, w10, w01, w11 = (1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v
        for t in range(values.shape[2]):
            out[m, t] = (
                w00 * values[i, j, t]
                + w10 * values[i + 1, j, t]
                + w01 * values[i, j + 1, t]
                + w11 * values[i + 1, j + 1, t]
            )
