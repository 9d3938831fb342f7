"""The rules of the choice and its outcome in words and numbers."""

import math
from typing import TYPE_CHECKING

from octant.reader_design.study_file.choice import Choice as Rules
from octant.reader_design.study_file.choice import Criterion
from octant.reader_design.study_file.scores import (
    Scores,
    higher_is_better,
    score_unit,
)

if TYPE_CHECKING:
    from octant.reader_design.setting.ranking import Candidate, Merit

SIZE = "size"
"""What decided where a constraint on the size did."""
USABLE = "usable signal"
"""What decided where too little signal did."""
ORDER = "order of the sweep"
"""What decided where all criteria are equal within their tolerances."""
ONLY_ONE = "only one design"
"""What decided where nothing is left to compare with."""

MISSIONS = "missions"
"""What decided where more runs of one design reached every tag."""

_PHRASES = (
    ("read_right_share", "share of right antennas as read"),
    ("read_strongest", "bearing error of the strongest antenna as read"),
    ("read_vector", "bearing error of the vector sum as read"),
    ("right_share", "share of right antennas"),
    ("strongest", "bearing error of the strongest antenna"),
    ("vector", "bearing error of the vector sum"),
    ("front_to_back", "front-to-back ratio"),
    ("margin", "margin over the neighbours"),
    ("monotonic", "monotonic steering signal"),
    ("slope", "slope of the steering signal"),
    ("full_scale", "full scale of the steering signal"),
    ("usable", "usable signal"),
    ("level", "level"),
    ("captured", "share of captured floor"),
)


def score_phrase(name: str) -> str:
    """Return what a score is about, in words.

    Parameters
    ----------
    name : Its name.
    """
    return next(phrase for start, phrase in _PHRASES if name.startswith(start))


def score_text(name: str, value: float) -> str:
    """Return a score with its unit [%, deg, dB, dBm, nW].

    Parameters
    ----------
    name : Its name, which tells the unit.
    value : The value in that unit [rad, dB, dBm, W or -].
    """
    unit = score_unit(name)
    if unit == "rad":
        return f"{math.degrees(value):.1f}°"
    if unit.startswith("W"):
        return f"{1e9 * value:.3g} n{unit}"
    if unit == "dB":
        return f"{value:+.1f} dB"
    if name.endswith("_share"):
        return f"{100 * value:.1f} %"
    return f"{value:.1f} {unit}" if unit == "dBm" else f"{value:.3g}"


def criterion_name(criterion: Criterion) -> str:
    """Return what a criterion is about, in words.

    Parameters
    ----------
    criterion : Names of the scores.
    """
    return score_phrase(criterion.free or criterion.room)


def criterion_sentence(criterion: Criterion) -> str:
    """Return a criterion in words, its tolerance in [dB], [deg] or percent [%].

    Parameters
    ----------
    criterion : Names of the scores and tolerance.
    """
    name = criterion.free or criterion.room
    both = bool(criterion.free and criterion.room)
    mean = "root mean square" if score_unit(name) == "rad" else "mean"
    where = f"{mean} of free space and the room" if both else "in free space"
    if not criterion.free:
        where = "in the room"
    scores = " and ".join(dict.fromkeys(filter(None, (criterion.free, criterion.room))))
    text = f"the {score_phrase(name)} ({scores}, {where})"
    best = "more" if higher_is_better(name) else "less"
    if criterion.relative:
        equal = f"within {100 * criterion.tolerance:.0f} % of the best"
    elif name.endswith("_share"):
        equal = f"within {100.0 * criterion.tolerance:.3g} percentage points of the best"
    else:
        equal = f"within {score_text(name, criterion.tolerance).lstrip('+')} of the best"
    return f"{text}; {best} is better" + (f", {equal} is equal" if criterion.tolerance else "")


def rule_sentences(rules: Rules) -> tuple[str, ...]:
    """Return the rules in words, one sentence each, tolerances in [dB] and percent [%].

    Parameters
    ----------
    rules : The study's table ``[choice]``.
    """
    out = []
    for name, limit_m in (("wide", rules.greatest_width_m), ("high", rules.greatest_height_m)):
        if limit_m is not None:
            out.append(
                f"A reader may be at most {100.0 * limit_m:.4g} cm {name}; others rank last."
            )
    out.append(
        "A design must receive a usable signal in at least "
        f"{100 * rules.least_usable_share:.0f} % of the "
        "samples, in free space and in the room; others rank last."
    )
    for k, criterion in enumerate(rules.criteria):
        out.append(f"{'Then' if k else 'First'}: {criterion_sentence(criterion)}.")
    out.append("If all that is equal, the design that stands first in the sweep.")
    if rules.by_missions:
        out.append(
            f"The first {rules.missions} then drive the missions: more runs that reached every tag "
            "are better, and of as many the earlier design."
        )
    return tuple(out)


