"""The designed reader in the room, for every controller, estimator and SLAM: ``reader``."""

import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import msgspec
import numpy as np

from octant.em.power.radio_map import grid_axis_m
from octant.geometries.errors import PhysicsWarning
from octant.navigation.angles import wrap_angle
from octant.navigation.estimators.fingerprint import FingerprintFilter
from octant.navigation.estimators.particle import ParticleFilter
from octant.navigation.estimators.pose_filters import DeadReckoning, PoseEstimator
from octant.navigation.estimators.rss_kalman import (
    ExtendedKalman,
    KalmanBucy,
    RssAssumptions,
    UnscentedKalman,
)
from octant.navigation.estimators.slam_filter import SlamEstimator
from octant.navigation.sensing.rss_maps import RssMap
from octant.navigation.sensing.rss_models import (
    LogDistanceLaw,
    RssNoise,
    TagMesh,
    fit_log_distance,
    fit_log_exponential,
)
from octant.navigation.sensing.tag_layouts import tag_distances_m
from octant.navigation.sensing.tag_reader import (
    RangeBearingReader,
    TagReader,
    summed_dbm,
)
from octant.navigation.tracking import shapes
from octant.navigation.tracking.closed_loop import drive, run_seeds
from octant.navigation.tracking.controllers import MeasurementFeedback, TrackingController
from octant.navigation.tracking.measurement_feedback import FeedbackTraining
from octant.reader_design.experiments.tracking.chapters import (
    NeighbouringSetup,
    feedback_task,
    neighbouring_setup,
    predictive_control,
)
from octant.reader_design.experiments.tracking.parts import (
    ChapterTable,
    FloatArray,
    FurtherChapter,
    Part,
    PartRecord,
    Records,
    middle_and_90,
    outcomes_of,
    rows_of,
)
from octant.reader_design.experiments.tracking.results import Outcome
from octant.reader_design.experiments.tracking.room import (
    INTERPOLATION_DB,
    KEPT_M,
    REACH_M,
    SURVEY_SPACING_M,
    tags_in_room,
)
from octant.reader_design.experiments.tracking.settings import LEMNISCATE_START, Settings
from octant.reader_design.experiments.tracking.task_figure import COLOURS
from octant.reader_design.setting.receiver import study_sensor
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.showing.style import NamedFigure, figure_style, new_figure
from octant.reader_design.study_file.schema import Study, Tag

