"""Which figures a study leaves, with the sentence that says what to see in each."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.navigation.angles import wrap_angle
from octant.reader_design.experiments.missions.drive_figures import (
    Drive,
    percentile_figure,
    rss_time_figure,
    trajectory_figure,
)
from octant.reader_design.experiments.missions.figures import controller_figure
from octant.reader_design.experiments.missions.stage import RoomMission
from octant.reader_design.experiments.study.reader_plots import (
    ErrorCurve,
    bearing_error_figure,
    error_distribution_figure,
    rss_azimuth_figure,
)
from octant.reader_design.experiments.study.sweep_plots import DistancePanel, rss_distance_figure
from octant.reader_design.setting.bearing_errors import vector_errors_rad
from octant.reader_design.setting.evaluation import Cell
from octant.reader_design.setting.measures import strongest_errors_rad
from octant.reader_design.setting.receiver import scoring_readings_w
from octant.reader_design.setting.samples import grid_azimuths_rad
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.plan import MapPanel, Plan, map_figure, plan_of
from octant.reader_design.showing.scene_picture import scene_figure
from octant.reader_design.showing.style import NamedFigure
from octant.reader_design.study_file.schema import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

MOST_PANELS = 12
"""Panels or maps that one figure shows at most [-]."""
_DRAWN = (
    "x", "y", "standing", "rss_w", "local_mean_rss_w", "vector_error", "strongest_error",
    "captured_share",
)  # fmt: skip
"""Arrays of a room's maps that are drawn."""
RoomSamples = tuple[FloatArray, FloatArray]
"""Azimuths [rad], and the RSS by place and tag, azimuth and antenna [W]."""
AZIMUTH_DISTANCE_M = 2.0
"""Distance at which the patterns over azimuth are shown [m]; the nearest sampled one is taken."""


def pattern_figures(cell: Cell, elements_rad: FloatArray) -> Iterator[NamedFigure]:
    """Yield the patterns of the chosen reader and its RSS over distance [dBm].

    Parameters
    ----------
    cell : The reader's cell.
    elements_rad : (n,) float64 — Azimuths of its antennas [rad].
    """
    azimuths = grid_azimuths_rad(1, cell.free_rss_w.shape[1])
    nearest = int(np.argmin(np.abs(cell.distances_m - AZIMUTH_DISTANCE_M)))
    yield NamedFigure(
        file="rss_azimuth.png",
        section="reader",
        title="Patterns of the chosen reader",
        caption="RSS of each antenna in free space while the tag goes round the reader; the "
        "antenna whose azimuth the tag crosses should be the strongest.",
        figure=rss_azimuth_figure(
            azimuths,
            cell.free_rss_w[nearest],
            elements_rad,
            distance_m=float(cell.distances_m[nearest]),
            title=f"Patterns of the chosen reader: {cell.label}",
        ),
    )
    yield NamedFigure(
        file="rss_distance.png",
        section="reader",
        title="RSS of the chosen reader against distance",
        caption="RSS of all antennas in free space on the way out from under the tag, antenna 1 "
        "towards it: weak right under the tag, greatest some way off, then falling with distance.",
        figure=rss_distance_figure(
            cell.travel_m,
            [DistancePanel(title="free space", rss_w=cell.travel_rss_w)],
            columns=1,
            title=f"RSS against distance: {cell.label}",
        ),
    )


def room_samples(room_map: "xr.Dataset") -> RoomSamples | None:
    """Return the samples of a room that its maps hold ([rad], [W]); None in free space.

    Parameters
    ----------
    room_map : The maps.
    """
    if "sample_rss_w" not in room_map:
        return None
    azimuths = np.radians(room_map["sample_azimuth"].values)
    return azimuths, room_map["sample_rss_w"].values.astype(np.float64)


