"""``octant.optimise``: an objective and constraints of one's own."""

import math

import numpy as np
import pytest

import octant
from octant.geometries.errors import ConfigError

CALLS = []


def bowl(study):
    """Least at r_a = 8.2 cm, load 90 ohm."""
    CALLS.append(study.reader.antenna_radius_m)
    radius = (study.reader.antenna_radius_m - 0.082) / 0.05
    return 3.0 + radius**2 + ((study.reader.load_ohm - 90.0) / 100.0) ** 2


def at_most_7_cm(study):
    return 0.07 - study.reader.antenna_radius_m


def failing(study):
    if study.reader.antenna_radius_m < 0.06:
        msg = "too small for me"
        raise ConfigError(msg)
    return bowl(study)


READER = octant.Reader(response="isolated", plate_height_m=0.0)
BOUNDS = {"antenna_radius_m": (0.04, 0.10), "load_ohm": (40.0, 140.0)}


@pytest.fixture(autouse=True)
def no_calls():
    CALLS.clear()


def test_the_least_of_a_bowl_is_found_within_the_steps_of_a_workshop(tmp_path):
    found = octant.optimise(
        READER, BOUNDS, objective=bowl, store=tmp_path, budget=80, progress=False
    )
    assert found.reader.antenna_radius_m == pytest.approx(0.082, abs=5e-4)
    assert found.reader.load_ohm == pytest.approx(90.0, abs=2.0)
    assert found.objective == pytest.approx(3.0, abs=1e-3)
    data = found.data
    assert data["objective"].min() == found.objective
    assert data["stage"].to_numpy()[0] == "reader"
    assert float(data["antenna_radius_m"][0]) == 0.1
    assert data["antenna_radius_m"].attrs["units"] == "m"
    assert f"{found.objective:.6g}" in repr(found)
    # Again: every design is there already, and the search takes the same steps.
    count = len(CALLS)
    again = octant.optimise(
        READER, BOUNDS, objective=bowl, store=tmp_path, budget=80, progress=False
    )
    assert len(CALLS) == count
    assert again.data.equals(data)


def test_constraints_hold_and_infeasible_designs_say_why():
    found = octant.optimise(
        READER, BOUNDS, objective=bowl, subject_to=[at_most_7_cm], budget=60, progress=False
    )
    assert found.reader.antenna_radius_m == pytest.approx(0.07, abs=3e-4)
    data = found.data
    missed = data["constraint_1"] < 0.0
    assert missed.any()
    assert np.isnan(data["objective"].where(missed, drop=True)).all()
    assert set(data["infeasible_because"].to_numpy()[missed]) == {"constraint 1 is negative."}
    # What a constraint rules out is not computed.
    assert max(CALLS) <= 0.07


def test_choices_are_surveyed_and_failures_are_designs_without_a_score():
    found = octant.optimise(
        READER,
        {"antenna_radius_m": (0.04, 0.10)},
        objective=failing,
        choices={"antennas": [6, 8]},
        survey=4,
        budget=10,
        progress=False,
    )
    assert set(found.data["antennas"].to_numpy()) == {6, 8}
    reasons = set(found.data["infeasible_because"].to_numpy())
    assert "too small for me" in reasons
    assert math.isfinite(found.objective)


def test_what_cannot_be_searched_is_refused():
    with pytest.raises(ConfigError, match="antenna_radius"):
        octant.optimise(READER, {"antena_radius_m": (0.04, 0.1)}, objective=bowl, progress=False)
    with pytest.raises(ConfigError, match="nothing to search"):
        octant.optimise(READER, {}, objective=bowl, progress=False)
    with pytest.raises(ConfigError, match=r"none of the .* is feasible.*not a number"):
        octant.optimise(
            READER, BOUNDS, objective=lambda _: math.nan, survey=1, budget=1, progress=False
        )
