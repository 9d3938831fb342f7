"""What a full-wave solution holds: matrices, embedded patterns, currents, powers."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from octant.em.blocks import one_blas_thread
from octant.em.reader.fullwave.basis import SurfaceBasis
from octant.em.reader.fullwave.far_field import CurrentSamples
from octant.em.reader.fullwave.loads import BELOW_RAD, LoadedReader
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import AntennaError


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorEstimate:
    """How far a solution is from that on a finer mesh.

    Parameters
    ----------
    finer_cells_per_wavelength : Density of the finer mesh [-].
    strong_db : Greatest rms difference of any antenna's gain where it is within 10 dB of its
        maximum [dB].
    weak_db : The same from 10 to 20 dB below the maximum [dB].
    impedance : Greatest relative difference of the input impedances [-].
    """

    finer_cells_per_wavelength: float
    strong_db: float
    weak_db: float
    impedance: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FullwaveResult(LoadedReader):
    """A loaded reader with the currents that its patterns come from.

    Parameters
    ----------
    unloaded, load_ohm, feeds : As in `LoadedReader` [ohm].
    samples : Currents of one volt at each port in turn, the others shorted [A m per V].
    halves_a_per_m : (n, f, 3) complex128 — The same currents as factors of the half-functions [A/m
        per V].
    basis : Functions and triangles.
    sheet_ohm : (f,) complex128 — Surface impedance of the basis' triangles [ohm].
    port_step : Ports by which a turn by one sector moves on; 0 when it does not map ports to ports.
    seconds : Wall-clock time of each step [s].
    error : What a finer mesh changes, where it was tried.
    """

    samples: CurrentSamples
    halves_a_per_m: npt.NDArray[np.complex128]
    basis: SurfaceBasis
    sheet_ohm: npt.NDArray[np.complex128]
    port_step: int = 0
    seconds: Mapping[str, float] = field(default_factory=dict)
    error: ErrorEstimate | None = None

    def __post_init__(self) -> None:
        LoadedReader.__post_init__(self)
        for name, shape in (
            ("halves_a_per_m", (self.ports, None, 3)),
            ("sheet_ohm", (len(self.basis.faces),)),
        ):
            value = frozen_array(
                getattr(self, name), name=name, shape=shape, dtype=np.complex128, error=AntennaError
            )
            object.__setattr__(self, name, value)
        object.__setattr__(self, "seconds", MappingProxyType(dict(self.seconds)))

    @one_blas_thread()
    def far_field(
        self, theta_rad: npt.ArrayLike, phi_rad: npt.ArrayLike
    ) -> npt.NDArray[np.complex128]:
        """Return the patterns of `pattern_grid` towards any directions, from the currents [-].

        Parameters
        ----------
        theta_rad, phi_rad : array_like — Directions [rad], broadcast against each other.

        Returns
        -------
        (n, ..., 2) complex128
            F_theta and F_phi [-].
        """
        shorted = self.samples.far_field(theta_rad, phi_rad)
        patterns: npt.NDArray[np.complex128] = np.tensordot(
            self.realised_weights, shorted, axes=(1, 0)
        )
        if self.unloaded.half_space:
            patterns[:, np.broadcast_to(theta_rad, patterns.shape[1:-1]) > BELOW_RAD] = 0.0
        return patterns

    @one_blas_thread()
    def surface_currents(self, port: int) -> npt.NDArray[np.complex128]:
        """Return the surface currents at the centroids with one port driven [A/m].

        Parameters
        ----------
        port : Driven port, from 0; its source has 1 W available, the others are loaded.

        Returns
        -------
        (f, 3) complex128
            Sum of the currents on both sides of every triangle of ``basis`` [A/m], peak values.
        """
        source_v = math.sqrt(8.0 * float(self.load_ohm[port].real))
        halves = source_v * np.tensordot(
            self.embedded_voltages_v[port], self.halves_a_per_m, axes=(0, 0)
        )
        corners = self.basis.corners_m
        outward = corners.mean(axis=1, keepdims=True) - corners
        scale = halves * self.basis.edge_lengths_m / (2.0 * self.basis.areas_m2[:, None])
        currents: npt.NDArray[np.complex128] = np.einsum("fi,fic->fc", scale, outward)
        return currents
