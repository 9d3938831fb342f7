"""Received power: pose by pose, and over the floor of a room as a dataset of layers."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import make_antenna
from octant.em.decibels import power_dbm
from octant.em.power.backscatter import Answers, BackscatterLink, Link
from octant.em.power.channel_spreads import ChannelSpreads, channel_spreads
from octant.em.power.disc_mean import DISC_PLACES, mean_over_disc
from octant.em.power.radio_map import RadioMap, map_antenna, map_backscatter, map_reader
from octant.em.power.received_power import antenna_power
from octant.geometries.errors import ConfigError
from octant.navigation.angles import wrap_angle
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.advice import refuse_buried, refuse_under_floor
from octant.reader_design.setting.cost import Cost, field_cost, reader_cost
from octant.reader_design.setting.map_grid import LARGEST_MAP, map_axes_m
from octant.reader_design.setting.measures import vector_sum_bearing_rad
from octant.reader_design.setting.placing import PlacedTag
from octant.reader_design.setting.read_range import ReadRange, read_range
from octant.reader_design.setting.rfid import is_woken, isotropic_responses
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.setting.solving import solved
from octant.reader_design.showing.netcdf import dataset, variable
from octant.reader_design.showing.wake import wake_lines, wake_variables
from octant.reader_design.study_file.calibration import sent_w
from octant.reader_design.study_file.loading import to_toml
from octant.reader_design.study_file.schema import Study

if TYPE_CHECKING:
    import xarray as xr

FloatArray = npt.NDArray[np.float64]
Axes = tuple[FloatArray, FloatArray]
NANOSECONDS_PER_SECOND = 1e9
OPEN_FLOOR = "open_floor"
"""The variable of a map that says where a receiver can be."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TagLayers:
    """Everything that is mapped for one tag, which transmits.

    Parameters
    ----------
    tag, power : The tag; coherent power, power sum [W] and number of paths.
    disc_mean_w : Mean of the coherent power over a disc of one wavelength, shaped as it [W].
    spreads : Spreads of the channel, (nx ny,) [s], [rad].
    answers, read_range : Of a tag that the reader wakes: what it takes and answers, (nx, ny, n)
        [W]; how far it is read in the open [m].
    """

    tag: PlacedTag
    power: RadioMap
    disc_mean_w: FloatArray | None = None
    spreads: ChannelSpreads | None = None
    answers: Answers | None = None
    read_range: ReadRange | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class MapView:
    """From where the tags of a map are seen.

    Attributes
    ----------
    axes, heading_rad : Grid in x and y [m]; heading of the robot [rad].
    isotropic : Whether one isotropic_theta antenna receives in place of the reader.
    """

    axes: Axes
    heading_rad: float
    isotropic: bool


def tag_map(
    setting: Setting,
    tag: PlacedTag,
    view: MapView,
    *,
    progress: Callable[[int], None],
) -> RadioMap:
    """Return the power map of one tag [W].

    Parameters
    ----------
    setting, tag, view : The reader in its room, the tag, and from where it is seen.
    progress : Called with the number of places that are done.
    """
    x_m, y_m = view.axes

    def rows_done(rows: int, _: int) -> None:
        progress(rows)

    if not view.isotropic:
        height_m, places = setting.study.map.height_m, _places(view.axes, setting)
        link = setting.link(tag, height_m=height_m, places_m=places[:, :2])
        return map_reader(link, x_m=x_m, y_m=y_m, heading_rad=view.heading_rad, progress=rows_done)
    found = setting.candidates(tag.position_m, receivers_m=_places(view.axes, setting))
    maps = [
        map_antenna(
            radio,
            found,
            x_m=x_m,
            y_m=y_m,
            z_m=setting.map_z_m,
            transmitter=transmitter,
            receiver=make_antenna("isotropic_theta", radio.frequency_hz),
            power_w=sent_w(setting.study, tag.id),
            progress=rows_done,
        )
        for radio, transmitter in zip(setting.radios, tag.antennas, strict=True)
    ]
    return replace(
        maps[0],
        coherent_w=np.mean([m.coherent_w for m in maps], axis=0),
        local_mean_w=np.mean([m.local_mean_w for m in maps], axis=0),
    )


