"""What went wrong in the runs of a mission, in one sentence, and which keys to try."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any, Literal

import numpy as np

from octant.navigation.missions.metrics import MissionMetrics, measure
from octant.navigation.missions.records import MissionResult
from octant.reader_design.experiments.missions.compute import mission_space
from octant.reader_design.experiments.missions.shadows import (
    Shadow,
    open_place_m,
    shadow_of,
    start_clearance_m,
)
from octant.reader_design.setting.rfid import is_woken
from octant.reader_design.setting.robot import free_place_m
from octant.reader_design.setting.setting import Setting
from octant.reader_design.study_file.changes import Change
from octant.reader_design.study_file.room import MaterialTable

Cause = Literal[
    "asleep", "start", "no floor", "shadowed", "time-out", "wrong place", "obstacle", "nowhere"
]

GOOD_SHARE = 0.95
"""Share of runs that reach every tag from which a mission counts as good [-]."""
FAIR_SHARE = 0.5
"""The same from which it counts as fair [-]."""

CHANNELS_HZ = {
    (2.4e9, 2.4835e9): (2.402e9, 2.428e9, 2.454e9, 2.48e9),
    (902e6, 928e6): (903e6, 911e6, 919e6, 927e6),
}
"""Channels [Hz] that are proposed for carriers within a band: spread over all of it."""
ARRIVING_TAG, ARRIVING_NAVIGATOR = "conical_patch", "tracker"
"""Tag antenna and navigator with which missions arrive inside walls (docs/navigation.md)."""
MANY_CHANNELS = 16
"""Channels that are proposed where a few do not suffice [-]."""

_SLEPT = 0.5
_AT_START_M = 0.5
_CLOSE_M = 0.15
_STARTED_ROWS = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Advice:
    """What a mission that failed needs.

    Attributes
    ----------
    cause : What happened in most of the runs that failed, as a word.
    sentence : The same as one sentence, with the numbers of runs.
    changes : Keys of the study to try, the most promising first; none where nothing is known.
    """

    cause: Cause
    sentence: str
    changes: tuple[Change, ...] = ()

    @property
    def lines(self) -> tuple[str, ...]:
        """The keys to try as lines of TOML, each table under its own header."""
        lines: list[str] = []
        for header, changes in groupby(self.changes, key=lambda change: change.header):
            lines += [*([""] if lines else []), header, *(change.line for change in changes)]
        return tuple(lines)

    def text(self) -> str:
        """Return sentence and lines for a terminal."""
        if not self.changes:
            return self.sentence
        return "\n".join([self.sentence, "Try, in the study file:", *_indented(self.lines)])


def _indented(lines: Sequence[str]) -> Iterator[str]:
    return (f"    {line}".rstrip() for line in lines)


def advise(setting: Setting, results: Sequence[MissionResult]) -> Advice | None:
    """Return what the runs show and what to try; None where nearly all reached every tag.

    Parameters
    ----------
    setting : The reader in the room in which the runs were driven, with their study.
    results : Every run.
    """
    metrics = [measure(result) for result in results]
    failed = [i for i, m in enumerate(metrics) if not m.success]
    if len(failed) <= (1.0 - GOOD_SHARE) * len(results) + 1e-9:
        return None
    runs = len(results)
    if len(failed) < runs:
        head = f"{len(failed)} of {runs} runs did not reach every tag"
    else:
        head = "The run did not reach every tag" if runs == 1 else "No run reached every tag"
    case = _Case(
        setting=setting,
        head=head,
        results=tuple(results[i] for i in failed),
        metrics=tuple(metrics[i] for i in failed),
        some_success=len(failed) < runs,
    )
    found = (_asleep, _start, _no_floor, _shadowed, _time_out, _wrong_place, _obstacle, _nowhere)
    return next(advice for advice in (look(case) for look in found) if advice is not None)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Case:
    setting: Setting
    head: str
    results: tuple[MissionResult, ...]
    metrics: tuple[MissionMetrics, ...]
    some_success: bool

    @property
    def missed(self) -> str:
        """The tag that most of these runs were missing: the first not reached within its radius."""
        return Counter(map(self.missed_in, range(len(self.results)))).most_common(1)[0][0]

    def missed_in(self, run: int) -> str:
        """Return the first tag that a run did not reach.

        Parameters
        ----------
        run : Its number among the failed ones.
        """
        result, metrics = self.results[run], self.metrics[run]
        radii_m = np.array([2.0 * test.radius_m for test in result.mission.arrivals])
        missed = ~(metrics.arrival_errors_m <= radii_m)
        return result.mission.tag_ids[int(np.argmax(missed))]

    def share(self, flags: Sequence[bool]) -> float:
        """Return the share of the failed runs for which something holds [-].

        Parameters
        ----------
        flags : One for each of them.
        """
        return sum(flags) / len(self.results)


def _asleep(case: _Case) -> Advice | None:
    study = case.setting.study
    if not is_woken(study, case.setting.tag(case.missed)):
        return None
    silent = [
        bool((r.rss_w[r.targets == r.targets[-1]].max(axis=1) <= 0.0).mean() > _SLEPT)
        or r.outcome == "no signal"
        for r in case.results
    ]
    if case.share(silent) <= 0.5:
        return None
    place, table = next((i, t) for i, t in enumerate(study.tags) if t.id == case.missed)
    passive = table.kind == "passive"
    changes = [
        Change(
            path=("tag", place, "kind"),
            value="semi_passive" if passive else "active",
            of=f'the one with id = "{table.id}"',
            why="a battery for its chip" if passive else "it sends by itself",
        )
    ]
    return Advice(
        cause="asleep",
        sentence=f"{case.head}: tag {case.missed} sleeps where the robot is, since what the reader "
        "sends does not wake it there.",
        changes=tuple(changes),
    )


def _start(case: _Case) -> Advice | None:
    mission = case.setting.mission
    if mission.random_starts or mission.starts:
        return None
    at_start = [
        r.outcome in ("collision", "stuck", "left the room")
        and float(np.hypot(*(r.poses[:, :2] - r.mission.start_m).T).max()) < _AT_START_M
        for r in case.results
    ]
    if case.share(at_start) <= 0.5:
        return None
    clear_m = start_clearance_m(case.setting)
    if clear_m > _CLOSE_M:
        return None
    space = mission_space(case.setting)
    better = free_place_m(space, mission.start_m, clear_m=_AT_START_M)
    return Advice(
        cause="start",
        sentence=f"{case.head}: the robot touches something as soon as it drives, for at start_m "
        f"there are {100.0 * max(clear_m, 0.0):.0f} cm between it and a wall or an object.",
        changes=()
        if better is None
        else (Change(path=("mission", "start_m"), value=better, why="the nearest open floor"),),
    )


def _no_floor(case: _Case) -> Advice | None:
    shadow = shadow_of(case.setting, case.missed)
    if shadow.stands:
        return None
    return Advice(
        cause="no floor",
        sentence=f"{case.head}: the robot cannot stand near tag {case.missed}'s point on the "
        "floor, where something stands already.",
        changes=_moved_tag(case),
    )


def _shadowed(case: _Case) -> Advice | None:
    ends = [r.poses[-1] for r in case.results if r.outcome == "no signal"]
    shadow = shadow_of(case.setting, case.missed, ends)
    if not shadow.bodies:
        return None
    changes = (*_letting_through(case, shadow), *_moved_tag(case))
    return Advice(
        cause="shadowed",
        sentence=f"{case.head}: no wave gets from tag {case.missed} to the robot near it through "
        f"{' and '.join(shadow.bodies)}.",
        changes=changes,
    )


def _letting_through(case: _Case, shadow: Shadow) -> Iterator[Change]:
    """Yield a thickness for each material in the way that has none, and ``transmission``."""
    if not shadow.walls:
        return
    if not case.setting.study.solver.transmission:
        yield Change(
            path=("solver", "transmission"), value=True, why="waves pass what has a thickness"
        )
    for wall in shadow.walls:
        spec = wall.spec
        if isinstance(spec, MaterialTable) and (spec.thickness_m or spec.layers):
            continue
        table = {"name": spec} if isinstance(spec, str) else _given(spec)
        yield Change(
            path=wall.path,
            value={**table, "thickness_m": wall.thickness_m},
            of=wall.of,
            why=wall.why,
        )


def _given(spec: MaterialTable) -> dict[str, Any]:
    keys = ("name", "eps_r", "sigma_s_per_m")
    return {key: getattr(spec, key) for key in keys if getattr(spec, key) is not None}


def _moved_tag(case: _Case) -> tuple[Change, ...]:
    study = case.setting.study
    place, table = next((i, t) for i, t in enumerate(study.tags) if t.id == case.missed)
    better = open_place_m(case.setting, case.missed)
    if better is None:
        return ()
    return (
        Change(
            path=("tag", place, "position_m"),
            value=better,
            of=f'the one with id = "{table.id}"',
            why="or: the nearest place that the robot sees from below",
        ),
    )


def _time_out(case: _Case) -> Advice | None:
    late = [
        m.outcome == "time-out" and not m.captured and _arriving(r)
        for r, m in zip(case.results, case.metrics, strict=True)
    ]
    if case.share(late) <= 0.5:
        return None
    limit_s = max(r.mission.time_limit_s for r in case.results)
    return Advice(
        cause="time-out",
        sentence=f"{case.head}: the time of {limit_s:.0f} s ran out on the way to tag "
        f"{case.missed}.",
        changes=(
            Change(
                path=("mission", "max_time_s"),
                value=float(f"{3.0 * limit_s:.2g}"),
                why="three times as long",
            ),
            *_better_link(case),
        ),
    )


def _arriving(result: MissionResult) -> bool:
    """Return whether a run was on its way: tags reached, or nearer to the tag than at first."""
    target = int(result.targets[-1])
    if np.isfinite(result.arrival_times_s).any():
        return True
    point = result.mission.tag_points_m[target]
    ways_m = np.hypot(*(result.poses[:, :2] - point).T)
    return bool(ways_m[-1] < 0.8 * ways_m[0] and ways_m[-1] <= 1.2 * ways_m.min() + 0.1)


def _wrong_place(case: _Case) -> Advice | None:
    if case.share([m.captured for m in case.metrics]) < 0.5:
        return None
    off_m = [_off_m(r, m) for r, m in zip(case.results, case.metrics, strict=True) if m.captured]
    return Advice(
        cause="wrong place",
        sentence=f"{case.head}: the robot took a wrong place for tag {case.missed}, in "
        f"the median {np.median(off_m):.1f} m from the tag's point{_weakness(case)}.",
        changes=tuple(_better_link(case)),
    )


def _off_m(result: MissionResult, metrics: MissionMetrics) -> float:
    """Return how far from a tag's point a run took it for reached, or was held [m]."""
    if result.outcome == "completed":
        return float(np.nanmax(metrics.arrival_errors_m))
    point = result.mission.tag_points_m[int(result.targets[-1])]
    return float(np.hypot(*(result.poses[-1, :2] - point)))


