"""The thesis' navigator as a state machine: what the robot decides from one reading.

The key steps 1-9 of thesis 5.2 and its flowchart (figure 5.6). `decide` is a pure function of the
reading and of what the navigator remembers; the simulated world around it is in `missions`.
"""

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from octant.navigation.arrival import ArrivalState, ArrivalTest, observe_spread, rss_spread_w
from octant.navigation.bearing import doct, turn_towards, vector_sum_bearing
from octant.navigation.controllers import Controller
from octant.navigation.robot import DifferentialDrive

Mode = Literal["rotation", "navigation", "stopped"]
"""What the robot does in a period."""

Rotation = Literal["strongest", "vector_sum"]
"""Which bearing the rotation mode turns to."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NavigatorState:
    """Return what the navigator remembers between readings; the defaults begin a mission.

    Parameters
    ----------
    mode : {"rotation", "navigation", "stopped"}
        What it does next.
    target : int
        Index of the current tag in the mission's list [-].
    turn_left_rad : float
        What is left of a rotation that takes several periods, counter-clockwise positive [rad].
    driven_m : float
        Distance commanded in the last period [m].
    reckoned_pose : tuple of float
        Dead-reckoned x [m], y [m], heading [rad] since the leg began, in the frame of its start.
    silent_readings : int
        Readings in a row in which no antenna received anything [-].
    arrival : ArrivalState
        Memory of the arrival test on this leg.
    """

    mode: Mode = "rotation"
    target: int = 0
    turn_left_rad: float = 0.0
    driven_m: float = 0.0
    reckoned_pose: tuple[float, float, float] = (0.0, 0.0, 0.0)
    silent_readings: int = 0
    arrival: ArrivalState = field(default_factory=ArrivalState)


@dataclass(frozen=True, slots=True, kw_only=True)
class Navigator:
    """Return the fixed part of a navigator: its tags' arrival tests, its controller, its robot.

    Parameters
    ----------
    arrivals : tuple of ArrivalTest
        One for each tag of the mission, in order.
    azimuths_rad : (n,) float64
        Azimuths of the antennas in the reader frame [rad].
    controller : Controller
        Law of the navigation mode.
    robot : DifferentialDrive
        Wheels, axle and limits.
    cruise_speed_m_per_s : float
        Speed of straight driving [m/s].
    period_s : float
        Sample period T [s].
    rotation : {"strongest", "vector_sum"}
        Bearing of the rotation mode: the strongest antenna, thesis (5.2), or the vector sum.
    """

    arrivals: tuple[ArrivalTest, ...]
    azimuths_rad: npt.NDArray[np.float64]
    controller: Controller
    robot: DifferentialDrive
    cruise_speed_m_per_s: float
    period_s: float
    rotation: Rotation = "strongest"

    def arrived(
        self, state: NavigatorState, rss_w: npt.NDArray[np.float64]
    ) -> tuple[bool, NavigatorState]:
        """Return whether a reading says that the current tag is reached: key steps 3 to 5.

        Parameters
        ----------
        state : NavigatorState
            Memory before the reading.
        rss_w : (n,) float64
            Reading of the current tag [W].

        Returns
        -------
        arrived : bool
            True when the tag is reached.
        state : NavigatorState
            Memory after the reading. After an arrival it stands in rotation mode with the next
            tag as its target (read again, step 5), or is stopped after the last (step 4).
        """
        silent = not float(rss_w.max()) > 0.0
        there, arrival = observe_spread(
            self.arrivals[state.target],
            state.arrival,
            spread_w=float(rss_spread_w(rss_w)),
            driven_m=state.driven_m,
            place_m=state.reckoned_pose[:2],
        )
        if not there:
            silent_readings = state.silent_readings + 1 if silent else 0
            return False, replace(
                state, arrival=arrival, driven_m=0.0, silent_readings=silent_readings
            )
        if state.target + 1 == len(self.arrivals):
            return True, NavigatorState(mode="stopped", target=state.target)
        return True, NavigatorState(target=state.target + 1)

    def decide(
        self, state: NavigatorState, rss_w: npt.NDArray[np.float64]
    ) -> tuple[npt.NDArray[np.float64], NavigatorState]:
        """Return the wheel rates for one period, when the tag is not reached: key steps 6 to 9.

        Parameters
        ----------
        state : NavigatorState
            Memory after `arrived`.
        rss_w : (n,) float64
            The same reading [W].

        Returns
        -------
        rates : (2,) float64
            Right and left wheel, within the robot's limits [rad/s].
        state : NavigatorState
            Memory for the next reading.

        Notes
        -----
        Without a signal the robot waits in rotation mode and goes straight on at cruise speed in
        navigation mode; who runs it decides when to give up. A rotation faster than the wheels
        allow goes on in the next periods without a new bearing; the Scout turns by up to 286° in
        1 s, so there one period is always enough.
        """
        if state.mode == "stopped":
            return np.zeros(2), state
        if state.mode == "rotation":
            rates, state = self._rotate(state, rss_w)
        elif state.silent_readings > 0:
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
        rates = self.robot.saturate(rates)
        driven_m = abs(float(self.robot.twist(rates)[0])) * self.period_s
        x, y, heading = self.robot.step_arc(state.reckoned_pose, rates, period_s=self.period_s)
        reckoned = (float(x), float(y), float(heading))
        return rates, replace(state, driven_m=driven_m, reckoned_pose=reckoned)

    def _rotate(
        self, state: NavigatorState, rss_w: npt.NDArray[np.float64]
    ) -> tuple[npt.NDArray[np.float64], NavigatorState]:
        turn_rad = state.turn_left_rad
        if turn_rad == 0.0:
            if state.silent_readings > 0:
                return np.zeros(2), state
            estimate = doct if self.rotation == "strongest" else vector_sum_bearing
            turn_rad = float(turn_towards(estimate(rss_w, self.azimuths_rad)))
        limit_rad = self.robot.max_turn_rate_rad_per_s * self.period_s
        now_rad = float(np.clip(turn_rad, -limit_rad, limit_rad))
        rates = self.robot.wheel_rates(
            speed_m_per_s=0.0, turn_rate_rad_per_s=now_rad / self.period_s
        )
        left_rad = turn_rad - now_rad
        mode: Mode = "rotation" if left_rad != 0.0 else "navigation"
        return rates, replace(state, turn_left_rad=left_rad, mode=mode)
