"""Paths that are kept, so that fields can be computed again with other materials and antennas.

Which paths exist is a matter of geometry; what they carry, of materials, levels and antennas. A fit
of these asks for the same links hundreds of times: the paths are searched once, and only the waves
along them are computed again.
"""

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.antennas.kinds import Antenna, make_antenna
from octant.em.blocks import Progress, run_blocks
from octant.em.medium.materials import Material
from octant.em.medium.radio_scene import RadioScene
from octant.em.paths.tracing import checked_receivers, scene_arrays, trace_paths
from octant.em.power import _kept_kernels
from octant.em.power.received_power import ReceivedPower
from octant.em.records import PathSet
from octant.em.search.candidates import Candidates
from octant.geometries._arrays import frozen_array, read_only
from octant.geometries.errors import AntennaError, GeometryError, MaterialRangeError

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

PLACES_PER_BLOCK = 64
"""Places [-] whose paths are worked out at a time: their arrays stay small."""


@dataclass(frozen=True, slots=True, kw_only=True)
class KeptPaths:
    """The paths from one source to m places, as `kept_fields` walks them.

    Parameters
    ----------
    source_m : (3,) float64 — Place of the source [m].
    places_m : (m, 3) float64 — Places of the receivers [m].
    first : (m + 1,) int64 — Paths first[i] to first[i + 1] lead to place i [-].
    start : (k + 1,) int64 — Points start[p] to start[p + 1] are those of path p [-].
    points_m : (v, 3) float64 — From each place over the interactions to the source [m].
    codes : (v - 2 k,) int64 — Interactions in the same sense, see `octant.em.records` [-].
    left_out : Greatest share [-] of a place's power, summed over paths, that was left out.
    """

    source_m: FloatArray
    places_m: FloatArray
    first: IntArray
    start: IntArray
    points_m: FloatArray
    codes: IntArray
    left_out: float = 0.0

    def __post_init__(self) -> None:
        paths = len(self.start) - 1
        for name, shape, dtype in (
            ("source_m", (3,), np.float64),
            ("places_m", (None, 3), np.float64),
            ("first", (len(self.places_m) + 1,), np.int64),
            ("start", (None,), np.int64),
            ("points_m", (None, 3), np.float64),
            ("codes", (len(self.points_m) - 2 * paths,), np.int64),
        ):
            array = frozen_array(getattr(self, name), name=name, shape=shape, dtype=dtype)
            object.__setattr__(self, name, array)

    def __len__(self) -> int:
        return len(self.start) - 1

    @property
    def place(self) -> IntArray:
        """Place that each path leads to, (k,)."""
        return np.repeat(np.arange(len(self.places_m)), np.diff(self.first))


