"""Further chapters of the tracking study: long drives, points, laws on line, and so on."""

import math
from dataclasses import replace

import numpy as np
import pytest

from octant.geometries.errors import ConfigError, NavigationError
from octant.navigation.tracking import shapes
from octant.reader_design.experiments.tracking import (
    chapters,
    frames,
    horizons,
    laboratory,
    law_on_line,
    long_drives,
    reader_part,
    slam_line,
    stabilisation,
)
from octant.reader_design.experiments.tracking.parts import Part
from octant.reader_design.experiments.tracking.settings import settings_of
from octant.reader_design.study_file.loading import parse_study

ROOM = '[room]\nbox_m = [12.0, 12.0, 3.0]\norigin_m = [-6.0, -6.0, 0.0]\nmaterial = "concrete"\n'
POINT = """
[[track.trajectory]]
name = "my point"
shape = "point"
waypoints_m = [[3.0, 8.0]]
start_m = [0.0, 0.0]
start_heading_deg = 28.6
goal_heading_deg = 90.0
state_weight = [0.01, 0.01, 0.01]
final_weight = [2.0, 2.0, 2.0]
"""


def of(tmp_path, track="", tables=""):
    text = f"{ROOM}[track]\n{track}{tables}"
    return settings_of(parse_study(text, source="test", directory=tmp_path))


def rows_by(columns, record):
    return [dict(zip(columns, row, strict=True)) for row in record.rows]


# Goal heading and weights of one's own ------------------------------------------------------------


@pytest.mark.slow
def test_a_point_of_ones_own_with_the_thesis_values_is_the_thesis_point(tmp_path):
    settings = of(tmp_path, "runs = 2\n", POINT)
    mine, _ = chapters.neighbouring_runs(settings, "my point")
    thesis, _ = chapters.neighbouring_runs(settings, "point")
    assert (mine[0].runs.poses == thesis[0].runs.poses).all()
    assert mine[0].runs.desired.poses[-1, 2] == pytest.approx(math.pi / 2)


def test_a_goal_heading_without_a_point_is_refused(tmp_path):
    with pytest.raises(ConfigError, match="only a 'point' has a goal heading"):
        of(tmp_path, "", POINT.replace('"point"\nw', '"line"\nw').replace("8.0]]", "8.0], [0, 0]]"))


# Long drives --------------------------------------------------------------------------------------


def test_a_repeated_curve_is_itself_again_and_an_open_one_is_refused():
    lap = shapes.lemniscate()
    once = replace(lap, motion=lambda t: lap.motion(np.minimum(t, 60.0)))
    thrice = shapes.repeated(once, 3)
    times = np.linspace(0.0, 59.9, 50)
    assert thrice.motion(times + 120.0) == pytest.approx(once.motion(times), abs=1e-12)
    with pytest.raises(NavigationError, match="closed curve"):
        shapes.repeated(shapes.sine(), 2)


def test_the_trend_is_the_slope_of_a_line_and_its_error_that_of_regression():
    from scipy.stats import linregress

    rng = np.random.default_rng(1)
    laps = 0.1 + 0.002 * np.arange(9) + rng.normal(0.0, 0.01, 9)
    errors = np.concatenate([[5.0], laps])[None]
    found = linregress(30.0 * np.arange(9) / 100.0, 1000.0 * laps)
    assert long_drives.trend(errors, 30.0) == pytest.approx((found.slope, found.stderr))
    many = np.array([np.concatenate([[5.0], 0.1 + k * np.arange(4)]) for k in (0.001, 0.003)])
    assert long_drives.trend(many, 100.0) == pytest.approx((2.0, 1.0))


@pytest.mark.slow
def test_the_error_does_not_accumulate_with_tags_but_without_them(tmp_path):
    settings = of(tmp_path, "runs = 20\nlong_laps = 4\n")
    tags, dead = (
        long_drives.trend_rows(
            settings,
            [(part, long_drives.compute(settings, part))],
        )[0]
        for part in (
            Part(chapter="long", task="lemniscate", method=m)
            for m in (chapters.EKF, long_drives.DEAD)
        )
    )
    assert abs(tags[4]) < 10.0
    assert dead[4] > 100.0


# A point held by measurement feedback -------------------------------------------------------------


