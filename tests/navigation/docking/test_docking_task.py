import pickle
from dataclasses import replace

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.medium.radio_scene import radio_scene
from octant.em.power.received_power import reader_link
from octant.em.reader.response import sector_response
from octant.em.search.candidates import SolverSettings
from octant.geometries.errors import NavigationError
from octant.geometries.furniture import box
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene, free_space_scene
from octant.navigation.control.docking_law import DockingLaw
from octant.navigation.docking.run import DockingJob, run_docking
from octant.navigation.docking.stages import DockingDrive
from octant.navigation.docking.task import CoarseStage, DockingSetting, DockingTask, FineStage
from octant.navigation.missions.batches import run_seeded
from octant.navigation.missions.starts import RandomStarts
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.floor import Floor, RobotSpace, WheelSlip, footprint
from octant.navigation.sensing.landmark_sensor import Landmark, LandmarkSensor
from octant.navigation.sensing.sensor import FieldSensor

AZIMUTHS = 2.0 * np.pi * np.arange(8) / 8
LANDMARK = Landmark(position_m=np.array([6.0, 2.5, 0.6]), heading_rad=0.0)
TASK = DockingTask(tag_id="dock", landmark=LANDMARK)
CAMERA = LandmarkSensor(detection_probability=0.95, false_probability=0.02)
REVERSE = replace(TASK, fine=FineStage(law=DockingLaw(approach="reverse")))


def station(scene, task=TASK, *, channels=(2.402e9, 2.441e9, 2.480e9)):
    link = reader_link(
        [radio_scene(scene, f) for f in channels],
        tag_position_m=(4.0, 2.5, 3.05),
        tag_antenna=[make_antenna("dipole", f) for f in channels],
        tag_power_w=1.0,
        response=[sector_response(AZIMUTHS, frequency_hz=f) for f in channels],
        reader_height_m=0.3,
        solver=SolverSettings(max_reflections=3),
    )
    robot = footprint(scene, radius_m=0.2, height_m=0.8)
    return DockingJob(
        task=task,
        setting=DockingSetting(
            reader=FieldSensor(links={"dock": link}, azimuths_rad=AZIMUTHS, noise_db=1.0),
            camera=replace(CAMERA, scene=scene),
            robot=DifferentialDrive(),
            blocked=robot,
        ),
        starts=RandomStarts(
            low_m=np.array([-1.0, -1.0]),
            high_m=np.array([6.0, 6.0]),
            fits=RobotSpace(footprint=robot, scene=scene, height_m=0.8),
        ),
    )


@pytest.fixture(scope="module")
def concrete():
    return station(build_scene(box_room((7.0, 7.0, 3.1), origin_m=(-1.0, -1.0, 0.0))))


def near(task, *, compensate=True):
    return DockingJob(
        task=replace(task, tries=1, fine=replace(task.fine, compensate_slips=compensate)),
        setting=DockingSetting(reader=None, camera=CAMERA, robot=DifferentialDrive()),
        starts=RandomStarts(
            low_m=np.array([3.6, 1.9]), high_m=np.array([4.4, 3.1]), fits=lambda p: p[:, 0] > -99
        ),
    )


@pytest.mark.slow
def test_docking_on_estimates_with_slip_compensation_ends_in_the_dock():
    runs = run_seeded(near(TASK), runs=30, seed=5)
    docked = [r for r in runs if r.success]
    assert len(docked) >= 28
    assert not any(r.outcome == "stalled" for r in runs)
    position, lateral = (
        np.array([getattr(r, key) for r in docked])
        for key in ("position_error_m", "lateral_error_m")
    )
    assert np.median(position) <= 0.04
    assert np.quantile(position, 0.9) <= 0.06
    assert np.median(lateral) <= 0.01
    assert np.quantile(lateral, 0.9) <= 0.02
    assert np.quantile([abs(r.final[2]) for r in docked], 0.9) <= 0.07


def test_without_compensation_a_slip_stalls_the_robot_at_b_over_gamma():
    runs = run_seeded(near(TASK, compensate=False), runs=4, seed=1)
    assert not any(r.success for r in runs)
    assert sum(r.outcome == "stalled" for r in runs) >= 3
    for result in runs:
        estimated = result.polar[np.isfinite(result.polar[:, 0]), 0]
        assert estimated.min() == pytest.approx(0.08, abs=0.02)


