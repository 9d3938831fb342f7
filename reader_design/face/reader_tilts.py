"""What a reader is worth for tags that lean by an unknown angle: levels and right antennas."""

import csv
import io
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.decibels import decibels
from octant.geometries.files import write_text

FloatArray = npt.NDArray[np.float64]

AZIMUTH_STEP_DEG = 2.5
"""Step of the azimuths over which a tag's level is averaged [deg]."""
TILT_COLUMNS = ("tilt_deg", "mean_gain_dbi", "least_gain_dbi", "next_to_tag_share")
"""Columns of ``tilts.csv``: tilt of the tag; gain of the strongest antenna towards it for its
polarisation, mean and least over its azimuth; at what share of azimuths that antenna stands less
than one step of the antennas from the tag's azimuth."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TiltTable:
    """Gains for tags of any tilt.

    Parameters
    ----------
    elevation_deg : Elevation of the tags over the reader's horizon [deg].
    tilts_deg : (t,) — Lean of the tag's polarisation, to the right seen from the reader [deg].
    gains_dbi : (t, a) — Gain of the strongest antenna at each azimuth [dBi].
    right : (t, a) bool — Whether it is one of those next to the tag [-].
    """

    elevation_deg: float
    tilts_deg: FloatArray
    gains_dbi: FloatArray
    right: npt.NDArray[np.bool_]

    @property
    def mean_gain_dbi(self) -> FloatArray:
        """Mean (t,) over azimuth of the gain, taken as a power [dBi]."""
        return decibels((10.0 ** (0.1 * self.gains_dbi)).mean(axis=1))

    @property
    def right_share(self) -> FloatArray:
        """Share (t,) of azimuths at which the strongest antenna is next to the tag [-]."""
        share: FloatArray = self.right.mean(axis=1)
        return share

    def rows(self) -> Iterator[tuple[float, float, float, float]]:
        """Yield a row of `TILT_COLUMNS` for each tilt [deg], [dBi], [dBi], [-]."""
        least = self.gains_dbi.min(axis=1)
        columns = (self.tilts_deg, self.mean_gain_dbi, least, self.right_share)
        yield from zip(*(column.tolist() for column in columns), strict=True)

    def lines(self) -> Iterator[str]:
        """Yield the table for people, and what tags of unknown tilt lose."""
        yield (
            f"Tags {self.elevation_deg:g}° above the horizon, by the tilt of their polarisation: "
            "gain of the strongest antenna over all azimuths, and where it is next to the tag"
        )
        yield "tilt [°]  mean gain [dBi]  least [dBi]  next to the tag [%]"
        for tilt, mean, least, share in self.rows():
            yield f"{tilt:>8g}{mean:>17.1f}{least:>13.1f}{100.0 * share:>21.0f}"
        yield (
            f"From the best to the worst tilt {np.ptp(self.mean_gain_dbi):.1f} dB are lost; over "
            f"all tilts the antenna is right at {100.0 * self.right_share.mean():.0f} % of places."
        )

    def to_csv(self, path: Path) -> None:
        """Write a table of `TILT_COLUMNS` [deg], [dBi], [-].

        Parameters
        ----------
        path : The file; replaced where it exists.
        """
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(TILT_COLUMNS)
        writer.writerows(self.rows())
        write_text(path, out.getvalue())


def tilt_table(response: ReaderResponse, *, step_deg: float, elevation_deg: float) -> TiltTable:
    """Return what a reader's antennas receive of linearly polarised tags of every tilt.

    Parameters
    ----------
    response : The antennas' patterns.
    step_deg : Step of the tilts [deg], from 0 to below 180; it must divide 180.
    elevation_deg : Elevation of the tags over the reader's horizon [deg].

    Notes
    -----
    A tag's polarisation leans from the vertical plane by t, to the right as seen from the reader:
    the gain is |cos(t) F_theta + sin(t) F_phi|².
    """
    phi = np.radians(np.arange(0.0, 360.0, AZIMUTH_STEP_DEG))
    theta = math.radians(90.0 - elevation_deg)
    field = response.far_field(np.full_like(phi, theta), phi)
    tilts = step_deg * np.arange(round(180.0 / step_deg), dtype=np.float64)
    t = np.radians(tilts)[:, None, None]
    gains = np.abs(np.cos(t) * field[..., 0] + np.sin(t) * field[..., 1]) ** 2
    strongest = gains.argmax(axis=1)
    off = response.azimuths_rad[strongest] - phi
    apart = np.abs((off + math.pi) % (2.0 * math.pi) - math.pi)
    step = 2.0 * math.pi / response.antennas
    return TiltTable(
        elevation_deg=elevation_deg,
        tilts_deg=tilts,
        gains_dbi=decibels(np.maximum(gains.max(axis=1), 1e-30)),
        right=apart < step - 1e-9,
    )
