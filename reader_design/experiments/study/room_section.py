"""The report's section on the room: what stands there, and what the reader receives in it."""

from typing import TYPE_CHECKING

import numpy as np

from octant.reader_design.experiments.study.content import StudyContent
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.drive_view import run_end, shown_runs
from octant.reader_design.showing.map_view import FloorMaps, map_widget, symmetric_turn
from octant.reader_design.showing.pages import (
    FigureFiles,
    ReportSection,
    ReportWidget,
    embedded_figures,
)
from octant.reader_design.showing.plan import plan_of
from octant.reader_design.showing.room_view import Way, room_widget
from octant.reader_design.showing.scene_picture import short_material
from octant.reader_design.study_file.schema import Solver

if TYPE_CHECKING:
    import xarray as xr


def room_section(
    content: StudyContent, room_map: "xr.Dataset", figures: FigureFiles
) -> ReportSection:
    """Return the section: the room in three dimensions, and maps to explore ([m], [dBm], [deg]).

    Parameters
    ----------
    content, room_map, figures : The results, the maps, and the figures by section.
    """
    setting = content.setting
    mission = content.missions[0] if content.missions else None
    ways: tuple[Way, ...] = ()
    if mission is not None and mission.results:
        held = shown_runs(mission.metrics)
        ways = tuple(
            Way(points_m=mission.results[i].poses[:, :2], end=run_end(mission.metrics[i]))
            for i in held
        )
    table = setting.study.mission
    room = room_widget(
        setting,
        start_m=None if table is None else table.start_m,
        ways=ways,
        fallback=embedded_figures(figures, "scene"),
    )
    explorer = _explorer(setting, room_map, figures)
    return ReportSection(
        heading="The room",
        points=_room_points(setting),
        widgets=tuple(one for one in (room, explorer) if one is not None),
    )


def _explorer(setting: Setting, room_map: "xr.Dataset", figures: FigureFiles) -> ReportWidget:
    maps = room_map
    tags = [tag.id for tag in setting.tags]
    mission = setting.study.mission
    if "turned_rss_w" in maps:
        every_x = -(-maps.sizes["x"] // maps.sizes["map_x"])
        every_y = -(-maps.sizes["y"] // maps.sizes["map_y"])
        some = np.s_[::every_x, ::every_y]
        floor = FloorMaps(
            x_m=maps["x"].values[::every_x],
            y_m=maps["y"].values[::every_y],
            headings_rad=maps["turned_heading"].values,
            coherent_w=maps["turned_rss_w"].values,
            mean_w=maps["turned_local_mean_rss_w"].values,
            standing=maps["standing"].values[some] == 1,
            azimuths_rad=setting.responses[0].azimuths_rad,
            turn=symmetric_turn(setting.responses[0]),
            rms_rad=maps["vector_error"].values[:, ::every_x, ::every_y],
            captured=maps["captured_share"].values[:, ::every_x, ::every_y],
        )
    else:  # kept by a version that held one heading only
        floor = FloorMaps(
            x_m=maps["x"].values,
            y_m=maps["y"].values,
            headings_rad=np.radians([float(maps.attrs["heading_deg"])]),
            coherent_w=maps["rss_w"].values[None],
            mean_w=maps["local_mean_rss_w"].values[None],
            standing=maps["standing"].values == 1,
            azimuths_rad=setting.responses[0].azimuths_rad,
            turn=symmetric_turn(setting.responses[0]),
            rms_rad=maps["vector_error"].values,
            captured=maps["captured_share"].values,
        )
    return map_widget(
        floor,
        setting,
        plan_of(setting.scene, setting.reader_z_m),
        tags=tags,
        tag=0 if mission is None else tags.index(mission.tags[0]),
        fallback=embedded_figures(figures, "room"),
    )


def _room_points(setting: Setting) -> tuple[str, ...]:
    scene, study = setting.scene, setting.study
    if not scene.bodies:
        return ("Free space: no walls and no objects.",)
    size = scene.bounds_m[1] - scene.bounds_m[0]
    names = ", ".join(b.name for b in scene.bodies[:12])
    return (
        (
            f"{size[0]:.3g} m by {size[1]:.3g} m, {size[2]:.3g} m high; {len(scene.bodies)} bodies "
            f"({names}{', ...' if len(scene.bodies) > 12 else ''}) of "
            f"{', '.join(dict.fromkeys(map(short_material, scene.material_names)))}"
        ),
        _paths_point(study.solver),
    )


def _paths_point(solver: Solver) -> str:
    """Return in words which paths the room's model includes."""
    over = "no diffraction"
    if solver.diffraction:
        over = f"up to {solver.max_diffractions} of them over edges (uniform theory of diffraction)"
    through = "through sheets with a thickness" if solver.transmission else "none through walls"
    how = ""
    if solver.search == "rays":
        how = f", all but what would add {solver.ray_tolerance_db:g} dB, as rays find them"
    return f"paths of up to {solver.max_reflections} bends, {over}, {through}{how}"
