"""Gradient descent on the gains of a feedback, with momentum and a step that converges."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError

FloatArray = npt.NDArray[np.float64]

FIRST_GAIN = 1e-6
"""Every entry of K before the first iteration, thesis 7.5.1 [rad/s per m, rad/s per rad]."""

CostOfGains = Callable[[FloatArray], tuple[float, FloatArray, FloatArray]]
"""Gains (n, 2, s) -> cost, gradient (n, 2, s), and the mean square (n,) of what they multiply."""

_FASTER, _SLOWER = 1.02, 0.5
_LEAST_SQUARE = 1e-300


@dataclass(frozen=True, slots=True, kw_only=True)
class Descent:
    """The five steps of thesis 6.4 and 7.2, with a step that converges.

    ΔK = -ε H_K with the printed "0 < ε < 1" converges only below about 1e-9. Here ε multiplies H_K
    T / |z|², where z is what the gains multiply, and so acts on the wheel rates, without a unit. It
    grows by 2 % after every iteration that lowers the cost; after one that does not it is halved,
    and the descent goes on from the best gains without momentum.

    Parameters
    ----------
    iterations : At most so many.
    momentum : λ of the update, from 0 to below 1 [-].
    first_step : ε before the first iteration [-].
    tolerance : δ_1 and δ_2 of step 5: stop at a cost, or a squared gradient, below it [-].
    """

    iterations: int
    momentum: float
    first_step: float = 0.01
    tolerance: float = 1e-12

    def __post_init__(self) -> None:
        if not (self.iterations >= 1 and 0.0 <= self.momentum < 1.0 and self.first_step > 0.0):
            msg = (
                f"iterations is {self.iterations}, momentum {self.momentum} and first_step "
                f"{self.first_step}, but they must be at least 1, from 0 to below 1 and positive: "
                "correct the one that is not."
            )
            raise NavigationError(msg)

    def descend(
        self, cost_of: CostOfGains, shape: tuple[int, int, int]
    ) -> tuple[FloatArray, FloatArray]:
        """Return the best gains K (n, 2, s) and the cost J (i,) [-] after every iteration.

        Parameters
        ----------
        cost_of : Gains to cost, gradient and |z|².
        shape : (3,) tuple of int — Of the gains: periods, wheels, states or tags.
        """
        gains = best = previous = np.full(shape, FIRST_GAIN)
        lowest, step = np.inf, self.first_step
        kept_gradient, kept_square = np.zeros(shape), np.ones(shape[0])
        costs = []
        for _ in range(self.iterations):
            cost, gradient, square = cost_of(gains)
            costs.append(cost)
            lower = cost < lowest
            if cost <= self.tolerance or np.sum(gradient * gradient) <= self.tolerance:
                best = gains if lower else best
                break
            if lower:
                best, lowest = gains, cost
                kept_gradient, kept_square = gradient, square
                step *= _FASTER
                momentum = self.momentum
            else:
                gains = previous = best
                step *= _SLOWER
                momentum = 0.0
            scale = step / np.maximum(kept_square, _LEAST_SQUARE)
            moved = gains - scale[:, None, None] * kept_gradient + momentum * (gains - previous)
            previous, gains = gains, moved
        return best, np.array(costs)
