"""All designs side by side in a report: every score as a column, those that matter most first."""

import math
from collections.abc import Mapping, Sequence

from octant.reader_design.setting.ranking import Candidate, Choice
from octant.reader_design.setting.reasons import (
    criterion_name,
    score_text,
)
from octant.reader_design.showing.designs_view import Column

DEGREE = math.degrees(1.0)

SCORE_COLUMNS: tuple[tuple[str, str, float, str], ...] = (
    ("right_share", "right antenna [%]", 100.0, "{:.1f}"),
    ("strongest_median_rad", "strongest antenna: median [°]", DEGREE, "{:.1f}"),
    ("strongest_mean_rad", "strongest antenna: mean [°]", DEGREE, "{:.1f}"),
    ("strongest_rms_rad", "strongest antenna: rms [°]", DEGREE, "{:.1f}"),
    ("strongest_p90_rad", "strongest antenna: 90 % [°]", DEGREE, "{:.1f}"),
    ("strongest_max_rad", "strongest antenna: max [°]", DEGREE, "{:.0f}"),
    ("strongest_beyond_45_share", "strongest antenna: beyond 45° [%]", 100.0, "{:.1f}"),
    ("strongest_beyond_90_share", "strongest antenna: beyond 90° [%]", 100.0, "{:.1f}"),
    ("vector_median_rad", "vector sum: median [°]", DEGREE, "{:.1f}"),
    ("vector_mean_rad", "vector sum: mean [°]", DEGREE, "{:.1f}"),
    ("vector_rms_rad", "vector sum: rms [°]", DEGREE, "{:.1f}"),
    ("vector_p90_rad", "vector sum: 90 % [°]", DEGREE, "{:.1f}"),
    ("vector_max_rad", "vector sum: max [°]", DEGREE, "{:.0f}"),
    ("vector_beyond_45_share", "vector sum: beyond 45° [%]", 100.0, "{:.1f}"),
    ("vector_beyond_90_share", "vector sum: beyond 90° [%]", 100.0, "{:.1f}"),
    ("front_to_back_mean_db", "front-to-back: mean [dB]", 1.0, "{:.1f}"),
    ("front_to_back_worst_db", "front-to-back: worst [dB]", 1.0, "{:.1f}"),
    ("margin_mean_db", "margin: mean [dB]", 1.0, "{:+.1f}"),
    ("margin_worst_db", "margin: worst [dB]", 1.0, "{:+.1f}"),
    ("monotonic_share", "z2 − z4 monotonic [%]", 100.0, "{:.0f}"),
    ("monotonic_normalised_share", "z2 − z4 monotonic, normalised [%]", 100.0, "{:.0f}"),
    ("slope_w_per_rad", "z2 − z4: slope [nW/°]", 1e9 / DEGREE, "{:.3g}"),
    ("slope_normalised_per_rad", "z2 − z4: slope, normalised [1/rad]", 1.0, "{:.2f}"),
    ("full_scale_w", "z2 − z4: full scale [nW]", 1e9, "{:.3g}"),
    ("full_scale_normalised", "z2 − z4: full scale, normalised [-]", 1.0, "{:.2f}"),
    ("usable_share", "usable [%]", 100.0, "{:.1f}"),
    ("level_median_dbm", "level: median [dBm]", 1.0, "{:.1f}"),
    ("level_p10_dbm", "level: 10 % [dBm]", 1.0, "{:.1f}"),
    ("captured_share", "captured by a reflection [%]", 100.0, "{:.1f}"),
    ("read_right_share", "as read: right antenna [%]", 100.0, "{:.1f}"),
    ("read_strongest_rms_rad", "as read: strongest antenna rms [°]", DEGREE, "{:.1f}"),
    ("read_vector_median_rad", "as read: vector sum median [°]", DEGREE, "{:.1f}"),
    ("read_vector_rms_rad", "as read: vector sum rms [°]", DEGREE, "{:.1f}"),
    ("read_vector_p90_rad", "as read: vector sum 90 % [°]", DEGREE, "{:.1f}"),
    ("read_vector_beyond_90_share", "as read: vector sum beyond 90° [%]", 100.0, "{:.1f}"),
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
        "captured by a reflection: share of places at which a single path with bends brings "
        "more power than the "
        "direct ray to the antenna that faces the tag."
    ),
    "as read: the same of readings with the receiver's noise, error and codes ([scoring]).",
)


FIRST = ("right_share", "vector_rms_rad", "vector_beyond_90_share")
"""Scores that the table of designs shows at first."""


def design_columns(
    candidates: Sequence[Candidate], choice: Choice, driven: Mapping[str, Sequence[str]]
) -> tuple[Column, ...]:
    """Return all qualities of the designs, best design first; those that matter most come first.

    Parameters
    ----------
    candidates, choice : Scored designs and their ranking.
    driven : By heading: how the missions of each candidate went, in a few words.
    """
    ranked = [candidates[index] for index in choice.ranking]
    in_room = ranked[0].room is not None
    places = (("room", "in the room"), ("free", "in free space")) if in_room else (("free", ""),)
    first: list[Column] = []
    rest: list[Column] = []
    for place, where in places:
        for name, heading, scale, form in SCORE_COLUMNS:
            values = tuple(scale * float(getattr(getattr(c, place), name)) for c in ranked)
            known = tuple(v if math.isfinite(v) else None for v in values)
            column = Column(
                heading=f"{heading}, {where}" if where else heading,
                texts=tuple("–" if v is None else form.format(v) for v in known),
                values=tuple(math.nan if v is None else v for v in known),
            )
            (first if place == places[0][0] and name in FIRST else rest).append(column)
    missions = [
        Column(heading=heading, texts=tuple(texts[index] for index in choice.ranking))
        for heading, texts in driven.items()
    ]
    sizes = Column(
        heading="width [cm]",
        texts=tuple(f"{100.0 * c.width_m:.3g}" for c in ranked),
        values=tuple(100.0 * c.width_m for c in ranked),
    )
    heights = Column(
        heading="height [cm]",
        texts=tuple(f"{100.0 * c.height_m:.3g}" for c in ranked),
        values=tuple(100.0 * c.height_m for c in ranked),
    )
    front = Column(
        heading="on the Pareto front",
        texts=tuple("yes" if choice.pareto[index] else "no" for index in choice.ranking),
    )
    criteria = [
        Column(
            heading=f"ranked by {k + 1}: {criterion_name(c)}",
            texts=tuple(
                score_text(c.free or c.room, choice.merits[index].values[k])
                for index in choice.ranking
            ),
        )
        for k, c in enumerate(choice.rules.criteria)
    ]
    usable = Column(
        heading="usable, least",
        texts=tuple(f"{100 * choice.merits[index].usable_share:.1f} %" for index in choice.ranking),
    )
    return (*missions[:1], *first, front, *missions[1:], sizes, heights, *criteria, usable, *rest)
