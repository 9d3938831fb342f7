"""A small flat of two rooms with four anchors, and logs of it by the full solver."""

from pathlib import Path

import numpy as np

from octant.em.antennas.kinds import make_antenna
from octant.em.power.received_power import antenna_power
from octant.navigation.logs.records import Log
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import parse_study

ANCHORS = {
    "a": (1.6, 2.1, 2.2),
    "b": (4.6, 0.4, 1.9),
    "c": (0.5, 3.5, 2.2),
    "d": (4.5, 3.4, 2.3),
}
WALL = """# a wall in the middle, as one sheet
v 2.5 0 0
v 2.5 4 0
v 2.5 4 2.6
v 2.5 0 2.6
f 1 2 3
f 1 3 4
"""


def study_text(
    folder: Path, *, sigma=0.02, axes=None, places=None, height_m=1.0, order=1, more=""
) -> str:
    """Return the text of the study; the wall's conductivity, tags' axes and places may differ."""
    file = folder / "wall.obj"
    if not file.exists():
        file.write_text(WALL)
    tags = ""
    for name, place in ANCHORS.items():
        at = (places or {}).get(name, place)
        tags += f'[[tag]]\nid = "{name}"\nposition_m = {list(map(float, at))}\nantenna = "dipole"\n'
        if axes and name in axes:
            tags += f"axis = {list(map(float, axes[name]))}\n"
    return f"""name = "measured"
[radio]
frequency_hz = 2.44e9
tag_power_w = 0.001
[room]
box_m = [5.0, 4.0, 2.6]
material = "concrete"
[[room.object]]
kind = "mesh"
file = "{file}"
unit = "m"
position_m = [0.0, 0.0, 0.0]
material = {{ eps_r = 2.8, sigma_s_per_m = {sigma}, thickness_m = 0.1 }}
[reader]
height_m = {height_m}
[solver]
max_reflections = {order}
transmission = true
{tags}
{more}"""


def measured_study(folder: Path, **values):
    """Return the study."""
    return parse_study(study_text(folder, **values), source="test", directory=folder)


def truth_dbm(study, poses):
    """Return the local means of all anchors at poses by the full solver, (m, t) [dBm]."""
    setting = build_setting(study)
    radio = setting.radios[0]
    places = np.column_stack((poses[:, :2], np.full(len(poses), setting.reader_z_m)))
    dipole = make_antenna("dipole", radio.frequency_hz)
    power = [
        antenna_power(
            radio,
            setting.candidates(tag.position_m),
            places,
            transmitter=tag.antennas[0],
            receiver=dipole,
            power_w=study.radio.tag_power_w,
        ).local_mean_w
        for tag in setting.tags
    ]
    return 10.0 * np.log10(np.array(power).T) + 30.0


def some_poses(count, seed=5):
    """Return poses anywhere on the floor off the wall, (m, 3) [m], [rad]."""
    rng = np.random.default_rng(seed)
    poses = rng.uniform((0.3, 0.3, -3.0), (4.7, 3.7, 3.0), (count, 3))
    return poses[np.abs(poses[:, 0] - 2.5) > 0.1]


def log_of(level_dbm, poses, *, ids=tuple(ANCHORS), threshold_dbm=None, hide_below=None):
    """Return a log of levels (m, t); those below ``hide_below`` are not heard."""
    level = np.asarray(level_dbm, dtype=float)
    if hide_below is not None:
        level = np.where(level < hide_below, -np.inf, level)
    m, t = level.shape
    unknown = np.full(m * t, np.nan)
    return Log(
        ids=ids,
        time_s=np.repeat(np.arange(m, dtype=float), t),
        poses=np.repeat(poses, t, axis=0),
        sources=np.tile(np.arange(t), m),
        antennas=np.zeros(m * t, dtype=int),
        rss_dbm=level.reshape(-1),
        frequency_hz=unknown,
        distance_m=unknown,
        turn_rad=unknown,
        threshold_dbm=threshold_dbm,
    )