@pytest.mark.slow
def test_measurement_feedback_holds_a_point_and_costs_no_less_than_the_best_inputs(tmp_path):
    settings = of(tmp_path, "runs = 1\ntraining_iterations = 16000\n")
    record = stabilisation.compute(settings, Part(chapter="stabilisation", task="point"))
    replayed, fresh, best = rows_by(stabilisation.COLUMNS, record)
    assert replayed["final_m_median"] < 0.01
    assert replayed["final_heading_deg_median"] < 0.5
    assert best["cost_median"] <= replayed["cost_median"] < 1.01 * best["cost_median"]
    assert fresh["final_m_median"] > 0.1


# The law, on line and from samples ----------------------------------------------------------------


def test_the_law_of_two_samples_is_exact(tmp_path):
    """The closed form: beta = ln(r2 / r1) / (d2 - d1), alpha = r1 exp(-beta d1)."""
    (tmp_path / "samples.csv").write_text("distance_m,rss_dbm\n1.0,-40\n3.0,-60\n")
    settings = of(tmp_path, 'rss_samples = "samples.csv"\n')
    beta = math.log(60.0 / 40.0) / 2.0
    assert settings.law.beta_per_m == pytest.approx(beta, abs=1e-8)
    assert settings.law.alpha_dbm == pytest.approx(-40.0 * math.exp(-beta), abs=1e-6)
    fits = chapters.fit_samples(settings)
    assert fits.rss_dbm.tolist() == [-40.0, -60.0]
    assert fits.exponential_rms_db == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("text", "keys", "match"),
    [
        ("distance_m,rss_dbm\n1.0,-40\n3.0,-60\n", "alpha_dbm = -50.0\n", "give one of them"),
        ("distance_m,rss_dbm\n1.0,-40\n", "", "at least two"),
        ("distance_m,rss_dbm\n-1.0,-40\n2,-50\n", "", "above 0 m"),
        ("distance_m,rss\n1.0,-40\n", "", "no column 'rss_dbm'"),
        ("distance_m,rss_dbm\n1.0,loud\n", "", "samples.csv:2: rss_dbm is 'loud'"),
    ],
)
def test_samples_that_cannot_be_fitted_are_refused(tmp_path, text, keys, match):
    (tmp_path / "samples.csv").write_text(text)
    with pytest.raises(ConfigError, match=match):
        of(tmp_path, 'rss_samples = "samples.csv"\n' + keys)


def test_the_law_is_found_while_driving_and_serves_as_well_as_the_known_one(tmp_path):
    settings = of(tmp_path, "runs = 8\n")
    known, fitted, guessed = (
        rows_by(law_on_line.COLUMNS, law_on_line.compute(settings, part))[0]
        for part in law_on_line.parts(settings)
    )
    assert fitted["average_m_median"] < 1.15 * known["average_m_median"]
    assert guessed["average_m_median"] > 5.0 * known["average_m_median"]
    assert fitted["alpha_dbm_median"] == pytest.approx(settings.law.alpha_dbm, rel=0.1)
    assert fitted["beta_per_m_median"] == pytest.approx(settings.law.beta_per_m, rel=0.05)


# Receding horizon ---------------------------------------------------------------------------------


def test_on_the_circle_a_receding_horizon_keeps_the_closed_form_wheel_rates(tmp_path):
    """v = 2 pi R / t, and the wheels turn with v (1 +- l / 2R) / r."""
    settings = of(tmp_path, "circle_radius_m = 1.5\ncircle_duration_s = 30.0\nhorizon = 15\n")
    curve = horizons._tasks(settings)["circle"].curve
    setup = chapters.neighbouring_setup(settings, curve, (1.5, 0.0, math.pi / 2))
    control = chapters.predictive_control(settings, setup)
    robot, speed = settings.robot, 2.0 * math.pi * 1.5 / 30.0
    share = 0.5 * robot.axle_length_m / 1.5
    wanted = speed / robot.wheel_radius_m * np.array([1.0 + share, 1.0 - share])
    for step in (0, 100, 200):
        pose = setup.desired.poses[step : step + 1].copy()
        rates = control.wheel_rates(step, pose, np.zeros((1, 1)))[0]
        assert rates == pytest.approx(wanted, rel=0.02)


