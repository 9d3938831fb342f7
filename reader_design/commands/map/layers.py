"""What ``octant map`` maps for one tag, layer by layer, and the dataset that holds them all."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.antennas.kinds import make_antenna
from octant.em.power.channel_spreads import ChannelSpreads, channel_spreads
from octant.em.power.disc_mean import mean_over_disc
from octant.em.power.radio_map import RadioMap, map_antenna, map_reader
from octant.em.power.received_power import antenna_power
from octant.navigation.angles import wrap_angle
from octant.reader_design.setting.links import tag_link
from octant.reader_design.setting.measures import vector_sum_bearing_rad
from octant.reader_design.setting.setting import PlacedTag, Setting, candidates_from
from octant.reader_design.showing.netcdf import dataset, variable
from octant.reader_design.study_file.loading import to_toml
from octant.reader_design.study_file.schema import Study

if TYPE_CHECKING:
    import xarray as xr

FloatArray = npt.NDArray[np.float64]
Axes = tuple[FloatArray, FloatArray]
NANOSECONDS_PER_SECOND = 1e9


@dataclass(frozen=True, slots=True, kw_only=True)
class TagLayers:
    """Everything that is mapped for one tag.

    Parameters
    ----------
    tag : PlacedTag
        The tag, which transmits.
    power : RadioMap
        Coherent power, power sum and number of paths [W],.
    disc_mean_w : ndarray or None
        Mean of the coherent power over a disc of one wavelength [W], in the shape of the power.
    spreads : ChannelSpreads or None
        Spreads of the channel, (nx ny,) [s], [rad].
    """

    tag: PlacedTag
    power: RadioMap
    disc_mean_w: FloatArray | None = None
    spreads: ChannelSpreads | None = None


def heading_deg(study: Study) -> float:
    """Return the heading of the robot on a map [deg]: that of the mission's start, or 90.

    Parameters
    ----------
    study : Study
        The study.
    """
    return 90.0 if study.mission is None else study.mission.heading_deg


def tag_map(
    study: Study,
    built: Setting,
    tag: PlacedTag,
    responses: Sequence[ReaderResponse],
    *,
    axes: Axes,
    told: Callable[[int], None],
) -> RadioMap:
    """Return the power map of one tag [W].

    Parameters
    ----------
    study : Study
        The study.
    built : Setting
        Its room.
    tag : PlacedTag
        The tag.
    responses : sequence of ReaderResponse
        The reader's, one a frequency; none for one isotropic_theta antenna.
    axes : pair of (k,) float64
        Grid in x and y [m].
    told : callable
        Told how many places are done [-].

    Returns
    -------
    RadioMap
        Of all antennas of the reader, or of the one.
    """
    x_m, y_m = axes

    def rows_done(rows: int, _: int) -> None:
        told(rows)

    if responses:
        link = tag_link(study, built, tag, responses, height_m=study.map.height_m)
        heading = math.radians(heading_deg(study))
        return map_reader(link, x_m=x_m, y_m=y_m, heading_rad=heading, progress=rows_done)
    found = candidates_from(study, built.radios[0], tag.position_m)
    maps = [
        map_antenna(
            radio,
            found,
            x_m=x_m,
            y_m=y_m,
            z_m=built.map_z_m,
            transmitter=sender,
            receiver=make_antenna("isotropic_theta", radio.frequency_hz),
            power_w=study.radio.tag_power_w,
            progress=rows_done,
        )
        for radio, sender in zip(built.radios, tag.antennas, strict=True)
    ]
    return replace(
        maps[0],
        coherent_w=np.mean([m.coherent_w for m in maps], axis=0),
        local_mean_w=np.mean([m.local_mean_w for m in maps], axis=0),
    )


def disc_map(
    study: Study,
    built: Setting,
    tag: PlacedTag,
    responses: Sequence[ReaderResponse],
    *,
    axes: Axes,
    told: Callable[[int], None],
) -> FloatArray:
    """Return the mean of the coherent power over a disc of one wavelength at each place [W].

    Parameters
    ----------
    study, built, tag, responses, axes
        As in `tag_map` [m].
    told : callable
        Told how many places of each disc are done [-].

    Returns
    -------
    (nx, ny) or (nx, ny, n) float64
        Power [W], over the part of the disc that is in the room and in no object.
    """
    places = _places(axes, built)
    if responses:
        link = tag_link(study, built, tag, responses, height_m=study.map.height_m)
        heading = math.radians(heading_deg(study))

        def power_w(at: FloatArray) -> FloatArray:
            return link.rss_w(np.column_stack((at[:, :2], np.full(len(at), heading))))
    else:
        found = candidates_from(study, built.radios[0], tag.position_m)

        def power_w(at: FloatArray) -> FloatArray:
            parts = [
                antenna_power(
                    radio,
                    found,
                    at,
                    transmitter=sender,
                    receiver=make_antenna("isotropic_theta", radio.frequency_hz),
                    power_w=study.radio.tag_power_w,
                ).coherent_w
                for radio, sender in zip(built.radios, tag.antennas, strict=True)
            ]
            return np.asarray(np.mean(parts, axis=0))

    mean = mean_over_disc(
        power_w,
        places,
        diameter_m=built.radios[0].wavelength_m,
        usable=lambda at: open_places(built, at),
        told=told,
    )
    return mean.reshape(len(axes[0]), len(axes[1]), *mean.shape[1:])


def spread_map(
    study: Study,
    built: Setting,
    tag: PlacedTag,
    *,
    axes: Axes,
    told: Callable[[int], None],
) -> ChannelSpreads:
    """Return the spreads of the channel from a tag to an isotropic_theta antenna.

    Parameters
    ----------
    study, built, tag, axes, told
        As in `tag_map` [m].

    Returns
    -------
    ChannelSpreads
        (nx ny,) [s] and [rad], at the first frequency of the study.
    """
    radio = built.radios[0]
    found = candidates_from(study, radio, tag.position_m)
    return channel_spreads(
        radio,
        found,
        _places(axes, built),
        transmitter=tag.antennas[0],
        receiver=make_antenna("isotropic_theta", radio.frequency_hz),
        progress=lambda rows, _: told(rows),
    )


def open_places(built: Setting, places_m: FloatArray) -> npt.NDArray[np.bool_]:
    """Return at which places an antenna can be: in the room, in no object [-].

    Parameters
    ----------
    built : Setting
        The room.
    places_m : (k, 3) float64
        Places [m].

    Returns
    -------
    (k,) bool
        Whether each is open [-].
    """
    return built.scene.inside_room(places_m) & ~built.scene.inside_solid(places_m)


def strongest_antenna(rss_w: FloatArray) -> npt.NDArray[np.int64]:
    """Return the number of the strongest antenna, from 1; 0 where nothing is received [-].

    Parameters
    ----------
    rss_w : (..., n) float64
        RSS [W]; of equal ones the first counts.
    """
    return np.where(rss_w.max(axis=-1) > 0.0, rss_w.argmax(axis=-1) + 1, 0)


def bearing_error_rad(
    rss_w: FloatArray, axes: Axes, *, point_m: FloatArray, heading_rad: float
) -> FloatArray:
    """Return the error of the RSS-weighted vector sum's bearing at each place [rad].

    Parameters
    ----------
    rss_w : (nx, ny, n) float64
        RSS of all antennas [W].
    axes : pair of (k,) float64
        Grid in x and y [m].
    point_m : (2,) float64
        Where the tag is, seen from above [m].
    heading_rad : float
        Heading of the robot [rad].

    Returns
    -------
    (nx, ny) float64
        Bearing less true bearing, from -pi to pi [rad]; NaN where the sum has no direction.
    """
    n = rss_w.shape[-1]
    bearing = vector_sum_bearing_rad(rss_w, np.arange(n) * (2.0 * math.pi / n))
    true = np.arctan2(point_m[1] - axes[1][None, :], point_m[0] - axes[0][:, None])
    return wrap_angle(bearing + heading_rad - 0.5 * math.pi - true)


def map_dataset(
    study: Study, layers: Sequence[TagLayers], *, antenna: int | None, local_mean: bool
) -> "xr.Dataset":
    """Return the dataset of all tags' layers, with units and names.

    Parameters
    ----------
    study : Study
        The study.
    layers : sequence of TagLayers
        One a tag, at least one.
    antenna : int or None
        Number of the only antenna of the reader that is kept, from 1; None: all.
    local_mean : bool
        Whether the power sum over paths is stored too.

    Returns
    -------
    xarray.Dataset
        Dimensions tag, x, y and, for a reader, antenna.
    """
    first = layers[0].power
    of_reader = first.coherent_w.ndim == 3
    chosen = slice(None) if antenna is None else slice(antenna - 1, antenna)
    dims = ["tag", "x", "y", "antenna"] if of_reader else ["tag", "x", "y"]

    def power(values: Sequence[FloatArray], what: str) -> "xr.Variable":
        stacked = np.stack(values)
        named = stacked[..., chosen] if of_reader else stacked
        return variable(dims, named, units="W", long_name=f"received power, {what}")

    coordinates = {
        "tag": variable(["tag"], [e.tag.id for e in layers], units="1", long_name="tag"),
        "x": variable(["x"], first.x_m, units="m", long_name="x in the room"),
        "y": variable(["y"], first.y_m, units="m", long_name="y in the room"),
        "z": variable([], first.z_m, units="m", long_name="height of the receiver"),
    }
    variables = {
        "rss_w": power([e.power.coherent_w for e in layers], "coherent sum"),
        "path_count": variable(
            dims[:3],
            np.stack([e.power.path_count for e in layers]),
            units="1",
            long_name="number of paths that arrive",
        ),
    }
    if of_reader:
        numbers = np.arange(1, study.reader.antennas + 1)[chosen]
        coordinates["antenna"] = variable(
            ["antenna"], numbers, units="1", long_name="antenna of the reader"
        )
        coordinates["heading"] = variable(
            [], heading_deg(study), units="degree", long_name="heading of the robot"
        )
    if local_mean:
        variables["rss_local_mean_w"] = power(
            [e.power.local_mean_w for e in layers], "sum over paths"
        )
    if all(e.disc_mean_w is not None for e in layers):
        means = [e.disc_mean_w for e in layers if e.disc_mean_w is not None]
        variables["rss_disc_mean_w"] = power(means, "mean over a disc of one wavelength")
    if of_reader and antenna is None:
        variables |= _bearing_variables(study, layers)
    if all(e.spreads is not None for e in layers):
        variables |= _spread_variables(layers)
    return dataset(
        variables,
        coordinates=coordinates,
        study_toml=to_toml(study),
        seed=study.seed,
        title=f"{study.name}: received power over the floor",
        attributes={"receiver": "reader" if of_reader else "isotropic_theta"},
    )


def _bearing_variables(study: Study, layers: Sequence[TagLayers]) -> dict[str, "xr.Variable"]:
    heading_rad = math.radians(heading_deg(study))
    errors = [
        bearing_error_rad(
            e.power.coherent_w,
            (e.power.x_m, e.power.y_m),
            point_m=e.tag.position_m[:2],
            heading_rad=heading_rad,
        )
        for e in layers
    ]
    dims = ["tag", "x", "y"]
    return {
        "strongest_antenna": variable(
            dims,
            np.stack([strongest_antenna(e.power.coherent_w) for e in layers]),
            units="1",
            long_name="strongest antenna (coherent), 0 where nothing is received",
        ),
        "bearing_error": variable(
            dims,
            np.degrees(np.stack(errors)),
            units="degree",
            long_name="bearing of the RSS-weighted vector sum less the true bearing of the tag",
        ),
    }


def _spread_variables(layers: Sequence[TagLayers]) -> dict[str, "xr.Variable"]:
    shape = layers[0].power.path_count.shape
    spreads = [e.spreads for e in layers if e.spreads is not None]

    def layer(name: str, scale: float) -> FloatArray:
        return np.stack([scale * getattr(s, name).reshape(shape) for s in spreads])

    dims, degrees = ["tag", "x", "y"], 180.0 / math.pi
    return {
        "delay_spread": variable(
            dims,
            layer("delay_spread_s", NANOSECONDS_PER_SECOND),
            units="ns",
            long_name="rms delay spread, power-weighted over paths",
        ),
        "azimuth_spread": variable(
            dims,
            layer("azimuth_spread_rad", degrees),
            units="degree",
            long_name="circular angle spread of the azimuth of arrival (3GPP TR 38.901, Annex A)",
        ),
        "direction_spread": variable(
            dims,
            layer("direction_spread_rad", degrees),
            units="degree",
            long_name="rms spread of the direction of arrival over the sphere (Fleury 2000)",
        ),
    }


def _places(axes: Axes, built: Setting) -> FloatArray:
    x, y = np.meshgrid(*axes, indexing="ij")
    return np.column_stack((x.ravel(), y.ravel(), np.full(x.size, built.map_z_m)))
