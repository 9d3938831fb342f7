"""The height of the plates swept, scored by a function of one's own; it resumes by itself."""

import numpy as np

import octant


def front_to_back_db(study: octant.Study) -> float:
    """Return the gain of antenna 1 to the front over that to the back [dB]."""
    gain = abs(study.solve(step_deg=5.0, progress=False).pattern.sel(theta=90.0, antenna=1)) ** 2
    front, back = (float(gain.sel(phi=phi).sum()) for phi in (0.0, 180.0))
    return float(10.0 * np.log10(front / back))


reader = octant.Reader(response="rays")
heights = {"plate_height_m": [0.02, 0.05, 0.08]}
print(octant.sweep(reader, heights, score=front_to_back_db, store="plate-heights")["score"])
