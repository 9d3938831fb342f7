"""The file in which a tag's field map and its strongest paths are kept."""

from typing import TYPE_CHECKING

import numpy as np

from octant.em.power.field_maps import FieldMap
from octant.em.power.node_paths import NodePaths
from octant.reader_design.keeping.small_netcdf import netcdf_bytes, read_netcdf
from octant.reader_design.mapping.field_maps import TagMap

if TYPE_CHECKING:
    from octant.reader_design.keeping.small_netcdf import Stored


class TagMapCodec:
    """Keeps the map of a tag as netCDF4, with the keeper."""

    suffix = ".nc"

    def encode(self, record: TagMap, case: object) -> bytes:
        """Return the content of the file of a map."""
        del case
        field, paths = record.field, record.paths
        sizes = {
            "tag": field.tags,
            "row": field.levels.shape[3],
            "heading": field.levels.shape[4],
            "antenna": len(field.ring),
            "corner": len(paths.start),
            "path": len(paths.image),
            "image": len(paths.images),
            "part": paths.images.shape[1],
            "motion": paths.moves.shape[1],
            "axis": 3,
            "channel": len(paths.fields),
        }
        code = "0.25 dB below top_dbm at 255; 0: nothing"
        fine, coarse = ("x", "y"), ("node_x", "node_y")
        wave = ("channel", "path", "axis")
        stored: dict[str, Stored] = {
            "x": (["x"], field.x_m, "m", "x of the places"),
            "y": (["y"], field.y_m, "m", "y of the places"),
            "node_x": (["node_x"], field.node_x_m, "m", "x of the traced places"),
            "node_y": (["node_y"], field.node_y_m, "m", "y of the traced places"),
            **{
                name: ([name], np.arange(size), "1", f"number of the {name}")
                for name, size in sizes.items()
            },
            "levels": (
                ["tag", *fine, "row", "heading"],
                field.levels,
                "1",
                f"coherent RSS, {code}",
            ),
            "means": (["tag", *coarse, "row", "heading"], field.means, "1", f"local mean, {code}"),
            "ring": (["antenna"], field.ring, "1", "row of each antenna"),
            "shift": (
                ["antenna"],
                field.shift_rad,
                "rad",
                "heading of an antenna ahead of its row",
            ),
            "top": (["tag"], field.top_dbm, "dBm", "level of code 255"),
            "start": (["corner"], paths.start, "1", "where the paths of each node begin"),
            "image_of": (["path"], paths.image, "1", "image point of each path"),
            "images": (
                ["image", "part"],
                paths.images,
                "m",
                "image points, axes and radii of those that turn about an edge",
            ),
            "moves": (["image", "motion", "axis"], paths.moves, "1", "motion with the tag's"),
            "real": (wave, np.real(paths.fields), "1", "field without phase, real part"),
            "imag": (wave, np.imag(paths.fields), "1", "field without phase, imaginary part"),
        }
        return netcdf_bytes(stored, {"title": "field map of a reader's antennas by heading"})

    def decode(self, content: bytes, case: object) -> TagMap:
        """Return the map of a file."""
        del case
        found, _ = read_netcdf(content)
        field = FieldMap(
            x_m=found["x"],
            y_m=found["y"],
            levels=found["levels"],
            node_x_m=found["node_x"],
            node_y_m=found["node_y"],
            means=found["means"],
            ring=found["ring"],
            shift_rad=found["shift"],
            top_dbm=found["top"],
        )
        paths = NodePaths(
            start=found["start"],
            image=found["image_of"],
            images=found["images"],
            moves=found["moves"],
            fields=tuple(found["real"] + 1j * found["imag"]),
        )
        return TagMap(field=field, paths=paths)
