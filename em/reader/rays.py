"""The reader's patterns from the currents that rays induce on its metal.

Rays from the antenna's wire, reflected and diffracted by plates and ground plane, give the magnetic
field H on both sides of every sheet, and so its current J = n x (H+ - H-). Wire and sheets then
radiate. Each field is needed only on the metal, and the patterns are smooth in every direction,
also where rays end at a corner of the body.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna, make_antenna
from octant.em.blocks import run_blocks
from octant.em.medium.radio_scene import RadioScene, radio_scene
from octant.em.paths.tracing import path_arrays
from octant.em.reader import _ray_kernels
from octant.em.reader.fullwave._symmetry import turned_vertices
from octant.em.reader.fullwave.far_field import CurrentSamples, band_limited
from octant.em.search.candidates import Candidates
from octant.em.search.edges import search_edges
from octant.em.search.images import search_images
from octant.geometries.bodies import Body
from octant.geometries.errors import AntennaError
from octant.geometries.reader_body import ReaderBody
from octant.geometries.scene import build_scene
from octant.geometries.wedges import find_wedges

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]

MAX_REFLECTIONS = 5
"""Reflections of a ray that meets no edge [-]: all that a 45 degree wedge over a plane gives."""

MAX_BENDS = 2
"""Bends of a ray over an edge [-]: its diffraction, and a reflection before or after it."""

WIRE_ELEMENTS = 4
"""Short elements that an antenna's current is cut into [-]; with eight no gain within 20 dB of
the greatest moves by 0.1 dB."""

PANELS_PER_WAVELENGTH = 8.0
"""Least number of panels per wavelength [-] on the metal far from the wire."""

NEAREST_PANEL_WAVELENGTHS = 1.0 / 24.0
"""Panels [wavelengths] at the wire's foot; further away they grow with the distance."""

CLEARANCE_WAVELENGTHS = 1e-5
"""Distance [wavelengths] from a sheet at which the field on its side is read."""

