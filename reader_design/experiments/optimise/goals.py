"""How near a design comes to the goals: scores over distances, slacks, one number to maximise."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.reader_design.experiments.optimise.evaluation import Evaluation
from octant.reader_design.study_file.optimise import SMALLER_IS_BETTER, Goal

BALANCE = 0.05
"""Weight of the mean slack beside the least one [-]: of two designs with the same weakest point
the one that is better elsewhere wins, so that the best one lies on the Pareto front."""

FloatArray = npt.NDArray[np.float64]

FULL_SHARE = 1.0 - 1e-12
"""A share of right antennas from here on cannot be improved [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Targets:
    """The goals, and what their scores refer to.

    Attributes
    ----------
    goals, distances_m : The goals; distances of the evaluations [m].
    reference : The study's ``[reader]``, which gains refer to; None where it has no scores.
    """

    goals: tuple[Goal, ...]
    distances_m: tuple[float, ...]
    reference: Evaluation | None

    def score(self, evaluation: Evaluation, goal: Goal) -> float:
        """Return the score that a goal names, over the distances that it names, in its unit [-].

        That is the mean of shares and front-to-back ratios, the greatest bearing error, and the
        least margin, level and gain.

        Parameters
        ----------
        evaluation, goal : A design with scores; which score, at which distances.
        """
        at = self._at(goal)
        match goal.score:
            case "right_share":
                value = evaluation.right_share[at].mean()
            case "margin_db":
                value = evaluation.margin_db[at].min()
            case "bearing_error_deg":
                value = evaluation.bearing_error_deg[at].max()
            case "front_to_back_db":
                value = evaluation.front_to_back_db[at].mean()
            case "level_dbm" | "gain_db":
                value = self.levels_db(evaluation, goal).min()
            case "footprint_m":
                value = evaluation.footprint_m
            case "height_m":
                value = evaluation.height_m
        return float(value)

    def levels_db(self, evaluation: Evaluation, goal: Goal) -> FloatArray:
        """Return (d,) levels [dBm], or gains over the reference [dB], at a goal's distances.

        Parameters
        ----------
        evaluation, goal : A design with scores; a goal of ``level_dbm`` or ``gain_db``.
        """
        at = self._at(goal)
        level: FloatArray = power_dbm(np.maximum(evaluation.level_w[at], 1e-30))
        if goal.score == "level_dbm":
            return level
        own = level if self.reference is None else power_dbm(self.reference.level_w[at])
        return level - own

    def _at(self, goal: Goal) -> list[int]:
        return [i for i, d in enumerate(self.distances_m) if not goal.at_m or d in goal.at_m]

    def scores(self, evaluation: Evaluation) -> tuple[float, ...]:
        """Return the score of each goal, in its own unit [-].

        Parameters
        ----------
        evaluation : A design with scores.
        """
        return tuple(self.score(evaluation, goal) for goal in self.goals)

    def slacks(self, evaluation: Evaluation) -> tuple[float, ...]:
        """Return by how much each goal is met, times its weight; negative where it is missed [-].

        Parameters
        ----------
        evaluation : A design with scores.
        """
        values = zip(self.goals, self.scores(evaluation), strict=True)
        return tuple(goal.weight * direction(goal) * (v - goal.value) for goal, v in values)

    def attainment(self, evaluation: Evaluation) -> float:
        """Return how well a design reaches all goals together; 0 or more: all are met [-].

        It is the least slack and `BALANCE` times their mean; minus infinity when infeasible. Goal
        attainment [1]_ with an augmented Chebyshev norm: the maximum lies on the Pareto front also
        where that is not convex. A share of 1 cannot be exceeded, so once it is reached it no
        longer counts as the least slack.

        Parameters
        ----------
        evaluation : Any design.

        References
        ----------
        .. [1] F. W. Gembicki and Y. Y. Haimes, "Approach to performance and sensitivity
           multiobjective optimization: the goal attainment method", IEEE Trans. Automatic Control
           20 (1975), 769-771.
        """
        if not evaluation.feasible:
            return -np.inf
        slacks, counts = self.slacks(evaluation), self.counting(evaluation)
        counting = [slack for slack, counted in zip(slacks, counts, strict=True) if counted]
        return min(counting) + BALANCE * float(np.mean(slacks))

    def counting(self, evaluation: Evaluation) -> tuple[bool, ...]:
        """Return which goals count for the least slack; all where none else would.

        Parameters
        ----------
        evaluation : A design with scores.
        """
        full = tuple(
            goal.score == "right_share" and score >= FULL_SHARE
            for goal, score in zip(self.goals, self.scores(evaluation), strict=True)
        )
        return tuple(all(full) or not done for done in full)

    def met(self, evaluation: Evaluation) -> tuple[bool, ...]:
        """Return which goals a design meets.

        Parameters
        ----------
        evaluation : A design with scores.
        """
        return tuple(slack >= 0.0 for slack in self.slacks(evaluation))


def direction(goal: Goal) -> float:
    """Return +1 where more of a goal's score is better, -1 where less is [-].

    Parameters
    ----------
    goal : The goal.
    """
    return -1.0 if goal.score in SMALLER_IS_BETTER else 1.0


UNITS = {
    "right_share": "",
    "margin_db": "dB",
    "bearing_error_deg": "°",
    "front_to_back_db": "dB",
    "level_dbm": "dBm",
    "gain_db": "dB",
    "footprint_m": "m",
    "height_m": "m",
}
WORDS = {
    "right_share": "share of right antennas",
    "margin_db": "worst margin over the neighbours",
    "bearing_error_deg": "bearing error of the vector sum",
    "front_to_back_db": "front-to-back ratio",
    "level_dbm": "weakest signal",
    "gain_db": "gain in signal",
    "footprint_m": "footprint",
    "height_m": "height",
}


def goal_name(goal: Goal) -> str:
    """Return a goal's score in words, such as ``gain in signal at 1, 2 m [dB]``.

    Parameters
    ----------
    goal : The goal.
    """
    where = f" at {', '.join(f'{d:g}' for d in goal.at_m)} m" if goal.at_m else ""
    unit = UNITS[goal.score]
    return f"{WORDS[goal.score]}{where}" + (f" [{unit}]" if unit else "")


def value_text(goal: Goal, value: float) -> str:
    """Return a score as a sentence shows it, with two decimals and its unit; lengths in [mm].

    Parameters
    ----------
    goal, value : Which score, and its value in the score's unit.
    """
    unit = UNITS[goal.score]
    if unit == "m":
        return f"{1e3 * value:.1f} mm"
    signed = f"{value:+.2f}" if unit == "dB" else f"{value:.2f}"
    return f"{signed}{'' if unit in {'', '°'} else ' '}{unit}"


def column_names(goals: Sequence[Goal]) -> tuple[str, ...]:
    """Return a table's column name for each goal, such as ``gain_db_at_1_2_m``.

    Parameters
    ----------
    goals : The goals.
    """
    return tuple(
        goal.score + (f"_at_{'_'.join(f'{d:g}' for d in goal.at_m)}_m" if goal.at_m else "")
        for goal in goals
    )
