"""What a tracking study's report says: figures and numbers beside those of the thesis."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from octant.reader_design.report.html import Report, ReportSection, ReportTable, embedded_figures
from octant.reader_design.store import versions
from octant.reader_design.tracking.chapter6 import FRESH, MANY, REPLAY
from octant.reader_design.tracking.chapter7 import EKF, IGNORED, ILQR
from octant.reader_design.tracking.outcomes import Outcome
from octant.reader_design.tracking.results import SLAM_COLUMNS, slam_row, solver_rows
from octant.reader_design.tracking.room import PARTICLE
from octant.reader_design.tracking.run import TrackingContent

FigureFiles = Mapping[str, Sequence[tuple[str, str, Path]]]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Figure:
    """A published figure: where it stands, what it is, what the thesis says, what to look up."""

    chapter: str
    task: str
    method: str
    measure: str
    words: str
    published: str


_FIGURES = (
    _Figure(
        chapter="feedback",
        task="line",
        method=REPLAY,
        measure="average_m",
        words="line, average error, replayed noise",
        published="0.07 m",
    ),
    _Figure(
        chapter="feedback",
        task="line",
        method=FRESH,
        measure="average_m",
        words="line, average error, fresh noise",
        published="not told apart",
    ),
    _Figure(
        chapter="feedback",
        task="line",
        method=MANY,
        measure="average_m",
        words="line, trained over many records",
        published="not done",
    ),
    _Figure(
        chapter="feedback",
        task="sine",
        method=REPLAY,
        measure="average_m",
        words="sine, average error, replayed noise",
        published="0.08 m",
    ),
    _Figure(
        chapter="feedback",
        task="sine",
        method=FRESH,
        measure="average_m",
        words="sine, average error, fresh noise",
        published="not told apart",
    ),
    _Figure(
        chapter="feedback",
        task="sine",
        method=MANY,
        measure="average_m",
        words="sine, trained over many records",
        published="not done",
    ),
    _Figure(
        chapter="nominal",
        task="ellipse",
        method=ILQR,
        measure="average_m",
        words="ellipse, average error",
        published="0.07 m",
    ),
    _Figure(
        chapter="nominal",
        task="parabola",
        method=ILQR,
        measure="average_m",
        words="parabola, average error (start not printed)",
        published="0.18 m",
    ),
    _Figure(
        chapter="nominal",
        task="sigmoid",
        method=ILQR,
        measure="average_m",
        words="sigmoid, average error",
        published="0.09 m",
    ),
    _Figure(
        chapter="nominal",
        task="point",
        method=ILQR,
        measure="final_m",
        words="point, final error",
        published="0.02 m",
    ),
    _Figure(
        chapter="nominal",
        task="point",
        method=ILQR,
        measure="final_heading_deg",
        words="point, final heading",
        published="–",
    ),
    _Figure(
        chapter="nominal",
        task="eight poses",
        method=ILQR,
        measure="final_m",
        words="eight poses, final error",
        published="–",
    ),
    _Figure(
        chapter="nominal",
        task="eight poses",
        method=ILQR,
        measure="final_heading_deg",
        words="eight poses, final heading",
        published="–",
    ),
    _Figure(
        chapter="neighbouring",
        task="lemniscate",
        method=EKF,
        measure="average_m",
        words="lemniscate, average error",
        published="0.10 m",
    ),
    _Figure(
        chapter="neighbouring",
        task="lemniscate",
        method=EKF,
        measure="within_m_90_of_time",
        words="lemniscate, 90 % of the time",
        published="0.22 m",
    ),
    _Figure(
        chapter="neighbouring",
        task="lemniscate",
        method=IGNORED,
        measure="average_m",
        words="lemniscate, noise's mean ignored",
        published="assumed zero",
    ),
    _Figure(
        chapter="neighbouring",
        task="point",
        method=EKF,
        measure="final_m",
        words="stabilisation, final error",
        published="practically nil",
    ),
    _Figure(
        chapter="room",
        task="9 tags",
        method=PARTICLE,
        measure="average_m",
        words="room solver, lemniscate, 9 tags",
        published="not in the thesis",
    ),
    _Figure(
        chapter="room",
        task="25 tags",
        method=PARTICLE,
        measure="average_m",
        words="room solver, lemniscate, 25 tags",
        published="not in the thesis",
    ),
)


def _found(content: TrackingContent) -> Iterator[tuple[_Figure, str]]:
    for figure in _FIGURES:
        for outcome in content.outcomes:
            key = (outcome.chapter, outcome.task, outcome.method)
            if key == (figure.chapter, figure.task, figure.method):
                values = outcome.measures()[figure.measure]
                unit = "°" if figure.measure.endswith("deg") else " m"
                text = f"{np.median(values):.3f}"
                if len(values) > 1:
                    text += f" / {np.quantile(values, 0.9):.3f}"
                yield figure, text + unit


def summary_lines(content: TrackingContent) -> Iterator[str]:
    """Yield lines with the figures of merit, beside what the thesis prints [m, °].

    Parameters
    ----------
    content : TrackingContent
        What was computed.

    Yields
    ------
    str
        One line each; two numbers are the median and the 90 % quantile over the runs.
    """
    for figure, text in _found(content):
        yield f"{figure.chapter:<13} {figure.words:<44} {text:<18} thesis: {figure.published}"
    if content.fits is not None:
        fit, published = content.fits.exponential, content.fits.noisy_share
        yield (
            f"rss           fit of Table 6.1: {fit.alpha_dbm:.2f} dBm, {fit.beta_per_m:.4f} 1/m "
            "(thesis: -35.5, 0.1071); the printed noisy fit (-60, 0.2) is as far out as "
            f"{published:.1%} of the noisy records"
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


def tracking_report(content: TrackingContent, figures: FigureFiles) -> Report:
    """Return the report of a tracking study; numbers carry their units [m, °, s, µs].

    Parameters
    ----------
    content : TrackingContent
        What was computed.
    figures : mapping of str to sequence of (str, str, Path)
        By chapter: title, caption and file of each figure.

    Returns
    -------
    Report
        Ready to be rendered.
    """
    study, track = content.settings.study, content.settings.track
    rows = tuple((f.chapter, f.words, f.published, text) for f, text in _found(content))
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
        _cost_section(content, figures),
        _study_section(content),
    )
    return Report(
        title=f"{study.name}: trajectory tracking from RSS",
        subtitle="Thesis chapters 6 and 7, recomputed by Octant",
        summary=(
            (
                "Measurement feedback follows its way only when the noise that it was trained on "
                "comes again; the neighbouring control does so with any noise, once the noise's "
                "mean is estimated; and in a reverberant room it is the pattern of fades, not the "
                "distance to the tags, that tells the robot where it is."
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
    rows = []
    for outcome in outcomes:
        cells = [
            f"{np.median(v):.3f} / {np.quantile(v, 0.9):.3f}" for v in outcome.measures().values()
        ]
        rows.append((outcome.task, outcome.method, *cells))
    return ReportTable(caption=caption, header=header, rows=tuple(rows))


def _rss_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    fits = content.fits
    if fits is None:
        return None
    alpha, beta = np.median(fits.noisy, axis=0)
    return ReportSection(
        heading="RSS of a tag (thesis 6.5.1)",
        paragraphs=(
            (
                "Least squares of (6.2) on the seven samples of Table 6.1 gives "
                f"{fits.exponential.alpha_dbm:.2f} dBm and {fits.exponential.beta_per_m:.4f} 1/m, "
                f"rms {fits.exponential_rms_db:.2f} dB; the printed -35.5 and 0.1071 leave "
                f"{fits.published_rms_db:.2f} dB. The log-distance law fits better, "
                f"{fits.distance_rms_db:.2f} dB, but with an exponent of "
                f"{fits.distance.exponent:.1f}, far from free space."
            ),
            (
                f"Fits to noisy records have the median ({alpha:.0f} dBm, {beta:.3f} 1/m). The "
                "printed (-60, 0.2) lies so far from the mean of the noisy signal that only "
                f"{fits.noisy_share:.1%} of the records give a fit that is as far out: an unlucky "
                "record, not the signal. Chapters 6 and 7 use it all the same, and so does this "
                "study."
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
                "same gains do much worse. Trained over many records they do better there, and "
                "worse than the published figures."
            ),
        ),
        tables=(_outcome_table(content.feedback, "Median / 90 % over the runs."),),
        figures=embedded_figures(figures, "feedback"),
    )


def _nominal_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    if not content.nominal:
        return None
    solvers = ReportTable(
        caption="What the solvers reached.",
        header=("task", "method", "iterations", "cost J", "average error [m]"),
        rows=tuple(
            (str(task), str(method), str(count), f"{cost:.4f}", f"{error:.3f}")
            for task, method, count, cost, error in solver_rows(content.nominal)
        ),
    )
    outcomes = [run.outcome for run in content.nominal]
    return ReportSection(
        heading="Nominal optimal control (7.2)",
        tables=(solvers, _outcome_table(outcomes, "Errors; eight runs for the eight poses.")),
        figures=embedded_figures(figures, "nominal"),
    )


def _neighbouring_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    results = content.neighbouring
    if results is None:
        return None
    stability = ReportTable(
        caption="Theorem 7.4 and Lemma 7.3 along each nominal trajectory, all to be positive.",
        header=("task", "decay of V in a period", "observability", "controllability"),
        rows=tuple(
            (task, f"{s.lyapunov_decay:.2e}", f"{s.observability:.2e}", f"{s.controllability:.2e}")
            for task, s in results.stability.items()
        ),
    )
    wheels = ReportTable(
        caption="The thesis prints no wheel noise for 7.5.2; what it does to the lemniscate:",
        header=("wheel noise [rad/s]", "average [m]", "90 % of the time [m]"),
        rows=tuple(
            (
                f"{sigma:g}",
                *(
                    f"{np.median(v):.3f} / {np.quantile(v, 0.9):.3f}"
                    for v in (
                        outcome.measures()["average_m"],
                        outcome.measures()["within_m_90_of_time"],
                    )
                ),
            )
            for sigma, outcome in results.wheel_noise
        ),
    )
    return ReportSection(
        heading="Neighbouring optimal control (7.3)",
        tables=(
            _outcome_table(results.outcomes, "Median / 90 % over the runs."),
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
    room = content.room
    if room is None:
        return None
    track, study = content.settings.track, content.settings.study
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
                "the mean level hardly depends on the place. What does are the fades, some "
                "centimetres wide. A filter that carries the computed map of them keeps the way; "
                "the particle filter does so from any start, the unscented one sometimes follows "
                "a wrong fade. That map is as good as the room's plan: one with brick walls and "
                "tags 2 cm off is worse."
            ),
        ),
        points=room.facts,
        tables=(_outcome_table(room.outcomes, "The lemniscate; median / 90 % over the runs."),),
        figures=embedded_figures(figures, "room"),
    )


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
        )
        for row in content.costs
    )
    return ReportSection(
        heading="Table 8.1, measured",
        paragraphs=(
            (
                "Times are those of this machine, one robot at a time; they differ from run to "
                "run and stand in costs.csv only. Below some tens of tags the calls cost more than "
                "the arithmetic, so that the measured exponents lie below one."
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