SHORT_WAVELENGTHS = 1e-3
"""Length [wavelengths] of a dipole with the pattern of an elementary one: sin(theta) to 1e-6."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Panels:
    """Small flat panels of metal sheets, as places where currents are known.

    Parameters
    ----------
    centre_m, normal : (p, 3) float64 — Centres [m] and unit normals [-].
    area_m2 : (p,) float64 — Areas [m^2].
    """

    centre_m: FloatArray
    normal: FloatArray
    area_m2: FloatArray


def ray_patterns(
    body: ReaderBody,
    antenna: Antenna,
    *,
    gap_m: float,
    theta_rad: FloatArray,
    columns: int,
    max_reflections: int = MAX_REFLECTIONS,
) -> ComplexArray:
    """Return (n, 2, T, P) patterns of a reader's antennas from the currents that rays induce [-].

    F_theta and F_phi have their phase at the reader's centre; |F|^2 is the gain of a matched
    antenna without losses, its mean over the sphere 1.

    Parameters
    ----------
    body, antenna : Metal and places of the antennas; one element, an upright dipole or monopole.
    gap_m : Height of the dipole's lower end, or monopole's own plane, above the ground plane [m].
    theta_rad, columns : (T,) float — Even steps of theta [rad], 0 to pi; number of those of phi.
    max_reflections : Greatest number of reflections of a ray that meets no edge.

    Notes
    -----
    The wire's current is sinusoidal, cut into elementary dipoles at the nodes of a Gauss-Legendre
    rule. The magnetic field of such a dipole at distance L is that of its ray times 1 + 1 / (jkL),
    exactly; the same holds for its images in planes, and is taken for rays over edges, so that
    the field stays continuous at shadow boundaries. A monopole stands on the ground plane or on its
    own plane, of which the mesh of this antenna alone has a copy.

    Left out: what the plates do to the wire's current and to its impedance, the other antennas'
    wires, rays diffracted twice, and the corners of plates as sources of their own. Antennas that
    the body's symmetry maps onto one another are computed once.

    References
    ----------
    .. [1] C. A. Balanis, Advanced Engineering Electromagnetics (1989), section 7.10 (induced
       currents), equations 6-106 to 6-108 (radiation); Antenna Theory, 3rd ed. (2005), equations
       4-8c and 4-56.
    """
    if antenna.kind not in {"dipole", "monopole"} or abs(antenna.axis[2]) < 1.0 - 1e-12:
        msg = (
            f"antenna {antenna.kind!r} of axis {antenna.axis.tolist()} has no place on a reader; "
            "give an upright dipole or monopole, or response model isolated."
        )
        raise AntennaError(msg)
    n = body.antennas
    step = _antennas_apart(body, columns)
    pattern = np.empty((n, 2, len(theta_rad), columns), dtype=np.complex128)
    for k in range(step):
        currents = antenna_currents(body, antenna, k, gap_m=gap_m, max_reflections=max_reflections)
        field = np.moveaxis(band_limited(currents).on_grid(theta_rad, columns)[0], -1, 0)
        field /= math.sqrt(_mean_over_sphere(np.sum(np.abs(field) ** 2, axis=0), theta_rad))
        for other in range(k, n, step):
            pattern[other] = np.roll(field, (other - k) * columns // n, axis=-1)
    return pattern


def antenna_currents(
    body: ReaderBody,
    antenna: Antenna,
    number: int,
    *,
    gap_m: float,
    max_reflections: int = MAX_REFLECTIONS,
) -> CurrentSamples:
    """Return currents of an antenna's wire, at most 1 A, and of the metal that it lights [A m].

    Parameters
    ----------
    body, antenna, gap_m, max_reflections : As in `ray_patterns` [m].
    number : Which antenna, from 0.
    """
    wavelength_m = antenna.wavelength_m
    own_plane_m = body.fitted_monopole_plane_m if antenna.kind == "monopole" else 0.0
    bodies = [body.body]
    if own_plane_m:
        bodies.append(_own_plane(body, number, own_plane_m, gap_m))
    scene = build_scene((), objects=bodies)
    wedges = find_wedges(scene)
    # The currents' own fields are smooth past the ends of edges, as docs/evidence/rays.md says.
    endless = replace(wedges, tips=np.zeros_like(wedges.tips))
    radio = radio_scene(scene, antenna.frequency_hz, wedges=endless)
    lift_m = 0.0 if antenna.kind == "monopole" and own_plane_m == 0.0 else gap_m
    foot_m = body.element_feet_m[number] + np.array((0.0, 0.0, lift_m))
    wire_m = np.stack((foot_m, foot_m + np.array((0.0, 0.0, antenna.length_m))))
    panels = cut_into_panels(
        scene.triangle_corners_m,
        wire_m,
        coarse_m=wavelength_m / PANELS_PER_WAVELENGTH,
        fine_m=NEAREST_PANEL_WAVELENGTHS * wavelength_m,
    )
    places_m, moments_a_m = _wire_elements(antenna, foot_m)
    jump = np.zeros(panels.centre_m.shape, dtype=np.complex128)
    for place_m, moment_a_m in zip(places_m, moments_a_m, strict=True):
        jump += moment_a_m * _field_jump(radio, place_m, panels, max_reflections)
    sheet = panels.area_m2[:, None] * np.cross(panels.normal, jump)
    wire = moments_a_m[:, None] * np.array((0.0, 0.0, 1.0))
    return CurrentSamples(
        points_m=np.concatenate((panels.centre_m, places_m)),
        moments_a_m=np.concatenate((sheet, wire))[None],
        frequency_hz=antenna.frequency_hz,
    )


def _wire_elements(antenna: Antenna, foot_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (q, 3) places [m] and (q,) moments [A m] of a sinusoidal current of at most 1 A."""
    wavenumber = 2.0 * math.pi / antenna.wavelength_m
    length_m = antenna.length_m
    nodes, weights = np.polynomial.legendre.leggauss(WIRE_ELEMENTS)
    height_m = 0.5 * length_m * (1.0 + nodes)
    to_tip_m = length_m - height_m
    if antenna.kind == "dipole":
        to_tip_m = np.minimum(to_tip_m, height_m)
    moments = 0.5 * length_m * weights * np.sin(wavenumber * to_tip_m)
    return foot_m + height_m[:, None] * np.array((0.0, 0.0, 1.0)), moments


