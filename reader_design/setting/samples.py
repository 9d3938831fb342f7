"""Where a design is probed: the RSS of its antennas over distances, places and azimuths.

Poses are chosen so that the tag appears at the same grid of azimuths in the reader frame from
every place; free space and room then give arrays of one shape, (distance or place, azimuth,
antenna), which :mod:`octant.reader_design.setting.scores` averages.
"""

import math

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import ConfigError
from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS
from octant.navigation.sensing.sensor import PowerLink
from octant.reader_design.setting.placing import PlacedTag
from octant.reader_design.setting.setting import Setting

FloatArray = npt.NDArray[np.float64]


def grid_azimuths_rad(antennas: int, per_antenna: int) -> FloatArray:
    """Return azimuths evenly over the circle from 0, those of the antennas included [rad].

    Parameters
    ----------
    antennas, per_antenna : Number of antennas n, and azimuths for each.
    """
    count = antennas * per_antenna
    return 2.0 * np.pi * np.arange(count) / count


def facing_poses(
    points_m: npt.ArrayLike, tag_point_m: npt.ArrayLike, azimuths_rad: npt.ArrayLike
) -> FloatArray:
    """Return (p, a, 3) poses, x, y [m] and heading [rad], that see the tag at given azimuths.

    Parameters
    ----------
    points_m : (p, 2) array_like — Places of the robot [m].
    tag_point_m : (2,) array_like — Point under the tag [m].
    azimuths_rad : (a,) array_like — Azimuths of the tag in the reader frame [rad].

    Notes
    -----
    A robot of heading h has the reader frame turned by h - pi/2 (antenna 3 of 8 is the front), so
    a tag in room direction A appears at A - h + pi/2.
    """
    points = frozen_array(points_m, name="points_m", shape=(None, 2))
    tag = frozen_array(tag_point_m, name="tag_point_m", shape=(2,))
    azimuths = frozen_array(azimuths_rad, name="azimuths_rad", shape=(None,))
    towards = np.arctan2(tag[1] - points[:, 1], tag[0] - points[:, 0])
    poses = np.empty((len(points), len(azimuths), 3))
    poses[:, :, :2] = points[:, None, :]
    poses[:, :, 2] = towards[:, None] + math.pi / 2.0 - azimuths
    return poses


def sample_rss_w(
    link: PowerLink,
    points_m: npt.ArrayLike,
    tag_point_m: npt.ArrayLike,
    azimuths_rad: npt.ArrayLike,
) -> FloatArray:
    """Return the (p, a, n) RSS by place, azimuth of the tag and antenna [W].

    Parameters
    ----------
    link : From the tag to the reader.
    points_m : (p, 2) array_like — Places of the robot [m].
    tag_point_m : (2,) array_like — Point under the tag [m].
    azimuths_rad : (a,) array_like — Azimuths of the tag in the reader frame [rad].
    """
    poses = facing_poses(points_m, tag_point_m, azimuths_rad)
    return link.rss_w(poses.reshape(-1, 3)).reshape(*poses.shape[:2], -1)


def free_points_m(distances_m: npt.ArrayLike) -> FloatArray:
    """Return (d, 2) places along +x at given distances from a tag above the origin [m].

    Parameters
    ----------
    distances_m : (d,) array_like — Horizontal distances [m].
    """
    distance = np.asarray(distances_m, dtype=np.float64)
    return np.column_stack([distance, np.zeros(distance.size)])


def standing_room(
    scene: Scene, points_m: FloatArray, *, reader_z_m: float, clearance_m: float
) -> npt.NDArray[np.bool_]:
    """Return at which places of the floor the robot's reader fits [-].

    Inside the room, in no solid from the floor up to the reader, and clear of what is beside it.

    Parameters
    ----------
    scene : Room and objects.
    points_m : (p, 2) float64 — Places [m].
    reader_z_m : Height coordinate of the ground plane in the room's frame [m].
    clearance_m : Distance to keep between the reader's centre and walls or objects beside it [m].
    """
    fits = np.ones(len(points_m), dtype=np.bool_)
    if not scene.bodies:
        return fits
    column = np.column_stack([points_m, np.full(len(points_m), reader_z_m)])
    fits &= scene.inside_room(column)
    floor = scene.floor_height_m
    for z_m in np.linspace(floor + LENGTHS.step_m, reader_z_m, 4):
        column[:, 2] = z_m
        fits &= ~scene.inside_solid(column)
    distance = scene.distance_to_facets_m(column)[0]
    fits &= distance >= min(clearance_m, 0.999 * (reader_z_m - floor))
    return fits


def floor_points_m(
    scene: Scene, *, spacing_m: float, reader_z_m: float, clearance_m: float
) -> FloatArray:
    """Return the places of a square grid on which the reader fits [m].

    Parameters
    ----------
    scene : A room; its bounds carry the grid, centred in them.
    spacing_m : Step of the grid [m].
    reader_z_m : Height coordinate of the ground plane in the room's frame [m].
    clearance_m : See :func:`standing_room` [m].
    """
    axes = []
    for low, high in zip(scene.bounds_m[0, :2], scene.bounds_m[1, :2], strict=True):
        count = max(1, math.floor((high - low) / spacing_m + 1e-9))
        offset = 0.5 * ((high - low) - (count - 1) * spacing_m)
        axes.append(low + offset + spacing_m * np.arange(count))
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    fits = standing_room(scene, grid, reader_z_m=reader_z_m, clearance_m=clearance_m)
    return grid[fits]


def room_places_m(setting: Setting) -> list[tuple[PlacedTag, FloatArray]]:
    """Return tags with their places in range where the reader fits [m]; refuse when there are none.

    Parameters
    ----------
    setting : The room; its sampling gives grid and range [m].
    """
    sampling = setting.sampling
    places = floor_points_m(
        setting.scene,
        spacing_m=sampling.room_spacing_m,
        reader_z_m=setting.reader_z_m,
        clearance_m=setting.reader.ground_plane_m / 2.0,
    )
    found = []
    for tag in setting.tags:
        distance = np.hypot(*(places - tag.position_m[:2]).T)
        near = distance >= sampling.nearest_m - LENGTHS.same_m
        near &= distance <= sampling.farthest_m + LENGTHS.same_m
        if near.any():
            found.append((tag, places[near]))
    if not found:
        msg = (
            f"none of the {len(places)} places on the floor lies {sampling.nearest_m:g} to "
            f"{sampling.farthest_m:g} m from a tag; check the tags' positions and the room."
        )
        raise ConfigError(msg)
    return found
