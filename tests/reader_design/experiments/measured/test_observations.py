"""Local means, also where readings were not heard; laws of distance; what is left of them."""

import numpy as np
import pytest
from measured_room import log_of, some_poses
from scipy.optimize import minimize_scalar
from scipy.stats import norm

from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene
from octant.navigation.logs.cells import local_means
from octant.reader_design.experiments.measured.agreement import agreement, pooled_sd_db
from octant.reader_design.experiments.measured.baselines import baselines, walls_crossed
from octant.reader_design.experiments.measured.observations import censored_means, observed
from octant.reader_design.experiments.measured.predict import Rows


def rows_of(log):
    """Rows as if each reading had a prediction of its own."""
    n = len(log)
    return Rows(log=log, tags=tuple(range(len(log.ids))), group=np.arange(n), poses=log.poses)


def test_censored_means_have_the_greatest_likelihood():
    rng = np.random.default_rng(2)
    threshold, scatter = -80.0, 4.0
    level = rng.normal(-81.0, scatter, (30, 12))
    heard = level >= threshold
    count = heard.sum(axis=1)
    mean = np.where(heard, level, 0.0).sum(axis=1) / count
    got = censored_means(mean, count, 12 - count, threshold, scatter)
    for i in range(30):

        def unlikely(m, i=i):
            some = norm.logpdf(level[i][heard[i]], m, scatter).sum()
            return -some - (12 - count[i]) * norm.logcdf(threshold, m, scatter)

        best = minimize_scalar(
            unlikely, bounds=(-110.0, -60.0), method="bounded", options={"xatol": 1e-9}
        )
        assert got[i] == pytest.approx(best.x, abs=1e-5)
    # The mean of what was heard alone lies far too high; this one does not.
    assert mean.mean() > -78.5
    assert got.mean() == pytest.approx(-81.0, abs=0.6)


def test_without_anything_censored_means_are_those_of_the_log():
    poses = some_poses(300)
    level = np.random.default_rng(4).normal(-60.0, 3.0, (len(poses), 4))
    log = log_of(level, poses)
    got = observed(rows_of(log), cell_m=0.5, least=5)
    want, _ = local_means(log, cell_m=0.5, least=5)
    assert np.array_equal(got.sources, want.sources)
    np.testing.assert_allclose(got.level_dbm, want.mean_dbm, rtol=1e-12)
    assert got.scatter_db == pytest.approx(3.0, rel=0.06)


def test_not_heard_counts_only_where_a_threshold_is_known():
    poses = some_poses(300)
    level = np.random.default_rng(4).normal(-78.0, 4.0, (len(poses), 4))
    unknown = observed(rows_of(log_of(level, poses, hide_below=-80.0)))
    known = observed(rows_of(log_of(level, poses, hide_below=-80.0, threshold_dbm=-80.0)))
    assert unknown.censored.sum() == 0
    assert known.censored.sum() > 100
    assert np.nanmean(unknown.level_dbm) > -76.5
    # Scatter of what was heard is too small, so that a part of the bias stays.
    assert np.nanmean(known.level_dbm) == pytest.approx(-78.0, abs=0.9)


def test_walls_are_counted_once_whatever_their_triangles():
    scene = build_scene(box_room((4.0, 3.0, 2.5), material="concrete"))
    starts = np.tile([2.0, 1.5, 1.25], (3, 1))
    ends = np.array([(6.0, 1.5, 1.25), (2.0, 1.5, 5.0), (3.0, 1.5, 1.25)])
    # Through the middle of a wall, where its two triangles meet; through the ceiling; inside.
    assert walls_crossed(scene, starts, ends).tolist() == [1, 0, 0]


def test_laws_give_back_the_numbers_that_levels_were_made_of():
    rng = np.random.default_rng(3)
    sources = np.repeat(np.arange(4), 60)
    distance = rng.uniform(1.0, 9.0, 240)
    walls = rng.integers(0, 4, 240)
    exponent = np.array([1.8, 2.2, 2.0, 2.6])[sources]
    exact = -40.0 - 3.0 * sources - 10.0 * exponent * np.log10(distance) - 4.5 * walls
    level = exact + rng.normal(0.0, 2.0, 240)
    laws = {law.name: law for law in baselines(level, sources, distance, walls)}
    own = laws["multi-wall (COST 231), own exponent"]
    assert own.sd_db == pytest.approx(2.0, rel=0.1)
    assert laws["log-distance, own exponent"].sd_db > 4.0
    assert baselines(exact, sources, distance, walls)[2].sd_db < 1e-9
    # The wall's loss comes from the other sources: a source with another loss does not hide it.
    odd = exact - np.where(sources == 0, 10.0, 0.0) * walls
    held = baselines(odd, sources, distance, walls)[2].residual_db
    assert np.std(held[sources == 0]) > 5.0


def test_agreement_is_that_of_numpy_and_its_intervals_hold_it():
    rng = np.random.default_rng(2)
    predicted = rng.normal(-60.0, 8.0, 200)
    measured = predicted + 3.0 + rng.normal(0.0, 2.0, 200)
    got = agreement("x", measured, np.append(predicted[:-1], np.nan))
    difference = (measured - predicted)[:-1]
    assert got.count == 199
    assert got.bias_db.value == pytest.approx(difference.mean())
    assert got.sd_db.value == pytest.approx(difference.std(ddof=1))
    assert got.correlation.value == pytest.approx(np.corrcoef(measured[:-1], predicted[:-1])[0, 1])
    assert got.bias_db.low < 3.0 < got.bias_db.high
    assert got.sd_db.low < 2.0 < got.sd_db.high
    assert np.isnan(agreement("one", measured[:1], predicted[:1]).sd_db.value)


def test_pooled_scatter_leaves_out_each_groups_mean():
    residual = np.array([1.0, -1.0, 11.0, 9.0, np.nan])
    assert pooled_sd_db(residual, np.array([0, 0, 1, 1, 1])) == pytest.approx(1.0)
