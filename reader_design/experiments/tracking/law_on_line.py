"""Alpha and beta fitted while the robot drives, thesis 6.3: the chapter ``law``."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from octant.navigation.estimators.kalman import Gaussian
from octant.navigation.estimators.law_fit import LawFittingKalman
from octant.navigation.estimators.rss_kalman import ExtendedKalman
from octant.navigation.sensing.rss_models import LogExponentialLaw, TagMesh
from octant.reader_design.experiments.tracking.chapters import (
    driven,
    neighbouring_setup,
    thesis_filter,
)
from octant.reader_design.experiments.tracking.parts import (
    ChapterTable,
    FloatArray,
    FurtherChapter,
    Part,
    PartRecord,
    Records,
    middle_and_90,
    rows_of,
)
from octant.reader_design.experiments.tracking.settings import Settings
from octant.reader_design.experiments.tracking.task_figure import COLOURS, WANTED
from octant.reader_design.showing.style import NamedFigure, figure_style, new_figure

KNOWN, FITTED, GUESSED = "law known", "law fitted on line", "first guess kept"
COLUMNS = (
    "trajectory",
    "method",
    "runs",
    "average_m_median",
    "average_m_90",
    "alpha_dbm_median",
    "alpha_dbm_error_90",
    "beta_per_m_median",
    "beta_per_m_error_90",
)
"""Columns of law.csv [m], [dBm], [1/m]; the law at the end of the drive."""


def parts(settings: Settings) -> list[Part]:
    """Return a part for each trajectory and each way to know the law.

    Parameters
    ----------
    settings : The study.
    """
    return [
        Part(chapter="law", task=name, method=method)
        for name in settings.tasks
        for method in (KNOWN, FITTED, GUESSED)
    ]


def compute(settings: Settings, part: Part) -> PartRecord:
    """Return a trajectory driven with one knowledge of the law.

    Parameters
    ----------
    settings, part : The study, and one of its `parts`.
    """
    track, mesh = settings.track, settings.mesh
    guess = LogExponentialLaw(alpha_dbm=track.guess_alpha_dbm, beta_per_m=track.guess_beta_per_m)
    task = settings.tasks[part.task]
    setup = neighbouring_setup(settings, task.curve, task.start, weights=task.weights)
    known = thesis_filter(settings)
    estimator: ExtendedKalman | LawFittingKalman = known
    if part.method == FITTED:
        estimator = LawFittingKalman(
            motion=settings.motion,
            noise=settings.assumptions,
            tags_m=mesh.tags_m,
            guess=guess,
            alpha_sigma_dbm=track.guess_alpha_sigma_dbm,
            beta_sigma_per_m=track.guess_beta_sigma_per_m,
        )
    elif part.method == GUESSED:
        estimator = replace(known, sensor=TagMesh(tags_m=mesh.tags_m, law=guess))
    outcome = driven(
        settings,
        setup,
        part.method,
        setup.control,
        estimator,
        chapter="law",
        watch=_law_of if part.method == FITTED else None,
    )
    laws = outcome.runs.watched
    if laws is None:
        used = settings.law if part.method == KNOWN else guess
        laws = np.array([[[used.alpha_dbm, used.beta_per_m]]])
    true = np.array([settings.law.alpha_dbm, settings.law.beta_per_m])
    middle = np.median(laws[:, -1], axis=0)
    worst = np.quantile(np.abs(laws[:, -1] - true), 0.9, axis=0)
    law_row = (float(middle[0]), float(worst[0]), float(middle[1]), float(worst[1]))
    average = outcome.measures()["average_m"]
    row = (part.task, part.method, len(average), *middle_and_90(average), *law_row)
    return PartRecord(outcomes=(outcome,), rows=(row,))


def _law_of(belief: Gaussian) -> FloatArray:
    return belief.mean[:, 3:5]


def said(settings: Settings, records: Records) -> tuple[str, ...]:
    """Return the sentences on the page.

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    del records
    track, law = settings.track, settings.law
    return (
        (
            "The thesis wants alpha and beta optimised on line by least squares (6.3). Here they "
            "are states of the filter, as the pose is; the robot begins with "
            f"{track.guess_alpha_dbm:g} dBm and {track.guess_beta_per_m:g} 1/m, where the tags "
            f"have {law.alpha_dbm:.4g} dBm and {law.beta_per_m:.4g} 1/m."
        ),
    )


def tables(settings: Settings, records: Records) -> tuple[ChapterTable, ...]:
    """Return the chapter's table.

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    del settings
    caption = "Each trajectory by what is known of the law, and the law at the end of it."
    return (ChapterTable(file="law.csv", caption=caption, header=COLUMNS, rows=rows_of(records)),)


def figures(settings: Settings, records: Records) -> Iterator[NamedFigure]:
    """Yield how alpha and beta come near to the tags' [dBm], [1/m].

    Parameters
    ----------
    settings, records : The study, and what its parts left.
    """
    fitted = next(one.outcomes[0].runs for part, one in records if part.method == FITTED)
    watched = fitted.watched
    if watched is None:
        return
    true = (settings.law.alpha_dbm, settings.law.beta_per_m)
    with figure_style():
        figure, (axes,) = new_figure(
            width_in=10.4,
            height_in=3.8,
            title="The law of the tags' RSS, fitted on line",
            columns=2,
        )
        for i, (ax, name) in enumerate(zip(axes, ("alpha [dBm]", "beta [1/m]"), strict=True)):
            low, middle, high = np.quantile(watched[:, :, i], [0.1, 0.5, 0.9], axis=0)
            time = fitted.desired.time_s
            ax.axhline(true[i], color=WANTED, linewidth=3, alpha=0.6, label="the tags'")
            ax.plot(time, middle, color=COLOURS[0], label="fitted, median of the runs")
            ax.fill_between(
                time, low, high, color=COLOURS[0], alpha=0.2, linewidth=0, label="10 to 90 %"
            )
            ax.set_title(name.split(" ")[0])
            ax.set_xlabel("time [s]")
            ax.set_ylabel(name)
            ax.legend()
    yield NamedFigure(
        file="law.png",
        section="law",
        title="The law fitted on line (thesis 6.3)",
        caption="On the lemniscate alpha and beta are found within the first metres, while the "
        "pose is estimated.",
        figure=figure,
    )


CHAPTER = FurtherChapter(
    heading="The law fitted on line (6.3)",
    parts=parts,
    compute=compute,
    said=said,
    tables=tables,
    figures=figures,
)
