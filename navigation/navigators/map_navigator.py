"""A navigator that knows room and tags: it finds its pose by field maps, and drives by the plan.

Beside it one that only counts its wheels: what it reaches needs no reader.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.checks import check_positive
from octant.navigation.navigators.interface import Decision, Mode, Odometry
from octant.navigation.navigators.learned import Learned
from octant.navigation.navigators.pose_belief import PoseBelief, PoseEstimate
from octant.navigation.navigators.pose_particles import PoseFilter
from octant.navigation.navigators.ways import FloorPlan
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.robot.motion import Integration, move

FloatArray = npt.NDArray[np.float64]

SURE_SDS = 2.45
"""Radius [-] of the circle that holds 95 % of a round normal distribution, by its deviation."""

_ON_SPOT_RAD, _ON_SPOT_TIGHT_RAD = 0.5, 0.15
_MARGIN_M = (0.1, 0.3)
_TURN_SHARE = 0.8
_THERE_M = 0.02
_LEAST_SHARE = 0.9
_SEARCH_STEPS = 12
_SEARCH_M = (0.25, 0.15)
_SEARCH_SIDES = 8
_BACK_STEPS = 2
_ALONG_STEPS = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Follower:
    """How a robot whose pose is known drives along a way.

    Parameters
    ----------
    plan : Ways to the tags of the mission, in order.
    robot : Wheels, axle and limits.
    cruise_step_m : Distance driven straight ahead in one period [m].
    period_s : Sample period T [s].
    """

    plan: FloorPlan
    robot: DifferentialDrive
    cruise_step_m: float
    period_s: float

    def __post_init__(self) -> None:
        check_positive(self.cruise_step_m, name="cruise_step_m", unit="m")
        check_positive(self.period_s, name="period_s", unit="s")

    def check_target(self, target: int) -> None:
        """Refuse a tag to which there is no way.

        Parameters
        ----------
        target : Index of the tag in the mission's order.
        """
        if not 0 <= target < len(self.plan.goals_m):
            msg = (
                f"the mission has a tag number {target + 1}, but the plan has "
                f"{len(self.plan.goals_m)} goals: give one for each tag."
            )
            raise NavigationError(msg)

    def end_m(self, target: int, offset_m: FloatArray) -> FloatArray:
        """Return the tag's point, or the free place nearest to where it was surveyed, (2,) [m].

        Parameters
        ----------
        target : Which tag.
        offset_m : (2,) float64 — How far from its surveyed point it is believed [m].
        """
        surveyed: FloatArray = self.plan.ends_m[target]
        found = surveyed + offset_m
        return found if self.plan.sees(surveyed, found) else surveyed

    def step(
        self, pose: FloatArray, target: int, end_m: FloatArray, *, spread_m: float = 0.0
    ) -> tuple[float, float, Mode]:
        """Return way [m] and turn [rad] of the coming period, and what it is.

        Parameters
        ----------
        pose : (3,) float64 — x, y [m], heading [rad].
        target : Which tag.
        end_m : (2,) float64 — Where its leg ends, from `end_m` [m].
        spread_m : Deviation of the pose along the least known direction [m]: as far as there is
            room the way keeps the circle of 95 % free, and 10 cm at least.
        """
        least, most = _MARGIN_M
        margin = min(max(SURE_SDS * spread_m, least), most)
        point = self.plan.towards(pose[:2], target, margin_m=margin)
        if math.dist(point, self.plan.ends_m[target]) == 0.0 and self.plan.sees(pose[:2], end_m):
            point = end_m
        return self.to_point(pose, point)

    def to_point(self, pose: FloatArray, point_m: FloatArray) -> tuple[float, float, Mode]:
        """Return way [m] and turn [rad] of a period towards a point, and what it is.

        Parameters
        ----------
        pose : (3,) float64 — x, y [m], heading [rad].
        point_m : (2,) float64 — Where to [m].
        """
        away = point_m - pose[:2]
        distance = float(np.hypot(*away))
        error = float(wrap_angle(math.atan2(away[1], away[0]) - pose[2]))
        ahead, left = distance * math.cos(error), distance * math.sin(error)
        if distance < self.cruise_step_m and math.cos(error) < 0.0 and not self._turns_badly:
            # A short way back needs no turn.
            back = float(wrap_angle(error + math.pi))
            if abs(back) <= _ON_SPOT_RAD:
                return -distance, back, "navigation"
        behind = self.robot.encircles(ahead, left)
        tight = self.plan.clearance_m(pose[:2]) < _MARGIN_M[0]
        if abs(error) > (_ON_SPOT_TIGHT_RAD if tight else _ON_SPOT_RAD) or behind:
            speed = self.cruise_step_m / self.period_s
            limit = self.robot.turning_limit_rad_per_s(speed) * self.period_s
            way, turn = self.robot.turning(min(max(error, -limit), limit), reverse=behind)
            return way, turn, "rotation"
        return min(self.cruise_step_m, distance), _TURN_SHARE * error, "navigation"

    @property
    def _turns_badly(self) -> bool:
        return self.robot.least_radius_m > 0.0

    def rates(self, way_m: float, turn_rad: float) -> FloatArray:
        """Return the wheel rates of a period, within the limits [rad/s].

        Parameters
        ----------
        way_m, turn_rad : Way [m] and turn [rad] of the period.
        """
        rates = self.robot.wheel_rates(
            speed_m_per_s=way_m / self.period_s, turn_rate_rad_per_s=turn_rad / self.period_s
        )
        saturated: FloatArray = self.robot.saturate(rates)
        return saturated


def backing_off(follower: Follower, rng: np.random.Generator) -> tuple[tuple[float, float], ...]:
    """Return ways [m] and turns [rad] after a contact: back, a turn to one side, and along.

    Parameters
    ----------
    follower : The robot and its step.
    rng : Source of side and angle.
    """
    side = math.copysign(rng.uniform(np.pi / 4.0, np.pi / 2.0), rng.random() - 0.5)
    step = follower.cruise_step_m
    return (
        *(((-step, 0.0),) * _BACK_STEPS),
        follower.robot.turning(side),
        *(((step, 0.0),) * _ALONG_STEPS),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class MapMemory:
    """What the map navigator remembers between readings.

    Parameters
    ----------
    target : Index of the current tag in the mission's list.
    belief : The robot's pose; None before the first reading.
    plan : Ways [m] and turns [rad] of the next periods, when it backs off.
    aside_m : (2,) float64 or None — Where it drives for readings from other places [m].
    aside_left : For how many periods at most it still does so.
    searches : How often it stood at the tag and was not sure, on this leg.
    """

    target: int
    belief: PoseBelief | None = None
    plan: tuple[tuple[float, float], ...] = ()
    aside_m: FloatArray | None = None
    aside_left: int = 0
    searches: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class MapNavigator:
    """A navigator that weighs poses by the RSS of all tags, and drives round what stands about.

    A tag is reached when the estimated pose is within 2 cm of its point, as far as it is known by
    now where it hangs, nearly all particles agree on it, readings do not contradict it, and the 95
    % circle of the estimate, the survey's error of the tag included, lies within the arrival
    radius. The particles' spread already contains what the map is known not to know, since that is
    part of their likelihood. There but not sure, the robot drives aside and back: readings from new
    places decide. Where the pose is open it drives on from the likeliest one, and where it touches
    something it backs off.

    Parameters
    ----------
    hears : Ids of all tags that are read at every place, in the order of the filter's maps.
    targets : For each tag of the mission its number among those.
    filter : Of the pose.
    follower : Ways to the tags.
    start_pose : (3,) float64 or None — x, y [m], heading [rad] at the mission's start; None: it may
        be anywhere.
    arrival_radius_m : The 95 % circle lies within this [m].
    tag_sd_m : Deviation of the survey of a tag's point along x and y [m].
    """

    hears: tuple[str, ...]
    targets: tuple[int, ...]
    filter: PoseFilter
    follower: Follower
    start_pose: FloatArray | None
    arrival_radius_m: float
    tag_sd_m: float = 0.02

    def begin(
        self,
        target: int,
        before: MapMemory | None,
        *,
        heading_rad: float,  # noqa: ARG002
    ) -> MapMemory:
        """Return what is remembered at the beginning of a leg; the belief goes on."""
        self.follower.check_target(target)
        if before is None:
            return MapMemory(target=target)
        return replace(before, target=target, plan=(), aside_m=None, searches=0)

    def decide(
        self,
        memory: MapMemory,
        rss_w: FloatArray,
        odometry: Odometry,
        rng: np.random.Generator,
    ) -> Decision[MapMemory]:
        """Return the command for the coming period, or that the tag is reached.

        Parameters
        ----------
        memory, odometry, rng : As for every navigator.
        rss_w : (t, n) float64 — One reading of every tag of ``hears`` [W].
        """
        belief = memory.belief
        if belief is None:
            belief = self.filter.start(rng, pose=self.start_pose)
        belief = self.filter.moved(belief, odometry, rng)
        belief = self.filter.observed(belief, rss_w, rng)
        estimate = self.filter.estimate(belief)
        memory = replace(memory, belief=belief)
        pose, target = estimate.pose, memory.target
        offset_m = self.filter.offsets_m(belief)[self.targets[target], :2]
        place_m = _seen_from(pose, self.follower.plan.goals_m[target] + offset_m)
        lost, end_m = self.filter.lost(belief), self.follower.end_m(target, offset_m)
        if math.dist(pose[:2], end_m) <= _THERE_M:
            if self._sure(estimate, lost=lost):
                return Decision(
                    rates=np.zeros(2),
                    memory=memory,
                    reached=True,
                    mode="stopped",
                    place_m=place_m,
                    pose=pose,
                )
            if not memory.plan and memory.aside_m is None:
                memory = replace(
                    memory,
                    aside_m=self._aside(pose, memory.searches, rng),
                    aside_left=_SEARCH_STEPS,
                    searches=memory.searches + 1,
                )
        if odometry.contact and not memory.plan:
            memory = replace(memory, plan=backing_off(self.follower, rng))
        if memory.plan:
            (way, turn), *later = memory.plan
            mode: Mode = "evade"
            memory = replace(memory, plan=tuple(later))
        elif memory.aside_m is not None:
            way, turn, _ = self.follower.to_point(pose, memory.aside_m)
            mode = "search"
            near = math.dist(pose[:2], memory.aside_m) <= self.follower.cruise_step_m
            if near or memory.aside_left <= 1:
                memory = replace(memory, aside_m=None)
            memory = replace(memory, aside_left=memory.aside_left - 1)
        else:
            way, turn, mode = self.follower.step(pose, target, end_m, spread_m=estimate.spread_m)
        return Decision(
            rates=self.follower.rates(way, turn),
            memory=memory,
            reached=False,
            mode="search" if lost and mode == "navigation" else mode,
            place_m=place_m,
            pose=pose,
        )

    def learned(self, memory: MapMemory) -> Learned | None:
        """Return what the next mission can use; None: nothing that is sure.

        Parameters
        ----------
        memory : At the end of a mission.
        """
        if memory.belief is None:
            return None
        return self.filter.learned(memory.belief, self.hears)

    def taught(self, known: Learned) -> "MapNavigator":
        """Return the navigator with what earlier missions have found.

        Parameters
        ----------
        known : Of the tags that it hears, in that order [m], [dB].
        """
        return replace(self, filter=self.filter.taught(known))

    def protection_m(self, estimate: PoseEstimate) -> float:
        """Return the radius around the tag's point that holds the robot with 95 % [m].

        Parameters
        ----------
        estimate : The pose, when it is at the tag.
        """
        return SURE_SDS * math.hypot(estimate.spread_m, self.tag_sd_m)

    def _sure(self, estimate: PoseEstimate, *, lost: bool) -> bool:
        near = self.protection_m(estimate) <= self.arrival_radius_m
        return near and estimate.share >= _LEAST_SHARE and not lost

    def _aside(self, pose: FloatArray, number: int, rng: np.random.Generator) -> FloatArray:
        """Return a free place beside the tag, each time farther, (2,) [m]."""
        first, further = _SEARCH_M
        radius = first + further * min(number, 5)
        for side in rng.uniform(-np.pi, np.pi, _SEARCH_SIDES):
            point: FloatArray = pose[:2] + radius * np.array([math.cos(side), math.sin(side)])
            if self.follower.plan.sees(pose[:2], point):
                return point
        return pose[:2]


def _seen_from(pose: FloatArray, point_m: FloatArray) -> FloatArray:
    """Return a point of the room ahead of the robot and to its left [m]."""
    away = point_m - pose[:2]
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return np.array([c * away[0] + s * away[1], c * away[1] - s * away[0]])


@dataclass(frozen=True, slots=True, kw_only=True)
class CountingMemory:
    """What a navigator by dead reckoning remembers.

    Parameters
    ----------
    target : Index of the current tag in the mission's list.
    pose : (3,) float64 — Where it believes to be, x, y [m], heading [rad].
    plan : Ways [m] and turns [rad] of the next periods, when it backs off.
    """

    target: int
    pose: FloatArray
    plan: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class CountingNavigator:
    """A navigator by dead reckoning alone: it knows start and tags, and never looks at a reading.

    What it reaches says how much the readings of another navigator are worth.

    Parameters
    ----------
    follower : Ways to the tags.
    start_pose : (3,) float64 — x, y [m], heading [rad] at the mission's start.
    method : How a period's motion is added up, as in `motion.move`.
    """

    follower: Follower
    start_pose: FloatArray
    method: Integration = "exact"

    def begin(
        self,
        target: int,
        before: CountingMemory | None,
        *,
        heading_rad: float,  # noqa: ARG002
    ) -> CountingMemory:
        """Return what is remembered at the beginning of a leg."""
        self.follower.check_target(target)
        if before is None:
            return CountingMemory(target=target, pose=self.start_pose)
        return replace(before, target=target, plan=())

    def decide(
        self,
        memory: CountingMemory,
        rss_w: npt.NDArray[np.float64],  # noqa: ARG002
        odometry: Odometry,
        rng: np.random.Generator,
    ) -> Decision[CountingMemory]:
        """Return the command for the coming period, or that the tag should be reached."""
        pose = move(
            memory.pose,
            distance_m=odometry.distance_m,
            turn_rad=odometry.turn_rad,
            method=self.method,
        )
        memory = replace(memory, pose=pose)
        place_m = _seen_from(pose, self.follower.plan.goals_m[memory.target])
        end_m = self.follower.plan.ends_m[memory.target]
        if math.dist(pose[:2], end_m) <= _THERE_M:
            return Decision(
                rates=np.zeros(2),
                memory=memory,
                reached=True,
                mode="stopped",
                place_m=place_m,
                pose=pose,
            )
        if odometry.contact and not memory.plan:
            memory = replace(memory, plan=backing_off(self.follower, rng))
        if memory.plan:
            (way, turn), *later = memory.plan
            memory = replace(memory, plan=tuple(later))
            mode: Mode = "evade"
        else:
            way, turn, mode = self.follower.step(pose, memory.target, end_m)
        return Decision(
            rates=self.follower.rates(way, turn),
            memory=memory,
            reached=False,
            mode=mode,
            place_m=place_m,
            pose=pose,
        )
