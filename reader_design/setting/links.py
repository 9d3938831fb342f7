"""What a robot knows of its reader: the patterns under which it sees each tag of its mission."""

import numpy as np

from octant.navigation.sensing.pattern_match import PowerTable, power_table
from octant.reader_design.setting.placing import alike_from_all_sides
from octant.reader_design.setting.setting import Setting

_SIDES = 16
_LEAST_REACH_M = 8.0
_OPEN_REACH = 1.5


def mission_reach_m(setting: Setting) -> float:
    """Return how far along the floor the robot looks for a tag [m].

    What the study says; else the diagonal of the room, and in free space half as far again as the
    diagonal of what the mission's places span.

    Parameters
    ----------
    setting : The room of a study with a mission.
    """
    table = setting.mission
    if table.tracker.reach_m is not None:
        return table.tracker.reach_m
    if setting.scene.has_room:
        low, high = setting.scene.bounds_m[:, :2]
        return float(np.linalg.norm(high - low))
    starts = [start[:2] for start in table.starts] or [table.start_m]
    places = np.array([*starts, *(setting.tag(tag_id).point_m for tag_id in table.tags)])
    return max(_LEAST_REACH_M, _OPEN_REACH * float(np.linalg.norm(np.ptp(places, axis=0))))


def mission_tables(setting: Setting) -> tuple[PowerTable, ...]:
    """Return what the robot knows of its reader, for each tag of the mission; alike ones share it.

    Parameters
    ----------
    setting : With a mission; how the tags hang is taken from it, and not where.
    """
    given = {tag.id: tag for tag in setting.study.tags}
    made: dict[str, PowerTable] = {}
    tables = []
    for tag_id in setting.mission.tags:
        tag, placed = given[tag_id], setting.tag(tag_id)
        kind = repr((tag.antenna, tag.axis, tag.azimuth_deg, setting.height_m(placed)))
        if kind not in made:
            made[kind] = power_table(
                setting.open_link(placed),
                (0.0, 0.0),
                reach_m=mission_reach_m(setting),
                sides=1 if alike_from_all_sides(tag) else _SIDES,
            )
        tables.append(made[kind])
    return tuple(tables)
