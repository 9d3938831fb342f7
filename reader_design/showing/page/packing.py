"""Arrays for the scripts of a page: rounded to equal steps and deflated."""

import base64
import zlib
from typing import Any

import numpy as np
import numpy.typing as npt


def packed(values: npt.ArrayLike, *, step: float, most: int = 255) -> dict[str, Any]:
    """Return an array in whole steps above its least value, deflated, as its page unpacks it.

    Parameters
    ----------
    values : Array of any shape [any unit]; what is not finite is kept as "none".
    step : Rounding [in the array's unit]; made coarser where ``most`` steps do not span the array.
    most : 255 or 65535: how many steps there may be.
    """
    array = np.asarray(values, dtype=np.float64)
    finite = array[np.isfinite(array)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    step = max(step, (high - low) / (most - 1))
    whole = np.where(np.isfinite(array), np.round((array - low) / step), most)
    kind = np.dtype("<u1") if most == 255 else np.dtype("<u2")
    data = zlib.compress(np.ascontiguousarray(whole.astype(kind)).tobytes(), 9)
    return {
        "shape": list(array.shape),
        "low": low,
        "step": step,
        "none": most,
        "bytes": kind.itemsize,
        "data": base64.b64encode(data).decode("ascii"),
    }
