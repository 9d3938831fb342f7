"""Runs of a mission to be played back in a page, with what the antennas read and how each ended."""

from collections.abc import Sequence

import numpy as np

from octant.em.decibels import power_dbm
from octant.navigation.missions.metrics import MissionMetrics, measure
from octant.navigation.missions.records import MissionResult
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.map_view import plan_data
from octant.reader_design.showing.page.packing import packed
from octant.reader_design.showing.pages import ReportFigure, ReportWidget
from octant.reader_design.showing.plan import Plan

MOST_RUNS = 24
"""Runs that a page holds [-]: of more, the first ones and those that failed."""
MOST_STEPS = 600
"""Steps of a run that a page holds [-]; of more, every second, third ..."""
_DEPTH_DB = 60.0


def run_end(metrics: MissionMetrics) -> str:
    """Return how a run ended, in a word: "success", "wrong place", or what stopped it.

    Parameters
    ----------
    metrics : Of the run.
    """
    if metrics.success:
        return "success"
    return "wrong place" if metrics.outcome == "completed" else metrics.outcome


def shown_runs(metrics: Sequence[MissionMetrics]) -> list[int]:
    """Return which runs a page holds: the first, then the failed ones, then others.

    Parameters
    ----------
    metrics : Of all runs.
    """
    failed = [i for i, one in enumerate(metrics) if not one.success and i > 0]
    others = [i for i in range(1, len(metrics)) if i not in failed]
    room = MOST_RUNS - 1
    kept = failed[: max(room // 2, room - len(others))]
    return sorted([0, *kept, *others[: room - len(kept)]])


def drive_widget(
    setting: Setting,
    plan: Plan,
    results: Sequence[MissionResult],
    *,
    radius_m: float,
    name: str = "",
    fallback: tuple[ReportFigure, ...] = (),
) -> ReportWidget:
    """Return the runs of a mission as a page plays them [m], [s], [rad], [dBm].

    Parameters
    ----------
    setting, plan, results : The room, how it is drawn, and all runs.
    radius_m : Radius of the robot [m].
    name, fallback : Of the room; what stands there without scripts and on paper.
    """
    metrics = [measure(one) for one in results]
    mission = results[0].mission
    points = mission.tag_points_m
    reached = sum(one.success for one in metrics)
    held = shown_runs(metrics)
    of = f" {len(held)} of {len(results)} runs are held here." if len(held) < len(results) else ""
    return ReportWidget(
        kind="drive",
        title="Playback" if not name else f"Playback, {name}",
        caption="Play a run or drag the time bar; click a way or choose a run to see another. The "
        "wedges are what the antennas read; the sign at the end of a way says how the run ended."
        + of,
        alt=f"Ways of the robot over the floor: {reached} of {len(results)} runs reached "
        "every tag.",
        data={
            "plan": plan_data(plan),
            "tags": [
                {"id": tag, "x": round(float(p[0]), 4), "y": round(float(p[1]), 4)}
                for tag, p in zip(mission.tag_ids, points, strict=True)
            ],
            "way": mission.waypoints_m.round(4).tolist(),
            "azimuths_deg": np.degrees(setting.responses[0].azimuths_rad).round(4).tolist(),
            "radius_m": radius_m,
            "runs": [_run(i, results[i], metrics[i]) for i in held],
        },
        fallback=fallback,
    )


def _run(number: int, result: MissionResult, metrics: MissionMetrics) -> dict[str, object]:
    every = -(-len(result.time_s) // MOST_STEPS)
    some = np.unique(np.append(np.arange(0, len(result.time_s), every), len(result.time_s) - 1))
    level = power_dbm(result.rss_w[some])
    top = float(level.max()) if np.isfinite(level).any() else 0.0
    level = np.where(np.isfinite(level), np.maximum(level, top - _DEPTH_DB), np.nan)
    said = metrics.reason[:1].upper() + metrics.reason[1:]
    return {
        "run": number,
        "end": run_end(metrics),
        "said": said if said.endswith(".") else f"{said}.",
        "t": packed(result.time_s[some], step=0.1, most=65535),
        "x": packed(result.poses[some, 0], step=0.002, most=65535),
        "y": packed(result.poses[some, 1], step=0.002, most=65535),
        "heading": packed(result.poses[some, 2], step=0.001, most=65535),
        "target": packed(result.targets[some], step=1.0),
        "rss": packed(level, step=0.5),
        "arrivals": [
            round(float(e), 4) if np.isfinite(e) else None for e in metrics.arrival_errors_m
        ],
    }
