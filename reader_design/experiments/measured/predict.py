"""A log's readings as the radio model sees them: cells, places, paths kept, levels predicted.

A log has many readings at nearly one place. Places within `PLACE_M` of each other share one
prediction, the power sum over paths, which varies slowly; local means over cells are means in dB
of the readings, and of the predictions at the readings' places.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna
from octant.em.medium.materials import Material
from octant.em.power.kept_paths import (
    ArrivingFields,
    KeptPaths,
    arriving_fields,
    keep_paths,
    with_materials,
)
from octant.em.search.candidates import search_candidates
from octant.geometries.errors import ConfigError
from octant.geometries.names import nearest_name
from octant.navigation.logs.records import NO_SOURCE, Log, taken
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.setting import Setting

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

PLACE_M = 0.15
"""Side of the squares whose readings share one prediction [m]: about a wavelength at 2.4 GHz."""
HEADING_RAD = np.radians(10.0)
"""Headings that share one prediction, where antennas are numbered [rad]."""
LEAST_SHARE = 1e-4
"""Paths of less than this share of a place's strongest one are left out [-]."""
DBM_PER_W = 30.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Rows:
    """The readings of a log that can be predicted.

    Parameters
    ----------
    log : Those readings alone, in their order.
    tags : Index of the study's tag for each of the log's ids [-]; -1: no reading is left of it.
    group : (n,) int64 — The place, of ``poses``, whose prediction each reading shares [-].
    poses : (g, 3) float64 — Mean x, y [m] and heading [rad] of the readings at each place.
    outside : Readings that were left out, since the room does not hold their place [-].
    unplaced : Readings that were left out, since the log does not say where they were taken [-].
    """

    log: Log
    tags: tuple[int, ...]
    group: IntArray
    poses: FloatArray
    outside: int = 0
    unplaced: int = 0

    @property
    def numbered(self) -> bool:
        """Whether the robot's antennas are numbered, as a reader's are."""
        return bool(self.log.antennas.size) and int(self.log.antennas.max()) > 0


def predictable(log: Log, setting: Setting, *, place_m: float = PLACE_M) -> Rows:
    """Return a log's readings that can be predicted; refuse a log that does not fit the study.

    Parameters
    ----------
    log, setting : The log, in the room's frame; the room, its tags and its reader.
    place_m : Side of the squares whose readings share one prediction [m].

    Raises
    ------
    ConfigError
        The log is empty, has a source that the study lacks, antennas that its reader lacks, or most
        of its places lie outside the room.
    """
    known = [tag.id for tag in setting.tags]
    said = taken(log, (log.sources != NO_SOURCE))
    if not len(said):
        msg = "the log is empty: it holds no reading; give one with a level or 'not heard'."
        raise ConfigError(msg)
    for name in (said.ids[i] for i in np.unique(said.sources)):
        if name not in known:
            near = nearest_name(name, known)
            hint = f"did you mean {near!r}?" if near else f"its tags are {', '.join(known) or '-'}."
            msg = (
                f"the log has readings of {name!r}, but the study has no such [[tag]]: {hint} Add "
                "it with its position_m, or leave its readings out."
            )
            raise ConfigError(msg)
    _check_antennas(said, setting)
    needed = 3 if int(said.antennas.max()) > 0 else 2
    placed = np.isfinite(said.poses[:, :needed]).all(axis=1)
    if not placed.any():
        msg = (
            "no reading of the log has a known place"
            + (" and heading" if needed == 3 else "")
            + ", but predictions need x_m and y_m of the robot"
            + (" and heading_deg." if needed == 3 else ".")
        )
        raise ConfigError(msg)
    there = taken(said, placed)
    points = np.column_stack((there.poses[:, :2], np.full(len(there), setting.reader_z_m)))
    inside = setting.scene.inside_room(points) & ~setting.scene.inside_solid(points)
    if not inside.any():
        low, high = setting.scene.bounds_m[:, :2]
        msg = (
            "no reading of the log was taken inside the room, which spans "
            f"x {low[0]:.6g} to {high[0]:.6g} and y {low[1]:.6g} to {high[1]:.6g} m, or in what is "
            "free of it; check log.length_unit, and log.points_log_m with log.points_room_m."
        )
        raise ConfigError(msg)
    rows = taken(there, inside)
    group, poses = _grouped(rows, place_m)
    return Rows(
        log=rows,
        tags=tuple(known.index(name) if name in known else -1 for name in rows.ids),
        group=group,
        poses=poses,
        outside=int(np.sum(~inside)),
        unplaced=int(np.sum(~placed)),
    )


