"""Maps of the bearing error over the floor, all headings together, and of capture."""

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
from octant.reader_design.showing.netcdf import variable

if TYPE_CHECKING:
    import xarray as xr

FloatArray = npt.NDArray[np.float64]

BLOCK = 2048
"""Places that are worked on at a time [-]: bounds the memory."""


def heading_errors_rad(
    link: Link, places_m: FloatArray, headings_rad: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the rms error over all headings of vector sum and strongest antenna, (p,) each [rad].

    Parameters
    ----------
    link : From the tag to the reader.
    places_m, headings_rad : (p, 2), (h,) float64 — Places [m] and headings [rad] of the robot.
    """
    rss = link.rss_by_heading_w(places_m, headings_rad)
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
    progress: Progress,
) -> "dict[str, xr.Variable]":
    """Return the maps (tag, x, y) of two bearing errors, rms over headings [rad], and of capture.

    Parameters
    ----------
    setting, progress : Reader and room, its sampling gives the number of headings; shows places.
    places_m, standing : (nx, ny, 2), (nx, ny) — Grid [m]; where the reader fits: elsewhere NaN.
    """
    headings = grid_azimuths_rad(setting.responses[0].antennas, setting.sampling.room_azimuths)
    places = places_m[standing]
    tables = np.full((3, len(setting.tags), *standing.shape), np.nan)
    for number, tag in enumerate(setting.tags):
        link = setting.link(tag)
        columns = np.empty((3, len(places)))
        with progress.count(len(places), label=f"bearing errors of tag {tag.id}") as done:
            for begin in range(0, len(places), BLOCK):
                block = slice(begin, begin + BLOCK)
                near = places[block]
                columns[:2, block] = heading_errors_rad(link, near, headings)
                towards = np.arctan2(*(tag.position_m[:2] - near).T[::-1])
                paths = arriving_paths(setting, tag, near)
                columns[2, block] = captured(paths, towards, setting.responses).mean(axis=1)
                done(begin + len(near))
        tables[:, number, standing] = columns
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
    }
