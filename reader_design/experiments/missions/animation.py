"""One run as a moving picture: robot and antennas, the field under them, RSS of all antennas."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.geometries.files import whole_file
from octant.navigation.missions.records import MissionResult
from octant.navigation.sensing.bearing import room_azimuth, vector_sum_bearing
from octant.reader_design.experiments.missions.drive_figures import PATH_COLOUR, Drive
from octant.reader_design.setting.samples import standing_room
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.plan import Plan, draw_plan, draw_tags, plan_of
from octant.reader_design.showing.style import ANTENNA_COLOURS, draw_antennas, figure_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from PIL.Image import Image

FloatArray = npt.NDArray[np.float64]


MOST_FRAMES = 120
"""Frames of an animation at most [-]; longer runs leave samples out."""
SPAN_DB = 50.0
"""Range of RSS that is shown below the greatest value [dB]."""

_DOTS_PER_INCH = 80
_COLOURS = 64
_FRAME_MS = 120
_LAST_FRAME_MS = 2500
_SCALE = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldMap:
    """The field of every tag that is visited.

    Attributes
    ----------
    x_m, y_m : (nx,), (ny,) float64 — Grid [m].
    rss_dbm : (k, ny, nx) float64 — Strongest RSS by tag visited [dBm]; NaN where no robot fits.
    """

    x_m: FloatArray
    y_m: FloatArray
    rss_dbm: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenery:
    """What an animation shows besides the run.

    Attributes
    ----------
    plan, tags, field : Walls and objects; points to visit, in order [m]; floor's RSS [dBm].
    azimuths_rad : (n,) float64 — Of the antennas in the reader frame, whose front is at 90° [rad].
    antenna_radius_m : Their distance from the reader's axis [m].
    """

    plan: Plan
    tags: Mapping[str, FloatArray]
    field: FieldMap
    azimuths_rad: FloatArray
    antenna_radius_m: float


def frame_samples(samples: int, *, most: int = MOST_FRAMES) -> npt.NDArray[np.int64]:
    """Return the (f,) samples of a run that become frames, equally spaced, with first and last [-].

    Parameters
    ----------
    samples, most : Number of samples of the run, at least 1, and of frames at most.
    """
    if samples <= most:
        return np.arange(samples)
    return np.unique(np.round(np.linspace(0, samples - 1, most)).astype(np.int64))


def drive_frames(
    drive: Drive, scenery: Scenery, *, title: str, samples: Sequence[int] | None = None
) -> "Iterator[Image]":
    """Yield the frames of a run as pictures; the panels have axes in [m], [dBm] and [s].

    Left the floor with the field of the tag in force, way, robot (drawn larger), strongest antenna,
    vector-sum bearing and, as a diamond, where the navigator believes the tag; right every
    antenna's RSS.

    Parameters
    ----------
    drive, scenery, title : The run, where it took place, text above.
    samples : Samples to draw; default: those of `frame_samples`.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from PIL import Image

    with figure_style():
        figure = Figure(figsize=(10.0, 5.2), dpi=_DOTS_PER_INCH, layout="constrained")
        canvas: Any = FigureCanvasAgg(figure)
        figure.suptitle(title, x=0.012, ha="left", fontsize=11, fontweight="bold")
        grid = figure.add_gridspec(2, 2, width_ratios=(1.25, 1.0))
        floor = _FloorPanel(figure.add_subplot(grid[:, 0]), drive, scenery)
        bars = _BarPanel(figure.add_subplot(grid[0, 1]), drive)
        course = _CoursePanel(figure.add_subplot(grid[1, 1]), drive)
        chosen = frame_samples(len(drive.time_s)) if samples is None else samples
        for k in chosen:
            for panel in (floor, bars, course):
                panel.show(int(k))
            canvas.draw()
            if k == chosen[0]:
                figure.set_layout_engine("none")  # panels must not move from frame to frame
            yield Image.fromarray(np.asarray(canvas.buffer_rgba())[:, :, :3].copy())


