"""Arrays for the scripts of a page: rounded to equal steps and deflated."""

import base64
import io
import zlib
from typing import Any

import numpy as np
import numpy.typing as npt

FIGURE_WIDTH = 1080
"""Greatest width of an image in a page [pixels]; the file beside it keeps its own."""
_COLOURS = 128


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


def small_png(png: bytes) -> bytes:
    """Return an image in fewer pixels and colours, for a page; as given where that is no gain.

    Parameters
    ----------
    png : The image.
    """
    from PIL import Image

    with Image.open(io.BytesIO(png)) as opened:
        image = opened.convert("RGB")
    if image.width > FIGURE_WIDTH:
        height = round(image.height * FIGURE_WIDTH / image.width)
        image = image.resize((FIGURE_WIDTH, height), Image.Resampling.LANCZOS)
    out = io.BytesIO()
    image.quantize(_COLOURS, dither=Image.Dither.NONE).save(out, "PNG", compress_level=6)
    small = out.getvalue()
    return small if len(small) < len(png) else png