def woken_map(
    setting: Setting,
    tag: PlacedTag,
    view: MapView,
    *,
    progress: Callable[[int], None],
) -> TagLayers:
    """Return the map of one tag that the reader wakes: what comes back [W], and what it takes.

    Parameters
    ----------
    setting, tag, view, progress : As in `tag_map`.
    """
    seen = _seen_by(setting, view)
    height_m, places = setting.study.map.height_m, _places(view.axes, setting)
    link = seen.link(tag, height_m=height_m, places_m=places[:, :2])
    if not isinstance(link, BackscatterLink):
        msg = f"tag {tag.id!r} is active, so that no reader wakes it; map it as what it sends."
        raise ConfigError(msg)
    power, found = map_backscatter(
        link,
        x_m=view.axes[0],
        y_m=view.axes[1],
        heading_rad=view.heading_rad,
        progress=lambda rows, _: progress(rows),
    )
    if view.isotropic:  # no axis of antennas
        means = power.local_mean_w[..., 0]
        power = replace(power, coherent_w=power.coherent_w[..., 0], local_mean_w=means)
    return TagLayers(tag=tag, power=power, answers=found, read_range=read_range(seen, tag))


def _seen_by(setting: Setting, view: MapView) -> Setting:
    """Return the setting with the reader that a map is for: one isotropic antenna, or its own."""
    if not view.isotropic:
        return setting
    return setting.with_responses(isotropic_responses(setting.study.radio.frequencies_hz))


def disc_map(
    setting: Setting,
    tag: PlacedTag,
    view: MapView,
    *,
    progress: Callable[[int], None],
) -> FloatArray:
    """Return the coherent power's mean over discs of one wavelength, (nx, ny) or (nx, ny, n) [W].

    Only the part of a disc that is in the room and in no object counts.

    Parameters
    ----------
    setting, tag, view : As in `tag_map`.
    progress : Called with the number of places of each disc that are done.
    """
    places = _places(view.axes, setting)
    if not view.isotropic or is_woken(setting.study, tag):
        link = _seen_by(setting, view).link(tag, height_m=setting.study.map.height_m)

        def power_w(at: FloatArray) -> FloatArray:
            rss = link.rss_w(np.column_stack((at[:, :2], np.full(len(at), view.heading_rad))))
            return rss[:, 0] if view.isotropic else rss
    else:
        found = setting.candidates(tag.position_m)

        def power_w(at: FloatArray) -> FloatArray:
            parts = [
                antenna_power(
                    radio,
                    found,
                    at,
                    transmitter=transmitter,
                    receiver=make_antenna("isotropic_theta", radio.frequency_hz),
                    power_w=sent_w(setting.study, tag.id),
                ).coherent_w
                for radio, transmitter in zip(setting.radios, tag.antennas, strict=True)
            ]
            return np.asarray(np.mean(parts, axis=0))

    mean = mean_over_disc(
        power_w,
        places,
        diameter_m=setting.radios[0].wavelength_m,
        usable=lambda at: open_places(setting, at),
        progress=progress,
    )
    return mean.reshape(len(view.axes[0]), len(view.axes[1]), *mean.shape[1:])


def spread_map(
    setting: Setting,
    tag: PlacedTag,
    view: MapView,
    *,
    progress: Callable[[int], None],
) -> ChannelSpreads:
    """Return spreads from a tag to isotropic_theta at the first frequency, (nx ny,) [s], [rad].

    Parameters
    ----------
    setting, tag, view, progress : As in `tag_map`.
    """
    radio = setting.radios[0]
    places = _places(view.axes, setting)
    found = setting.candidates(tag.position_m, receivers_m=places)
    return channel_spreads(
        radio,
        found,
        places,
        transmitter=tag.antennas[0],
        receiver=make_antenna("isotropic_theta", radio.frequency_hz),
        progress=lambda rows, _: progress(rows),
    )


