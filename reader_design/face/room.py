"""A room with what stands in it, and what can be asked of it: paths, maps, pictures."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from octant.geometries.bodies import place
from octant.geometries.errors import ConfigError
from octant.geometries.mesh_files import Reading, frame_of
from octant.reader_design.face.materials import Audit
from octant.reader_design.face.materials import audit as audit_file
from octant.reader_design.face.paths import End, Paths, path_link, paths_title
from octant.reader_design.face.reader import Reader
from octant.reader_design.face.rss_map import MapWanted, map_rss, pose_dataset, with_dbm
from octant.reader_design.face.shown import figure_html, progress_of, text_html
from octant.reader_design.face.tables import (
    StudyTable,
    Tag,
    radio_keys,
    refuse_unlike,
    solver_keys,
    study_from,
    with_keys_of,
)
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.free_floor import free_floor
from octant.reader_design.setting.map_grid import map_axes_m
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.showing.rasters import Raster, write_occupancy
from octant.reader_design.showing.scene_glb import write_scene
from octant.reader_design.showing.scene_picture import ColourBy, View, scene_figure
from octant.reader_design.study_file.room import Room as RoomTable
from octant.reader_design.study_file.schema import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Place = Tag | Sequence[float] | npt.NDArray[np.float64]
Material = str | Mapping[str, Any]
READER_EXAMPLE = "octant.Reader(plate_height_m=0.08)"
TAG_EXAMPLE = 'octant.Tag("1", (2.0, 0.5, 2.9))'


@with_keys_of(RoomTable)
class Room(StudyTable):
    """A room and what stands in it.

    The keys are those of the table ``[room]`` of a study file; `Room.box`, `Room.outline`,
    `Room.load` and `Room.free_space` name the usual ones.

    Examples
    --------
    >>> import octant
    >>> room = octant.Room.box((5, 4, 3), "concrete")
    >>> room
    <Room: 5 x 4 x 3 m, 3 bodies, 12 triangles: concrete>
    >>> len(room.paths((2.0, 0.5, 2.9), (1.0, 1.0, 0.3), max_reflections=1))
    7
    """

    __slots__ = ()
    _kind = RoomTable

    def __init__(self, **keys: Any) -> None:  # noqa: ANN401  keys of the table
        self.table = study_from("Room", {"room": keys}).room

    @classmethod
    def box(
        cls,
        size_m: Sequence[float],
        material: Material | None = None,
        *,
        origin_m: Sequence[float] = (0.0, 0.0, 0.0),
        objects: Sequence[Mapping[str, Any]] = (),
        doorways: Sequence[Mapping[str, Any]] = (),
    ) -> Self:
        """Return a box room.

        Parameters
        ----------
        size_m, origin_m : (3,) — Inner size along x, y and z, and lowest corner [m].
        material : A name of `octant.materials`, keys of a material, or one for each of ``walls``,
            ``floor`` and ``ceiling``; concrete where it is left out.
        objects, doorways : With the keys of tables ``[[room.object]]`` and ``[[room.doorway]]``.
        """
        return cls(
            box_m=size_m, material=material, origin_m=origin_m, object=objects, doorway=doorways
        )

    @classmethod
    def outline(
        cls,
        corners_m: npt.ArrayLike,
        material: Material | None = None,
        *,
        height_m: float,
        origin_m: Sequence[float] = (0.0, 0.0, 0.0),
        objects: Sequence[Mapping[str, Any]] = (),
        doorways: Sequence[Mapping[str, Any]] = (),
    ) -> Self:
        """Return a room of any outline with vertical walls.

        Parameters
        ----------
        corners_m : (n, 2) array_like — Corners x, y [m].
        height_m, origin_m : Height, and where the outline's origin lies [m].
        material, objects, doorways : As in `box`.
        """
        return cls(
            outline_m=corners_m,
            height_m=height_m,
            material=material,
            origin_m=origin_m,
            object=objects,
            doorway=doorways,
        )

    @classmethod
    def load(
        cls,
        file: str | Path | Sequence[Mapping[str, Any]],
        *,
        unit: str | None = None,
        up: str | None = None,
        material: Material | None = None,
        materials: Mapping[str, Material] | None = None,
        origin_m: Sequence[float] = (0.0, 0.0, 0.0),
        objects: Sequence[Mapping[str, Any]] = (),
        geometry: str | None = None,
        height_m: float | None = None,
        metres_per_pixel: float | None = None,
        resource_path: Sequence[str | Path] = (),
    ) -> Self:
        """Return a room from a mesh file, or from several.

        Parameters
        ----------
        file : A file of any format that trimesh reads, a Mitsuba scene, DAE, an SDF or URDF world,
            a floor plan (YAML of a map, picture, DXF); or several files, each with the keys of
            a table ``[[room.mesh]]``.
        unit : Length unit of the file (m, cm, mm, in ...), unless the format declares one; ``auto``
            guesses it from the size, for reasons that `octant.audit` says.
        up : {"y", "z", "auto"} — The file's vertical axis; by default y for GLB and GLTF, what a
            DAE says, z for the others; ``auto`` guesses it from names and size.
        materials, material : Material by name of the body in the file; that of all other bodies.
        origin_m, objects : Where the file's origin lies, (3,) [m]; as in `box`.
        geometry, height_m, metres_per_pixel, resource_path : Keys of the table ``[room]``:
            ``visual`` or ``collision`` of a world; height of a floor plan's walls [m]; scale of a
            picture of one [m]; folders of models.
        """
        several = not isinstance(file, str | Path)
        if isinstance(file, str | Path) and "auto" in (unit, up):
            reading = Reading(
                geometry="collision" if geometry == "collision" else "visual",
                height_m=height_m,
                metres_per_pixel=metres_per_pixel,
                resource_path=tuple(str(folder) for folder in resource_path),
            )
            guess = frame_of(file, reading=reading)
            unit = guess.unit if unit == "auto" else unit
            up = guess.up if up == "auto" else up
        return cls(
            mesh=file if several else str(file),
            geometry=geometry,
            height_m=height_m,
            metres_per_pixel=metres_per_pixel,
            resource_path=[str(folder) for folder in resource_path],
            unit=unit,
            up=up,
            material=material,
            materials=materials or {},
            origin_m=origin_m,
            object=objects,
        )

    @classmethod
    def free_space(cls, objects: Sequence[Mapping[str, Any]] = ()) -> Self:
        """Return free space with objects in it, or with none.

        Parameters
        ----------
        objects : As in `box`.
        """
        return cls(free_space=True, object=objects)

    def audit(self) -> Audit | tuple[Audit, ...]:
        """Return what is wrong with the room's mesh file, or with each of its files."""
        mesh = self.table.mesh
        if mesh is None:
            msg = (
                "this room is not read from a mesh file, so there is nothing to audit; audit a "
                "Room.load(...), or a file by octant.audit(file)."
            )
            raise ConfigError(msg)
        if isinstance(mesh, str):
            return audit_file(mesh, unit=self.table.unit, up=self.table.up)
        return tuple(audit_file(part.file, unit=part.unit, up=part.up) for part in mesh)

    def paths(
        self,
        tx: Place,
        rx: Place,
        *,
        frequency_hz: float = 2.4e9,
        max_reflections: int | None = None,
        tx_antenna: str = "dipole",
        rx_antenna: str = "dipole",
        solver: Mapping[str, Any] | None = None,
    ) -> Paths:
        """Return every path between a transmitter and receivers, with its gain.

        Parameters
        ----------
        tx, rx : Transmitter; receiver, or the places of several [m].
        frequency_hz : Frequency [Hz].
        max_reflections : Highest number of reflections and diffractions; by default 3.
        tx_antenna, rx_antenna : ``dipole``, ``monopole``, ``patch``, ``isotropic_theta`` or a
            pattern file; a `Tag` brings its own, with axis and azimuth.
        solver : Keys of the table ``[solver]``, such as ``diffraction`` and ``transmission``.
        """
        study = study_from(
            "paths",
            {
                "room": self,
                "radio": {"frequency_hz": frequency_hz},
                "solver": solver_keys(solver, max_reflections=max_reflections),
            },
        )
        ends = {"tx": (tx, tx_antenna), "rx": (rx, rx_antenna)}
        made = {name: _end(name, given, antenna) for name, (given, antenna) in ends.items()}
        link = path_link(study, _place("tx", tx), _place("rx", rx), tx=made["tx"], rx=made["rx"])
        return Paths(link=link, blocks=tuple(link.blocks()))

    def rss(
        self,
        tags: Sequence[Tag],
        reader: Reader,
        poses: npt.ArrayLike,
        *,
        frequency_hz: float = 2.4e9,
        channels_hz: Sequence[float] = (),
        solver: Mapping[str, Any] | None = None,
        rfid: Mapping[str, Any] | None = None,
    ) -> "xr.Dataset":
        """Return what every antenna of a reader receives from tags, pose by pose ([W] and [dBm]).

        Parameters
        ----------
        tags, reader : Transmitters and receiver.
        poses : (k, 3) array_like — x, y [m] and heading [deg] of the robot.
        frequency_hz, channels_hz : Carrier; hopping frequencies, over which RSS is the mean [Hz].
        solver, rfid : Keys of the tables ``[solver]`` and ``[rfid]``.
        """
        study = link_study(
            self,
            tags,
            reader,
            {"solver": solver, "rfid": rfid},
            frequency_hz=frequency_hz,
            channels_hz=channels_hz,
        )
        return pose_dataset(study, [tag.id for tag in tags], poses)

    def rss_map(
        self,
        tags: Sequence[Tag],
        reader: Reader | None = None,
        *,
        spacing_m: float = 0.1,
        height_m: float | None = None,
        antennas: Sequence[int] | None = None,
        heading_deg: float | Sequence[float] = 90.0,
        frequency_hz: float = 2.4e9,
        channels_hz: Sequence[float] = (),
        local_mean: bool = False,
        local_mean_disc: bool = False,
        spreads: bool = False,
        solver: Mapping[str, Any] | None = None,
        rfid: Mapping[str, Any] | None = None,
        margin_m: float = 1.0,
        progress: bool | Progress = True,
    ) -> "xr.Dataset":
        """Return what a reader receives from tags over the floor ([W] and [dBm]).

        Parameters
        ----------
        tags, reader : Transmitters, one layer each; no reader: one ``isotropic_theta`` antenna.
        spacing_m : Distance of neighbouring places [m].
        height_m : Height of the receivers above the floor [m]; by default the reader's.
        antennas : Numbers of the antennas, from 1; by default all, with the strongest antenna and
            the bearing error of the RSS-weighted vector sum.
        heading_deg : Heading of the robot [deg]; several make a dimension ``heading``.
        frequency_hz, channels_hz, solver, rfid : As in `rss` [Hz].
        margin_m : How far a map of free space reaches beyond the tags [m].
        local_mean, local_mean_disc : Add the sum over paths; the mean over a wavelength's disc.
        spreads : Add delay spread and angular spreads of the channel.
        progress : False silences it.
        """
        grid = {"spacing_m": spacing_m, "height_m": height_m, "margin_m": margin_m}
        study = link_study(
            self,
            tags,
            reader,
            {"solver": solver, "rfid": rfid, "map": grid},
            frequency_hz=frequency_hz,
            channels_hz=channels_hz,
        )
        several = not np.isscalar(heading_deg)
        headings = np.atleast_1d(np.asarray(heading_deg, dtype=np.float64)).tolist()
        maps = [
            map_rss(
                study,
                MapWanted(
                    antennas=None if antennas is None else tuple(antennas),
                    heading_deg=heading,
                    isotropic=reader is None,
                    local_mean=local_mean,
                    local_mean_disc=local_mean_disc,
                    spreads=spreads,
                ),
                progress=progress_of(progress),
            )[0]
            for heading in (headings if reader is not None else headings[:1])
        ]
        return with_dbm(_by_heading(maps) if several and reader is not None else maps[0])

    def plot(
        self,
        tags: Sequence[Tag] = (),
        *,
        azimuth_deg: float = -60.0,
        elevation_deg: float = 35.0,
    ) -> "Figure":
        """Return a picture of the room, cut open towards the viewer.

        Parameters
        ----------
        tags, azimuth_deg, elevation_deg : Tags that are drawn; from where it is seen [deg].
        """
        study = study_from("plot", {"room": self, "tag": list(tags)})
        view = View(azimuth_deg=azimuth_deg, elevation_deg=elevation_deg)
        return scene_picture(build_setting(study), title="", view=view)

    def to_glb(self, path: str | Path) -> None:
        """Write the room as a GLB file with its materials by name.

        Parameters
        ----------
        path : The file; replaced where it exists.
        """
        scene = build_setting(study_from("to_glb", {"room": self})).scene
        write_scene(scene, Path(path), paths=None, ends_m={})

    def to_map_server(
        self, path: str | Path, *, resolution_m: float = 0.05, height_m: float = 0.4
    ) -> tuple[Path, ...]:
        """Write the free floor as a map for ROS' map_server, and return its yaml and pgm.

        A cell is occupied where anything up to a height touches the circle around it, and unknown
        outside the room.

        Parameters
        ----------
        path : The file ending in .yaml; replaced where it exists.
        resolution_m : Greatest width of a cell [m].
        height_m : Up to where things count, above the floor [m].
        """
        study = study_from("to_map_server", {"room": self, "map": {"spacing_m": resolution_m}})
        setting = build_setting(study)
        x_m, y_m = map_axes_m(setting)
        floor = free_floor(setting, x_m, y_m, height_m=height_m)
        return write_occupancy(
            Raster(x_m=x_m, y_m=y_m, values=floor, name="free floor", unit="1"), Path(path)
        )

    def __repr__(self) -> str:
        scene = build_setting(study_from("Room", {"room": self})).scene
        materials = dict.fromkeys(body.material for body in scene.bodies)
        bodies, triangles = len(scene.bodies), sum(len(body.faces) for body in scene.bodies)
        size = "free space"
        if scene.has_room:
            size = " x ".join(f"{c:.4g}" for c in np.ptp(scene.bounds_m, axis=0)) + " m"
        return (
            f"<Room: {size}, {bodies} bod{'y' if bodies == 1 else 'ies'}, {triangles} triangles"
            + (f": {', '.join(materials)}>" if materials else ">")
        )

    def _repr_html_(self) -> str:
        return text_html(repr(self)) + figure_html(self.plot())


