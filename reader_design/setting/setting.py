"""A study as the radio model computes with it: scene, materials, tags in their places, sampling."""

from dataclasses import dataclass, replace

import msgspec
import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna
from octant.em.medium.radio_scene import RadioScene, radio_scene
from octant.em.search.candidates import Candidates, SolverSettings, radio_scenes, search_candidates
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import ConfigError, OctantError
from octant.geometries.scene import Scene, build_scene
from octant.geometries.tolerances import LENGTHS
from octant.reader_design.setting.antennas import named_antenna
from octant.reader_design.setting.scores import USABLE_DBM
from octant.reader_design.study_file.bodies import object_bodies, room_bodies, study_materials
from octant.reader_design.study_file.checks import rooms_of
from octant.reader_design.study_file.errors import unknown_name
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.schema import Layout, Radio, Study, Tag

FloatArray = npt.NDArray[np.float64]

COORDINATE_BITS = {"flat": 24, "as_stored": 53}
"""Bits [-] of the coordinates that ``solver.faces`` takes for exact: of single or double precision.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class PlacedTag:
    """A tag where the radio model sees it.

    Parameters
    ----------
    id : Its name.
    position_m : (3,) float64 — Place in the room, after the stand-off [m].
    given_m : (3,) float64 — Place that the study gives [m].
    antennas : Its antenna at each frequency of the study [Hz]: the same metal, cut for the carrier;
        axis in the room's frame.
    """

    id: str
    position_m: FloatArray
    given_m: FloatArray
    antennas: tuple[Antenna, ...]

    def __post_init__(self) -> None:
        for name in ("position_m", "given_m"):
            value = frozen_array(getattr(self, name), name=name, shape=(3,))
            object.__setattr__(self, name, value)

    @property
    def point_m(self) -> FloatArray:
        """The tag's point on the ground, (2,) float64 [m]: below where the study puts the tag."""
        return self.given_m[:2]


