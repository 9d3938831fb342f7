"""A pattern over all directions from its horizontal and its vertical cut."""

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.antennas.pattern_files._lines import refusal

FloatArray = npt.NDArray[np.float64]

STEP_DEG = 1.0
"""Step [deg] of the grid that two cuts are spread over."""

TWO_CUTS_WARNING = (
    "{source} holds two cuts: directions off them are interpolated, with errors of several dB"
)


def spread_two_cuts(
    horizontal_db: FloatArray, vertical_db: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return theta (181,) and phi (360,) [rad] and the levels (181, 360) [dB] from two cuts [dB].

    The horizontal cut is at azimuth 0, 1 .. 359 deg on the horizon; the vertical one on the great
    circle through the main direction at elevation 0 .. 359 deg: 90 is the zenith, 180 behind.

    The summing method, L = H(phi) + V(el), knows nothing of the vertical cut's back. Here, as in
    weighted summing, its departure from the horizon is weighted front to back, w = |phi| / 180 deg:

    L = H(phi) + (1 - w) (V(el) - V(0)) + w (V(180 deg - el) - V(180 deg)).

    Cuts that agree at their crossings and bodies of revolution come out exactly; where front and
    back are alike it is the summing method. Sources: F. Gil et al., IEEE Antennas Propag. Mag. 43
    (2001) 132-137; T. G. Vasiliadis et al., IEEE Trans. Antennas Propag. 53 (2005) 2212-2219.
    """
    theta_deg = np.arange(0.0, 180.0 + STEP_DEG, STEP_DEG)
    phi_deg = np.arange(0.0, 360.0, STEP_DEG)
    elevation = np.round(90.0 - theta_deg).astype(np.int64)
    front = vertical_db[elevation % 360] - vertical_db[0]
    back = vertical_db[(180 - elevation) % 360] - vertical_db[180]
    weight = np.minimum(phi_deg, 360.0 - phi_deg) / 180.0
    level = horizontal_db + np.outer(front, 1.0 - weight) + np.outer(back, weight)
    # the sum of two cuts must not rise above what either of them shows
    level = np.minimum(level, max(float(horizontal_db.max()), float(vertical_db.max())))
    return np.radians(theta_deg), np.radians(phi_deg), level


def closed_cut(path: Path, line: int, angle_deg: FloatArray, level_db: FloatArray) -> FloatArray:
    """Return a cut [dB] at 0, 1 .. 359 deg, linear in dB, from ascending angles of any turn."""
    step = np.diff(angle_deg)
    if len(angle_deg) < 2 or (step <= 0.0).any() or angle_deg[-1] - angle_deg[0] > 360.0 + 1e-6:
        what = "the cut's angles must ascend once around, each given once; sort them."
        raise refusal(path, line, what)
    if max(float(step.max()), 360.0 - float(angle_deg[-1] - angle_deg[0])) > 30.0:
        raise refusal(path, line, "the cut leaves a gap of more than 30 deg; angles are missing.")
    wanted = np.arange(0.0, 360.0)
    if math.isclose(angle_deg[-1] - angle_deg[0], 360.0, abs_tol=1e-6):
        angle_deg, level_db = angle_deg[:-1], level_db[:-1]
    closed: FloatArray = np.interp(wanted, angle_deg, level_db, period=360.0)
    return closed