def link_study(
    room: Room,
    tags: Sequence[Tag],
    reader: Reader | None,
    tables: Mapping[str, Any],
    *,
    frequency_hz: float,
    channels_hz: Sequence[float],
) -> Study:
    """Return the study of tags and a reader in a room; refuse what is of the wrong kind or no fit.

    Parameters
    ----------
    room, tags : The room and its tags.
    reader : The reader; None: the default one.
    tables : Further tables of a study file.
    frequency_hz, channels_hz : Carrier and hopping frequencies [Hz].
    """
    refuse_unlike("room", room, Room, example='octant.Room.box((5, 4, 3), "concrete")')
    for i, tag in enumerate(tags):
        refuse_unlike(f"tags[{i}]", tag, Tag, example=TAG_EXAMPLE)
    if reader is not None:
        refuse_unlike("reader", reader, Reader, example=READER_EXAMPLE)
    radio = radio_keys(tags, frequency_hz=frequency_hz, channels_hz=channels_hz)
    return study_from(
        "Room", {"room": room, "tag": list(tags), "reader": reader, "radio": radio, **tables}
    )


def _end(name: str, given: Place, antenna: str) -> End:
    if not isinstance(given, Tag):
        return End(place_key=name, antenna_key=f"{name}_antenna", antenna=antenna)
    return End(
        place_key=f"{name}.position_m",
        antenna_key=f"{name}.antenna",
        antenna=given.antenna,
        axis=given.axis,
        azimuth_deg=given.azimuth_deg,
    )