def test_the_time_to_converge_is_the_first_within_a_decimetre():
    errors = np.array([[0.5, 0.2, 0.05, 0.3], [0.5, 0.5, 0.4, 0.2]])
    assert horizons.converged_s(errors, 0.5).tolist() == [1.0, 1.5]


def test_a_longer_horizon_is_better_and_none_converges_before_the_neighbouring_control(tmp_path):
    settings = of(tmp_path, "runs = 10\nhorizons = [5, 40]\n")
    ours, short, long = (
        rows_by(horizons.COLUMNS, horizons.compute(settings, part))[0]
        for part in horizons.parts(settings)
        if part.task == "lemniscate"
    )
    assert short["horizon_s"] == pytest.approx(0.5)
    assert ours["converged_s_median"] <= long["converged_s_median"] < short["converged_s_median"]
    assert ours["average_m_median"] < long["average_m_median"] < short["average_m_median"]


# SLAM beside the filter on RSS --------------------------------------------------------------------


def test_slam_and_the_filter_on_rss_estimate_the_same_drives(tmp_path):
    settings = of(tmp_path, "slam_runs = 20\n")
    record = slam_line.compute(settings, Part(chapter="slam line", sigma=0.1))
    slam, rss, dead = rows_by(slam_line.COLUMNS, record)
    assert dead["final_m_median"] == pytest.approx(np.median(record.slam.reckoned_error_m))
    assert slam["final_m_median"] == pytest.approx(np.median(record.slam.final_error_m))
    clear = of(tmp_path, "slam_runs = 20\nrss_sigma_db = 0.5\n")
    rss_clear = rows_by(slam_line.COLUMNS, slam_line.compute(clear, Part(chapter="", sigma=0.1)))[1]
    assert rss_clear["final_m_median"] < 0.02 < rss["final_m_median"]
    assert rss_clear["second_half_over_first"] < 1.5 < dead["second_half_over_first"]


# The experiments of 7.6 ---------------------------------------------------------------------------


def test_the_u_of_the_thesis_has_its_legs_and_the_sputnik_its_axle(tmp_path):
    one = laboratory.EXPERIMENTS["u-shape (7.6.2)"]
    place, velocity, _ = one.curve.motion(np.array([0.0, one.curve.duration_s]))
    corner_m = 0.5 * (2.0 - math.pi / 2.0) * 2.0  # two corners of 0.5 m, cut short
    length = np.hypot(*velocity[0]) * one.curve.duration_s
    assert length == pytest.approx(16.5 - corner_m)
    assert place[0] == pytest.approx([0.0, 0.0])
    assert place[1] == pytest.approx([-4.0, 2.5])
    assert velocity[0] / np.hypot(*velocity[0]) == pytest.approx([0.0, 1.0], abs=1e-12)
    there = laboratory.in_the_laboratory(of(tmp_path, "laboratory_wheel_scale = 0.03\n"), one)
    assert there.robot.axle_length_m == 0.26
    assert there.mesh.tags_m.tolist() == [list(tag) for tag in laboratory.U_TAGS_M]
    assert there.world(there.mesh, tags_m=there.mesh.tags_m).rolling.scale_sd == 0.03


@pytest.mark.slow
def test_the_experiments_end_about_as_far_off_as_the_thesis_reports(tmp_path):
    settings = of(tmp_path, "runs = 20\n")
    rows = [
        rows_by(laboratory.COLUMNS, laboratory.compute(settings, part))[0]
        for part in laboratory.parts(settings)
    ]
    found = {(row["experiment"][:4], row["method"]): row for row in rows}
    for name, published_m in (("line", 0.13), ("u-sh", 0.5), ("poin", 0.2)):
        final = found[name, chapters.EKF]["final_m_median"]
        assert 0.5 * published_m < final < 1.5 * published_m
        assert found[name, laboratory.WITHOUT]["final_m_median"] > 1.3 * final
    u = found["u-sh", chapters.EKF]
    assert 0.08 < u["first_leg_m_median"] < 0.25
    assert found["u-sh", laboratory.SLIDING]["average_m_median"] < 2.0 * u["average_m_median"]


# RSS measured by the tags -------------------------------------------------------------------------


