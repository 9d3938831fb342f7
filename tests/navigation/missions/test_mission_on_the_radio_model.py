"""The thesis mission (5.4) in free space on Octant's own field, with sectors."""

import numpy as np
import pytest
from thesis_robot import THESIS_POINTS_M, thesis_mission, thesis_robot

from octant.em.antennas.kinds import make_antenna
from octant.em.medium.radio_scene import radio_scene
from octant.em.power.received_power import reader_link
from octant.em.reader.response import sector_response
from octant.em.search.candidates import SolverSettings
from octant.geometries.scene import free_space_scene
from octant.navigation.control.controllers import FuzzyController
from octant.navigation.missions.metrics import measure
from octant.navigation.missions.run import run_missions
from octant.navigation.navigators.arrival import arrival_tests
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.sensing.sensor import FieldSensor

F = 2.4e9
AZIMUTHS = 2.0 * np.pi * np.arange(8) / 8


@pytest.fixture(scope="module")
def links():
    radio, response = radio_scene(free_space_scene(), F), sector_response(AZIMUTHS, frequency_hz=F)
    return {
        tag: reader_link(
            radio,
            tag_position_m=(*point, 2.95),
            tag_antenna=make_antenna("dipole", F),
            tag_power_w=1.0,
            response=response,
            reader_height_m=0.3,
            solver=SolverSettings(max_reflections=0),
        )
        for tag, point in THESIS_POINTS_M.items()
    }


@pytest.mark.parametrize("steering_input", ["normalised", "nanowatt"])
def test_all_tags_are_reached_in_100_of_100_noisy_runs_within_12_cm(links, steering_input):
    points = list(THESIS_POINTS_M.values())
    tests = arrival_tests(links, list(THESIS_POINTS_M), points, radius_m=0.20)
    mission = thesis_mission(tests)
    sensor = FieldSensor(links=links, azimuths_rad=AZIMUTHS, noise_db=1.0)
    results = run_missions(
        mission,
        sensor,
        thesis_robot(mission, sensor, FuzzyController(steering_input=steering_input)),
        DifferentialDrive(),
        runs=100,
        seed=1,
    )
    metrics = [measure(result) for result in results]
    assert sum(run.success for run in metrics) == 100
    assert max(run.rmse_m for run in metrics) <= 0.12
    assert not any(run.captured for run in metrics)
