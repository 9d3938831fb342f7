"""The antennas' patterns for a page: solids that turn, with cuts."""

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.decibels import decibels
from octant.reader_design.showing.page.packing import packed
from octant.reader_design.showing.pages import ReportFigure, ReportWidget

THETA_STEPS, PHI_STEPS = 46, 90
"""Points of a pattern [-]: every 4°."""


def peak_dbi(response: ReaderResponse) -> float:
    """Return the greatest realised gain of any antenna [dBi].

    Parameters
    ----------
    response : The reader's.
    """
    return float(_gain_dbi(response).max())


def _gain_dbi(response: ReaderResponse) -> npt.NDArray[np.float64]:
    theta = np.linspace(0.0, np.pi, THETA_STEPS)
    phi = np.arange(PHI_STEPS) * 2.0 * np.pi / PHI_STEPS
    field = response.far_field(theta[:, None], phi[None, :])
    return decibels(np.maximum((np.abs(field) ** 2).sum(axis=-1), 1e-10))


def pattern_widget(
    response: ReaderResponse, *, fallback: tuple[ReportFigure, ...] = ()
) -> ReportWidget:
    """Return the antennas' realised gains as a page turns them [dBi].

    Parameters
    ----------
    response : The reader's.
    fallback : What stands there without scripts and on paper.
    """
    theta = np.linspace(0.0, np.pi, THETA_STEPS)
    phi = np.arange(PHI_STEPS) * 2.0 * np.pi / PHI_STEPS
    gain = _gain_dbi(response)
    top = float(gain.max())
    first = gain[0]
    best = np.unravel_index(int(first.argmax()), first.shape)
    return ReportWidget(
        kind="pattern",
        title="Pattern of each antenna",
        caption="The realised gain of one antenna with all others in place, as a solid whose "
        "radius falls by 30 dB to its centre. Choose the antenna; the cut beside it shows all.",
        alt=f"Antenna 1 has its greatest gain, {first.max():.1f} dBi, "
        f"{90.0 - np.degrees(theta[best[0]]):.0f}° above the horizon at azimuth "
        f"{np.degrees(phi[best[1]]):.0f}°.",
        data={
            "gain_dbi": packed(np.maximum(gain, top - 45.0), step=0.2),
            "azimuths_deg": np.degrees(response.azimuths_rad).round(3).tolist(),
            "theta_deg": float(np.degrees(theta[best[0]])),
        },
        fallback=fallback,
    )
