"""The filter of a robot's pose by field maps, which are kept."""

import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.power.field_maps import FieldMap, MapError, joined
from octant.em.power.node_paths import NodePaths
from octant.em.power.path_maps import make_path_map
from octant.geometries.errors import ConfigError, NavigationError
from octant.navigation.navigators.learned import Learned
from octant.navigation.navigators.pose_particles import PoseFilter, misplaced_share
from octant.navigation.navigators.tag_places import TagSurvey
from octant.navigation.robot.floor import Blocked, RobotSpace
from octant.navigation.robot.motion import Integration
from octant.reader_design.keeping.keeper import map_cases
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.workers import Crew
from octant.reader_design.mapping.field_maps import (
    EXACT_PLACES,
    MappedTag,
    compute_map,
    error_of,
    error_sentence,
    exacter,
    map_context,
    map_forecast,
    mapped_tags,
)
from octant.reader_design.mapping.learned_file import read_learned
from octant.reader_design.mapping.map_file import TagMapCodec
from octant.reader_design.setting.placing import PlacedTag
from octant.reader_design.setting.setting import Setting
from octant.reader_design.study_file.calibration import sent_w

FloatArray = npt.NDArray[np.float64]

SEARCHED_PART = 0.5
"""Tags' places are searched for while driving where that leaves less than this part of the variance
of fading that survey and map together leave unknown [-]: in plain rooms with a survey of 6 mm or
more at 2.4 GHz; not where maps are so poor that the survey hardly matters."""

TRUST, ALIKE = 0.5, 2.5
"""Power of a reading's likelihood where map and survey are exact [-], and by how much it falls with
the power of their expected error field over the local mean: that field is alike at places close by
and at all antennas, so that readings repeat one error, and a filter that took them for independent
would be surer than it may be. At 0.4, as among metal shelves, it is halved."""

