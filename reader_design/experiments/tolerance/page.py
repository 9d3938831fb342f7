"""What a tolerance study says: sentences, tables and a section of a report."""

import numpy as np

from octant.navigation.statistics import Interval
from octant.reader_design.experiments.tolerance.ranking import confidence_sentence
from octant.reader_design.experiments.tolerance.study import (
    PLACE_RESAMPLES,
    BuiltDesign,
    ToleranceStudy,
)
from octant.reader_design.experiments.tolerance.views import limit_texts
from octant.reader_design.showing.numbers import rounded, with_doubt, with_interval
from octant.reader_design.showing.pages import ReportFigure, ReportSection, ReportTable

LOW_R_SQUARED = 0.5
"""R² for new samples below which shares of variance are called a hint only [-]."""


def summary_sentences(result: ToleranceStudy) -> tuple[str, ...]:
    """Return the result in words: what was drawn, the yield, the confidence ([mm], [deg], [%]).

    Parameters
    ----------
    result : The study.
    """
    chosen, tolerance = result.chosen, result.tolerance
    how = "within plus and minus" if tolerance.distribution == "uniform" else "with deviations of"
    drawn = (
        f"{len(chosen.samples)} readers of {chosen.design.label()} were built {how} "
        f"{1e3 * tolerance.position_m:g} mm and {tolerance.angle_deg:g}°."
    )
    limits = limit_texts(tolerance.limits)
    yields = (_yield_sentence(one, limits) for one in (chosen, *result.rivals))
    sentences = [drawn, *yields]
    for rival, confidence in zip(result.rivals, result.confidence, strict=True):
        sentences.append(
            confidence_sentence(
                confidence, better=chosen.name, worse=rival.name, samples=len(chosen.samples)
            )
        )
    if result.confidence_places:
        for rival, confidence in zip(result.rivals, result.confidence_places, strict=True):
            sentences.append(
                confidence_sentence(
                    confidence,
                    better=chosen.name,
                    worse=rival.name,
                    samples=PLACE_RESAMPLES,
                    over="draws of places of the room, readers as drawn",
                )
            )
    return tuple(sentences)


def _yield_sentence(one: BuiltDesign, limits: tuple[str, ...]) -> str:
    if not limits:
        return f"No limits are given for {one.name}; every reader that can be built is good."
    good = one.good
    text = (
        f"{round(100 * good.value)} % ({round(100 * good.low)} to {round(100 * good.high)}) of "
        f"the readers of {one.name} reach {' and '.join(limits)}"
    )
    if not one.drawn_is_good:
        text += (
            "; the drawing itself does not, so that this is no yield: give it limits that the "
            "drawing keeps, in [tolerance.limits]"
        )
    if one.not_built:
        text += f"; {one.not_built} of {len(one.samples)} cannot be built, and count as bad"
    return text + "."


def tolerance_section(
    result: ToleranceStudy, figures: tuple[ReportFigure, ...] = ()
) -> ReportSection:
    """Return the section of a report on tolerances.

    Parameters
    ----------
    result, figures : The study and its figures.
    """
    return ReportSection(
        heading="As built",
        paragraphs=summary_sentences(result),
        warnings=_doubts(result),
        tables=(*_spread_tables(result), _slope_table(result), *_linear_tables(result)),
        figures=figures,
    )


def _doubts(result: ToleranceStudy) -> tuple[str, ...]:
    """Return what limits the numbers."""
    out = []
    count = len(result.chosen.samples)
    if count < 60:
        out.append(
            f"With {count} samples the 5 % and 95 % values are near the worst and the best reader "
            "seen; some 60 or more tell them apart."
        )
    weak = [
        view.title
        for view, explained in zip(result.shown, result.explained, strict=True)
        if explained is not None and explained.r_squared_new < LOW_R_SQUARED
    ]
    if weak:
        out.append(
            "Shares of variance are a hint only, as sums of single errors do not predict it "
            f"(R² for new readers below {LOW_R_SQUARED:g}), for: {', '.join(weak)}."
        )
    if any(explained is None for explained in result.explained):
        out.append(
            "Scores without shares of variance did not vary, or there were fewer samples than "
            "kinds of error."
        )
    bent = sorted({s.score for s in result.slopes if s.bends})
    if bent:
        titles = [view.title for view in result.shown if view.name in bent]
        out.append(
            "These scores bend at the drawing, as the worst of several directions does, and have "
            f"no gradient there, but one slope for more and one for less: {', '.join(titles)}."
        )
    return tuple(out)


def _cell(interval: Interval, unit: str) -> str:
    return with_interval(interval.value, low=interval.low, high=interval.high, unit=unit)


def _spread_tables(result: ToleranceStudy) -> tuple[ReportTable, ...]:
    tables = []
    for one in (result.chosen, *result.rivals):
        rows = tuple(
            (
                view.label(),
                rounded(view.of(one.nominal), view.unit),
                *(_cell(interval, view.unit) for interval in spread),
            )
            for view, spread in zip(result.shown, one.spreads, strict=True)
        )
        tables.append(
            ReportTable(
                caption=f"Scores of {one.name}, as drawn and over {len(one.samples)} built "
                "readers; in brackets 95 % confidence intervals.",
                header=("score", "as drawn", "median", "5 %", "95 %"),
                rows=rows,
            )
        )
    return tuple(tables)


def _linear_tables(result: ToleranceStudy) -> tuple[ReportTable, ...]:
    """Return the linear estimate beside the readers that were built; nothing without one."""
    if result.linear is None:
        return ()
    values = result.chosen.values[~np.isnan(result.chosen.values).any(axis=1)]
    rows = []
    for view, linear, built in zip(result.shown, result.linear.T, values.T, strict=True):
        if np.isnan(linear).any():
            continue
        unit = view.change_unit
        ends = (np.quantile(some, (0.05, 0.95)) for some in (linear, built))
        rows.append(
            (
                view.label(),
                *(rounded(float(some.std()), unit) for some in (linear, built)),
                *(" to ".join(rounded(float(end), view.unit) for end in pair) for pair in ends),
            )
        )
    table = ReportTable(
        caption=f"Spread of {len(result.linear)} readers whose ports are linear in their errors, "
        f"from one solution, beside {len(values)} that were built: standard deviation, and 5 % to "
        "95 %.",
        header=("score", "deviation, linear", "built", "5 % to 95 %, linear", "built"),
        rows=tuple(rows),
    )
    return (table,)


def _slope_table(result: ToleranceStudy) -> ReportTable:
    names = list(dict.fromkeys(s.parameter for s in result.slopes))
    views = [view for view in result.shown if any(s.score == view.name for s in result.slopes)]
    found = {(s.parameter, s.score): s for s in result.slopes}
    rows = []
    for name in names:
        mine = [found[name, view.name] for view in views]
        per = mine[0].unit.rsplit("/", 1)[1]
        cells = (
            f"{s.down:+.2f} / {s.up:+.2f}" if s.bends else with_doubt(s.central, s.doubt)
            for s in mine
        )
        rows.append((f"{name} [per {per}]", *cells))
    return ReportTable(
        caption=f"Slopes around the drawing by {result.tolerance.slopes}, for errors that all "
        "antennas or plates share: central difference ± its change with half the step, or less / "
        "more where the score bends.",
        header=("parameter", *(f"{view.title} [{view.change_unit}]" for view in views)),
        rows=tuple(rows),
    )
