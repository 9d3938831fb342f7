"""The map explorer of a page: what the reader receives over the floor, for many headings."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.decibels import power_dbm
from octant.navigation.angles import wrap_angle
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.page.packing import packed
from octant.reader_design.showing.pages import ReportFigure, ReportWidget
from octant.reader_design.showing.plan import Plan

FloatArray = npt.NDArray[np.float64]

MOST_CELLS = 5000
"""Places of the floor that an explorer holds [-]; a finer map is thinned out."""
DEPTH_DB = 90.0
"""Levels farther below the greatest one are shown as this far below it [dB]."""
RSS_STEP_DB, MEAN_STEP_DB = 0.5, 1.0
"""Rounding of the levels in a page [dB]."""
_ALIKE = 0.02


@dataclass(frozen=True, slots=True, kw_only=True)
class FloorMaps:
    """Maps over the floor that an explorer shows; all share one grid.

    Attributes
    ----------
    x_m, y_m : (nx,), (ny,) float64 — Grid [m].
    headings_rad : (h,) float64 — Headings of the robot that are held [rad].
    coherent_w, mean_w : (h, tag, nx, ny, n) — RSS, coherent and as power sum [W]; None: no sum.
    standing : (nx, ny) bool — Where the reader fits.
    azimuths_rad : (n,) float64 — Azimuths of the antennas in the reader's frame [rad].
    turn : How many antennas further a turn of the reader is that changes nothing but the antennas'
        numbers; 0: none is [-].
    rms_rad, captured : (tag, nx, ny) — Bearing error over all headings [rad], captured share [-].
    """

    x_m: FloatArray
    y_m: FloatArray
    headings_rad: FloatArray
    coherent_w: npt.NDArray[np.floating[Any]]
    mean_w: npt.NDArray[np.floating[Any]] | None
    standing: npt.NDArray[np.bool_]
    azimuths_rad: FloatArray
    turn: int = 0
    rms_rad: FloatArray | None = None
    captured: FloatArray | None = None


def map_stride(shape: tuple[int, int]) -> int:
    """Return which part of a grid's rows and columns an explorer takes: every stride-th [-].

    Parameters
    ----------
    shape : Places along x and y.
    """
    return max(1, int(np.ceil(np.sqrt(shape[0] * shape[1] / MOST_CELLS))))


def symmetric_turn(response: ReaderResponse) -> int:
    """Return after how many antennas the reader looks the same again; 0: only after all [-].

    Found from the patterns themselves: turned by that many antenna spacings, each antenna's pattern
    must be that of the antenna there, within 2 % of the greatest field.

    Parameters
    ----------
    response : The reader's.
    """
    n = response.antennas
    theta, phi = np.meshgrid(
        np.radians([35.0, 60.0, 80.0]), np.radians(np.arange(0.0, 360.0, 15.0))
    )
    field = response.far_field(theta, phi)
    most = float(np.abs(field).max())
    for turn in range(1, n):
        if n % turn:
            continue
        step_rad = 2.0 * np.pi * turn / n
        spacings = np.roll(response.azimuths_rad, -turn) - response.azimuths_rad
        if np.abs(wrap_angle(spacings - step_rad)).max() > 1e-6:
            continue
        turned = np.roll(response.far_field(theta, (phi + step_rad) % (2.0 * np.pi)), -turn, axis=0)
        if np.abs(turned - field).max() <= _ALIKE * most:
            return turn
    return 0


def explorer_headings_rad(
    headings_rad: FloatArray, first_rad: float, n: int, turn: int
) -> FloatArray:
    """Return headings to hold, of those that are computed; turns give the others [rad].

    Parameters
    ----------
    headings_rad, first_rad : (h,) float64 — Computed headings; that which must be among them [rad].
    n, turn : Number of antennas; from `symmetric_turn`.
    """
    wanted = [0.0, np.pi * turn / n] if turn else [0.0, 0.5 * np.pi, np.pi, 1.5 * np.pi]
    found: list[float] = []
    for angle in np.add(wanted, first_rad):
        off = np.abs(wrap_angle(headings_rad - angle))
        nearest = float(headings_rad[int(off.argmin())])
        if nearest not in found:
            found.append(nearest)
    return np.array(found)


def map_widget(
    maps: FloorMaps,
    setting: Setting,
    plan: Plan,
    *,
    tags: Sequence[str],
    tag: int = 0,
    fallback: tuple[ReportFigure, ...] = (),
) -> ReportWidget:
    """Return the explorer of maps [dBm], [deg], [%].

    Parameters
    ----------
    maps, setting, plan : What is shown; the room, and how it is drawn.
    tags, tag : Tags of the maps, in their order; which is shown first.
    fallback : What stands there without scripts and on paper.
    """
    every = map_stride(maps.standing.shape)
    some = np.s_[::every, ::every]
    standing = maps.standing[some]
    places = {one.id: one.point_m for one in setting.tags}
    x, y = maps.x_m[::every], maps.y_m[::every]
    coherent = _levels(maps.coherent_w, every, standing)
    finite = coherent[np.isfinite(coherent)]
    top = float(finite.max()) if finite.size else 0.0
    low = float(np.quantile(finite, 0.02)) if finite.size else -100.0
    usable = float(np.round(setting.usable_dbm))
    ends = [float(np.floor(low / 5.0) * 5.0), float(np.ceil(top / 5.0) * 5.0)]
    data: dict[str, object] = {
        "grid": {
            "x0": float(x[0]),
            "dx": _step(x),
            "nx": len(x),
            "y0": float(y[0]),
            "dy": _step(y),
            "ny": len(y),
        },
        "tags": [
            {"id": name, "x": float(places[name][0]), "y": float(places[name][1])} for name in tags
        ],
        "tag": tag,
        "azimuths_deg": np.degrees(maps.azimuths_rad).round(4).tolist(),
        "headings_deg": (np.degrees(maps.headings_rad).round(4) % 360.0).tolist(),
        "turn": {
            "step_deg": 360.0 * maps.turn / len(maps.azimuths_rad),
            "shift": maps.turn,
        }
        if maps.turn
        else None,
        "threshold_dbm": usable if ends[0] < usable < ends[1] else float(np.round(np.mean(ends))),
        "range_dbm": ends,
        "coherent": packed(coherent, step=RSS_STEP_DB),
        "plan": plan_data(plan),
    }
    if maps.mean_w is not None:
        data["mean"] = packed(_levels(maps.mean_w, every, standing), step=MEAN_STEP_DB)
    for name, values, scale in (
        ("rms", maps.rms_rad, np.degrees(1.0)),
        ("captured", maps.captured, 100.0),
    ):
        if values is not None:
            thinned = np.where(standing, scale * values[:, ::every, ::every], np.nan)
            data[name] = packed(np.swapaxes(thinned, 1, 2), step=1.0)
    seen = finite >= usable
    share = 100.0 * float(seen.mean()) if finite.size else 0.0
    turned = " The robot can be turned, since the maps of other headings are held, too."
    return ReportWidget(
        kind="map",
        title="Map explorer",
        caption="Choose a tag, what to show and a threshold. Point at the map to read values; "
        "click a place, or move there with the arrow keys, to see what each antenna receives."
        + (turned if maps.turn or len(maps.headings_rad) > 1 else "")
        + f" Levels are rounded to {RSS_STEP_DB:g} dB here"
        + (f", and every {_ordinal(every)} place of the map is held." if every > 1 else "."),
        alt=f"Maps of the power over the floor: {share:.0f} % of the readings of single antennas "
        f"are above {usable:g} dBm.",
        data=data,
        fallback=fallback,
    )


def plan_data(plan: Plan) -> Mapping[str, object]:
    """Return a room seen from above as a page draws it [m].

    Parameters
    ----------
    plan : Walls and objects.
    """
    bounds = plan.bounds_m if np.ptp(plan.bounds_m) > 0.0 else np.array([[-1.0, -1.0], [1.0, 1.0]])
    return {
        "cuts": plan.cuts_m.reshape(-1, 4).round(3).tolist(),
        "solids": plan.solids_m.reshape(-1, 6).round(3).tolist(),
        "bounds": bounds.round(3).tolist(),
    }


def _levels(
    power_w: npt.NDArray[np.floating[Any]], every: int, standing: npt.NDArray[np.bool_]
) -> FloatArray:
    """Return levels by heading, tag, y, x and antenna [dBm]; NaN where the reader does not fit."""
    thinned = power_w[:, :, ::every, ::every].astype(np.float64)
    level = power_dbm(thinned)
    top = float(level.max()) if level.size else 0.0
    level = np.maximum(level, top - DEPTH_DB)
    level = np.where(standing[:, :, None] & (thinned > 0.0), level, np.nan)
    return np.swapaxes(level, 2, 3)


def _step(axis: FloatArray) -> float:
    return float(axis[1] - axis[0]) if len(axis) > 1 else 1.0


def _ordinal(number: int) -> str:
    return {2: "second", 3: "third"}.get(number, f"{number}th")
