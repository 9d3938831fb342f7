"""Each way in which a mission fails is told from its runs, and what is proposed mends it."""

import itertools
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from octant.em.reader.response import sector_response
from octant.geometries.errors import ConfigError
from octant.navigation.missions.records import MissionResult
from octant.reader_design.experiments.missions.advice import advise
from octant.reader_design.experiments.missions.compute import drive_missions, mission_job
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.changes import changed
from octant.reader_design.study_file.loading import parse_study

ROOM = """
seed = 3
[room]
box_m = [6.0, 5.0, 3.1]
origin_m = [-1.0, -1.0, 0.0]
material = "concrete"
[[tag]]
id = "a"
position_m = [2.0, 1.0, 3.05]
antenna = "dipole"
[solver]
max_reflections = 2
[mission]
navigator = "thesis"
start_m = [0.0, 0.0]
tags = ["a"]
runs = 4
"""
DESK = """
[[room.object]]
kind = "box"
name = "desk"
size_m = [1.6, 1.4, 0.04]
position_m = [1.2, 0.3, 0.74]
material = "wood"
"""
LINK = {("mission", "navigator"), ("tag", None, "antenna"), ("radio", "channels_hz")}


def setting_of(study):
    azimuths = 2.0 * np.pi * np.arange(8) / 8
    return build_setting(study).with_responses(
        sector_response(azimuths, frequency_hz=f) for f in study.radio.frequencies_hz
    )


def study_of(extra="", **edits):
    text = ROOM + extra
    for old, new in edits.values():
        assert old in text
        text = text.replace(old, new)
    return parse_study(text, source="test", directory=Path())


def run_of(setting, outcome, way, *, arrived=None, rss=1e-6):
    """Return a run along places, which ended so; where it declared the tag reached."""
    mission, way = mission_job(setting).mission, np.array(way, dtype=float)
    rows = len(way)
    nowhere = np.full((1, 2), np.nan)
    return MissionResult(
        mission=mission,
        outcome=outcome,
        reason="as it was",
        time_s=np.arange(float(rows)),
        poses=np.column_stack([way, np.zeros(rows)]),
        modes=("navigation",) * rows,
        targets=np.zeros(rows, dtype=np.int64),
        rss_w=np.full((rows, 8), rss),
        arrival_times_s=np.array([np.nan if arrived is None else float(rows)]),
        arrival_points_m=nowhere if arrived is None else np.array([arrived]),
    )


def walk(*corners, steps=40):
    return np.concatenate([np.linspace(a, b, steps) for a, b in itertools.pairwise(corners)])


ASTRAY = walk((0, 0), (4, 3), (3, 3.5), (0, 3))
START = {"start": ("start_m = [0.0, 0.0]", "start_m = [-0.83, 0.0]")}
ASLEEP = {"kind": ('antenna = "dipole"', 'antenna = "dipole"\nkind = "passive"')}
CASES = {
    "nowhere": (study_of(), ("time-out", ASTRAY), {}, LINK),
    "wrong place": (
        study_of(),
        ("completed", walk((0, 0), (4, 3))),
        {"arrived": (4.0, 3.0)},
        LINK,
    ),
    "obstacle": (
        study_of(),
        ("collision", walk((0, 0), (4, 3))),
        {},
        LINK | {("mission", "contact")},
    ),
    "time-out": (
        study_of(),
        ("time-out", walk((0, 0), (1.5, 0.7))),
        {},
        LINK | {("mission", "max_time_s")},
    ),
    "start": (
        study_of(**START),
        ("collision", walk((-0.83, 0), (-0.84, 0.1), steps=3)),
        {},
        {("mission", "start_m")},
    ),
    "asleep": (
        study_of("[rfid]\npower_w = 1.0\n", **ASLEEP),
        ("no signal", walk((0, 0), (1, 1))),
        {"rss": 0.0},
        {("tag", 0, "kind")},
    ),
    "shadowed": (
        study_of(DESK),
        ("time-out", ASTRAY),
        {},
        {
            ("solver", "transmission"),
            ("room", "object", 0, "material"),
            ("tag", 0, "position_m"),
        },
    ),
    "no floor": (
        study_of(DESK.replace("0.04]", "0.7]").replace("0.74]", "0.0]")),
        ("time-out", ASTRAY),
        {},
        {("tag", 0, "position_m")},
    ),
}


