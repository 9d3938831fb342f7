"""One cell of a sweep: a design in a study, scored in free space and in the room.

`keys` names cells; `experiments.sweep` runs many of them and keeps them.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import SweepStateError
from octant.reader_design.setting.capture import captured_share
from octant.reader_design.setting.receiver import scoring_readings_w
from octant.reader_design.setting.samples import (
    free_points_m,
    grid_azimuths_rad,
    room_places_m,
    sample_rss_w,
)
from octant.reader_design.setting.scores import score_rss
from octant.reader_design.setting.setting import Setting
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.scores import Scores

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """One computed (or failed) cell.

    Attributes
    ----------
    key : Its key; empty until it is kept.
    design : The design.
    reason : Why it failed; empty when it did not.
    free, room : Scores in free space and in the room ([rad], [dB], [W],); None without.
    distances_m : (d,) float64 — Distances in free space [m].
    free_rss_w : (d, a, n) float64 — RSS in free space [W] by distance, azimuth, antenna; azimuths
        evenly from 0.
    travel_m : (t,) float64 — Distances of the drive away from the tag [m].
    travel_rss_w : (t, n) float64 — RSS on it [W], the tag straight behind antenna 1's direction of
        travel reversed: antenna 1 faces the tag.
    notes : Warnings of the reader's model.
    seconds : Time that it took [s].
    unexpected : Whether it failed for a reason that is not the design's own, such as want of
        memory: the next run tries it again.
    label : Human name, with every swept parameter; by default the design's own.
    """

    key: str = ""
    design: Reader
    reason: str = ""
    free: Scores | None = None
    room: Scores | None = None
    distances_m: FloatArray
    free_rss_w: FloatArray
    travel_m: FloatArray
    travel_rss_w: FloatArray
    notes: tuple[str, ...] = ()
    seconds: float = 0.0
    unexpected: bool = False
    label: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "label", self.label or self.design.label())
        d, t = np.size(self.distances_m), np.size(self.travel_m)
        for name, shape in (
            ("distances_m", (d,)),
            ("free_rss_w", (d, None, None)),
            ("travel_m", (t,)),
            ("travel_rss_w", (t, None)),
        ):
            array = frozen_array(getattr(self, name), name=name, shape=shape, error=SweepStateError)
            object.__setattr__(self, name, array)


def failed_cell(design: Reader, key: str, reason: str, *, unexpected: bool = False) -> Cell:
    """Return a cell without numbers.

    Parameters
    ----------
    design, key : The design and its key.
    reason : Why there are none.
    unexpected : Whether the reason is not the design's own.
    """
    return Cell(
        key=key,
        design=design,
        reason=reason,
        unexpected=unexpected,
        distances_m=np.zeros(0),
        free_rss_w=np.zeros((0, 0, design.antennas)),
        travel_m=np.zeros(0),
        travel_rss_w=np.zeros((0, design.antennas)),
    )


def scored_cell(setting: Setting) -> Cell:
    """Return the scores and RSS of the reader of a setting, or raise why there are none.

    Parameters
    ----------
    setting : The reader in its room.

    Notes
    -----
    Free space uses the reference tag at its height, without the room; the room uses every tag
    and every place of the floor on which the reader fits. RSS is coherent.
    """
    study, sampling, responses = setting.study, setting.sampling, setting.responses
    elements = np.asarray(responses[0].azimuths_rad, dtype=np.float64)
    tag = setting.reference_tag
    link = setting.free_link(tag)
    azimuths = grid_azimuths_rad(elements.size, sampling.free_azimuths)
    distances, travel = sampling.distances_m(), sampling.travel_m()
    origin = tag.position_m[:2]
    free = sample_rss_w(link, origin + free_points_m(distances), origin, azimuths)
    along = sample_rss_w(link, origin + free_points_m(travel), origin, elements[:1])
    room = None
    if setting.has_room:
        room_azimuths = grid_azimuths_rad(elements.size, sampling.room_azimuths)
        rss = room_samples_w(setting, room_azimuths)
        room = score_rss(
            rss,
            room_azimuths,
            elements,
            usable_dbm=setting.usable_dbm,
            readings_w=scoring_readings_w(study, rss),
            captured_share=captured_share(setting),
        )
    warned = (text for one in responses for text in one.warnings)
    return Cell(
        design=setting.reader,
        free=score_rss(
            free,
            azimuths,
            elements,
            usable_dbm=setting.usable_dbm,
            readings_w=scoring_readings_w(study, free),
        ),
        room=room,
        distances_m=distances,
        free_rss_w=free,
        travel_m=travel,
        travel_rss_w=along[:, 0],
        notes=tuple(dict.fromkeys((*setting.reader.notes(), *warned))),
    )


def room_samples_w(setting: Setting, azimuths_rad: FloatArray) -> FloatArray:
    """Return a reader's RSS in its room [W], by tag and place, azimuth, antenna.

    Parameters
    ----------
    setting : The room with its reader, and the sampling.
    azimuths_rad : (a,) float64 — Azimuths of the tag in the reader frame [rad].
    """
    rows = []
    for tag, places in room_places_m(setting):
        rows.append(sample_rss_w(setting.link(tag), places, tag.position_m[:2], azimuths_rad))
    return np.concatenate(rows)