def test_fine_codes_cost_nothing_cut_ones_much_and_a_quick_channel_is_none(tmp_path):
    settings = of(tmp_path, "runs = 4\nframe_bit_rates_hz = [9600.0, 600.0]\n")
    records = [frames.compute(settings, part) for part in frames.parts(settings)]
    exact, cut, fine, quick, slow = (rows_by(frames.COLUMNS, record)[0] for record in records)
    assert fine["average_m_median"] == pytest.approx(exact["average_m_median"], rel=0.05)
    assert cut["average_m_median"] > 10.0 * exact["average_m_median"]
    assert quick["round_s"] == pytest.approx((16 + 25 * 24) / 9600.0)
    assert quick["round_s"] < settings.track.period_s
    poses = [record.outcomes[0].runs.poses for record in records]
    assert (poses[3] == poses[2]).all()
    assert slow["average_m_median"] > 1.3 * fine["average_m_median"]


# The designed reader in the room ------------------------------------------------------------------

READER = """
runs = 2
training_iterations = 20
training_records = 2
room_reading_every_s = 2.0
reader_map_spacing_m = 0.4
chapters = ["reader"]
[reader]
response = "isolated"
[solver]
max_reflections = 1
[[tag]]
id = "a"
position_m = [2.0, 2.0, 2.9]
antenna = "patch"
[[tag]]
id = "b"
position_m = [-2.0, 0.5, 2.9]
antenna = "patch"
"""


def by_method(settings):
    records = [reader_part.compute(settings, part) for part in reader_part.parts(settings)]
    assert any("isolated antennas" in note for note in records[0].notes)
    return {o.method: o.runs for record in records for o in record.outcomes}


@pytest.mark.slow
def test_what_the_device_does_not_hear_leaves_dead_reckoning(tmp_path):
    """[sensor] is obeyed: a deaf reader tells no filter anything, and u = K z stands still."""
    runs = by_method(of(tmp_path, READER, "[sensor]\nsensitivity_dbm = 60.0\n"))
    assert len(runs) == 11
    dead = runs.pop("neighbouring, dead reckoning").poses
    still = runs.pop("measurement feedback").wheel_rates
    assert not still.any()
    for name in ("EKF, law", "UKF, map", "fingerprints", "EKF SLAM"):
        assert runs[f"neighbouring + {name}"].poses == pytest.approx(dead, abs=1e-9), name


@pytest.mark.slow
def test_every_method_reads_the_designed_reader_and_coarse_codes_are_heeded(tmp_path):
    exact, coarse = (
        by_method(of(tmp_path, READER, table)) for table in ("", "[sensor]\nbits = 2\n")
    )
    dead = exact["neighbouring, dead reckoning"].poses
    for name, runs in exact.items():
        if "dead" not in name:
            assert not np.allclose(runs.poses, dead, atol=1e-3), name
            assert not (runs.poses == coarse[name].poses).all(), name


def test_the_time_from_antenna_to_antenna_is_the_readers_alone(tmp_path):
    with pytest.raises(ConfigError, match=r"track\.room_reading_every_s is 2 s"):
        of(tmp_path, READER, "[sensor]\ndwell_s = 0.5\n")
    assert of(tmp_path, READER, "[sensor]\ndwell_s = 0.01\n").study.sensor.dwell_s == 0.01
    with pytest.raises(ConfigError, match="reads one antenna"):
        of(tmp_path, 'chapters = ["law"]\n', "[sensor]\ndwell_s = 0.01\n")


def test_the_studys_own_trajectories_are_in_the_chapters_that_follow_some(tmp_path):
    own = (
        '[[track.trajectory]]\nname = "loop"\nshape = "ellipse"\nduration_s = 60.0\n'
        "state_weight = [2.0, 2.0, 1.0]\n"
    )
    settings = of(tmp_path, "runs = 1\nhorizons = [5]\n", own)
    for chapter in (horizons, law_on_line, long_drives):
        assert "loop" in {part.task for part in chapter.parts(settings)}
    part = next(part for part in horizons.parts(settings) if part.task == "loop")
    (row,) = rows_by(horizons.COLUMNS, horizons.compute(settings, part))
    assert row["average_m_median"] < 0.3
    plain = of(tmp_path, "runs = 1\n", own.replace("state_weight = [2.0, 2.0, 1.0]\n", ""))
    (other,) = rows_by(horizons.COLUMNS, horizons.compute(plain, part))
    assert other["average_m_median"] != row["average_m_median"]
