"""Bearing errors inside four concrete walls, beside those of an independent prototype.

Run from a checkout with ``octant`` installed::

    python benchmarks/bench_room_bearing.py [--poses N]

The room is 7 x 7 x 3.1 m around the thesis' 5 x 5 m area; paths of up to three reflections add up
coherently; the reader is that of the thesis (r_a = 10 cm) by the method of moments. Each line gives
median and 90th percentile of the vector sum's bearing error at random poses and tags.

The prototype's tag is "a downward patch-like antenna". ``cosine`` is vertical polarisation with the
amplitude cos of the angle to straight down, which reproduces its numbers; ``patch`` is Octant's
physical one, linearly polarised, whose horizontal component adds reflections that mislead.
"""

import argparse
import math
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from octant.em.antennas.kinds import Antenna
from octant.navigation.sensing.bearing import reader_azimuth
from octant.reader_design.setting.bearing_errors import vector_errors_rad
from octant.reader_design.setting.samples import standing_room
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import parse_study

AREA_M = (5.0, 5.0)
TAGS_M = ((2.0, 0.5), (3.5, 2.0), (2.0, 3.5), (4.0, 3.5))
CHANNELS_HZ = tuple(float(f) for f in np.linspace(2.402e9, 2.480e9, 16))
BETTER = "ground_plane_shape = 'round'\n"

CASES = (
    # name, room, channels, tag antenna, reader keys, prototype's median and 90 % [deg]
    ("free space", False, (), "dipole", "", "0.7 / 3"),
    ("concrete room", True, (), "dipole", "", "20-22 / 76-85"),
    ("h_p = 0", True, (), "dipole", "plate_height_m = 0.0\n", "61 / 156"),
    ("16 channels", True, CHANNELS_HZ, "dipole", "", "9 / 28"),
    ("cosine tag", True, (), "cosine", "", "6 / 15"),
    ("both", True, CHANNELS_HZ, "cosine", "", "2.4 / 8"),
    ("both, round plane", True, CHANNELS_HZ, "cosine", BETTER, "1.4 / 5.3"),
    ("patch tag", True, (), "patch", "", "-"),
    ("patch, 16 channels", True, CHANNELS_HZ, "patch", "", "-"),
)


def study_of(*, room, channels, antenna, reader):
    """Return the study of one case."""
    walls = (
        'box_m = [7.0, 7.0, 3.1]\norigin_m = [-1.0, -1.0, 0.0]\nmaterial = "concrete"'
        if room
        else "free_space = true"
    )
    named = "dipole" if antenna == "cosine" else antenna
    tags = "".join(
        f'[[tag]]\nid = "{k}"\nantenna = "{named}"\nposition_m = [{x}, {y}, 3.05]\n'
        for k, (x, y) in enumerate(TAGS_M)
    )
    text = (
        f"[radio]\nchannels_hz = {list(channels)}\n[room]\n{walls}\n{tags}[reader]\n{reader}"
        "[solver]\nmax_reflections = 3\n"
    )
    return parse_study(text, source="case", directory=Path.cwd())


def cosine_antenna(frequency_hz):
    """Return a tag of vertical polarisation, amplitude cos of the angle to straight down."""
    theta = np.linspace(0.0, math.pi, 181)
    table = np.zeros((2, theta.size, 4), dtype=np.complex128)
    table[0] = math.sqrt(6.0) * np.maximum(-np.cos(theta), 0.0)[:, None]  # mean gain 1
    return Antenna(
        kind="pattern",
        length_m=0.0,
        frequency_hz=frequency_hz,
        axis=np.array([0.0, 0.0, 1.0]),
        pattern=table,
    )


def random_pose_errors_rad(place, *, area_m, poses, rng):
    """Return the vector sum's bearing errors [rad] at poses drawn evenly from (0, 0) to area_m [m].

    Poses where the reader does not fit are left out; an error is pi where there is no bearing.
    """
    places = rng.uniform((0.0, 0.0), area_m, (poses, 2))
    headings = rng.uniform(-np.pi, np.pi, poses)
    asked = rng.integers(len(place.tags), size=poses)
    fits = standing_room(
        place.scene,
        places,
        reader_z_m=place.reader_z_m,
        clearance_m=place.reader.ground_plane_m / 2.0,
    )
    errors = []
    for number, tag in enumerate(place.tags):
        mine = fits & (asked == number)
        if not mine.any():
            continue
        rss = place.link(tag).rss_w(np.column_stack([places[mine], headings[mine]]))
        towards = np.arctan2(*(tag.position_m[:2] - places[mine]).T[::-1])
        azimuth = reader_azimuth(headings[mine], towards)
        elements = place.responses[0].azimuths_rad
        errors.append(vector_errors_rad(rss[:, None], azimuth[:, None], elements)[:, 0])
    return np.concatenate(errors)


def errors_deg(setting, *, antenna, poses):
    """Return the absolute bearing errors of one case [deg]."""
    study = setting.study
    if antenna == "cosine":
        own = tuple(cosine_antenna(f) for f in study.radio.frequencies_hz)
        tags = tuple(replace(tag, antennas=own) for tag in setting.tags)
        setting = replace(setting, tags=tags).with_responses(setting.responses)
    errors = random_pose_errors_rad(
        setting,
        area_m=AREA_M,
        poses=poses,
        rng=np.random.default_rng(study.seed),
    )
    return np.degrees(np.abs(errors))


def main():
    """Print one line for each case."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--poses", type=int, default=4000)
    poses = parser.parse_args().poses
    print(f"{'case':24s}{'median / 90 % [deg]':>22s}{'prototype':>16s}{'> 90 deg':>10s}{'s':>7s}")
    for name, room, channels, antenna, reader, prototype in CASES:
        began = time.perf_counter()
        study = study_of(room=room, channels=channels, antenna=antenna, reader=reader)
        error = errors_deg(build_setting(study), antenna=antenna, poses=poses)
        middle, high = np.quantile(error, [0.5, 0.9])
        beyond = 100.0 * float((error > math.degrees(math.pi / 2)).mean())
        print(
            f"{name:24s}{f'{middle:.1f} / {high:.1f}':>22s}{prototype:>16s}{beyond:9.1f}%"
            f"{time.perf_counter() - began:7.1f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
