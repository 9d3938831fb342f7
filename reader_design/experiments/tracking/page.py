"""The report of a tracking study: figures and numbers beside those of the thesis."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.reader_design.experiments.tracking.chapters import (
    EKF,
    FRESH,
    IGNORED,
    ILQR,
    MANY,
    REPLAY,
)
from octant.reader_design.experiments.tracking.compute import TrackingContent
from octant.reader_design.experiments.tracking.further import FURTHER
from octant.reader_design.experiments.tracking.results import SLAM_COLUMNS, Outcome, slam_row
from octant.reader_design.experiments.tracking.room import PARTICLE
from octant.reader_design.experiments.tracking.settings import RESERVED_NAMES
from octant.reader_design.keeping.versions import versions
from octant.reader_design.showing.pages import Report, ReportSection, ReportTable, embedded_figures

FloatArray = npt.NDArray[np.float64]
FigureFiles = Mapping[str, Sequence[tuple[str, str, Path]]]


Key = tuple[str, str, str]

THESIS = (
    "S. Miah, Design and Implementation of Control Techniques for Differential Drive Mobile "
    "Robots: An RFID Approach, PhD thesis, University of Ottawa."
)
"""The source of the published figures, in full."""
_NOT = "not in the thesis"
_PUBLISHED: dict[Key, tuple[tuple[str, str, str], ...]] = {
    ("feedback", "line", REPLAY): (("average_m", "line, replayed noise", "0.07 m"),),
    ("feedback", "line", FRESH): (("average_m", "line, fresh noise", "not separated"),),
    ("feedback", "line", MANY): (("average_m", "line, trained over many records", "not done"),),
    ("feedback", "sine", REPLAY): (("average_m", "sine, replayed noise", "0.08 m"),),
    ("feedback", "sine", FRESH): (("average_m", "sine, fresh noise", "not separated"),),
    ("feedback", "sine", MANY): (("average_m", "sine, trained over many records", "not done"),),
    ("nominal", "ellipse", ILQR): (("average_m", "ellipse, average error", "0.07 m"),),
    ("nominal", "parabola", ILQR): (("average_m", "parabola (start not printed)", "0.18 m"),),
    ("nominal", "sigmoid", ILQR): (("average_m", "sigmoid, average error", "0.09 m"),),
    ("nominal", "point", ILQR): (
        ("final_m", "point, final error", "0.02 m"),
        ("final_heading_deg", "point, final heading", "–"),
    ),
    ("nominal", "eight poses", ILQR): (
        ("final_m", "eight poses, final error", "–"),
        ("final_heading_deg", "eight poses, final heading", "–"),
    ),
    ("neighbouring", "lemniscate", EKF): (
        ("average_m", "lemniscate, average error", "0.10 m"),
        ("within_m_90_of_time", "lemniscate, 90 % of the time", "0.22 m"),
    ),
    ("neighbouring", "lemniscate", IGNORED): (
        ("average_m", "lemniscate, noise's mean ignored", "assumed zero"),
    ),
    ("neighbouring", "point", EKF): (("final_m", "stabilisation, final error", "practically nil"),),
    ("room", "9 tags", PARTICLE): (("average_m", "room solver, lemniscate, 9 tags", _NOT),),
    ("room", "25 tags", PARTICLE): (("average_m", "room solver, lemniscate, 25 tags", _NOT),),
}
"""By chapter, task and method: measure, its name, and what the thesis says."""


def _both(values: FloatArray) -> str:
    return f"{np.median(values):.3f} / {np.quantile(values, 0.9):.3f}"


def _pair(values: FloatArray) -> str:
    return _both(values) if len(values) > 1 else f"{values[0]:.3f}"


def _published_rows(content: TrackingContent) -> Iterator[tuple[str, str, str, str]]:
    """Yield chapter, name, figure of the thesis, and the one computed here."""
    found = {(o.chapter, o.task, o.method): o for o in content.outcomes}
    for key, rows in _PUBLISHED.items():
        for measure, words, published in rows if key in found else ():
            unit = "°" if measure.endswith("deg") else " m"
            yield key[0], words, published, _pair(found[key].measures()[measure]) + unit


def summary_lines(content: TrackingContent) -> Iterator[str]:
    """Yield lines with the figures of merit: the study's room first, then what a thesis prints too.

    Parameters
    ----------
    content : What was computed; two numbers are the median and the 90 % quantile over the runs.
    """
    study, runs = content.settings.study, content.settings.track.runs
    yield f"Errors in {study.name}, median / 90 % over {runs} run{'' if runs == 1 else 's'}:"
    published_rows = sorted(_published_rows(content), key=lambda row: row[0] != "room")
    for chapter, words, published, text in published_rows:
        there = any(c.isdigit() for c in published)
        line = f"{chapter:<13} {words:<44} {text:<18}"
        yield f"{line} thesis: {published}" if there else line.rstrip()
    for outcome in content.outcomes:
        own = outcome.chapter == "neighbouring" and outcome.task not in RESERVED_NAMES
        key = (outcome.chapter, outcome.task, outcome.method)
        further = outcome.chapter in content.further
        if own or further or (outcome.chapter == "room" and key not in _PUBLISHED):
            words = f"{outcome.task}, {outcome.method}"
            text = _pair(outcome.measures()["average_m"])
            yield f"{outcome.chapter:<13} {words:<44} {text} m"
    if content.fits is not None:
        fit, share = content.fits.exponential, content.fits.noisy_share
        yield (
            f"rss           fit of {_samples(content)}: {fit.alpha_dbm:.2f} dBm, "
            f"{fit.beta_per_m:.4f} 1/m (thesis: -35.5, 0.1071); the printed noisy fit (-60, 0.2) "
            f"is as far away as {100 * share:.1f} % of the fits to noisy records"
        )
    for sigma, record in content.slam:
        error = record.final_error_m
        yield (
            f"slam          wheel noise {sigma:g} rad/s: final {np.median(error):.4f} / "
            f"{np.quantile(error, 0.9):.4f} m, dead reckoning "
            f"{np.median(record.reckoned_error_m):.4f} m, NEES(3) {record.nees.mean():.2f}, "
            f"{int(record.diverged.sum())} of {len(error)} diverged"
        )
    for row in content.costs:
        offline = "–" if row.offline_s is None else f"{row.offline_s:.2f} s"
        yield (
            f"cost          {row.method}: {row.step_us:.0f} µs a control step, {offline} offline, "
            f"{row.claimed}"
        )
    if any(any(c.isdigit() for c in published) for _, _, published, _ in published_rows):
        yield f"thesis: {THESIS}"


def tracking_report(content: TrackingContent, figures: FigureFiles) -> Report:
    """Return the report of a tracking study; numbers carry their units [m, °, s, µs].

    Parameters
    ----------
    content, figures : What was computed; by chapter, title, caption and file of each figure.
    """
    study, track = content.settings.study, content.settings.track
    rows = tuple(_published_rows(content))
    table = ReportTable(
        caption=f"Medians and 90 % quantiles over {track.runs} runs (one of the nominal control, "
        "which has no noise).",
        header=("chapter", "figure", "thesis", "here"),
        rows=rows,
        words=True,
    )
    sections = (
        ReportSection(heading="Against the published figures", tables=(table,) if rows else ()),
        _rss_section(content, figures),
        _feedback_section(content, figures),
        _nominal_section(content, figures),
        _neighbouring_section(content, figures),
        _slam_section(content, figures),
        _room_section(content, figures),
        *_further_sections(content, figures),
        _cost_section(content, figures),
        _study_section(content),
    )
    return Report(
        title=f"{study.name}: trajectory tracking from RSS",
        subtitle="Thesis chapters 6 and 7, recomputed by Octant",
        summary=(
            (
                "Measurement feedback follows its trajectory only when the noise is the same as "
                "in its training. The neighbouring control follows it with any noise, provided "
                "that the mean of the noise is estimated. In a reverberant room the robot finds "
                "its place from the pattern of fades, not from the distance to the tags."
            ),
        ),
        warnings=(),
        facts=(
            ("runs", str(track.runs)),
            ("noise on RSS", f"{track.rss_mean_db:g} dB mean, {track.rss_sigma_db:g} dB deviation"),
            ("noise on wheels", f"{track.wheel_sigma_rad_per_s:g} rad/s"),
        ),
        sections=tuple(s for s in sections if s is not None),
    )


def _outcome_table(outcomes: Sequence[Outcome], caption: str) -> ReportTable:
    header = ("task", "method", "average [m]", "90 % of the time [m]", "final [m]", "final [°]")
    rows = tuple((o.task, o.method, *map(_both, o.measures().values())) for o in outcomes)
    return ReportTable(caption=caption, header=header, rows=rows)


def _samples(content: TrackingContent) -> str:
    return "Table 6.1" if content.settings.samples is None else "the study's file"


def _rss_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    fits = content.fits
    if fits is None:
        return None
    alpha, beta = np.median(fits.noisy, axis=0)
    return ReportSection(
        heading="RSS of a tag (thesis 6.5.1)",
        paragraphs=(
            (
                f"Least squares of (6.2) on the {len(fits.rss_dbm)} samples of "
                f"{_samples(content)} gives "
                f"{fits.exponential.alpha_dbm:.2f} dBm and {fits.exponential.beta_per_m:.4f} 1/m, "
                f"rms {fits.exponential_rms_db:.2f} dB; the printed -35.5 and 0.1071 leave "
                f"{fits.published_rms_db:.2f} dB. The log-distance law leaves "
                f"{fits.distance_rms_db:.2f} dB, with an exponent of {fits.distance.exponent:.1f}; "
                "in free space it is 2."
            ),
            (
                f"Fits to noisy records have the median ({alpha:.0f} dBm, {beta:.3f} 1/m). The "
                "printed (-60, 0.2) lies so far from the mean of the noisy signal that only "
                f"{100 * fits.noisy_share:.1f} % of the records give a fit that is as far "
                "away: it is due "
                "to an unlucky record, not to the signal. Chapters 6 and 7 use it nevertheless, "
                "and so does this study."
            ),
        ),
        figures=embedded_figures(figures, "rss"),
    )


def _feedback_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    if not content.feedback:
        return None
    return ReportSection(
        heading="Measurement feedback (chapter 6)",
        paragraphs=(
            (
                "The gains are trained by the five steps of thesis 6.4 with a unit-free step. The "
                "published figures belong to the noise record of the training; on fresh noise the "
                "same gains do much worse. Gains that were trained over many records do better on "
                "fresh noise, but worse than the published figures."
            ),
        ),
        tables=(_outcome_table(content.feedback, "Median / 90 % over the runs."),),
        figures=embedded_figures(figures, "feedback"),
    )


def _nominal_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    if not content.nominal:
        return None
    solvers = ReportTable(
        caption="Results of the solvers.",
        header=("task", "method", "iterations", "cost J", "average error [m]"),
        rows=tuple(
            (
                run.outcome.task,
                run.outcome.method,
                str(run.solution.iterations),
                f"{run.solution.cost:.4f}",
                f"{np.median(run.outcome.measures()['average_m']):.3f}",
            )
            for run in content.nominal
        ),
    )
    outcomes = [run.outcome for run in content.nominal]
    return ReportSection(
        heading="Nominal optimal control (7.2)",
        tables=(solvers, _outcome_table(outcomes, "Errors; eight runs for the eight poses.")),
        figures=embedded_figures(figures, "nominal"),
    )


def _neighbouring_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    if not content.neighbouring:
        return None
    stability = ReportTable(
        caption="Theorem 7.4 and Lemma 7.3 along each nominal trajectory; all must be positive.",
        header=("task", "decay of V in a period", "observability", "controllability"),
        rows=tuple(
            (task, f"{s.lyapunov_decay:.2e}", f"{s.observability:.2e}", f"{s.controllability:.2e}")
            for task, s in content.stability.items()
        ),
    )
    wheels = ReportTable(
        caption="The thesis prints no wheel noise for 7.5.2; its effect on the lemniscate:",
        header=("wheel noise [rad/s]", "average [m]", "90 % of the time [m]"),
        rows=tuple(
            (
                f"{sigma:g}",
                *(_both(outcome.measures()[m]) for m in ("average_m", "within_m_90_of_time")),
            )
            for sigma, outcome in content.wheel_noise
        ),
    )
    return ReportSection(
        heading="Neighbouring optimal control (7.3)",
        tables=(
            _outcome_table(content.neighbouring, "Median / 90 % over the runs."),
            wheels,
            stability,
        ),
        figures=embedded_figures(figures, "neighbouring"),
    )


def _slam_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    if not content.slam:
        return None
    rows = tuple(
        tuple(f"{v:.4g}" for v in slam_row(sigma, record)) for sigma, record in content.slam
    )
    return ReportSection(
        heading="EKF SLAM (7.4, 7.7)",
        paragraphs=(
            (
                "With the printed sensor noise (1.5 m, 0.9 rad) SLAM is hardly better than dead "
                "reckoning; it is consistent, and it does not fail at ten times the wheel noise."
            ),
        ),
        tables=(
            ReportTable(
                caption="Errors of the place, and NEES(3).", header=SLAM_COLUMNS, rows=rows
            ),
        ),
        figures=embedded_figures(figures, "slam"),
    )


def _room_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    if not content.room:
        return None
    track, study = content.settings.track, content.settings.study
    room = [outcome for runs in content.room for outcome in runs.outcomes]
    frequencies = study.radio.frequencies_hz
    channels = (
        "on one carrier"
        if len(frequencies) == 1
        else f"averaged in power over {len(frequencies)} channels"
    )
    return ReportSection(
        heading="RSS from the room solver",
        paragraphs=(
            (
                f"The field is the coherent sum of paths of up to {study.solver.max_reflections} "
                f"reflections at the robot's true place, {channels}, read every "
                f"{track.room_reading_every_s:g} s with {track.room_noise_db:g} dB of noise."
            ),
            (
                "A law of distance and a map of local means do not help: between concrete walls "
                "the mean level hardly depends on the place. The fades, some centimetres wide, do. "
                "A filter that has the computed map of the fades follows the trajectory until it "
                "mistakes one fade for another. This happens to the unscented filter more often "
                "than to the particle filter; the list below counts the runs. The map comes from "
                "the same solver as the field: in a real room the plan of the room must be right "
                "to a centimetre or two. The wrong map has brick walls, and tags 2 cm off in x "
                "and y."
            ),
        ),
        points=tuple(fact for runs in content.room for fact in runs.facts),
        tables=(_outcome_table(room, "The lemniscate; median / 90 % over the runs."),),
        figures=embedded_figures(figures, "room"),
    )


def _further_sections(content: TrackingContent, figures: FigureFiles) -> Iterator[ReportSection]:
    for name, records in content.further.items():
        chapter = FURTHER[name]
        yield ReportSection(
            heading=chapter.heading,
            paragraphs=chapter.said(content.settings, records),
            warnings=tuple(dict.fromkeys(note for _, one in records for note in one.notes)),
            tables=tuple(
                ReportTable(
                    caption=table.caption,
                    header=table.header,
                    rows=tuple(tuple(map(cell_text, row)) for row in table.rows),
                )
                for table in chapter.tables(content.settings, records)
            ),
            figures=embedded_figures(figures, name),
        )


def cell_text(value: str | float | None) -> str:
    """Return a cell of a table as it stands on the page, numbers with three digits [any].

    Parameters
    ----------
    value : In the unit of its column [any]; None: there is none.
    """
    if value is None:
        return "–"
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def _cost_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    if not content.costs:
        return None
    rows = tuple(
        (
            row.method,
            row.claimed,
            "–" if row.offline_s is None else f"{row.offline_s:.2f}",
            f"{row.step_us:.0f}",
            row.line_m,
            row.lemniscate_m,
            "yes" if row.knows_tags else "no",
            row.architecture,
            row.linearises,
            row.tracks,
            row.stabilises,
            row.point_m,
        )
        for row in content.costs
    )
    return ReportSection(
        heading="Table 8.1, measured",
        paragraphs=(
            (
                "Times were measured on the machine that made this report, one robot at a time. "
                "They differ from run to run and are stored in costs.csv only. With less than some "
                "tens of tags the function calls cost more than the arithmetic, so that the "
                "measured exponents lie below one. With the number N of iterations offline the "
                "training grows in proportion, as claimed; with three to six states n a filter's "
                "step hardly grows, for n² is then a few dozen multiplications."
            ),
        ),
        tables=(
            ReportTable(
                caption="Cost and average error of each controller.",
                header=(
                    "controller",
                    "thesis",
                    "offline [s]",
                    "control step [µs]",
                    "line [m]",
                    "lemniscate [m]",
                    "must know the tags",
                    "RFID architecture",
                    "linearises",
                    "tracks",
                    "holds a point",
                    "point [m]",
                ),
                rows=rows,
                words=True,
            ),
        ),
        figures=embedded_figures(figures, "costs"),
    )


def _study_section(content: TrackingContent) -> ReportSection:
    found = "; ".join(f"{n.removesuffix('_version')} {v}" for n, v in versions().items())
    return ReportSection(
        heading="The study",
        paragraphs=(f"Seed {content.settings.study.seed}; versions: {found}.",),
        folded=(("The study with every default resolved (study.toml)", content.study_toml),),
    )
