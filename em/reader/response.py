"""The reader's response: the embedded patterns of its antennas, by which RSS follows from fields.

Three models stand behind one class. ``isolated`` takes the element patterns at their places, with
no metal around. In ``rays`` they light the ground plane and the plates by reflected and diffracted
rays, and the currents on all that metal radiate. (The full-wave model solves for the currents.)
"""

import math
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import GRID_SHAPE, ReaderResponse
from octant.em.antennas.kinds import Antenna, make_antenna
from octant.em.directions import angle_grid
from octant.em.reader.rays import MAX_REFLECTIONS, ray_patterns
from octant.geometries.errors import AntennaError
from octant.geometries.reader_body import ReaderBody

ResponseModel = Literal["rays", "isolated"]

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


def reader_response(
    body: ReaderBody,
    antenna: Antenna,
    *,
    model: str,
    gap_m: float,
    max_reflections: int = MAX_REFLECTIONS,
) -> ReaderResponse:
    """Return the embedded patterns of a reader by an approximate model, on the grid `GRID_SHAPE`.

    Parameters
    ----------
    body, antenna : Metal and places of the antennas; one element, upright.
    model : ``isolated`` or ``rays``; the response's ``warnings`` say where each fails.
    gap_m : Height of the dipole's lower end, or monopole's own plane, above the ground plane [m]; a
        monopole without a plane of its own stands on the ground plane.
    max_reflections : Greatest number of reflections in ``rays`` of a ray that meets no edge.

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
    theta, phi = angle_grid(*GRID_SHAPE)
    lift_m = gap_m + (0.5 * antenna.length_m if antenna.kind == "dipole" else 0.0)
    if antenna.kind == "monopole" and body.fitted_monopole_plane_m == 0.0:
        lift_m = 0.0
    centres_m = body.element_feet_m + np.array([0.0, 0.0, lift_m])
    common: dict[str, Any] = {
        "model": model,
        "frequency_hz": antenna.frequency_hz,
        "azimuths_rad": body.element_azimuths_rad,
        "phase_centres_m": centres_m,
    }
    if model == "isolated":
        element = np.moveaxis(antenna.far_field(theta[:, None], phi), -1, 0)
        pattern = np.broadcast_to(element, (body.antennas, *element.shape))
        warnings = (ISOLATED_WARNING, MATCHED_WARNING)
        return ReaderResponse(pattern=pattern, warnings=warnings, **common)
    pattern = ray_patterns(
        body,
        antenna,
        gap_m=gap_m,
        theta_rad=theta,
        columns=len(phi),
        max_reflections=max_reflections,
    )
    return ReaderResponse.from_centre(pattern, warnings=(RAYS_WARNING, MATCHED_WARNING), **common)


def sector_response(
    azimuths_rad: npt.ArrayLike,
    *,
    frequency_hz: float,
    antenna_radius_m: float = 0.10,
    exponent: float = 4.0,
) -> ReaderResponse:
    """Return an idealised sector reader: isolated half-wave dipoles behind cosine sector windows.

    Each dipole's amplitude is multiplied by cos^exponent of half the angle between the direction's
    azimuth and its own. No metal makes this; it serves to test what comes after the radio model,
    and to see the best that a bearing-sensitive reader could do.

    Parameters
    ----------
    azimuths_rad, antenna_radius_m : (n,), () float — Azimuths [rad] and radius [m] of the antennas.
    frequency_hz : Frequency [Hz].
    exponent : Exponent of the window [-]; 4 gives a half-power width of 94 degrees.
    """
    azimuths = np.asarray(azimuths_rad, dtype=np.float64)
    theta, phi = angle_grid(*GRID_SHAPE)
    dipole = make_antenna("dipole", frequency_hz)
    element = np.moveaxis(dipole.far_field(theta[:, None], phi), -1, 0)
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
