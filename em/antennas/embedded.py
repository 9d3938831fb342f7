"""Embedded patterns of a reader's antennas, by which RSS follows from fields: their record."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from octant.em.antennas import _response_kernels
from octant.em.antennas._response_kernels import PAD
from octant.em.antennas.kinds import checked_steps, linear_cells, padded_table
from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.directions import angle_grid, phase_ahead_rad
from octant.em.records import ResponseArrays
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import AntennaError

GRID_STEP_DEG = 1.5
"""Step [deg] of the tables: divides 45; cubic interpolation stays within 1e-4 of the maximum."""


GRID_SHAPE = (round(180.0 / GRID_STEP_DEG) + 1, round(360.0 / GRID_STEP_DEG))
"""Values of theta and phi in those tables."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReaderResponse:
    """Embedded patterns of a reader's antennas in the reader's own frame.

    Parameters
    ----------
    model : What made it: ``rays``, ``isolated``, or another name.
    frequency_hz : Frequency [Hz].
    azimuths_rad : (n,) float64 — Azimuth of each antenna [rad], antenna 1 at 0.
    phase_centres_m : (n, 3) float64 — Point [m] that each antenna's phase is referred to.
    pattern : (n, 2, T, P) complex128 — F_theta and F_phi [-], |F|^2 = gain, on a uniform grid: T
        values of theta from 0 to pi, P of phi from 0 to below 2 pi; P is even.
    warnings : Where the model is known not to hold.
    steps : (T - 1, P) bool or None — Cells of the grid that are interpolated along straight lines,
        since a step of a file runs through them [-].
    """

    model: str
    frequency_hz: float
    azimuths_rad: npt.NDArray[np.float64]
    phase_centres_m: npt.NDArray[np.float64]
    pattern: npt.NDArray[np.complex128]
    warnings: tuple[str, ...] = ()
    steps: npt.NDArray[np.bool_] | None = None

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
        object.__setattr__(self, "steps", checked_steps(self.steps, pattern.shape))
        object.__setattr__(self, "azimuths_rad", azimuths)
        object.__setattr__(self, "phase_centres_m", centres)

    @classmethod
    def from_centre(
        cls,
        pattern: npt.NDArray[np.complex128],
        *,
        model: str,
        frequency_hz: float,
        azimuths_rad: npt.NDArray[np.float64],
        phase_centres_m: npt.NDArray[np.float64],
        warnings: tuple[str, ...] = (),
    ) -> "ReaderResponse":
        """Return the response of patterns [-] whose phase is referred to the reader's centre.

        Parameters
        ----------
        pattern : (n, 2, T, P) complex128 — F_theta and F_phi [-] with that phase.
        model : What made it.
        frequency_hz : Frequency [Hz].
        azimuths_rad : (n,) float64 — Azimuth of each antenna [rad].
        phase_centres_m : (n, 3) float64 — Point [m] that each antenna's phase is moved to.
        warnings : Where the model is known not to hold.
        """
        ahead = phase_ahead_rad(
            *angle_grid(*pattern.shape[2:]),
            phase_centres_m,
            wavelength_m=SPEED_OF_LIGHT_M_PER_S / frequency_hz,
        )
        return cls(
            model=model,
            frequency_hz=frequency_hz,
            azimuths_rad=azimuths_rad,
            phase_centres_m=phase_centres_m,
            pattern=pattern * np.exp(-1j * ahead)[:, None],
            warnings=warnings,
        )

    @property
    def pattern_at_centre(self) -> npt.NDArray[np.complex128]:
        """Patterns (n, 2, T, P) [-] with their phase at the reader's centre."""
        ahead = phase_ahead_rad(
            self.theta_rad,
            self.phi_rad,
            self.phase_centres_m,
            wavelength_m=SPEED_OF_LIGHT_M_PER_S / self.frequency_hz,
        )
        pattern: npt.NDArray[np.complex128] = self.pattern * np.exp(1j * ahead)[:, None]
        return pattern

    @property
    def antennas(self) -> int:
        """Number of antennas."""
        return len(self.azimuths_rad)

    @property
    def theta_rad(self) -> npt.NDArray[np.float64]:
        """Values of theta [rad] of the grid, (T,)."""
        return angle_grid(*self.pattern.shape[2:])[0]

    @property
    def phi_rad(self) -> npt.NDArray[np.float64]:
        """Values of phi [rad] of the grid, (P,)."""
        return angle_grid(*self.pattern.shape[2:])[1]

    def far_field(
        self, theta_rad: npt.ArrayLike, phi_rad: npt.ArrayLike
    ) -> npt.NDArray[np.complex128]:
        """Return (n, ..., 2) F_theta, F_phi [-] of all antennas, phase at the reader's centre.

        Between the grid's points by cubic Lagrange interpolation, at steps linear.

        Parameters
        ----------
        theta_rad, phi_rad : Directions [rad] in the reader's frame, broadcast; 0 <= theta <= pi.
        """
        theta, phi = np.broadcast_arrays(
            np.asarray(theta_rad, dtype=np.float64), np.asarray(phi_rad, dtype=np.float64)
        )
        flat = np.empty((theta.size, 1, self.antennas, 2), dtype=np.complex128)
        _response_kernels.fill_far_fields(
            response_arrays((self,)),
            theta.flatten(),
            phi.flatten(),
            flat,
        )
        return np.moveaxis(flat.reshape(*theta.shape, self.antennas, 2), -2, 0)


