"""Which figures a study leaves, with the sentence that says what to see in each."""

import math
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.navigation.bearing import wrap_angle
from octant.reader_design.figures.common import bearing_error_figure, rss_azimuth_figure
from octant.reader_design.figures.room import (
    MapPanel,
    map_figure,
    percentile_figure,
    rss_time_figure,
    trajectory_figure,
)
from octant.reader_design.figures.sweep import (
    DistancePanel,
    MatrixColumn,
    rss_distance_figure,
    sweep_matrix_figure,
)
from octant.reader_design.rooms.plan import Plan, plan_of
from octant.reader_design.study.map_stage import RoomMap
from octant.reader_design.study.mission_stage import RoomMission
from octant.reader_design.sweep.cells import Cell, SweepContext
from octant.reader_design.sweep.choice import Candidate, Choice
from octant.reader_design.sweep.measures import power_dbm
from octant.reader_design.sweep.samples import grid_azimuths_rad
from octant.reader_design.sweep.scores import Scores

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

MOST_ROWS = 30
"""Designs that the sweep matrix shows at most [-]."""
MOST_PANELS = 12
"""Panels or maps that one figure shows at most [-]."""
PANEL_LETTERS = 32
"""Letters that fit above a panel [-]."""
AZIMUTH_DISTANCE_M = 2.0
"""Distance at which the patterns over azimuth are shown [m]; the nearest sampled one is taken."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NamedFigure:
    """A figure with its file name and what to see in it.

    Attributes
    ----------
    file : str
        File name.
    section : str
        ``sweep``, ``reader``, ``room`` or ``mission``.
    title : str
        Its name.
    caption : str
        One sentence, with the units that matter [m, dB, deg].
    figure : Figure
        The figure.
    """

    file: str
    section: str
    title: str
    caption: str
    figure: "Figure"


def sweep_figures(
    cells: Sequence[Cell], candidates: Sequence[Candidate], choice: Choice
) -> Iterator[NamedFigure]:
    """Yield the figures of the sweep: all scores, and RSS [dBm] against distance [m].

    Parameters
    ----------
    cells : sequence of Cell
        All cells.
    candidates : sequence of Candidate
        The scored ones.
    choice : Choice
        Their ranking.

    Yields
    ------
    NamedFigure
        The matrix, then one figure for each antenna type.
    """
    order = choice.ranking[:MOST_ROWS]
    yield NamedFigure(
        file="sweep_matrix.png",
        section="sweep",
        title="The designs side by side",
        caption="Designs from best to worst with the numbers that decide; dark is good, each "
        "column on its own scale, and the first row is the chosen design.",
        figure=sweep_matrix_figure(
            [candidates[i].label for i in order],
            _matrix_columns([candidates[i] for i in order]),
            title="The designs, best first",
        ),
    )
    good = [c for c in cells if not c.reason]
    for kind in dict.fromkeys(c.design.antenna for c in good):
        shown = [c for c in good if c.design.antenna == kind][:MOST_PANELS]
        heights = len({c.design.plate_height_m for c in shown})
        panels = [
            DistancePanel(
                title="\n".join(_panel_title(c)),
                rss_w=c.travel_rss_w,
            )
            for c in shown
        ]
        yield NamedFigure(
            file=f"rss_distance_{kind}.png",
            section="sweep",
            title=f"RSS against distance, {kind}s",
            caption="What each antenna receives in free space while the robot moves away from the "
            "point under the tag with antenna 1 facing the tag (thesis Fig. 5.9 and 5.11); a good "
            "design keeps antenna 1 on top and the curves apart.",
            figure=rss_distance_figure(
                shown[0].travel_m,
                panels,
                columns=min(heights if heights > 1 else 3, len(shown), 4),
                title=f"RSS of the {kind} designs, antenna 1 towards the tag",
            ),
        )


def _panel_title(cell: Cell) -> Iterator[str]:
    """Yield the lines that tell a cell from others of its antenna, lengths in cm."""
    design = cell.design
    yield (
        f"r_a = {100 * design.antenna_radius_m:.4g} cm, h_p = {100 * design.plate_height_m:.4g} cm"
    )
    yield from textwrap.wrap(cell.label.removeprefix(design.label()).strip(), PANEL_LETTERS)


def _matrix_columns(rows: Sequence[Candidate]) -> list[MatrixColumn]:
    """Return the columns of the sweep matrix: the deciding scores, in free space and the room."""
    table: tuple[tuple[str, str, float, str, str], ...] = (
        ("right_share", "right antenna\n{} [%]", 100.0, "{:.0f}", "high"),
        ("vector_rms_rad", "vector sum\n{} rms [°]", math.degrees(1.0), "{:.1f}", "low"),
        ("margin_mean_db", "mean margin\n{} [dB]", 1.0, "{:+.1f}", "high"),
        ("front_to_back_mean_db", "front-to-back\n{} [dB]", 1.0, "{:+.1f}", "high"),
        ("level_median_dbm", "median level\n{} [dBm]", 1.0, "{:.0f}", "high"),
    )
    columns = []
    for name, heading, scale, text, better in table:
        for place in ("free", "room"):
            scores: list[Scores | None] = [getattr(row, place) for row in rows]
            known = [s for s in scores if s is not None]
            if len(known) == len(scores):
                values = scale * np.array([getattr(s, name) for s in known])
                title = heading.format(place)
                columns.append(MatrixColumn(title=title, values=values, text=text, better=better))
    return columns


def reader_figures(
    cell: Cell, elements_rad: FloatArray, room_map: RoomMap
) -> Iterator[NamedFigure]:
    """Yield the figures of the chosen reader: patterns [dBm] and bearing errors [deg].

    Parameters
    ----------
    cell : Cell
        Its cell.
    elements_rad : (n,) float64
        Azimuths of its antennas [rad].
    room_map : RoomMap
        Holds the samples of the room.

    Yields
    ------
    NamedFigure
        Two figures.
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
    surroundings = [("free space, all distances", azimuths, cell.free_rss_w)]
    if "sample_rss_w" in room_map.data:
        samples = room_map.data["sample_rss_w"].values.astype(np.float64)
        in_room = np.radians(room_map.data["sample_azimuth"].values)
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


