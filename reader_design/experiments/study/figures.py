"""Which figures a study leaves, with the sentence that says what to see in each."""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.navigation.angles import wrap_angle
from octant.reader_design.experiments.missions.drive_figures import (
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

FloatArray = npt.NDArray[np.float64]

MOST_PANELS = 12
"""Panels or maps that one figure shows at most [-]."""
AZIMUTH_DISTANCE_M = 2.0
"""Distance at which the patterns over azimuth are shown [m]; the nearest sampled one is taken."""


def reader_figures(
    study: Study, cell: Cell, elements_rad: FloatArray, room_map: "xr.Dataset"
) -> Iterator[NamedFigure]:
    """Yield the figures of the chosen reader: patterns [dBm] and bearing errors [deg].

    Parameters
    ----------
    study, cell, room_map : Gives the receiver; the reader's cell; holds the room's samples.
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
    surroundings = [("free space, all distances", azimuths, cell.free_rss_w)]
    if "sample_rss_w" in room_map:
        samples = room_map["sample_rss_w"].values.astype(np.float64)
        in_room = np.radians(room_map["sample_azimuth"].values)
        surroundings.append(("in the room, all places and tags", in_room, samples))
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


def room_figures(
    setting: Setting, room_map: "xr.Dataset", elements_rad: FloatArray
) -> Iterator[NamedFigure]:
    """Yield the maps of the room: RSS [dBm] of the strongest antenna, bearing error [deg].

    Parameters
    ----------
    setting, room_map : Study and room; its maps.
    elements_rad : (n,) float64 — Azimuths of the antennas [rad].
    """
    data = room_map
    plan = plan_of(setting.scene, setting.reader_z_m)
    x, y = data["x"].values, data["y"].values
    blocked = data["standing"].values == 0
    points = {tag.id: tag.point_m for tag in setting.tags}

    def panel(title: str, values: FloatArray, *names: str) -> MapPanel:
        masked = np.where(blocked, np.nan, values).T
        return MapPanel(title=title, values=masked, tags={n: points[n] for n in names})

    powers = data["rss_w"].values
    coherent = power_dbm(powers.max(axis=-1).astype(np.float64))
    mean = power_dbm(data["local_mean_rss_w"].values.max(axis=-1).astype(np.float64))
    coherent, mean = (np.where(np.isfinite(v), v, np.nan) for v in (coherent, mean))
    names = list(points)[:MOST_PANELS]
    first = 0 if setting.study.mission is None else names.index(setting.study.mission.tags[0])
    heading = f"heading {float(data.attrs['heading_deg']):g}°"
    yield NamedFigure(
        file="map_rss.png",
        section="room",
        title=f"RSS map for tag {names[first]}",
        caption="RSS of the strongest antenna over the floor: the coherent field with its fading, "
        "and the power sum over paths without it; grey is where the reader does not fit. All "
        f"{np.isfinite(powers).sum()} powers of the antennas in the map were checked as they were "
        "computed: finite, and none above what the tag sends.",
        figure=map_figure(
            x,
            y,
            [
                panel("coherent", coherent[first], names[first]),
                panel("local mean (power sum)", mean[first], names[first]),
            ],
            plan,
            title=f"RSS of the strongest antenna, tag {names[first]}, {heading}",
            bar_label="RSS [dBm]",
        ),
    )
    if len(names) > 1:
        yield NamedFigure(
            file="map_rss_tags.png",
            section="room",
            title="RSS maps of all tags",
            caption="The same coherent RSS for every tag (cross)"
            + (
                ": weak right under it, since vertical wires neither send nor receive along "
                "themselves."
                if {tag.antenna for tag in setting.study.tags} <= {"dipole", "monopole"}
                else "."
            ),
            figure=map_figure(
                x,
                y,
                [panel(f"tag {n}", coherent[i], n) for i, n in enumerate(names)],
                plan,
                title=f"Coherent RSS of the strongest antenna, {heading}",
                bar_label="RSS [dBm]",
            ),
        )
    errors = _map_errors_deg(data, points, elements_rad)
    yield NamedFigure(
        file="map_bearing_error.png",
        section="room",
        title="Bearing error over the floor",
        caption="Absolute error of the direction of the strongest antenna; an error beyond 90° "
        "sends the robot away from the tag.",
        figure=map_figure(
            x,
            y,
            [panel(f"tag {n}", errors[i], n) for i, n in enumerate(names)],
            plan,
            title=f"Bearing error of the strongest antenna, {heading}",
            bar_label="absolute bearing error [°]",
            limits=(0.0, 180.0),
            colours="magma_r",
        ),
    )
    yield from _floor_figures(data, names, panel, (x, y), plan)


def _floor_figures(
    data: "xr.Dataset",
    names: Sequence[str],
    panel: Callable[..., MapPanel],
    grid: tuple[FloatArray, FloatArray],
    plan: Plan,
) -> Iterator[NamedFigure]:
    """Yield the maps over all headings: bearing error and capture."""
    vector = np.degrees(data["vector_error"].values)
    strongest = np.degrees(data["strongest_error"].values)
    panels = [panel(f"vector sum, tag {n}", vector[i], n) for i, n in enumerate(names)]
    for label, table in (("vector sum", vector), ("strongest antenna", strongest)):
        panels.append(panel(f"{label}, all tags", np.sqrt((table**2).mean(axis=0)), *names))
    yield NamedFigure(
        file="map_bearing_rms.png",
        section="room",
        title="Bearing error over the floor, all headings",
        caption="Rms error of the bearing over all headings of the robot at each place, for each "
        "tag and over all tags: red places send the robot astray however it stands.",
        figure=map_figure(
            *grid,
            panels,
            plan,
            title="Rms bearing error over all headings",
            bar_label="rms bearing error [°]",
            limits=(0.0, 90.0),
            colours="YlOrRd",
            columns=3 if len(panels) > 4 else 2,
        ),
    )
    captured = 100.0 * data["captured_share"].values
    yield NamedFigure(
        file="map_capture.png",
        section="room",
        title="Where a reflection is stronger than the tag",
        caption="Share of the antennas, each facing the tag in turn, to which a single path with "
        "bends brings more power than the direct ray: there the reader sees a mirror image first.",
        figure=map_figure(
            *grid,
            [panel(f"tag {n}", captured[i], n) for i, n in enumerate(names)],
            plan,
            title="Capture by a reflection",
            bar_label="antennas captured [%]",
            limits=(0.0, 100.0),
            colours="YlGnBu",
        ),
    )


def _map_errors_deg(
    data: "xr.Dataset", points: dict[str, FloatArray], elements_rad: FloatArray
) -> FloatArray:
    """Return the (tag, x, y) absolute error of the strongest antenna's direction [deg]."""
    x, y = data["x"].values, data["y"].values
    heading = math.radians(float(data.attrs["heading_deg"]))
    errors = []
    for index, point in enumerate(points.values()):
        towards = np.arctan2(point[1] - y[None, :], point[0] - x[:, None])
        truth = towards - heading + math.pi / 2.0
        estimate = elements_rad[data["rss_w"].values[index].argmax(axis=-1)]
        errors.append(np.degrees(np.abs(wrap_angle(estimate - truth))))
    return np.array(errors)


def mission_figures(
    setting: Setting, missions: Sequence[tuple[RoomMission, Plan]], *, label: str
) -> Iterator[NamedFigure]:
    """Yield the missions' figures, as thesis Fig. 5.12: way [m], errors [cm, deg], RSS [dBm].

    Parameters
    ----------
    setting, missions, label : Study and room; one for each room, with its RSS; the design.
    """
    table = setting.study.mission
    driven = [(m.name, m.drive, plan, m.slug) for m, plan in missions]
    shown = [(name, drive, plan, slug) for name, drive, plan, slug in driven if drive is not None]
    if table is None or not shown:
        return
    points = {tag_id: setting.tag(tag_id).point_m for tag_id in table.tags}
    yield NamedFigure(
        file="trajectory.png",
        section="mission",
        title="Way of the robot",
        caption="Run 0 in each room: desired straight segments dashed, tags as crosses, the "
        "robot's path as a line.",
        figure=trajectory_figure(
            [(name, drive, plan) for name, drive, plan, _ in shown],
            points,
            title=f"Way of the robot with the {label}",
        ),
    )
    yield NamedFigure(
        file="percentiles.png",
        section="mission",
        title="Errors by percentile",
        caption="Distance to the desired segment and heading error that run 0 kept for a given "
        "share of the time; the dotted line marks 90 %.",
        figure=percentile_figure(
            [(name, drive) for name, drive, _, _ in shown], title="Errors by percentile, run 0"
        ),
    )
    for name, drive, _, slug in shown:
        yield NamedFigure(
            file=f"rss_time_{slug}.png",
            section="mission",
            title=f"RSS over time, {name}",
            caption="What every antenna read in run 0, with the noise of the reader; dotted lines "
            "mark where the next tag became the target.",
            figure=rss_time_figure(drive, table.tags, title=f"RSS over time, {name}, run 0"),
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