def test_in_reverse_the_robot_backs_into_the_dock():
    """The goals [0, ±π, ±π] of the docking paper, VI: the same places, the back to the landmark."""
    job = near(REVERSE)
    behind = replace(CAMERA, yaw_rad=CAMERA.yaw_rad + np.pi, position_m=[-0.09, -0.03, 0.775])
    job = replace(job, setting=replace(job.setting, camera=behind))
    for result in run_seeded(job, runs=4, seed=5):
        assert result.success, result.reason
        to_landmark = LANDMARK.position_m[:2] - result.poses[-1, :2]
        heading = result.poses[-1, 2]
        assert np.hypot(*to_landmark) == pytest.approx(0.5, abs=0.08)
        assert to_landmark @ [np.cos(heading), np.sin(heading)] < -0.9 * np.hypot(*to_landmark)
        docking = np.array(result.phases) == "dock"
        assert np.median(result.twist[docking, 0]) < 0.0


@pytest.mark.parametrize("error", [(1.0, -0.5, 1.0), (2.0, -1.5, 2.5)])
def test_from_a_wrong_estimate_the_robot_docks_given_that_it_sees_the_landmark(error):
    """Docking paper VIII; without a landmark in view the estimate stays wrong."""
    task = replace(TASK, tries=1, fine=FineStage(start_error=error))
    setting = near(TASK).setting
    for seed, start in enumerate([(4.0, 2.3, 0.1), (3.8, 2.9, -0.3)]):
        result = run_docking(task, setting, start, np.random.default_rng(seed))
        assert result.success, result.reason
        away_m = np.hypot(*(np.array(start[:2]) - TASK.goal[:2]))
        assert abs(result.polar[0, 0] - away_m) > 0.2  # it did begin astray
    blind = replace(setting, camera=replace(CAMERA, farthest_m=0.5))
    assert not run_docking(task, blind, start, np.random.default_rng(1)).success


@pytest.mark.parametrize("method", ["exact", "rk2", "euler"])
def test_odometry_adds_up_as_it_is_told(method):
    """Closed forms of n equal steps: each step's way turns by Δθ from the one before."""
    speed, rate, period_s, steps = 0.2, 0.3, 0.5, 12
    setting = DockingSetting(reader=None, camera=CAMERA, robot=DifferentialDrive(), odometry=method)
    drive = DockingDrive(TASK, setting, pose=np.zeros(3), rng=np.random.default_rng(1))
    for _ in range(steps):
        drive.step("search", np.array([speed, rate]), period_s=period_s)
    turn = rate * period_s
    first = {
        "euler": speed * period_s,
        "rk2": speed * period_s * np.exp(0.5j * turn),
        "exact": speed / rate * (np.exp(1j * turn) - 1.0) / 1j,
    }[method]
    place = first * (1.0 - np.exp(1j * turn * steps)) / (1.0 - np.exp(1j * turn))
    assert drive.odometry == pytest.approx([place.real, place.imag, steps * turn])


@pytest.mark.slow
def test_missions_dock_from_anywhere_in_a_concrete_room(concrete):
    runs = run_seeded(concrete, runs=12, seed=1)
    assert sum(r.success for r in runs) == 12
    assert all(r.reason for r in runs)


def test_missions_dock_from_anywhere_in_free_space():
    runs = run_seeded(station(free_space_scene(), channels=(2.441e9,)), runs=8, seed=1)
    assert sum(r.success for r in runs) == 8
    assert max(r.staged_m for r in runs) < 0.6


def test_a_run_is_the_same_to_the_bit_alone_among_others_and_sent_to_another_process():
    scene = free_space_scene()
    robot = footprint(scene, radius_m=0.2, height_m=0.8)
    space = RobotSpace(footprint=robot, scene=scene, height_m=0.8)
    job = near(TASK)
    job = replace(job, starts=replace(job.starts, fits=space))
    alone = job(np.random.SeedSequence(3).spawn(3)[2])
    for sent in (job, pickle.loads(pickle.dumps(job))):  # noqa: S301  our own bytes
        among = run_seeded(sent, runs=3, seed=3)[2]
        np.testing.assert_array_equal(alone.poses, among.poses)
        np.testing.assert_array_equal(alone.polar, among.polar)
        assert alone.reason == among.reason


def test_a_cabinet_before_the_dock_is_touched_and_named():
    cabinet = box((0.3, 3.0, 0.45), position_m=(4.9, 1.0, 0.0), material="metal")
    scene = build_scene(box_room((7.0, 7.0, 3.1), origin_m=(-1.0, -1.0, 0.0)), objects=[cabinet])
    task = replace(TASK, tries=2, max_contacts=3)
    job = station(scene, task, channels=(2.441e9,))
    result = run_docking(task, job.setting, [3.5, 2.5, 0.0], np.random.default_rng(1))
    assert not result.success
    assert result.contacts > 0
    clearance = footprint(scene, radius_m=0.2, height_m=0.8).clearance_m(result.poses[:, :2])
    assert clearance.min() > -0.021  # the robot stops at what it touches


