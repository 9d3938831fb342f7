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
from octant.em.antennas.kinds import Antenna
from octant.em.medium.radio_scene import RadioScene
from octant.em.power import _path_map_kernels
from octant.em.power.node_paths import NodePaths, trace_node_paths
from octant.em.search.candidates import SolverSettings
from octant.geometries._arrays import frozen_array, read_only

FloatArray = npt.NDArray[np.float64]

_PHASES = 8192
_LEFT_OUT = 0.005


@dataclass(frozen=True, slots=True, kw_only=True)
class PathMap:
    """The paths of one tag over a floor, for a tag that may hang a little elsewhere.

    Parameters
    ----------
    node_x_m, node_y_m, reader_z_m : Coarse grid, and height of the reader's centre [m].
    start, image : (nodes + 1,) int64, (k,) int32 — Where each node's paths begin; their images [-].
    images_m, mirrors : (i, 3), (i, 3, 3) float64 — Image points [m]; by how much they move when the
        tag does [-].
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
    images_m: FloatArray
    mirrors: FloatArray
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
            ("images_m", np.float64),
            ("mirrors", np.float64),
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
        x, y = self.node_x_m, self.node_y_m
        for field, table, turn in zip(
            self.fields, self.patterns, self.wavenumbers_per_m, strict=True
        ):
            _path_map_kernels.add_shifted_power(
                pose, offset, np.array([x[0], y[0]]), np.array([x[1] - x[0], y[1] - y[0]]),
                np.array([len(x), len(y)]), self.reader_z_m, self.start, self.image, field,
                self.images_m, self.mirrors, turn, table, _PHASORS,
                self.power_w / len(self.fields), out,
            )  # fmt: skip
        return out


def trace_path_map(
    radios: Sequence[RadioScene],
    responses: Sequence[ReaderResponse],
    *,
    node_x_m: FloatArray,
    node_y_m: FloatArray,
    tag_position_m: npt.ArrayLike,
    tag_antennas: Sequence[Antenna],
    tag_power_w: float,
    reader_z_m: float,
    solver: SolverSettings,
) -> PathMap:
    """Return the paths of one tag over a floor; nothing diffracts.

    The weakest images are left out, which on average over the floor carry 0.5 % of a place's power.

    Parameters
    ----------
    radios, responses : The room and the reader, each at every channel.
    node_x_m, node_y_m, reader_z_m : Coarse grid of the floor; height of the reader's centre [m].
    tag_position_m : (3,) array_like — Surveyed place of the tag [m].
    tag_antennas, tag_power_w : Antenna at each channel; what it sends [W].
    solver : How paths are searched.
    """
    paths = trace_node_paths(
        radios, node_x_m, node_y_m, tag_position_m=np.asarray(tag_position_m, dtype=np.float64),
        tag_antennas=tag_antennas, reader_z_m=reader_z_m, solver=solver,
    )  # fmt: skip
    start, kept = _strong(paths)
    return PathMap(
        node_x_m=node_x_m,
        node_y_m=node_y_m,
        reader_z_m=reader_z_m,
        start=start,
        image=paths.image[kept].astype(np.int32),
        images_m=paths.images_m,
        mirrors=paths.mirrors,
        fields=np.array([field[kept] for field in paths.fields], dtype=np.complex64),
        patterns=np.array([_pattern_table(response) for response in responses]),
        wavenumbers_per_m=np.array([2.0 * math.pi / radio.wavelength_m for radio in radios]),
        power_w=tag_power_w,
    )


def _strong(paths: NodePaths) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.bool_]]:
    """Return where nodes begin without the weakest images, and which paths are kept."""
    power = np.sum([np.sum(np.abs(field) ** 2, axis=1) for field in paths.fields], axis=0)
    node = np.repeat(np.arange(len(paths.start) - 1), np.diff(paths.start))
    there = np.bincount(node, weights=power)
    share = np.bincount(paths.image, weights=power / there[node], minlength=len(paths.images_m))
    order = np.argsort(share, kind="stable")
    weak = np.cumsum(share[order]) <= _LEFT_OUT * share.sum()
    strong = np.ones(len(share), dtype=np.bool_)
    strong[order[weak]] = False
    kept = strong[paths.image]
    return np.concatenate([[0], np.cumsum(kept)])[paths.start], kept


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
