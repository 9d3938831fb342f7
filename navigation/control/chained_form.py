"""The unicycle in chained form: coordinates in which its motion integrates in closed form.

Textbook (11.23)-(11.25). With z₁ = θ, z₂ = x cos θ + y sin θ, z₃ = x sin θ - y cos θ and the inputs
v₁ = ω, v₂ = v - z₃ ω the kinematic model becomes ż₁ = v₁, ż₂ = v₂, ż₃ = z₂ v₁.
"""

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


def to_chained(pose: npt.ArrayLike) -> FloatArray:
    """Return z₁ [rad], z₂ [m], z₃ [m] of a pose, (..., 3), textbook (11.23).

    Parameters
    ----------
    pose : (..., 3) array_like — x [m], y [m], heading θ [rad].
    """
    given = np.asarray(pose, dtype=np.float64)
    x, y, heading = given[..., 0], given[..., 1], given[..., 2]
    cos, sin = np.cos(heading), np.sin(heading)
    return np.stack([heading, x * cos + y * sin, x * sin - y * cos], axis=-1)


def of_chained(chained: npt.ArrayLike) -> FloatArray:
    """Return the pose x [m], y [m], θ [rad] of chained coordinates, (..., 3): (11.23) inverted.

    Parameters
    ----------
    chained : (..., 3) array_like — z₁ [rad], z₂ [m], z₃ [m].
    """
    given = np.asarray(chained, dtype=np.float64)
    heading, second, third = given[..., 0], given[..., 1], given[..., 2]
    cos, sin = np.cos(heading), np.sin(heading)
    return np.stack([second * cos + third * sin, second * sin - third * cos, heading], axis=-1)


def chained_inputs(chained: npt.ArrayLike, twist: npt.ArrayLike) -> FloatArray:
    """Return v₁ = ω [rad/s] and v₂ = v - z₃ ω [m/s], (..., 2): textbook (11.24) inverted.

    Parameters
    ----------
    chained : (..., 3) array_like — z₁ [rad], z₂ [m], z₃ [m].
    twist : (..., 2) array_like — Forward speed v [m/s], turn rate ω [rad/s].
    """
    state, command = np.asarray(chained, dtype=np.float64), np.asarray(twist, dtype=np.float64)
    turn_rate = command[..., 1]
    return np.stack([turn_rate, command[..., 0] - state[..., 2] * turn_rate], axis=-1)


def chained_rate(chained: npt.ArrayLike, inputs: npt.ArrayLike) -> FloatArray:
    """Return ż₁ = v₁ [rad/s], ż₂ = v₂ [m/s], ż₃ = z₂ v₁ [m/s], (..., 3), textbook (11.25).

    Parameters
    ----------
    chained : (..., 3) array_like — z₁ [rad], z₂ [m], z₃ [m].
    inputs : (..., 2) array_like — v₁ [rad/s], v₂ [m/s], as `chained_inputs` returns them.
    """
    state, given = np.asarray(chained, dtype=np.float64), np.asarray(inputs, dtype=np.float64)
    first, second = given[..., 0], given[..., 1]
    return np.stack([first, second, state[..., 1] * first], axis=-1)


def chained_step(chained: npt.ArrayLike, twist: npt.ArrayLike, *, period_s: float) -> FloatArray:
    """Return the chained coordinates after a period of constant v and ω, in closed form.

    z₂ + i z₃ obeys ẇ = v + i ω w: it turns by ω T, and v adds a chord. The way to (11.85) that the
    textbook names; `motion.move` gives the same pose.

    Parameters
    ----------
    chained : (..., 3) array_like — z₁ [rad], z₂ [m], z₃ [m].
    twist : (..., 2) array_like — Forward speed v [m/s], turn rate ω [rad/s].
    period_s : Period T [s].
    """
    state, command = np.asarray(chained, dtype=np.float64), np.asarray(twist, dtype=np.float64)
    turn = command[..., 1] * period_s
    half = 0.5 * turn
    chord = command[..., 0] * period_s * np.sinc(half / np.pi)
    plane = (state[..., 1] + 1j * state[..., 2]) * np.exp(1j * turn) + chord * np.exp(1j * half)
    return np.stack([state[..., 0] + turn, plane.real, plane.imag], axis=-1)