def _check_antennas(log: Log, setting: Setting) -> None:
    """Refuse a log whose antennas are not those of the reader."""
    numbers = [int(a) for a in np.unique(log.antennas)]
    if 0 in numbers and len(numbers) > 1:
        msg = (
            f"some readings name an antenna ({numbers[-1]}) and others none; number all of them, "
            "or none."
        )
        raise ConfigError(msg)
    if numbers[-1] > setting.reader.antennas:
        msg = (
            f"the log has readings of antenna {numbers[-1]}, but the study's reader has "
            f"{setting.reader.antennas} (reader.antennas)."
        )
        raise ConfigError(msg)


def _grouped(log: Log, place_m: float) -> tuple[IntArray, FloatArray]:
    """Return the place of each reading, and the places' mean poses."""
    numbered = int(log.antennas.max()) > 0
    heading = np.where(np.isfinite(log.poses[:, 2]), log.poses[:, 2], 0.0)
    turned = np.floor(np.mod(heading, 2.0 * np.pi) / HEADING_RAD) if numbered else 0.0 * heading
    keys = np.column_stack([np.floor(log.poses[:, :2] / place_m), turned]).astype(np.int64)
    _, group = np.unique(keys, axis=0, return_inverse=True)
    group = group.reshape(-1)
    count = np.bincount(group)
    x, y, c, s = (
        np.bincount(group, values) / count
        for values in (*log.poses[:, :2].T, np.cos(heading), np.sin(heading))
    )
    return group, np.column_stack([x, y, np.arctan2(s, c)])


@dataclass(frozen=True, slots=True, kw_only=True)
class Values:
    """What a prediction depends on besides the study: values that a fit may change.

    Parameters
    ----------
    materials : Meaning of material labels of the scene that differ from the study's.
    axes : By number of the tag, direction of its antenna [-].
    places_m : By number of the tag, its place [m].
    height_m : Height of the reader's ground plane above the floor [m]; None: the study's.
    """

    materials: Mapping[str, Material] = field(default_factory=dict)
    axes: Mapping[int, tuple[float, float, float]] = field(default_factory=dict)
    places_m: Mapping[int, tuple[float, float, float]] = field(default_factory=dict)
    height_m: float | None = None


