"""A calibration gives back what a log was made of, and refuses what the log cannot tell."""

from dataclasses import replace

import numpy as np
import pytest
from measured_room import (
    ANCHORS,
    log_of,
    measured_study,
    some_poses,
    study_text,
    truth_dbm,
)
from scipy.stats import norm

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.measured.calibrate import (
    Problem,
    Wanted,
    calibrated,
    values_of,
)
from octant.reader_design.experiments.measured.calibrate_fit import fit
from octant.reader_design.experiments.measured.calibrate_model import tilted
from octant.reader_design.experiments.measured.predict import Predictor
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import parse_study, to_toml

LEVELS = {"a": -3.0, "b": 1.5, "c": 0.0, "d": 4.0}
SIGMA, TILT = 0.06, (14.0, -9.0)
POSES = some_poses(500)
FADING_DB = 4.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("measured")


@pytest.fixture(scope="module")
def exact(folder):
    """Levels by the full solver of a flat whose wall and one antenna differ from the study."""
    true = measured_study(folder, sigma=SIGMA, axes={"a": tilted((0.0, 0.0, 1.0), *TILT)})
    return truth_dbm(true, POSES) + np.array(list(LEVELS.values()))


@pytest.fixture(scope="module")
def study(folder):
    return measured_study(folder)


def problem(study, level, names, **wanted):
    return Problem(study=study, log=log_of(level, POSES), wanted=Wanted(names=names, **wanted))


NAMES = ("level", "sigma:material", "tilt:a")


@pytest.fixture(scope="module")
def traced(study, exact):
    return problem(study, exact, NAMES).predictor


def whole_fit(one, predictor):
    """The fit of everything, with paths that are traced already."""
    vars(one)["predictor"] = predictor
    return fit(one.task, one.task.start(), np.ones(len(one.parameters), bool),
               np.ones(len(one.observations), bool))  # fmt: skip


def test_without_fading_values_come_back_as_they_were_put_in(study, exact, traced):
    one = problem(study, exact, NAMES)
    got = dict(
        zip(
            [p.name for p in one.parameters],
            values_of(one.parameters, whole_fit(one, traced)),
            strict=True,
        )
    )
    for name, level in LEVELS.items():
        assert got[f"level:{name}"].value == pytest.approx(level, abs=0.1)
    assert got["sigma:material"].value == pytest.approx(SIGMA, rel=0.02)
    assert got["tilt:a.x"].value == pytest.approx(TILT[0], abs=0.6)
    assert got["tilt:a.y"].value == pytest.approx(TILT[1], abs=0.6)


def covered(study, exact, traced, logs, seed):
    """Return in how many of some logs with fading each interval holds the truth."""
    want = {f"level:{k}": v for k, v in LEVELS.items()} | {
        "sigma:material": SIGMA,
        "tilt:a.x": TILT[0],
        "tilt:a.y": TILT[1],
    }
    rng = np.random.default_rng(seed)
    hits = dict.fromkeys(want, 0)
    for _ in range(logs):
        one = problem(study, exact + rng.normal(0.0, FADING_DB, exact.shape), NAMES)
        values = values_of(one.parameters, whole_fit(one, traced))
        for p, v in zip(one.parameters, values, strict=True):
            hits[p.name] += v.low <= want[p.name] <= v.high
    return hits


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say(study, exact, traced):
    hits = covered(study, exact, traced, 20, seed=3)
    for name, count in hits.items():
        assert count >= 15, name  # fewer come once in 3,000 times where 95 % hold
    assert sum(hits.values()) >= 0.9 * 20 * len(hits)


def test_a_run_holds_out_anchors_and_goes_on_where_it_stopped(study, exact, traced, tmp_path):
    level = exact + np.random.default_rng(8).normal(0.0, FADING_DB, exact.shape)
    names = ("level", "sigma:material")
    one = problem(study, level, names)
    vars(one)["predictor"] = traced
    found = calibrated(one, tmp_path, Progress())
    assert found.how == "anchors"
    assert found.folds == 4
    assert np.isfinite(found.held_out_db).all()
    assert found.held_out_sd_db < min(law.sd_db for law in found.baselines)
    assert found.held_out_sd_db < found.before_sd_db
    again = problem(study, level, names)
    vars(again)["predictor"] = traced
    files = {p: p.stat().st_mtime_ns for p in (tmp_path / "cases").glob("*.msgpack")}
    assert len(files) == 5
    repeated = calibrated(again, tmp_path, Progress())
    assert {p: p.stat().st_mtime_ns for p in files} == files
    assert np.array_equal(repeated.held_out_db, found.held_out_db)


