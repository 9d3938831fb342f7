"""Maps over all headings: bearing error, capture, and RSS at some headings for the report."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.em.power.backscatter import Link
from octant.navigation.sensing.bearing import reader_azimuth
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


@dataclass(frozen=True, slots=True, kw_only=True)
class FloorGrid:
    """Where, and at which headings of the robot, the errors of a reader are mapped.

    Attributes
    ----------
    places_m, standing : (nx, ny, 2), (nx, ny) — Grid [m]; where the reader fits: elsewhere NaN.
    heading_rad : Heading that must be among those of the RSS [rad].
    """

    places_m: FloatArray
    standing: npt.NDArray[np.bool_]
    heading_rad: float

    @property
    def stride(self) -> int:
        """Every how many places of the grid the RSS at some headings is kept [-]."""
        return map_stride(self.standing.shape)

    def kept_headings_rad(self, setting: Setting) -> FloatArray:
        """Return the headings at which RSS is kept; symmetry gives the others [rad].

        Parameters
        ----------
        setting : The reader.
        """
        response = setting.responses[0]
        turn = symmetric_turn(response)
        return explorer_headings_rad(
            _headings_rad(setting), self.heading_rad, response.antennas, turn
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class TagErrors:
    """The errors of a reader for one tag, over all places at which it fits.

    Attributes
    ----------
    columns : (3, p) float64 — Two bearing errors, rms over headings [rad], and capture [-].
    powers_w : (2, q, h, n) float32 — Coherent RSS and power sum [W] at the places and headings at
        which they are kept.
    """

    columns: FloatArray
    powers_w: npt.NDArray[np.float32]


def _headings_rad(setting: Setting) -> FloatArray:
    return grid_azimuths_rad(setting.responses[0].antennas, setting.sampling.room_azimuths)


def tag_errors(
    setting: Setting, grid: FloorGrid, number: int, done: Callable[[int], None]
) -> TagErrors:
    """Return the errors for one tag ([rad], [-], [W]).

    Parameters
    ----------
    setting, grid, number : Reader and room; where; which of its tags, from 0.
    done : Called with how many places are done.
    """
    tag, headings = setting.tags[number], _headings_rad(setting)
    chosen = [int(np.flatnonzero(headings == h)[0]) for h in grid.kept_headings_rad(setting)]
    kept = np.zeros(grid.standing.shape, dtype=np.bool_)
    kept[:: grid.stride, :: grid.stride] = True
    taken = kept[grid.standing]
    places = grid.places_m[grid.standing]
    link = setting.link(tag, places_m=places)
    columns = np.empty((3, len(places)))
    powers = [np.zeros((2, 0, len(chosen), setting.responses[0].antennas), dtype=np.float32)]
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
    return TagErrors(columns=columns, powers_w=np.concatenate(powers, axis=1))


def error_maps(
    setting: Setting, grid: FloorGrid, errors: Sequence[TagErrors]
) -> "dict[str, xr.Variable]":
    """Return the maps (tag, x, y) of two bearing errors, rms over headings [rad], and of capture.

    And ``turned_rss_w`` and ``turned_local_mean_rss_w`` (heading, tag, map_x, map_y, antenna): on a
    thinned grid the RSS [W] at those headings from which the reader's symmetry gives the others.

    Parameters
    ----------
    setting, grid : Reader and room, its sampling gives the number of headings; where.
    errors : From `tag_errors`, one for each tag.
    """
    standing, some = grid.standing, grid.kept_headings_rad(setting)
    thin = standing[:: grid.stride, :: grid.stride]
    n = setting.responses[0].antennas
    turned = np.zeros((2, len(some), len(errors), *thin.shape, n), dtype=np.float32)
    tables = np.full((3, len(errors), *standing.shape), np.nan)
    for number, one in enumerate(errors):
        tables[:, number, standing] = one.columns
        turned[:, :, number, thin] = np.moveaxis(one.powers_w, 2, 1)
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
