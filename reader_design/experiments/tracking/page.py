"""What a tracking study's report says: figures and numbers beside those of the thesis."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from octant.reader_design.experiments.tracking.chapter6 import FRESH, MANY, REPLAY
from octant.reader_design.experiments.tracking.chapter7 import EKF, IGNORED, ILQR
from octant.reader_design.experiments.tracking.page_sections import (
    FigureFiles,
    cost_section,
    feedback_section,
    neighbouring_section,
    nominal_section,
    room_section,
    rss_section,
    slam_section,
    study_section,
)
from octant.reader_design.experiments.tracking.room import PARTICLE
from octant.reader_design.experiments.tracking.run import TrackingContent
from octant.reader_design.experiments.tracking.settings import RESERVED_NAMES
from octant.reader_design.showing.pages import Report, ReportSection, ReportTable


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
    """
    for figure, text in _found(content):
        yield f"{figure.chapter:<13} {figure.words:<44} {text:<18} thesis: {figure.published}"
    named = {(f.chapter, f.task, f.method) for f in _FIGURES}
    for outcome in content.outcomes:
        own = outcome.chapter == "neighbouring" and outcome.task not in RESERVED_NAMES
        key = (outcome.chapter, outcome.task, outcome.method)
        if own or (outcome.chapter == "room" and key not in named):
            average = outcome.measures()["average_m"]
            words = f"{outcome.task}, {outcome.method}"
            text = f"{np.median(average):.3f} / {np.quantile(average, 0.9):.3f} m"
            yield f"{outcome.chapter:<13} {words:<44} {text}"
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
        rss_section(content, figures),
        feedback_section(content, figures),
        nominal_section(content, figures),
        neighbouring_section(content, figures),
        slam_section(content, figures),
        room_section(content, figures),
        cost_section(content, figures),
        study_section(content),
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