def error_figures(
    study: Study, cell: Cell, elements_rad: FloatArray, in_room: RoomSamples | None
) -> Iterator[NamedFigure]:
    """Yield the bearing errors of the chosen reader [deg].

    Parameters
    ----------
    study, cell, in_room : Gives the receiver; the reader's cell; none of free space.
    elements_rad : (n,) float64 — Azimuths of its antennas [rad].
    """
    azimuths = grid_azimuths_rad(1, cell.free_rss_w.shape[1])
    surroundings = [("free space, all distances", azimuths, cell.free_rss_w)]
    if in_room is not None:
        surroundings.append(("in the room, all places and tags", *in_room))
    yield NamedFigure(
        file="bearing_error.png",
        section="reader",
        title="Bearing error against azimuth",
        caption="Median (line) and the range from 10 % to 90 % (band) of the absolute bearing "
        "error by the strongest antenna and by the vector sum of all; even an ideal reader of n "
        "antennas errs by 180°/n half-way between two of them if it takes the strongest.",
        figure=bearing_error_figure(
            surroundings, elements_rad, title=f"Bearing error: {cell.label}"
        ),
    )
    panels = []
    for name, angles, rss in surroundings:
        read = scoring_readings_w(study, rss)
        curves = [
            ErrorCurve(
                label="strongest antenna",
                error_rad=strongest_errors_rad(rss, angles, elements_rad)[0],
                weight=strongest_errors_rad(rss, angles, elements_rad)[1],
            ),
            ErrorCurve(
                label="strongest antenna, as read",
                error_rad=strongest_errors_rad(read, angles, elements_rad)[0],
                weight=strongest_errors_rad(read, angles, elements_rad)[1],
            ),
            ErrorCurve(label="vector sum", error_rad=vector_errors_rad(rss, angles, elements_rad)),
            ErrorCurve(
                label="vector sum, as read",
                error_rad=vector_errors_rad(read, angles, elements_rad),
            ),
        ]
        panels.append((name, curves))
    yield NamedFigure(
        file="error_distribution.png",
        section="reader",
        title="Distribution of the bearing error",
        caption="Share of places and headings at which the bearing errs by no more than the "
        f"abscissa, exact and as read with {study.scoring.noise_db:g} dB error and "
        f"{study.scoring.bits} bits; dotted lines mark median, 90 %, 45° and 90°.",
        figure=error_distribution_figure(
            panels, title=f"Distribution of the bearing error: {cell.label}"
        ),
    )