def _field_jump(
    radio: RadioScene, place_m: FloatArray, panels: Panels, max_reflections: int
) -> ComplexArray:
    """Return (p, 3) H+ - H- [1/m^2] per moment of an upright elementary dipole."""
    wavelength_m = radio.wavelength_m
    dipole = make_antenna("dipole", radio.frequency_hz, length_m=SHORT_WAVELENGTHS * wavelength_m)
    off = CLEARANCE_WAVELENGTHS * wavelength_m * panels.normal
    places = np.concatenate((panels.centre_m + off, panels.centre_m - off))
    # Images come order by order, so those of the shorter search are the first of the longer.
    tree = search_images(radio.scene, place_m, max(max_reflections, MAX_BENDS))
    near = search_images(radio.scene, place_m, MAX_BENDS)
    edges = search_edges(radio.scene, radio.wedges, near)
    arrays = path_arrays(radio, Candidates(images=tree, edges=edges))
    element = dipole.kernel_arrays()
    total = np.zeros(places.shape, dtype=np.complex128)

    def work(begin: int, end: int) -> None:
        _ray_kernels.sum_magnetic_fields(*arrays, element, places, begin, end, total)

    run_blocks(work, len(places))
    # The kernel's field is F lambda / (4 pi L); H is j k / (4 pi L) of a moment across the ray.
    unit = float(dipole.far_field(0.5 * math.pi, 0.0)[0].real)
    sides = np.split(total, 2)
    jump: ComplexArray = 2j * math.pi / (wavelength_m**2 * unit) * (sides[0] - sides[1])
    return jump


def cut_into_panels(
    triangles_m: FloatArray, wire_m: FloatArray, *, coarse_m: float, fine_m: float
) -> Panels:
    """Return panels of triangles [m], small near a wire.

    Parameters
    ----------
    triangles_m : (t, 3, 3) float64 — Corners [m].
    wire_m : (2, 3) float64 — Foot and tip of the upright wire [m].
    coarse_m, fine_m : Bounds of a panel's longest side, at most its distance from the wire [m].
    """
    kept = []
    rest = triangles_m
    while len(rest):
        sides = np.linalg.norm(np.roll(rest, -1, axis=1) - rest, axis=2)
        centre = rest.mean(axis=1)
        height = np.clip(centre[:, 2], wire_m[0, 2], wire_m[1, 2])
        offset = centre - np.column_stack((np.tile(wire_m[0, :2], (len(rest), 1)), height))
        limit = np.clip(np.linalg.norm(offset, axis=1), fine_m, coarse_m)
        small = sides.max(axis=1) <= limit
        kept.append(rest[small])
        rest = _halved(rest[~small], np.argmax(sides[~small], axis=1))
    corners = np.concatenate(kept)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    twice = np.linalg.norm(across, axis=1)
    return Panels(
        centre_m=corners.mean(axis=1), normal=across / twice[:, None], area_m2=0.5 * twice
    )


def _halved(triangles_m: FloatArray, side: np.ndarray) -> FloatArray:
    """Return each triangle's two halves, its given side cut in the middle."""
    row = np.arange(len(triangles_m))
    start, end = triangles_m[row, side], triangles_m[row, (side + 1) % 3]
    top, middle = triangles_m[row, (side + 2) % 3], 0.5 * (start + end)
    return np.concatenate(
        (np.stack((start, middle, top), axis=1), np.stack((middle, end, top), axis=1))
    )


def _own_plane(body: ReaderBody, number: int, side_m: float, gap_m: float) -> Body:
    """Return a monopole's own square plane, two sides along the radius."""
    azimuth = float(body.element_azimuths_rad[number])
    radial = np.array((math.cos(azimuth), math.sin(azimuth), 0.0))
    across = np.array((-math.sin(azimuth), math.cos(azimuth), 0.0))
    centre = body.element_feet_m[number] + np.array((0.0, 0.0, gap_m))
    half = 0.5 * side_m
    return Body(
        name="monopole plane",
        vertices_m=np.array(
            [centre + half * (i * radial + j * across) for i, j in _SQUARE], dtype=np.float64
        ),
        faces=np.array(((0, 1, 2), (0, 2, 3))),
        material=body.body.material,
    )


_SQUARE = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def _antennas_apart(body: ReaderBody, columns: int) -> int:
    """Return how many antennas apart the body repeats itself, on a table of so many columns."""
    n = body.antennas
    for step in range(1, n):
        repeats = n % step == 0 and (step * columns) % n == 0
        if repeats and turned_vertices(body.body.vertices_m, n // step) is not None:
            return step
    return n


def _mean_over_sphere(power: FloatArray, theta_rad: FloatArray) -> float:
    """Return the mean of a power pattern (T, P) by the trapezoidal rule [-]."""
    ring = power.mean(axis=1) * np.sin(theta_rad)
    return float(0.5 * np.trapezoid(ring, theta_rad))
