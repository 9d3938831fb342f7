# mypy: allow-untyped-defs
"""Compiled test of where a point of a plane lies with respect to a facet."""

import numpy as np

from octant.geometries.kernels import kernel

OUTSIDE, INSIDE, ON_RIM = 0, 1, 2
"""Where a point of its plane lies with respect to a facet."""


@kernel
def winds_around(outline, begin, end, u, v, tolerance):
    """Return where a point lies with respect to the polygon of directed edges."""
    winding = 0
    for i in range(begin, end):
        u0, v0, u1, v1 = outline[i, 0], outline[i, 1], outline[i, 2], outline[i, 3]
        du, dv = u1 - u0, v1 - v0
        side = du * (v - v0) - (u - u0) * dv
        length2 = du * du + dv * dv
        if length2 > 0.0 and side * side <= tolerance * tolerance * length2:
            along = (u - u0) * du + (v - v0) * dv
            slack = tolerance * np.sqrt(length2)
            if -slack <= along <= length2 + slack:
                return ON_RIM
        if v0 <= v:
            if v1 > v and side > 0.0:
                winding += 1
        elif v1 <= v and side < 0.0:
            winding -= 1
    return INSIDE if winding != 0 else OUTSIDE


@kernel(forceinline=True)
def place_on_facet(facet_box, facet_outline, outline, facet, u, v, tolerance):
    """Return where a point of its plane lies with respect to a facet; NaN is outside."""
    if not (
        facet_box[facet, 0] - tolerance <= u <= facet_box[facet, 2] + tolerance
        and facet_box[facet, 1] - tolerance <= v <= facet_box[facet, 3] + tolerance
    ):
        return OUTSIDE
    begin, end = facet_outline[facet, 0], facet_outline[facet, 1]
    if begin < end:
        return winds_around(outline, begin, end, u, v, tolerance)
    if (
        u < facet_box[facet, 0] + tolerance
        or v < facet_box[facet, 1] + tolerance
        or u > facet_box[facet, 2] - tolerance
        or v > facet_box[facet, 3] - tolerance
    ):
        return ON_RIM
    return INSIDE