def one_antenna_fields(
    responses: tuple[ReaderResponse, ...],
    number: int,
    theta_rad: npt.NDArray[np.float64],
    phi_rad: npt.NDArray[np.float64],
) -> npt.NDArray[np.complex128]:
    """Return (c, k, 2) F_theta, F_phi [-] of one antenna at each frequency, phase at the centre.

    As `ReaderResponse.far_field` has them, but the other antennas are not interpolated. As in links
    a cell with a step at one frequency is linear at all those on the same grid.

    Parameters
    ----------
    responses : The reader's at c frequencies.
    number : Which antenna, from 0.
    theta_rad, phi_rad : (k,) float64 — Directions [rad] in the reader's frame; 0 <= theta <= pi.
    """
    if len({one.pattern.shape for one in responses}) > 1:
        each = [one_antenna_fields((one,), number, theta_rad, phi_rad) for one in responses]
        return np.concatenate(each)
    whole = response_arrays(responses)
    rows, columns = whole.table.shape[:2]
    parts = whole.table.reshape(rows, columns, 4, len(responses), -1)[..., number]
    own = whole._replace(
        table=np.ascontiguousarray(parts).reshape(rows, columns, -1),
        centre_rad=np.ascontiguousarray(
            whole.centre_rad.reshape(3, len(responses), -1)[..., number]
        ),
    )
    fields = np.empty((len(theta_rad), len(responses), 1, 2), dtype=np.complex128)
    _response_kernels.fill_far_fields(own, theta_rad, phi_rad, fields)
    return np.moveaxis(fields[:, :, 0], 1, 0)


@lru_cache(maxsize=1)  # a room's tags are linked to one reader, one after the other
def response_arrays(responses: tuple[ReaderResponse, ...]) -> ResponseArrays:
    """Return a reader's patterns at several frequencies as the kernels take them, angles in [rad].

    Parameters
    ----------
    responses : One or more, of as many antennas on the same grid.
    """
    first = responses[0]
    n, _, rows, columns = first.pattern.shape
    shape = (rows + 2 * PAD, columns + 2 * PAD, 4, len(responses), n)
    table = np.empty(shape)
    linear = np.zeros((rows - 1, columns), dtype=np.bool_)
    for channel, response in enumerate(responses):
        padded = np.moveaxis(padded_table(response.pattern), 3, 2)
        table[:, :, ::2, channel], table[:, :, 1::2, channel] = padded.real, padded.imag
        linear |= linear_cells(response.pattern, response.steps)
    wavenumbers = [2.0 * math.pi * r.frequency_hz / SPEED_OF_LIGHT_M_PER_S for r in responses]
    centres = [k * r.phase_centres_m for k, r in zip(wavenumbers, responses, strict=True)]
    return ResponseArrays(
        table=table.reshape(*shape[:2], -1),
        linear=linear,
        step_theta=math.pi / (rows - 1),
        step_phi=2.0 * math.pi / columns,
        centre_rad=np.ascontiguousarray(np.concatenate(centres).T),
    )
