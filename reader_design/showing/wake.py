"""Layers of a map for tags that the reader wakes: what chips get, and where that is enough."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.em.decibels import decibels
from octant.em.power.backscatter import Answers
from octant.reader_design.setting.read_range import ReadRange
from octant.reader_design.showing.netcdf import variable

if TYPE_CHECKING:
    import xarray as xr

FloatArray = npt.NDArray[np.float64]
ACTIVE = "the tag is active"
"""What NaN means."""
MARGIN_DB = 15.0
"""Margins beyond which the colour of a map stays [dB]."""


def wake_variables(
    answers: Sequence[Answers | None],
    ranges: Sequence[ReadRange | None],
    *,
    chosen: slice | list[int] = slice(None),
    of_reader: bool = True,
) -> "dict[str, xr.Variable]":
    """Return what tags take [W], by how much they wake [dB] and how far they are read [m]; or none.

    Parameters
    ----------
    answers, ranges : One a tag; None: an active one.
    chosen, of_reader : Antennas that are kept; False: one isotropic antenna, without an axis.
    """
    woken = [one for one in answers if one is not None]
    if not woken:
        return {}
    dims = ["tag", "x", "y", "antenna"] if of_reader else ["tag", "x", "y"]
    asleep = np.full(woken[0].chip_w.shape, np.nan)

    def each(name: str) -> FloatArray:
        parts = [asleep if one is None else getattr(one, name) for one in answers]
        stacked = np.stack(parts).astype(np.float64)
        return stacked[..., chosen] if of_reader else stacked

    def power(name: str, what: str) -> "xr.Variable":
        values = each(name)
        named = values if of_reader else values[..., 0]
        what = f"power at the tag's chip while the antenna is read, {what}"
        return variable(dims, named, units="W", long_name=what, missing=ACTIVE)

    distances = {
        "read_range": ("slant_m", "computed"),
        "read_range_closed_form": ("closed_form_m", "Friis with the gains in that direction"),
        "read_range_peak_gains": ("peak_m", "Friis with the greatest gains"),
    }
    return {
        "chip_power_w": power("chip_w", "coherent sum"),
        "chip_power_local_mean_w": power("chip_mean_w", "sum over paths"),
        "wake_margin_db": variable(
            ["tag", "x", "y"],
            decibels(each("margin").max(axis=-1)),
            units="dB",
            long_name="power at the tag's chip over what wakes it, best antenna and channel",
            missing=ACTIVE,
        ),
        "reading_antennas": variable(
            ["tag", "x", "y"],
            each("read").sum(axis=-1),
            units="1",
            long_name="number of antennas that read the tag",
            missing=ACTIVE,
        ),
        **{
            name: variable(
                ["tag"],
                [np.nan if one is None else getattr(one, key) for one in ranges],
                units="m",
                long_name=f"distance up to which the tag is read in the open, {what}",
                missing="the tag is active, or the transmitter stands in the room",
            )
            for name, (key, what) in distances.items()
        },
    }


def wake_lines(tag_id: str, found: Answers, distance: ReadRange | None) -> Iterator[str]:
    """Yield where a tag wakes and is read, and how far in the open, in words ([dB], [m]).

    Parameters
    ----------
    tag_id, found, distance : Name of a tag that the reader wakes; over a map; in the open.
    """
    margin_db = decibels(found.margin.max(axis=-1))
    read = found.read.any(axis=-1)
    heard = margin_db[np.isfinite(margin_db)]
    least, most = (heard.min(), heard.max()) if heard.size else (-np.inf, -np.inf)
    yield (
        f"tag {tag_id}: wakes at {int((margin_db >= 0.0).sum())} and is read at "
        f"{int(read.sum())} of {read.size} places; margin {least:.1f} to {most:.1f} dB."
    )
    if distance is not None:
        yield f"tag {tag_id}: {range_text(distance)}."


def range_text(found: ReadRange) -> str:
    """Return a read range in words [m].

    Parameters
    ----------
    found : From `octant.reader_design.setting.read_range.read_range`.
    """
    if found.slant_m == 0.0:
        return (
            "in the open it is read nowhere at this height; the greatest gains of both antennas "
            f"would reach {found.peak_m:.2f} m"
        )
    return (
        f"read range in the open {found.slant_m:.2f} m ({found.floor_m:.2f} m along the floor), "
        f"ended by {found.limit}; closed form {found.closed_form_m:.2f} m, with the greatest gains "
        f"of both antennas {found.peak_m:.2f} m"
    )