def scene_figures(setting: Setting) -> Iterator[NamedFigure]:
    """Yield the picture of the room in three dimensions [m]; none of free space.

    Parameters
    ----------
    setting : The room with its tags.
    """
    if not setting.scene.bodies:
        return
    yield NamedFigure(
        file="room.png",
        section="scene",
        title="The room",
        caption="The room with its tags; walls between the viewer and the room are cut away.",
        figure=scene_figure(
            setting.scene,
            title=setting.name,
            tags={tag.id: tag.position_m for tag in setting.tags},
        ),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class FloorData:
    """What the maps of a room are drawn from.

    Attributes
    ----------
    setting : Study and room.
    values : Arrays of its maps by name, as `map_stage` has them.
    heading_deg : Heading of the robot in the maps at one heading [deg].
    """

    setting: Setting
    values: Mapping[str, npt.NDArray[Any]]
    heading_deg: float

    @classmethod
    def of(cls, setting: Setting, room_map: "xr.Dataset") -> "FloorData":
        """Return what is drawn of a room's maps, as plain arrays, which workers read at once.

        Parameters
        ----------
        setting, room_map : Study and room; its maps.
        """
        values = {name: room_map[name].values for name in _DRAWN}
        return cls(setting=setting, values=values, heading_deg=room_map.attrs["heading_deg"])

    @property
    def points_m(self) -> dict[str, FloatArray]:
        """Where each tag hangs over the floor [m]."""
        return {tag.id: tag.point_m for tag in self.setting.tags}

    @property
    def names(self) -> list[str]:
        """Names of the tags that get a panel."""
        return list(self.points_m)[:MOST_PANELS]

    @property
    def heading(self) -> str:
        """Heading of the robot in the maps at one heading, in words [deg]."""
        return f"heading {self.heading_deg:g}°"

    @property
    def coherent_dbm(self) -> FloatArray:
        """Coherent RSS of the strongest antenna, (tag, x, y) [dBm]; NaN: nothing received."""
        return self._strongest_dbm("rss_w")

    @property
    def mean_dbm(self) -> FloatArray:
        """Power sum over paths at the strongest antenna, (tag, x, y) [dBm]; NaN: nothing."""
        return self._strongest_dbm("local_mean_rss_w")

    def _strongest_dbm(self, name: str) -> FloatArray:
        level = power_dbm(self.values[name].max(axis=-1).astype(np.float64))
        return np.where(np.isfinite(level), level, np.nan)

    def panel(self, title: str, values: FloatArray, *names: str) -> MapPanel:
        """Return one map, empty where the reader does not fit.

        Parameters
        ----------
        title, values, names : Above it; (x, y), in any unit [dBm, deg or %]; tags shown in it.
        """
        points = self.points_m
        blocked = self.values["standing"] == 0
        masked = np.where(blocked, np.nan, values).T
        return MapPanel(title=title, values=masked, tags={n: points[n] for n in names})

    def figure(
        self,
        panels: Sequence[MapPanel],
        *,
        title: str,
        bar_label: str,
        limits: tuple[float, float] | None = None,
        colours: str = "viridis",
        columns: int = 2,
    ) -> "Figure":
        """Return panels over the plan of the room, axes in [m].

        Parameters
        ----------
        panels, title, bar_label, limits, colours, columns : As for `map_figure`, limits in [dBm],
            [deg] or [%].
        """
        return map_figure(
            self.values["x"],
            self.values["y"],
            panels,
            plan_of(self.setting.scene, self.setting.reader_z_m),
            title=title,
            bar_label=bar_label,
            limits=limits,
            colours=colours,
            columns=columns,
        )


def level_figures(floor: FloorData) -> Iterator[NamedFigure]:
    """Yield the RSS map of the mission's first tag [dBm].

    Parameters
    ----------
    floor : The room with its maps.
    """
    names, mission = floor.names, floor.setting.study.mission
    first = 0 if mission is None else names.index(mission.tags[0])
    powers = floor.values["rss_w"]
    yield NamedFigure(
        file="map_rss.png",
        section="room",
        title=f"RSS map for tag {names[first]}",
        caption="RSS of the strongest antenna over the floor: the coherent field with its fading, "
        "and the power sum over paths without it; grey is where the reader does not fit. All "
        f"{np.isfinite(powers).sum()} powers of the antennas in the map were checked as they were "
        "computed: finite, and none above what the tag sends.",
        figure=floor.figure(
            [
                floor.panel("coherent", floor.coherent_dbm[first], names[first]),
                floor.panel("local mean (power sum)", floor.mean_dbm[first], names[first]),
            ],
            title=f"RSS of the strongest antenna, tag {names[first]}, {floor.heading}",
            bar_label="RSS [dBm]",
        ),
    )


def tag_level_figures(floor: FloorData) -> Iterator[NamedFigure]:
    """Yield the RSS maps of all tags [dBm]; none of a single tag.

    Parameters
    ----------
    floor : The room with its maps.
    """
    names = floor.names
    if len(names) == 1:
        return
    coherent = floor.coherent_dbm
    yield NamedFigure(
        file="map_rss_tags.png",
        section="room",
        title="RSS maps of all tags",
        caption="The same coherent RSS for every tag (cross)"
        + (
            ": weak right under it, since vertical wires neither send nor receive along themselves."
            if {tag.antenna for tag in floor.setting.study.tags} <= {"dipole", "monopole"}
            else "."
        ),
        figure=floor.figure(
            [floor.panel(f"tag {n}", coherent[i], n) for i, n in enumerate(names)],
            title=f"Coherent RSS of the strongest antenna, {floor.heading}",
            bar_label="RSS [dBm]",
        ),
    )


def heading_error_figures(floor: FloorData, elements_rad: FloatArray) -> Iterator[NamedFigure]:
    """Yield the map of the bearing error at one heading [deg].

    Parameters
    ----------
    floor : The room with its maps.
    elements_rad : (n,) float64 — Azimuths of the antennas [rad].
    """
    errors = _map_errors_deg(floor, elements_rad)
    yield NamedFigure(
        file="map_bearing_error.png",
        section="room",
        title="Bearing error over the floor",
        caption="Absolute error of the direction of the strongest antenna; an error beyond 90° "
        "sends the robot away from the tag.",
        figure=floor.figure(
            [floor.panel(f"tag {n}", errors[i], n) for i, n in enumerate(floor.names)],
            title=f"Bearing error of the strongest antenna, {floor.heading}",
            bar_label="absolute bearing error [°]",
            limits=(0.0, 180.0),
            colours="magma_r",
        ),
    )


def all_headings_figures(floor: FloorData) -> Iterator[NamedFigure]:
    """Yield the map of the bearing error over all headings [deg].

    Parameters
    ----------
    floor : The room with its maps.
    """
    names, panel = floor.names, floor.panel
    vector = np.degrees(floor.values["vector_error"])
    strongest = np.degrees(floor.values["strongest_error"])
    panels = [panel(f"vector sum, tag {n}", vector[i], n) for i, n in enumerate(names)]
    for label, table in (("vector sum", vector), ("strongest antenna", strongest)):
        panels.append(panel(f"{label}, all tags", np.sqrt((table**2).mean(axis=0)), *names))
    yield NamedFigure(
        file="map_bearing_rms.png",
        section="room",
        title="Bearing error over the floor, all headings",
        caption="Rms error of the bearing over all headings of the robot at each place, for each "
        "tag and over all tags: red places send the robot astray however it stands.",
        figure=floor.figure(
            panels,
            title="Rms bearing error over all headings",
            bar_label="rms bearing error [°]",
            limits=(0.0, 90.0),
            colours="YlOrRd",
            columns=3 if len(panels) > 4 else 2,
        ),
    )


def capture_figures(floor: FloorData) -> Iterator[NamedFigure]:
    """Yield the map of capture by a reflection [%].

    Parameters
    ----------
    floor : The room with its maps.
    """
    captured = 100.0 * floor.values["captured_share"]
    yield NamedFigure(
        file="map_capture.png",
        section="room",
        title="Where a reflection is stronger than the tag",
        caption="Share of the antennas, each facing the tag in turn, to which a single path with "
        "bends brings more power than the direct ray: there the reader sees a mirror image first.",
        figure=floor.figure(
            [floor.panel(f"tag {n}", captured[i], n) for i, n in enumerate(floor.names)],
            title="Capture by a reflection",
            bar_label="antennas captured [%]",
            limits=(0.0, 100.0),
            colours="YlGnBu",
        ),
    )


def _map_errors_deg(floor: FloorData, elements_rad: FloatArray) -> FloatArray:
    """Return the (tag, x, y) absolute error of the strongest antenna's direction [deg]."""
    x, y = floor.values["x"], floor.values["y"]
    heading = math.radians(floor.heading_deg)
    errors = []
    for powers, point in zip(floor.values["rss_w"], floor.points_m.values(), strict=True):
        towards = np.arctan2(point[1] - y[None, :], point[0] - x[:, None])
        truth = towards - heading + math.pi / 2.0
        estimate = elements_rad[powers.argmax(axis=-1)]
        errors.append(np.degrees(np.abs(wrap_angle(estimate - truth))))
    return np.array(errors)


def way_figures(
    setting: Setting, missions: Sequence[tuple[RoomMission, Plan]], *, label: str
) -> Iterator[NamedFigure]:
    """Yield the missions' ways [m], as thesis Fig. 5.12; none where nothing was driven.

    Parameters
    ----------
    setting, missions, label : Study and room; one for each room, with its plan; the design.
    """
    table, shown = setting.study.mission, _driven(missions)
    if table is None or not shown:
        return
    yield NamedFigure(
        file="trajectory.png",
        section="mission",
        title="Way of the robot",
        caption="Run 0 in each room: desired straight segments dashed, tags as crosses, the "
        "robot's path as a line.",
        figure=trajectory_figure(
            [(mission.name, drive, plan) for mission, drive, plan in shown],
            {tag_id: setting.tag(tag_id).point_m for tag_id in table.tags},
            title=f"Way of the robot with the {label}",
        ),
    )


def drive_figures(
    setting: Setting, missions: Sequence[tuple[RoomMission, Plan]]
) -> Iterator[NamedFigure]:
    """Yield what happened on the missions' ways: errors [cm, deg], RSS [dBm], controller.

    Parameters
    ----------
    setting, missions : Study and room; one for each room, with its plan.
    """
    table, shown = setting.study.mission, _driven(missions)
    if table is None or not shown:
        return
    yield NamedFigure(
        file="percentiles.png",
        section="mission",
        title="Errors by percentile",
        caption="Distance to the desired segment and heading error that run 0 kept for a given "
        "share of the time; the dotted line marks 90 %.",
        figure=percentile_figure(
            [(mission.name, drive) for mission, drive, _ in shown],
            title="Errors by percentile, run 0",
        ),
    )
    for mission, drive, _ in shown:
        yield NamedFigure(
            file=f"rss_time_{mission.slug}.png",
            section="mission",
            title=f"RSS over time, {mission.name}",
            caption="What every antenna read in run 0, with the noise of the reader; dotted lines "
            "mark where the next tag became the target.",
            figure=rss_time_figure(
                drive, table.tags, title=f"RSS over time, {mission.name}, run 0"
            ),
        )
    rules = controller_figure(table, name=setting.study.name)
    if rules is not None:
        yield NamedFigure(
            file="membership.png",
            section="mission",
            title="Fuzzy controller",
            caption="Terms of the steering input and of a wheel's speed, and the speeds that its "
            "rules give.",
            figure=rules,
        )


def _driven(
    missions: Sequence[tuple[RoomMission, Plan]],
) -> list[tuple[RoomMission, Drive, Plan]]:
    """Return the missions that were driven, with run 0 of each."""
    drives = [(mission, mission.drive, plan) for mission, plan in missions]
    return [(mission, drive, plan) for mission, drive, plan in drives if drive is not None]
