"""What a robot knows of its reader: the patterns under which it sees each tag of its mission."""

from octant.navigation.sensing.pattern_match import PowerTable, power_table
from octant.reader_design.setting.setting import Setting

_ROUND = ("dipole", "monopole", "isotropic_theta")
_SIDES = 16


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
            upright = tag.antenna in _ROUND and (tag.axis is None or not any(tag.axis[:2]))
            made[kind] = power_table(
                setting.open_link(placed), (0.0, 0.0), sides=1 if upright else _SIDES
            )
        tables.append(made[kind])
    return tuple(tables)
