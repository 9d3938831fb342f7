"""The last check of what leaves the radio model: finite, and no more power than was sent."""

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ResultError

ROUNDING = 1e-9
"""Share by which rounding may carry a power above what was sent [-]."""


def check_power(power_w: npt.NDArray[np.float64], sent_w: float, places_m: npt.ArrayLike) -> None:
    """Refuse received powers that are no numbers, or above what was sent; name the first place.

    Parameters
    ----------
    power_w : (m, ...) float64 — Powers [W].
    sent_w : Power that was sent [W].
    places_m : (m, 3) array_like — Where the receiver stands [m].
    """
    if power_w.size == 0:
        return
    each = power_w.reshape(len(power_w), -1)
    # NaN compares as false, so what is not shown to be sound is unsound.
    unsound = ~((each >= 0.0) & (each <= sent_w * (1.0 + ROUNDING))).all(axis=1)
    if not unsound.any():
        return
    first = int(np.argmax(unsound))
    place = ", ".join(f"{c:.6g}" for c in np.asarray(places_m)[first])
    where = f"at {int(unsound.sum())} of {len(each)} places, first at ({place}) m"
    if np.isfinite(each[first]).all():
        msg = (
            f"{each[first].max():.3g} W would be received of {sent_w:.3g} W sent {where}: the "
            "antennas stand too close together for waves that spread as from a point; move them "
            "apart, or shift the grid."
        )
    else:
        msg = (
            f"the received power cannot be computed {where}; move that place or the transmitter a "
            "little, and report it with the study."
        )
    raise ResultError(msg)
