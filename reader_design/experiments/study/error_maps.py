"""Maps over all headings: bearing error, capture, and RSS at some headings for the report."""

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.em.power.backscatter import Link
from octant.navigation.sensing.bearing import reader_azimuth
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.bearing_errors import vector_errors_rad
from octant.reader_design.setting.capture import arriving_paths, captured
from octant.reader_design.setting.measures import strongest_errors_rad
from octant.reader_design.setting.samples import grid_azimuths_rad
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.map_view import (
    explorer_headings_rad,
    map_stride,
    symmetric_turn,
)
from octant.reader_design.showing.netcdf import variable

if TYPE_CHECKING:
    import xarray as xr

FloatArray = npt.NDArray[np.float64]

BLOCK = 2048
"""Places that are worked on at a time [-]: bounds the memory."""


def heading_errors_rad(
    link: Link, rss: FloatArray, places_m: FloatArray, headings_rad: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the rms error over all headings of vector sum and strongest antenna, (p,) each [rad].

    Parameters
    ----------
    link : From the tag to the reader.
    rss : (p, h, n) float64 — Power at these places and headings [W].
    places_m, headings_rad : (p, 2), (h,) float64 — Places [m] and headings [rad] of the robot.
    """
    towards = np.arctan2(*(link.tag_position_m[:2] - places_m).T[::-1])
    azimuths = reader_azimuth(headings_rad, towards[:, None])
    vector = vector_errors_rad(rss, azimuths, link.azimuths_rad)
    strongest = np.empty(len(places_m))
    for i, (row, azimuth) in enumerate(zip(rss, azimuths, strict=True)):
        error, weight = strongest_errors_rad(row[None], azimuth, link.azimuths_rad)
        strongest[i] = np.sqrt((weight * error**2).sum() / headings_rad.size)
    return np.sqrt((vector**2).mean(axis=1)), strongest


def error_maps(
    setting: Setting,
    places_m: FloatArray,
    standing: npt.NDArray[np.bool_],
    heading_rad: float,
    progress: Progress,
) -> "dict[str, xr.Variable]":
    """Return the maps (tag, x, y) of two bearing errors, rms over headings [rad], and of capture.

    And ``turned_rss_w`` and ``turned_local_mean_rss_w`` (heading, tag, map_x, map_y, antenna): on a
    thinned grid the RSS [W] at those headings from which the reader's symmetry gives the others.

    Parameters
    ----------
    setting, progress : Reader and room, its sampling gives the number of headings; shows places.
    places_m, standing : (nx, ny, 2), (nx, ny) — Grid [m]; where the reader fits: elsewhere NaN.
    heading_rad : Heading that must be among those of the RSS [rad].
    """
    headings = grid_azimuths_rad(setting.responses[0].antennas, setting.sampling.room_azimuths)
    n = setting.responses[0].antennas
    turn = symmetric_turn(setting.responses[0])
    some = explorer_headings_rad(headings, heading_rad, n, turn)
    chosen = [int(np.flatnonzero(headings == one)[0]) for one in some]
    every = map_stride(standing.shape)
    thin = standing[::every, ::every]
    grid = np.zeros(standing.shape, dtype=np.bool_)
    grid[::every, ::every] = thin
    taken = grid[standing]
    turned = np.zeros((2, len(some), len(setting.tags), *thin.shape, n), dtype=np.float32)
    places = places_m[standing]
    tables = np.full((3, len(setting.tags), *standing.shape), np.nan)
    for number, tag in enumerate(setting.tags):
        link = setting.link(tag, places_m=places)
        columns = np.empty((3, len(places)))
        powers = []
        with progress.count(len(places), label=f"bearing errors of tag {tag.id}") as done:
            for begin in range(0, len(places), BLOCK):
                block = slice(begin, begin + BLOCK)
                near = places[block]
                found = link.power_by_heading(near, headings)
                columns[:2, block] = heading_errors_rad(link, found.coherent_w, near, headings)
                both = np.stack([found.coherent_w, found.local_mean_w])
                powers.append(both[:, taken[block]][:, :, chosen].astype(np.float32))
                towards = np.arctan2(*(tag.position_m[:2] - near).T[::-1])
                paths = arriving_paths(setting, tag, near)
                columns[2, block] = captured(paths, towards, setting.responses).mean(axis=1)
                done(begin + len(near))
        tables[:, number, standing] = columns
        turned[:, :, number, thin] = np.moveaxis(np.concatenate(powers, axis=1), 2, 1)
    turned_dims = ["heading", "tag", "map_x", "map_y", "antenna"]
    dims = ["tag", "x", "y"]
    over, nowhere = "over all headings of the robot", "the reader does not fit there"
    return {
        "vector_error": variable(
            dims,
            tables[0],
            units="rad",
            long_name=f"rms error of the vector sum {over}",
            missing=nowhere,
        ),
        "strongest_error": variable(
            dims,
            tables[1],
            units="rad",
            long_name=f"rms error of the strongest antenna {over}",
            missing=nowhere,
        ),
        "captured_share": variable(
            dims,
            tables[2],
            units="1",
            long_name="share of facing antennas at which a reflection beats the direct ray",
            missing=nowhere,
        ),
        "turned_rss_w": variable(
            turned_dims,
            turned[0],
            units="W",
            long_name="coherent RSS at some headings, 0: no place",
        ),
        "turned_local_mean_rss_w": variable(
            turned_dims, turned[1], units="W", long_name="power sum over paths at some headings"
        ),
        "turned_heading": variable(
            ["heading"], some, units="rad", long_name="heading of the robot in these maps"
        ),
    }
