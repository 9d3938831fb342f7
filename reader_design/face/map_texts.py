"""A map as programs read its summary: one entry for each tag."""

from typing import Any

import numpy as np
import xarray as xr

from octant.em.decibels import power_dbm
from octant.reader_design.face.map_files import MapAccessor


def map_document(data: xr.Dataset, *, threshold_dbm: float | None) -> dict[str, Any]:
    """Return places, levels and coverage of each tag as plain values, units in the names.

    Parameters
    ----------
    data : The map.
    threshold_dbm : Level whose share of the floor is told [dBm]; None: it is not.
    """
    strongest = data["rss_w"].max("antenna") if "antenna" in data["rss_w"].dims else data["rss_w"]
    share = None
    if threshold_dbm is not None:
        share = np.atleast_1d(MapAccessor(data).coverage(threshold_dbm, "rss_w"))
    tags = []
    for i, tag in enumerate(data["tag"].to_numpy().tolist()):
        count = data["path_count"][i].to_numpy()
        power_w = strongest[i].to_numpy()
        heard = power_dbm(power_w[power_w > 0.0])
        levels = np.quantile(heard, (0.0, 0.5, 1.0)) if heard.size else [None] * 3
        tags.append(
            {
                "tag": tag,
                "places": count.size,
                "places_without_path": int((count == 0).sum()),
                "paths": int(count.sum()),
                **dict(zip(("lowest_dbm", "median_dbm", "highest_dbm"), levels, strict=True)),
                "covered_share": None if share is None else share[i],
            }
        )
    return {
        "receiver": data.attrs["receiver"],
        "height_m": float(data["z"]),
        "heading_deg": float(data["heading"]) if "heading" in data.coords else None,
        "threshold_dbm": threshold_dbm,
        "tags": tags,
    }