def _numbers(free: Scores, room: Scores | None) -> str:
    """Return the numbers behind a candidate's rank, as half a sentence."""

    def text(scores: Scores) -> str:
        return (
            f"the strongest antenna is the right one in {100 * scores.right_share:.0f} % of the "
            f"directions, the vector sum is {math.degrees(scores.vector_rms_rad):.1f}° rms off"
        )

    out = (
        f"in free space {text(free)} and the facing antenna leads its neighbours by "
        f"{free.margin_worst_db:+.1f} dB at worst"
    )
    if room is not None:
        out += (
            f"; in the room {text(room)} and the facing antenna leads by "
            f"{room.margin_mean_db:+.1f} dB on average"
        )
    return out


def chosen_sentence(best: "Candidate", merit: "Merit", rules: Rules) -> tuple[str, ...]:
    """Return what the chosen design can do, and which constraint it misses, in sentences.

    Parameters
    ----------
    best, merit, rules : The chosen design, its deciding numbers, and the constraints.
    """
    out = [f"Chosen: {best.label}; {_numbers(best.free, best.room)}."]
    if merit.excess_m > 0.0:
        out.append(
            "No design keeps to the allowed size; this one exceeds it least, by "
            f"{100.0 * merit.excess_m:.3g} cm."
        )
    if merit.usable_share < rules.least_usable_share:
        out.append(
            f"No design receives a usable signal in {100 * rules.least_usable_share:.0f} % of the "
            f"samples; this one comes closest with {100 * merit.usable_share:.0f} %."
        )
    return tuple(out)


def comparison_sentence(
    better: "Merit", worse: "Merit", by: str, *, label: str, rules: Rules
) -> str:
    """Return in one sentence what a design has over the next, in [%, deg, dB, dBm, cm].

    Parameters
    ----------
    better, worse : Deciding numbers of both.
    by, label, rules : What decided, name of the next design, and the criteria.
    """
    numbers = "all criteria equal within their tolerances"
    if by == SIZE:
        numbers = f"{100 * better.excess_m:.3g} cm against {100 * worse.excess_m:.3g} cm too large"
    elif by == USABLE:
        numbers = (
            f"{100 * better.usable_share:.0f} % against {100 * worse.usable_share:.0f} % usable"
        )
    for criterion, one, other in zip(rules.criteria, better.values, worse.values, strict=True):
        if by == criterion_name(criterion):
            name = criterion.free or criterion.room
            numbers = f"{score_text(name, one)} against {score_text(name, other)}"
            break
    return f"Next comes {label}; what decided is the {by}: {numbers}."


def missions_sentence(reached: int, other: int, runs: int, *, label: str) -> str:
    """Return in one sentence by how many runs a design is before the next.

    Parameters
    ----------
    reached, other, runs : Runs of both that reached every tag, of so many.
    label : Name of the next design.
    """
    return (
        f"Next comes {label}; what decided is the {MISSIONS}: {reached} against {other} of {runs} "
        "runs reached every tag."
    )


def model_sentence(model: str) -> str:
    """Return how far the reader's model can be trusted; its error in [dB].

    Parameters
    ----------
    model : Model of the reader's response.
    """
    if model == "rays":
        return (
            "Take the ranking with care: the reader's own metal was modelled by the currents that "
            'rays induce on it (response = "rays"), which leaves out the coupling between antennas '
            "and the mismatch to their loads; levels near an antenna's maximum are known to err by "
            "1 to 3 dB, weak ones by more, so a full-wave check must confirm the choice."
        )
    if model == "isolated":
        return (
            "Take the ranking with care: the antennas were modelled alone "
            '(response = "isolated"), so neither the plates nor the ground plane act and '
            "designs that differ in them only cannot be told apart."
        )
    if model == "fullwave":
        return (
            "The reader's own body was solved by the method of moments "
            '(response = "fullwave"): coupling, mismatch to the loads and diffraction at its edges '
            "are in the ranking; thickness and losses of its metal, and the robot below, are not."
        )
    if model == "metal":
        return (
            "The reader's metal was solved by the method of moments as it is given (response = "
            '"metal"); its thickness and losses, and the robot below, are not in the ranking.'
        )
    if model == "files":
        return "The reader is given by pattern files; the choice rests on what they say."
    return f'The reader\'s own body was modelled with response = "{model}".'
