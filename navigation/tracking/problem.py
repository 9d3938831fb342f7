"""What a tracking controller is to minimise: the weights and the problem of thesis (6.5)."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.robot.drive import DifferentialDrive
from octant.navigation.tracking.trajectories import DesiredTrajectory

FloatArray = npt.NDArray[np.float64]


def weight_matrix(value: npt.ArrayLike, *, name: str, size: int) -> FloatArray:
    """Return a weight as a read-only matrix: given whole, or by its diagonal.

    Parameters
    ----------
    value : (size,) or (size, size) float — The weight [-].
    name : What it is called in a message.
    size : Number of rows.
    """
    rows = np.ndim(np.array(value, dtype=object))
    given = frozen_array(value, name=name, shape=(None,) * max(rows, 1), error=NavigationError)
    matrix = frozen_array(
        np.diag(given) if rows == 1 else given,
        name=name,
        shape=(size, size),
        error=NavigationError,
    )
    if not np.array_equal(matrix, matrix.T):
        msg = (
            f"{name} is {matrix.tolist()}, which is not symmetric, but a quadratic cost needs a "
            "symmetric weight: give the mean of it and its transpose."
        )
        raise NavigationError(msg)
    smallest, largest = np.linalg.eigvalsh(matrix)[[0, -1]]
    if not smallest > 1e-12 * max(largest, 0.0):
        msg = (
            f"{name} is {matrix.tolist()}, which is singular or indefinite (smallest eigenvalue "
            f"{smallest:.3g}), but the weight must be positive definite: raise its diagonal."
        )
        raise NavigationError(msg)
    return matrix


@dataclass(frozen=True, slots=True, kw_only=True)
class Weights:
    """The weights of the cost: thesis (6.5) and (7.31).

    Parameters
    ----------
    state : (3, 3) float64 — Q of the running pose error, or its diagonal [1/m², 1/rad²].
    final : (3, 3) float64 — P(t_f) of the last pose error, or its diagonal [s/m², s/rad²].
    inputs : (2, 2) float64 — R of the rates' deviation, for neighbouring control only [s²/rad²].
    """

    state: FloatArray
    final: FloatArray
    inputs: FloatArray

    def __post_init__(self) -> None:
        for name, size in (("state", 3), ("final", 3), ("inputs", 2)):
            matrix = weight_matrix(getattr(self, name), name=f"the {name} weight", size=size)
            object.__setattr__(self, name, matrix)


def tracking_weights() -> Weights:
    """Return the weights of thesis 6.5 and of its trajectories in 7.5; R is not printed."""
    return Weights(
        state=np.array([1.0, 1.0, 2.0]),
        final=np.array([0.5, 0.5, 1.0]),
        inputs=np.array([0.01, 0.01]),
    )


def stabilisation_weights() -> Weights:
    """Return the weights of thesis 7.5.2.1; R is not printed."""
    return Weights(state=np.full(3, 0.01), final=np.full(3, 2.0), inputs=np.array([0.01, 0.01]))


@dataclass(frozen=True, slots=True, kw_only=True)
class TrackingProblem:
    """A problem: follow a trajectory from a start, at the least cost (6.5).

    Parameters
    ----------
    desired : Sampled at the Euler steps with which the robot is simulated.
    start : (3,) float64 — x [m], y [m], heading [rad].
    weights : Of the cost.
    robot : The robot and its limits.
    substeps : Euler steps for which a wheel rate, or a gain, is held.
    """

    desired: DesiredTrajectory
    start: FloatArray
    weights: Weights
    robot: DifferentialDrive
    substeps: int = 1

    def __post_init__(self) -> None:
        start = frozen_array(self.start, name="start", shape=(3,), error=NavigationError)
        object.__setattr__(self, "start", start)
        if self.substeps < 1 or self.desired.steps % self.substeps:
            msg = (
                f"substeps is {self.substeps}, but it must divide the {self.desired.steps} steps "
                f"of {self.desired.name!r}: choose another number."
            )
            raise NavigationError(msg)

    @property
    def intervals(self) -> int:
        """Return the number of control intervals."""
        return self.desired.steps // self.substeps

    @property
    def period_s(self) -> float:
        """Return the length of a control interval T [s]."""
        return self.substeps * self.desired.period_s
