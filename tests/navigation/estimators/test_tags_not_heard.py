"""A tag that is not heard counts for nothing: estimators are as if it were not there."""

import numpy as np
import pytest

from octant.navigation.estimators.fingerprint import FingerprintFilter
from octant.navigation.estimators.particle import ParticleFilter
from octant.navigation.estimators.pose_filters import WheelMotion
from octant.navigation.estimators.rss_kalman import (
    ExtendedKalman,
    KalmanBucy,
    RssAssumptions,
    UnscentedKalman,
)
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.sensing.rss_maps import RssMap
from octant.navigation.sensing.rss_models import LogExponentialLaw, TagMesh, tag_grid

MOTION = WheelMotion(robot=DifferentialDrive(), period_s=0.1, rate_sigma_rad_per_s=0.1)
TAGS = tag_grid(3, spacing_m=3.0, height_m=3.0)
LOST = np.array([0, 4, 7])


def mesh(tags):
    return TagMesh(tags_m=tags, law=LogExponentialLaw())


def survey(tags):
    axis = np.linspace(-2.0, 2.0, 41)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    rss = mesh(tags).rss_dbm(np.column_stack([x.ravel(), y.ravel()]))
    return RssMap(x_m=axis, y_m=axis, rss=rss.reshape(41, 41, -1))


def of(kind, tags):
    noise = RssAssumptions(sigma_db=20.0)
    if kind is ParticleFilter:
        return kind(motion=MOTION, sensor=mesh(tags), sigma_db=20.0)
    if kind is FingerprintFilter:
        return kind(motion=MOTION, survey=survey(tags), sigma_m=0.5)
    return kind(motion=MOTION, sensor=mesh(tags), noise=noise)


def estimate(estimator, readings):
    rngs = [np.random.default_rng(1), np.random.default_rng(2)]
    poses = np.array([[0.3, -0.2, 0.4], [-1.0, 1.0, 2.0]])
    belief = estimator.begin(poses, np.diag([0.2, 0.2, 0.1]) ** 2, rngs)
    for reading in readings:
        belief = estimator.step(belief, np.full((2, 2), 2.0), reading, rngs)
    return estimator.poses(belief)


@pytest.mark.parametrize(
    "kind", [ExtendedKalman, UnscentedKalman, KalmanBucy, ParticleFilter, FingerprintFilter]
)
def test_tags_not_heard_are_as_if_they_were_not_there(kind):
    rng = np.random.default_rng(3)
    whole = [mesh(TAGS).rss_dbm(np.full((2, 2), 0.5)) + rng.normal(0, 20, (2, 9)) for _ in range(5)]
    holes = [reading.copy() for reading in whole]
    for reading in holes:
        reading[:, LOST] = np.nan
    fewer = [np.delete(reading, LOST, axis=1) for reading in whole]
    found = estimate(of(kind, TAGS), holes)
    assert found == pytest.approx(
        estimate(of(kind, np.delete(TAGS, LOST, axis=0)), fewer), abs=1e-9
    )
    assert not np.allclose(found, estimate(of(kind, TAGS), whole), atol=1e-4)


@pytest.mark.parametrize("kind", [ExtendedKalman, UnscentedKalman, FingerprintFilter])
def test_a_reading_in_which_no_tag_is_heard_is_none(kind):
    silent = [np.full((2, 9), np.nan)]
    assert estimate(of(kind, TAGS), silent) == pytest.approx(
        estimate(of(kind, TAGS), [None]), abs=1e-12
    )
