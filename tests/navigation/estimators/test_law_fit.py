"""Alpha and beta as states of a filter: where the pose is known, they are the least-squares fit."""

import numpy as np
import pytest

from octant.navigation.estimators.law_fit import LawFittingKalman
from octant.navigation.estimators.pose_filters import WheelMotion
from octant.navigation.estimators.rss_kalman import RssAssumptions
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.sensing.rss_models import (
    LogExponentialLaw,
    TagMesh,
    fit_log_exponential,
    tag_grid,
)
from octant.navigation.sensing.tag_layouts import tag_distances_m

TAGS = tag_grid(3, spacing_m=3.0, height_m=3.0)
LAW = LogExponentialLaw(alpha_dbm=-45.0, beta_per_m=0.15)


@pytest.mark.parametrize("mean_sigma_db", [0.0, 20.0])
def test_with_a_known_pose_the_filter_is_the_batch_least_squares(mean_sigma_db):
    """Wheels that hardly slip on a line from a known start: only alpha and beta are unknown."""
    motion = WheelMotion(robot=DifferentialDrive(), period_s=0.1, rate_sigma_rad_per_s=1e-6)
    rng, rates = np.random.default_rng(1), np.full((1, 2), 3.0)
    sigma_db, mean_db = 4.0, 7.0 if mean_sigma_db else 0.0
    estimator = LawFittingKalman(
        motion=motion,
        noise=RssAssumptions(sigma_db=sigma_db, mean_sigma_db=mean_sigma_db),
        tags_m=TAGS,
        guess=LogExponentialLaw(alpha_dbm=-35.5, beta_per_m=0.1071),
        alpha_sigma_dbm=1000.0,
        beta_sigma_per_m=0.1,
    )
    pose = np.array([[-3.0, -2.0, 0.5]])
    belief = estimator.begin(pose, 1e-12 * np.eye(3), [rng])
    distances, readings = [], []
    for _ in range(150):
        pose = motion.moved(pose, rates)
        distance = tag_distances_m(pose, TAGS)
        rss = TagMesh(tags_m=TAGS, law=LAW).rss_dbm(pose[:, :2]) + mean_db
        rss = rss + rng.normal(0.0, sigma_db, rss.shape)
        distances.append(distance[0])
        readings.append(rss[0])
        belief = estimator.step(belief, rates, rss, [rng])
    fit, _ = fit_log_exponential(np.concatenate(distances), np.concatenate(readings) - mean_db)
    alpha, beta = belief.mean[0, 3:5]
    spread = np.sqrt(np.diagonal(belief.covariance[0]))[3:5]
    if mean_sigma_db:
        assert belief.mean[0, 5] == pytest.approx(mean_db, abs=3.0)
        assert abs(alpha - LAW.alpha_dbm) < 3.0 * spread[0]
        assert abs(beta - LAW.beta_per_m) < 3.0 * spread[1]
    else:
        assert abs(alpha - fit.alpha_dbm) < 0.3 * spread[0]
        assert abs(beta - fit.beta_per_m) < 0.3 * spread[1]
        assert alpha == pytest.approx(LAW.alpha_dbm, rel=0.02)
