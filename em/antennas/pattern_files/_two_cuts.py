"""A pattern over all directions from its horizontal and its vertical cut."""

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.antennas.pattern_files._lines import refusal

FloatArray = npt.NDArray[np.float64]

STEPS_DEG = (1.0, 0.5, 0.25, 0.2, 0.1)
"""Steps [deg] of the grid that two cuts are spread over: the first that meets all their angles."""
_SAME_DEG = 1e-4

CROSSING_DB = 0.1
"""Difference [dB] of two cuts where they cross, up to which they count as equal there."""


def spread_two_cuts(
    horizontal_db: FloatArray, vertical_db: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return theta (T,) and phi (P,) [rad] and the levels (T, P) [dB] from two cuts [dB].

    Both cuts have P levels, evenly spaced around and at whole degrees too. The horizontal cut
    starts at azimuth 0 on the horizon; the vertical one runs on the great circle through the main
    direction from elevation 0: 90 is the zenith, 180 behind.

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
    count = len(horizontal_db)
    theta_deg = np.linspace(0.0, 180.0, count // 2 + 1)
    phi_deg = np.arange(count) * (360.0 / count)
    elevation = count // 4 - np.arange(len(theta_deg))
    peak_db = max(float(horizontal_db.max()), float(vertical_db.max()))
    in_front_db, behind_db = vertical_db[0], vertical_db[count // 2]
    if abs(horizontal_db[0] - vertical_db[0]) > CROSSING_DB:
        in_front_db, behind_db = peak_db, horizontal_db[count // 2]
    front = vertical_db[elevation % count] - in_front_db
    back = vertical_db[(count // 2 - elevation) % count] - behind_db
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
    half = len(horizontal_db) // 2
    front_db, behind_db = (float(abs(horizontal_db[k] - vertical_db[k])) for k in (0, half))
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


def cut_step_deg(*angles_deg: FloatArray) -> float:
    """Return the step [deg] of `STEPS_DEG` that meets all angles of cuts; the least, if none."""
    given = np.concatenate(angles_deg)
    for step in STEPS_DEG:
        if (np.abs(given / step - np.round(given / step)) * step < _SAME_DEG).all():
            return step
    return STEPS_DEG[-1]


def closed_cut(
    path: Path, line: int, angle_deg: FloatArray, level_db: FloatArray, *, step_deg: float
) -> FloatArray:
    """Return a cut [dB] once around from 0, linear in dB, from ascending angles of any turn."""
    step = np.diff(angle_deg)
    if len(angle_deg) < 2 or (step <= 0.0).any() or angle_deg[-1] - angle_deg[0] > 360.0 + 1e-6:
        what = "the cut's angles must ascend once around, each given once; sort them."
        raise refusal(path, line, what)
    if max(float(step.max()), 360.0 - float(angle_deg[-1] - angle_deg[0])) > 30.0:
        raise refusal(path, line, "the cut leaves a gap of more than 30 deg; angles are missing.")
    wanted = np.arange(round(360.0 / step_deg)) * step_deg
    if math.isclose(angle_deg[-1] - angle_deg[0], 360.0, abs_tol=1e-6):
        angle_deg, level_db = angle_deg[:-1], level_db[:-1]
    closed: FloatArray = np.interp(wanted, angle_deg, level_db, period=360.0)
    return closed
