"""The thesis' navigator as a state machine: the key steps 1-9 of thesis 5.2 and its figure 5.6.

Rotation turns the front to the tag, navigation is a controller's, a null means arrival.
"""

import math
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.checks import check_choice, check_positive
from octant.navigation.control.controllers import Controller
from octant.navigation.navigators.arrival import ArrivalState, ArrivalTest, observe_spread
from octant.navigation.navigators.interface import Decision, Mode, Odometry
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.motion import Integration
from octant.navigation.sensing.bearing import (
    doct,
    turn_towards,
    vector_sum_bearing,
)

FloatArray = npt.NDArray[np.float64]

Rotation = Literal["strongest", "vector_sum"]
"""Which bearing the rotation mode turns to."""

_FRONT_SPACINGS = 1.5


@dataclass(frozen=True, slots=True, kw_only=True)
class ThesisMemory:
    """What the navigator remembers between readings; the defaults begin a mission.

    Parameters
    ----------
    mode : {"rotation", "navigation"} — What it does next.
    target : Index of the current tag in the mission's list.
    turn_left_rad : What is left of a rotation, counter-clockwise positive [rad].
    place : Dead-reckoned x [m], y [m], heading [rad] in the frame of the leg's start.
    readings : Readings on this leg so far.
    arrival : Memory of the arrival test on this leg.
    """

    mode: Mode = "rotation"
    target: int = 0
    turn_left_rad: float = 0.0
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)
    readings: int = 0
    arrival: ArrivalState = field(default_factory=ArrivalState)


@dataclass(frozen=True, slots=True, kw_only=True)
class ThesisNavigator:
    """The fixed part of a navigator: its tags' arrival tests, its controller, its robot.

    Without a signal the robot waits in rotation mode and goes straight on at cruise speed in
    navigation mode. A rotation faster than the wheels allow goes on in the next periods without a
    new bearing; the Scout turns by up to 286° in 1 s. A car turns on its tightest circle forwards,
    as the place of the tag is not known; it may go round a tag inside of it until the time is up.

    Parameters
    ----------
    arrivals : One for each tag of the mission, in order.
    azimuths_rad : (n,) float64 — Azimuths of the antennas in the reader frame [rad].
    controller : Law of the navigation mode.
    robot : Wheels, axle and limits.
    cruise_speed_m_per_s : Speed of straight driving [m/s].
    period_s : Sample period T [s].
    rotation : {"strongest", "vector_sum"} — Bearing of the rotation mode: thesis (5.2), or the sum.
    rerotate_for_s : For so long on a leg the robot rotates again when the strongest antenna is not
        one of the front three [s]; 0: never, as in the thesis. Reflections may turn it endlessly.
    method : How dead reckoning adds up a period, as in `motion.move`.
    """

    arrivals: tuple[ArrivalTest, ...]
    azimuths_rad: FloatArray
    controller: Controller
    robot: DifferentialDrive
    cruise_speed_m_per_s: float
    period_s: float
    rotation: Rotation = "strongest"
    rerotate_for_s: float = 0.0
    method: Integration = "exact"

    def __post_init__(self) -> None:
        check_choice(self.rotation, get_args(Rotation), name="rotation")
        check_positive(self.period_s, name="period_s", unit="s")
        check_positive(self.cruise_speed_m_per_s, name="cruise_speed_m_per_s", unit="m/s")
        check_positive(self.rerotate_for_s, name="rerotate_for_s", unit="s", allow_zero=True)

    def begin(
        self,
        target: int,
        before: ThesisMemory | None,  # noqa: ARG002
        *,
        heading_rad: float,  # noqa: ARG002
    ) -> ThesisMemory:
        """Return what is remembered at the beginning of a leg: key step 5."""
        if not 0 <= target < len(self.arrivals):
            msg = (
                f"the mission has a tag number {target + 1}, but the navigator has "
                f"{len(self.arrivals)} arrival tests: give one for each tag."
            )
            raise NavigationError(msg)
        return ThesisMemory(target=target)

    def decide(
        self,
        memory: ThesisMemory,
        rss_w: FloatArray,
        odometry: Odometry,
        rng: np.random.Generator,  # noqa: ARG002
    ) -> Decision[ThesisMemory]:
        """Return the command for the coming period, or that the tag is reached: steps 3 to 9."""
        place = _moved(memory.place, odometry, self.method)
        strongest_w = float(rss_w.max())
        there, arrival = observe_spread(
            self.arrivals[memory.target],
            memory.arrival,
            spread_w=strongest_w - float(rss_w.min()),
            driven_m=abs(odometry.distance_m),
            place_m=place[:2],
        )
        memory = replace(memory, arrival=arrival, place=place, readings=memory.readings + 1)
        if there:
            return Decision(rates=np.zeros(2), memory=memory, reached=True, mode="stopped")
        silent = not strongest_w > 0.0
        if memory.mode == "navigation" and not silent and self._looks_away(memory, rss_w):
            memory = replace(memory, mode="rotation")
        mode = memory.mode
        if mode == "rotation":
            rates, memory = self._rotate(memory, rss_w, silent=silent)
        elif silent:
            rates = self.robot.wheel_rates(
                speed_m_per_s=self.cruise_speed_m_per_s, turn_rate_rad_per_s=0.0
            )
        else:
            rates = self.controller.wheel_rates(
                rss_w,
                azimuths_rad=self.azimuths_rad,
                cruise_speed_m_per_s=self.cruise_speed_m_per_s,
                robot=self.robot,
            )
        return Decision(rates=self.robot.saturate(rates), memory=memory, reached=False, mode=mode)

    def _looks_away(self, memory: ThesisMemory, rss_w: FloatArray) -> bool:
        if memory.readings * self.period_s > self.rerotate_for_s:
            return False
        front = _FRONT_SPACINGS * 2.0 * math.pi / len(self.azimuths_rad)
        strongest = float(self.azimuths_rad[int(np.argmax(rss_w))])
        return abs(float(turn_towards(strongest))) > front

    def _rotate(
        self, memory: ThesisMemory, rss_w: FloatArray, *, silent: bool
    ) -> tuple[FloatArray, ThesisMemory]:
        turn_rad = memory.turn_left_rad
        if turn_rad == 0.0:
            if silent:
                return np.zeros(2), memory
            estimate = doct if self.rotation == "strongest" else vector_sum_bearing
            turn_rad = float(turn_towards(estimate(rss_w, self.azimuths_rad)))
        limit = self.robot.turning_limit_rad_per_s(self.cruise_speed_m_per_s)
        limit_rad = limit * self.period_s
        now_rad = min(max(turn_rad, -limit_rad), limit_rad)
        speed, turn_rate = self.robot.turning(now_rad / self.period_s)
        rates = self.robot.wheel_rates(speed_m_per_s=speed, turn_rate_rad_per_s=turn_rate)
        left_rad = turn_rad - now_rad
        mode: Mode = "rotation" if left_rad != 0.0 else "navigation"
        return rates, replace(memory, turn_left_rad=left_rad, mode=mode)


def _moved(
    place: tuple[float, float, float], odometry: Odometry, method: Integration
) -> tuple[float, float, float]:
    """Return the dead-reckoned pose after a motion; `motion.move` in plain numbers."""
    x, y, heading = place
    half = 0.5 * odometry.turn_rad
    shorter = math.sin(half) / half if half and method == "exact" else 1.0
    chord = odometry.distance_m * shorter
    along = heading if method == "euler" else heading + half
    return x + chord * math.cos(along), y + chord * math.sin(along), heading + odometry.turn_rad
