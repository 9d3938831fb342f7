"""Power of all antennas of a reader from tags that do not hang exactly where they should.

A `FieldMap` is of one place of the tag. What a path's field becomes when the tag hangs elsewhere by
some centimetres follows from its direction at the tag: its length, and so its phase; amplitude,
polarisation and what is lit stay, which holds while the offset is small beside the distances to
walls and rims. The power of thousands of poses and offsets is then summed path by path.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.medium.radio_scene import RadioScene
from octant.em.power import _path_map_kernels
from octant.em.power.field_maps import MapPlan
from octant.em.power.node_paths import NodePaths
from octant.geometries._arrays import frozen_array, read_only

FloatArray = npt.NDArray[np.float64]

_PHASES = 8192
_CLOSE = 0.4
"""Poses within so many wavelengths [-] share what changes little between them: at 5 cm and 2 m from
the tag the ways by its offset of 5 cm change by 1 mm."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PathMap:
    """The paths of one tag over a floor, for a tag that may hang a little elsewhere.

    Parameters
    ----------
    node_x_m, node_y_m, reader_z_m : Coarse grid, and height of the reader's centre [m].
    start, image : (nodes + 1,) int64, (k,) int32 — Where each node's paths begin; their images [-].
    images, moves : (i, 7), (i, 4, 3) float64 — Image points [m], and how they move with the tag
        [-], as in `NodePaths`.
    fields : (c, k, 3) complex64 — Field of each path without phase, at every channel [-].
    patterns : (c, T, P + 1, 4 n) float32 — Real and imaginary parts of all antennas' theta
        patterns, and of their phi patterns, phases at the reader's centre [-].
    wavenumbers_per_m : (c,) float64 — 2 pi over the wavelengths [1/m].
    power_w : What the tag sends [W].
    """

    node_x_m: FloatArray
    node_y_m: FloatArray
    reader_z_m: float
    start: npt.NDArray[np.int64]
    image: npt.NDArray[np.int32]
    images: FloatArray
    moves: FloatArray
    fields: npt.NDArray[np.complex64]
    patterns: npt.NDArray[np.float32]
    wavenumbers_per_m: FloatArray
    power_w: float

    def __post_init__(self) -> None:
        for name, dtype in (
            ("node_x_m", np.float64),
            ("node_y_m", np.float64),
            ("start", np.int64),
            ("image", np.int32),
            ("images", np.float64),
            ("moves", np.float64),
            ("fields", np.complex64),
            ("patterns", np.float32),
            ("wavenumbers_per_m", np.float64),
        ):
            array = np.ascontiguousarray(getattr(self, name), dtype=dtype)
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    def shifted_w(self, poses: npt.ArrayLike, offsets_m: npt.ArrayLike) -> FloatArray:
        """Return the RSS of all antennas for every place that the tag may have, (m, k, n) [W].

        Parameters
        ----------
        poses : (m, 3) float64 — x, y [m] and heading [rad] of the robot.
        offsets_m : (k, 3) float64 — From the tag's surveyed place to where it may hang [m].
        """
        pose = frozen_array(poses, name="poses", shape=(None, 3))
        offset = frozen_array(offsets_m, name="offsets_m", shape=(None, 3))
        out = np.zeros((len(pose), len(offset), self.patterns.shape[3] // 4))
        close_m = _CLOSE * 2.0 * math.pi / float(self.wavenumbers_per_m.max())
        member, group = _groups(pose[:, :2], close_m)
        x, y = self.node_x_m, self.node_y_m
        grid = (
            np.array([x[0], y[0]]), np.array([x[1] - x[0], y[1] - y[0]]), np.array([len(x), len(y)])
        )  # fmt: skip
        for field, table, turn in zip(
            self.fields, self.patterns, self.wavenumbers_per_m, strict=True
        ):
            _path_map_kernels.add_shifted_power(
                pose, member, group, offset, *grid, self.reader_z_m, self.start, self.image, field,
                self.images, self.moves, turn, table, _PHASORS,
                self.power_w / len(self.fields), out,
            )  # fmt: skip
        return out


def make_path_map(
    paths: NodePaths,
    radios: Sequence[RadioScene],
    responses: Sequence[ReaderResponse],
    plan: MapPlan,
    *,
    tag_power_w: float,
    reader_z_m: float,
) -> PathMap:
    """Return the paths of one tag as antennas receive them, for a tag that may hang elsewhere.

    Parameters
    ----------
    paths : Of the tag to the plan's nodes; `NodePaths.strongest` are enough.
    radios, responses : The room and the reader, each at every channel.
    plan : From `plan_map` [m].
    tag_power_w : What the tag sends [W].
    reader_z_m : Height of the reader's centre in the room's frame [m].
    """
    return PathMap(
        node_x_m=plan.node_x_m,
        node_y_m=plan.node_y_m,
        reader_z_m=reader_z_m,
        start=paths.start,
        image=paths.image.astype(np.int32),
        images=paths.images,
        moves=paths.moves,
        fields=np.array(paths.fields),
        patterns=np.array([_pattern_table(response) for response in responses]),
        wavenumbers_per_m=np.array([2.0 * math.pi / radio.wavelength_m for radio in radios]),
        power_w=tag_power_w,
    )


def _groups(
    places_m: FloatArray, close_m: float
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the numbers (m,) of places in the order of squares, and where each square begins."""
    if len(places_m) == 1:
        return np.zeros(1, dtype=np.int64), np.array([0, 1])
    cells = np.floor((places_m - places_m.mean(axis=0)) / close_m + 0.5).astype(np.int64)
    number = cells @ np.array([1_000_003, 1])
    member = np.argsort(number, kind="stable")
    begins = np.flatnonzero(np.diff(number[member])) + 1
    return member, np.concatenate([[0], begins, [len(member)]])


def _pattern_table(response: ReaderResponse) -> npt.NDArray[np.float32]:
    """Return (T, P + 1, 4 n) of the patterns, the first azimuth once more at the end."""
    pattern = response.pattern_at_centre
    table = np.moveaxis(np.stack([pattern.real, pattern.imag]), (3, 4, 2, 0, 1), (0, 1, 2, 3, 4))
    table = np.concatenate([table, table[:, :1]], axis=1)
    return table.reshape(*table.shape[:2], -1).astype(np.float32)


def _phasors() -> npt.NDArray[np.float32]:
    angle = 2.0 * math.pi / _PHASES * np.arange(_PHASES)
    table: npt.NDArray[np.float32] = read_only(
        np.column_stack([np.cos(angle), -np.sin(angle)]).astype(np.float32)
    )
    return table


_PHASORS = _phasors()
