"""What an animated run is seen against: the field of its tags over the floor, coarsely."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.decibels import power_dbm
from octant.navigation.missions.records import MissionResult
from octant.reader_design.experiments.missions.animation import FieldMap, Scenery
from octant.reader_design.setting.links import tag_link
from octant.reader_design.setting.samples import standing_room
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.plan import plan_of
from octant.reader_design.study_file.schema import Study

FloatArray = npt.NDArray[np.float64]

SPACING_M = 0.1
"""Distance of neighbouring points of the field under an animation [m]."""

_CLEARANCE_M = 0.03
_AROUND_M = 0.7


def run_scenery(
    study: Study,
    built: Setting,
    responses: Sequence[ReaderResponse],
    result: MissionResult,
    *,
    spacing_m: float = SPACING_M,
) -> Scenery:
    """Return plan, tags, reader and field for the animation of a run.

    Parameters
    ----------
    study : Study
        The study.
    built : Setting
        The room.
    responses : sequence of ReaderResponse
        The reader's, one for each of ``study.radio.frequencies_hz``.
    result : MissionResult
        The run.
    spacing_m : float
        Distance of neighbouring points of the field [m].

    Returns
    -------
    Scenery
        The field [dBm] is that of the strongest antenna of a robot heading along +y.
    """
    mission = result.mission
    points = dict(zip(mission.tag_ids, mission.tag_points_m, strict=True))
    low, high = _extent_m(built, np.vstack([mission.tag_points_m, result.poses[:, :2]]))
    x_m, y_m = (
        np.arange(a, b + 0.5 * spacing_m, spacing_m) for a, b in zip(low, high, strict=True)
    )
    x, y = np.meshgrid(x_m, y_m)
    places = np.column_stack([x.ravel(), y.ravel()])
    open_floor = standing_room(
        built.scene, places, reader_z_m=built.reader_z_m, clearance_m=_CLEARANCE_M
    )
    poses = np.column_stack([places, np.full(len(places), 0.5 * np.pi)])[open_floor]
    fields: dict[str, FloatArray] = {}
    for tag_id in points:
        level = np.full(len(places), np.nan)
        rss_w = tag_link(study, built, built.tag(tag_id), responses).rss_w(poses)
        level[open_floor] = power_dbm(rss_w.max(axis=1))
        fields[tag_id] = np.where(np.isfinite(level), level, np.nan).reshape(x.shape)
    return Scenery(
        plan=plan_of(built.scene, built.reader_z_m),
        tags=points,
        field=FieldMap(
            x_m=x_m, y_m=y_m, rss_dbm=np.stack([fields[tag_id] for tag_id in mission.tag_ids])
        ),
        azimuths_rad=responses[0].azimuths_rad,
        antenna_radius_m=study.reader.antenna_radius_m,
    )


def _extent_m(built: Setting, way_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    if built.scene.has_room:
        low, high = built.scene.bounds_m[:, :2]
        return np.asarray(low), np.asarray(high)
    return way_m.min(axis=0) - _AROUND_M, way_m.max(axis=0) + _AROUND_M
