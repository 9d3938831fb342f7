"""Rooms of tests."""

from octant.geometries.rooms import prism_room


def l_shaped_room(size_m, notch_m):
    """Return a room from which the corner at the greatest x and y is missing."""
    (lx, ly, lz), (nx, ny) = size_m, notch_m
    outline = [(0.0, 0.0), (lx, 0.0), (lx, ly - ny), (lx - nx, ly - ny), (lx - nx, ly), (0.0, ly)]
    return prism_room(outline, lz)