def _obstacle(case: _Case) -> Advice | None:
    touched = [m.outcome in ("collision", "stuck", "left the room") for m in case.metrics]
    if case.share(touched) < 0.5:
        return None
    what = Counter(m.outcome for m in case.metrics if m.outcome != "time-out").most_common(1)[0][0]
    words = {
        "collision": "ran into something",
        "stuck": "got stuck at something",
        "left the room": "drove out of the room",
    }
    changes = list(_better_link(case))
    if case.setting.mission.contact == "end" and what == "collision":
        changes.append(
            Change(
                path=("mission", "contact"), value="slide", why="it slides along what it touches"
            )
        )
    return Advice(
        cause="obstacle",
        sentence=f"{case.head}: the robot {words.get(what, 'ran into something')} on its way to "
        f"tag {case.missed}{_weakness(case)}.",
        changes=tuple(sorted(changes, key=lambda change: change.path[0] != "mission")),
    )


def _nowhere(case: _Case) -> Advice | None:
    return Advice(
        cause="nowhere",
        sentence=f"{case.head}: most went astray on the way to tag {case.missed}{_weakness(case)}.",
        changes=tuple(_better_link(case)),
    )


def _weakness(case: _Case) -> str:
    """Return what makes readings ambiguous here, as the end of a sentence; else nothing."""
    study = case.setting.study
    weak = []
    if study.mission is not None and study.mission.navigator != ARRIVING_NAVIGATOR:
        weak.append(f"the navigator “{study.mission.navigator}”")
    others = {t.antenna for t in study.tags if t.antenna != ARRIVING_TAG}
    if others & {"dipole", "monopole"} and case.setting.has_room:
        weak.append("tags that send nothing straight down")
    if len(study.radio.frequencies_hz) == 1 and case.setting.has_room:
        weak.append("a single channel")
    if not weak:
        return ""
    listed = weak[0] if len(weak) == 1 else f"{', '.join(weak[:-1])} and {weak[-1]}"
    rest = "reflections pass for the tag" if case.setting.has_room else "the tag is easily lost"
    return f", since {rest} with {listed}"


