"""A map of received power for other programs: tables, rasters, and how much of the floor it covers.

Importing this module gives every `xarray.Dataset` the accessor ``octant``: a `MapAccessor`.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from octant.geometries.errors import ConfigError
from octant.geometries.files import whole_file
from octant.geometries.names import nearest_name
from octant.reader_design.face.rss_map import OPEN_FLOOR, with_dbm
from octant.reader_design.showing.mat_files import write_mat
from octant.reader_design.showing.rasters import (
    FilterKind,
    Raster,
    write_geotiff,
    write_mask,
    write_world_png,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]
Export = Literal["csv", "mat", "png", "geotiff", "map-server"]
EXPORTS: dict[Export, str] = {
    "csv": ".csv",
    "mat": ".mat",
    "png": ".png",
    "geotiff": ".tif",
    "map-server": ".yaml",
}
"""What a map is written as besides netCDF, and the endings of these files."""
TABLES = ("csv", "mat")
"""Of these the ones that hold everything in one file."""
COVERED, BEARING_ERROR = "covered", "bearing_error"
"""Layers whose values and colours are not those of a power."""

_UNIT_ENDINGS = {"degree": "deg", "ns": "ns"}
_WHOLE = {COVERED: (0.0, 1.0), BEARING_ERROR: (0.0, 180.0)}
_COLOURS = {COVERED: "cividis", BEARING_ERROR: "magma_r"}


def export_names(
    out: Path, kinds: Sequence[Export], layers: Sequence[str], tags: Sequence[str]
) -> list[tuple[Export, Path, str, str]]:
    """Return kind, file, layer and tag of everything that a map is written as beside its netCDF.

    Parameters
    ----------
    out, kinds : The netCDF file, whose name the others begin with; what is written.
    layers, tags : Of the rasters, one file each.
    """
    named: list[tuple[Export, Path, str, str]] = []
    for kind in kinds:
        if kind in TABLES:
            named.append((kind, out.with_suffix(EXPORTS[kind]), "", ""))
            continue
        for layer in layers:
            for tag in tags:
                file = out.with_name(f"{out.stem}_{layer}_{tag}{EXPORTS[kind]}")
                named.append((kind, file, layer, tag))
    return named


def write_exports(
    data: xr.Dataset,
    named: Sequence[tuple[Export, Path, str, str]],
    *,
    threshold_dbm: float | None = None,
) -> None:
    """Write what `export_names` lists.

    Rasters of power [dBm] are of the strongest antenna, and of the bearing error absolute [deg];
    ``covered`` is a keepout mask for Nav2, other masks are for its binary filter.

    Parameters
    ----------
    data, named : The map; what is written.
    threshold_dbm : Level from which a place is covered [dBm].
    """
    maps = MapAccessor(data)
    for kind, path, layer, tag in named:
        if kind == "csv":
            maps.to_csv(path)
        elif kind == "mat":
            maps.to_mat(path)
        elif kind == "png":
            maps.to_png(path, layer, tag=tag, threshold_dbm=threshold_dbm)
        elif kind == "geotiff":
            maps.to_geotiff(path, layer, tag=tag, threshold_dbm=threshold_dbm)
        else:
            maps.to_map_server(path, layer, tag=tag, threshold_dbm=threshold_dbm)


def coverage_lines(data: xr.Dataset, threshold_dbm: float) -> Iterator[str]:
    """Yield for each tag on how much of the floor a level is reached [%].

    Parameters
    ----------
    data, threshold_dbm : The map; the level [dBm].
    """
    powers = [
        (name, what)
        for name, what in (
            ("rss_w", "coherent"),
            ("rss_local_mean_w", "power sum over paths"),
            ("rss_disc_mean_w", "mean over a disc"),
        )
        if name in data
    ]
    shares = {what: MapAccessor(data).coverage(threshold_dbm, name) for name, what in powers}
    for i, tag in enumerate(data["tag"].to_numpy()):
        of = ", ".join(
            f"{100.0 * float(share[i]):.1f} % ({what})" for what, share in shares.items()
        )
        yield f"tag {tag}: {threshold_dbm:g} dBm or more on {of} of the floor."


@xr.register_dataset_accessor("octant")  # type: ignore[no-untyped-call]
class MapAccessor:
    """What a map of received power can be turned into, as ``map.octant``.

    A layer is a variable of the map: ``rss_dbm``, ``rss_w``, ``rss_local_mean_dbm``,
    ``bearing_error`` (as a raster absolute) ..., or ``covered``, 1 where the level
    ``threshold_dbm`` is reached and 0 elsewhere. Without ``antenna`` it is the strongest one's.
    ``tag`` and ``heading_deg`` may be left out where the map has one only. Places where no receiver
    can be have no value.

    Parameters
    ----------
    data : From `Room.rss_map` or `Study.rss_map`, or a map file that was read.
    """

    def __init__(self, data: xr.Dataset) -> None:
        if not {"x", "y", "tag"} <= set(data.dims) or "rss_w" not in data:
            msg = (
                "octant.to_... and octant.coverage are for maps over a floor (dimensions tag, x, y "
                f"and rss_w), but this dataset has {', '.join(map(str, data.dims)) or 'none'}."
            )
            raise ConfigError(msg)
        self._data = data if "rss_dbm" in data else with_dbm(data)

    def covered(self, threshold_dbm: float, layer: str = "rss_w") -> xr.DataArray:
        """Return where the strongest antenna receives a level, 1 or 0; NaN where none can be [-].

        Parameters
        ----------
        threshold_dbm : The level [dBm].
        layer : A power of the map: ``rss_w``, ``rss_local_mean_w`` or ``rss_disc_mean_w``.
        """
        if not np.isfinite(threshold_dbm):
            msg = f"threshold_dbm is {threshold_dbm!r}, but a level in dBm such as -70 is needed."
            raise ConfigError(msg)
        level = self._strongest(self._layer(f"{layer.removesuffix('_w').removesuffix('_dbm')}_dbm"))
        found = (level >= threshold_dbm).astype(np.float64).where(self._open & level.notnull())
        found.attrs = {
            "units": "1",
            "long_name": f"1 where {threshold_dbm:g} dBm or more are received",
            "missing": "no receiver can be there",
        }
        return found

    def coverage(self, threshold_dbm: float, layer: str = "rss_w") -> xr.DataArray:
        """Return the share of the floor on which a level is received, over the tags [-].

        Parameters
        ----------
        threshold_dbm, layer : As in `covered` [dBm].
        """
        share = self.covered(threshold_dbm, layer).mean(["x", "y"], skipna=True)
        share.attrs = {
            "units": "1",
            "long_name": f"share of the floor with {threshold_dbm:g} dBm or more",
        }
        return share

    def raster(
        self,
        layer: str = "rss_dbm",
        *,
        tag: str | None = None,
        antenna: int | None = None,
        heading_deg: float | None = None,
        threshold_dbm: float | None = None,
    ) -> Raster:
        """Return one layer as a raster in its unit.

        Parameters
        ----------
        layer, tag, antenna, heading_deg, threshold_dbm : As `MapAccessor` says [deg], [dBm].
        """
        if layer == COVERED:
            if threshold_dbm is None:
                msg = "the layer 'covered' needs a level; give threshold_dbm, such as -70."
                raise ConfigError(msg)
            values = self.covered(threshold_dbm)
        else:
            values = self._layer(layer)
        if layer == BEARING_ERROR:
            values = xr.apply_ufunc(np.abs, values, keep_attrs=True)
        said = values.attrs
        if antenna is not None:
            values = self._one(values, "antenna", antenna, "antenna")
        values = self._one(self._strongest(values), "tag", tag, "tag")
        values = self._one(values, "heading", heading_deg, "heading_deg").where(self._open)
        name = str(said.get("long_name", layer))
        if "tag" in values.coords:
            name += f", tag {values['tag'].item()}"
        return Raster(
            x_m=self._data["x"].to_numpy(),
            y_m=self._data["y"].to_numpy(),
            values=values.transpose("x", "y").to_numpy(),
            name=name,
            unit=str(said.get("units", "1")),
        )

    def to_geotiff(
        self,
        path: str | Path,
        layer: str = "rss_dbm",
        *,
        origin_m: tuple[float, float] = (0.0, 0.0),
        epsg: int | None = None,
        tag: str | None = None,
        antenna: int | None = None,
        heading_deg: float | None = None,
        threshold_dbm: float | None = None,
    ) -> None:
        """Write a layer as GeoTIFF, float32.

        Parameters
        ----------
        path, layer : The file, replaced where it exists; the layer.
        origin_m, epsg : Place of the room's origin in a projected system [m]; its EPSG number.
        tag, antenna, heading_deg, threshold_dbm : As in `raster` [deg], [dBm].
        """
        raster = self.raster(
            layer,
            tag=tag,
            antenna=antenna,
            heading_deg=heading_deg,
            threshold_dbm=threshold_dbm,
        )
        write_geotiff(raster, Path(path), origin_m=origin_m, epsg=epsg)

    def to_png(
        self,
        path: str | Path,
        layer: str = "rss_dbm",
        *,
        limits: tuple[float, float] | None = None,
        tag: str | None = None,
        antenna: int | None = None,
        heading_deg: float | None = None,
        threshold_dbm: float | None = None,
    ) -> None:
        """Write a layer as PNG, one pixel a place, with a world file ``.pgw`` beside it [m].

        Parameters
        ----------
        path, layer : The file, replaced where it exists; the layer.
        limits : Values of the first and the last colour, in the layer's unit [dBm], [deg].
        tag, antenna, heading_deg, threshold_dbm : As in `raster` [deg], [dBm].
        """
        raster = self.raster(
            layer,
            tag=tag,
            antenna=antenna,
            heading_deg=heading_deg,
            threshold_dbm=threshold_dbm,
        )
        colours = _COLOURS.get(layer, "viridis")
        write_world_png(raster, Path(path), limits=limits or _WHOLE.get(layer), colours=colours)

    def to_map_server(
        self,
        path: str | Path,
        layer: str = "rss_dbm",
        *,
        limits: tuple[float, float] | None = None,
        kind: FilterKind | None = None,
        tag: str | None = None,
        antenna: int | None = None,
        heading_deg: float | None = None,
        threshold_dbm: float | None = None,
    ) -> tuple[Path, ...]:
        """Write a layer for ROS' map_server and as mask of a Nav2 costmap filter; return the files.

        The mask goes from 0 to 100, and value = base + multiplier x mask; base and multiplier stand
        in the yaml and in the parameters of the costmap filter info server. ``covered`` is written
        as the opposite, 1 where the level is not reached, so that a keepout filter keeps out.

        Parameters
        ----------
        path, layer : The file ending in .yaml, replaced where it exists; the layer.
        limits : Values of mask 0 and 100, in the layer's unit [dBm], [deg]; None: around all.
        kind : For which filter; by default ``keepout`` of ``covered``, else ``binary``.
        tag, antenna, heading_deg, threshold_dbm : As in `raster` [deg], [dBm].
        """
        raster = self.raster(
            layer,
            tag=tag,
            antenna=antenna,
            heading_deg=heading_deg,
            threshold_dbm=threshold_dbm,
        )
        if layer == COVERED:
            name = raster.name.replace("1 where", "100 outside of where")
            raster = replace(raster, values=100.0 * (1.0 - raster.values), name=name)
            limits, kind = limits or (0.0, 100.0), kind or "keepout"
        limits = limits or _WHOLE.get(layer)
        return write_mask(raster, Path(path), limits=limits, kind=kind or "binary")

    def to_csv(self, path: str | Path) -> None:
        """Write everything as a table, a row for each tag, x and y (and heading) [W], [dBm], [m].

        Columns of one antenna carry its number, as ``rss_3_w`` and ``rss_3_dbm``. A cell is empty
        where there is no value, as the level where nothing arrives.

        Parameters
        ----------
        path : The file; replaced where it exists.
        """
        import pandas as pd

        data = self._data
        dims = [name for name in ("tag", "heading", "x", "y") if name in data.dims]
        shape = [data.sizes[name] for name in dims]
        places = np.meshgrid(*(np.arange(n) for n in shape), indexing="ij")
        index = {name: place.ravel() for name, place in zip(dims, places, strict=True)}
        columns: dict[str, Any] = {}
        for name, column in (("x", "x_m"), ("y", "y_m"), ("z", "z_m"), ("heading", "heading_deg")):
            if name in data.coords:
                values = data[name].to_numpy()
                columns[column] = values[index[name]] if name in index else float(values)
        columns["tag"] = data["tag"].to_numpy()[index["tag"]]
        for key, layer in data.data_vars.items():
            stem, unit = _stem_and_unit(str(key), str(layer.attrs.get("units", "1")))
            several = "antenna" in layer.dims
            inner = [d for d in dims if d in layer.dims]
            values = layer.transpose(*inner, *(["antenna"] if several else [])).to_numpy()
            rows = values[tuple(index[d] for d in inner)]
            if rows.dtype.kind == "f":
                rows = np.where(np.isfinite(rows), rows, np.nan)
            if not several:
                columns[f"{stem}{unit}"] = rows
                continue
            for i, number in enumerate(data["antenna"].to_numpy()):
                columns[f"{stem}_{number}{unit}"] = rows[:, i]
        with whole_file(Path(path)) as part:
            pd.DataFrame(columns).to_csv(part, index=False, lineterminator="\n")

    def to_mat(self, path: str | Path) -> None:
        """Write everything as a MAT file of version 5, arrays by their names [W], [dBm], [m].

        Arrays have the dimensions that the structure ``dimensions`` names, and the units of the
        structure ``units``; ``tag`` is a cell array.

        Parameters
        ----------
        path : The file; replaced where it exists.
        """
        write_mat(self._data, Path(path))

    def plot(
        self,
        layer: str = "rss_dbm",
        *,
        threshold_dbm: float | None = None,
        tag: str | None = None,
        antenna: int | None = None,
        heading_deg: float | None = None,
    ) -> "Figure":
        """Return a layer as a plan view of its room, with the contour of a level.

        Parameters
        ----------
        layer, threshold_dbm : The layer; where it is crossed a line is drawn [dBm].
        tag, antenna, heading_deg : As in `raster` [deg].
        """
        from octant.reader_design.face.map_figures import raster_figure

        raster = self.raster(
            layer,
            tag=tag,
            antenna=antenna,
            heading_deg=heading_deg,
            threshold_dbm=threshold_dbm,
        )
        return raster_figure(
            self._data,
            raster,
            limits=_WHOLE.get(layer),
            colours=_COLOURS.get(layer, "viridis"),
            contour=threshold_dbm if raster.unit == "dBm" else None,
        )

    @property
    def _open(self) -> xr.DataArray:
        """Where a receiver can be; everywhere on maps that do not say so."""
        if OPEN_FLOOR in self._data:
            return self._data[OPEN_FLOOR] > 0
        return xr.ones_like(self._data["x"] * self._data["y"], dtype=bool)

    def _layer(self, name: str) -> xr.DataArray:
        found = [str(n) for n, v in self._data.data_vars.items() if {"x", "y"} <= set(v.dims)]
        if name not in found:
            near = nearest_name(name, (*found, COVERED))
            msg = (
                f"the map has no layer {name!r}; it has {', '.join((*found, COVERED))}; "
                f"the nearest is {near!r}."
            )
            raise ConfigError(msg)
        return self._data[name]

    @staticmethod
    def _strongest(values: xr.DataArray) -> xr.DataArray:
        if "antenna" not in values.dims:
            return values
        return values.max("antenna", keep_attrs=True)

    @staticmethod
    def _one(values: xr.DataArray, dim: str, wanted: object, argument: str) -> xr.DataArray:
        """Return the part of one place of a dimension, which must be named if there are several."""
        if dim not in values.dims:
            return values
        there = values[dim].to_numpy().tolist()
        if wanted is None and len(there) == 1:
            return values.isel({dim: 0})
        if wanted not in there:
            given = "is not given" if wanted is None else f"is {wanted!r}"
            msg = f"{argument} {given}, but the map has {', '.join(map(str, there))}; choose one."
            raise ConfigError(msg)
        return values.isel({dim: there.index(wanted)})


def _stem_and_unit(name: str, units: str) -> tuple[str, str]:
    """Return a variable's name without its unit, and the unit as the ending of a column."""
    for ending in ("_w", "_dbm", "_db", "_m"):
        if name.endswith(ending):
            return name.removesuffix(ending), ending
    return name, f"_{_UNIT_ENDINGS[units]}" if units in _UNIT_ENDINGS else ""
