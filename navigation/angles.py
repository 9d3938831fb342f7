"""Angles moved into one turn."""

import numpy as np
import numpy.typing as npt


def wrap_angle(angle_rad: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return angles moved into (-π, π] [rad]; -π becomes π: half a turn is counter-clockwise.

    Parameters
    ----------
    angle_rad : (...) float64 — Angles [rad].
    """
    angle = np.asarray(angle_rad, dtype=np.float64)
    return np.asarray(np.pi - np.mod(np.pi - angle, 2.0 * np.pi))
