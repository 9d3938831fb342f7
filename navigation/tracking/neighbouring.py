"""Neighbouring optimal control, thesis 7.3.1: Riccati gains, and what makes them stable."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.robot.drive import DifferentialDrive, linear_model
from octant.navigation.tracking.problem import Weights

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class RiccatiGains:
    """The neighbouring control's gains and its costs-to-go.

    Parameters
    ----------
    gains : (k, 2, 3) float64 — C of (7.32) in every period [rad/s per m, rad/s per rad].
    cost_to_go : (k + 1, 3, 3) float64 — P of (7.33) [s/m², s/rad²].
    """

    gains: FloatArray
    cost_to_go: FloatArray

    def __post_init__(self) -> None:
        for name, shape in (("gains", (None, 2, 3)), ("cost_to_go", (len(self.gains) + 1, 3, 3))):
            array = frozen_array(getattr(self, name), name=name, shape=shape, error=NavigationError)
            object.__setattr__(self, name, array)


def riccati_gains(
    poses: npt.ArrayLike,
    wheel_rates: npt.ArrayLike,
    robot: DifferentialDrive,
    *,
    weights: Weights,
    period_s: float,
) -> RiccatiGains:
    """Return the gains of the sampled neighbouring control along a nominal trajectory.

    Of the discrete Riccati equation with A = I + F T, B = G T, Q T and R T, which tends to thesis
    (7.33) as T becomes small; the last line of its appendix A.4 lacks P before G R⁻¹.

    Parameters
    ----------
    poses : (k, 3) float64 — Nominal x [m], y [m], heading [rad] at the sample times but the last.
    wheel_rates : (k, 2) float64 — Nominal wheel rates [rad/s].
    robot : Wheels and axle.
    weights : Q, R and P(t_f) of (7.31).
    period_s : Sample period T [s].
    """
    f, g = linear_model(poses, wheel_rates, robot)
    a, b = np.eye(3) + period_s * f, period_s * g
    state, inputs = period_s * weights.state, period_s * weights.inputs
    steps = len(a)
    gains, cost = np.empty((steps, 2, 3)), np.empty((steps + 1, 3, 3))
    cost[steps] = weights.final
    for k in range(steps - 1, -1, -1):
        pulled = b[k].T @ cost[k + 1]
        gains[k] = np.linalg.solve(inputs + pulled @ b[k], pulled @ a[k])
        closed = a[k] - b[k] @ gains[k]
        value = state + closed.T @ cost[k + 1] @ closed + gains[k].T @ inputs @ gains[k]
        cost[k] = 0.5 * (value + value.T)
    return RiccatiGains(gains=gains, cost_to_go=cost)


@dataclass(frozen=True, slots=True, kw_only=True)
class StabilityReport:
    """What Theorem 7.4 and Lemma 7.3 ask for, computed along a trajectory.

    Parameters
    ----------
    lyapunov_decay : Least share by which V = Δqᵀ P Δq / 2 falls in a period [-]; positive: stable.
    observability : Least eigenvalue of (7.37) [s/m², s/rad²]; positive: {A, D} is observable.
    controllability : Least singular value of the reachability Gramian of {A, B} [m² s²/rad², s²];
        positive: every pose error can be steered away.
    """

    lyapunov_decay: float
    observability: float
    controllability: float


def stability_report(
    poses: npt.ArrayLike,
    wheel_rates: npt.ArrayLike,
    robot: DifferentialDrive,
    *,
    riccati: RiccatiGains,
    weights: Weights,
    period_s: float,
) -> StabilityReport:
    """Return the computed conditions of Theorem 7.4 for a neighbouring control.

    A varying A has the product of the periods' transition matrices, not e^{tA(t)} as printed. Lemma
    7.3, which it calls controllability, is about observability of the cost; real controllability,
    of {A, B}, is computed beside it.

    Parameters
    ----------
    poses, wheel_rates, robot, weights, period_s : As for `riccati_gains` [m, rad], [rad/s], [s].
    riccati : Its result.
    """
    from scipy.linalg import eigh

    f, g = linear_model(poses, wheel_rates, robot)
    a, b = np.eye(3) + period_s * f, period_s * g
    closed = a - b @ riccati.gains
    decay = np.inf
    observed, reached, transition = np.zeros((3, 3)), np.zeros((3, 3)), np.eye(3)
    for k, step in enumerate(closed):
        after = step.T @ riccati.cost_to_go[k + 1] @ step
        decay = min(decay, 1.0 - float(eigh(after, riccati.cost_to_go[k], eigvals_only=True)[-1]))
        observed += period_s * transition.T @ weights.state @ transition
        transition = step @ transition
        reached = a[k] @ reached @ a[k].T + b[k] @ b[k].T
    return StabilityReport(
        lyapunov_decay=decay,
        observability=float(np.linalg.eigvalsh(observed)[0]),
        controllability=float(np.linalg.svd(reached, compute_uv=False)[-1]),
    )
