"""Ports and patterns at many frequencies of a band, without the currents in between.

Far fields of currents take the most time of a band. With loads they change smoothly over it, so
that a polynomial through some of them gives the others; that is compared once.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
import numpy.typing as npt

from octant.em.blocks import one_blas_thread
from octant.em.reader.fullwave._circuit import embedded_voltages
from octant.em.reader.fullwave.band import (
    FullwaveBand,
    chebyshev_places_hz,
    polynomial_shares,
)
from octant.em.reader.fullwave.far_field import FarField
from octant.em.reader.fullwave.loads import LoadedReader, UnloadedReader

FAR_NODES = 7
"""Far fields over a band that the others are interpolated between [-]."""
FAR_TOLERANCE = 1e-6
"""Greatest difference of interpolated patterns that is allowed, over their greatest value [-]."""
COMPARED_STEP_DEG = 10.0
"""Step of the directions in which they are compared [deg]."""

ComplexArray = npt.NDArray[np.complex128]


def ports_over(band: FullwaveBand, frequencies_hz: Sequence[float]) -> Iterator[LoadedReader]:
    """Yield the interpolated solution at each frequency, as `FullwaveBand.at` but without currents.

    Where that takes less far fields, they are interpolated between `FAR_NODES` of them, once the
    patterns and the heat of one more frequency, where a polynomial is worst, have been compared.

    Parameters
    ----------
    band, frequencies_hz : Solutions, and frequencies within their band [Hz].
    """
    wanted = [float(f) for f in frequencies_hz]
    fields = _NodeFields.of(band, wanted) if len(wanted) > FAR_NODES + 1 else None
    for f in wanted:
        yield band.at(f) if fields is None else fields.at(f)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _NodeFields:
    """Far fields (k, n, rows, columns, 2) [V] and heat (k, n, n) [S V^2] with loads at nodes."""

    band: FullwaveBand
    nodes_hz: npt.NDArray[np.float64]
    far_v: ComplexArray
    heat: ComplexArray

    @classmethod
    @one_blas_thread()
    def of(cls, band: FullwaveBand, wanted_hz: Sequence[float]) -> Self | None:
        """Return them across the frequencies that are wanted; None where they are not enough."""
        nodes = chebyshev_places_hz(min(wanted_hz), max(wanted_hz), FAR_NODES)
        solved = [band.at(float(f)) for f in nodes]
        grids = [one.unloaded.shorted_v.values.shape[1:3] for one in solved]
        theta, columns = np.linspace(0.0, np.pi, max(g[0] for g in grids)), max(grids)[1]
        found = cls(
            band=band,
            nodes_hz=nodes,
            far_v=np.stack(
                [
                    np.tensordot(
                        one.embedded_voltages_v,
                        one.unloaded.shorted_v.on_grid(theta, columns),
                        axes=(1, 0),
                    )
                    for one in solved
                ]
            ),
            heat=np.stack(
                [
                    one.embedded_voltages_v.conj() @ one.unloaded.heat_s @ one.embedded_voltages_v.T
                    for one in solved
                ]
            ),
        )
        width = nodes[-1] - nodes[0]
        far = [float(np.abs((f - nodes) / width).prod()) for f in wanted_hz]
        worst_hz = wanted_hz[int(np.argmax(far))]
        return found if _same(found.at(worst_hz), band.at(worst_hz)) else None

    @one_blas_thread()
    def at(self, frequency_hz: float) -> LoadedReader:
        """Return the ports at a frequency [Hz]."""
        first = self.band.results[0]
        admittance = self.band.admittance_s(frequency_hz)
        back = np.linalg.inv(embedded_voltages(admittance, first.load_ohm))
        shares = polynomial_shares(self.nodes_hz, frequency_hz)
        far, heat = (np.tensordot(shares, one, axes=(0, 0)) for one in (self.far_v, self.heat))
        unloaded = UnloadedReader(
            frequency_hz=frequency_hz,
            admittance_s=admittance,
            heat_s=back.conj() @ heat @ back.T,
            shorted_v=FarField(values=np.tensordot(back, far, axes=(1, 0))),
            phase_centres_m=first.unloaded.phase_centres_m,
            unknowns=first.unknowns,
            doubts=first.unloaded.doubts,
            half_space=first.unloaded.half_space,
        )
        return LoadedReader(unloaded=unloaded, load_ohm=first.load_ohm)


def _same(found: LoadedReader, expected: LoadedReader) -> bool:
    """Return whether two solutions agree in patterns and heat within `FAR_TOLERANCE`."""
    theta = np.radians(np.arange(0.0, 180.1, COMPARED_STEP_DEG))
    columns = round(360.0 / COMPARED_STEP_DEG)
    ours, theirs = (one.pattern_grid(theta, columns) for one in (found, expected))
    patterns = np.abs(ours - theirs).max() <= FAR_TOLERANCE * np.abs(theirs).max()
    heat = np.abs(found.lost_share - expected.lost_share).max() <= FAR_TOLERANCE
    return bool(patterns and heat)