def test_the_fitted_study_reads_back_and_explains_the_log(study, exact, traced, folder, tmp_path):
    one = problem(study, exact, ("level", "sigma:material", "tilt:a"))
    vars(one)["predictor"] = traced
    found = calibrated(one, tmp_path, Progress())
    text = to_toml(found.study)
    back = parse_study(text, source="fitted", directory=folder)
    assert back.calibration.level_db["d"] == pytest.approx(4.0, abs=0.1)
    assert back.room.objects[0].material.sigma_s_per_m == pytest.approx(SIGMA, rel=0.03)
    lifted = np.array([back.calibration.level_db[name] for name in ANCHORS])
    np.testing.assert_allclose(truth_dbm(back, POSES) + lifted, exact, atol=0.4)


def test_parameters_that_cannot_be_told_apart_are_refused_by_name(folder, tmp_path):
    # Straight paths only: none meets floor or ceiling, and each passes both walls, or none.
    second = """[[room.object]]
name = "second"
kind = "mesh"
file = "wall.obj"
unit = "m"
position_m = [0.05, 0.0, 0.0]
material = { eps_r = 2.8000001, sigma_s_per_m = 0.02, thickness_m = 0.1 }
"""
    text = study_text(folder, order=0, more=second)
    double = parse_study(text, source="test", directory=folder)
    level = truth_dbm(double, POSES) + np.random.default_rng(2).normal(0.0, 4.0, (len(POSES), 4))
    both = problem(double, level, ("level", "sigma:room.object[0].material", "sigma:second"))
    with pytest.raises(ConfigError) as said:
        calibrated(both, tmp_path, Progress())
    assert "cannot tell" in str(said.value)
    for name in ("sigma:second", "sigma:room.object[0].material"):
        assert name in str(said.value)
    floor = problem(double, level, ("level", "sigma:concrete"))
    with pytest.raises(ConfigError, match="next to nothing of sigma:concrete"):
        calibrated(floor, tmp_path, Progress())


def test_a_prior_tells_what_the_log_does_not(study, exact, traced):
    level = exact + np.random.default_rng(8).normal(0.0, FADING_DB, exact.shape)
    one = problem(
        study, level, ("level", "sigma:material"), priors={"sigma:material": (0.02, 0.0002)}
    )
    got = values_of(one.parameters, whole_fit(one, traced))[-1]
    assert got.value == pytest.approx(0.02, rel=0.03)


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (("levle",), "did you mean 'level'"),
        (("sigma:wals",), "has no material 'wals'"),
        (("tilt:z",), "no readings of a tag 'z'"),
        (("level", "level:a"), "names 'level:a' twice"),
        (("thickness:concrete",), "fills all behind its face"),
        (("antenna_level",), "has readings of 1"),
    ],
)
def test_names_that_mean_nothing_are_refused_with_what_does(study, exact, names, said):
    with pytest.raises(ConfigError, match=said):
        _ = problem(study, exact, names).parameters


def test_a_log_that_does_not_fit_the_study_is_refused(study, exact):
    stranger = replace(log_of(exact, POSES), ids=("a", "b", "c", "e"))
    with pytest.raises(
        ConfigError, match=r"readings of 'e', but the study has no such \[\[tag\]\]"
    ):
        _ = Problem(study=study, log=stranger, wanted=Wanted(names=NAMES)).rows
    log = log_of(exact, POSES + np.array([100.0, 0.0, 0.0]))
    with pytest.raises(ConfigError, match="inside the room, which spans"):
        _ = Problem(study=study, log=log, wanted=Wanted(names=NAMES)).rows
    with pytest.raises(ConfigError, match="log is empty"):
        _ = Problem(study=study, log=log_of(exact[:0], POSES[:0]), wanted=Wanted(names=NAMES)).rows
    numbered = replace(log_of(exact, POSES), antennas=np.full(exact.size, 99))
    with pytest.raises(ConfigError, match="antenna 99, but the study's reader has 8"):
        _ = Problem(study=study, log=numbered, wanted=Wanted(names=NAMES)).rows
    nowhere = log_of(exact, np.full_like(POSES, np.nan))
    with pytest.raises(ConfigError, match="no reading of the log has a known place"):
        _ = Problem(study=study, log=nowhere, wanted=Wanted(names=NAMES)).rows


