"""The verdict of a study says what was run, with judgements that stand on stated limits."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from octant.reader_design.experiments.missions.stage import RoomMission
from octant.reader_design.experiments.study.verdict import study_verdict
from octant.reader_design.setting.ranking import Candidate
from octant.reader_design.setting.scores import score_rss

ELEMENTS = np.arange(8) * np.pi / 4
AZIMUTHS = np.arange(48) * np.pi / 24
SCORES = score_rss(
    (1e-6 * (1 + 0.8 * np.cos(AZIMUTHS[:, None] - ELEMENTS)))[None], AZIMUTHS, ELEMENTS
)


def reader(error_deg, right):
    scores = dataclasses.replace(SCORES, vector_rms_rad=math.radians(error_deg), right_share=right)
    return Candidate(label="r", key="r", free=SCORES, room=scores)


def driven(reached, runs):
    success = np.arange(runs) < reached
    return RoomMission(
        name="office",
        slug="room",
        reason="",
        notes=(),
        data=xr.Dataset({"success": ("run", success)}),
        folder=Path(),
    )


@pytest.mark.parametrize(
    ("reached", "error_deg", "right", "sentence", "grades"),
    [
        (20, 8.6, 0.93, "all four tags in 20 of 20 runs; the reader points within 9° ", "ggg"),
        (19, 11.3, 0.8, "all four tags in 19 of 20 runs; the reader points within 11° ", "gfg"),
        (18, 22.5, 0.79, "all four tags in 18 of 20 runs; the reader points within 22° ", "fff"),
        (0, 30.9, 0.49, "all four tags in none of 20 runs; the reader points within 31° ", "ppp"),
    ],
)
def test_sentence_and_grades_follow_the_numbers(reached, error_deg, right, sentence, grades):
    verdict = study_verdict(reader(error_deg, right), 8, [driven(reached, 20)], 4)
    assert verdict.sentence == f"The robot reached {sentence}(rms) in this room."
    assert "".join(n.grade[0] for n in verdict.numbers) == grades
    assert "good up to 11°, fair up to 22°" in verdict.numbers[1].rule


def test_without_a_mission_or_a_room_nothing_is_said_of_them():
    free = dataclasses.replace(reader(4.0, 1.0), room=None)
    verdict = study_verdict(free, 8, [], 0)
    assert verdict.sentence.endswith("° (rms) in free space.")
    assert verdict.sentence.startswith("The reader points within ")
    assert [n.name for n in verdict.numbers] == [
        "bearing error, free space",
        "right antenna, free space",
    ]
    undriven = dataclasses.replace(driven(0, 1), data=None, reason="no band")
    assert "could not be driven" in study_verdict(free, 8, [undriven], 1).sentence