def _place(name: str, given: Place) -> npt.NDArray[np.float64]:
    """Return the place of a transmitter (3,), or the places of receivers (m, 3) [m]."""
    values = given.position_m if isinstance(given, Tag) else given
    example = f"a Tag, or three coordinates such as {name}=(1.0, 1.0, 0.3)"
    try:
        place_m = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as exc:
        msg = f"{name} is {values!r}, which is no place; give {example}."
        raise ConfigError(msg) from exc
    wanted = place_m.shape == (3,) or (name == "rx" and place_m.ndim == 2 and place_m.size > 0)
    if not wanted or place_m.shape[-1] != 3 or not np.isfinite(place_m).all():
        msg = (
            f"{name} is {values!r}, but finite coordinates x, y, z [m] are needed; give {example}."
        )
        raise ConfigError(msg)
    return place_m


def _by_heading(maps: "Sequence[xr.Dataset]") -> "xr.Dataset":
    """Return maps of several headings as one, with a dimension ``heading`` where it matters."""
    import xarray as xr

    same = [name for name in maps[0] if maps[0][name].dims in {("tag", "x", "y"), ("x", "y")}]
    same = [n for n in same if n not in {"strongest_antenna", "bearing_error"}]
    turned = xr.concat(
        [one.drop_vars(same) for one in maps], dim="heading", combine_attrs="override"
    )
    return turned.assign({name: maps[0][name] for name in same})


