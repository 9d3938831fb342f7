"""Results on disk: netCDF with units on everything, written whole or not at all."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError, ResultError
from octant.geometries.files import refuse_overwrite, whole_file
from octant.reader_design.keeping.small_netcdf import dataset_bytes
from octant.reader_design.keeping.versions import versions

if TYPE_CHECKING:
    import xarray as xr

PARTS = ("re", "im")


def variable(
    dims: Sequence[str],
    values: npt.ArrayLike,
    *,
    units: str,
    long_name: str,
    missing: str = "",
) -> "xr.Variable":
    """Return an xarray variable that says what it is, in which unit.

    Parameters
    ----------
    dims : Name of each dimension; a complex array gets a last one, ``part`` = re, im.
    values : array_like — The numbers, in the unit [``units``]; text is allowed.
    units : Unit, for example ``W``; ``1`` for a number without one.
    long_name : What it is, in words.
    missing : What NaN means, for example ``no path``; without it the variable may have none.
    """
    import xarray as xr

    if not units or not long_name:
        msg = f"A stored variable needs units and long_name, but got {units!r} and {long_name!r}."
        raise ValueError(msg)
    array, names = np.asarray(values), list(dims)
    if np.iscomplexobj(array):
        array, names = np.stack([array.real, array.imag], axis=-1), [*names, "part"]
    attributes = {"units": units, "long_name": long_name}
    if missing:
        attributes["missing"] = missing
    return xr.Variable(names, array, attrs=attributes)


def dataset(
    variables: Mapping[str, "xr.Variable"],
    *,
    coordinates: Mapping[str, "xr.Variable"] | None = None,
    study_toml: str,
    seed: int,
    title: str,
    attributes: Mapping[str, str | int | float] | None = None,
) -> "xr.Dataset":
    """Return a dataset with the study, the versions and the seed in its attributes.

    Parameters
    ----------
    variables : Made by `variable` (any unit).
    coordinates : Made by `variable`; ``part`` is added where a variable is complex.
    study_toml : The resolved study.
    seed : The seed in force.
    title : What the file holds.
    attributes : Further attributes [-].
    """
    import xarray as xr

    coords: dict[str, xr.Variable] = dict(coordinates or {})
    if any("part" in v.dims for v in variables.values()):
        coords["part"] = variable(
            ["part"], list(PARTS), units="1", long_name="part of a complex number"
        )
    for name, item in {**variables, **coords}.items():
        if not item.attrs.get("units") or not item.attrs.get("long_name"):
            msg = f"{name} has no units or long_name; make it with showing.netcdf.variable."
            raise ValueError(msg)
    attrs = {"title": title, "study": study_toml, "seed": seed, **versions(), **(attributes or {})}
    return xr.Dataset(dict(variables), coords=coords, attrs=attrs)


def write_dataset(data: "xr.Dataset", path: Path, *, force: bool) -> None:
    """Write a dataset as netCDF4, whole or not at all.

    Parameters
    ----------
    data : Every variable and coordinate with ``units`` and ``long_name``.
    path : The file.
    force : False: refuse when the file exists.
    """
    refuse_overwrite(path, force=force)
    for name, item in data.variables.items():
        if not item.attrs.get("units") or not item.attrs.get("long_name"):
            msg = f"{name} has no units or long_name; make it with showing.netcdf.variable."
            raise ValueError(msg)
        _refuse_unsound(str(name), item)
    with whole_file(path) as part:
        part.write_bytes(dataset_bytes(data))


def _refuse_unsound(name: str, item: "xr.Variable") -> None:
    """Refuse NaN that means nothing, and infinity that is not the level of no power."""
    values = item.to_numpy()
    if values.dtype.kind != "f":
        return
    wrong = np.isposinf(values)
    if "dB" not in item.attrs["units"]:
        wrong |= np.isneginf(values)
    if "missing" not in item.attrs:
        wrong |= np.isnan(values)
    if wrong.any():
        first = ", ".join(
            f"{dim} {i}" for dim, i in zip(item.dims, np.argwhere(wrong)[0], strict=True)
        )
        msg = (
            f"{name} has {int(wrong.sum())} values of {values.size} that cannot be true, first at "
            f"{first}, so that the file is not written; report it with the study."
        )
        raise ResultError(msg)


def inputs_of(path: Path) -> str:
    """Return the digest of what a file was made from, as its writer put it in; none: empty.

    Parameters
    ----------
    path : A netCDF4 file with the attribute ``inputs``, or anything else.
    """
    import h5py

    try:
        with h5py.File(path, "r") as file:
            return str(file.attrs.get("inputs", ""))
    except (OSError, ValueError, KeyError, RuntimeError):
        return ""


def read_dataset(path: Path) -> "xr.Dataset":
    """Return the dataset of a file, loaded into memory.

    Parameters
    ----------
    path : A netCDF4 file.
    """
    import xarray as xr

    if not path.is_file():
        msg = f"{path} does not exist; give the path of a results file."
        raise ConfigError(msg)
    try:
        return xr.load_dataset(path, engine="h5netcdf")
    except OSError as exc:
        msg = f"{path} is not a netCDF4 file; give one that Octant wrote."
        raise ConfigError(msg) from exc