@pytest.mark.parametrize(("start", "beyond_m"), [([0.0, 0.0, 0.0], 0.5), ([4.0, 2.5, 0.0], 4.1)])
def test_a_robot_that_leaves_the_room_says_so_in_either_stage(concrete, start, beyond_m):
    setting = replace(concrete.setting, outside=lambda points: points[:, 0] > beyond_m)
    if beyond_m > 4.0:
        setting = replace(setting, reader=None)
    result = run_docking(TASK, setting, start, np.random.default_rng(1))
    assert result.outcome == "left the room"
    assert result.poses[-1, 0] > beyond_m
    assert (result.poses[:-1, 0] <= beyond_m).all()
    assert result.tries == 1


def test_without_a_landmark_in_sight_the_result_says_so():
    hidden = replace(CAMERA, farthest_m=0.5, false_probability=0.0)
    job = near(TASK)
    setting = replace(job.setting, camera=hidden)
    result = run_docking(job.task, setting, [4.0, 2.5, 0.0], np.random.default_rng(1))
    assert result.outcome == "landmark not found"


def test_a_robot_that_hears_nothing_says_so_and_a_slow_reader_knows_how_it_drove():
    motions = []

    class Deaf:
        antennas, azimuths_rad, tag_ids = 8, AZIMUTHS, ("dock",)

        def read(self, pose, tag_id, rng, *, motion):
            del pose, tag_id, rng
            motions.append(motion)
            return np.zeros(8)

    setting = DockingSetting(reader=Deaf(), camera=CAMERA, robot=DifferentialDrive())
    result = run_docking(TASK, setting, [0.0, 0.0, 0.0], np.random.default_rng(1))
    assert result.outcome == "tag not found"
    assert "received nothing" in result.reason
    assert motions[0].rests
    twist, slip = result.twist[result.time_s < result.time_s[-1]], TASK.slip
    first = next(m for m in motions if not m.rests)
    assert first.speed_m_per_s == twist[0, 0] + slip.linear_m_per_s
    assert first.turn_rate_rad_per_s == twist[0, 1] + slip.angular_rad_per_s


def test_the_simulated_robot_moves_by_its_command_and_its_slip():
    slip = WheelSlip(
        linear_m_per_s=-0.05, angular_rad_per_s=0.1, position_m2_per_s=0.0, heading_rad2_per_s=0.0
    )
    floor, pose = Floor(robot=DifferentialDrive()), np.array([1.0, 2.0, 0.0])
    rng = np.random.default_rng(1)
    for _ in range(20):
        pose, contact = floor.slip(pose, [0.25, 0.1], slip=slip, period_s=0.1, rng=rng)
        assert not contact
    radius, turn = 0.2 / 0.2, 0.4
    want = [1.0 + radius * np.sin(turn), 2.0 + radius * (1 - np.cos(turn)), turn]
    np.testing.assert_allclose(pose, want, atol=1e-12)
    still, _ = floor.slip(pose, [0.0, 0.0], slip=slip, period_s=10.0, rng=rng)
    np.testing.assert_array_equal(still, pose)


def test_a_blocked_start_an_unknown_tag_and_bad_tasks_are_refused(concrete):
    rng = np.random.default_rng(1)
    with pytest.raises(NavigationError, match="inside an obstacle"):
        run_docking(TASK, concrete.setting, [-0.95, 0.0, 0.0], rng)
    with pytest.raises(NavigationError, match="unknown"):
        run_docking(replace(TASK, tag_id="dok"), concrete.setting, [0.0, 0.0, 0.0], rng)
    with pytest.raises(NavigationError, match="staging_m"):
        replace(TASK, staging_m=0.4)
    with pytest.raises(NavigationError, match="sample time"):
        FineStage(period_s=0.0)
    with pytest.raises(NavigationError, match="sample time"):
        CoarseStage(period_s=-1.0)
    with pytest.raises(NavigationError, match="turn it about"):
        run_docking(REVERSE, concrete.setting, [0.0, 0.0, 0.0], rng)
    with pytest.raises(NavigationError, match="widen"):
        RandomStarts(
            low_m=np.zeros(2), high_m=np.ones(2), fits=lambda p: np.zeros(len(p), dtype=bool)
        ).draw(rng)
