"""How far antennas stand from plates and neighbours; what touches is refused."""

import math
from collections.abc import Sequence

import numpy as np

from octant.geometries._plane_geometry import FloatArray
from octant.geometries.errors import GeometryError
from octant.geometries.reader_body import ReaderBody
from octant.geometries.tolerances import LENGTHS

CLOSE_M = 0.011
"""Distance [m] between a strip and a plate below which the result depends on the refinement."""


def clearance_m(
    body: ReaderBody, outlines_m: Sequence[FloatArray], lines_m: FloatArray, *, width_m: float
) -> float:
    """Return the least distance of an antenna from plates and neighbours [m], seen from above.

    ``outlines_m`` holds the corners (k, 2) of each antenna's strip, ``lines_m`` (n, 2, 3) the ends
    of its middle line.
    """
    built = body.built
    least = math.inf
    for i, outline in enumerate(outlines_m):
        plates = zip(built.plate_azimuths_rad, built.plate_reaches_m, strict=True)
        for azimuth, reach in plates:
            beside = _from_plate_m(outline, float(azimuth), float(reach))
            _refuse_contact(body, i, beside, f"the plate at {math.degrees(azimuth):g} deg")
            least = min(least, beside)
        for k, other in enumerate(outlines_m[:i]):
            apart = outline[:, None] - other[None, :]
            beside = float(np.linalg.norm(apart, axis=2).min())
            middles = np.linalg.norm(lines_m[i, :, :2] - lines_m[k, :, :2], axis=1).min()
            _refuse_contact(body, i, 0.0 if middles <= width_m else beside, f"antenna {k + 1}")
            least = min(least, beside)
    return least


def refuse_crossed_planes(body: ReaderBody, planes_m: Sequence[FloatArray]) -> None:
    """Raise when a monopole's own plane, corners (k, 2), crosses a plate or the neighbour's half.

    Without plates the half-planes half-way between neighbours stand for them.
    """
    azimuths, reaches = body.built.plate_azimuths_rad, body.built.plate_reaches_m
    if not len(azimuths):
        azimuths = body.element_azimuths_rad + math.pi / body.antennas
        reaches = np.full(body.antennas, math.inf)
    for i, plane in enumerate(planes_m):
        for azimuth, reach in zip(azimuths, reaches, strict=True):
            beside = _from_plate_m(plane, float(azimuth), float(reach))
            _refuse_contact(body, i, beside, f"by its own plane the plate at {azimuth:.3g} rad")


def _from_plate_m(points_m: FloatArray, azimuth_rad: float, reach_m: float) -> float:
    """Return the distance of points (k, 2) from a plate [m], 0 when they lie on both its sides."""
    out = np.array((math.cos(azimuth_rad), math.sin(azimuth_rad)))
    along = np.clip(points_m @ out, 0.0, reach_m)
    side = points_m @ np.array((-out[1], out[0]))
    beside = float(np.linalg.norm(points_m - along[:, None] * out, axis=1).min())
    crosses = side.min() < 0.0 < side.max() and bool((along > 0.0).all())
    return 0.0 if crosses and float((points_m @ out).min()) <= reach_m else beside


def _refuse_contact(body: ReaderBody, antenna: int, beside_m: float, what: str) -> None:
    """Raise when an antenna touches something."""
    if beside_m <= LENGTHS.joined_m:
        msg = (
            f"antenna {antenna + 1} touches {what} at antenna_radius_m = "
            f"{body.antenna_radius_m:g} m; move the antennas out, or give thinner wire."
        )
        raise GeometryError(msg)


def close_doubts(clearance_m: float) -> tuple[str, ...]:
    """Return what makes the result doubtful when antennas stand as close as this [m]."""
    if clearance_m >= CLOSE_M:
        return ()
    doubt = (
        f"the antennas are {1e3 * clearance_m:.2g} mm from the nearest sheet or neighbour, nearer "
        f"than {1e3 * CLOSE_M:.2g} mm: patterns may be off by several tenths of a decibel, and "
        "deep between plates they mean little"
    )
    return (doubt,)