MARGIN_M = 0.3
"""How near to a wall the reader comes at most [m]."""
HEADINGS = 5
"""Headings at which the survey is read [-]; not a divisor of eight antennas."""
FAINT_DBM = -150.0
"""RSS that stands for none in maps and laws [dBm]."""
COLUMNS = (
    "method",
    "runs",
    "average_m_median",
    "average_m_90",
    "final_m_median",
    "runs_within_0_15_m",
    "law_exponent",
    "law_rms_db",
    "range_sigma_m",
    "bearing_sigma_deg",
)
"""Columns of reader.csv [m], [dB], [deg]; what the readings are like stands in every row."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Survey:
    """What is known of the reader's readings beforehand.

    Parameters
    ----------
    reader, slam_reader : The reader in the room: RSS, and range with bearing.
    tags_m : (s, 3) float64 — The tags, heights above the antennas [m].
    law, law_rms_db : Log-distance law of the summed RSS, and what it leaves [dB].
    distance_m, rss_dbm : (k,) float64 — The samples [m], [dBm].
    range_sigma_m, bearing_sigma_rad : Errors of range and bearing, rms [m], [rad].
    """

    reader: TagReader
    slam_reader: RangeBearingReader
    tags_m: FloatArray
    law: LogDistanceLaw
    law_rms_db: float
    distance_m: FloatArray
    rss_dbm: FloatArray
    range_sigma_m: float
    bearing_sigma_rad: float


def parts(settings: Settings) -> list[Part]:
    """Return a part for each knowledge of the RSS.

    Parameters
    ----------
    settings : The study.
    """
    del settings
    return [Part(chapter="reader", method=kind) for kind in (LAW, MAP, OTHERS)]


def with_tags(settings: Settings) -> Study:
    """Return the study with its ``[[tag]]``, or with dipoles where the keys of ``[track]`` say.

    Parameters
    ----------
    settings : The study [m].
    """
    study = settings.study
    if study.tags:
        return study
    setting = build_setting(study)
    tags = tags_in_room(settings, setting, 0)
    return msgspec.structs.replace(
        study,
        tags=tuple(
            Tag(
                id=f"tag {i}",
                position_m=(float(x), float(y), float(z) + setting.map_z_m),
                antenna="dipole",
            )
            for i, (x, y, z) in enumerate(tags, start=1)
        ),
    )


def surveyed(settings: Settings, setting: Setting) -> Survey:
    """Return the reader in the room, and what a survey of it says.

    Parameters
    ----------
    settings, setting : The study, and its room with tags and reader.
    """
    links = {tag.id: setting.link(tag) for tag in setting.tags}
    azimuths = next(iter(links.values())).azimuths_rad
    sensor = study_sensor(
        setting.study.sensor, links, azimuths, noise_db=settings.track.room_noise_db
    )
    low, high = setting.scene.bounds_m[:, :2]
    reader = TagReader(sensor=sensor, low_m=low + MARGIN_M, high_m=high - MARGIN_M)
    tags_m = np.array([tag.position_m for tag in setting.tags])
    tags_m[:, 2] -= setting.reader_z_m
    rng = np.random.default_rng([settings.study.seed, 12])
    axis = grid_axis_m(-REACH_M, REACH_M, spacing_m=SURVEY_SPACING_M)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    poses = np.column_stack([x.ravel(), y.ravel(), rng.uniform(-np.pi, np.pi, x.size)])
    powers = np.stack([link.rss_w(poses) for link in links.values()], axis=1)
    distance, level = tag_distances_m(poses, tags_m), summed_dbm(powers)
    heard = ~np.isnan(level)
    law, rms = fit_log_distance(distance[heard], level[heard])
    slam = RangeBearingReader(
        sensor=sensor,
        low_m=reader.low_m,
        high_m=reader.high_m,
        law=law,
        height_m=float(np.median(tags_m[:, 2])),
    )
    measured = slam.measured(powers, azimuths)
    offset = tags_m[None, :, :2] - poses[:, None, :2]
    true_bearing = np.arctan2(offset[..., 1], offset[..., 0]) - poses[:, 2, None]
    along = measured[..., 0] - np.hypot(offset[..., 0], offset[..., 1])
    aside = wrap_angle(measured[..., 1] - true_bearing)
    return Survey(
        reader=reader,
        slam_reader=slam,
        tags_m=tags_m,
        law=law,
        law_rms_db=rms,
        distance_m=distance[heard],
        rss_dbm=level[heard],
        # Ranges beyond the room are an outlier's: the middle half says how wide the rest is.
        range_sigma_m=float(np.quantile(np.abs(along[heard]), 0.68)),
        bearing_sigma_rad=float(np.sqrt(np.mean(aside[heard] ** 2))),
    )


def reader_map(settings: Settings, survey: Survey) -> RssMap:
    """Return the map of the summed RSS, in the mean over headings [dBm].

    Parameters
    ----------
    settings, survey : Its spacing [m], and the reader.
    """
    axis = grid_axis_m(-REACH_M, REACH_M, spacing_m=settings.track.reader_map_spacing_m)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    places = np.column_stack([x.ravel(), y.ravel()])
    turns = 2.0 * np.pi * np.arange(HEADINGS) / HEADINGS
    layers = []
    for link in survey.reader.sensor.links.values():  # type: ignore[attr-defined]
        power = link.rss_by_heading_w(places, turns).sum(axis=-1).mean(axis=-1)
        level = np.nan_to_num(summed_dbm(power[:, None]), nan=FAINT_DBM)
        layers.append(level.reshape(len(axis), len(axis)))
    return RssMap(x_m=axis, y_m=axis, rss=np.stack(layers, axis=-1))


LAW, MAP, OTHERS = "law", "map", "others"
"""What is known of the RSS: a law of distance, or its map; and what needs neither."""
Method = tuple[str, TrackingController, PoseEstimator[Any], TagReader]


def _methods(
    settings: Settings, survey: Survey, setup: NeighbouringSetup, kind: str
) -> Iterator[Method]:
    """Yield the controllers with the estimators of a part: name, both, and how they read."""
    motion, reader, control = settings.motion, survey.reader, setup.control
    predictive = predictive_control(settings, setup)
    if kind == LAW:
        sensor = TagMesh(tags_m=survey.tags_m, law=survey.law)
        noise = _assumed(settings, survey.law_rms_db)
        for estimator in (ExtendedKalman, KalmanBucy, UnscentedKalman):
            made = estimator(motion=motion, sensor=sensor, noise=noise)
            yield f"neighbouring + {_SHORT[estimator]}, law", control, made, reader
        yield "predictive + UKF, law", predictive, made, reader
    elif kind == MAP:
        chart, noise = reader_map(settings, survey), _assumed(settings, INTERPOLATION_DB)
        ukf = UnscentedKalman(motion=motion, sensor=chart, noise=noise)
        particles = ParticleFilter(
            motion=motion,
            sensor=chart,
            sigma_db=noise.sigma_db,
            particles=settings.track.room_particles,
        )
        yield "neighbouring + particles, map", control, particles, reader
        yield "neighbouring + UKF, map", control, ukf, reader
        yield "predictive + UKF, map", predictive, ukf, reader
        yield "neighbouring + fingerprints", control, _prints(settings, chart), reader
    else:
        slam = SlamEstimator(
            motion=motion,
            tags_m=survey.tags_m[:, :2],
            range_sigma_m=survey.range_sigma_m,
            bearing_sigma_rad=survey.bearing_sigma_rad,
        )
        yield "neighbouring + EKF SLAM", control, slam, survey.slam_reader
        dead = DeadReckoning(motion=motion)
        yield "neighbouring, dead reckoning", control, dead, reader
        yield "measurement feedback", _trained(settings, survey), dead, reader


_SHORT = {ExtendedKalman: "EKF", KalmanBucy: "Kalman-Bucy", UnscentedKalman: "UKF"}


def _assumed(settings: Settings, model_db: float) -> RssAssumptions:
    sigma_db = math.hypot(settings.track.room_noise_db, model_db)
    return RssAssumptions(sigma_db=sigma_db, mean_sigma_db=0.0)


def _prints(settings: Settings, chart: RssMap) -> FingerprintFilter:
    """Return the fingerprint filter with the spread that its fixes really have."""
    prints = FingerprintFilter(motion=settings.motion, survey=chart, sigma_m=1.0)
    rng = np.random.default_rng([settings.study.seed, 8])
    places = rng.uniform(-REACH_M, REACH_M, (200, 2))
    clean = chart.rss_dbm(places)
    fixes = prints.fix_m(clean + rng.normal(0.0, settings.track.room_noise_db, clean.shape))
    return replace(prints, sigma_m=float(np.sqrt(np.mean((fixes - places) ** 2))))


def _trained(settings: Settings, survey: Survey) -> MeasurementFeedback:
    """Return chapter 6's feedback, trained over records of the reader's law and scatter."""
    track = settings.track
    law, rms = fit_log_exponential(survey.distance_m, survey.rss_dbm)
    there = replace(settings, law=law, given_tags_m=survey.tags_m)
    work = feedback_task(there, shapes.lemniscate(), LEMNISCATE_START)
    noise = RssNoise(mean_db=0.0, sigma_db=math.hypot(track.room_noise_db, rms))
    rng = np.random.default_rng([settings.study.seed, 13])
    records = noise.draw((track.training_records, *work.record_shape), rng)
    gains, _ = FeedbackTraining(iterations=track.training_iterations).train(work, records)
    return MeasurementFeedback(gains=gains)


def compute(settings: Settings, part: Part) -> PartRecord:
    """Return the lemniscate followed with the designed reader by the methods of a part.

    Parameters
    ----------
    settings, part : The study, and one of its `parts`.
    """
    track = settings.track
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", PhysicsWarning)
        setting = build_setting(with_tags(settings)).solved()
        survey = surveyed(settings, setting)
    said = [str(w.message) for w in caught if issubclass(w.category, PhysicsWarning)]
    setup = neighbouring_setup(settings, shapes.lemniscate(), LEMNISCATE_START)
    world = settings.world(
        TagMesh(tags_m=survey.tags_m, law=survey.law),
        tags_m=survey.tags_m,
        reading_every=max(round(track.room_reading_every_s / track.period_s), 1),
    )
    follow = partial(
        drive,
        desired=setup.desired,
        start=setup.start,
        seeds=run_seeds(settings.study.seed, track.runs),
    )
    outcomes, rows = [], []
    task = f"{len(survey.tags_m)} tags"
    for method, controller, estimator, reader in _methods(settings, survey, setup, part.method):
        record = follow(controller, estimator, replace(world, hearing=None, reader=reader))
        outcome = Outcome(chapter=part.chapter, task=task, method=method, runs=record)
        outcomes.append(outcome)
        average = record.average_error_m
        rows.append(
            (
                method,
                len(average),
                *middle_and_90(average),
                float(np.median(record.final_error_m)),
                int((average <= KEPT_M).sum()),
                survey.law.exponent,
                survey.law_rms_db,
                survey.range_sigma_m,
                math.degrees(survey.bearing_sigma_rad),
            )
        )
    notes = tuple(dict.fromkeys((*setting.notes, *said)))
    return PartRecord(outcomes=tuple(outcomes), rows=tuple(rows), notes=notes)


def said(settings: Settings, records: Records) -> tuple[str, ...]:
    """Return the sentences on the page.

    Parameters
    ----------
    settings, records : The study, and what its part left.
    """
    reader, rows = settings.study.reader, rows_of(records)
    best = min(rows, key=lambda row: float(row[2] or 0.0))
    return (
        (
            f"Here the study's reader with {reader.antennas} antennas reads every tag, through the "
            "room solver's field, its embedded patterns and the device of [sensor], every "
            f"{settings.track.room_reading_every_s:g} s. Controllers and filters get the sum of "
            "its antennas' powers. That departs from a law of distance (exponent "
            f"{rows[0][6]:.2f}) by {rows[0][7]:.1f} dB; SLAM gets ranges of ± {rows[0][8]:.1f} m "
            f"and bearings of ± {rows[0][9]:.0f}° from the same readings. Best is {best[0]}."
        ),
    )


def tables(settings: Settings, records: Records) -> tuple[ChapterTable, ...]:
    """Return the chapter's table.

    Parameters
    ----------
    settings, records : The study, and what its part left.
    """
    caption = f"The lemniscate in the room, {settings.track.runs} runs of every method."
    return (
        ChapterTable(file="reader.csv", caption=caption, header=COLUMNS, rows=rows_of(records)),
    )


def figures(settings: Settings, records: Records) -> Iterator[NamedFigure]:
    """Yield the average error of every method [m].

    Parameters
    ----------
    settings, records : The study, and what its part left.
    """
    del settings
    outcomes = outcomes_of(records)
    with figure_style():
        figure, (axes,) = new_figure(
            width_in=11.4,
            height_in=4.8,
            title="The lemniscate with the designed reader in the room",
            columns=2,
        )
        plan, bars = axes
        plan.plot(*outcomes[0].runs.desired.poses[:, :2].T, color="#999999", lw=4, alpha=0.5)
        ranked = sorted(outcomes, key=lambda o: float(np.median(o.runs.average_error_m)))
        for outcome, colour in zip(ranked[:3], COLOURS, strict=False):
            plan.plot(*outcome.runs.poses[0, :, :2].T, color=colour, label=outcome.method, lw=1.1)
        plan.set_aspect("equal", adjustable="datalim")
        plan.set_title("the three best (run 0); grey: desired")
        plan.set_xlabel("x [m]")
        plan.set_ylabel("y [m]")
        plan.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), fontsize=7.5)
        names = [o.method for o in ranked]
        middle = [float(np.median(o.runs.average_error_m)) for o in ranked]
        bars.barh(names, middle, color=COLOURS[0], alpha=0.6)
        for o in ranked:
            average = o.runs.average_error_m
            bars.plot(average, [o.method] * len(average), ".", color="#222222", markersize=2)
        bars.invert_yaxis()
        bars.set_xlim(left=0.0)
        bars.set_title("average error: median (bar), every run (dots)")
        bars.set_xlabel("average distance to the desired place [m]")
    yield NamedFigure(
        file="reader.png",
        section="reader",
        title="The designed reader in the room",
        caption="Paths of the best methods, and the error of every controller and estimator.",
        figure=figure,
    )


CHAPTER = FurtherChapter(
    heading="The designed reader in the room",
    parts=parts,
    compute=compute,
    said=said,
    tables=tables,
    figures=figures,
)
