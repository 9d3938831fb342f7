"""Tracking with RSS from the room solver, by estimators that know more or less of the field."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna, make_antenna
from octant.em.decibels import power_dbm
from octant.em.medium.materials import material
from octant.em.medium.radio_scene import radio_scene
from octant.em.power.image_fields import ImageField, trace_image_field
from octant.em.power.radio_map import grid_axis_m
from octant.geometries.errors import ConfigError
from octant.navigation.estimators.fingerprint import FingerprintFilter
from octant.navigation.estimators.particle import ParticleFilter
from octant.navigation.estimators.pose_filters import DeadReckoning, PoseEstimator
from octant.navigation.estimators.rss_kalman import (
    ExtendedKalman,
    RssAssumptions,
    UnscentedKalman,
)
from octant.navigation.sensing.rss_maps import RssMap
from octant.navigation.sensing.rss_models import (
    LogDistanceLaw,
    RssNoise,
    TagMesh,
    fit_log_distance,
)
from octant.navigation.tracking import shapes
from octant.navigation.tracking.closed_loop import drive, run_seeds
from octant.reader_design.experiments.tracking.chapters import neighbouring_setup
from octant.reader_design.experiments.tracking.results import Outcome
from octant.reader_design.experiments.tracking.settings import LEMNISCATE_START, Settings
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.study_file.bodies import study_materials

FloatArray = npt.NDArray[np.float64]

REACH_M = 3.8
"""Half of the mapped square around the lemniscate [m]."""
TRACE_SPACING_M = 0.25
"""Grid on which paths are traced [m]."""
SURVEY_SPACING_M = 0.2
"""Grid of a site survey by hand, on which laws and local means are fitted [m]."""
KEPT_M = 0.15
"""A run whose average error is at most this stayed on the trajectory [m]."""
FADED_FLOOR_DBM = -150.0
"""RSS in a field's zero [dBm]."""
MISPLACED_M = 0.02
"""The wrong map has brick walls, and tags this far from where they hang (each coordinate) [m]."""
INTERPOLATION_DB = 1.0
"""What a filter adds to its readings' noise for a map's interpolation [dB]."""
PARTICLE, UKF_MAP = "particle filter, computed map", "UKF, computed map"
LOCAL_MEAN, LOG_DISTANCE = "UKF, local-mean map", "EKF, log-distance law"
FINGERPRINT, DEAD = "fingerprints of a survey + odometry", "dead reckoning"
WRONG_MAP = "particle filter, map that is wrong"


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldRss:
    """The RSS of the room solver at any place, coherent: an `RssModel`.

    Parameters
    ----------
    field : Fields of the tags [W].
    """

    field: ImageField

    def rss_dbm(self, places_m: FloatArray) -> FloatArray:
        """Return (m, s) RSS of all tags [dBm]; places off the traced rectangle go to its rim."""
        x, y = self.field.x_m, self.field.y_m
        inside = np.column_stack(
            [np.clip(places_m[:, 0], x[0], x[-1]), np.clip(places_m[:, 1], y[0], y[-1])]
        )
        floor_w = 10.0 ** (0.1 * FADED_FLOOR_DBM - 3.0)
        power = np.maximum(self.field.coherent_w(inside), floor_w)
        return power_dbm(power)


@dataclass(frozen=True, slots=True, kw_only=True)
class RoomRuns:
    """The lemniscate tracked with RSS of the room solver, with one mesh of tags.

    Parameters
    ----------
    outcomes : One for each estimator.
    facts : What the field is like, and how many runs were near the trajectory [m, dB].
    map_x_m, map_dbm : (nx,), (nx, nx) float64 — Grid [m], and RSS of the middle tag on it [dBm].
    """

    outcomes: tuple[Outcome, ...]
    facts: tuple[str, ...]
    map_x_m: FloatArray
    map_dbm: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class _Knowledge:
    """What estimators can know of the field: its map, its local mean, its law of distance."""

    computed: RssMap
    local_mean: RssMap
    mean_rms_db: float
    mesh: TagMesh
    law: LogDistanceLaw
    law_rms_db: float
    wrong: RssMap | None


def meshes(settings: Settings) -> tuple[int, ...]:
    """Return the numbers of the meshes of tags: that of chapter 6, that of chapter 7.

    Tags that the study gives, or counts, are one mesh for both.

    Parameters
    ----------
    settings : The study.
    """
    one = settings.given_tags_m is not None or settings.track.tag_count is not None
    return (0,) if one else (0, 1)


