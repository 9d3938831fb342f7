"""Field maps of a study's tags in one of its rooms: plan, cost, computation, and error."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.antennas.kinds import Antenna
from octant.em.medium.radio_scene import RadioScene
from octant.em.power.field_maps import (
    HEADINGS,
    NODES_PER_WAVELENGTH,
    FieldMap,
    MapError,
    MapPlan,
    antennas_alike,
    make_field_map,
    map_error,
    plan_map,
)
from octant.em.power.node_paths import NodePaths, trace_node_paths
from octant.em.search.candidates import SolverSettings
from octant.geometries.errors import ConfigError
from octant.navigation.robot.floor import RobotSpace
from octant.reader_design.setting.placing import PlacedTag
from octant.reader_design.setting.rfid import is_woken
from octant.reader_design.setting.setting import Setting, build_setting

FloatArray = npt.NDArray[np.float64]

ERROR_PLACES, EXACT_PLACES = 300, 100
"""Random places [-] at which a map is compared with the solver, and with a more exact one."""
PATH_S, PLACE_S, WEDGE_S = 6e-6, 3e-5, 1e-5
"""Time [s] of a traced path, of a fine place and channel for each row of antennas, and of an edge
that diffracts at a node."""

MOST_WEDGES = 500
"""Edges that diffract [-] up to which maps contain paths over them unless the study says more."""

_ERROR_STREAM = 18_001
_OUTSIDE_M = 2.0
_BOX_FACETS = 6
_WEDGE_PLACE_S = 6e-7
_KEPT_PATHS, _KEPT_OVER_EDGES = 0.25, 0.7
_PATH_BYTES, _FIELD_BYTES = 8.0, 24.0


@dataclass(frozen=True, slots=True, kw_only=True)
class MapContext:
    """What the field maps of all tags of a room share.

    Parameters
    ----------
    radios, responses : The room and the reader at every channel.
    plan : The grids [m].
    reader_z_m : Height of the reader's centre [m].
    solver : How paths are searched.
    """

    radios: tuple[RadioScene, ...]
    responses: tuple[ReaderResponse, ...]
    plan: MapPlan
    reader_z_m: float
    solver: SolverSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class MappedTag:
    """A tag as its map needs it.

    Parameters
    ----------
    position_m : Place [m].
    antennas : Antenna at every channel.
    power_w : What it sends [W].
    """

    position_m: tuple[float, ...]
    antennas: tuple[Antenna, ...]
    power_w: float


def map_context(setting: Setting) -> MapContext:
    """Return what the maps of a room share.

    Parameters
    ----------
    setting : The reader in a room of a study with a mission [m].
    """
    table = setting.mission
    setting, has_edges = _with_edges(setting)
    if setting.scene.has_room:
        low, high = setting.scene.bounds_m[:, :2]
    else:
        starts = [start[:2] for start in table.starts] or [table.start_m]
        points = np.array([*starts, *(tag.point_m for tag in setting.tags)])
        low, high = points.min(axis=0) - _OUTSIDE_M, points.max(axis=0) + _OUTSIDE_M
    # What a facet shadows jumps there without the field of its edges.
    furnished = len(setting.scene.facets.facet_plane) > _BOX_FACETS and not has_edges
    plan = plan_map(
        low,
        high,
        wavelength_m=min(radio.wavelength_m for radio in setting.radios),
        spacing_m=table.map.spacing_m,
        nodes_per_wavelength=NODES_PER_WAVELENGTH[1 if furnished else 0],
    )
    return MapContext(
        radios=setting.radios,
        responses=setting.responses,
        plan=plan,
        reader_z_m=setting.reader_z_m,
        solver=setting.solver,
    )


def _with_edges(setting: Setting) -> tuple[Setting, bool]:
    """Return a room whose edges diffract as far as its maps contain that, and whether they do."""
    edged, wanted = _with_solver(setting, diffraction=True), setting.mission.map.edges
    if wanted is None:
        wanted = len(edged.radios[0].wedges) <= MOST_WEDGES
    return (edged if wanted else _with_solver(setting, diffraction=False)), wanted


def mapped_tags(setting: Setting) -> tuple[PlacedTag, ...]:
    """Return the tags that a map navigator hears: those of the mission first; woken ones refused.

    Parameters
    ----------
    setting : The reader in a room of a study with a mission.
    """
    names = dict.fromkeys((*setting.mission.tags, *(tag.id for tag in setting.tags)))
    tags = tuple(setting.tag(name) for name in names)
    for tag in tags:
        if is_woken(setting.study, tag):
            msg = (
                f'tag {tag.id!r} answers by backscatter, but mission.navigator "map" has maps of '
                'tags that send by themselves only; set its kind to "active", or take "tracker".'
            )
            raise ConfigError(msg)
    return tags


def map_forecast(setting: Setting) -> str:
    """Return in words how large the maps are and how long they take.

    Parameters
    ----------
    setting : The reader in a room of a study with a mission.
    """
    context, tags = map_context(setting), mapped_tags(setting)
    plan, rows = context.plan, antennas_alike(context.responses[0])
    channels = len(context.radios)
    paths = 3.0 * sum(6.0**order for order in range(context.solver.max_reflections + 1)) ** 0.7
    wedges = len(context.radios[0].wedges) if context.solver.diffraction else 0
    kept = plan.nodes * (_KEPT_PATHS * paths + _KEPT_OVER_EDGES * wedges)
    levels = plan.nbytes(rows, _headings(context.responses[0]))
    size = len(tags) * (levels + kept * (_PATH_BYTES + _FIELD_BYTES * channels)) / 1e6
    node_s = (paths * PATH_S + wedges * WEDGE_S) * (1.0 + channels)
    place_s = (PLACE_S + wedges * _WEDGE_PLACE_S) * channels * rows
    seconds = len(tags) * (plan.nodes * node_s + plan.places * place_s)
    return (
        f"field maps of {len(tags)} tags: {plan.places} places {plan.x_m[1] - plan.x_m[0]:.3f} m "
        f"apart, {channels} channels, {wedges} edges that diffract, {size:.0f} MB, about "
        f"{seconds:.0f} s of one core"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TagMap:
    """What is kept of a tag: the field of its surveyed place, and what follows for others.

    Parameters
    ----------
    field : Its field map.
    paths : Its strongest paths to the nodes.
    """

    field: FieldMap
    paths: NodePaths


def compute_map(context: MapContext, tag: MappedTag) -> TagMap:
    """Return the map of one tag.

    Parameters
    ----------
    context, tag : What all maps share; the tag.
    """
    paths = trace_node_paths(
        context.radios,
        context.plan.node_x_m,
        context.plan.node_y_m,
        tag_position_m=np.array(tag.position_m),
        tag_antennas=tag.antennas,
        reader_z_m=context.reader_z_m,
        solver=context.solver,
    )
    field = make_field_map(
        paths,
        context.radios,
        context.responses,
        context.plan,
        tag_power_w=tag.power_w,
        reader_z_m=context.reader_z_m,
    )
    return TagMap(field=field, paths=paths.strongest())


def exacter(setting: Setting) -> Setting:
    """Return a room with what its maps leave out: one more reflection, and edges that diffract.

    Parameters
    ----------
    setting : The reader in a room of a study with a mission.
    """
    more = setting.study.solver.max_reflections + 1
    return _with_solver(setting, max_reflections=more, diffraction=True)


def _with_solver(setting: Setting, **changes: int | bool) -> Setting:
    """Return a room whose waves are followed otherwise, with its reader as it is."""
    solver = msgspec.structs.replace(setting.study.solver, **changes)
    study = msgspec.structs.replace(setting.study, solver=solver)
    return build_setting(study, setting.layout, sampling=setting.sampling).with_responses(
        setting.responses
    )


def error_of(
    setting: Setting,
    found: FieldMap,
    tags: Sequence[PlacedTag],
    space: RobotSpace,
    *,
    places: int = ERROR_PLACES,
) -> tuple[tuple[MapError, ...], FloatArray, FloatArray]:
    """Return how far each tag's map is from the study's solver at random free places.

    With it the poses (m, 3) [m], [rad] and what the solver gives there, (t, m, n) [W].

    Parameters
    ----------
    setting, found, tags : The room as it is solved; the maps of tags, in order.
    space : Where the robot can stand.
    places : Number of places [-].
    """
    rng = np.random.default_rng((setting.study.seed, _ERROR_STREAM))
    low, high = (
        np.array([x[0], y[0]])
        for x, y in ((found.x_m, found.y_m), (found.x_m[::-1], found.y_m[::-1]))
    )
    points = rng.uniform(low, high, (20 * ERROR_PLACES, 2))
    points = points[space(points)][:places]
    poses = np.column_stack([points, rng.uniform(-math.pi, math.pi, len(points))])
    rss_w = np.array([setting.link(tag).rss_w(poses) for tag in tags])
    errors = tuple(map_error(found, one, poses, tag=number) for number, one in enumerate(rss_w))
    return errors, poses, rss_w


def error_sentence(errors: Sequence[MapError], what: str) -> str:
    """Return in words how far maps are from the solver.

    Parameters
    ----------
    errors, what : Of every tag; what the solver includes.
    """
    rms, p95 = (float(np.mean([getattr(e, name) for e in errors])) for name in ("rms_db", "p95_db"))
    under_db = float(np.mean([e.under_db for e in errors]))
    return (
        f"field maps against {what} at {errors[0].places} random places: {rms:.1f} dB rms, "
        f"95 % within {p95:.1f} dB, deep fades included; error field "
        f"{under_db:.0f} dB under the local mean."
    )


def _headings(response: ReaderResponse) -> int:
    return response.antennas * math.ceil(HEADINGS / response.antennas)