class Predictor:
    """Predicts power at a log's places: paths are traced once for each place of tag and reader.

    Parameters
    ----------
    setting, rows : The room with its tags; the readings.
    receiver : The robot's antenna at each frequency, where the log numbers none; None: the reader.
    progress : Shows the tracing.
    """

    def __init__(
        self,
        setting: Setting,
        rows: Rows,
        *,
        receiver: Sequence[Antenna] | None,
        progress: Progress | None = None,
    ) -> None:
        self.setting, self.rows = setting, rows
        self._receiver = receiver
        self._progress = progress
        self._kept: dict[tuple[object, ...], KeptPaths] = {}
        self._gains: dict[tuple[object, ...], FloatArray] = {}
        self.sources = tuple(int(s) for s in np.unique(rows.log.sources))
        self._places = {s: np.unique(rows.group[rows.log.sources == s]) for s in self.sources}

    @property
    def antennas(self) -> int:
        """Number of the robot's antennas."""
        return 1 if self._receiver is not None else self.setting.reader.antennas

    @property
    def left_out(self) -> float:
        """Greatest share of a place's power in paths that were left out [-]."""
        return max((kept.left_out for kept in self._kept.values()), default=0.0)

    def gains(self, values: Values) -> FloatArray:
        """Return the power sum over paths of each source, place and antenna, (s, g, n) [-].

        NaN where the log has no reading of the source at a place.

        Parameters
        ----------
        values : What differs from the study ([m], [-]).
        """
        out = np.full((len(self.rows.log.ids), len(self.rows.poses), self.antennas), np.nan)
        for source in self.sources:
            out[source, self._places[source]] = self._source_gains(source, values)
        return out

    def _source_gains(self, source: int, values: Values) -> FloatArray:
        tag = self.rows.tags[source]
        own = (
            tuple(sorted(values.materials.items(), key=lambda item: item[0])),
            values.axes.get(tag),
            values.places_m.get(tag),
            values.height_m,
        )
        key = (source, own)
        if key not in self._gains:
            if len(self._gains) > 400:  # a fit comes back to its latest values only
                self._gains.pop(next(iter(self._gains)))
            self._gains[key] = self._computed(source, values)
        return self._gains[key]

    def _computed(self, source: int, values: Values) -> FloatArray:
        tag_number = self.rows.tags[source]
        tag = self.setting.tags[tag_number]
        kept = self.kept(source, values)
        axis = values.axes.get(tag_number)
        headings = self.rows.poses[self._places[source], 2]
        sums = np.zeros((len(kept.places_m), self.antennas))
        for i, radio in enumerate(self.setting.radios):
            antenna = tag.antennas[i]
            if axis is not None:
                antenna = replace(antenna, axis=np.asarray(axis))
            changed = with_materials(radio, values.materials) if values.materials else radio
            waves = arriving_fields(changed, kept, transmitter=antenna)
            sums += self._received(waves, i, headings)
        return sums / len(self.setting.radios)

    def _received(self, waves: ArrivingFields, channel: int, headings: FloatArray) -> FloatArray:
        if self._receiver is not None:
            return waves.at_antenna(self._receiver[channel], 1.0).local_mean_w[:, None]
        response = self.setting.responses[channel]
        return waves.at_reader(response, headings, 1.0).local_mean_w

    def kept(self, source: int, values: Values) -> KeptPaths:
        """Return the paths from a source to its places, traced when they are first asked for.

        Parameters
        ----------
        source, values : Index into the log's ids; places and height that differ [m].
        """
        tag = self.rows.tags[source]
        place = values.places_m.get(tag) or tuple(self.setting.tags[tag].position_m.tolist())
        key = (source, place, values.height_m)
        if key not in self._kept:
            while len(self._kept) > 4 * len(self.sources) + 8:
                self._kept.pop(next(iter(self._kept)))
            z_m = self.height_m(values)
            where = self.rows.poses[self._places[source], :2]
            radio = max(self.setting.radios, key=lambda one: one.wavelength_m)
            found = search_candidates(radio, place, self.setting.solver)
            self._kept[key] = keep_paths(
                radio,
                found,
                np.column_stack((where, np.full(len(where), z_m))),
                least_share=LEAST_SHARE,
            )
        return self._kept[key]

    def trace(self) -> None:
        """Trace the paths of all sources, with progress, for the study's own values."""
        progress = self._progress or Progress(quiet=True)
        with progress.track(self.sources, total=len(self.sources), label="tracing") as each:
            for source in each:
                self.kept(source, Values())

    def height_m(self, values: Values) -> float:
        """Return the height coordinate of the robot's antenna [m].

        Parameters
        ----------
        values : Of them the height counts [m].
        """
        floor = self.setting.scene.floor_height_m
        own = self.setting.reader.height_m if values.height_m is None else values.height_m
        return floor + own
