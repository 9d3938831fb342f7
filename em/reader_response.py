"""The reader's response: the embedded patterns of its antennas, by which RSS follows from fields.

Three models stand behind one class. ``isolated`` takes the element patterns at their places, with
no metal around. ``rays`` adds what geometrical optics says of the ground plane and the plates.
(The full-wave model solves for the currents.)
"""

import math
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from octant.em import _power_kernels, _response_kernels
from octant.em._pattern_grid import padded_table
from octant.em._response_kernels import ResponseArrays
from octant.em.antennas import Antenna, make_antenna
from octant.em.blocks import run_blocks
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.image_search import search_images
from octant.em.paths import edge_arrays, scene_arrays
from octant.em.radio_scene import RadioScene, radio_scene
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import AntennaError
from octant.geometries.reader_body import ReaderBody
from octant.geometries.scene import build_scene

ResponseModel = Literal["rays", "isolated"]
"""Models of the reader's response."""

FAR_FIELD_DISTANCE_M = 1e5
"""Distance [m] at which ``rays`` reads the far field: amplitude off by 1e-6, phase by 1e-5 rad."""

GRID_STEP_DEG = 1.5
"""Step [deg] of the pattern tables: divides 45 degrees, and keeps cubic interpolation of a
reader of a wavelength within 1e-4 of its maximum."""

RAYS_WARNING = (
    "the reader's response is geometrical optics (rays) on a body of about one wavelength: "
    "diffraction at the plates' edges, mutual coupling and mismatch are left out, levels can be "
    "wrong by several dB and the strongest antenna by one place or more"
)
ISOLATED_WARNING = (
    "the reader's response is that of isolated antennas: plates and ground plane are left out"
)
MATCHED_WARNING = "every antenna is taken as matched, so load_ohm has no effect"


@dataclass(frozen=True, slots=True, kw_only=True)
class ReaderResponse:
    """Embedded patterns of a reader's antennas in the reader's own frame.

    Parameters
    ----------
    model : str
        What made it: ``rays``, ``isolated``, or another name.
    frequency_hz : float
        Frequency [Hz].
    azimuths_rad : (n,) float64
        Azimuth of each antenna [rad], antenna 1 at 0.
    phase_centres_m : (n, 3) float64
        Point [m] that each antenna's table refers its phase to, which keeps the table smooth.
    pattern : (n, 2, T, P) complex128
        F_theta and F_phi [-] on the grid, phase at the antenna's own phase centre; |F|^2 is the
        gain. theta runs over T values from 0 to pi, phi over P values from 0 up to, not including,
        2 pi, both uniform; P is even.
    warnings : tuple of str
        Where the model is known not to hold.
    """

    model: str
    frequency_hz: float
    azimuths_rad: npt.NDArray[np.float64]
    phase_centres_m: npt.NDArray[np.float64]
    pattern: npt.NDArray[np.complex128]
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        pattern = frozen_array(
            self.pattern,
            name="pattern",
            shape=(None, 2, None, None),
            dtype=np.complex128,
            error=AntennaError,
        )
        n, _, rows, columns = pattern.shape
        if n < 1 or rows < 4 or columns < 4 or columns % 2:
            msg = (
                f"pattern has shape {pattern.shape}, but at least one antenna, four values of "
                "theta and an even number of at least four values of phi are needed."
            )
            raise AntennaError(msg)
        azimuths = frozen_array(
            self.azimuths_rad, name="azimuths_rad", shape=(n,), error=AntennaError
        )
        centres = frozen_array(
            self.phase_centres_m, name="phase_centres_m", shape=(n, 3), error=AntennaError
        )
        object.__setattr__(self, "pattern", pattern)
        object.__setattr__(self, "azimuths_rad", azimuths)
        object.__setattr__(self, "phase_centres_m", centres)

    @property
    def antennas(self) -> int:
        """Number of antennas [-]."""
        return len(self.azimuths_rad)

    @property
    def theta_rad(self) -> npt.NDArray[np.float64]:
        """Values of theta [rad] of the grid, (T,)."""
        return np.linspace(0.0, math.pi, self.pattern.shape[2])

    @property
    def phi_rad(self) -> npt.NDArray[np.float64]:
        """Values of phi [rad] of the grid, (P,)."""
        columns = self.pattern.shape[3]
        phi: npt.NDArray[np.float64] = np.arange(columns) * (2.0 * math.pi / columns)
        return phi

    def kernel_arrays(self) -> ResponseArrays:
        """Return the padded table as the kernels take it, steps in radians [rad]."""
        wavenumber = 2.0 * math.pi * self.frequency_hz / SPEED_OF_LIGHT_M_PER_S
        return ResponseArrays(
            table=padded_table(self.pattern),
            step_theta=math.pi / (self.pattern.shape[2] - 1),
            step_phi=2.0 * math.pi / self.pattern.shape[3],
            centre_rad=np.ascontiguousarray(wavenumber * self.phase_centres_m),
        )

    def far_field(
        self, theta_rad: npt.ArrayLike, phi_rad: npt.ArrayLike
    ) -> npt.NDArray[np.complex128]:
        """Return the far fields of all antennas towards directions of the reader's frame.

        Parameters
        ----------
        theta_rad, phi_rad : array_like
            Directions [rad], broadcast against each other; 0 <= theta <= pi.

        Returns
        -------
        (n, ..., 2) complex128
            F_theta and F_phi [-], |F|^2 = gain, phase referred to the reader's centre. Between the
            grid's points by cubic Lagrange interpolation.
        """
        theta, phi = np.broadcast_arrays(
            np.asarray(theta_rad, dtype=np.float64), np.asarray(phi_rad, dtype=np.float64)
        )
        flat = np.empty((theta.size, self.antennas, 2), dtype=np.complex128)
        _response_kernels.fill_far_fields(
            self.kernel_arrays(),
            np.ascontiguousarray(theta.ravel()),
            np.ascontiguousarray(phi.ravel()),
            flat,
        )
        return np.moveaxis(flat.reshape(*theta.shape, self.antennas, 2), -2, 0)


