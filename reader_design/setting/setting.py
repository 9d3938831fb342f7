"""A study as the radio model computes with it: scene, materials, tags in their places, sampling."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.medium.radio_scene import RadioScene, radio_scene
from octant.em.power.backscatter import BackscatterLink, Link
from octant.em.power.received_power import reader_link
from octant.em.search.candidates import Candidates, SolverSettings, radio_scenes, search_candidates
from octant.geometries.errors import ConfigError, OctantError, PhysicsWarning
from octant.geometries.scene import Scene, build_scene, free_space_scene
from octant.navigation.navigators.own import find_navigator
from octant.reader_design.setting.advice import (
    floor_note,
    refuse_under_floor,
    seen_floor_m,
    solid_wall_notes,
)
from octant.reader_design.setting.design import reader_responses
from octant.reader_design.setting.placing import PlacedTag, check_heights, check_starts, place_tags
from octant.reader_design.setting.rfid import LinkPlace, is_woken, woken_link
from octant.reader_design.setting.scores import USABLE_DBM
from octant.reader_design.study_file.bodies import object_bodies, room_bodies, study_materials
from octant.reader_design.study_file.calibration import sent_w
from octant.reader_design.study_file.checks import rooms_of
from octant.reader_design.study_file.errors import unknown_name
from octant.reader_design.study_file.loading import layout_study
from octant.reader_design.study_file.mission import NAVIGATORS
from octant.reader_design.study_file.mission import Mission as MissionTable
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.schema import Layout, Study

FloatArray = npt.NDArray[np.float64]

COORDINATE_BITS = {"flat": 24, "as_stored": 53}
"""Bits [-] of the coordinates that ``solver.faces`` takes for exact: of single or double precision.
"""
DIRECT_ONLY = SolverSettings(max_reflections=0)
"""The model of free space."""


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


@dataclass(frozen=True, kw_only=True)
class Setting:
    """One room of a study with its reader, ready for the radio model, and how it is judged there.

    Picklable. The reader's response is computed when it is first asked for; a copy with another
    study or reader computes its own.

    Parameters
    ----------
    study : The study; its ``[reader]`` is the reader that stands here.
    layout : The layout whose room this is; None: the study's own room.
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
    layout: Layout | None = None
    scene: Scene
    radios: tuple[RadioScene, ...]
    tags: tuple[PlacedTag, ...]
    reader_z_m: float
    map_z_m: float
    notes: tuple[str, ...]
    sampling: Sampling = Sampling()
    usable_dbm: float = USABLE_DBM

    @property
    def name(self) -> str:
        """The layout's name, or the study's."""
        return self.study.name if self.layout is None else self.layout.name

    @property
    def has_room(self) -> bool:
        """Whether there is a room to score in, besides free space."""
        return self.scene.has_room

    @property
    def reader(self) -> Reader:
        """The reader that stands here: the study's table ``[reader]``."""
        return self.study.reader

    @property
    def mission(self) -> MissionTable:
        """The study's table ``[mission]``; a study without one is refused."""
        return mission_table(self.study)

    @property
    def solver(self) -> SolverSettings:
        """What the radio model includes: the study's table ``[solver]``."""
        return solver_settings(self.study)

    @property
    def seen_floor_m(self) -> float | None:
        """Where the floor seems to be [m], if not where it is taken; else None."""
        return seen_floor_m(self.study, self.scene, rooms_of(self.study, self.layout))

    @property
    def reference_tag(self) -> PlacedTag:
        """The tag of the scores in free space: the mission's first, or the study's first."""
        if not self.tags:
            msg = "the study has no [[tag]], but designs are scored by the RSS of one; add a tag."
            raise ConfigError(msg)
        mission = self.study.mission
        return self.tags[0] if mission is None else self.tag(mission.tags[0])

    @cached_property
    def responses(self) -> tuple[ReaderResponse, ...]:
        """The reader's response at each frequency, with the warnings of its model."""
        return reader_responses(self.reader, self.study.radio)

    def solved(self) -> "Setting":
        """Return the setting with its responses; a PhysicsWarning says what does not hold."""
        for text in dict.fromkeys(text for one in self.responses for text in one.warnings):
            warnings.warn(text, PhysicsWarning, stacklevel=2)
        return self

    def with_responses(self, responses: Sequence[ReaderResponse]) -> "Setting":
        """Return the same setting with given responses in place of those of its reader's model.

        Parameters
        ----------
        responses : One for each of ``study.radio.frequencies_hz``.
        """
        other = replace(self)
        vars(other)["responses"] = tuple(responses)  # where functools keeps a cached property
        return other

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

    def radio_at(self, frequency_hz: float) -> RadioScene:
        """Return the room, its edges too, at a frequency that may be none of its channels.

        Parameters
        ----------
        frequency_hz : Frequency [Hz].
        """
        for radio in self.radios:
            if radio.frequency_hz == frequency_hz:
                return radio
        return radio_scene(
            self.scene,
            frequency_hz,
            study_materials(self.study),
            transmission=self.study.solver.transmission,
            wedges=self.radios[0].wedges,
        )

    def candidates(
        self,
        source_m: npt.ArrayLike,
        *,
        radio: RadioScene | None = None,
        max_reflections: int | None = None,
        region_m: npt.ArrayLike | None = None,
        receivers_m: npt.ArrayLike | None = None,
    ) -> Candidates:
        """Return the candidates for paths from a place, searched as the study's solver says.

        Parameters
        ----------
        source_m : (3,) array_like — Place of the source [m].
        radio : The room at one frequency; None: at the first.
        max_reflections : Greatest order; None: the study's.
        region_m : (2, 3) array_like or None — Box [m] that all receivers lie in; None: the room.
        receivers_m : (m, 3) array_like or None — All receivers [m], where they are known.
        """
        solver = self.solver
        if max_reflections is not None:
            solver = replace(solver, max_reflections=max_reflections)
        return search_candidates(
            radio or self.radios[0],
            source_m,
            solver,
            region_m=region_m,
            receivers_m=receivers_m,
        )

    def link(
        self,
        tag: PlacedTag,
        *,
        height_m: float | None = None,
        places_m: npt.ArrayLike | None = None,
    ) -> Link:
        """Return the link of a tag to the reader: RSS [W] for any pose, mean over the channels.

        Of a tag that the reader wakes, what it sends back; 0 where it sleeps.

        Parameters
        ----------
        tag : One of the room's tags.
        height_m : Ground plane above the floor [m]; None: the study's.
        places_m : (m, 2) array_like or None — The only x, y [m] of the robot, where they are known.
        """
        return self._link(
            self.radios,
            tag,
            tag.position_m,
            height_m=height_m,
            solver=self.solver,
            places_m=places_m,
        )

    def free_link(self, tag: PlacedTag) -> Link:
        """Return the link of a tag to the reader at the same heights, without any room.

        Parameters
        ----------
        tag : Its place and antenna are kept.
        """
        place = np.array(tag.position_m)
        place[2] -= self.reader_z_m - self.reader.height_m
        return self._link(_free_space(tag), tag, place)

    def open_link(self, tag: PlacedTag) -> Link:
        """Return the link of a tag that hangs over (0, 0) as high as here, but in free space.

        It is what one knows of the reader and the tag beforehand: the tag never sleeps.

        Parameters
        ----------
        tag : Only its height above the floor and its antenna count [m].
        """
        link = self._link(_free_space(tag), tag, np.array([0.0, 0.0, self.height_m(tag)]))
        return link.always_awake() if isinstance(link, BackscatterLink) else link

    def woken_open_link(self, tag: PlacedTag) -> BackscatterLink:
        """Return the same of a tag that sleeps where the reader does not wake it.

        Parameters
        ----------
        tag : A tag that is not active; only its height and its antenna count [m].
        """
        place = np.array([0.0, 0.0, self.height_m(tag)])
        return self._woken(_free_space(tag), tag, place)

    def height_m(self, tag: PlacedTag) -> float:
        """Return how high a tag hangs above the floor [m].

        Parameters
        ----------
        tag : One of the room's tags.
        """
        return float(tag.position_m[2]) - self.scene.floor_height_m

    def _link(
        self,
        radios: Sequence[RadioScene],
        tag: PlacedTag,
        position_m: FloatArray,
        *,
        height_m: float | None = None,
        solver: SolverSettings = DIRECT_ONLY,
        places_m: npt.ArrayLike | None = None,
    ) -> Link:
        if is_woken(self.study, tag):
            return self._woken(
                radios, tag, position_m, height_m=height_m, solver=solver, places_m=places_m
            )
        return reader_link(
            radios,
            tag_position_m=position_m,
            tag_antenna=tag.antennas,
            tag_power_w=sent_w(self.study, tag.id),
            response=self.responses,
            reader_height_m=self.reader.height_m if height_m is None else height_m,
            solver=solver,
            places_m=places_m,
        )

    def _woken(
        self,
        radios: Sequence[RadioScene],
        tag: PlacedTag,
        position_m: FloatArray,
        *,
        height_m: float | None = None,
        solver: SolverSettings = DIRECT_ONLY,
        places_m: npt.ArrayLike | None = None,
    ) -> BackscatterLink:
        place = LinkPlace(
            radios=radios,
            tag_m=position_m,
            height_m=self.reader.height_m if height_m is None else height_m,
            solver=solver,
            standoff_m=self.study.solver.standoff_m,
            places_m=places_m,
        )
        return woken_link(self.study, tag, place, self.responses)


