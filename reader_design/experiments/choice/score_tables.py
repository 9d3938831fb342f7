"""Tables of the report: what the ranking compares, and every score of every design."""

import math
from collections.abc import Sequence

from octant.reader_design.setting.ranking import Candidate, Choice
from octant.reader_design.setting.reasons import (
    criterion_name,
    score_text,
)
from octant.reader_design.showing.pages import ReportTable
from octant.reader_design.study_file.scores import Scores

DEGREE = math.degrees(1.0)

SCORE_COLUMNS: tuple[tuple[str, str, float, str], ...] = (
    ("right_share", "right antenna [%]", 100.0, "{:.1f}"),
    ("strongest_median_rad", "strongest: median [°]", DEGREE, "{:.1f}"),
    ("strongest_mean_rad", "mean [°]", DEGREE, "{:.1f}"),
    ("strongest_rms_rad", "rms [°]", DEGREE, "{:.1f}"),
    ("strongest_p90_rad", "90 % [°]", DEGREE, "{:.1f}"),
    ("strongest_max_rad", "max [°]", DEGREE, "{:.0f}"),
    ("strongest_beyond_45_share", "beyond 45° [%]", 100.0, "{:.1f}"),
    ("strongest_beyond_90_share", "beyond 90° [%]", 100.0, "{:.1f}"),
    ("vector_median_rad", "vector sum: median [°]", DEGREE, "{:.1f}"),
    ("vector_mean_rad", "mean [°]", DEGREE, "{:.1f}"),
    ("vector_rms_rad", "rms [°]", DEGREE, "{:.1f}"),
    ("vector_p90_rad", "90 % [°]", DEGREE, "{:.1f}"),
    ("vector_max_rad", "max [°]", DEGREE, "{:.0f}"),
    ("vector_beyond_45_share", "beyond 45° [%]", 100.0, "{:.1f}"),
    ("vector_beyond_90_share", "beyond 90° [%]", 100.0, "{:.1f}"),
    ("front_to_back_mean_db", "front-to-back: mean [dB]", 1.0, "{:.1f}"),
    ("front_to_back_worst_db", "worst [dB]", 1.0, "{:.1f}"),
    ("margin_mean_db", "margin: mean [dB]", 1.0, "{:+.1f}"),
    ("margin_worst_db", "worst [dB]", 1.0, "{:+.1f}"),
    ("monotonic_share", "z2 − z4 monotonic [%]", 100.0, "{:.0f}"),
    ("monotonic_normalised_share", "normalised [%]", 100.0, "{:.0f}"),
    ("slope_w_per_rad", "slope [nW/°]", 1e9 / DEGREE, "{:.3g}"),
    ("slope_normalised_per_rad", "normalised [1/rad]", 1.0, "{:.2f}"),
    ("full_scale_w", "full scale [nW]", 1e9, "{:.3g}"),
    ("full_scale_normalised", "normalised [-]", 1.0, "{:.2f}"),
    ("usable_share", "usable [%]", 100.0, "{:.1f}"),
    ("level_median_dbm", "level: median [dBm]", 1.0, "{:.1f}"),
    ("level_p10_dbm", "10 % [dBm]", 1.0, "{:.1f}"),
    ("captured_share", "captured [%]", 100.0, "{:.1f}"),
    ("read_right_share", "as read: right antenna [%]", 100.0, "{:.1f}"),
    ("read_strongest_rms_rad", "strongest rms [°]", DEGREE, "{:.1f}"),
    ("read_vector_median_rad", "vector sum: median [°]", DEGREE, "{:.1f}"),
    ("read_vector_rms_rad", "rms [°]", DEGREE, "{:.1f}"),
    ("read_vector_p90_rad", "90 % [°]", DEGREE, "{:.1f}"),
    ("read_vector_beyond_90_share", "beyond 90° [%]", 100.0, "{:.1f}"),
)

SCORE_MEANINGS = (
    (
        "right antenna: share of directions for which the strongest antenna is the nearest in "
        "angle; half-way between two antennas either counts."
    ),
    (
        "strongest, vector sum: error of the bearing that is read off the strongest antenna, or "
        "off the RSS-weighted vector sum of all antennas; no bearing at all counts as 180°."
    ),
    (
        "front-to-back, margin: RSS of the antenna that faces the tag over the opposite one, and "
        "over the stronger of its two neighbours."
    ),
    (
        "z2 − z4: the navigator's steering signal within one antenna spacing of the front: at what "
        "share of distances or places it grows all the way, its slope straight ahead and its full "
        "scale (medians), in watts and normalised by z2 + z4."
    ),
    (
        "beyond 45°, beyond 90°: share of places and headings at which that bearing errs by more; "
        "beyond 90° it sends the robot away from the tag."
    ),
    "usable, level: share of samples above the threshold, and the strongest antenna's RSS.",
    (
        "captured: share of places at which a single path with bends brings more power than the "
        "direct ray to the antenna that faces the tag."
    ),
    "as read: the same of readings with the receiver's noise, error and codes ([scoring]).",
)


def merit_table(candidates: Sequence[Candidate], choice: Choice) -> ReportTable:
    """Return the numbers that the ranking compares, best first ([%], [deg], [dB], [dBm]).

    Parameters
    ----------
    candidates, choice : Scored designs and their ranking.
    """
    rows = []
    for rank, index in enumerate(choice.ranking):
        m = choice.merits[index]
        rows.append(
            (
                f"{rank + 1}. {candidates[index].label}",
                f"{m.usable_share:.1%}",
                *(
                    score_text(c.free or c.room, value)
                    for c, value in zip(choice.rules.criteria, m.values, strict=True)
                ),
                "yes" if choice.pareto[index] else "no",
            )
        )
    return ReportTable(
        caption="What the ranking compares, in the order in which it counts.",
        header=(
            "design",
            "usable",
            *(criterion_name(c) for c in choice.rules.criteria),
            "on the Pareto front",
        ),
        rows=tuple(rows),
        best=0,
    )


def score_table(
    candidates: Sequence[Candidate], choice: Choice, place: str, *, caption: str
) -> ReportTable | None:
    """Return all scores in a surrounding, best first ([%], [deg], [dB], [nW]); None: no scores.

    Parameters
    ----------
    candidates, choice : Scored designs and their ranking.
    place, caption : ``free`` or ``room``; text above the table.
    """
    rows = []
    for rank, index in enumerate(choice.ranking):
        scores: Scores | None = getattr(candidates[index], place)
        if scores is None:
            return None
        label = f"{rank + 1}. {candidates[index].label}" + (" *" if choice.pareto[index] else "")
        cells = (f.format(scale * getattr(scores, n)) for n, _, scale, f in SCORE_COLUMNS)
        rows.append((label, *cells))
    header = ("design", *(heading for _, heading, _, _ in SCORE_COLUMNS))
    return ReportTable(caption=caption, header=header, rows=tuple(rows), best=0)