def reader_response(
    body: ReaderBody,
    antenna: Antenna,
    *,
    model: str,
    gap_m: float,
    max_reflections: int = 5,
) -> ReaderResponse:
    """Return the embedded patterns of a reader by one of the approximate models.

    Parameters
    ----------
    body : ReaderBody
        Ground plane, plates and the places of the antennas.
    antenna : Antenna
        One element, upright.
    model : str
        ``isolated`` or ``rays``.
    gap_m : float
        Height [m] of the dipole's lower end, or of the monopole's foot, above the ground plane.
    max_reflections : int
        Greatest order [-] in ``rays``; five covers a 45 degree wedge over a ground plane.

    Returns
    -------
    ReaderResponse
        Patterns on a grid of ``GRID_STEP_DEG``; its ``warnings`` say where the model fails.

    Raises
    ------
    AntennaError
        For an unknown model or a negative gap.

    Notes
    -----
    Elements count as matched and do not see each other. A monopole keeps its closed-form pattern
    over an infinite plane, nothing below it. In ``rays``, reflections at plates nearer than a
    wavelength are beyond the far field; edges do not diffract.
    """
    if model not in get_args(ResponseModel):
        allowed = ", ".join(get_args(ResponseModel))
        msg = f"response model {model!r} is unknown; allowed are {allowed}."
        raise AntennaError(msg)
    if not (math.isfinite(gap_m) and gap_m >= 0.0):
        msg = f"gap_m = {gap_m} m is not a gap; give 0 m or more."
        raise AntennaError(msg)
    rows, columns = round(180.0 / GRID_STEP_DEG) + 1, round(360.0 / GRID_STEP_DEG)
    theta = np.linspace(0.0, math.pi, rows)[:, None]
    phi = (np.arange(columns) * (2.0 * math.pi / columns))[None, :]
    lift_m = gap_m + (0.5 * antenna.length_m if antenna.kind == "dipole" else 0.0)
    centres_m = body.element_feet_m + np.array([0.0, 0.0, lift_m])
    if model == "isolated":
        element = np.moveaxis(antenna.far_field(theta, phi), -1, 0)
        pattern = np.broadcast_to(element, (body.antennas, *element.shape))
        warnings: tuple[str, ...] = (ISOLATED_WARNING, MATCHED_WARNING)
    else:
        radio = radio_scene(build_scene((), objects=(body.body,)), antenna.frequency_hz)
        grid = (theta, phi)
        pattern = np.stack(
            [_ray_pattern(radio, antenna, place, grid, max_reflections) for place in centres_m]
        )
        warnings = (RAYS_WARNING, MATCHED_WARNING)
    return ReaderResponse(
        model=model,
        frequency_hz=antenna.frequency_hz,
        azimuths_rad=body.element_azimuths_rad,
        phase_centres_m=centres_m,
        pattern=pattern,
        warnings=warnings,
    )


