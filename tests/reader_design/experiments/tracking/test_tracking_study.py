"""The tracking study's parts: the room solver's, chapter 6's, and Table 8.1, on small settings."""

import msgspec
import numpy as np
import pytest

from octant.reader_design.experiments.tracking import chapters, room
from octant.reader_design.experiments.tracking.compute import TrackingContent
from octant.reader_design.experiments.tracking.costs import CostScaling, cost_rows
from octant.reader_design.experiments.tracking.figures import tracking_figures
from octant.reader_design.experiments.tracking.settings import settings_of
from octant.reader_design.study_file.loading import load_study


def small(**changes):
    study = load_study(built_in="track_study")
    return settings_of(
        msgspec.structs.replace(study, track=msgspec.structs.replace(study.track, **changes))
    )


@pytest.fixture(scope="module")
def in_the_room():
    """Nine tags only: the larger mesh is shrunk to one tag, which serves no acceptance here."""
    return room.room_results(small(runs=6, tags=1, room_particles=200))


def averages(results, task, method):
    outcome = next(o for o in results.outcomes if (o.task, o.method) == (task, method))
    return outcome.measures()["average_m"]


def test_the_particle_filter_keeps_the_lemniscate_in_the_concrete_room(in_the_room):
    best = averages(in_the_room, "9 tags", room.PARTICLE)
    assert np.median(best) <= 0.15
    assert np.median(averages(in_the_room, "9 tags", room.DEAD)) > 2.0 * np.median(best)


def test_one_tag_is_worse_than_nine(in_the_room):
    one = averages(in_the_room, "1 tags", room.PARTICLE)
    assert np.median(one) > np.median(averages(in_the_room, "9 tags", room.PARTICLE))


def test_the_true_field_is_coherent_and_finer_than_the_map(in_the_room):
    assert in_the_room.map_dbm.shape[0] == len(in_the_room.map_x_m)
    assert np.std(in_the_room.map_dbm) > 2.0
    assert "rms" in in_the_room.facts[0]
    assert in_the_room.facts[1].startswith("9 tags, particle filter, computed map: 6 of 6 runs")


def test_feedback_outcomes_do_not_depend_on_the_number_of_runs():
    few, more = (
        chapters.feedback_outcomes(small(runs=runs, training_iterations=40, training_records=2))
        for runs in (1, 2)
    )
    assert len(few) == len(more) == 7
    for one, other in zip(few, more, strict=True):
        assert (one.poses[0] == other.poses[0]).all()


def test_the_cost_table_has_every_controller_and_positive_times(monkeypatch):
    monkeypatch.setattr("octant.reader_design.experiments.tracking.costs.TIMED_S", 1e-4)
    settings = small(training_iterations=10)
    rows = cost_rows(settings, ())
    assert len(rows) == 5
    assert all(row.step_us > 0.0 for row in rows)
    assert [row.knows_tags for row in rows] == [False, False, True, True, True]


def test_a_scaling_knows_its_exponent():
    scaling = CostScaling(
        what="x", quantity="n", sizes=(1, 2, 4), times_us={"square": (1.0, 4.0, 16.0)}
    )
    assert scaling.exponent("square") == pytest.approx(2.0)


def test_an_empty_study_has_no_figures():
    empty = TrackingContent(
        settings=small(),
        fits=None,
        feedback=(),
        nominal=(),
        neighbouring=None,
        slam=(),
        room=None,
        costs=(),
        scalings=(),
        study_toml="",
    )
    assert list(tracking_figures(empty)) == []
    assert empty.outcomes == ()