FADING_DB = 5.57
"""Deviation of the level of an exponential power [dB]: of a field of very many waves."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MapStore:
    """Where field maps are kept, and who computes them.

    Parameters
    ----------
    folder : Their folder; None: they are not kept.
    crew, progress : Workers that share the tags, None: this process; shows maps.
    """

    folder: Path | None = None
    crew: Crew | None = None
    progress: Progress | None = None


def study_maps(
    setting: Setting, space: RobotSpace, store: MapStore
) -> tuple[FieldMap, tuple[NodePaths, ...], tuple[MapError, ...], tuple[FloatArray, FloatArray]]:
    """Return the field maps of all tags of a room, and how far they are from a more exact field.

    With them the tags' paths, and poses (m, 3) [m], [rad] and the RSS there by that field,
    (t, m, n) [W].

    Parameters
    ----------
    setting, space : The reader in a room of a study with a mission; where the robot can stand.
    store : Where maps are kept.
    """
    tags, context = found_tags(setting), map_context(setting)
    cases = [
        MappedTag(
            position_m=tuple(tag.position_m.tolist()),
            antennas=tag.antennas,
            power_w=sent_w(setting.study, tag.id),
        )
        for tag in tags
    ]
    say = (store.progress or Progress()).say
    say(f"{map_forecast(setting)}.")
    with tempfile.TemporaryDirectory() as scratch:
        kept = map_cases(
            compute_map,
            cases,
            context=context,
            folder=store.folder or Path(scratch),
            codec=TagMapCodec(),
            crew=store.crew,
            progress=store.progress,
            label="field maps",
        )
    found = joined([one.value.field for one in kept])
    say(error_sentence(error_of(setting, found, tags, space)[0], "the solver"))
    errors, *exact = error_of(exacter(setting), found, tags, space, places=EXACT_PLACES)
    say(error_sentence(errors, "one more reflection and diffraction"))
    paths = tuple(one.value.paths for one in kept)
    return found, paths, errors, (exact[0], exact[1])


def study_pose_filter(
    setting: Setting,
    space: RobotSpace,
    store: MapStore,
    *,
    bounds_m: tuple[FloatArray, FloatArray],
    blocked: Blocked,
    method: Integration,
) -> PoseFilter:
    """Return the filter of the pose by the field maps of all tags of a room.

    Parameters
    ----------
    setting, space, store : As for `study_maps`.
    bounds_m : Least and greatest x and y of the floor, (2,) float64 each [m].
    blocked : Where the robot's centre cannot be.
    method : How its odometry adds up a period's motion.
    """
    table = setting.mission
    low, high = bounds_m
    found, paths, errors, exact = study_maps(setting, space, store)
    wavelength_m = SPEED_OF_LIGHT_M_PER_S / max(r.frequency_hz for r in setting.radios)
    known = known_before(setting)
    sd_m = np.full((found.tags, 3), table.map.tag_sd_m) if known is None else known.offset_sd_m
    shares = np.minimum([error.share + table.map.field_error for error in errors], 1.0)
    off_m = math.sqrt(float(np.mean(sd_m**2)))
    left = unknown_part(float(np.mean(shares)))
    survey = misplaced_share(off_m, wavelength_m=wavelength_m)
    searched = None
    if left < SEARCHED_PART * unknown_part(float(np.mean(shares)) + survey):
        searched = study_survey(setting, paths, sd_m)
    error = float(np.mean(shares)) + (survey if searched is None else 0.0)
    try:
        made = PoseFilter(
            maps=found,
            shares=shares,
            floors_w=np.array([error.floor_w for error in errors]),
            low_m=low,
            high_m=high,
            blocked=blocked,
            wavelength_m=wavelength_m,
            radius_m=setting.reader.antenna_radius_m,
            noise_db=max(table.noise_db, 0.5),
            fading_db=fading_of(found),
            level_db=table.map.level_sd_db,
            gain_db=table.map.gain_sd_db,
            survey=searched,
            survey_sd_m=off_m,
            known=known,
            base_m=None if known is None else known.offset_m,
            base_sd_m=sd_m,
            particles=table.map.particles,
            trust=TRUST / (1.0 + ALIKE * min(error, 1.0)),
            method=method,
        )
    except NavigationError as exc:
        raise ConfigError(str(exc)) from exc
    if searched is not None:
        return made
    return replace(
        made, rivals_limit=made.limit_of(*exact, np.random.default_rng(setting.study.seed))
    )


def unknown_part(share: float) -> float:
    """Return how much of the variance of fading is unknown beside an error field [-].

    Parameters
    ----------
    share : Power of the error field over the local mean [-].
    """
    part = share / (1.0 + share)
    return part * (2.0 - part)


def known_before(setting: Setting) -> Learned | None:
    """Return what earlier missions have found, of the tags that are heard [m], [dB]; None: nothing.

    Parameters
    ----------
    setting : The reader in a room of a study with a mission.
    """
    file = setting.mission.map.learned
    if file is None:
        return None
    names = tuple(tag.id for tag in mapped_tags(setting))
    try:
        return read_learned(Path(file)).of(names, antennas=setting.responses[0].antennas)
    except NavigationError as exc:
        msg = f"{file}: {exc}"
        raise ConfigError(msg) from exc


def found_tags(setting: Setting) -> tuple[PlacedTag, ...]:
    """Return the tags that a map navigator hears, where earlier missions have found them.

    Parameters
    ----------
    setting : The reader in a room of a study with a mission.
    """
    tags, known = mapped_tags(setting), known_before(setting)
    if known is None:
        return tags
    return tuple(
        replace(tag, position_m=tag.position_m + off)
        for tag, off in zip(tags, known.offset_m, strict=True)
    )


def study_survey(setting: Setting, paths: Sequence[NodePaths], sd_m: FloatArray) -> TagSurvey:
    """Return the tags' paths and survey, for tags whose places are to be found while driving.

    Parameters
    ----------
    setting, paths : The reader in a room of a study with a mission; the paths of each tag.
    sd_m : (t, 3) float64 — Deviations of what is known of the tags' places [m].
    """
    context, tags = map_context(setting), found_tags(setting)
    found = tuple(
        make_path_map(
            some,
            context.radios,
            context.responses,
            context.plan,
            tag_power_w=sent_w(setting.study, tag.id),
            reader_z_m=context.reader_z_m,
        )
        for some, tag in zip(paths, tags, strict=True)
    )
    return TagSurvey(
        paths=found,
        sd_m=np.maximum(sd_m, setting.mission.map.tag_sd_m),
        known_m=np.zeros((len(tags), 3)),
        known_sd_m=sd_m,
    )


def fading_of(maps: FieldMap) -> FloatArray:
    """Return the deviation of the coherent level around the local mean of each tag, (t,) [dB].

    Many channels average fading out; at most that of an exponential power is taken.

    Parameters
    ----------
    maps : Of all tags.
    """
    rng = np.random.default_rng(0)
    low, high = (np.array([x[k], y[k]]) for k in (0, -1) for x, y in ((maps.x_m, maps.y_m),))
    poses = np.column_stack(
        [rng.uniform(low, high, (2000, 2)), rng.uniform(-math.pi, math.pi, 2000)]
    )
    found = []
    for tag in range(maps.tags):
        here, mean = maps.rss_w(poses, tag=tag), maps.local_mean_w(poses, tag=tag)
        sound = (here > 0.0) & (mean > 0.0)
        error = 10.0 * np.log10(here[sound] / mean[sound])
        found.append(float(np.clip(np.std(error), 1.0, FADING_DB)))
    return np.array(found)
