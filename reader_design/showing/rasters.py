"""Rasters over a floor as files of other programs: GeoTIFF, PNG with world file, ROS maps.

A raster's columns run along x and its rows along y; images have the greatest y in their first row.
"""

import io
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import ConfigError
from octant.geometries.files import whole_file, write_text

FloatArray = npt.NDArray[np.float64]

FilterKind = Literal["keepout", "speed percent", "speed", "binary"]
FILTER_TYPES: dict[FilterKind, int] = {"keepout": 0, "speed percent": 1, "speed": 2, "binary": 3}
"""Numbers of Nav2's costmap filters, as its costmap filter info server takes them."""
MASK_TOP, MASK_UNKNOWN = 100, 255
"""Greatest value of an occupancy grid, and the pixel that ``mode: raw`` reads as unknown (-1)."""
FREE_PIXEL, OCCUPIED_PIXEL, UNKNOWN_PIXEL = 254, 0, 205
"""Pixels of an occupancy map in ``mode: trinary``, as ROS' map saver writes them."""
_SAME_CELL = 1e-6

_PIXEL_SCALE, _TIEPOINT, _GEO_KEYS, _GEO_TEXT, _NO_DATA = 33550, 33922, 34735, 34737, 42113
_DESCRIPTION = 270
_MODEL_TYPE, _RASTER_TYPE, _CITATION = 1024, 1025, 1026
_PROJECTED_SYSTEM, _LENGTH_UNIT = 3072, 3076
_USER_DEFINED, _PROJECTED, _AREA, _METRE = 32767, 1, 1, 9001


@dataclass(frozen=True, slots=True, kw_only=True)
class Raster:
    """One value in each cell of a floor.

    Parameters
    ----------
    x_m, y_m : (nx,), (ny,) float64 — Cell centres, evenly spaced and rising [m].
    values : (nx, ny) float64 — In ``unit``; NaN: no value.
    name, unit : What it is, and its unit; ``1`` for none.
    """

    x_m: FloatArray
    y_m: FloatArray
    values: FloatArray
    name: str
    unit: str

    def __post_init__(self) -> None:
        for name in ("x_m", "y_m"):
            array = frozen_array(getattr(self, name), name=name, shape=(None,))
            object.__setattr__(self, name, array)
        shape = (len(self.x_m), len(self.y_m))
        values = np.array(self.values, dtype=np.float64)
        if values.shape != shape or max(shape) < 2:
            msg = (
                f"a raster of {shape[0]} x {shape[1]} cells has values of shape {values.shape}, "
                "but one value a cell, and two cells or more along x or y, are needed; choose a "
                "finer map.spacing_m."
            )
            raise ConfigError(msg)
        values.setflags(write=False)
        object.__setattr__(self, "values", values)

    @property
    def cell_m(self) -> tuple[float, float]:
        """Width of a cell along x and y [m]; along an axis of one cell as along the other."""
        widths = [
            float(axis[-1] - axis[0]) / (len(axis) - 1) if len(axis) > 1 else 0.0
            for axis in (self.x_m, self.y_m)
        ]
        return widths[0] or widths[1], widths[1] or widths[0]

    @property
    def low_m(self) -> tuple[float, float]:
        """Outer corner of the cell of least x and y [m]."""
        width, depth = self.cell_m
        return float(self.x_m[0]) - 0.5 * width, float(self.y_m[0]) - 0.5 * depth

    @property
    def high_y_m(self) -> float:
        """Upper edge of the image's first row [m]."""
        return float(self.y_m[-1]) + 0.5 * self.cell_m[1]

    @property
    def image(self) -> FloatArray:
        """Values as an image, (ny, nx), the greatest y first [unit]."""
        return self.values.T[::-1]

    def squared(self) -> "Raster":
        """Return the same with square cells, as wide as the narrower side [m].

        Cells that are square already stay; others take the value of the cell around their centre,
        and reach beyond the last one by less than a cell, without a value there.
        """
        width, depth = self.cell_m
        if abs(width - depth) <= _SAME_CELL * width:
            return self
        side = min(width, depth)
        axes: list[FloatArray] = []
        places: list[npt.NDArray[np.int64]] = []
        for axis, low, cell in zip((self.x_m, self.y_m), self.low_m, self.cell_m, strict=True):
            count = math.ceil(len(axis) * cell / side - _SAME_CELL)
            centres = low + side * (np.arange(count, dtype=np.float64) + 0.5)
            axes.append(centres)
            places.append(np.floor((centres - low) / cell).astype(np.int64))
        values = np.full((len(axes[0]), len(axes[1])), np.nan)
        inside = [
            place < len(axis) for place, axis in zip(places, (self.x_m, self.y_m), strict=True)
        ]
        kept = np.ix_(places[0][inside[0]], places[1][inside[1]])
        values[np.ix_(inside[0], inside[1])] = self.values[kept]
        return Raster(x_m=axes[0], y_m=axes[1], values=values, name=self.name, unit=self.unit)