def write_gif(path: Path, frames: "Iterator[Image]") -> int:
    """Return the number of frames written; the file is written whole or not at all.

    Parameters
    ----------
    path, frames : A ``.gif``; at least one frame, all in the colours of the middle one.
    """
    from PIL.Image import Dither

    pictures = list(frames)
    palette = pictures[len(pictures) // 2].quantize(_COLOURS, dither=Dither.NONE)
    small = [picture.quantize(palette=palette, dither=Dither.NONE) for picture in pictures]
    times = [_FRAME_MS] * (len(small) - 1) + [_LAST_FRAME_MS]
    with whole_file(path) as part:
        small[0].save(
            part, format="GIF", save_all=True, append_images=small[1:], duration=times, loop=0
        )
    return len(small)


def levels_dbm(rss_w: FloatArray) -> FloatArray:
    """Return RSS [dBm], raised to `SPAN_DB` below the greatest; not finite if all of it is zero.

    Parameters
    ----------
    rss_w : (...) float64 — RSS [W]; 0 where nothing is received.
    """
    level = power_dbm(np.maximum(rss_w, 0.0))
    finite = level[np.isfinite(level)]
    top = float(finite.max()) if finite.size else 0.0
    return np.asarray(np.maximum(level, top - SPAN_DB))


class _FloorPanel:
    """Floor plan, field, way and robot."""

    def __init__(self, axes: "Axes", drive: Drive, scenery: Scenery) -> None:
        from matplotlib.patches import Circle

        self._drive, self._scenery = drive, scenery
        field = scenery.field
        low, high = np.nanpercentile(field.rss_dbm, [5.0, 99.5])
        mesh: Any = axes.pcolormesh(
            field.x_m,
            field.y_m,
            field.rss_dbm[0],
            shading="nearest",
            cmap="Blues",
            vmin=low,
            vmax=high,
        )
        self._field = mesh
        axes.grid(visible=False)
        bar = axes.figure.colorbar(mesh, ax=axes, shrink=0.75, label="RSS, strongest antenna [dBm]")
        bar.outline.set_visible(False)
        points = np.array(list(scenery.tags.values())).reshape(-1, 2)
        corners = np.array([[field.x_m[0], field.y_m[0]], [field.x_m[-1], field.y_m[-1]]])
        draw_plan(axes, scenery.plan, extra_m=corners)
        draw_tags(axes, scenery.tags)
        wanted = np.concatenate([drive.path_m[:1], points])
        axes.plot(*wanted.T, "--", color="#555555", linewidth=1.0)
        (self._way,) = axes.plot([], [], color=PATH_COLOUR, linewidth=1.8)
        radius = _SCALE * scenery.antenna_radius_m
        self._body = Circle((0.0, 0.0), 1.35 * radius, facecolor="white", edgecolor="black")
        self._body.set_zorder(8.0)
        axes.add_patch(self._body)
        self._antennas: Any = axes.scatter(
            np.zeros(len(scenery.azimuths_rad)), np.zeros(len(scenery.azimuths_rad)), s=9, zorder=9
        )
        (self._front,) = axes.plot([], [], color="black", linewidth=1.6, zorder=8.5)
        (self._bearing,) = axes.plot([], [], color="#cc3311", linewidth=1.4, zorder=7.5)
        (self._believed,) = axes.plot(
            [], [], "D", color="#ddaa33", markeredgecolor="black", markersize=8, zorder=10
        )
        self._axes = axes

    def show(self, k: int) -> None:
        drive, scenery = self._drive, self._scenery
        here, heading = drive.path_m[k], float(drive.heading_rad[k])
        target = int(drive.target[k])
        self._field.set_array(scenery.field.rss_dbm[target])
        self._way.set_data(*drive.path_m[: k + 1].T)
        self._body.center = (float(here[0]), float(here[1]))
        radius = _SCALE * scenery.antenna_radius_m
        angle = room_azimuth(heading, scenery.azimuths_rad)
        around = here + radius * np.column_stack((np.cos(angle), np.sin(angle)))
        self._antennas.set_offsets(around)
        rss = drive.rss_w[k]
        strongest = int(np.argmax(rss)) if float(rss.max()) > 0.0 else -1
        self._antennas.set_facecolors(
            ["#cc3311" if i == strongest else "#888888" for i in range(len(rss))]
        )
        self._antennas.set_sizes([40.0 if i == strongest else 9.0 for i in range(len(rss))])
        front = here + 1.35 * radius * np.array([np.cos(heading), np.sin(heading)])
        self._front.set_data(*np.array([here, front]).T)
        if drive.believed_m is not None:
            self._believed.set_data(*drive.believed_m[k : k + 1].T)
        self._bearing.set_data([], [])
        if strongest >= 0:
            bearing = room_azimuth(heading, vector_sum_bearing(rss, scenery.azimuths_rad))
            end = here + 4.0 * radius * np.array([np.cos(bearing), np.sin(bearing)])
            self._bearing.set_data(*np.array([here, end]).T)
        self._axes.set_title(
            f"t = {drive.time_s[k]:.0f} s, to {list(scenery.tags)[target]}; "
            f"error {100.0 * drive.position_error_m[k]:.0f} cm",
            fontsize=10,
        )


class _BarPanel:
    """RSS of every antenna now, as bars."""

    def __init__(self, axes: "Axes", drive: Drive) -> None:
        self._level = levels_dbm(drive.rss_w)
        count = self._level.shape[1]
        self._floor = float(self._level.max()) - SPAN_DB
        colours = [ANTENNA_COLOURS[i % len(ANTENNA_COLOURS)] for i in range(count)]
        self._bars = axes.bar(
            np.arange(1, count + 1),
            np.zeros(count),
            bottom=self._floor,
            color=colours,
            edgecolor="#cc3311",
        )
        axes.set_ylim(self._floor, self._floor + SPAN_DB + 3.0)
        axes.set_xticks(np.arange(1, count + 1))
        axes.set_xlabel("antenna")
        axes.set_ylabel("RSS now [dBm]")

    def show(self, k: int) -> None:
        level = self._level[k]
        for i, bar in enumerate(self._bars):
            bar.set_height(float(level[i]) - self._floor)
            bar.set_linewidth(2.5 if i == int(np.argmax(level)) else 0.0)


class _CoursePanel:
    """RSS of all antennas over time, up to now."""

    def __init__(self, axes: "Axes", drive: Drive) -> None:
        self._time_s, self._level = drive.time_s, levels_dbm(drive.rss_w)
        draw_antennas(axes, drive.time_s, self._level)
        self._lines = list(axes.get_lines())
        top = float(self._level.max())
        axes.set_ylim(top - SPAN_DB, top + 3.0)
        axes.set_xlim(float(drive.time_s[0]), max(float(drive.time_s[-1]), 1e-9))
        for start in np.flatnonzero(np.diff(drive.target)) + 1:
            axes.axvline(drive.time_s[start], color="#555555", linewidth=0.9, linestyle=":")
        axes.set_xlabel("time [s]")
        axes.set_ylabel("RSS [dBm]")

    def show(self, k: int) -> None:
        for i, line in enumerate(self._lines):
            line.set_data(self._time_s[: k + 1], self._level[: k + 1, i])


SPACING_M = 0.1
"""Distance of neighbouring points of the field under an animation [m]."""

_CLEARANCE_M = 0.03
_AROUND_M = 0.7


def run_scenery(
    setting: Setting,
    result: MissionResult,
    *,
    spacing_m: float = SPACING_M,
) -> Scenery:
    """Return what an animation of a run shows; the field [dBm] is that of a robot heading along +y.

    Parameters
    ----------
    setting, result : The reader in its room; the run.
    spacing_m : Distance of neighbouring points of the field [m].
    """
    mission = result.mission
    points = dict(zip(mission.tag_ids, mission.tag_points_m, strict=True))
    low, high = _extent_m(setting, np.vstack([mission.tag_points_m, result.poses[:, :2]]))
    x_m, y_m = (
        np.arange(a, b + 0.5 * spacing_m, spacing_m) for a, b in zip(low, high, strict=True)
    )
    x, y = np.meshgrid(x_m, y_m)
    places = np.column_stack([x.ravel(), y.ravel()])
    open_floor = standing_room(
        setting.scene, places, reader_z_m=setting.reader_z_m, clearance_m=_CLEARANCE_M
    )
    poses = np.column_stack([places, np.full(len(places), 0.5 * np.pi)])[open_floor]
    fields: dict[str, FloatArray] = {}
    for tag_id in points:
        level = np.full(len(places), np.nan)
        rss_w = setting.link(setting.tag(tag_id), places_m=poses[:, :2]).rss_w(poses)
        level[open_floor] = power_dbm(rss_w.max(axis=1))
        fields[tag_id] = np.where(np.isfinite(level), level, np.nan).reshape(x.shape)
    return Scenery(
        plan=plan_of(setting.scene, setting.reader_z_m),
        tags=points,
        field=FieldMap(
            x_m=x_m, y_m=y_m, rss_dbm=np.stack([fields[tag_id] for tag_id in mission.tag_ids])
        ),
        azimuths_rad=setting.responses[0].azimuths_rad,
        antenna_radius_m=setting.reader.antenna_radius_m,
    )


def _extent_m(setting: Setting, way_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    if setting.scene.has_room:
        low, high = setting.scene.bounds_m[:, :2]
        return np.asarray(low), np.asarray(high)
    return way_m.min(axis=0) - _AROUND_M, way_m.max(axis=0) + _AROUND_M