def room_runs(settings: Settings, mesh: int) -> RoomRuns:
    """Return the lemniscate tracked from RSS of the room solver, by every estimator.

    Parameters
    ----------
    settings, mesh : The study, and one of its `meshes`, of which the first meets a wrong map too.
    """
    track = settings.track
    setup = neighbouring_setup(settings, shapes.lemniscate(), LEMNISCATE_START)
    seeds = run_seeds(settings.study.seed, track.runs)
    field, tags_m = _field(settings, mesh)
    known = _known(settings, field, tags_m, imagine_wrong=mesh == 0)
    world = settings.world(
        FieldRss(field=field),
        tags_m=tags_m,
        noise=RssNoise(mean_db=0.0, sigma_db=track.room_noise_db),
        reading_every=max(round(track.room_reading_every_s / track.period_s), 1),
    )
    task = f"{len(tags_m)} tags"
    departs = (
        f"{task}: the coherent field departs from its local mean by {known.mean_rms_db:.1f} dB "
        f"(rms) and from the log-distance law by {known.law_rms_db:.1f} dB, whose exponent is "
        f"{known.law.exponent:.2f}"
    )
    facts = [departs]
    outcomes = []
    for method, estimator in _estimators(settings, known):
        record = drive(
            setup.control, estimator, world, setup.desired, start=setup.start, seeds=seeds
        )
        outcomes.append(Outcome(chapter="room", task=task, method=method, runs=record))
        kept = int((record.average_error_m <= KEPT_M).sum())
        facts.append(f"{task}, {method}: {kept} of {len(seeds)} runs average {KEPT_M:g} m or less")
    middle = known.computed.rss.shape[2] // 2
    return RoomRuns(
        outcomes=tuple(outcomes),
        facts=tuple(facts),
        map_x_m=known.computed.x_m,
        map_dbm=known.computed.rss[:, :, middle],
    )


def check_room(settings: Settings) -> None:
    """Refuse a room that does not hold the mapped square and the tags.

    Parameters
    ----------
    settings : The study [m].
    """
    setting = build_setting(settings.study)
    for mesh in meshes(settings):
        tags_in_room(settings, setting, mesh)


def tags_in_room(settings: Settings, setting: Setting, mesh: int) -> FloatArray:
    """Return the tags' places (s, 3), heights above the antenna [m].

    Parameters
    ----------
    settings, setting : The study and its room, which must hold the mapped square and the tags.
    mesh : One of the `meshes`.
    """
    track, standoff_m = settings.track, settings.study.solver.standoff_m
    side, spacing_m = (
        (track.feedback_tags, track.tag_spacing_m),
        (track.tags, track.room_tag_spacing_m),
    )[mesh]
    low, high = setting.scene.bounds_m
    height_m = float(high[2]) - standoff_m - setting.map_z_m
    tags = settings.tags_m(side, spacing_m=spacing_m, height_m=height_m)
    wanted = max(REACH_M, float(np.abs(tags[:, :2]).max()) + standoff_m)
    if (low[:2] > -wanted).any() or (high[:2] < wanted).any():
        msg = (
            f"the room spans {low[:2].tolist()} to {high[:2].tolist()} m, but the chapter 'room' "
            f"of [track] needs x and y from {-wanted:g} to {wanted:g} m; take a larger room, or "
            "leave that chapter out."
        )
        raise ConfigError(msg)
    return tags


def _field(settings: Settings, mesh: int, *, wrong: bool = False) -> tuple[ImageField, FloatArray]:
    """Return the tags' fields and places (s, 3), heights above the antenna [m]."""
    study = settings.study
    setting = build_setting(study)
    tags, z_m = tags_in_room(settings, setting, mesh), setting.map_z_m
    carrier = study.radio.frequency_hz
    materials = study_materials(study)
    if wrong:
        materials = dict.fromkeys(materials, material("brick"))
        rng = np.random.default_rng([study.seed, 9])
        tags = tags + rng.normal(0.0, MISPLACED_M, tags.shape) * (1.0, 1.0, 0.0)
    axis = grid_axis_m(-REACH_M - 0.5, REACH_M + 0.5, spacing_m=TRACE_SPACING_M)
    field = trace_image_field(
        radio_scene(setting.scene, carrier, materials, transmission=study.solver.transmission),
        [
            ((*tag[:2], tag[2] + z_m), antenna)
            for tag, antenna in zip(tags, _antennas(setting, len(tags)), strict=True)
        ],
        receiver=make_antenna("isotropic_theta", carrier),
        x_m=axis,
        y_m=axis,
        z_m=z_m,
        solver=setting.solver,
        channels_hz=np.array(study.radio.frequencies_hz),
        power_w=study.radio.tag_power_w,
    )
    return field, tags


