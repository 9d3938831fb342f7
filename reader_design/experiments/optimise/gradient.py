"""Refinement by derivatives: linear programs within a region that grows and shrinks.

The attainment is a least value over goals and distances. Around a design each of these is taken as
linear, and the step that attains most within the region is a linear program. The design there is
solved on a mesh of its own; it is kept where enough of what was promised comes true, and the region
follows (a trust region). Sequential linear programming suits minimax problems, whose solution lies
where as many goals as parameters meet; the ripple that every new mesh brings ends it sooner than
curvature would.

References
----------
.. [1] K. Madsen, "An algorithm for minimax solution of overdetermined systems of non-linear
   equations", IMA J. Appl. Math. 16 (1975) 321.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.reader_design.experiments.optimise.evaluation import Evaluation, Slopes
from octant.reader_design.experiments.optimise.goals import BALANCE, Targets, direction
from octant.reader_design.experiments.optimise.space import Box
from octant.reader_design.study_file.optimise import SIZES, Goal
from octant.reader_design.study_file.reader import Reader

FloatArray = npt.NDArray[np.float64]

FIRST_REGION, WIDEST = 0.15, 0.3
"""First and greatest half-width of the region, as a share of each parameter's bounds [-]."""
LAST_REGION = 0.005
"""Half-width below which the refinement ends [-]."""
LEAST_GAIN = 1e-3
"""Promised gain of attainment below which it ends [-]."""
KEPT, TRUSTED = 0.1, 0.7
"""Shares of the promised gain from which a step is kept, and the region doubled [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """What a design must not exceed.

    Attributes
    ----------
    footprint_m, height_m : Size of the ground plane; of plates and antennas above it [m].
    """

    footprint_m: float
    height_m: float


def ascend(
    box: Box,
    start: Evaluation,
    *,
    targets: Targets,
    limits: Limits,
    frequency_hz: float,
    tried: Callable[[Reader], Evaluation],
    slopes: Callable[[Reader, tuple[str, ...]], Slopes],
) -> None:
    """Try designs that attain more and more, until the region is small or nothing is promised.

    Parameters
    ----------
    box, start : Parameters with their bounds, and the design from which to go.
    targets, limits : What is to be attained, and what must not be exceeded [m].
    frequency_hz : Frequency at which antennas without a length are resonant [Hz].
    tried : Evaluates a design; may raise to end the refinement.
    slopes : Returns the derivatives of a design's scores by keys.
    """
    here, region = start, FIRST_REGION
    slope = slopes(here.design, box.names)
    while region > LAST_REGION:
        point = box.point(here.design, frequency_hz=frequency_hz)
        step, promised = best_step(here, slope, box, point, region, targets=targets, limits=limits)
        now = targets.attainment(here)
        if promised < LEAST_GAIN:
            return
        there = tried(box.design(point + step))
        gain = targets.attainment(there) - now
        if gain >= KEPT * promised:
            here, slope = there, slopes(there.design, box.names)
        region = min(2.0 * region, WIDEST) if gain >= TRUSTED * promised else region
        region = 0.5 * region if gain < KEPT * promised else region


def best_step(
    here: Evaluation,
    slope: Slopes,
    box: Box,
    point: FloatArray,
    region: float,
    *,
    targets: Targets,
    limits: Limits,
) -> tuple[FloatArray, float]:
    """Return the step [share of the bounds] that attains most by the slopes, and its gain [-].

    Parameters
    ----------
    here, slope, box : A design with its scores and their derivatives by the box's parameters.
    point, region : Its place in the unit cube, and how far each parameter may change [-].
    targets, limits : As for `ascend` [m].
    """
    from scipy.optimize import linprog

    width = np.array(box.high) - np.array(box.low)
    parameters, goals = len(width), len(targets.goals)
    counting = targets.counting(here)
    # Unknowns: the step, each goal's slack, the least slack that counts.
    rows: list[FloatArray] = []
    most: list[float] = []
    for g, goal in enumerate(targets.goals):
        for slack, gradient in _parts(here, slope, goal, targets):
            row = np.zeros(parameters + goals + 1)
            row[:parameters], row[parameters + g] = -gradient * width, 1.0
            rows.append(row)
            most.append(slack)
        if counting[g]:
            row = np.zeros(parameters + goals + 1)
            row[parameters + g], row[-1] = -1.0, 1.0
            rows.append(row)
            most.append(0.0)
    for name in SIZES:
        row = np.zeros(parameters + goals + 1)
        row[:parameters] = getattr(slope, name) * width
        rows.append(row)
        most.append(getattr(limits, name) - getattr(here, name))
    cost = np.concatenate((np.zeros(parameters), np.full(goals, -BALANCE / goals), [-1.0]))
    bounds = [
        *zip(np.maximum(-region, -point), np.minimum(region, 1.0 - point), strict=True),
        *[(None, None)] * (goals + 1),
    ]
    found = linprog(cost, A_ub=np.array(rows), b_ub=np.array(most), bounds=bounds, method="highs")
    if not found.success:
        return np.zeros(parameters), 0.0
    return found.x[:parameters], float(-found.fun) - targets.attainment(here)


def _parts(
    here: Evaluation, slope: Slopes, goal: Goal, targets: Targets
) -> list[tuple[float, FloatArray]]:
    """Return slack and gradient [per m or ohm] of each value of which a goal takes the least."""
    sign = goal.weight * direction(goal)
    if goal.score in SIZES:
        values = [(getattr(here, goal.score), getattr(slope, goal.score))]
    else:
        at = [i for i, d in enumerate(targets.distances_m) if not goal.at_m or d in goal.at_m]
        name = "level_w" if goal.score in ("level_dbm", "gain_db") else goal.score
        score, change = getattr(here, name)[at], getattr(slope, name)[:, at]
        if goal.score in ("right_share", "front_to_back_db"):
            score, change = score.mean(keepdims=True), change.mean(axis=1, keepdims=True)
        elif name == "level_w":
            change = 10.0 / math.log(10.0) * change / score
            score = targets.levels_db(here, goal)
        values = list(zip(score.tolist(), change.T, strict=True))
    return [(sign * (value - goal.value), sign * gradient) for value, gradient in values]
