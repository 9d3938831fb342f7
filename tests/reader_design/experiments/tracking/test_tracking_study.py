"""The tracking study's parts: the room solver's, chapter 6's, and Table 8.1, on small settings."""

import msgspec
import numpy as np
import pytest

from octant.reader_design.experiments.tracking import chapters, compute, room
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
    settings = small(runs=6, tags=1, room_particles=200)
    return [room.room_runs(settings, mesh) for mesh in room.MESHES]


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


def test_a_scaling_knows_its_exponent():
    scaling = CostScaling(
        what="x", quantity="n", sizes=(1, 2, 4), times_us={"square": (1.0, 4.0, 16.0)}
    )
    assert scaling.exponent("square") == pytest.approx(2.0)


def test_an_empty_study_has_no_figures():
    empty = compute.TrackingContent(settings=small(), study_toml="")
    assert list(tracking_figures(empty)) == []
    assert empty.outcomes == ()