def test_a_readers_antennas_are_compared_with_the_first(folder, tmp_path):
    reader = "response = 'isolated'\nground_plane_shape = 'round'\n"
    text = study_text(folder).replace("[reader]\n", f"[reader]\n{reader}")
    round_one = parse_study(text, source="test", directory=folder)
    setting = build_setting(round_one)
    poses = POSES[:150]
    shift = np.array([0.0, 1.0, -2.0, 0.5, 3.0, 0.0, -1.0, 2.0])
    power = [setting.link(tag).power(poses).local_mean_w for tag in setting.tags]
    level = 10.0 * np.log10(np.array(power)) + 30.0 + shift  # tag, pose, antenna
    m, n = len(poses), len(shift)
    plain = log_of(np.zeros((m * n, 4)), np.repeat(poses, n, axis=0))
    log = replace(
        plain,
        antennas=np.repeat(np.tile(np.arange(1, n + 1), m), 4),
        rss_dbm=np.moveaxis(level, 0, 2).reshape(-1),
    )
    one = Problem(
        study=round_one,
        log=log,
        wanted=Wanted(names=("level", "antenna_level"), cell_m=1.0, least=1, place_m=0.02),
    )
    found = calibrated(one, tmp_path, Progress())
    got = found.study.calibration.antenna_db
    np.testing.assert_allclose(got, shift, atol=0.02)
    assert found.held_out_sd_db < 0.1


def test_not_heard_keeps_a_level_from_looking_too_high(study, exact, traced):
    level = exact + np.random.default_rng(8).normal(0.0, FADING_DB, exact.shape)
    limit = float(np.quantile(level, 0.5))
    found = {}
    for threshold in (limit, None):
        log = log_of(level, POSES, threshold_dbm=threshold, hide_below=limit)
        one = Problem(study=study, log=log, wanted=Wanted(names=("level", "sigma:material")))
        vars(one)["predictor"] = Predictor(
            one.setting, one.rows, receiver=traced._receiver, progress=None
        )
        found[threshold] = [
            v.value for v in values_of(one.parameters, whole_fit(one, one.predictor))
        ]
    want = list(LEVELS.values())[1:]  # that of "a" is tilted
    error = {k: np.mean(np.array(v[1:4]) - want) for k, v in found.items()}
    assert abs(error[limit]) < 0.5
    assert error[None] > 0.3 + abs(error[limit]), error


def test_slopes_are_those_of_the_prediction(study, exact, traced):
    one = problem(study, exact, ("level:a", "diffuse:b", "sigma:material", "tilt:a"))
    vars(one)["predictor"] = traced
    theta = one.task.start()
    model = one.task.model
    slopes = model.slopes(theta, range(len(theta)))
    assert np.abs(slopes).max(axis=0).min() > 1e-3
    for k in range(len(theta)):
        step = np.zeros(len(theta))
        step[k] = 1e-3
        want = (model.local_means(theta + step) - model.local_means(theta - step)) / 2e-3
        np.testing.assert_allclose(slopes[:, k], want, atol=0.01 * np.abs(want).max())


def test_cells_without_a_heard_reading_count_by_their_likelihood(study, exact, traced):
    limit = float(np.quantile(exact, 0.5))
    log = log_of(exact, POSES, threshold_dbm=limit, hide_below=limit)
    one = Problem(study=study, log=log, wanted=Wanted(names=("level",)))
    vars(one)["predictor"] = traced
    silent = one.observations.heard == 0
    assert silent.sum() > 20
    predicted = np.linspace(limit - 9.0, limit + 9.0, len(silent))
    doubt = np.full(len(silent), 2.5)
    residual, slope = one.task.residuals(predicted, doubt)
    want = -2.0 * norm.logcdf((limit - predicted) / doubt)
    np.testing.assert_allclose(residual[silent] ** 2, want[silent], rtol=1e-9)
    up, down = (one.task.residuals(predicted + h, doubt)[0] for h in (1e-4, -1e-4))
    np.testing.assert_allclose(slope[silent], ((up - down) / 2e-4)[silent], rtol=1e-4, atol=1e-8)
    np.testing.assert_allclose(slope[~silent], -1.0 / 2.5)
