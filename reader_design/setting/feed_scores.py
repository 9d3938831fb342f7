"""How well a reader tells bearings at several frequencies, whatever lies behind its antennas.

In free space what arrives at the receivers is linear in what the shorted antennas would receive, so
that the scores of many feeds follow from one solution.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import numpy.typing as npt
from msgspec.structs import replace as with_keys

from octant.em.antennas.kinds import Antenna
from octant.em.blocks import one_blas_thread
from octant.em.reader.feeding import Feeding
from octant.em.reader.fullwave.loads import BELOW_RAD, LoadedReader
from octant.reader_design.setting.bearing_errors import summarise_errors, vector_errors_rad
from octant.reader_design.setting.measures import right_share, strongest_errors_rad
from octant.reader_design.setting.samples import grid_azimuths_rad
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.schema import Study

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BearingErrors:
    """Scores of bearing at several frequencies, of which less is better.

    Parameters
    ----------
    vector_rms_rad, strongest_rms_rad : (f,) float64 — Rms errors of the vector sum and of the
        strongest antenna [rad].
    wrong_share : (f,) float64 — Share of directions whose strongest antenna is not the nearest [-].
    """

    vector_rms_rad: FloatArray
    strongest_rms_rad: FloatArray
    wrong_share: FloatArray

    def over(self, other: "BearingErrors") -> FloatArray:
        """Return the ratios (3, f) to another's of all scores at all frequencies [-].

        Parameters
        ----------
        other : At the same frequencies; where both are zero the ratio is 1.
        """
        names = ("vector_rms_rad", "strongest_rms_rad", "wrong_share")
        tiny = np.finfo(np.float64).tiny
        return np.array(
            [
                np.maximum(getattr(self, name), tiny) / np.maximum(getattr(other, name), tiny)
                for name in names
            ]
        )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FeedScores:
    """A solved reader and the fields of a study's reference tag, at several frequencies.

    Parameters
    ----------
    solutions : The ports at each frequency; what lies behind them here does not count.
    received_v : At each frequency, (n, d, a) what one volt at each port would receive, by distance
        and azimuth of the tag [any unit].
    azimuths_rad, element_azimuths_rad : (a,), (n,) azimuths of the tag and of the antennas [rad].
    """

    solutions: tuple[LoadedReader, ...]
    received_v: tuple[ComplexArray, ...]
    azimuths_rad: FloatArray
    element_azimuths_rad: FloatArray

    @classmethod
    def of(cls, study: Study, solutions: Sequence[LoadedReader]) -> Self:
        """Return the scores' inputs as `scored_cell` samples free space.

        Parameters
        ----------
        study : It has a tag; a tag that the reader wakes counts as one that sends.
        solutions : The reader's ports at each frequency.
        """
        frequencies_hz = tuple(one.frequency_hz for one in solutions)
        radio = with_keys(study.radio, channels_hz=frequencies_hz)
        setting = build_setting(with_keys(study, radio=radio))
        tag, sampling = setting.reference_tag, setting.sampling
        elements = np.asarray(study.reader.body().element_azimuths_rad, dtype=np.float64)
        azimuths = grid_azimuths_rad(elements.size, sampling.free_azimuths)
        above_m = float(tag.position_m[2]) - setting.reader_z_m
        theta = np.arctan2(sampling.distances_m(), above_m)
        at = dict(zip(setting.study.radio.frequencies_hz, tag.antennas, strict=True))
        return cls(
            solutions=tuple(solutions),
            received_v=tuple(
                _received(one, at[one.frequency_hz], theta, azimuths.size) for one in solutions
            ),
            azimuths_rad=azimuths,
            element_azimuths_rad=elements,
        )

    @property
    def frequencies_hz(self) -> tuple[float, ...]:
        """The frequencies [Hz]."""
        return tuple(one.frequency_hz for one in self.solutions)

    @one_blas_thread()
    def behind(self, feeding: Feeding | None) -> BearingErrors:
        """Return the scores with a feed behind the antennas ([rad], [-]).

        Parameters
        ----------
        feeding : What lies there; None: the loads of the solutions.
        """
        rows = []
        for ports, received in zip(self.solutions, self.received_v, strict=True):
            loaded = replace(ports, feeds=None) if feeding is None else feeding.on(ports)
            voltage = np.tensordot(received, loaded.realised_weights, axes=(0, 1))
            rss = voltage.real**2 + voltage.imag**2
            place = (rss, self.azimuths_rad, self.element_azimuths_rad)
            vector = summarise_errors(vector_errors_rad(*place))
            strongest = summarise_errors(*strongest_errors_rad(*place))
            rows.append((vector.rms_rad, strongest.rms_rad, 1.0 - right_share(*place)))
        vector_rms, strongest_rms, wrong = np.array(rows).T
        return BearingErrors(
            vector_rms_rad=vector_rms, strongest_rms_rad=strongest_rms, wrong_share=wrong
        )


def _received(
    ports: LoadedReader, tag: Antenna, theta_rad: FloatArray, columns: int
) -> ComplexArray:
    """Return (n, d, a) what one volt at each port receives of a tag at angles from +z [any unit].

    The tag stands still while the reader turns below it, on its +x side.
    """
    fields = ports.unloaded.shorted_v.on_grid(theta_rad, columns)
    if ports.unloaded.half_space:
        fields[:, theta_rad > BELOW_RAD] = 0.0
    sent = tag.far_field(math.pi - theta_rad, np.zeros_like(theta_rad))
    # Seen from the reader the tag's theta points as seen from the tag, and its phi back.
    received: ComplexArray = fields[..., 0] * sent[:, None, 0] - fields[..., 1] * sent[:, None, 1]
    return received