@dataclass(frozen=True, slots=True, kw_only=True)
class Sampling:
    """How densely designs are probed.

    Attributes
    ----------
    nearest_m, farthest_m : Range of horizontal distances between reader and tag [m].
    distance_step_m : Step of the distances in free space [m].
    free_azimuths, room_azimuths : Azimuths for each antenna in free space and in the room; even, so
        that directions half-way between antennas are among them.
    room_spacing_m : Step of the places on the floor [m].
    travel_step_m : Step of the drive along antenna 1's direction, for the figure of RSS against
        distance [m].
    """

    nearest_m: float = 0.5
    farthest_m: float = 5.0
    distance_step_m: float = 0.5
    free_azimuths: int = 18
    room_azimuths: int = 4
    room_spacing_m: float = 0.5
    travel_step_m: float = 0.05

    def distances_m(self) -> FloatArray:
        """Return the horizontal distances in free space, ends included [m]."""
        count = max(2, 1 + round((self.farthest_m - self.nearest_m) / self.distance_step_m))
        return np.linspace(self.nearest_m, self.farthest_m, count)

    def travel_m(self) -> FloatArray:
        """Return the distances of the drive away from the tag, from right under it [m]."""
        return np.linspace(0.0, self.farthest_m, 1 + round(self.farthest_m / self.travel_step_m))

    def coarser(self) -> "Sampling":
        """Return the sampling of a quick look: shares from it err by a few percentage points."""
        return Sampling(
            nearest_m=self.nearest_m,
            farthest_m=self.farthest_m,
            distance_step_m=2.0 * self.distance_step_m,
            free_azimuths=max(2, self.free_azimuths // 2 // 2 * 2),
            room_azimuths=max(2, self.room_azimuths // 2 // 2 * 2),
            room_spacing_m=2.0 * self.room_spacing_m,
            travel_step_m=2.0 * self.travel_step_m,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """One room of a study, ready for the radio model, and how readers are judged in it; picklable.

    Parameters
    ----------
    study : The study; its ``[reader]`` is the reader that stands here.
    name : The study's name, or the layout's.
    scene : Room and objects.
    radios : One for each frequency over which RSS is averaged [Hz].
    tags : In the order of the study.
    reader_z_m : Height coordinate of the reader's ground plane in the room's frame [m].
    map_z_m : Height coordinate of map receivers in the room's frame [m].
    notes : What the user should know, for example which tag was moved off the ceiling and how far
        [m].
    sampling : How densely readers are probed [m].
    usable_dbm : RSS at which a tag is still read [dBm].
    """

    study: Study
    name: str
    scene: Scene
    radios: tuple[RadioScene, ...]
    tags: tuple[PlacedTag, ...]
    reader_z_m: float
    map_z_m: float
    notes: tuple[str, ...]
    sampling: Sampling = Sampling()
    usable_dbm: float = USABLE_DBM

    @property
    def has_room(self) -> bool:
        """Whether there is a room to score in, besides free space."""
        return self.scene.has_room

    @property
    def reader(self) -> Reader:
        """The reader that stands here: the study's table ``[reader]``."""
        return self.study.reader

    def with_reader(self, reader: Reader) -> "Setting":
        """Return the same room with another reader in it.

        Parameters
        ----------
        reader : Its ground plane stands at its own height [m].
        """
        return replace(
            self,
            study=msgspec.structs.replace(self.study, reader=reader),
            reader_z_m=self.scene.floor_height_m + reader.height_m,
        )

    def tag(self, tag_id: str) -> PlacedTag:
        """Return the tag of a name; refuse an unknown one.

        Parameters
        ----------
        tag_id : Its id.
        """
        for tag in self.tags:
            if tag.id == tag_id:
                return tag
        raise ConfigError(
            unknown_name("the tag", tag_id, [t.id for t in self.tags], what="[[tag]]")
        )


def build_setting(
    study: Study, layout: Layout | None = None, *, sampling: Sampling | None = None
) -> Setting:
    """Return the room of a study, or of one of its layouts, with materials and tags.

    A tag or start outside the room or inside an object, an unknown material and a mesh that cannot
    be used are refused.

    Parameters
    ----------
    study : A study from `load_study` [m].
    layout : One of ``study.layouts``; None: the study's own room.
    sampling : How densely readers are probed [m].
    """
    where = "" if layout is None else f"in layout {layout.name!r}: "
    room = rooms_of(study, layout)
    scene = build_scene(
        room_bodies(room),
        objects=object_bodies(room.objects),
        coordinate_bits=COORDINATE_BITS[study.solver.faces],
    )
    try:
        materials = study_materials(study)
        frequencies_hz = study.radio.frequencies_hz
        radios = radio_scenes(scene, frequencies_hz, solver_settings(study), materials)
        tags, notes = place_tags(study, scene)
        reader_z_m = scene.floor_height_m + study.reader.height_m
        map_z_m = scene.floor_height_m + (study.map.height_m or study.reader.height_m)
        _check_heights(study, scene, reader_z_m, map_z_m)
        _check_starts(study, scene, reader_z_m)
    except OctantError as exc:
        if not where:
            raise
        msg = f"{where}{exc}"
        raise ConfigError(msg) from exc
    return Setting(
        study=study,
        name=study.name if layout is None else layout.name,
        scene=scene,
        radios=radios,
        tags=tags,
        reader_z_m=reader_z_m,
        map_z_m=map_z_m,
        notes=tuple(where + note for note in notes),
        sampling=sampling or Sampling(),
    )


def radio_at(study: Study, setting: Setting, frequency_hz: float) -> RadioScene:
    """Return a study's room, its edges too, at a frequency that may be none of its channels.

    Parameters
    ----------
    study, setting : A study and one of its rooms.
    frequency_hz : Frequency [Hz].
    """
    for radio in setting.radios:
        if radio.frequency_hz == frequency_hz:
            return radio
    return radio_scene(
        setting.scene,
        frequency_hz,
        study_materials(study),
        transmission=study.solver.transmission,
        wedges=setting.radios[0].wedges,
    )


def candidates_from(
    study: Study,
    radio: RadioScene,
    source_m: npt.ArrayLike,
    *,
    max_reflections: int | None = None,
    region_m: npt.ArrayLike | None = None,
) -> Candidates:
    """Return the candidates for paths from a place, searched as the study's solver says.

    Parameters
    ----------
    study : The study.
    radio : Its room at one frequency.
    source_m : (3,) array_like — Place of the source [m].
    max_reflections : Greatest order; None: the study's.
    region_m : (2, 3) array_like or None — Box [m] that all receivers lie in; None: the room.
    """
    solver = solver_settings(study)
    if max_reflections is not None:
        solver = replace(solver, max_reflections=max_reflections)
    return search_candidates(radio, source_m, solver, region_m=region_m)


def solver_settings(study: Study) -> SolverSettings:
    """Return what the radio model of a study's rooms includes: its table ``[solver]``.

    Parameters
    ----------
    study : The study.
    """
    solver = study.solver
    return SolverSettings(
        max_reflections=solver.max_reflections,
        diffraction=solver.diffraction,
        max_diffractions=solver.max_diffractions,
        transmission=solver.transmission,
        search=solver.search,
        rays=solver.rays,
    )


def place_tags(study: Study, scene: Scene) -> tuple[tuple[PlacedTag, ...], tuple[str, ...]]:
    """Return the tags in their places, and a line for each that had to be moved.

    Parameters
    ----------
    study : With its tags [m].
    scene : The room they hang in.
    """
    placed, notes = [], []
    for i, tag in enumerate(study.tags):
        position, moved = place_antenna(
            scene,
            tag.position_m,
            study.solver.standoff_m,
            name=f"tag {tag.id!r}",
            key=f"tag[{i}].position_m",
        )
        if moved:
            notes.append(moved)
        placed.append(
            PlacedTag(
                id=tag.id,
                position_m=position,
                given_m=np.array(tag.position_m),
                antennas=_tag_antennas(tag, study.radio, key=f"tag[{i}].antenna"),
            )
        )
    return tuple(placed), tuple(notes)


def place_antenna(
    scene: Scene, point_m: npt.ArrayLike, standoff_m: float, *, name: str, key: str
) -> tuple[FloatArray, str]:
    """Return where an antenna is put, and a line that says so when that is not where it was given.

    A place outside the room or inside an object is refused.

    Parameters
    ----------
    scene : The room.
    point_m : (3,) array_like — Given place [m].
    standoff_m : How far it is moved off a surface that it lies on [m].
    name, key : Name in the line, and key path or option that gave the place, for errors.
    """
    given = np.asarray(point_m, dtype=np.float64)
    text = _point_text(given)
    points, moved = scene.stand_off(given[None, :], standoff_m)
    if not scene.inside_room(points)[0]:
        low, high = (_point_text(corner) for corner in scene.bounds_m)
        msg = (
            f"{key} is {text} m, which is outside the room that spans {low} to {high} m; "
            "move it inside."
        )
        raise ConfigError(msg)
    if scene.inside_solid(points)[0]:
        msg = f"{key} is {text} m, which is inside a solid object; move it out, or the object."
        raise ConfigError(msg)
    if not moved[0]:
        return given, ""
    note = (
        f"{name} at {text} m lies on a surface and is moved "
        f"{100.0 * float(np.linalg.norm(points[0] - given)):.3g} cm off it, "
        f"to {_point_text(points[0])} m (solver.standoff_m)."
    )
    return np.asarray(points[0], dtype=np.float64), note


def _tag_antennas(tag: Tag, radio: Radio, *, key: str) -> tuple[Antenna, ...]:
    antennas: list[Antenna] = []
    cut = None
    for f in (radio.frequency_hz, *radio.frequencies_hz):
        antennas.append(
            named_antenna(
                tag.antenna, f, key=key, axis=tag.axis, azimuth_deg=tag.azimuth_deg, length_m=cut
            )
        )
        cut = antennas[0].length_m or None  # the same metal at all frequencies
    return tuple(antennas[1:])


def _check_starts(study: Study, scene: Scene, reader_z_m: float) -> None:
    if study.mission is None:
        return
    _check_start(study, scene, reader_z_m, key="mission.start_m", place_m=study.mission.start_m)
    for i, (x, y, _) in enumerate(study.mission.starts):
        _check_start(study, scene, reader_z_m, key=f"mission.starts[{i}]", place_m=(x, y))


def _check_start(
    study: Study, scene: Scene, reader_z_m: float, *, key: str, place_m: tuple[float, float]
) -> None:
    start = np.array([*place_m, reader_z_m])
    shown = f"{key} is {list(place_m)} m"
    if not scene.inside_room(start[None, :])[0]:
        low, high = scene.bounds_m[:, :2].tolist()
        msg = f"{shown}, which is outside the room that spans {low} to {high} m; start inside it."
        raise ConfigError(msg)
    heights = np.linspace(scene.floor_height_m + LENGTHS.step_m, reader_z_m, 5)
    column = np.column_stack([np.tile(start[:2], (5, 1)), heights])
    if scene.inside_solid(column).any():
        msg = f"{shown}, which is inside an object; start beside it."
        raise ConfigError(msg)
    radius_m = study.reader.ground_plane_m / 2.0
    distance_m = float(scene.distance_to_facets_m(start[None, :])[0][0])
    beside = distance_m < radius_m and distance_m < study.reader.height_m - LENGTHS.same_m
    if beside:
        msg = (
            f"{shown}, {distance_m:g} m from a wall or an object, but the reader reaches "
            f"{radius_m:g} m from its centre; start further off (or move the room: room.origin_m)."
        )
        raise ConfigError(msg)


def _check_heights(study: Study, scene: Scene, reader_z_m: float, map_z_m: float) -> None:
    if not scene.has_room:
        return
    top_m = float(scene.bounds_m[1, 2])
    heights = {
        "reader.height_m": (study.reader.height_m, reader_z_m),
        "map.height_m": (study.map.height_m, map_z_m),
    }
    for path, (height_m, z_m) in heights.items():
        if z_m >= top_m:
            msg = (
                f"{path} is {height_m:g} m above the floor, but the room is only "
                f"{top_m - scene.floor_height_m:g} m high; choose less."
            )
            raise ConfigError(msg)


def _point_text(point_m: npt.ArrayLike) -> str:
    return "(" + ", ".join(f"{c:.6g}" for c in np.asarray(point_m)) + ")"