def room_figures(
    context: SweepContext, room_map: RoomMap, elements_rad: FloatArray
) -> Iterator[NamedFigure]:
    """Yield the maps of the room: RSS [dBm] of the strongest antenna, bearing error [deg].

    Parameters
    ----------
    context : SweepContext
        Study and room.
    room_map : RoomMap
        The maps.
    elements_rad : (n,) float64
        Azimuths of the antennas [rad].

    Yields
    ------
    NamedFigure
        Three figures.
    """
    data, built = room_map.data, context.built
    plan = plan_of(built.scene, built.reader_z_m)
    x, y = data["x"].values, data["y"].values
    blocked = data["standing"].values == 0
    points = {tag.id: tag.point_m for tag in built.tags}

    def panel(title: str, values: FloatArray, *names: str) -> MapPanel:
        masked = np.where(blocked, np.nan, values).T
        return MapPanel(title=title, values=masked, tags={n: points[n] for n in names})

    coherent = power_dbm(data["rss_w"].values.max(axis=-1).astype(np.float64))
    mean = power_dbm(data["local_mean_rss_w"].values.max(axis=-1).astype(np.float64))
    coherent, mean = (np.where(np.isfinite(v), v, np.nan) for v in (coherent, mean))
    names = list(points)[:MOST_PANELS]
    first = 0 if context.study.mission is None else names.index(context.study.mission.tags[0])
    heading = f"heading {float(data.attrs['heading_deg']):g}°"
    yield NamedFigure(
        file="map_rss.png",
        section="room",
        title=f"RSS map for tag {names[first]}",
        caption="RSS of the strongest antenna over the floor: the coherent field with its fading, "
        "and the power sum over paths without it; grey is where the reader does not fit.",
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
            caption="The same coherent RSS for every tag (cross): weak right under it, where two "
            "vertical antennas do not see each other.",
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
    context: SweepContext, missions: Sequence[tuple[RoomMission, Plan]], *, label: str
) -> Iterator[NamedFigure]:
    """Yield the figures of the missions: way [m], errors [cm, deg], RSS over time [dBm].

    Parameters
    ----------
    context : SweepContext
        Study and room.
    missions : sequence of (RoomMission, Plan)
        One for each room.
    label : str
        The chosen design.

    Yields
    ------
    NamedFigure
        As in thesis Fig. 5.12, one RSS figure for each room.
    """
    table = context.study.mission
    driven = [(m.name, m.drive, plan, m.slug) for m, plan in missions]
    shown = [(name, drive, plan, slug) for name, drive, plan, slug in driven if drive is not None]
    if table is None or not shown:
        return
    points = {tag_id: context.built.tag(tag_id).point_m for tag_id in table.tags}
    yield NamedFigure(
        file="trajectory.png",
        section="mission",
        title="Way of the robot",
        caption="Run 0 in each room: desired straight segments dashed, tags as crosses, the "
        "robot's path as a line (thesis Fig. 5.12 a).",
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
        "share of the time; the dotted line marks 90 % (thesis Fig. 5.12 b).",
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
            "mark where the next tag became the target (thesis Fig. 5.12 c).",
            figure=rss_time_figure(drive, table.tags, title=f"RSS over time, {name}, run 0"),
        )