def _better_link(case: _Case) -> Iterator[Change]:
    """Yield what makes readings tell where a tag is, as far as the study does not have it."""
    study = case.setting.study
    if case.setting.mission.navigator != ARRIVING_NAVIGATOR:
        yield Change(
            path=("mission", "navigator"),
            value=ARRIVING_NAVIGATOR,
            why="estimates the tag's place from all readings",
        )
    if case.setting.has_room and any(t.antenna != ARRIVING_TAG for t in study.tags):
        yield Change(
            path=("tag", None, "antenna"),
            value=ARRIVING_TAG,
            of="in each of them",
            why="its beam is a cone downwards; axis: none, or [0, 0, -1]",
        )
    channels = _channels(study.radio.frequency_hz, len(study.radio.frequencies_hz))
    if case.setting.has_room and channels:
        yield Change(
            path=("radio", "channels_hz"), value=channels, why="averages over fades of one channel"
        )


def _channels(carrier_hz: float, have: int) -> tuple[float, ...]:
    for (low, high), channels in CHANNELS_HZ.items():
        if low <= carrier_hz <= high:
            if have < len(channels):
                return channels
            if have < MANY_CHANNELS:
                spread = np.linspace(channels[0], channels[-1], MANY_CHANNELS)
                return tuple(float(f"{f:.5g}") for f in spread)
    return ()
