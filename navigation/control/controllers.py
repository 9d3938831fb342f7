"""Controllers of the navigation mode: from the RSS of one reading to the wheels' rates."""

import math
from dataclasses import dataclass, field
from typing import Literal, Protocol, get_args

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.checks import check_positive
from octant.navigation.control.fuzzy import RuleBase, thesis_rule_base
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.sensing.bearing import (
    steering_pair,
    turn_towards,
    vector_sum_bearing,
    vector_sum_variance,
)
from octant.navigation.sensing.pattern_match import PatternMatcher

SteeringInput = Literal["normalised", "nanowatt"]
"""How a reading becomes the fuzzy controller's input."""


class Controller(Protocol):
    """Turns one reading into wheel rates; keeps no memory between readings."""

    def wheel_rates(
        self,
        rss_w: npt.NDArray[np.float64],
        *,
        azimuths_rad: npt.NDArray[np.float64],
        cruise_speed_m_per_s: float,
        robot: DifferentialDrive,
    ) -> npt.NDArray[np.float64]:
        """Return the next period's rates of the right and the left wheel, (2,), not cut [rad/s].

        Parameters
        ----------
        rss_w : (n,) float64 — One reading with a signal [W].
        azimuths_rad : (n,) float64 — Azimuths of the antennas in the reader frame [rad].
        cruise_speed_m_per_s : Speed of straight driving [m/s].
        robot : Wheels and axle.
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class FuzzyController:
    """The thesis' fuzzy controller, with either input.

    Thesis 5.2.2.2. Right and left are those of `bearing.steering_pair`. The middle of the output,
    0.5, is the cruise speed: rim speed = 2 · u · cruise speed. RSS falls with the fourth power of
    the distance under the tag, so there the "nanowatt" input is starved and the robot runs straight
    on; the "normalised" one keeps its gain down to the null.

    Parameters
    ----------
    steering_input : {"normalised", "nanowatt"} — Difference right - left over the sum of the two,
        or, as the thesis has it, in nanowatts over its full scale, clipped.
    full_scale_w : Full scale of the "nanowatt" input [W].
    rules : One input on [-1, 1], two outputs on [0, 1]: right and left wheel.
    """

    steering_input: SteeringInput = "normalised"
    full_scale_w: float = 1200e-9
    rules: RuleBase = field(default_factory=thesis_rule_base)

    def __post_init__(self) -> None:
        if self.steering_input not in get_args(SteeringInput):
            msg = (
                f"steering_input is {self.steering_input!r}, but it must be one of "
                f"{list(get_args(SteeringInput))}: choose one."
            )
            raise NavigationError(msg)
        if not (np.isfinite(self.full_scale_w) and self.full_scale_w > 0.0):
            msg = (
                f"full_scale_w is {self.full_scale_w} W, but it must be positive and finite: "
                "the thesis has 1.2e-6."
            )
            raise NavigationError(msg)
        if len(self.rules.outputs) != 2:
            msg = (
                f"the rule base has {len(self.rules.outputs)} outputs, but the robot has two "
                "wheels: give right and left."
            )
            raise NavigationError(msg)

    def steering(
        self, rss_w: npt.ArrayLike, azimuths_rad: npt.ArrayLike
    ) -> npt.NDArray[np.float64]:
        """Return Δz_24 on [-1, 1], positive for a tag on the right; 0 where neither receives [-].

        Parameters
        ----------
        rss_w : (..., n) float64 — RSS of the antennas [W].
        azimuths_rad : (n,) float64 — Azimuths of the antennas in the reader frame [rad].
        """
        rss = np.asarray(rss_w, dtype=np.float64)
        right, left = steering_pair(azimuths_rad)
        difference = rss[..., right] - rss[..., left]
        if self.steering_input == "nanowatt":
            return np.asarray(np.clip(difference / self.full_scale_w, -1.0, 1.0))
        total = rss[..., right] + rss[..., left]
        return np.asarray(difference / np.where(total > 0.0, total, 1.0))

    def wheel_rates(
        self,
        rss_w: npt.NDArray[np.float64],
        *,
        azimuths_rad: npt.NDArray[np.float64],
        cruise_speed_m_per_s: float,
        robot: DifferentialDrive,
    ) -> npt.NDArray[np.float64]:
        """Return the rates of the right and the left wheel for the next period [rad/s]."""
        normalised = self.rules.infer(self.steering(rss_w, azimuths_rad))
        return 2.0 * cruise_speed_m_per_s / robot.wheel_radius_m * normalised


@dataclass(frozen=True, slots=True, kw_only=True)
class VectorSumController:
    """A proportional law on the vector-sum bearing: the simple alternative.

    With the bearing error e and its variance s²: v = cruise speed · max(0, cos e), ω = gain · e ·
    exp(-s²/2), the mean turn. It takes any number of antennas.

    Parameters
    ----------
    gain_per_s : Turn rate per bearing error [1/s]; times T up to 1 no overshoot, above 2 unstable.
    noise_db : Noise of the readings that the law assumes [dB]; 0: none.
    """

    gain_per_s: float = 0.5
    noise_db: float = 0.0

    def __post_init__(self) -> None:
        _check_gain(self.gain_per_s)
        check_positive(self.noise_db, name="noise_db", unit="dB", allow_zero=True)

    def wheel_rates(
        self,
        rss_w: npt.NDArray[np.float64],
        *,
        azimuths_rad: npt.NDArray[np.float64],
        cruise_speed_m_per_s: float,
        robot: DifferentialDrive,
    ) -> npt.NDArray[np.float64]:
        """Return the rates of the right and the left wheel for the next period [rad/s]."""
        variance = float(vector_sum_variance(rss_w, azimuths_rad, noise_db=self.noise_db))
        return proportional_rates(
            float(turn_towards(vector_sum_bearing(rss_w, azimuths_rad))),
            gain_per_s=self.gain_per_s * math.exp(-0.5 * variance),
            cruise_speed_m_per_s=cruise_speed_m_per_s,
            robot=robot,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class PatternController:
    """The same proportional law on the bearing that best explains all RSS values.

    Parameters
    ----------
    matcher : Patterns of the reader, and the errors of its readings.
    gain_per_s : Turn rate per bearing error [1/s].
    """

    matcher: PatternMatcher
    gain_per_s: float = 0.5

    def __post_init__(self) -> None:
        _check_gain(self.gain_per_s)

    def wheel_rates(
        self,
        rss_w: npt.NDArray[np.float64],
        *,
        azimuths_rad: npt.NDArray[np.float64],  # noqa: ARG002
        cruise_speed_m_per_s: float,
        robot: DifferentialDrive,
    ) -> npt.NDArray[np.float64]:
        """Return the rates of the right and the left wheel for the next period [rad/s]."""
        bearing_rad, variance = self.matcher.bearing(rss_w)
        return proportional_rates(
            bearing_rad,
            gain_per_s=self.gain_per_s * math.exp(-0.5 * variance),
            cruise_speed_m_per_s=cruise_speed_m_per_s,
            robot=robot,
        )


def proportional_rates(
    error_rad: float, *, gain_per_s: float, cruise_speed_m_per_s: float, robot: DifferentialDrive
) -> npt.NDArray[np.float64]:
    """Return the uncut wheel rates (2,) of v = cruise speed · max(0, cos e), ω = gain · e [rad/s].

    Parameters
    ----------
    error_rad : Bearing e from the robot's front, counter-clockwise positive [rad].
    gain_per_s : Turn rate per bearing error [1/s].
    cruise_speed_m_per_s, robot : As for `Controller.wheel_rates` [m/s].
    """
    return robot.wheel_rates(
        speed_m_per_s=cruise_speed_m_per_s * max(0.0, math.cos(error_rad)),
        turn_rate_rad_per_s=gain_per_s * error_rad,
    )


def _check_gain(gain_per_s: float) -> None:
    if not (np.isfinite(gain_per_s) and gain_per_s > 0.0):
        msg = (
            f"gain_per_s is {gain_per_s} 1/s, but it must be positive and finite: "
            "0.5 suits a period of 1 s."
        )
        raise NavigationError(msg)
