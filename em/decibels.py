"""Power ratios in decibels and powers in dBm."""

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


def decibels(ratio: npt.ArrayLike) -> FloatArray:
    """Return 10 log10 of power ratios [dB]; zero gives -inf.

    Parameters
    ----------
    ratio : array_like — Power over power, gain over isotropic, not negative [-].
    """
    with np.errstate(divide="ignore"):
        level: FloatArray = 10.0 * np.log10(np.asarray(ratio, dtype=np.float64))
    return level


def power_dbm(power_w: npt.ArrayLike) -> FloatArray:
    """Return powers in dBm [dBm]; zero gives -inf.

    Parameters
    ----------
    power_w : array_like — Powers, not negative [W].
    """
    return decibels(power_w) + 30.0
