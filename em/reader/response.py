"""The reader's response: the embedded patterns of its antennas, by which RSS follows from fields.

Three models stand behind one class. ``isolated`` takes the element patterns at their places, with
no metal around. In ``rays`` they light the ground plane and the plates by reflected and diffracted
rays, and the currents on all that metal radiate. (The full-wave model solves for the currents.)
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from octant.em.antennas import _response_kernels
from octant.em.antennas._pattern_grid import padded_table
from octant.em.antennas._response_kernels import PAD, ResponseArrays
from octant.em.antennas.kinds import Antenna, make_antenna
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.rays import MAX_REFLECTIONS, ray_patterns
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import AntennaError
from octant.geometries.reader_body import ReaderBody

ResponseModel = Literal["rays", "isolated"]
"""Models of the reader's response."""

GRID_STEP_DEG = 1.5
"""Step [deg] of the pattern tables: divides 45 degrees, and keeps cubic interpolation of a
reader of a wavelength within 1e-4 of its maximum."""

RAYS_WARNING = (
    "the reader's response is that of currents lit by rays, diffracted once at the plates' edges: "
    "coupling between antennas and what the metal does to their impedance are left out; within "
    "10 dB of an antenna's maximum expect 1 dB rms for the thesis' best dipole design and up to "
    "3 dB for others, 10 to 20 dB below it 2 to 4 dB; levels further down come out 4 to 12 dB "
    "too strong"
)
ISOLATED_WARNING = (
    "the reader's response is that of isolated antennas: plates and ground plane are left out"
)
MATCHED_WARNING = (
    "every antenna is taken as matched and the others as open, so load_ohm has no effect"
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
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
        """Number of antennas."""
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
        flat = np.empty((theta.size, 1, self.antennas, 2), dtype=np.complex128)
        _response_kernels.fill_far_fields(
            response_arrays((self,)),
            np.ascontiguousarray(theta.ravel()),
            np.ascontiguousarray(phi.ravel()),
            flat,
        )
        return np.moveaxis(flat.reshape(*theta.shape, self.antennas, 2), -2, 0)


@lru_cache(maxsize=1)  # a room's tags are linked to one reader, one after the other
def response_arrays(responses: tuple[ReaderResponse, ...]) -> ResponseArrays:
    """Return a reader's patterns at several frequencies as the kernels take them, angles in [rad].

    Parameters
    ----------
    responses : tuple of ReaderResponse
        One or more, of as many antennas on the same grid.
    """
    first = responses[0]
    n, _, rows, columns = first.pattern.shape
    shape = (rows + 2 * PAD, columns + 2 * PAD, len(responses), n, 2)
    table = np.empty(shape, dtype=np.complex128)
    for channel, response in enumerate(responses):
        table[:, :, channel] = padded_table(response.pattern)
    wavenumbers = [2.0 * math.pi * r.frequency_hz / SPEED_OF_LIGHT_M_PER_S for r in responses]
    centres = [k * r.phase_centres_m for k, r in zip(wavenumbers, responses, strict=True)]
    return ResponseArrays(
        table=table.reshape(*shape[:2], -1).view(np.float64),
        step_theta=math.pi / (rows - 1),
        step_phi=2.0 * math.pi / columns,
        centre_rad=np.array(centres),
    )


def reader_response(
    body: ReaderBody,
    antenna: Antenna,
    *,
    model: str,
    gap_m: float,
    max_reflections: int = MAX_REFLECTIONS,
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
        Height [m] of the dipole's lower end, or of the monopole's own plane, above the ground
        plane; a monopole without a plane of its own stands on the ground plane.
    max_reflections : int
        Greatest number of reflections in ``rays`` of a ray that meets no edge.

    Returns
    -------
    ReaderResponse
        Patterns on a grid of ``GRID_STEP_DEG``; its ``warnings`` say where the model fails.

    Raises
    ------
    AntennaError
        For an unknown model, a negative gap, a reader with build errors, or in ``rays`` an antenna
        that is not an upright dipole or monopole.

    Notes
    -----
    Elements count as matched and do not see each other. In ``isolated`` a monopole keeps its
    closed-form pattern over an infinite plane, nothing below it. For ``rays`` see
    :func:`octant.em.reader.rays.ray_patterns`; its gain averages 1 over the sphere, so that with
    a known input impedance Z the realised gain is 1 - |Gamma|^2 of it.
    """
    if model not in get_args(ResponseModel):
        allowed = ", ".join(get_args(ResponseModel))
        msg = f"response model {model!r} is unknown; allowed are {allowed}."
        raise AntennaError(msg)
    if not (math.isfinite(gap_m) and gap_m >= 0.0):
        msg = f"gap_m = {gap_m} m is not a gap; give 0 m or more."
        raise AntennaError(msg)
    if body.errors is not None:
        msg = (
            f'response model "{model}" was given a reader with build errors, but only "fullwave" '
            "knows them; take that, or the reader as drawn."
        )
        raise AntennaError(msg)
    rows, columns = round(180.0 / GRID_STEP_DEG) + 1, round(360.0 / GRID_STEP_DEG)
    theta = np.linspace(0.0, math.pi, rows)
    phi = np.arange(columns) * (2.0 * math.pi / columns)
    lift_m = gap_m + (0.5 * antenna.length_m if antenna.kind == "dipole" else 0.0)
    if antenna.kind == "monopole" and body.fitted_monopole_plane_m == 0.0:
        lift_m = 0.0
    centres_m = body.element_feet_m + np.array([0.0, 0.0, lift_m])
    if model == "isolated":
        element = np.moveaxis(antenna.far_field(theta[:, None], phi), -1, 0)
        pattern = np.broadcast_to(element, (body.antennas, *element.shape))
        warnings: tuple[str, ...] = (ISOLATED_WARNING, MATCHED_WARNING)
    else:
        at_reader = ray_patterns(
            body,
            antenna,
            gap_m=gap_m,
            theta_rad=theta,
            columns=columns,
            max_reflections=max_reflections,
        )
        wavenumber = 2.0 * math.pi / antenna.wavelength_m
        st, ct = np.sin(theta)[:, None], np.cos(theta)[:, None]
        unit = np.stack(np.broadcast_arrays(st * np.cos(phi), st * np.sin(phi), ct), axis=-1)
        turn = np.exp(-1j * wavenumber * np.einsum("tpc,nc->ntp", unit, centres_m))
        pattern = at_reader * turn[:, None]
        warnings = (RAYS_WARNING, MATCHED_WARNING)
    return ReaderResponse(
        model=model,
        frequency_hz=antenna.frequency_hz,
        azimuths_rad=body.element_azimuths_rad,
        phase_centres_m=centres_m,
        pattern=pattern,
        warnings=warnings,
    )


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
