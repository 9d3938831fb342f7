"""A navigator of the user's own: found by its name, driven, its mistakes said in one sentence."""

from importlib import metadata

import numpy as np
import pytest

from octant.geometries.errors import ConfigError
from octant.navigation.navigators.interface import STILL
from octant.navigation.navigators.loading import GROUP, class_place
from octant.navigation.navigators.own import (
    Command,
    Navigator,
    OwnNavigator,
    Told,
    find_navigator,
    place_of,
)
from octant.navigation.robot.drive import DifferentialDrive

TOLD = Told(
    tag_ids=("A", "B"),
    heading_rad=0.0,
    azimuths_rad=np.array([0.0, np.pi / 2, np.pi, -np.pi / 2]),
    period_s=1.0,
    cruise_step_m=0.09,
    arrival_radius_m=0.2,
    robot=DifferentialDrive(),
)
HEAD = "import octant\n\nclass Mine(octant.Navigator):\n"


def write(tmp_path, body, head=HEAD):
    file = tmp_path / "mine.py"
    file.write_text(head + body)
    return f"{file}:Mine"


def decide(place, *, rss_w=(1e-9, 4e-9, 1e-9, 0.0), times=1):
    navigator = OwnNavigator(place=place, told=TOLD)
    memory, rng = navigator.begin(0, None, heading_rad=0.5), np.random.default_rng(1)
    for _ in range(times):
        decision = navigator.decide(memory, np.array(rss_w), STILL, rng)
        memory = decision.memory
    return navigator, decision


def test_a_class_of_a_file_is_told_reads_and_commands(tmp_path):
    place = find_navigator(
        write(
            tmp_path,
            "    seen = 0\n"
            "    def step(self, reading, odometry):\n"
            "        self.seen += 1\n"
            "        assert reading.first == (self.seen == 1), reading\n"
            "        turn = reading.bearing_rad(self.told.azimuths_rad) + self.told.heading_rad\n"
            "        return octant.Command(speed_m_per_s=0.1, turn_rate_rad_per_s=turn)\n",
        )
    )
    assert place.name == "mine.py:Mine"
    assert place.files == (str(tmp_path / "mine.py"),)
    navigator, decision = decide(place, times=2)
    speed, turn = TOLD.robot.twist(decision.rates)
    # Antenna 2 stands to the left: the vector sum is 4e-9 j, a quarter turn; 0.5 rad was the start.
    assert (speed, turn) == pytest.approx((0.1, np.pi / 2 + 0.5))
    assert decision.mode == "navigation"
    again = navigator.begin(1, decision.memory, heading_rad=0.5)
    assert again.navigator.seen == 2  # the same object goes on with the next tag
    assert navigator.begin(0, None, heading_rad=0.5).navigator.seen == 0  # a run begins anew


class Plain:
    def step(self, reading, odometry):  # noqa: ARG002
        return Command(reached=reading.tag_id == "A")


def test_a_plain_class_and_its_module_will_do():
    _, decision = decide(place_of(Plain))
    assert decision.reached
    assert not decision.rates.any()


def test_entry_points_name_classes(monkeypatch):
    point = metadata.EntryPoint(name="mine", value="somewhere.robots:Mine", group=GROUP)
    monkeypatch.setattr(metadata, "entry_points", lambda group: [point] if group == GROUP else [])
    assert class_place("mine") == ("somewhere.robots", "Mine")


@pytest.mark.parametrize(
    ("body", "text"),
    [
        ("    pass\n", "mine.py:Mine has no step of its own"),
        ("    def step(self, reading):\n        pass\n", r"Mine.step takes \(self, reading\)"),
        (
            "    def __init__(self, gain):\n        pass\n    def step(self, r, o):\n     pass\n",
            r"Mine takes \(gain\), but it is called with no argument",
        ),
        ("    def step(self, r, o):\n  pass\n", "mine.py is no Python, line 5"),
        ("    pass\n1 / 0\n", r"mine.py cannot be imported \(line 5\): ZeroDivisionError"),
        ("    pass\nimport nothing_like_this\n", "mine.py needs 'nothing_like_this'"),
        ("    pass\nMina = Mine\ndel Mine", "no class 'Mine'; did you mean 'Mina'"),
        ("    pass\nMine = 3\n", "is 3, but a class is needed"),
    ],
)
def test_a_class_that_cannot_drive_is_refused(tmp_path, body, text):
    with pytest.raises(ConfigError, match=text):
        find_navigator(write(tmp_path, body))


@pytest.mark.parametrize(
    ("name", "text"),
    [
        (
            "nothing_like_this.robots:Mine",
            "no module 'nothing_like_this.robots'",
        ),
        ("json:Mine", "json has no class 'Mine'"),
        (":Mine", "is no class; write FILE.py:Class"),
        ("/nowhere/mine.py:Mine", "does not exist"),
    ],
)
def test_a_name_that_leads_nowhere_is_refused(name, text):
    with pytest.raises(ConfigError, match=text):
        find_navigator(name)


@pytest.mark.parametrize(
    ("line", "text"),
    [
        (
            "return 1 / 0",
            r"failed in step \(mine.py, line 5\): ZeroDivisionError: division",
        ),
        ("import math; math.sqrt(-1)", r"failed in step \(mine.py, line 5\): ValueError"),
        ("return None", "returned None from step, but an octant.Command is needed"),
        ("return octant.Command(speed_m_per_s=float('nan'))", "commands nan m/s and 0.0 rad/s"),
    ],
)
def test_what_goes_wrong_while_driving_is_said_with_its_line(tmp_path, line, text):
    place = find_navigator(
        write(tmp_path, f"    def step(self, reading, odometry):\n        {line}\n")
    )
    with pytest.raises(ConfigError, match=text):
        decide(place)


def test_the_base_without_a_step_is_refused():
    with pytest.raises(ConfigError, match="has no step of its own"):
        place_of(Navigator)
