"""What runs of a mission could know by a distance-RSS map: earlier orientations, and their place.

Thesis 5.2.2.1 propagates the orientation error back, given such a map, and 5.4.3 compares errors of
navigation with those of localisation. Both are computed here along the ways that were driven.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.navigation.angles import wrap_angle
from octant.navigation.csv_files import number_text, write_csv
from octant.navigation.estimators.place_fix import place_by_bearings, place_by_distances
from octant.navigation.missions.metrics import measure, percentile_curve, root_mean_square
from octant.navigation.missions.records import MissionResult
from octant.navigation.sensing.bearing import room_azimuth, vector_sum_bearing
from octant.navigation.sensing.distance_map import (
    DistanceMap,
    distance_map,
    propagated_error_rad,
)
from octant.navigation.sensing.sensor import RssSensor
from octant.reader_design.experiments.missions.compute import MissionRuns
from octant.reader_design.keeping.keeper import RecordCodec, map_cases
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.workers import Crew
from octant.reader_design.setting.links import mission_reach_m
from octant.reader_design.showing.style import figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

PUBLISHED_M = (0.30, 0.40)
"""Localisation error of the literature that thesis 5.4.3 quotes [m]."""
LOCALISATION_COLUMNS = ("run", "method", "rms_m", "median_m", "p90_m", "found_share")
ORIENTATION_COLUMNS = (
    "t_s",
    "tag",
    "distance_m",
    "mapped_m",
    "error_deg",
    "propagated_deg",
)
BY_DISTANCES, BY_BEARINGS = "distance-RSS map", "bearings"
_STREAM = 9


@dataclass(frozen=True, slots=True, kw_only=True)
class LocaliseCase:
    """One run to be judged.

    Attributes
    ----------
    sensor, maps, result : What the robot reads; map of each tag of the mission; its run.
    seed : Of the readings' errors.
    """

    sensor: RssSensor
    maps: tuple[DistanceMap, ...]
    result: MissionResult
    seed: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Localised:
    """What one run could know; one row a sample.

    Attributes
    ----------
    by_distances_m, by_bearings_m : (s,) float64 — Errors of the robot's place [m], or NaN.
    distance_m, mapped_m : (s,) float64 — To the tag in force along the floor; by the map [m].
    error_rad, propagated_rad : (s,) float64 — Angle from the move that begins then to the tag, and
        the same as found after it [rad], or NaN.
    """

    by_distances_m: FloatArray
    by_bearings_m: FloatArray
    distance_m: FloatArray
    mapped_m: FloatArray
    error_rad: FloatArray
    propagated_rad: FloatArray


def localised(_context: None, case: LocaliseCase) -> Localised:
    """Return what a run could know, from the readings it took and from some of all tags [m], [rad].

    Parameters
    ----------
    case : The run. The robot stands still for the readings of all tags; heading and odometry are
        exact.
    """
    result, mission = case.result, case.result.mission
    azimuths, rng = case.sensor.azimuths_rad, np.random.default_rng([case.seed, _STREAM])
    tags = dict(zip(mission.tag_ids, mission.tag_points_m, strict=True))
    places_m = np.array(list(tags.values()))
    maps = dict(zip(mission.tag_ids, case.maps, strict=True))
    found = np.empty((len(result.poses), 2, 2))
    for k, pose in enumerate(result.poses):
        rss = np.array([case.sensor.read(pose, tag_id, rng) for tag_id in tags])
        reach = np.array([maps[t].distance_m(z) for t, z in zip(tags, rss, strict=True)])
        seen = room_azimuth(pose[2], vector_sum_bearing(rss, azimuths))
        found[k, 0] = place_by_distances(reach, places_m)
        found[k, 1] = place_by_bearings(seen, places_m)
    away = np.linalg.norm(found - result.poses[:, None, :2], axis=2)
    return Localised(by_distances_m=away[:, 0], by_bearings_m=away[:, 1], **_moves(case))


def _moves(case: LocaliseCase) -> Mapping[str, FloatArray]:
    result = case.result
    goal = result.mission.tag_points_m[result.targets] - result.poses[:, :2]
    distance = np.linalg.norm(goal, axis=1)
    pairs = zip(result.targets, result.rss_w, strict=True)
    mapped = np.array([float(case.maps[t].distance_m(rss)) for t, rss in pairs])
    seen = room_azimuth(
        result.poses[:, 2], vector_sum_bearing(result.rss_w, case.sensor.azimuths_rad)
    )
    step = np.diff(result.poses[:, :2], axis=0)
    way = np.arctan2(step[:, 1], step[:, 0])
    straight = (np.linalg.norm(step, axis=1) > 0.0) & (np.diff(result.targets) == 0)
    error, found = (np.full(len(distance), np.nan) for _ in range(2))
    truth = wrap_angle(np.arctan2(goal[:-1, 1], goal[:-1, 0]) - way)
    error[:-1] = np.where(straight, truth, np.nan)
    back = propagated_error_rad(mapped[:-1], mapped[1:], wrap_angle(seen[1:] - way))
    found[:-1] = np.where(straight, back, np.nan)
    return {
        "distance_m": distance,
        "mapped_m": mapped,
        "error_rad": error,
        "propagated_rad": found,
    }


def localise_runs(
    runs: Sequence[MissionRuns],
    results: Sequence[MissionResult],
    *,
    folder: Path,
    crew: Crew | None = None,
    progress: Progress | None = None,
) -> tuple[Localised, ...]:
    """Return what every run could know; those that the folder holds are read ([m], [rad]).

    Parameters
    ----------
    runs, results : From `mission_runs` and `drive`, in one order.
    folder, crew, progress : As for `drive`.
    """
    cases, left = [], iter(results)
    for one in runs:
        setting = one.setting
        maps = tuple(
            distance_map(setting.open_link(setting.tag(tag_id)), reach_m=mission_reach_m(setting))
            for tag_id in one.job.mission.tag_ids
        )
        cases += [
            LocaliseCase(sensor=one.job.sensor, maps=maps, result=next(left), seed=one.seed + run)
            for run in range(one.runs)
        ]
    kept = map_cases(
        localised,
        cases,
        context=None,
        folder=folder,
        codec=RecordCodec(Localised),
        crew=crew,
        progress=progress,
        label="runs localised",
    )
    return tuple(one.value for one in kept)


def methods_of(found: Localised) -> Mapping[str, FloatArray]:
    """Return the errors of place (s,) by method [m].

    Parameters
    ----------
    found : One run.
    """
    return {BY_DISTANCES: found.by_distances_m, BY_BEARINGS: found.by_bearings_m}


def localisation_lines(
    found: Sequence[Localised], results: Sequence[MissionResult]
) -> Iterator[str]:
    """Yield how well runs could be localised, beside how well they were navigated [m].

    Parameters
    ----------
    found, results : All runs.
    """
    for method in methods_of(found[0]):
        errors = np.concatenate([methods_of(one)[method] for one in found])
        known = errors[np.isfinite(errors)]
        text = "nowhere" if not known.size else f"{np.median(known):.3f} m off in the median"
        share = known.size / errors.size
        yield f"Localisation by {method}: {text}, found at {100 * share:.0f} % of the places."
    driven = float(np.median([measure(result).rmse_m for result in results]))
    yield (
        f"The same runs kept to their way within {driven:.3f} m RMSE (thesis 5.4.3: localisation "
        "in the literature 0.30 to 0.40 m, navigation 0.09 to 0.20 m)."
    )


def write_localisation(
    found: Sequence[Localised], results: Sequence[MissionResult], out: Path
) -> list[Path]:
    """Return localisation.csv of all runs, and orientation.csv of run 0, once written [m], [deg].

    Parameters
    ----------
    found, results, out : All runs; folder of the results.
    """
    rows = []
    for run, one in enumerate(found):
        for method, errors in methods_of(one).items():
            known = errors[np.isfinite(errors)]
            numbers = [np.nan] * 3
            if known.size:
                numbers = [root_mean_square(known), *map(float, np.percentile(known, (50.0, 90.0)))]
            cells = [number_text(v) for v in (*numbers, known.size / errors.size)]
            rows.append((run, method, *cells))
    first, result = found[0], results[0]
    places, moves = out / "localisation.csv", out / "orientation.csv"
    write_csv(places, LOCALISATION_COLUMNS, rows)
    columns = np.column_stack(
        [
            first.distance_m,
            first.mapped_m,
            np.degrees(first.error_rad),
            np.degrees(first.propagated_rad),
        ]
    )
    lines = (
        (number_text(t), result.mission.tag_ids[target], *(number_text(v) for v in row))
        for t, target, row in zip(result.time_s, result.targets, columns, strict=True)
    )
    write_csv(moves, ORIENTATION_COLUMNS, lines)
    return [places, moves]


def localisation_figure(
    found: Sequence[Localised], results: Sequence[MissionResult], *, title: str
) -> "Figure":
    """Return errors of place [m] by percentile, navigated and localised, thesis 5.4.3.

    Parameters
    ----------
    found, results, title : All runs; text above.
    """
    share = np.linspace(0.0, 100.0, 201)
    driven = np.concatenate([measure(result).position_errors_m for result in results])
    curves = {"navigation: off the way": driven}
    for method in methods_of(found[0]):
        errors = np.concatenate([methods_of(one)[method] for one in found])
        curves[f"localisation by {method}"] = errors[np.isfinite(errors)]
    with figure_style():
        figure, axes = new_figure(width_in=6.4, height_in=3.8, title=title)
        ax = axes[0, 0]
        for (name, errors), dash in zip(curves.items(), ("-", "--", "-."), strict=True):
            if errors.size:
                ax.plot(*percentile_curve(errors, share), dash, label=name)
        ax.axhspan(*PUBLISHED_M, color="#bbbbbb", alpha=0.5, label="literature, as quoted in 5.4.3")
        ax.set_yscale("log")
        ax.set_ylim(0.005, 10.0)
        ax.set_xlim(0.0, 100.0)
        ax.set_xlabel("percentile of the time [%]")
        ax.set_ylabel("error of the place [m]")
        ax.legend(fontsize=8)
    return figure


def orientation_figure(found: Localised, result: MissionResult, *, title: str) -> "Figure":
    """Return the map's distances [m] and the orientation error propagated back [°], Fig. 5.2.

    Parameters
    ----------
    found, result, title : Run 0; text above.
    """
    with figure_style():
        figure, axes = new_figure(width_in=10.0, height_in=3.8, title=title, columns=2)
        left, right = axes[0]
        reach = float(found.distance_m.max())
        left.plot([0.0, reach], [0.0, reach], color="#999999", linewidth=1.0, label="equal")
        left.plot(found.distance_m, found.mapped_m, "o", markersize=3, label="readings of run 0")
        left.set_xlabel("distance from the tag's point [m]")
        left.set_ylabel("distance by the map [m]")
        left.legend()
        right.plot(result.time_s, np.degrees(found.error_rad), label="error of the move")
        right.plot(
            result.time_s,
            np.degrees(found.propagated_rad),
            "o",
            markersize=3,
            label="propagated back after it",
        )
        right.set_xlabel("time [s]")
        right.set_ylabel("direction of the tag from the move's [°]")
        right.set_ylim(-90.0, 90.0)
        right.legend()
    return figure
