"""What a study came to, in one plain sentence and up to three judged numbers."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from octant.reader_design.experiments.missions.advice import FAIR_SHARE, GOOD_SHARE, Advice
from octant.reader_design.experiments.missions.stage import RoomMission
from octant.reader_design.setting.ranking import Candidate

Grade = Literal["good", "fair", "poor"]

RIGHT_GOOD, RIGHT_FAIR = 0.8, 0.5
"""Shares of directions with the right strongest antenna that are good, and fair [-]."""
BEARING_GOOD, BEARING_FAIR = 0.25, 0.5
"""Bearing errors, rms by the angle between neighbouring antennas, that are good, and fair [-].

At half of it an error reaches the neighbour's sector; at a quarter, two standard deviations do."""

_NUMBERS = (
    "no one two three four five six seven eight nine ten eleven twelve".split()  # noqa: SIM905
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """One number with a plain judgement.

    Attributes
    ----------
    name, text : What it is, and its value with its unit.
    value : The same as a number, in that unit; a share for per cent [-].
    grade, rule : The judgement, and from where on it is good or fair.
    """

    name: str
    text: str
    value: float
    grade: Grade
    rule: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """What a study came to.

    Attributes
    ----------
    sentence : In one sentence.
    numbers : Missions, bearing error and right antenna, as far as there are any.
    advice : What to try where missions failed; None: they did not, or there are none.
    """

    sentence: str
    numbers: tuple[Judged, ...]
    advice: Advice | None = None


def study_verdict(
    chosen: Candidate, antennas: int, missions: Sequence[RoomMission], tags: int
) -> Verdict:
    """Return the verdict on a chosen reader.

    Parameters
    ----------
    chosen : Its scores, those in the room where there is one.
    antennas : Number of its antennas [-].
    missions, tags : Its missions, those in the study's own room first; tags of a mission [-].
    """
    where, scores = ("in this room", chosen.room)
    if scores is None:
        where, scores = ("in free space", chosen.free)
    error_deg = math.degrees(scores.vector_rms_rad)
    parts, numbers = [], []
    first = missions[0] if missions else None
    if first is not None and first.data is not None:
        reached, runs = int(first.data["success"].values.sum()), int(first.data.sizes["run"])
        parts.append(f"the robot reached {all_tags(tags)} in {of_runs(reached, runs)}")
        numbers.append(
            Judged(
                name="missions",
                text=f"{reached} of {runs} runs",
                value=reached / runs,
                grade=grade(reached / runs, good=GOOD_SHARE, fair=FAIR_SHARE),
                rule=_share_rule(GOOD_SHARE, FAIR_SHARE),
            )
        )
    elif first is not None:
        parts.append("the robot could not be driven with this reader")
    parts.append(f"the reader points within {degrees(error_deg)} (rms) {where}")
    spacing_deg = 360.0 / antennas
    good_deg, fair_deg = BEARING_GOOD * spacing_deg, BEARING_FAIR * spacing_deg
    numbers.append(
        Judged(
            name=f"bearing error, {where.removeprefix('in this ').removeprefix('in ')}",
            text=f"{degrees(error_deg)} rms",
            value=error_deg,
            grade=grade(-error_deg, good=-good_deg, fair=-fair_deg),
            rule=f"good up to {degrees(good_deg)}, fair up to {degrees(fair_deg)}: a quarter and a "
            f"half of the {degrees(spacing_deg)} between antennas",
        )
    )
    numbers.append(
        Judged(
            name=f"right antenna, {where.removeprefix('in this ').removeprefix('in ')}",
            text=f"{100.0 * scores.right_share:.0f} % of directions",
            value=scores.right_share,
            grade=grade(scores.right_share, good=RIGHT_GOOD, fair=RIGHT_FAIR),
            rule=_share_rule(RIGHT_GOOD, RIGHT_FAIR),
        )
    )
    sentence = "; ".join(parts)
    return Verdict(
        sentence=f"{sentence[0].upper()}{sentence[1:]}.",
        numbers=tuple(numbers),
        advice=None if first is None else first.advice,
    )


def grade(value: float, *, good: float, fair: float) -> Grade:
    """Return the judgement on a number of which more is better.

    Parameters
    ----------
    value, good, fair : The number, and from where on it is good, or fair [its unit].
    """
    return "good" if value >= good else "fair" if value >= fair else "poor"


def all_tags(count: int) -> str:
    """Return the tags of a mission in words, such as "all four tags".

    Parameters
    ----------
    count : How many [-].
    """
    if count <= 2:
        return ("", "the tag", "both tags")[count]
    return f"all {_NUMBERS[count] if count < len(_NUMBERS) else count} tags"


def of_runs(reached: int, runs: int) -> str:
    """Return how many of the runs, such as "19 of 20 runs" or "none of 20 runs".

    Parameters
    ----------
    reached, runs : How many, of how many [-].
    """
    if runs == 1:
        return "the one run" if reached else "none of one run"
    return f"{reached or 'none'} of {runs} runs"


def degrees(angle_deg: float) -> str:
    """Return an angle as a person would say it, with its sign.

    Parameters
    ----------
    angle_deg : The angle [deg].
    """
    return f"{angle_deg:.0f}°" if angle_deg >= 1.95 else f"{angle_deg:.1f}°"


def _share_rule(good: float, fair: float) -> str:
    return f"good from {100.0 * good:.0f} %, fair from {100.0 * fair:.0f} %"