@dataclass(frozen=True, slots=True, kw_only=True)
class ArrivingFields:
    """The waves that arrive along kept paths; any receiving antenna weighs them afterwards.

    Parameters
    ----------
    first : (m + 1,) int64 — Paths first[i] to first[i + 1] lead to place i [-].
    field : (k, 3) complex128 — Vector in the room's frame, times lambda / 4 pi [-]: its product
        with a receiving pattern is the path's complex gain.
    arrival : (k, 3) float64 — Unit vectors from the place to where the wave comes from [-].
    """

    first: IntArray
    field: npt.NDArray[np.complex128]
    arrival: FloatArray

    def at_antenna(self, receiver: Antenna, power_w: float) -> ReceivedPower:
        """Return what one antenna receives at each place, (m,) [W].

        Parameters
        ----------
        receiver : Antenna in the room's frame.
        power_w : Transmitted power [W].
        """
        theta, phi, e_theta, e_phi = self._angles()
        pattern = receiver.far_field(theta, phi)
        return self._sums((pattern[:, 0] * e_theta + pattern[:, 1] * e_phi)[:, None], power_w)[0]

    def at_reader(
        self, response: ReaderResponse, headings_rad: npt.ArrayLike, power_w: float
    ) -> ReceivedPower:
        """Return what the reader's n antennas receive at each place, (m, n) [W].

        Parameters
        ----------
        response : Embedded patterns.
        headings_rad : (m,) float — Heading of the robot at each place [rad].
        power_w : Transmitted power [W].
        """
        headings = frozen_array(
            headings_rad, name="headings_rad", shape=(len(self.first) - 1,), error=AntennaError
        )
        theta, phi, e_theta, e_phi = self._angles()
        turn = np.repeat(headings - 0.5 * np.pi, np.diff(self.first))
        pattern = response.far_field(theta, phi - turn)
        voltage = pattern[..., 0] * e_theta + pattern[..., 1] * e_phi
        return self._sums(voltage.T, power_w)[1]

    def _angles(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return theta and phi of arrival [rad], and the field's components along them."""
        ux, uy, uz = self.arrival.T
        across = np.hypot(ux, uy)
        level = across > 0.0
        some = np.where(level, across, 1.0)
        cp, sp = np.where(level, ux / some, 1.0), np.where(level, uy / some, 0.0)
        ex, ey, ez = self.field.T
        return (
            np.arctan2(across, uz),
            np.arctan2(sp, cp),
            uz * (cp * ex + sp * ey) - across * ez,
            cp * ey - sp * ex,
        )

    def _sums(
        self, voltage: npt.NDArray[np.complex128], power_w: float
    ) -> tuple[ReceivedPower, ReceivedPower]:
        """Return sums over the paths of each place of (k, n) voltages, as (m,) and as (m, n)."""
        counts = np.diff(self.first)
        some = np.flatnonzero(counts)
        coherent = np.zeros((len(counts), voltage.shape[1]))
        mean = np.zeros_like(coherent)
        if len(some):
            begin = self.first[:-1][some]
            coherent[some] = np.abs(np.add.reduceat(voltage, begin, axis=0)) ** 2
            mean[some] = np.add.reduceat(voltage.real**2 + voltage.imag**2, begin, axis=0)
        coherent, mean = power_w * coherent, power_w * mean
        one = ReceivedPower(coherent[:, 0], mean[:, 0], counts)
        return one, ReceivedPower(coherent, mean, counts)


def keep_paths(
    radio: RadioScene,
    candidates: Candidates,
    places_m: npt.ArrayLike,
    *,
    least_share: float = 0.0,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> KeptPaths:
    """Return the paths from a source to many places, traced once.

    Parameters
    ----------
    radio, candidates : The scene, and what was searched in it from the source.
    places_m : (m, 3) float — Places of the receivers [m].
    least_share : Paths with less than this share [-] of the power of the place's strongest path
        are left out, by the mean of sources polarised along z and along x; 0 keeps every path, so
        that fields are those of the full solver. What is left out is said in ``left_out``.
    executor, progress : As in `octant.em.blocks.run_blocks`.
    """
    places = checked_receivers(candidates.images, places_m)
    blocks: dict[int, KeptPaths] = {}

    def work(begin: int, end: int) -> None:
        found = _ragged(trace_paths(radio, candidates, places[begin:end]))
        blocks[begin] = _thinned(radio, found, least_share) if least_share > 0.0 else found

    run_blocks(work, len(places), block_size=PLACES_PER_BLOCK, executor=executor, progress=progress)
    return _joined([blocks[begin] for begin in sorted(blocks)], candidates.images.source_m, places)


def _ragged(found: PathSet) -> KeptPaths:
    """Return paths in ragged arrays, those of a place in order of their numbers of interactions."""
    number = found.interactions
    order = np.lexsort((number, found.receiver))  # equal numbers are worked out side by side
    number, width = number[order], found.kind.shape[1]
    start = np.concatenate(([0], np.cumsum(number + 2)))
    path = np.repeat(np.arange(len(order)), number + 2)
    step = number[path] + 1 - (np.arange(len(path)) - start[path])  # from the receiver backwards
    inside = (step > 0) & (step <= number[path])
    codes = found.codes[order] if width else np.zeros((len(order), 1), np.int64)
    counts = np.bincount(found.receiver, minlength=len(found.receivers_m))
    return KeptPaths(
        source_m=found.source_m,
        places_m=found.receivers_m,
        first=np.concatenate(([0], np.cumsum(counts))),
        start=start,
        points_m=found.vertices_m[order][path, step],
        codes=codes[path[inside], step[inside] - 1],
    )


def _thinned(radio: RadioScene, kept: KeptPaths, least_share: float) -> KeptPaths:
    """Return the paths without those that carry too little."""
    frequency_hz = radio.frequency_hz
    strength = np.zeros(len(kept))
    for axis in ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0)):
        source = make_antenna("isotropic_theta", frequency_hz, axis=axis)
        strength += np.sum(np.abs(_fields(radio, kept, source)[0]) ** 2, axis=1)
    place, places = kept.place, len(kept.places_m)
    strongest = np.zeros(places)
    np.maximum.at(strongest, place, strength)
    stays = strength >= least_share * strongest[place]
    gone = np.bincount(place, np.where(stays, 0.0, strength), minlength=places)
    whole = np.bincount(place, strength, minlength=places)
    shares = gone[whole > 0.0] / whole[whole > 0.0]
    number = np.diff(kept.start)
    counts = np.bincount(place[stays], minlength=places)
    return KeptPaths(
        source_m=kept.source_m,
        places_m=kept.places_m,
        first=np.concatenate(([0], np.cumsum(counts))),
        start=np.concatenate(([0], np.cumsum(number[stays]))),
        points_m=kept.points_m[np.repeat(stays, number)],
        codes=kept.codes[np.repeat(stays, number - 2)],
        left_out=float(shares.max(initial=0.0)),
    )


