"""A pattern over all directions from its horizontal and its vertical cut."""

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.antennas.pattern_files._lines import refusal

FloatArray = npt.NDArray[np.float64]

STEP_DEG = 1.0
"""Step [deg] of the grid that two cuts are spread over."""

CROSSING_DB = 0.1
"""Difference [dB] of two cuts where they cross, up to which they count as equal there."""


def spread_two_cuts(
    horizontal_db: FloatArray, vertical_db: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return theta (181,) and phi (360,) [rad] and the levels (181, 360) [dB] from two cuts [dB].

    The horizontal cut is at azimuth 0, 1 .. 359 deg on the horizon; the vertical one on the great
    circle through the main direction at elevation 0 .. 359 deg: 90 is the zenith, 180 behind.

    The summing method, L = H(phi) + V(el), knows nothing of the vertical cut's back. Here, as in
    weighted summing, its departure from a level is weighted front to back, w = |phi| / 180 deg:

    L = H(phi) + (1 - w) (V(el) - a) + w (V(180 deg - el) - b).

    Where both cuts have one level in front, a = V(0) and b = V(180 deg): cuts that agree at their
    crossings and bodies of revolution come out exactly; where front and back are alike it is the
    summing method. Else the horizontal cut does not run along the horizon but through a tilted
    beam, as makers take it: a is then the maximum, which both cuts refer to, and b = H(180 deg),
    so that the vertical cut comes out. Sources: F. Gil et al., IEEE Antennas Propag. Mag. 43
    (2001) 132-137; T. G. Vasiliadis et al., IEEE Trans. Antennas Propag. 53 (2005) 2212-2219;
    Radio Mobile, "Definitions: MSI".
    """
    theta_deg = np.arange(0.0, 180.0 + STEP_DEG, STEP_DEG)
    phi_deg = np.arange(0.0, 360.0, STEP_DEG)
    elevation = np.round(90.0 - theta_deg).astype(np.int64)
    peak_db = max(float(horizontal_db.max()), float(vertical_db.max()))
    in_front_db, behind_db = vertical_db[0], vertical_db[180]
    if abs(horizontal_db[0] - vertical_db[0]) > CROSSING_DB:
        in_front_db, behind_db = peak_db, horizontal_db[180]
    front = vertical_db[elevation % 360] - in_front_db
    back = vertical_db[(180 - elevation) % 360] - behind_db
    weight = np.minimum(phi_deg, 360.0 - phi_deg) / 180.0
    level = horizontal_db + np.outer(front, 1.0 - weight) + np.outer(back, weight)
    # the sum of two cuts must not rise above what either of them shows
    level = np.minimum(level, peak_db)
    return np.radians(theta_deg), np.radians(phi_deg), level


def two_cuts_warnings(
    source: str, horizontal_db: FloatArray, vertical_db: FloatArray
) -> tuple[str, ...]:
    """Return what is in doubt about a pattern from two cuts [dB], which `spread_two_cuts` takes."""
    notes = (
        f"{source} holds two cuts: directions off them are interpolated, with errors of several dB",
    )
    front_db, behind_db = (float(abs(horizontal_db[k] - vertical_db[k])) for k in (0, 180))
    if max(front_db, behind_db) <= CROSSING_DB:
        return notes
    kept = "the vertical one comes out, the horizontal one is taken to run through a tilted beam"
    if front_db <= CROSSING_DB:
        kept = "the horizontal one comes out, the vertical one is shifted behind"
    note = (
        f"{source}: the cuts disagree by {front_db:.1f} dB in front and {behind_db:.1f} dB behind, "
        f"where they cross: {kept}"
    )
    return (*notes, note)


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
