"""A log against the radio model: local means and single readings, beside what any law reaches."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.navigation.logs.frames import axis_frames
from octant.navigation.logs.records import Log
from octant.reader_design.experiments.measured.agreement import (
    Agreement,
    agreement,
    pooled_sd_db,
)
from octant.reader_design.experiments.measured.baselines import Baseline, baselines
from octant.reader_design.experiments.measured.calibrate import receivers
from octant.reader_design.experiments.measured.calibrate_model import LevelModel
from octant.reader_design.experiments.measured.observations import Observations, observed
from octant.reader_design.experiments.measured.predict import Predictor, Rows, predictable
from octant.reader_design.experiments.measured.sight import straight_lines
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.advice import opaque_sheet_note
from octant.reader_design.setting.setting import Setting

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

BETTER = 0.75
"""Scatter at other places over that at the own ones, from which axes seem mixed up [-]."""
NEAR_M = 0.4
"""How far a cell may be whose prediction is taken for such a place [m]."""
COMMON = 0.5
"""Share of the cells that must have one [-]."""
NO_PATH_DBM = -299.0
"""Predicted levels below this one are those of no path at all [dBm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """A log beside its predictions.

    Parameters
    ----------
    setting, rows, observations : The room, the readings, their local means.
    predicted_dbm : (o,) float64 — Predicted local means; NaN where no path arrives [dBm].
    readings_dbm : (n,) float64 — The same of single readings [dBm].
    distance_m, walls : (o,) — Distance to the source [m], faces of walls on the straight line [-].
    links, readings : Agreement by source and antenna, of local means and of single readings.
    by_walls : Agreement of local means in sight of the source, and behind walls, levels free.
    sd_free_db : Standard deviation of local means about one level for each source and antenna [dB].
    baselines : Standing laws.
    left_out : Greatest share of a place's power in paths that were left out [-].
    notes : What the reader should know.
    """

    setting: Setting
    rows: Rows
    observations: Observations
    predicted_dbm: FloatArray
    readings_dbm: FloatArray
    distance_m: FloatArray
    walls: IntArray
    links: tuple[Agreement, ...]
    readings: tuple[Agreement, ...]
    by_walls: tuple[Agreement, ...]
    sd_free_db: float
    baselines: tuple[Baseline, ...]
    left_out: float
    notes: tuple[str, ...]

    @property
    def residual_db(self) -> FloatArray:
        """Measured less predicted local means less the mean of source and antenna, (o,) [dB]."""
        rest = self.observations.level_dbm - self.predicted_dbm
        out = np.full(len(rest), np.nan)
        for mine in link_rows(self.observations).values():
            finite = mine & np.isfinite(rest)
            if finite.any():
                out[finite] = rest[finite] - rest[finite].mean()
        return out


def link_rows(observations: Observations) -> Mapping[tuple[int, int], npt.NDArray[np.bool_]]:
    """Return which observations belong to each source and antenna.

    Parameters
    ----------
    observations : Local means.
    """
    keys = np.column_stack([observations.sources, observations.antennas])
    return {
        (int(s), int(a)): (keys == (s, a)).all(axis=1) for s, a in np.unique(keys, axis=0).tolist()
    }


def compared(
    setting: Setting,
    log: Log,
    *,
    antenna: str,
    cell_m: float,
    least: int,
    progress: Progress,
) -> Compared:
    """Return a log beside its predictions: power sums over paths, in the room as the study has it.

    Parameters
    ----------
    setting, log : The room with its tags; the log in its frame.
    antenna : The robot's antenna where the log numbers none: a kind, or a pattern file.
    cell_m, least : Side of a cell [m], and readings that make a local mean.
    progress : Shows the tracing.
    """
    rows = predictable(log, setting)
    o = observed(rows, cell_m=cell_m, least=least)
    predictor = Predictor(
        setting, rows, receiver=receivers(setting, rows, antenna), progress=progress
    )
    predictor.trace()
    model = LevelModel(
        predictor=predictor,
        observations=o,
        parameters=(),
        power_w=setting.study.radio.tag_power_w,
    )
    readings = model.readings_dbm(np.zeros(0))
    reached = np.where(readings > NO_PATH_DBM, readings, np.nan)
    means = o.means(reached)
    distance, walls = straight_lines(setting, rows, o)
    names = {key: _name(rows, *key) for key in link_rows(o)}
    residual = o.level_dbm - means
    free = pooled_sd_db(residual, _numbers(o))
    notes = [*setting.notes, *_notes(setting, rows, means)]
    if advice := mixed_up(setting, o, means):
        notes.append(advice)
    return Compared(
        setting=setting,
        rows=rows,
        observations=o,
        predicted_dbm=means,
        readings_dbm=reached,
        distance_m=distance,
        walls=walls,
        links=tuple(
            agreement(names[key], o.level_dbm[mine], means[mine], unheard=_unheard(o, means, mine))
            for key, mine in link_rows(o).items()
        ),
        readings=tuple(_of_readings(rows, reached, names)),
        by_walls=tuple(_by_walls(o, residual, means, walls)),
        sd_free_db=free,
        baselines=baselines(o.level_dbm, _numbers(o), distance, walls),
        left_out=predictor.left_out,
        notes=tuple(notes),
    )


def _numbers(o: Observations) -> IntArray:
    """Return a number for each pair of source and antenna, (o,)."""
    _, number = np.unique(np.column_stack([o.sources, o.antennas]), axis=0, return_inverse=True)
    out: IntArray = number.reshape(-1)
    return out


def _name(rows: Rows, source: int, antenna: int) -> str:
    name = rows.log.ids[source]
    return f"{name}, antenna {antenna}" if antenna else name


def _unheard(o: Observations, means: FloatArray, mine: npt.NDArray[np.bool_]) -> tuple[int, int]:
    """Return how many cells without any heard reading are predicted below the threshold, of all."""
    silent = mine & (o.heard == 0)
    if o.threshold_dbm is None or not silent.any():
        return 0, 0
    right = ~(np.nan_to_num(means[silent], nan=-np.inf) > o.threshold_dbm)
    return int(right.sum()), int(silent.sum())


def _of_readings(
    rows: Rows, predicted: FloatArray, names: Mapping[tuple[int, int], str]
) -> list[Agreement]:
    log = rows.log
    out = []
    for (source, antenna), name in names.items():
        mine = (log.sources == source) & (log.antennas == antenna) & log.heard
        out.append(agreement(name, log.rss_dbm[mine], predicted[mine]))
    return out


def _by_walls(
    o: Observations, residual: FloatArray, means: FloatArray, walls: IntArray
) -> list[Agreement]:
    """Return agreements by what stands on the straight line, the level of each source taken off."""
    level = o.level_dbm.copy()
    for mine in link_rows(o).values():
        finite = mine & np.isfinite(residual)
        if finite.any():
            level[finite] -= residual[finite].mean()
    groups = (
        ("in sight", walls == 0),
        ("behind 1 or 2 faces of walls", (walls > 0) & (walls < 3)),
        ("behind 3 or more", walls >= 3),
    )
    return [agreement(name, level[g], means[g]) for name, g in groups if g.any()]


def _notes(setting: Setting, rows: Rows, means: FloatArray) -> list[str]:
    out = []
    if rows.outside:
        out.append(f"{rows.outside} readings were taken outside the room's free space: left out.")
    if rows.unplaced:
        out.append(f"{rows.unplaced} readings have no known place and are left out.")
    lost = int(rows.log.censored.sum())
    if lost and rows.log.threshold_dbm is None:
        out.append(
            f"{lost} times a source was not heard. No threshold is known, so that these may be "
            "lost packets: they are left out. Give log.threshold_dbm to count them as weak."
        )
    dark = int(np.sum(np.isnan(means)))
    if dark:
        out.append(f"no path arrives in {dark} of {len(means)} cells, where something was heard.")
    if advice := opaque_sheet_note(setting.study, setting.scene):
        out.append(advice)
    return out


def mixed_up(setting: Setting, o: Observations, means: FloatArray) -> str:
    """Return that a log's axes seem to be mixed up, and which way, or "".

    Where cells fit the predictions clearly better at their mirrored or turned places, the log's
    coordinates are not the room's.

    Parameters
    ----------
    setting, o, means : The room, the local means, their predictions [dBm].
    """
    if not setting.has_room or len(np.unique(o.sources)) < 2:
        return ""

    def scatter_db(places: FloatArray) -> tuple[float, float]:
        """Return the scatter at other places, and at the own ones of the same cells."""
        there = np.full(len(o), np.nan)
        for mine in link_rows(o).values():
            known = np.flatnonzero(mine & np.isfinite(means))
            if not known.size:
                continue
            gap = np.linalg.norm(places[mine, None] - o.places[known], axis=2)
            near = np.argmin(gap, axis=1)
            found = gap[np.arange(len(near)), near] <= NEAR_M
            there[mine] = np.where(found, means[known[near]], np.nan)
        both = np.isfinite(there) & np.isfinite(means) & np.isfinite(o.level_dbm)
        if np.mean(both) < COMMON:
            return float("inf"), 0.0
        scatter = [
            pooled_sd_db(np.where(both, o.level_dbm - p, np.nan), _numbers(o))
            for p in (there, means)
        ]
        return scatter[0], scatter[1]

    tried = axis_frames(*setting.scene.bounds_m[:, :2])
    found = {name: scatter_db(frame.places_m(o.places)) for name, frame in tried.items()}
    best = min(found, key=lambda name: found[name][0])
    if not found[best][0] < BETTER * found[best][1]:
        return ""
    return (
        f"with {best} the log fits far better ({found[best][0]:.1f} dB of scatter in place of "
        f"{found[best][1]:.1f}): are its axes mixed up? Try {tried[best].text()} in [log]."
    )