def _joined(parts: list[KeptPaths], source_m: FloatArray, places_m: FloatArray) -> KeptPaths:
    """Return the paths of blocks of places as one."""

    def ends(arrays: list[IntArray]) -> IntArray:
        return np.concatenate(([0], np.cumsum(np.concatenate([np.diff(a) for a in arrays]))))

    if not parts:
        none = np.zeros(1, np.int64)
        parts = [
            KeptPaths(
                source_m=source_m,
                places_m=places_m,
                first=none,
                start=none,
                points_m=np.zeros((0, 3)),
                codes=none[:0],
            )
        ]
    return KeptPaths(
        source_m=source_m,
        places_m=places_m,
        first=ends([part.first for part in parts]),
        start=ends([part.start for part in parts]),
        points_m=np.concatenate([part.points_m for part in parts]),
        codes=np.concatenate([part.codes for part in parts]),
        left_out=max(part.left_out for part in parts),
    )


def _fields(
    radio: RadioScene, kept: KeptPaths, transmitter: Antenna
) -> tuple[npt.NDArray[np.complex128], FloatArray]:
    """Return fields (k, 3) and directions of travel (k, 3) of all paths."""
    waves = np.empty((len(kept), 3), dtype=np.complex128), np.empty((len(kept), 3))
    _fill(radio, kept, transmitter, waves, (0, len(kept)))
    return waves


def _fill(
    radio: RadioScene,
    kept: KeptPaths,
    transmitter: Antenna,
    waves: tuple[npt.NDArray[np.complex128], FloatArray],
    rows: tuple[int, int],
) -> None:
    """Fill rows from, to of fields and directions of travel."""
    width = int(np.diff(kept.start).max(initial=2)) - 2
    _kept_kernels.kept_fields(
        scene_arrays(radio),
        transmitter.kernel_arrays(),
        width,
        *read_only((kept.start, kept.points_m, kept.codes)),
        *rows,
        *waves,
    )


def arriving_fields(
    radio: RadioScene,
    kept: KeptPaths,
    *,
    transmitter: Antenna,
    executor: Executor | None = None,
) -> ArrivingFields:
    """Return the waves along kept paths [-], in the scene's materials as they are now.

    With `keep_paths` of every path the powers are those of `antenna_power` and `reader_link`, to
    rounding.

    Parameters
    ----------
    radio : The scene that the paths were traced in, also with other materials (`with_materials`).
    kept : The paths.
    transmitter : The source's antenna, in the room's frame.
    executor : Runs the blocks of paths, sharing memory.
    """
    field = np.empty((len(kept), 3), dtype=np.complex128)
    direction = np.empty((len(kept), 3))

    def work(begin: int, end: int) -> None:
        rows = int(kept.first[begin]), int(kept.first[end])
        _fill(radio, kept, transmitter, (field, direction), rows)

    run_blocks(work, len(kept.places_m), block_size=PLACES_PER_BLOCK, executor=executor)
    return ArrivingFields(first=kept.first, field=field, arrival=-direction)


def with_materials(radio: RadioScene, materials: Mapping[str, Material]) -> RadioScene:
    """Return a scene with other values of materials, in which its paths stay what they are.

    Parameters
    ----------
    radio : Scene with resolved materials.
    materials : New meaning of some of its labels; each has as many layers as before, and as open or
        closed a back: else other paths would exist.
    """
    names = radio.scene.material_names
    unknown = sorted(set(materials) - set(names))
    if unknown:
        msg = f"the scene has no material {unknown[0]!r}; its materials are {', '.join(names)}."
        raise MaterialRangeError(msg)
    resolved = tuple(
        materials.get(name, old) for name, old in zip(names, radio.materials, strict=True)
    )
    for name, old, new in zip(names, radio.materials, resolved, strict=True):
        if _kind(old) != _kind(new):
            msg = (
                f"material {name!r} changes from {_words(old)} to {_words(new)}, by which other "
                "paths exist: trace them anew."
            )
            raise GeometryError(msg)
    stacks = [one.layer_stack(radio.frequency_hz) for one in resolved]
    none = np.zeros(0)
    return replace(
        radio,
        materials=resolved,
        layer_permittivity=np.concatenate([none, *(eps for eps, _ in stacks)]),
        layer_thickness_m=np.concatenate([none, *(d for _, d in stacks)]),
    )


def _kind(one: Material) -> tuple[bool, ...]:
    """Return of each layer whether it conducts perfectly and whether it has a far side."""
    layers = one.layers or (one,)
    return tuple(value for m in layers for value in (m.is_pec, m.thickness_m is None))


def _words(one: Material) -> str:
    """Return what a wall is."""
    if one.layers:
        return f"{len(one.layers)} layers"
    if one.is_pec:
        return "a perfect conductor"
    return "a half-space" if one.thickness_m is None else "a slab"