def open_places(setting: Setting, places_m: FloatArray) -> npt.NDArray[np.bool_]:
    """Return at which places an antenna can be: in the room, in no object, (k,).

    Parameters
    ----------
    setting : The room.
    places_m : (k, 3) float64 — Places [m].
    """
    return setting.scene.inside_room(places_m) & ~setting.scene.inside_solid(places_m)


def strongest_antenna(rss_w: FloatArray) -> npt.NDArray[np.int64]:
    """Return the number of the strongest antenna, from 1; 0 where nothing is received [-].

    Parameters
    ----------
    rss_w : (..., n) float64 — RSS [W]; of equal ones the first counts.
    """
    return np.where(rss_w.max(axis=-1) > 0.0, rss_w.argmax(axis=-1) + 1, 0)


def bearing_error_rad(
    rss_w: FloatArray, axes: Axes, *, point_m: FloatArray, heading_rad: float
) -> FloatArray:
    """Return the vector sum's bearing less the true one in [-pi, pi], NaN without direction [rad].

    Parameters
    ----------
    rss_w : (nx, ny, n) float64 — RSS of all antennas [W].
    axes, point_m : Grid in x and y, and the tag's place from above, (2,) [m].
    heading_rad : Heading of the robot [rad].
    """
    n = rss_w.shape[-1]
    bearing = vector_sum_bearing_rad(rss_w, np.arange(n) * (2.0 * math.pi / n))
    true = np.arctan2(point_m[1] - axes[1][None, :], point_m[0] - axes[0][:, None])
    return wrap_angle(bearing + heading_rad - 0.5 * math.pi - true)


def map_dataset(
    study: Study,
    layers: Sequence[TagLayers],
    *,
    open_floor: npt.NDArray[np.bool_],
    antennas: Sequence[int] | None,
    heading_deg: float,
    local_mean: bool,
) -> "xr.Dataset":
    """Return all tags' layers over tag, x, y and, for a reader, antenna, with units and names.

    Parameters
    ----------
    study, layers : The study, and one item a tag, at least one.
    open_floor : (nx * ny,) bool — Where a receiver can be.
    antennas : Numbers of the reader's antennas that are kept, from 1; None: all.
    heading_deg : Heading of the robot [deg].
    local_mean : Whether the power sum over paths is stored too.
    """
    first = layers[0].power
    of_reader = first.coherent_w.ndim == 3
    chosen = slice(None) if antennas is None else [number - 1 for number in antennas]
    dims = ["tag", "x", "y", "antenna"] if of_reader else ["tag", "x", "y"]

    def power(values: Sequence[FloatArray], what: str, missing: str = "") -> "xr.Variable":
        stacked = np.stack(values)
        named = stacked[..., chosen] if of_reader else stacked
        what = f"received power, {what}"
        return variable(dims, named, units="W", long_name=what, missing=missing)

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
            [], heading_deg, units="degree", long_name="heading of the robot"
        )
    if local_mean:
        both = any(e.answers is not None for e in layers)
        variables["rss_local_mean_w"] = power(
            [e.power.local_mean_w for e in layers],
            "sum over paths" + (", of tags that answer both ways' sums multiplied" if both else ""),
        )
    if all(e.disc_mean_w is not None for e in layers):
        means = [e.disc_mean_w for e in layers if e.disc_mean_w is not None]
        variables["rss_disc_mean_w"] = power(
            means,
            "mean over a disc of one wavelength",
            missing="no part of the disc is in the room and outside its objects",
        )
    if of_reader and antennas is None:
        variables |= _bearing_variables(layers, math.radians(heading_deg))
    if all(e.spreads is not None for e in layers):
        variables |= _spread_variables(layers)
    variables |= wake_variables(
        [e.answers for e in layers],
        [e.read_range for e in layers],
        chosen=chosen,
        of_reader=of_reader,
    )
    variables[OPEN_FLOOR] = variable(
        ["x", "y"],
        open_floor.reshape(len(first.x_m), len(first.y_m)).astype(np.int8),
        units="1",
        long_name="1 where a receiver can be: in the room and in no object",
    )
    return dataset(
        variables,
        coordinates=coordinates,
        study_toml=to_toml(study),
        seed=study.seed,
        title=f"{study.name}: received power over the floor",
        attributes={"receiver": "reader" if of_reader else "isotropic_theta"}
        | _ray_attributes(layers),
    )