def _ray_pattern(
    radio: RadioScene,
    antenna: Antenna,
    place_m: npt.NDArray[np.float64],
    grid: tuple[npt.NDArray[Any], npt.NDArray[Any]],
    max_reflections: int,
) -> npt.NDArray[np.complex128]:
    """Return (2, T, P) the far field of one antenna among the reader's facets, phase at its place.

    By reciprocity the receiving pattern is the transmitting one: the field at a great distance,
    with the spherical wave taken out.
    """
    theta, phi = np.broadcast_arrays(*grid)
    st, ct, sp, cp = np.sin(theta), np.cos(theta), np.sin(phi), np.cos(phi)
    direction = np.stack((st * cp, st * sp, ct), axis=-1).reshape(-1, 3)
    places = np.ascontiguousarray(place_m + FAR_FIELD_DISTANCE_M * direction)
    tree = search_images(radio.scene, place_m, max_reflections)
    field = np.zeros(places.shape, dtype=np.complex128)
    scene, images, element = scene_arrays(radio), tree.kernel_arrays(), antenna.kernel_arrays()
    ways = edge_arrays(radio, tree, None)

    def work(begin: int, end: int) -> None:
        _power_kernels.sum_fields(scene, images, ways, element, places, begin, end, field)

    run_blocks(work, len(places))
    wavelength_m = antenna.wavelength_m
    turn = 2.0 * math.pi * math.fmod(FAR_FIELD_DISTANCE_M / wavelength_m, 1.0)
    scale = (
        4.0
        * math.pi
        * FAR_FIELD_DISTANCE_M
        / wavelength_m
        * complex(math.cos(turn), math.sin(turn))
    )
    field = (scale * field).reshape(*theta.shape, 3)
    theta_hat = np.stack((ct * cp, ct * sp, -st), axis=-1)
    phi_hat = np.stack((-sp, cp, np.zeros_like(sp)), axis=-1)
    return np.stack((np.sum(field * theta_hat, axis=-1), np.sum(field * phi_hat, axis=-1)))


def sector_response(
    azimuths_rad: npt.ArrayLike,
    *,
    frequency_hz: float,
    antenna_radius_m: float = 0.10,
    exponent: float = 4.0,
) -> ReaderResponse:
    """Return an idealised sector reader: isolated half-wave dipoles behind cosine sector windows.

    Each dipole's amplitude is multiplied by cos^exponent of half the angle between the direction's
    azimuth and the antenna's own. No metal makes exactly this; it serves to test what comes after
    the radio model, and to see the best that a bearing-sensitive reader could do.

    Parameters
    ----------
    azimuths_rad : (n,) float
        Azimuth of each antenna [rad].
    frequency_hz : float
        Frequency [Hz].
    antenna_radius_m : float
        Distance of the antennas from the axis [m].
    exponent : float
        Exponent of the window [-]; 4 gives a half-power width of 94 degrees.

    Returns
    -------
    ReaderResponse
        Response of model ``sector``.
    """
    azimuths = np.asarray(azimuths_rad, dtype=np.float64)
    rows, columns = round(180.0 / GRID_STEP_DEG) + 1, round(360.0 / GRID_STEP_DEG)
    theta = np.linspace(0.0, math.pi, rows)[:, None]
    phi = (np.arange(columns) * (2.0 * math.pi / columns))[None, :]
    element = np.moveaxis(make_antenna("dipole", frequency_hz).far_field(theta, phi), -1, 0)
    window = np.abs(np.cos(0.5 * (phi - azimuths[:, None, None]))) ** exponent
    flat = np.zeros(len(azimuths))
    return ReaderResponse(
        model="sector",
        frequency_hz=frequency_hz,
        azimuths_rad=azimuths,
        phase_centres_m=antenna_radius_m
        * np.column_stack((np.cos(azimuths), np.sin(azimuths), flat)),
        pattern=element[None] * window[:, None],
        warnings=("the reader's response is an idealised sector pattern, for tests",),
    )