@pytest.mark.parametrize("cause", CASES)
def test_each_cause_is_told_in_one_sentence_with_keys_that_can_be_pasted(cause):
    study, (outcome, way), more, keys = CASES[cause]
    setting = setting_of(study)
    advice = advise(setting, [run_of(setting, outcome, way, **more)] * 4)
    assert advice.cause == cause
    assert {change.path for change in advice.changes} == keys
    assert advice.sentence.endswith(".")
    assert "nan" not in advice.text()
    pasted = tomllib.loads("\n".join(advice.lines).replace("[[tag]]", "[tag]"))
    assert pasted
    build_setting(changed(study, advice.changes))  # every value is one that the study takes


def test_nothing_is_advised_where_nearly_all_runs_arrive():
    setting = setting_of(study_of())
    good = run_of(setting, "completed", walk((0, 0), (2, 1)), arrived=(2.0, 1.0))
    bad = run_of(setting, "time-out", ASTRAY)
    assert advise(setting, [good] * 19 + [bad]) is None
    assert advise(setting, [good] * 18 + [bad] * 2).sentence.startswith("2 of 20 runs")


def test_a_closed_desk_gets_half_its_thickness_and_large_numbers_are_short():
    study, (outcome, way), more, _ = CASES["shadowed"]
    setting = setting_of(study)
    lines = advise(setting, [run_of(setting, outcome, way, **more)]).lines
    assert any('{name = "wood", thickness_m = 0.019}' in line for line in lines)
    setting = setting_of(study_of())
    lines = advise(setting, [run_of(setting, "time-out", ASTRAY)]).lines
    assert any("[2.402e9, 2.428e9, 2.454e9, 2.48e9]" in line for line in lines)


@pytest.mark.parametrize("start", ["[1.5, 0.6]", "[-5.0, 0.0]", "[-0.95, 0.0]"])
def test_a_start_where_the_robot_cannot_stand_is_refused_with_one_where_it_can(start):
    cupboard = DESK.replace("0.04]", "0.7]").replace("0.74]", "0.0]")
    with pytest.raises(ConfigError, match=r"start_m is .* for example at (\[.*\]) m") as refusal:
        build_setting(study_of(cupboard, start=("[0.0, 0.0]", start)))
    better = re.search(r"example at (\[.*\]) m", str(refusal.value))
    mission_job(setting_of(study_of(cupboard, start=("[0.0, 0.0]", better[1]))))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("study", "cause"),
    [
        (study_of(), {"obstacle", "nowhere", "wrong place"}),
        (
            study_of(
                late=("runs = 4", "runs = 4\nmax_time_s = 14.0"),
                navigator=('"thesis"', '"tracker"'),
                tag=('"dipole"', '"conical_patch"'),
            ),
            {"time-out"},
        ),
        (
            study_of(
                DESK, navigator=('"thesis"', '"tracker"'), tag=('"dipole"', '"conical_patch"')
            ),
            {"shadowed"},
        ),
    ],
)
def test_what_is_advised_mends_the_mission(study, cause):
    """Round by round, as a person would follow it; a tag is moved only where nothing else is left.

    An independent check of the advice: the mission itself, driven again.
    """
    setting = setting_of(study)
    advice = advise(setting, drive_missions(setting))
    assert advice.cause in cause
    for _ in range(3):
        other = [c for c in advice.changes if c.path[-1] != "position_m"]
        study = changed(study, other or advice.changes)
        setting = setting_of(study)
        advice = advise(setting, drive_missions(setting))
        if advice is None:
            return
    pytest.fail(advice.text())