def write_geotiff(
    raster: Raster,
    path: Path,
    *,
    origin_m: tuple[float, float] = (0.0, 0.0),
    epsg: int | None = None,
) -> None:
    """Write a raster as GeoTIFF: float32, one band, pixels are areas, NaN is no data.

    Infinite levels, where nothing arrives, are no data too.

    Parameters
    ----------
    raster, path : What is written, and where.
    origin_m : Easting and northing of the room's origin [m].
    epsg : Number of the projected system in metres in which that origin is given; None: the room's
        own, a local system.
    """
    from PIL import Image
    from PIL.TiffImagePlugin import ImageFileDirectory_v2
    from PIL.TiffTags import ASCII, DOUBLE, SHORT

    if epsg is not None and not 1024 <= epsg < _USER_DEFINED:
        msg = f"epsg is {epsg}, but EPSG numbers of projected systems go from 1024 to 32766."
        raise ConfigError(msg)
    citation = f"{'Room' if epsg is None else 'EPSG ' + str(epsg)}, metres|"
    keys = [
        (_MODEL_TYPE, 0, 1, _USER_DEFINED if epsg is None else _PROJECTED),
        (_RASTER_TYPE, 0, 1, _AREA),
        (_CITATION, _GEO_TEXT, len(citation), 0),
        *([] if epsg is None else [(_PROJECTED_SYSTEM, 0, 1, epsg)]),
        (_LENGTH_UNIT, 0, 1, _METRE),
    ]
    tags = ImageFileDirectory_v2()
    width, depth = raster.cell_m
    corner = (origin_m[0] + raster.low_m[0], origin_m[1] + raster.high_y_m)
    for tag, kind, value in (
        (_DESCRIPTION, ASCII, _ascii(f"{raster.name} [{raster.unit}]")),
        (_PIXEL_SCALE, DOUBLE, (width, depth, 0.0)),
        (_TIEPOINT, DOUBLE, (0.0, 0.0, 0.0, *corner, 0.0)),
        (_GEO_KEYS, SHORT, tuple(n for key in ((1, 1, 0, len(keys)), *keys) for n in key)),
        (_GEO_TEXT, ASCII, citation),
        (_NO_DATA, ASCII, "nan"),
    ):
        tags.tagtype[tag] = kind
        tags[tag] = value
    values = np.where(np.isfinite(raster.image), raster.image, np.nan).astype(np.float32)
    with whole_file(path) as part:
        Image.fromarray(values).save(
            part, format="TIFF", tiffinfo=tags, compression="tiff_adobe_deflate"
        )


def write_world_png(
    raster: Raster,
    path: Path,
    *,
    limits: tuple[float, float] | None = None,
    colours: str = "viridis",
) -> None:
    """Write a raster as PNG, one pixel a cell, and beside it ``.pgw`` with its place [m].

    Cells without a value are transparent. The texts ``low``, ``high``, ``unit`` and ``colours``
    in the file say what the colours mean.

    Parameters
    ----------
    raster, path : What is written; the PNG.
    limits : Values of the first and the last colour; None: the least and the greatest [unit].
    colours : Matplotlib colour map.
    """
    from matplotlib import colormaps
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    image = raster.image
    seen = image[np.isfinite(image)]
    low, high = limits or ((float(seen.min()), float(seen.max())) if seen.size else (0.0, 1.0))
    share = np.clip((image - low) / ((high - low) or 1.0), 0.0, 1.0)
    pixels = colormaps[colours](np.nan_to_num(share), bytes=True)
    pixels[np.isnan(image), 3] = 0
    said = PngInfo()
    for key, text in (
        ("Title", raster.name),
        ("unit", raster.unit),
        ("low", f"{low:.6g}"),
        ("high", f"{high:.6g}"),
        ("colours", colours),
    ):
        said.add_text(key, text)
    with whole_file(path) as part:
        Image.fromarray(pixels).save(part, format="PNG", pnginfo=said)
    width, depth = raster.cell_m
    lines = (width, 0.0, 0.0, -depth, float(raster.x_m[0]), float(raster.y_m[-1]))
    write_text(path.with_suffix(".pgw"), "".join(f"{value!r}\n" for value in lines))