def _free_space(tag: PlacedTag) -> list[RadioScene]:
    scene = free_space_scene()
    return [radio_scene(scene, antenna.frequency_hz) for antenna in tag.antennas]


def mission_table(study: Study) -> MissionTable:
    """Return the study's table ``[mission]``; refuse a study without one.

    Parameters
    ----------
    study : The study.
    """
    if study.mission is None:
        msg = "the study has no table [mission], which is needed to drive; add start_m and tags."
        raise ConfigError(msg)
    return study.mission


def check_navigator(study: Study) -> None:
    """Refuse a study without a mission, or whose navigator is a class that cannot drive one.

    Parameters
    ----------
    study : The study; a class of the user's own is imported.
    """
    name = mission_table(study).navigator
    if name not in NAVIGATORS:
        find_navigator(name)


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
    study = layout_study(study, layout)
    where = "" if layout is None else f"in layout {layout.name!r}: "
    room = rooms_of(study, layout)
    scene = build_scene(
        room_bodies(room),
        objects=object_bodies(room.objects),
        coordinate_bits=COORDINATE_BITS[study.solver.faces],
        floor_m=room.floor_m,
    )
    try:
        materials = study_materials(study)
        frequencies_hz = study.radio.frequencies_hz
        radios = radio_scenes(scene, frequencies_hz, solver_settings(study), materials)
        tags, notes = place_tags(study, scene)
        seen_m = seen_floor_m(study, scene, room)
        floor_notes = () if seen_m is None else (floor_note(scene, seen_m),)
        notes = (*notes, *floor_notes, *solid_wall_notes(study, scene))
        reader_z_m = scene.floor_height_m + study.reader.height_m
        map_z_m = scene.floor_height_m + (study.map.height_m or study.reader.height_m)
        check_heights(study, scene, reader_z_m, map_z_m)
        if study.mission is not None:
            refuse_under_floor(scene, seen_m, reader_z_m, name="the reader")
        check_starts(study, scene, reader_z_m)
    except OctantError as exc:
        if not where:
            raise
        msg = f"{where}{exc}"
        raise ConfigError(msg) from exc
    return Setting(
        study=study,
        layout=layout,
        scene=scene,
        radios=radios,
        tags=tags,
        reader_z_m=reader_z_m,
        map_z_m=map_z_m,
        notes=tuple(where + note for note in notes),
        sampling=sampling or Sampling(),
    )


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
        ray_tolerance_db=solver.ray_tolerance_db,
    )