def _antennas(setting: Setting, tags: int) -> list[Antenna]:
    """Return every tag's antenna at the carrier, or the channel next to it; else a dipole."""
    radio = setting.study.radio
    if not setting.tags:
        return [make_antenna("dipole", radio.frequency_hz)] * tags
    nearest = int(np.argmin(np.abs(np.array(radio.frequencies_hz) - radio.frequency_hz)))
    return [tag.antennas[nearest] for tag in setting.tags]


def _computed_map(settings: Settings, field: ImageField) -> RssMap:
    axis = grid_axis_m(-REACH_M, REACH_M, spacing_m=settings.track.room_map_spacing_m)
    return _sampled(FieldRss(field=field).rss_dbm(_grid(axis)), axis)


def _grid(axis_m: FloatArray) -> FloatArray:
    x, y = np.meshgrid(axis_m, axis_m, indexing="ij")
    return np.column_stack([x.ravel(), y.ravel()])


def _sampled(rss: FloatArray, axis_m: FloatArray) -> RssMap:
    return RssMap(x_m=axis_m, y_m=axis_m, rss=rss.reshape(len(axis_m), len(axis_m), -1))


def _known(
    settings: Settings, field: ImageField, tags_m: FloatArray, *, imagine_wrong: bool
) -> _Knowledge:
    axis = grid_axis_m(-REACH_M, REACH_M, spacing_m=SURVEY_SPACING_M)
    places = _grid(axis)
    coherent = FieldRss(field=field).rss_dbm(places)
    mean = power_dbm(field.local_mean_w(places))
    # Fades are deeper than peaks are high: the mean of decibels lies below that of watts.
    mean += coherent.mean() - mean.mean()
    offset = places[:, None] - tags_m[:, :2]
    distance = np.sqrt(np.sum(offset**2, axis=2) + tags_m[:, 2] ** 2)
    law, rms = fit_log_distance(distance.ravel(), coherent.ravel())
    wrong = None
    if imagine_wrong:
        other, _ = _field(settings, 0, wrong=True)
        wrong = _computed_map(settings, other)
    return _Knowledge(
        computed=_computed_map(settings, field),
        local_mean=_sampled(mean, axis),
        mean_rms_db=float(np.std(coherent - mean)),
        mesh=TagMesh(tags_m=tags_m, law=law),
        law=law,
        law_rms_db=rms,
        wrong=wrong,
    )


def _estimators(
    settings: Settings, known: _Knowledge
) -> tuple[tuple[str, PoseEstimator[Any]], ...]:
    track, motion = settings.track, settings.motion

    def noise(model_db: float) -> RssAssumptions:
        return RssAssumptions(
            sigma_db=float(np.hypot(track.room_noise_db, model_db)), mean_sigma_db=0.0
        )

    step = max(round(SURVEY_SPACING_M / track.room_map_spacing_m), 1)
    survey = RssMap(
        x_m=known.computed.x_m[::step],
        y_m=known.computed.y_m[::step],
        rss=known.computed.rss[::step, ::step],
    )
    close = noise(INTERPOLATION_DB)

    def particles(sensor: RssMap, sigma_db: float) -> ParticleFilter:
        return ParticleFilter(
            motion=motion, sensor=sensor, sigma_db=sigma_db, particles=track.room_particles
        )

    rows: list[tuple[str, PoseEstimator[Any]]] = [
        (PARTICLE, particles(known.computed, close.sigma_db)),
        (UKF_MAP, UnscentedKalman(motion=motion, sensor=known.computed, noise=close)),
        (
            LOCAL_MEAN,
            UnscentedKalman(motion=motion, sensor=known.local_mean, noise=noise(known.mean_rms_db)),
        ),
        (
            LOG_DISTANCE,
            ExtendedKalman(motion=motion, sensor=known.mesh, noise=noise(known.law_rms_db)),
        ),
        (FINGERPRINT, _fingerprints(settings, survey, known.computed)),
        (DEAD, DeadReckoning(motion=motion)),
    ]
    if known.wrong is not None:
        difference = float(np.std(known.wrong.rss - known.computed.rss))
        rows.insert(1, (WRONG_MAP, particles(known.wrong, noise(difference).sigma_db)))
    return tuple(rows)


def _fingerprints(settings: Settings, survey: RssMap, computed: RssMap) -> FingerprintFilter:
    """Return the fingerprint filter with the spread that its fixes really have."""
    rng = np.random.default_rng([settings.study.seed, 8])
    places = rng.uniform(-REACH_M, REACH_M, (400, 2))
    clean = computed.rss_dbm(places)
    readings = clean + rng.normal(0.0, settings.track.room_noise_db, clean.shape)
    trial = FingerprintFilter(motion=settings.motion, survey=survey, sigma_m=1.0)
    error = trial.fix_m(readings) - places
    return FingerprintFilter(
        motion=settings.motion, survey=survey, sigma_m=float(np.sqrt(np.mean(error**2)))
    )
