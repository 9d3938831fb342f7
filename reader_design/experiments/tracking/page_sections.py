"""The sections of a tracking study's report, chapter by chapter."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from octant.reader_design.experiments.tracking.outcomes import Outcome
from octant.reader_design.experiments.tracking.results import SLAM_COLUMNS, slam_row, solver_rows
from octant.reader_design.experiments.tracking.run import TrackingContent
from octant.reader_design.keeping.versions import versions
from octant.reader_design.showing.pages import ReportSection, ReportTable, embedded_figures

FigureFiles = Mapping[str, Sequence[tuple[str, str, Path]]]


def _outcome_table(outcomes: Sequence[Outcome], caption: str) -> ReportTable:
    header = ("task", "method", "average [m]", "90 % of the time [m]", "final [m]", "final [°]")
    rows = []
    for outcome in outcomes:
        cells = [
            f"{np.median(v):.3f} / {np.quantile(v, 0.9):.3f}" for v in outcome.measures().values()
        ]
        rows.append((outcome.task, outcome.method, *cells))
    return ReportTable(caption=caption, header=header, rows=tuple(rows))


def rss_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    """Return the section on the fits of Table 6.1; numbers carry their units [m, dB, °, s, -].

    Parameters
    ----------
    content : TrackingContent
        What was computed.
    figures : mapping of str to sequence of (str, str, Path)
        By chapter: title, caption and file of each figure.
    """
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


def feedback_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    """Return the section on chapter 6; numbers carry their units [m, dB, °, s, -].

    Parameters
    ----------
    content : TrackingContent
        What was computed.
    figures : mapping of str to sequence of (str, str, Path)
        By chapter: title, caption and file of each figure.
    """
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


def nominal_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    """Return the section on thesis 7.2; numbers carry their units [m, dB, °, s, -].

    Parameters
    ----------
    content : TrackingContent
        What was computed.
    figures : mapping of str to sequence of (str, str, Path)
        By chapter: title, caption and file of each figure.
    """
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


def neighbouring_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    """Return the section on thesis 7.3; numbers carry their units [m, dB, °, s, -].

    Parameters
    ----------
    content : TrackingContent
        What was computed.
    figures : mapping of str to sequence of (str, str, Path)
        By chapter: title, caption and file of each figure.
    """
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


def slam_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    """Return the section on thesis 7.4; numbers carry their units [m, dB, °, s, -].

    Parameters
    ----------
    content : TrackingContent
        What was computed.
    figures : mapping of str to sequence of (str, str, Path)
        By chapter: title, caption and file of each figure.
    """
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


def room_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    """Return the section on RSS from the room solver; numbers carry their units [m, dB, °, s, -].

    Parameters
    ----------
    content : TrackingContent
        What was computed.
    figures : mapping of str to sequence of (str, str, Path)
        By chapter: title, caption and file of each figure.
    """
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
                "centimetres wide. A filter that carries the computed map of them keeps the way, "
                "as long as it does not take one fade for another, which the unscented filter does "
                "more often than the particle filter; the list below counts the runs. The map is "
                "the solver's own: in a real room its plan must be right to a centimetre or two. "
                "The wrong map has brick walls, and tags 2 cm off in x and y."
            ),
        ),
        points=room.facts,
        tables=(_outcome_table(room.outcomes, "The lemniscate; median / 90 % over the runs."),),
        figures=embedded_figures(figures, "room"),
    )


def cost_section(content: TrackingContent, figures: FigureFiles) -> ReportSection | None:
    """Return the section on Table 8.1; numbers carry their units [m, dB, °, s, -].

    Parameters
    ----------
    content : TrackingContent
        What was computed.
    figures : mapping of str to sequence of (str, str, Path)
        By chapter: title, caption and file of each figure.
    """
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


def study_section(content: TrackingContent) -> ReportSection:
    """Return the section on the study itself; numbers carry their units [m, dB, °, s, -].

    Parameters
    ----------
    content : TrackingContent
        What was computed.
    """
    found = "; ".join(f"{n.removesuffix('_version')} {v}" for n, v in versions().items())
    return ReportSection(
        heading="The study",
        paragraphs=(f"Seed {content.settings.study.seed}; versions: {found}.",),
        folded=(("The study with every default resolved (study.toml)", content.study_toml),),
    )