def scene_picture(
    setting: Setting,
    *,
    title: str | None = None,
    found: Paths | None = None,
    most: int = 30,
    colour_by: ColourBy = "gain",
    view: View | None = None,
) -> "Figure":
    """Return a picture of a study's room with its tags, its reader at the start, and paths.

    Parameters
    ----------
    setting : The study and its room.
    title : Above the picture; by default the study's name, and what paths are drawn.
    found, most : Paths between two ends; draw at most so many of them.
    colour_by, view : Their colour shows "gain" or "order"; from where the room is seen.
    """
    drawn = None if found is None else found.strongest(most)
    if title is None:
        carrier_hz = setting.study.radio.frequency_hz
        title = setting.name
        if drawn is not None:
            title = paths_title(setting, drawn, frequency_hz=carrier_hz)
    return scene_figure(
        setting.scene,
        title=title,
        tags={tag.id: tag.position_m for tag in setting.tags},
        ends_m={} if found is None else found.ends_m(),
        reader_m=_reader_triangles(setting),
        paths=drawn,
        colour_by=colour_by,
        view=view,
    )


def _reader_triangles(setting: Setting) -> npt.NDArray[np.float64] | None:
    mission = setting.study.mission
    if mission is None:
        return None
    body = setting.reader.body().body
    turn = math.radians(mission.heading_deg - 90.0)
    where = (*mission.start_m, setting.reader_z_m)
    return place(body, position_m=where, yaw_rad=turn).triangles_m
