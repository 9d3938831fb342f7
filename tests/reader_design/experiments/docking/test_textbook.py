"""Tables of what the textbook and the docking paper derive, and the keys that lead to them."""

import math
from pathlib import Path

import numpy as np
import pytest

from octant.reader_design.experiments.docking.compute import (
    dock_table,
    docking_job,
    docking_task,
)
from octant.reader_design.experiments.docking.page import wrong_start_lines
from octant.reader_design.experiments.docking.published import published_job, regulator_loops
from octant.reader_design.experiments.docking.textbook import (
    half_circle,
    observability_rows,
    odometry_error_m,
    odometry_rows,
    regulator_rows,
)
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import parse_study

TEXT = """
[room]
free_space = true
[[tag]]
id = "a"
position_m = [4.0, 2.0, 3.0]
antenna = "dipole"
[reader]
response = "isolated"
[dock]
tag = "a"
landmark_position_m = [6.0, 2.0, 0.6]
{}
"""


def study_of(keys=""):
    return parse_study(TEXT.format(keys), source="test", directory=Path())


TABLE = dock_table(study_of())


@pytest.mark.parametrize("steps", [4, 31])
def test_odometrys_error_of_half_a_circle_is_that_of_its_polygon(steps):
    speed, rate, time_s = half_circle(TABLE)
    turn, chord = math.pi / steps, speed * time_s / steps
    end = 2j * speed / rate
    for method, first in (("euler", chord), ("rk2", chord * np.exp(0.5j * turn))):
        polygon = first * (1.0 - np.exp(1j * math.pi)) / (1.0 - np.exp(1j * turn))
        error = odometry_error_m(TABLE, method, time_s / steps * (1.0 + 1e-12))
        assert error == pytest.approx(abs(polygon - end), rel=1e-6)
    for method in ("exact", None):
        assert odometry_error_m(TABLE, method, time_s / steps) < 1e-12


def test_the_tables_show_the_orders_of_the_steps_and_the_ranks():
    euler, runge_kutta, exact, chained = odometry_rows(TABLE)
    assert float(euler[3]) / float(euler[1]) == pytest.approx(10.0, rel=0.1)  # T
    assert float(runge_kutta[3]) / float(runge_kutta[1]) == pytest.approx(100.0, rel=0.1)  # T²
    assert max(float(row[k]) for row in (exact, chained) for k in (1, 2, 3)) < 1e-13
    attitude, straight, *_ = observability_rows(TABLE)
    assert (attitude[1], straight[1]) == ("2 of 2", "3 of 3")
    # √(12 R T/t³) with R = 0.01 m², T = 0.1 s.
    assert straight[2] == f"{math.sqrt(12.0 * 0.01 * 0.1):.2g} m/s"


def test_regulators_from_own_starts_turn_back_once_at_most_and_end_forward():
    keys = (
        "[dock.regulation]\nstarts = [[-3.0, 2.0, 90.0], [0.5, -2.0, 180.0], [2.0, 0.3, 0.0]]\n"
        "posture_k3 = 2.0\nduration_s = 20.0"
    )
    loops = regulator_loops(dock_table(study_of(keys)).regulation)
    rows = regulator_rows(loops)
    assert len(rows) == 9
    assert [row[1] for row in rows[:3]] == [
        "(-3, 2) m, 90°",
        "(0.5, -2) m, 180°",
        "(2, 0.3) m, 0°",
    ]
    for law, _, distance, heading, inversions, ends in rows:
        assert float(distance) < 1e-3, law
        assert int(inversions) <= 1
        assert ends == "forward"
        if "posture" in law:
            assert abs(float(heading)) < 0.1
    posture = loops["posture regulator (Fig. 11.20)"][0]
    e, alpha, phi = posture.polar[0]
    wanted = 2.5 * alpha + math.cos(alpha) * math.sin(alpha) / alpha * (alpha + 2.0 * phi)
    assert posture.twist[0] == pytest.approx([e * math.cos(alpha), wanted])


@pytest.mark.filterwarnings("ignore::octant.geometries.errors.PhysicsWarning")
def test_the_report_says_how_runs_from_a_wrong_estimate_ended():
    keys = "start_error_m = [1.0, -0.5]\nfalse_probability = 0.0"
    setting = build_setting(study_of(keys)).solved()
    job = docking_job(setting)
    closed = published_job(job.task, job.setting, compensate_slips=True)
    runs = [closed(seed) for seed in np.random.SeedSequence(2).spawn(2)]
    (text,) = wrong_start_lines(runs)
    assert "off by (1, -0.5) m and 0 degrees" in text
    assert "2 of 2 runs docked, of the others 0 of 0" in text
    plain = published_job(docking_task(study_of()), job.setting, compensate_slips=True)
    assert wrong_start_lines([plain(np.random.SeedSequence(1))]) == ()


@pytest.mark.filterwarnings("ignore::octant.geometries.errors.PhysicsWarning")
def test_keys_of_the_dock_reach_the_task():
    keys = 'approach = "reverse"\nstart_error_m = [1.0, -0.5]\nstart_error_deg = 90.0'
    job = docking_job(build_setting(study_of(keys)).solved())
    assert job.task.goal == pytest.approx([5.5, 2.0, math.pi])
    assert job.task.fine.start_error == pytest.approx((1.0, -0.5, math.pi / 2))
    camera = job.setting.camera
    assert camera.yaw_rad == pytest.approx(0.216 + math.pi)
    assert camera.position_m == pytest.approx([-0.09, -0.03, 0.775])
