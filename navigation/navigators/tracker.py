"""A navigator that knows that the tag is fixed: it tracks the tag's place and drives there."""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.checks import check_positive
from octant.navigation.navigators.interface import Decision, Mode, Odometry
from octant.navigation.navigators.place_particles import (
    PlaceBelief,
    PlaceEstimate,
    PlaceFilter,
    seen_after,
)
from octant.navigation.robot.drive import DifferentialDrive

FloatArray = npt.NDArray[np.float64]

_ON_SPOT_RAD = 0.6
_TURN_SHARE = 0.7
_SEARCH_TURN_RAD = 0.3
_LEAST_STEP_SHARE = 0.3
_BACK_STEPS = 3
_ALONG_STEPS = 5
_HEADING_SD_RAD = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerMemory:
    """What the tracking navigator remembers between readings.

    Parameters
    ----------
    target : Index of the current tag in the mission's list.
    belief : The tag's place; None before the first reading of a leg, or to begin anew.
    goal_m : (2,) float64 — The place to which the robot drives, ahead and to its left [m].
    heading_rad, heading_sd_rad : Heading that the robot supposes and its standard deviation [rad].
    readings : Readings since the belief began.
    plan : Ways [m] and turns [rad] of the next periods, when it is backing off.
    """

    target: int
    belief: PlaceBelief | None
    heading_rad: float
    heading_sd_rad: float
    goal_m: FloatArray | None = None
    readings: int = 0
    plan: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackerNavigator:
    """A navigator that drives to where a particle filter believes the tag.

    It turns on the spot when the believed place is more than 0.6 rad off its front, else it drives
    there, a step at a time. It keeps to a place until another is clearly more probable: it would
    turn round for ever between two that each look better from afar. There but not sure, it drives
    on in an arc: readings from new places decide. After a contact it backs off, turns to one side
    and drives a little first. A car turns on its tightest circle, backwards where the believed
    place lies inside of it.

    Parameters
    ----------
    filters : One for each tag of the mission, in order; the same where tags hang alike.
    robot : Wheels, axle and limits.
    cruise_step_m : Distance driven straight ahead in one period [m].
    period_s : Sample period T [s].
    arrival_radius_m : The tag is reached when the believed place is nearer than this [m].
    arrival_share : Least probability that the tag is within 1 m of that place [-].
    arrival_spread_m : Greatest spread of the particles there [m].
    arrival_level_sds : The level found there is at most so many standard deviations of the filter's
        `level_db` from the table's [-].
    patience : After so many readings without arrival the belief begins anew.
    """

    filters: tuple[PlaceFilter, ...]
    robot: DifferentialDrive
    cruise_step_m: float
    period_s: float
    arrival_radius_m: float = 0.08
    arrival_share: float = 0.6
    arrival_spread_m: float = 0.3
    arrival_level_sds: float = 2.5
    patience: int = 150

    def __post_init__(self) -> None:
        for name, unit in (
            ("cruise_step_m", "m"),
            ("period_s", "s"),
            ("arrival_radius_m", "m"),
            ("arrival_share", "1"),
            ("arrival_spread_m", "m"),
            ("arrival_level_sds", "1"),
            ("patience", "readings"),
        ):
            check_positive(getattr(self, name), name=name, unit=unit)

    def begin(
        self, target: int, before: TrackerMemory | None, *, heading_rad: float
    ) -> TrackerMemory:
        """Return what is remembered at the beginning of a leg."""
        if not 0 <= target < len(self.filters):
            msg = (
                f"the mission has a tag number {target + 1}, but the navigator has "
                f"{len(self.filters)} filters: give one for each tag."
            )
            raise NavigationError(msg)
        if before is None:
            return TrackerMemory(
                target=target, belief=None, heading_rad=heading_rad, heading_sd_rad=_HEADING_SD_RAD
            )
        return replace(before, target=target, belief=None, goal_m=None, readings=0, plan=())

    def decide(
        self,
        memory: TrackerMemory,
        rss_w: FloatArray,
        odometry: Odometry,
        rng: np.random.Generator,
    ) -> Decision[TrackerMemory]:
        """Return the command for the coming period, or that the tag is reached."""
        place_filter, belief = self.filters[memory.target], memory.belief
        if belief is None:
            belief = place_filter.start(
                rng,
                heading_rad=memory.heading_rad + odometry.turn_rad,
                heading_sd_rad=max(memory.heading_sd_rad, _HEADING_SD_RAD),
            )
        else:
            belief = place_filter.moved(belief, odometry, rng)
        belief = place_filter.observed(belief, rss_w, rng)
        held_m = memory.goal_m
        if held_m is not None:
            held_m = seen_after(
                held_m,
                way_m=odometry.distance_m,
                turn_rad=odometry.turn_rad,
                method=place_filter.method,
            )
        estimate = place_filter.estimate(belief, held_m=held_m)
        memory = replace(
            memory,
            belief=belief,
            goal_m=estimate.place_m,
            heading_rad=estimate.heading_rad,
            heading_sd_rad=estimate.heading_sd_rad,
            readings=memory.readings + 1,
        )
        if self._there(estimate, level_db=place_filter.level_db):
            return Decision(
                rates=np.zeros(2),
                memory=memory,
                reached=True,
                mode="stopped",
                place_m=estimate.place_m,
            )
        if memory.readings >= self.patience:
            memory = replace(memory, belief=None, goal_m=None, readings=0)
        if odometry.contact and not memory.plan:
            memory = replace(memory, plan=self._back_off(rng))
        if memory.plan:
            (way_m, turn_rad), *later = memory.plan
            mode: Mode = "evade"
            memory = replace(memory, plan=tuple(later))
        else:
            way_m, turn_rad, mode = self._towards(estimate)
        rates = self.robot.wheel_rates(
            speed_m_per_s=way_m / self.period_s, turn_rate_rad_per_s=turn_rad / self.period_s
        )
        return Decision(
            rates=self.robot.saturate(rates),
            memory=memory,
            reached=False,
            mode=mode,
            place_m=estimate.place_m,
        )

    def _sure(self, estimate: PlaceEstimate) -> bool:
        return estimate.share >= self.arrival_share and estimate.spread_m <= self.arrival_spread_m

    def _there(self, estimate: PlaceEstimate, *, level_db: float) -> bool:
        near = estimate.distance_m <= self.arrival_radius_m
        possible = abs(estimate.level_db) <= self.arrival_level_sds * level_db
        return near and possible and self._sure(estimate)

    def _towards(self, estimate: PlaceEstimate) -> tuple[float, float, Mode]:
        """Return way [m] and turn [rad] of the coming period."""
        error = estimate.bearing_rad
        speed_m_per_s = self.cruise_step_m / self.period_s
        limit = self.robot.turning_limit_rad_per_s(speed_m_per_s) * self.period_s
        if estimate.distance_m <= self.arrival_radius_m:
            return self.cruise_step_m, _SEARCH_TURN_RAD, "search"
        x_m, y_m = estimate.place_m
        behind = self.robot.encircles(float(x_m), float(y_m))
        if abs(error) > _ON_SPOT_RAD or behind:
            # Of a period instead of a second: ways and turns.
            way, turn = self.robot.turning(min(max(error, -limit), limit), reverse=behind)
            return way, turn, "rotation"
        least = _LEAST_STEP_SHARE * self.cruise_step_m
        way = min(self.cruise_step_m, max(least, estimate.distance_m))
        return way, _TURN_SHARE * error, "navigation"

    def _back_off(self, rng: np.random.Generator) -> tuple[tuple[float, float], ...]:
        side = math.copysign(rng.uniform(np.pi / 3.0, 2.0 * np.pi / 3.0), rng.random() - 0.5)
        back = ((-self.cruise_step_m, 0.0),) * _BACK_STEPS
        along = ((self.cruise_step_m, 0.0),) * _ALONG_STEPS
        return (*back, self.robot.turning(side), *along)
