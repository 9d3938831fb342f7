"""Nominal optimal control, thesis 7.2: the best inputs when nothing disturbs the robot."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.tracking import _ilqr_kernels, _optimal_kernels
from octant.navigation.tracking.descent import Descent
from octant.navigation.tracking.problem import TrackingProblem

FloatArray = npt.NDArray[np.float64]

FIRST_RATES_RAD_PER_S = ((0.1, 0.1), (3.0, 3.0), (-3.0, -3.0), (1.0, -1.0), (-1.0, 1.0))
"""First guesses: standing, forwards, backwards, left and right [rad/s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NominalSolution:
    """The nominal inputs and the way they make.

    Parameters
    ----------
    wheel_rates : (n m, 2) float64 — Right and left in every Euler step [rad/s].
    poses : (n m + 1, 3) float64 — x [m], y [m], heading [rad] at the Euler steps.
    cost, costs : J of (6.5), and (i,) float64 — J after each iteration [-].
    """

    wheel_rates: FloatArray
    poses: FloatArray
    cost: float
    costs: FloatArray

    def __post_init__(self) -> None:
        for name, shape in (
            ("wheel_rates", (None, 2)),
            ("poses", (len(self.wheel_rates) + 1, 3)),
            ("costs", (None,)),
        ):
            array = frozen_array(getattr(self, name), name=name, shape=shape, error=NavigationError)
            object.__setattr__(self, name, array)

    @property
    def iterations(self) -> int:
        """Return the number of iterations."""
        return len(self.costs)


class NominalSolver(Protocol):
    """What solves a nominal problem."""

    def solve(self, problem: TrackingProblem) -> NominalSolution:
        """Return inputs within the wheels' limits that make the cost small.

        Parameters
        ----------
        problem : What to follow, from where, with which weights.
        """


def input_cost(
    problem: TrackingProblem, wheel_rates: FloatArray
) -> tuple[float, FloatArray, FloatArray]:
    """Return cost J (6.5), gradient dJ/du (n, 2) [s/rad] and poses (n m + 1, 3) of held inputs.

    J is a left Riemann sum; the gradient, by the discrete costate, is exact for the Euler steps.

    Parameters
    ----------
    problem : The problem.
    wheel_rates : (n, 2) float64 — Right and left in every control interval [rad/s].
    """
    poses = np.empty((problem.desired.steps + 1, 3))
    gradient = np.empty((problem.intervals, 2))
    cost = _optimal_kernels.input_cost(
        np.ascontiguousarray(wheel_rates, dtype=np.float64),
        problem.start,
        problem.desired.poses,
        problem.weights.state,
        problem.weights.final,
        problem.desired.period_s,
        problem.substeps,
        problem.robot.wheel_radius_m,
        problem.robot.axle_length_m,
        poses,
        gradient,
    )
    return float(cost), gradient, poses


def gain_cost(
    problem: TrackingProblem, gains: FloatArray
) -> tuple[float, FloatArray, FloatArray, FloatArray]:
    """Return J, dJ/dK (n, 2, 3), poses (n m + 1, 3) and rates (n m, 2) of u = K q, (7.1).

    J of (6.5) is a left Riemann sum; dJ/dK, the integral of the Hamiltonian's gradient (7.20) over
    each interval, is exact for the Euler steps.

    Parameters
    ----------
    problem : The problem.
    gains : (n, 2, 3) float64 — K of every interval [rad/s per m, rad/s per rad]; u is limited.
    """
    poses = np.empty((problem.desired.steps + 1, 3))
    rates = np.empty((problem.desired.steps, 2))
    gradient = np.empty((problem.intervals, 2, 3))
    cost = _optimal_kernels.gain_cost(
        np.ascontiguousarray(gains, dtype=np.float64),
        problem.start,
        problem.desired.poses,
        problem.weights.state,
        problem.weights.final,
        problem.desired.period_s,
        problem.substeps,
        problem.robot.wheel_radius_m,
        problem.robot.axle_length_m,
        problem.robot.max_wheel_rate_rad_per_s,
        poses,
        rates,
        gradient,
    )
    return float(cost), gradient, poses, rates


@dataclass(frozen=True, slots=True, kw_only=True)
class BoundedIlqr:
    """The quickest solver: iterative LQR whose inputs keep within the wheels' limits.

    Differential dynamic programming with the Gauss-Newton Hessian and a box-constrained step
    (Tassa, Mansard and Todorov, ICRA 2014): tens of iterations of a millisecond. The cost has
    several valleys when the robot must turn round, hence the five first guesses.

    Parameters
    ----------
    iterations : At most so many from each first guess.
    tolerance : Stop when an iteration lowers the cost by less than this share [-].
    first_rates_rad_per_s : Constant rates of the searches; the best one counts [rad/s].
    """

    iterations: int = 500
    tolerance: float = 1e-10
    first_rates_rad_per_s: tuple[tuple[float, float], ...] = FIRST_RATES_RAD_PER_S

    def solve(self, problem: TrackingProblem) -> NominalSolution:
        """Return the best inputs found."""
        found = [self._search(problem, np.array(first)) for first in self.first_rates_rad_per_s]
        return min(found, key=lambda solution: solution.cost)

    def _search(self, problem: TrackingProblem, first: FloatArray) -> NominalSolution:
        limit = problem.robot.max_wheel_rate_rad_per_s
        rates = np.tile(np.clip(first, -limit, limit), (problem.intervals, 1))
        costs = np.empty(self.iterations)
        poses = np.empty((problem.desired.steps + 1, 3))
        done = _ilqr_kernels.ilqr(
            rates,
            np.zeros_like(rates),
            problem.start,
            problem.desired.poses,
            problem.weights.state,
            problem.weights.final,
            np.zeros((2, 2)),
            problem.desired.period_s,
            problem.substeps,
            problem.robot.wheel_radius_m,
            problem.robot.axle_length_m,
            limit,
            self.tolerance,
            poses,
            costs,
        )
        return NominalSolution(
            wheel_rates=np.repeat(rates, problem.substeps, axis=0),
            poses=poses,
            cost=float(costs[done - 1]),
            costs=costs[:done],
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class InputSearch:
    """A check of `BoundedIlqr`: L-BFGS-B with the adjoint gradient, up to thousands of iterations.

    Parameters
    ----------
    iterations, first_rates_rad_per_s : As of `BoundedIlqr` [rad/s].
    """

    iterations: int = 3000
    first_rates_rad_per_s: tuple[tuple[float, float], ...] = FIRST_RATES_RAD_PER_S

    def solve(self, problem: TrackingProblem) -> NominalSolution:
        """Return the best inputs found."""
        found = [self._search(problem, np.array(first)) for first in self.first_rates_rad_per_s]
        return min(found, key=lambda solution: solution.cost)

    def _search(self, problem: TrackingProblem, first: FloatArray) -> NominalSolution:
        from scipy.optimize import OptimizeResult, minimize

        limit = problem.robot.max_wheel_rate_rad_per_s
        costs: list[float] = []

        def objective(flat: FloatArray) -> tuple[float, FloatArray]:
            cost, gradient, _ = input_cost(problem, flat.reshape(-1, 2))
            return cost, gradient.ravel()

        def after(intermediate_result: OptimizeResult) -> None:
            costs.append(float(intermediate_result.fun))

        result = minimize(
            objective,
            np.tile(np.clip(first, -limit, limit), problem.intervals),
            jac=True,
            method="L-BFGS-B",
            bounds=[(-limit, limit)] * (2 * problem.intervals),
            callback=after,
            options={
                "maxiter": self.iterations,
                "maxfun": 3 * self.iterations,
                "maxcor": 10,
                "ftol": 1e-13,
                "gtol": 1e-9,
            },
        )
        rates = result.x.reshape(-1, 2)
        cost, _, poses = input_cost(problem, rates)
        return NominalSolution(
            wheel_rates=np.repeat(rates, problem.substeps, axis=0),
            poses=poses,
            cost=cost,
            costs=np.array(costs or [cost]),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class GainDescent(Descent):
    """The printed solver, thesis 7.2: gradient descent on K with momentum, thousands of iterations.

    Parameters
    ----------
    iterations, momentum : As of `Descent` [-].
    """

    iterations: int = 20000
    momentum: float = 0.98

    def solve(self, problem: TrackingProblem) -> NominalSolution:
        """Return the inputs of the best gains found."""
        if not problem.start.any():
            msg = (
                "the start is x = 0, y = 0, heading = 0, from where u = K q never moves, thesis "
                "(7.2): move the start, or solve for the inputs."
            )
            raise NavigationError(msg)

        def cost_of(gains: FloatArray) -> tuple[float, FloatArray, FloatArray]:
            cost, gradient, poses, _ = gain_cost(problem, gains)
            # Added up in the order of time: the last bit then depends on no library.
            terms = (poses[:-1] ** 2 / problem.substeps).reshape(problem.intervals, -1)
            return cost, gradient, np.cumsum(terms, axis=1)[:, -1]

        gains, costs = self.descend(cost_of, (problem.intervals, 2, 3))
        cost, _, poses, rates = gain_cost(problem, gains)
        return NominalSolution(wheel_rates=rates, poses=poses, cost=cost, costs=costs)
