"""Refinement by derivatives: known optima of minimax problems, and slopes of real scores."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from octant.em.reader.fullwave.derivatives import STEP_M
from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.optimise.evaluation import (
    ARRAYS,
    Evaluation,
    SlopeCase,
    Slopes,
    bench,
    evaluate,
    kept_slopes,
    slopes,
)
from octant.reader_design.experiments.optimise.search import search
from octant.reader_design.experiments.optimise.space import (
    boxes,
    key_value,
    profile_key,
    with_values,
)
from octant.reader_design.setting.tangents import FOLLOWED, moved_body
from octant.reader_design.study_file.loading import parse_study
from octant.reader_design.study_file.reader import Reader

STUDY = """
name = "gradient"
[room]
free_space = true
[[tag]]
id = "a"
position_m = [0.0, 0.0, 3.0]
antenna = "dipole"
[reader]
antennas = 3
antenna_length_m = 0.05
antenna_radius_m = 0.04
plate_height_m = 0.03
ground_plane_m = 0.1
cells_per_wavelength = 4.0
[optimise]
survey = 0
evaluations = 40
method = "gradient"
distances_m = [1.0, 2.0]
parameters = {antenna_radius_m = [0.02, 0.05], gap_m = [0.002, 0.022], load_ohm = [20.0, 90.0]}
[[optimise.goal]]
score = "margin_db"
value = 3.0
[[optimise.goal]]
score = "bearing_error_deg"
value = 1.0
"""


def study(old="", new=""):
    return parse_study(STUDY.replace(old, new), source="test.toml", directory=None)


def model(design):
    """Return scores at two distances, and their derivatives by r_a, gap and load."""
    u = np.array((design.antenna_radius_m / 0.01, design.gap_m / 0.01, design.load_ohm / 50.0))
    towards = (np.array((3.1, 1.2, 1.1)), np.array((3.5, 1.2, 1.1)))
    margin = np.array([5.0 - ((u - t) ** 2).sum() for t in towards])
    change = np.array([-2.0 * (u - t) for t in towards]) / np.array((0.01, 0.01, 50.0))
    error = 1.0 + 0.2 * (u[0] - 3.2) * np.ones(2)
    flat = np.zeros((3, 2))
    error_change = flat.copy()
    error_change[0] = 0.2 / 0.01
    numbers = {"right_share": np.ones(2), "front_to_back_db": np.ones(2), "level_w": np.ones(2)}
    evaluation = Evaluation(
        design=design,
        footprint_m=0.1,
        height_m=0.06,
        margin_db=margin,
        bearing_error_deg=error,
        **numbers,
    )
    slope = Slopes(
        right_share=flat,
        front_to_back_db=flat,
        level_w=flat,
        margin_db=change.T,
        bearing_error_deg=error_change,
        footprint_m=np.zeros(3),
        height_m=np.zeros(3),
    )
    return evaluation, slope


def attained(design):
    margin, error = model(design)[0].margin_db.min(), model(design)[0].bearing_error_deg.max()
    slacks = (margin - 3.0, 1.0 - error)
    return min(slacks) + 0.05 * np.mean(slacks)


def test_the_minimax_optimum_is_found_in_a_few_solutions():
    one = study()
    asked = []

    def slopes_of(design, names):
        asked.append(design)
        assert names == ("antenna_radius_m", "gap_m", "load_ohm")
        return model(design)[1]

    found = search(one, one.optimise, lambda design: model(design)[0], slopes=slopes_of)
    best = msgspec.structs.replace(one.reader, gap_m=0.012, load_ohm=55.0)
    grid = [
        attained(msgspec.structs.replace(best, antenna_radius_m=r))
        for r in np.linspace(0.02, 0.05, 3001)
    ]
    assert found.winner.attainment == pytest.approx(max(grid), abs=0.01)
    assert len(found.trials) + len(asked) < 25


def test_a_design_beyond_the_limits_is_not_proposed():
    one = study("distances_m = [1.0, 2.0]", "distances_m = [1.0, 2.0]\nheight_m = 0.05")

    def slopes_of(design, _):
        slope = model(design)[1]
        return Slopes(
            **{name: getattr(slope, name) for name in (*ARRAYS, "footprint_m")},
            height_m=np.array((0.0, 1.0, 0.0)),
        )

    def evaluated(design):
        return replace(model(design)[0], height_m=0.047 + design.gap_m)

    found = search(one, one.optimise, evaluated, slopes=slopes_of)
    assert max(t.evaluation.height_m for t in found.trials[1:]) <= 0.0521
    assert len(found.trials) > 3


@pytest.mark.parametrize("name", [*FOLLOWED[:-2], profile_key(0), profile_key(1)])
def test_a_moved_body_is_built_as_the_changed_design_is_drawn(name):
    reader = Reader(
        antenna_radius_m=0.09,
        plate_height_axis_m=0.09,
        plate_profile_m=(0.07, 0.085),
        antenna_length_m=0.05,
    )
    step = 1e-4
    other = with_values(reader, {name: key_value(reader, name, 2.4e9) + step})
    moved, drawn = moved_body(reader, name, step), other.body()
    for field in (
        "element_azimuths_rad", "element_radii_m", "plate_azimuths_rad", "plate_reaches_m",
        "plate_rim_heights_m", "plate_axis_height_m", "plate_profiles_m",
    ):  # fmt: skip
        assert getattr(moved.built, field) == pytest.approx(getattr(drawn.built, field), abs=1e-15)
    scale = drawn.ground_plane_m / reader.ground_plane_m
    assert moved.built.rim_scale == pytest.approx(scale, rel=1e-14)
    feet = {"antenna_length_m": moved.errors.length_m, "gap_m": moved.errors.gap_m}
    for key, error in feet.items():
        assert (error == (step if key == name else 0.0)).all()


def test_slopes_by_the_load_are_those_of_whole_evaluations(tmp_path):
    place = bench(study())
    design = place.study.reader
    found = kept_slopes(place, SlopeCase(design=design, names=("load_ohm", "gap_m")), tmp_path)
    again = kept_slopes(place, SlopeCase(design=design, names=("load_ohm", "gap_m")), tmp_path)
    step = 0.02
    ends = [
        evaluate(place, msgspec.structs.replace(design, load_ohm=50.0 + s)) for s in (-step, step)
    ]
    for name in ARRAYS:
        whole = (getattr(ends[1], name) - getattr(ends[0], name)) / (2.0 * step)
        assert getattr(found, name)[0] == pytest.approx(whole, rel=1e-5, abs=1e-12)
        assert (getattr(again, name) == getattr(found, name)).all()
    assert found.height_m == pytest.approx((0.0, 1.0), abs=1e-9)


def test_slopes_by_a_length_are_near_those_of_fresh_meshes():
    place = bench(study("cells_per_wavelength = 4.0", "cells_per_wavelength = 10.0"))
    design = place.study.reader
    found = slopes(place, SlopeCase(design=design, names=("antenna_length_m",)))
    step = 1e-3
    ends = [
        evaluate(place, msgspec.structs.replace(design, antenna_length_m=0.05 + s))
        for s in (-step, step)
    ]
    whole = (ends[1].level_w - ends[0].level_w) / (2.0 * step)
    assert step > 100.0 * STEP_M
    assert found.level_w[0] == pytest.approx(whole, rel=0.05)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("antennas = 3", 'antennas = 3\nresponse = "rays"', "only the full-wave solution has"),
        ("{antenna_radius_m", "{plate_outer_radius_m = [0.02, 0.05], antenna_radius_m", "afresh"),
        (
            "{antenna_radius_m",
            "{plate_profile_m = [0.02, 0.05], antenna_radius_m",
            "has no heights",
        ),
    ],
)
def test_what_has_no_derivative_is_refused_at_once(old, new, told):
    with pytest.raises(ConfigError, match=told):
        bench(study(old, new))


def test_every_height_of_the_profile_is_a_parameter_of_its_own():
    free = STUDY.replace("{antenna_radius_m", "{plate_profile_m = [0.02, 0.06], antenna_radius_m")
    free = free.replace("[optimise]", "plate_profile_m = [0.03, 0.04]\n[optimise]", 1)
    one = parse_study(free, source="test.toml", directory=None)
    (box,) = boxes(one, one.optimise)
    assert box.names[1:3] == (profile_key(0), profile_key(1))
    assert box.point(one.reader, frequency_hz=2.4e9)[1:3] == pytest.approx((0.25, 0.5))
    design = box.design((0.5, 1.0, 0.75, 0.5, 0.5))
    assert design.plate_profile_m == pytest.approx((0.06, 0.05))
    assert design.size_m(2.4e9)[1] == pytest.approx(0.062)


def test_an_objective_of_ones_own_has_no_derivative():
    one = study()
    with pytest.raises(ConfigError, match="an objective of your own"):
        search(one, one.optimise, lambda design: model(design)[0], attainment=lambda _: 0.0)
