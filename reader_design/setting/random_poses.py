"""Bearing errors at random poses: the quick look at a room, without a sweep."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.navigation.sensing.bearing import reader_azimuth
from octant.reader_design.setting.bearing_errors import vector_errors_rad
from octant.reader_design.setting.links import tag_link
from octant.reader_design.setting.samples import standing_room
from octant.reader_design.setting.setting import Setting
from octant.reader_design.study_file.schema import Study

FloatArray = npt.NDArray[np.float64]


def random_pose_errors_rad(
    study: Study,
    setting: Setting,
    responses: Sequence[ReaderResponse],
    *,
    area_m: tuple[float, float],
    poses: int,
    rng: np.random.Generator,
) -> FloatArray:
    """Return the bearing errors of the vector sum at poses drawn evenly over an area [rad].

    Parameters
    ----------
    study : Study
        The study.
    setting : Setting
        One of its rooms.
    responses : sequence of ReaderResponse
        The reader's, one for each frequency.
    area_m : (float, float)
        Far corner of the area in x and y [m]; the near one is the room's origin of coordinates.
    poses : int
        Poses that are drawn; those where the reader does not fit are left out.
    rng : numpy.random.Generator
        Draws places, headings, and the tag that is asked for.

    Returns
    -------
    (k,) float64
        Estimate minus truth [rad], pi without a bearing.
    """
    places = rng.uniform((0.0, 0.0), area_m, (poses, 2))
    headings = rng.uniform(-np.pi, np.pi, poses)
    asked = rng.integers(len(setting.tags), size=poses)
    fits = standing_room(
        setting.scene,
        places,
        reader_z_m=setting.reader_z_m,
        clearance_m=study.reader.ground_plane_m / 2.0,
    )
    errors = []
    for number, tag in enumerate(setting.tags):
        mine = fits & (asked == number)
        if not mine.any():
            continue
        rss = tag_link(study, setting, tag, responses).rss_w(
            np.column_stack([places[mine], headings[mine]])
        )
        towards = np.arctan2(*(tag.position_m[:2] - places[mine]).T[::-1])
        azimuth = reader_azimuth(headings[mine], towards)
        elements = responses[0].azimuths_rad
        errors.append(vector_errors_rad(rss[:, None], azimuth[:, None], elements)[:, 0])
    return np.concatenate(errors)