def _ray_attributes(layers: Sequence[TagLayers]) -> dict[str, Any]:
    """Return what rays have not found of the power, of the tag of which they miss most [dB]."""
    found = [layer.power.rays for layer in layers if layer.power.rays is not None]
    return max(
        (share.attributes() for share in found), key=lambda one: one["missing_share"], default={}
    )


def _bearing_variables(layers: Sequence[TagLayers], heading_rad: float) -> dict[str, "xr.Variable"]:
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
            missing="no direction: no power arrives, or from all sides alike",
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
            missing="no path",
        ),
        "azimuth_spread": variable(
            dims,
            layer("azimuth_spread_rad", degrees),
            units="degree",
            long_name="circular angle spread of the azimuth of arrival (3GPP TR 38.901, Annex A)",
            missing="no path",
        ),
        "direction_spread": variable(
            dims,
            layer("direction_spread_rad", degrees),
            units="degree",
            long_name="rms spread of the direction of arrival over the sphere (Fleury 2000)",
            missing="no path",
        ),
    }


def _places(axes: Axes, setting: Setting) -> FloatArray:
    x, y = np.meshgrid(*axes, indexing="ij")
    return np.column_stack((x.ravel(), y.ravel(), np.full(x.size, setting.map_z_m)))


@dataclass(frozen=True, slots=True, kw_only=True)
class MapWanted:
    """What a map of a study shows.

    Parameters
    ----------
    tag_ids, antennas : The tags (none: all), the antennas' numbers from 1 (None: all).
    heading_deg : Heading of the robot [deg]; None: that of the mission's start, or 90.
    isotropic : One ``isotropic_theta`` antenna receives, and no reader.
    local_mean, local_mean_disc : Add the power sum over paths; the mean over a wavelength's disc.
    spreads : Add delay spread and angular spreads of the channel.
    """

    tag_ids: tuple[str, ...] = ()
    antennas: tuple[int, ...] | None = None
    heading_deg: float | None = None
    isotropic: bool = False
    local_mean: bool = False
    local_mean_disc: bool = False
    spreads: bool = False

    def raster_layers(self, *, threshold: bool) -> list[str]:
        """Return the layers of which rasters are written: powers, bearing error, what is covered.

        Parameters
        ----------
        threshold : Whether a level is asked for.
        """
        has = {
            "rss_dbm": True,
            "rss_local_mean_dbm": self.local_mean,
            "rss_disc_mean_dbm": self.local_mean_disc,
            "bearing_error": not self.isotropic and self.antennas is None,
            "covered": threshold,
        }
        return [name for name, there in has.items() if there]


