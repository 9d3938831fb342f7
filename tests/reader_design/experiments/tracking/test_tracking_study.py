"""The tracking study's parts: the room solver's, chapter 6's, and Table 8.1, on small settings."""

import msgspec
import numpy as np
import pytest

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.tracking import chapters, compute, room, tag_numbers
from octant.reader_design.experiments.tracking import cost_scalings as cost_scalings_module
from octant.reader_design.experiments.tracking.cost_scalings import CostScaling, cost_scalings
from octant.reader_design.experiments.tracking.costs import COST_COLUMNS, cost_rows
from octant.reader_design.experiments.tracking.figures import tracking_figures
from octant.reader_design.experiments.tracking.settings import settings_of
from octant.reader_design.study_file.loading import load_study, parse_study


def small(**changes):
    study = load_study(built_in="track_study")
    return settings_of(
        msgspec.structs.replace(study, track=msgspec.structs.replace(study.track, **changes))
    )


@pytest.fixture(scope="module")
def in_the_room():
    """Nine tags only: the larger mesh is shrunk to one tag, which serves no acceptance here."""
    settings = small(runs=6, tags=1, room_particles=200)
    return [room.room_runs(settings, mesh) for mesh in room.meshes(settings)]


def among(text, tmp_path):
    """Settings of a study in the thesis' room, with further tables."""
    room = (
        '[room]\nbox_m = [12.0, 12.0, 3.0]\norigin_m = [-6.0, -6.0, 0.0]\nmaterial = "concrete"\n'
    )
    return settings_of(parse_study(room + text, source="test", directory=tmp_path))


TWO_TAGS = """
[track]
[map]
height_m = 0.4
[[tag]]
id = "a"
position_m = [1.0, 2.0, 2.5]
antenna = "dipole"
[[tag]]
id = "b"
position_m = [-1.0, 0.5, 1.4]
antenna = "dipole"
"""


def test_the_tags_of_the_study_are_the_tags_of_every_chapter(tmp_path):
    settings = among(TWO_TAGS, tmp_path)
    heights = [[1.0, 2.0, 2.1], [-1.0, 0.5, 1.0]]
    for found in (settings.mesh.tags_m, settings.feedback_tags_m):
        assert found == pytest.approx(np.array(heights))
    assert chapters.laboratory_tags_m(settings) == pytest.approx(np.array(heights))
    assert room.meshes(settings) == (0,)


def test_a_tag_as_high_as_the_antenna_is_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"tag\[1\].*set map.height_m"):
        among(TWO_TAGS.replace("1.4]", "0.4]"), tmp_path)


def test_patterns_and_numbers_of_tags_are_keys(tmp_path):
    settings = among(
        '[track]\ntag_pattern = "circle"\ntag_count = 6\ntag_field_m = 8.0\n', tmp_path
    )
    for found in (settings.mesh.tags_m, settings.feedback_tags_m):
        assert np.hypot(*found[:, :2].T) == pytest.approx(np.full(6, 4.0))


@pytest.mark.parametrize(
    ("task", "run", "sigma", "published_m"),
    [
        (tag_numbers.SPACING, 4, 0.0, 0.181),
        (tag_numbers.SPACING, 9, 0.0, 0.116),
        (tag_numbers.SPACING, 25, 0.0, 0.071),
        (tag_numbers.SPACING, 49, 0.0, 0.043),
    ],
)
def test_more_tags_follow_better_as_the_audit_found(task, run, sigma, published_m):
    part = compute.Part(chapter="tags", task=task, method="lemniscate", run=run, sigma=sigma)
    (row,) = tag_numbers.compute(small(runs=25), part).rows
    found = dict(zip(tag_numbers.COLUMNS, row, strict=True))
    assert found["average_m_median"] == pytest.approx(published_m, rel=0.1)
    assert found["field_m"] == pytest.approx(3.0 * (run**0.5 - 1.0))


def test_a_range_leaves_the_robot_with_fewer_tags_and_a_larger_error():
    part = compute.Part(chapter="tags", task=tag_numbers.RANGE, method="lemniscate", sigma=4.0)
    (row,) = tag_numbers.compute(small(runs=5), part).rows
    found = dict(zip(tag_numbers.COLUMNS, row, strict=True))
    assert found["heard_least_on_way"] == 1
    assert found["share_of_way_with_least_tags"] == 0.0
    assert found["average_m_median"] > 0.15


def averages(results, task, method):
    outcomes = [o for runs in results for o in runs.outcomes]
    outcome = next(o for o in outcomes if (o.task, o.method) == (task, method))
    return outcome.measures()["average_m"]


