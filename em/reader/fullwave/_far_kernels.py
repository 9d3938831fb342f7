# mypy: allow-untyped-defs
"""Compiled phase factors of a far field."""

from octant.em.reader.fullwave._phase_kernels import cosine_sine
from octant.geometries.kernels import kernel


@kernel(nogil=True)
def fill_phases(direction, point, begin, end, out):
    """Fill out[i] = exp(j direction[begin + i] . point), for points (3, p) already times k."""
    count = point.shape[1]
    for i in range(begin, end):
        dx, dy, dz = direction[i, 0], direction[i, 1], direction[i, 2]
        row = i - begin
        for p in range(count):
            x = dx * point[0, p] + dy * point[1, p] + dz * point[2, p]
            cosine, sine = cosine_sine(x)
            out[row, p] = complex(cosine, sine)