def map_rss(
    study: Study,
    wanted: MapWanted,
    *,
    progress: Progress,
    approve: Callable[[Cost], None] | None = None,
) -> tuple["xr.Dataset", Setting, tuple[TagLayers, ...]]:
    """Return the map of a study as a dataset ([W], [ns], [deg]), the room, and what was computed.

    Parameters
    ----------
    study, wanted : The study, whose ``[map]`` gives spacing and height; what is shown.
    progress : Shows what is done.
    approve : Refuses what takes too long or too much memory, once the room is known.
    """
    numbers = wanted.antennas or ()
    wrong = [n for n in numbers if not 1 <= n <= study.reader.antennas]
    if wrong:
        msg = f"antenna {wrong[0]} is asked for, but the reader has antennas 1 to "
        msg += f"{study.reader.antennas}; choose one of these."
        raise ConfigError(msg)
    setting = build_setting(study)
    tags = [setting.tag(tag_id) for tag_id in wanted.tag_ids] or list(setting.tags)
    if not tags:
        msg = "the study has no [[tag]], so there is nothing that transmits; add one."
        raise ConfigError(msg)
    axes = map_axes_m(setting)
    receivers = 1 if wanted.isotropic else len(numbers) or study.reader.antennas
    _refuse_huge(study, axes, tags=len(tags), receivers=receivers)
    if approve is not None:
        cost = field_cost(
            study,
            float(axes[0].size * axes[1].size) * (DISC_PLACES if wanted.local_mean_disc else 1),
            tags=len(tags),
            causes=("map.spacing_m",),
        )
        approve(cost if wanted.isotropic else reader_cost(study).and_then(cost))
    for note in setting.notes:
        progress.say(note)
    refuse_under_floor(setting.scene, setting.seen_floor_m, setting.map_z_m, name="the map")
    if not wanted.isotropic:
        solved(setting, progress)
    heading_deg = wanted.heading_deg
    if heading_deg is None:
        heading_deg = 90.0 if study.mission is None else study.mission.heading_deg
    heading_rad = math.radians(heading_deg)
    view = MapView(axes=axes, heading_rad=heading_rad, isotropic=wanted.isotropic)
    layers = []
    places = axes[0].size * axes[1].size
    for tag in tags:
        with progress.count(places, label=f"tag {tag.id}") as done:
            if is_woken(study, tag):
                one = woken_map(setting, tag, view, progress=done)
            else:
                one = TagLayers(tag=tag, power=tag_map(setting, tag, view, progress=done))
        disc = spread = None
        if wanted.local_mean_disc:
            with progress.count(DISC_PLACES, label=f"tag {tag.id}, discs") as done:
                disc = disc_map(setting, tag, view, progress=done)
        if wanted.spreads:
            with progress.count(places, label=f"tag {tag.id}, spreads") as done:
                spread = spread_map(setting, tag, view, progress=done)
        layers.append(replace(one, disc_mean_w=disc, spreads=spread))
    data = map_dataset(
        study,
        layers,
        open_floor=open_places(setting, _places(axes, setting)),
        antennas=wanted.antennas,
        heading_deg=heading_deg,
        local_mean=wanted.local_mean,
    )
    return data, setting, tuple(layers)


def _refuse_huge(study: Study, axes: Axes, *, tags: int, receivers: int) -> None:
    values = axes[0].size * axes[1].size * tags * receivers
    if values > LARGEST_MAP:
        msg = (
            f"map.spacing_m is {study.map.spacing_m:g} m, which with {tags} tags and {receivers} "
            f"antennas makes {values:.3g} values; choose a coarser grid, or one --tag or --antenna."
        )
        raise ConfigError(msg)


def with_dbm(data: "xr.Dataset") -> "xr.Dataset":
    """Return a map with every power in [dBm] too, beside the one in [W].

    Parameters
    ----------
    data : From `map_rss` or `pose_dataset`.
    """
    from octant.reader_design.face import map_files  # noqa: F401  gives maps their accessor

    added = {}
    for name, power in data.data_vars.items():
        if str(name).endswith("_w"):
            level = data[name].copy(data=power_dbm(power.to_numpy()))
            level.attrs = {**power.attrs, "units": "dBm"}
            added[f"{str(name).removesuffix('_w')}_dbm"] = level
    return data.assign(added)


def rss_link(study: Study, tag_id: str, poses: npt.ArrayLike, *, progress: Progress) -> Link:
    """Return the link of one tag of a study to its reader.

    Parameters
    ----------
    study, tag_id : The study and the tag.
    poses : (k, 3) array_like — x, y [m] and heading [deg]; one in a solid or outside is refused.
    progress : Says which tags were moved off a surface.
    """
    setting = build_setting(study)
    tag = setting.tag(tag_id)
    for note in setting.notes:
        progress.say(note)
    _refuse_buried_poses(setting, poses)
    return solved(setting, progress).link(tag)


def _refuse_buried_poses(setting: Setting, poses: npt.ArrayLike) -> None:
    """Refuse a pose (k, 3) outside the room or in a solid."""
    places_m = np.array(poses, dtype=np.float64)
    places_m[:, 2] = setting.reader_z_m
    refuse_under_floor(setting.scene, setting.seen_floor_m, setting.reader_z_m, name="the reader")
    refuse_buried(setting.scene, places_m, name="pose")