@pytest.mark.slow
def test_the_particle_filter_keeps_the_lemniscate_in_the_concrete_room(in_the_room):
    best = averages(in_the_room, "9 tags", room.PARTICLE)
    assert np.median(best) <= 0.15
    assert np.median(averages(in_the_room, "9 tags", room.DEAD)) > 2.0 * np.median(best)


def test_one_tag_is_worse_than_nine(in_the_room):
    one = averages(in_the_room, "1 tags", room.PARTICLE)
    assert np.median(one) > np.median(averages(in_the_room, "9 tags", room.PARTICLE))


def test_the_true_field_is_coherent_and_finer_than_the_map(in_the_room):
    first, _ = in_the_room
    assert first.map_dbm.shape[0] == len(first.map_x_m)
    assert np.std(first.map_dbm) > 2.0
    assert "rms" in first.facts[0]
    assert first.facts[1].startswith("9 tags, particle filter, computed map: 6 of 6 runs")


def test_the_runs_of_gains_trained_over_many_records_do_not_depend_on_their_number():
    few, more = (
        chapters.trained_over_many(
            small(runs=runs, training_iterations=40, training_records=2), "line"
        )[0].runs.poses
        for runs in (1, 2)
    )
    assert (few[0] == more[0]).all()


def test_the_runs_of_one_method_are_put_together_in_order():
    settings = small(runs=2, training_iterations=5, chapters=("feedback",))
    parts = [part for part in compute.parts_of(settings) if not part.method]
    records = [compute.compute_part(settings.study, part) for part in parts]
    content = compute.TrackingContent(
        settings=settings, study_toml="", parts=tuple(zip(parts, records, strict=True))
    )
    assert [(o.task, o.method) for o in content.feedback] == [
        (task, method) for task in ("line", "sine") for method in (chapters.REPLAY, chapters.FRESH)
    ]
    poses = content.feedback[0].runs.poses
    assert (poses[1] == records[1].outcomes[0].runs.poses[0]).all()
    assert not (poses[0] == poses[1]).all()


def test_the_cost_table_has_every_controller_and_positive_times(monkeypatch):
    monkeypatch.setattr("octant.reader_design.experiments.tracking.costs.TIMED_S", 1e-4)
    settings = small(training_iterations=10)
    rows = cost_rows(settings)
    assert len(rows) == 5
    assert all(row.step_us > 0.0 for row in rows)
    assert [row.knows_tags for row in rows] == [False, False, True, True, True]


def test_the_cost_table_has_all_columns_of_table_8_1(monkeypatch):
    monkeypatch.setattr("octant.reader_design.experiments.tracking.costs.TIMED_S", 1e-4)
    rows = [dict(zip(COST_COLUMNS, r.row(), strict=True)) for r in cost_rows(small())]
    assert [row["rfid_architecture"] for row in rows] == ["modified reader"] + 4 * ["modified tag"]
    assert [row["tracks"] for row in rows] == ["no"] + 4 * ["yes"]
    assert rows[0]["stabilises"].startswith("no")
    assert rows[2]["linearises"].startswith("along the nominal (7.28)")


def test_every_scaling_has_a_positive_time_for_each_size(monkeypatch):
    monkeypatch.setattr("octant.reader_design.experiments.tracking.costs.TIMED_S", 1e-4)
    for sizes in ("TAG_SIDES", "STEP_COUNTS", "ITERATIONS", "HORIZONS"):
        monkeypatch.setattr(cost_scalings_module, sizes, (2, 4))
    scalings = {s.quantity: s for s in cost_scalings(small())}
    assert list(scalings) == [
        "number of tags s",
        "number of tags s (600 steps)",
        "number of steps k_f",
        "number of states n",
        "number of iterations N",
        "horizon [periods]",
    ]
    for scaling in scalings.values():
        assert list(scaling.sizes) == sorted(set(scaling.sizes))
        for times in scaling.times_us.values():
            assert len(times) == len(scaling.sizes)
            assert min(times) > 0.0


def test_a_scaling_knows_its_exponent():
    scaling = CostScaling(
        what="x", quantity="n", sizes=(1, 2, 4), times_us={"square": (1.0, 4.0, 16.0)}
    )
    assert scaling.exponent("square") == pytest.approx(2.0)


def test_an_empty_study_has_no_figures():
    empty = compute.TrackingContent(settings=small(), study_toml="")
    assert list(tracking_figures(empty)) == []
    assert empty.outcomes == ()