def write_mask(
    raster: Raster,
    path: Path,
    *,
    limits: tuple[float, float] | None = None,
    kind: FilterKind = "binary",
) -> tuple[Path, ...]:
    """Write a raster as a ROS map and Nav2 costmap filter mask, and return the files.

    ``path`` is the map's yaml; beside it lie the pgm (``mode: raw``: mask values 0 to 100, 255
    where there is no value) and ``..._filter_info.yaml``, the parameters of Nav2's costmap filter
    info server: value = base + multiplier x mask. A value is rounded by half a multiplier at most.

    Parameters
    ----------
    raster, path : What is written, on square cells (`Raster.squared`); the file ending in .yaml.
    limits : Values of mask 0 and 100; None: the whole numbers around the finite ones [unit].
    kind : For which filter of Nav2 the mask is.
    """
    square = raster.squared()
    image = square.image
    seen = image[np.isfinite(image)]
    if limits is None:
        limits = (math.floor(seen.min()), math.ceil(seen.max())) if seen.size else (0.0, 1.0)
    base, multiplier = limits[0], ((limits[1] - limits[0]) or 1.0) / MASK_TOP
    known = ~np.isnan(image)
    mask = np.full(image.shape, MASK_UNKNOWN, dtype=np.uint8)
    scaled = np.clip((image[known] - base) / multiplier, 0.0, MASK_TOP)
    mask[known] = np.rint(scaled).astype(np.uint8)
    head = (
        f"# {_ascii(raster.name)} [{_ascii(raster.unit)}] = "
        f"{base:.10g} + {multiplier:.10g} * value; unknown: no value\n"
    )
    written = _write_ros_map(square, mask, path, mode="raw", head=head)
    info = path.with_name(f"{path.stem}_filter_info.yaml")
    write_text(
        info,
        head + "costmap_filter_info_server:\n  ros__parameters:\n"
        f"    type: {FILTER_TYPES[kind]}\n"
        "    filter_info_topic: costmap_filter_info\n    mask_topic: filter_mask\n"
        f"    base: {float(base)!r}\n    multiplier: {float(multiplier)!r}\n",
    )
    return (*written, info)


def write_occupancy(open_floor: Raster, path: Path) -> tuple[Path, ...]:
    """Write where the floor is free as a map for ROS' map_server, and return yaml and pgm.

    Parameters
    ----------
    open_floor : 1 where it is free, 0 where something stands, NaN outside the room.
    path : The file ending in .yaml.
    """
    square = open_floor.squared()
    image = square.image
    pixels = np.full(image.shape, UNKNOWN_PIXEL, dtype=np.uint8)
    pixels[image == 1.0] = FREE_PIXEL
    pixels[image == 0.0] = OCCUPIED_PIXEL
    return _write_ros_map(square, pixels, path, mode="trinary", head="")


def _write_ros_map(
    raster: Raster, pixels: npt.NDArray[np.uint8], path: Path, *, mode: str, head: str
) -> tuple[Path, Path]:
    """Write the yaml and the binary pgm of a map whose origin is its lower left corner."""
    if path.suffix not in {".yaml", ".yml"}:
        msg = f"{path} is to be a map of ROS, whose file ends in .yaml; give it that ending."
        raise ConfigError(msg)
    image = path.with_suffix(".pgm")
    content = io.BytesIO()
    content.write(f"P5\n{pixels.shape[1]} {pixels.shape[0]}\n255\n".encode("ascii"))
    content.write(np.ascontiguousarray(pixels).tobytes())
    with whole_file(image) as part:
        part.write_bytes(content.getvalue())
    x_m, y_m = (round(side, 9) for side in raster.low_m)
    write_text(
        path,
        f"{head}image: {_quoted(image.name)}\nmode: {mode}\n"
        f"resolution: {raster.cell_m[0]:.12g}\norigin: [{x_m!r}, {y_m!r}, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
    )
    return path, image


def _quoted(name: str) -> str:
    """Return a name as YAML takes it, whatever it holds."""
    doubled = name.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{doubled}"'


def _ascii(text: str) -> str:
    return text.encode("ascii", "replace").decode("ascii")