def pose_rss_w(link: Link, poses: npt.ArrayLike) -> FloatArray:
    """Return what every antenna receives at each pose, coherent [W].

    Parameters
    ----------
    link, poses : From `rss_link`; x, y [m] and heading [deg], (k, 3).
    """
    return link.rss_w(np.asarray(poses, dtype=np.float64) * (1.0, 1.0, np.pi / 180.0))


def rss_columns(antennas: int) -> list[str]:
    """Return the columns of a table of RSS: the pose, then a column an antenna.

    Parameters
    ----------
    antennas : Number of antennas.
    """
    return ["x_m", "y_m", "heading_deg", *(f"rss_{i + 1}_w" for i in range(antennas))]


def pose_dataset(study: Study, tag_ids: Sequence[str], poses: npt.ArrayLike) -> "xr.Dataset":
    """Return what every antenna receives from tags, pose by pose ([W] and [dBm]).

    Parameters
    ----------
    study, tag_ids : The study and the tags.
    poses : (k, 3) array_like — x, y [m] and heading [deg].
    """
    import xarray as xr

    given = np.asarray(poses, dtype=np.float64)
    if given.shape[-1:] != (3,) or given.ndim > 2:
        msg = (
            f"poses has shape {given.shape}, but one row (x [m], y [m], heading [deg]) a pose is "
            "needed."
        )
        raise ConfigError(msg)
    given = given.reshape(-1, 3)
    setting = build_setting(study)
    _refuse_buried_poses(setting, given)
    setting.solved()
    links = [setting.link(setting.tag(tag_id), places_m=given[:, :2]) for tag_id in tag_ids]
    rss = [pose_rss_w(link, given) for link in links]
    numbers = np.arange(1, rss[0].shape[-1] + 1)
    places = {
        name: variable(["pose"], given[:, i], units=units, long_name=text)
        for i, (name, units, text) in enumerate(
            (
                ("x", "m", "x in the room"),
                ("y", "m", "y in the room"),
                ("heading", "degree", "heading of the robot"),
            )
        )
    }
    return with_dbm(
        xr.Dataset(
            {
                "rss_w": variable(
                    ["tag", "pose", "antenna"],
                    np.stack(rss),
                    units="W",
                    long_name="received power, coherent sum",
                )
            },
            coords={
                "tag": variable(["tag"], list(tag_ids), units="1", long_name="tag"),
                "antenna": variable(
                    ["antenna"], numbers, units="1", long_name="antenna of the reader"
                ),
                **places,
            },
        )
    )


def unreached_places(layers: Sequence[TagLayers]) -> int:
    """Return how many places of a map no path reaches, for all its tags together.

    Parameters
    ----------
    layers : From `map_rss`.
    """
    return sum(int((layer.power.path_count == 0).sum()) for layer in layers)


def summary_lines(layers: Sequence[TagLayers]) -> Iterator[str]:
    """Yield one line for each tag of a map: places without a path, and the range of powers.

    Parameters
    ----------
    layers : From `map_rss`.
    """
    for layer in layers:
        tag, power, count = layer.tag.id, layer.power.coherent_w, layer.power.path_count
        strongest = power.max(axis=-1) if power.ndim == 3 else power
        heard = strongest[count > 0]
        if layer.answers is not None:
            yield from wake_lines(tag, layer.answers, layer.read_range)
        heard = heard[heard > 0.0] if layer.answers is not None else heard
        if heard.size == 0 or heard.max() <= 0.0:
            what = "no path to" if layer.answers is None else "no answer from the tag at"
            yield f"tag {tag}: {what} any of {count.size} places."
            continue
        dbm = power_dbm(heard)
        yield (
            f"tag {tag}: {count.size} places, {int((count == 0).sum())} without a "
            f"path; strongest antenna {dbm.min():.1f} to {dbm.max():.1f} dBm, median "
            f"{np.median(dbm):.1f} dBm; {int(count.sum())} paths."
        )
        if layer.power.rays is not None:
            yield f"tag {tag}: {layer.power.rays.text()}"
