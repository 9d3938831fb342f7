"""One antenna alone: a dipole in free space, a monopole on its own square plane."""

import numpy as np

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave._element_size import ElementSize
from octant.em.reader.fullwave._reader_pieces import PieceMesher, joined_pieces
from octant.em.reader.fullwave._strips import Strip, strip_cells, strip_triangles
from octant.em.reader.fullwave.conductor import Conductor
from octant.em.reader.fullwave.mesh import (
    BODY,
    CELLS_PER_WAVELENGTH,
    FEED_GAP_M,
    WIRE_RADIUS_M,
    ReaderMesh,
)
from octant.geometries._checks import positive_number


def dipole_mesh(
    *,
    frequency_hz: float,
    length_m: float | None = None,
    wire_radius_m: float = WIRE_RADIUS_M,
    feed_gap_m: float = FEED_GAP_M,
    cells_per_wavelength: float = CELLS_PER_WAVELENGTH,
    graded_tips: bool = True,
    conductor: Conductor | None = None,
) -> ReaderMesh:
    """Return the triangles [m] of one upright dipole alone, its middle at the origin.

    Parameters
    ----------
    frequency_hz : Frequency [Hz].
    length_m : Length [m]; None takes half a wavelength.
    wire_radius_m : Radius a of the wire [m]; the strip is 4 a wide.
    feed_gap_m : Length of the feed [m]; 0 is a delta gap.
    cells_per_wavelength : Elements per wavelength [-]; strips have at least 24 cells to half a
        wavelength.
    graded_tips : Cut the last cells finer, where charge gathers.
    conductor : What it is made of; None: perfect metal.

    Notes
    -----
    The dipole's impedance depends on length, radius and feed. The thesis' 76.64 + j27.79 ohm for
    "6.25 cm" is not that of 6.25 cm at 2.4 GHz, whatever the wire: thin wire of that length has
    73 + j43 ohm, thicker wire more. A strip dipole of 6.17 cm, a = 0.009 mm and a delta gap has
    it (6.16 cm and 0.014 mm with a feed of 5.7 mm): thin wire, 1.2 % shorter than half a
    wavelength.
    """
    frequency = positive_number(frequency_hz, name="frequency_hz", unit="Hz")
    wavelength_m = SPEED_OF_LIGHT_M_PER_S / frequency
    length = 0.5 * wavelength_m
    if length_m is not None:
        length = positive_number(length_m, name="length_m")
    half_width = 2.0 * positive_number(wire_radius_m, name="wire_radius_m")
    feed = positive_number(feed_gap_m, name="feed_gap_m", allow_zero=True)
    foot = np.array(((0.0, -1.0, 0.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))) * half_width
    strip = Strip(
        foot_m=foot - np.array((0.0, 0.0, 0.5 * length)),
        length_m=length,
        cells=strip_cells(length, wavelength_m, cells_per_wavelength),
        grounded=False,
        graded=graded_tips,
    )
    vertices, faces = strip_triangles(strip)
    reach = np.array(((0.0, 0.0, 0.5 * feed),))
    return ReaderMesh(
        vertices_m=vertices,
        faces=faces,
        antenna_of_face=np.zeros(len(faces), dtype=np.int64),
        feed_bottom_m=-reach,
        feed_top_m=reach,
        strip_of_feed=np.zeros(1, dtype=np.int64),
        phase_centres_m=np.zeros((1, 3)),
        coarse_m=wavelength_m / cells_per_wavelength,
        frequency_hz=frequency,
        conductor=conductor,
        wire_radius_m=0.5 * half_width,
    )


def monopole_mesh(
    *,
    frequency_hz: float,
    plane_m: float = 0.04,
    length_m: float | None = None,
    wire_radius_m: float = WIRE_RADIUS_M,
    feed_gap_m: float = FEED_GAP_M,
    cells_per_wavelength: float = CELLS_PER_WAVELENGTH,
    graded_tips: bool = True,
    conductor: Conductor | None = None,
) -> ReaderMesh:
    """Return the triangles [m] of one monopole in the middle of a square plane at z = 0.

    Parameters
    ----------
    frequency_hz : Frequency [Hz].
    plane_m : Side of the plane [m].
    length_m : Height [m]; None takes a quarter of a wavelength.
    wire_radius_m : Radius a of the wire [m]; the strip is 4 a wide.
    feed_gap_m : Length of the feed above the plane [m]; 0 is a delta gap at the foot.
    cells_per_wavelength : Elements per wavelength [-].
    graded_tips : Cut the last cell finer, where charge gathers.
    conductor : What it is made of; None: perfect metal.

    Notes
    -----
    The thesis gives 32.12 + j22.76 ohm and 1.22 dBi for 3.12 cm on 4 x 4 cm.
    """
    frequency = positive_number(frequency_hz, name="frequency_hz", unit="Hz")
    wavelength_m = SPEED_OF_LIGHT_M_PER_S / frequency
    length = 0.25 * wavelength_m
    if length_m is not None:
        length = positive_number(length_m, name="length_m")
    half_width = 2.0 * positive_number(wire_radius_m, name="wire_radius_m")
    half = 0.5 * positive_number(plane_m, name="plane_m")
    feed = positive_number(feed_gap_m, name="feed_gap_m", allow_zero=True)
    foot = np.array(((0.0, -1.0, 0.0), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))) * half_width
    strip = Strip(
        foot_m=foot,
        length_m=length,
        cells=strip_cells(length, wavelength_m, cells_per_wavelength),
        grounded=True,
        graded=graded_tips,
    )
    coarse = wavelength_m / cells_per_wavelength
    mesher = PieceMesher(
        ElementSize(
            coarse_m=coarse,
            finest_m=min(half_width, coarse),
            strips_m=strip.middle_line_m[None],
            planes_m=np.zeros((0, 3)),
        )
    )
    corners = half * np.array(
        ((-1.0, 0.0, 0.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0))
    )
    other = np.roll(corners[::-1], 3, axis=0) * np.array((1.0, -1.0, 1.0))
    pieces = [mesher.mesh(corners, foot[2:]), mesher.mesh(other, foot[:1])]
    on_plane = sum(len(faces) for _, faces in pieces)
    vertices, faces = joined_pieces([*pieces, strip_triangles(strip)])
    return ReaderMesh(
        vertices_m=vertices,
        faces=faces,
        antenna_of_face=np.where(np.arange(len(faces)) < on_plane, BODY, 0),
        feed_bottom_m=np.zeros((1, 3)),
        feed_top_m=np.array(((0.0, 0.0, feed),)),
        strip_of_feed=np.zeros(1, dtype=np.int64),
        phase_centres_m=np.zeros((1, 3)),
        coarse_m=coarse,
        frequency_hz=frequency,
        conductor=conductor,
        wire_radius_m=0.5 * half_width,
    )
