"""Errors that are swept until missions break: what is driven, and what is said of it."""

import math
from pathlib import Path
from types import SimpleNamespace

import msgspec
import pytest

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.missions.sensitivity import (
    ErrorEntry,
    break_rows,
    broke_before,
    check_error,
    error_truths,
)
from octant.reader_design.study_file.truth import Truth

BOX = {
    "kind": "box",
    "size_m": [0.4, 0.4, 1.0],
    "position_m": [2.0, 2.0, 0.0],
    "material": "wood",
}


def entry(**keys):
    return msgspec.convert({"name": "it", **keys}, ErrorEntry)


def test_each_value_gives_the_keys_of_a_truth():
    tags = entry(key="tag_sd_m", values=[0.01, 0.05], truth={"draws": 5})
    assert list(error_truths(tags)) == [
        (0.01, {"draws": 5, "tag_sd_m": 0.01}),
        (0.05, {"draws": 5, "tag_sd_m": 0.05}),
    ]
    missing = entry(key="object", values=[0, 2], object=[BOX, {**BOX, "yaw_deg": 5.0}])
    truths = [msgspec.convert(keys, Truth) for _, keys in error_truths(missing)]
    assert [len(truth.objects) for truth in truths] == [0, 2]
    assert truths[1].objects[1].yaw_deg == 5.0


@pytest.mark.parametrize(
    ("keys", "told"),
    [
        ({"key": "tag_sd", "values": [0.1]}, "tag_sd_m"),
        ({"key": "object", "values": [2], "object": [BOX]}, "so many cannot stand"),
        ({"key": "object", "values": [0.5], "object": [BOX]}, "whole numbers"),
    ],
)
def test_a_key_or_a_number_that_cannot_be_is_refused(keys, told):
    with pytest.raises(ConfigError, match=told):
        check_error(entry(**keys))


def outcome(value, successes, runs=10, failures=()):
    cell = SimpleNamespace(layout="hall", error="tags", driven="map", value=value)
    return SimpleNamespace(
        cell=cell,
        runs=runs,
        successes=successes,
        success_interval=(0.1, 0.9),
        failures=failures,
    )


def test_a_sweep_breaks_at_the_first_value_with_too_few_successes():
    outcomes = [
        outcome(0.01, 10),
        outcome(0.02, 5),
        outcome(0.05, 4, failures=(("time-out", 4), ("stuck", 2))),
        outcome(0.10, 0, runs=0),
    ]
    assert math.isnan(broke_before(outcomes[:2], 0.5))
    assert broke_before(outcomes[:3], 0.5) == 0.05
    ((_, error, driven, bears, breaks, kinds),) = break_rows(outcomes, 0.5)
    assert (error, driven) == ("tags", "map")
    assert bears == "0.02 (5 of 10, 10 to 90 %)"
    assert breaks.startswith("0.05 (4 of 10")
    assert kinds == "4 time-out; 2 stuck"
    ((*_, unbroken, kinds),) = break_rows(outcomes[:2], 0.5)
    assert (unbroken, kinds) == ("not up to 0.02", "none")


def test_the_built_in_sweep_of_errors_can_be_planned():
    from octant.reader_design.experiments.missions.comparison import plan_comparison
    from octant.reader_design.experiments.missions.comparison_table import load_comparison

    folder = Path(__file__).resolve().parents[4] / "examples" / "layouts"
    comparison = load_comparison(folder / "compare_survey.toml")
    cells = plan_comparison(comparison)
    swept = {cell.error: cell.study.truth for cell in cells if cell.error}
    assert set(swept) >= {"permittivity", "tags", "reader's height", "noise", "cabinets"}
    assert len(swept["cabinets"].objects) >= 3
    assert swept["noise"].noise_db > cells[0].study.mission.noise_db
