"""Datasets as MAT files of version 5, which MATLAB and Octave load."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from octant.geometries.files import whole_file

if TYPE_CHECKING:
    import xarray as xr

_HEAD, _HEAD_BYTES = b"MATLAB 5.0 MAT-file, written by Octant", 116
_PART = "part"


def write_mat(data: "xr.Dataset", path: Path) -> None:
    """Write all variables and coordinates by their names; the same dataset, the same bytes.

    Arrays have the dimensions that the structure ``dimensions`` names, and the units of the
    structure ``units``. Texts become cell arrays; a last dimension ``part`` (real, imaginary)
    becomes complex numbers.

    Parameters
    ----------
    data, path : The dataset; the file, replaced where it exists.
    """
    from scipy.io import savemat

    arrays: dict[str, Any] = {}
    dimensions: dict[str, str] = {}
    for key, item in (*data.coords.items(), *data.data_vars.items()):
        name, values, dims = str(key), item.to_numpy(), [str(dim) for dim in item.dims]
        if name == _PART:
            continue
        if dims[-1:] == [_PART]:
            values, dims = values[..., 0] + 1j * values[..., 1], dims[:-1]
        if values.dtype.kind in "UO":
            values = values.astype(object)
        elif values.dtype.kind == "b":
            values = values.astype(np.uint8)
        arrays[name] = values
        if key in data.data_vars:
            dimensions[name] = ", ".join(dims) or "-"
    units = {name: str(data[name].attrs.get("units", "1")) for name in arrays}
    arrays |= {"units": units, "dimensions": dimensions}
    with whole_file(path) as part:
        savemat(part, arrays, long_field_names=True, do_compression=True, oned_as="column")
        with part.open("r+b") as file:  # scipy's text there holds the time
            file.write(_HEAD.ljust(_HEAD_BYTES))
