"""Field maps: RSS of all antennas of a reader over a floor and all headings, to be read quickly.

Paths are traced on a coarse grid only: between its nodes a path's field without its phase is
interpolated, and the phase e^{-jkL} follows exactly from its image point, which does not move. At
each fine place all paths together excite harmonics of the heading, since a pattern of a reader of
radius a has no more than about 2 k a + 1 of them: these few serve all headings and all antennas.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.blocks import run_blocks
from octant.em.medium.radio_scene import RadioScene
from octant.em.power import _field_map_kernels
from octant.em.power.node_paths import NodePaths, grid_points
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import GeometryError

FloatArray = npt.NDArray[np.float64]
Codes = npt.NDArray[np.uint8]
ComplexArray = npt.NDArray[np.complex128]

CODE_DB = 0.25
"""Step [dB] of the levels that are kept: an error of 0.07 dB rms, 64 dB below the strongest."""
HEADINGS = 64
"""Least number of headings kept [-]; a multiple of the number of antennas is taken."""
PLACES_PER_WAVELENGTH = 6.0
"""Places per wavelength [-], unless a spacing is given: power varies twice as fast as the field."""
NODES_PER_WAVELENGTH = (1.0, 2.0, 4.0)
"""Nodes per wavelength [-] on which paths are traced: more where furniture makes shadows."""

_ALIKE = 1e-3
_SILENT = 1e-3
_BLOCK = 64


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldMap:
    """RSS of every antenna for one or more tags, over a rectangle of the floor and all headings.

    Parameters
    ----------
    x_m, y_m : (nx,), (ny,) float64 — Even coordinates of the places [m].
    levels : (t, nx, ny, r, h) uint8 — Coherent RSS of each tag, averaged over channels, in steps of
        `CODE_DB` up to ``top_dbm`` at 255, for even headings from 0 on; 0: that weak, or nothing
        [-].
    node_x_m, node_y_m : (cx,), (cy,) float64 — The same of the coarse grid [m].
    means : (t, cx, cy, r, h) uint8 — Sum of the paths' powers there, in the same steps [-].
    ring : (n,) int64 — Which of the r rows an antenna has [-]: on a reader of a symmetry, antennas
        that it maps onto one another share one.
    shift_rad : (n,) float64 — By how much its heading is ahead there [rad].
    top_dbm : (t,) float64 — Level of the highest code [dBm].
    powers_w : (t, 256) float64 — What the codes mean for each tag [W]; 0 of code 0: made of that.
    """

    x_m: FloatArray
    y_m: FloatArray
    levels: Codes
    node_x_m: FloatArray
    node_y_m: FloatArray
    means: Codes
    ring: npt.NDArray[np.int64]
    shift_rad: FloatArray
    top_dbm: FloatArray
    powers_w: FloatArray = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for x, y, codes in (
            ("x_m", "y_m", "levels"),
            ("node_x_m", "node_y_m", "means"),
        ):
            for name in (x, y):
                array = frozen_array(getattr(self, name), name=name, shape=(None,))
                object.__setattr__(self, name, array)
            shape = (len(self.levels), len(getattr(self, x)), len(getattr(self, y)), None, None)
            array = frozen_array(getattr(self, codes), name=codes, shape=shape, dtype=np.uint8)
            object.__setattr__(self, codes, array)
        n = len(self.ring)
        ring = frozen_array(self.ring, name="ring", shape=(n,), dtype=np.int64)
        object.__setattr__(self, "ring", ring)
        shift = frozen_array(self.shift_rad, name="shift_rad", shape=(n,))
        object.__setattr__(self, "shift_rad", shift)
        top = frozen_array(self.top_dbm, name="top_dbm", shape=(len(self.levels),))
        object.__setattr__(self, "top_dbm", top)
        level_dbm = top[:, None] + CODE_DB * (np.arange(256.0) - 255.0)
        power = np.where(np.arange(256) > 0, 10.0 ** ((level_dbm - 30.0) / 10.0), 0.0)
        object.__setattr__(
            self, "powers_w", frozen_array(power, name="powers_w", shape=(None, 256))
        )

    @property
    def tags(self) -> int:
        """Number of tags."""
        return len(self.levels)

    @property
    def nbytes(self) -> int:
        """Memory of the levels [B]."""
        return self.levels.nbytes + self.means.nbytes

    def rss_w(self, poses: npt.ArrayLike, *, tag: int = 0) -> FloatArray:
        """Return the coherent RSS of all antennas, (m, n) [W]; beyond the map that at its rim.

        Parameters
        ----------
        poses : (m, 3) float64 — x, y [m] and heading [rad] of the robot.
        tag : Which tag.
        """
        return self._read(poses, self.x_m, self.y_m, self.levels[tag], tag)

    def local_mean_w(self, poses: npt.ArrayLike, *, tag: int = 0) -> FloatArray:
        """Return the sum of the paths' powers of all antennas, (m, n) [W].

        Parameters
        ----------
        poses : (m, 3) float64 — x, y [m] and heading [rad] of the robot.
        tag : Which tag.
        """
        return self._read(poses, self.node_x_m, self.node_y_m, self.means[tag], tag)

    def _read(
        self, poses: npt.ArrayLike, x: FloatArray, y: FloatArray, codes: Codes, tag: int
    ) -> FloatArray:
        pose = frozen_array(poses, name="poses", shape=(None, 3))
        out = np.empty((len(pose), len(self.ring)))
        shift = self.shift_rad * codes.shape[3] / (2.0 * math.pi)
        grid = np.array([x[0], y[0]]), np.array([x[1] - x[0], y[1] - y[0]])
        _field_map_kernels.read_power(
            pose, 0, len(pose), *grid, codes, self.powers_w[tag], self.ring, shift, out
        )
        return out


def joined(maps: Sequence[FieldMap]) -> FieldMap:
    """Return the maps of several tags as one; they must have one grid and one reader.

    Parameters
    ----------
    maps : One or more.
    """
    first = maps[0]
    for other in maps[1:]:
        alike = all(
            np.array_equal(getattr(first, name), getattr(other, name))
            for name in ("x_m", "y_m", "node_x_m", "node_y_m", "ring", "shift_rad")
        )
        if not alike or other.levels.shape[1:] != first.levels.shape[1:]:
            msg = (
                f"the field maps have {first.levels.shape[1:]} and {other.levels.shape[1:]} "
                "values, but tags that are read together need maps of one grid and one reader: "
                "make them together."
            )
            raise GeometryError(msg)
    return replace(
        first,
        levels=np.concatenate([one.levels for one in maps]),
        means=np.concatenate([one.means for one in maps]),
        top_dbm=np.concatenate([one.top_dbm for one in maps]),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class MapError:
    """How far a field map is from the solver.

    Parameters
    ----------
    rms_db, p95_db : Root mean square and 95th percentile of the errors in decibels [dB].
    share : Power of the error field over the local mean [-].
    floor_w : Power of the error field that is the same everywhere, also in shadows [W]. Errors in
        decibels follow from both, larger in fades: of RSS P and error field D = share * mean +
        floor, with f = D/(P + D), their variance is about 5.57² f(2 - f) [dB²].
    under_db : By how much its mean power is below that of the local mean [dB].
    places : Number of random places [-].
    """

    rms_db: float
    p95_db: float
    share: float
    floor_w: float
    under_db: float
    places: int


def map_error(
    field_map: FieldMap,
    true_w: FloatArray,
    poses: FloatArray,
    *,
    tag: int = 0,
    fading_db: float = 5.57,
) -> MapError:
    """Return how far a field map is from RSS that the solver gives at random poses.

    Share and floor are where the likelihood of the errors, normal in decibels, is greatest.

    Parameters
    ----------
    field_map, poses : The map; (m, 3) x, y [m], heading [rad].
    true_w : (m, n) float64 — RSS there [W].
    tag : Which tag of the map.
    fading_db : Deviation of a fading signal's level [dB]: 5.57 of an exponential power.
    """
    found, mean = field_map.rss_w(poses, tag=tag), field_map.local_mean_w(poses, tag=tag)
    sound = true_w > 0.0
    least_w = field_map.powers_w[tag, 1]
    found, mean, true = (np.maximum(power[sound], least_w) for power in (found, mean, true_w))
    error = 10.0 * np.log10(true / found)
    shares = 10.0 ** np.arange(-4.0, 0.01, 0.1)
    best, least = (1.0, 0.0), math.inf
    for floor_w in float(np.mean(mean)) * np.append(0.0, 10.0 ** np.arange(-4.0, 0.01, 0.1)):
        for share in shares:
            diffuse = share * mean + floor_w
            part = diffuse / (found + diffuse)
            part *= 2.0 - part
            variance = fading_db**2 * part + CODE_DB**2 / 12.0
            off = 10.0 * np.log10(true / (found + diffuse)) + 2.51 / 5.57 * fading_db * part
            cost = float(np.sum(off**2 / variance + np.log(variance)))
            if cost < least:
                best, least = (float(share), float(floor_w)), cost
    size = np.abs(error)
    return MapError(
        rms_db=float(np.sqrt(np.mean(error**2))) if size.size else math.inf,
        p95_db=float(np.percentile(size, 95.0)) if size.size else math.inf,
        share=best[0],
        floor_w=best[1],
        under_db=-10.0 * math.log10(best[0] + best[1] / float(np.mean(mean))),
        places=len(poses),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class MapPlan:
    """The grids of a field map, and what it takes.

    Parameters
    ----------
    x_m, y_m : (nx,), (ny,) float64 — Fine places [m].
    node_x_m, node_y_m : (cx,), (cy,) float64 — Places where paths are traced [m].
    """

    x_m: FloatArray
    y_m: FloatArray
    node_x_m: FloatArray
    node_y_m: FloatArray

    @property
    def places(self) -> int:
        """Number of fine places."""
        return len(self.x_m) * len(self.y_m)

    @property
    def nodes(self) -> int:
        """Number of traced places."""
        return len(self.node_x_m) * len(self.node_y_m)

    def nbytes(self, rows: int, headings: int = HEADINGS) -> int:
        """Return the memory of a tag's levels [B].

        Parameters
        ----------
        rows, headings : Antennas that no symmetry maps onto another; headings kept.
        """
        return (self.places + self.nodes) * rows * headings


def plan_map(
    low_m: npt.ArrayLike,
    high_m: npt.ArrayLike,
    *,
    wavelength_m: float,
    spacing_m: float | None = None,
    nodes_per_wavelength: float = NODES_PER_WAVELENGTH[0],
) -> MapPlan:
    """Return the grids over a rectangle [m].

    Parameters
    ----------
    low_m, high_m : (2,) array_like — Corners [m].
    wavelength_m : Shortest wavelength [m].
    spacing_m : Distance of fine places [m], at most; None: a sixth of a wavelength.
    nodes_per_wavelength : Traced places per wavelength, at least [-].
    """
    low, high = (np.asarray(c, dtype=np.float64) for c in (low_m, high_m))
    fine = spacing_m or wavelength_m / PLACES_PER_WAVELENGTH
    coarse = wavelength_m / nodes_per_wavelength
    axes = [
        np.linspace(low[i], high[i], 2 + int((high[i] - low[i]) / step - 1e-9))
        for step in (fine, coarse)
        for i in range(2)
    ]
    return MapPlan(x_m=axes[0], y_m=axes[1], node_x_m=axes[2], node_y_m=axes[3])


def antennas_alike(response: ReaderResponse) -> int:
    """Return how many antennas apart a ring's patterns repeat, turned: the rows of its map [-].

    Parameters
    ----------
    response : Patterns of n antennas.
    """
    pattern = response.pattern_at_centre
    n, columns = len(pattern), pattern.shape[-1]
    even = 2.0 * math.pi / n * np.arange(n)
    if np.abs(np.angle(np.exp(1j * (response.azimuths_rad - even)))).max() > 1e-9:
        return n
    most = np.abs(pattern).max()
    for step in range(1, n):
        if n % step or (step * columns) % n:
            continue
        turned = np.roll(pattern, step * columns // n, axis=-1)
        if np.abs(turned - np.roll(pattern, -step, axis=0)).max() <= _ALIKE * most:
            return step
    return n


def make_field_map(
    paths: NodePaths,
    radios: Sequence[RadioScene],
    responses: Sequence[ReaderResponse],
    plan: MapPlan,
    *,
    tag_power_w: float,
    reader_z_m: float,
) -> FieldMap:
    """Return the map of RSS of a tag, averaged over the channels.

    Shadows' edges are blurred over a cell of the coarse grid. Plane waves arrive at the reader's
    centre, as in `ReaderLink`. `map_error` says how far all that is from the solver.

    Parameters
    ----------
    paths : Of the tag to the plan's nodes, from `trace_node_paths`.
    radios, responses : The room and the reader, each at every channel.
    plan : From `plan_map` [m].
    tag_power_w : What the tag sends [W].
    reader_z_m : Height of the reader's centre in the room's frame [m].
    """
    rows = max(antennas_alike(response) for response in responses)
    n = responses[0].antennas
    headings = n * math.ceil(HEADINGS / n)
    tables = [_harmonics(response, rows) for response in responses]
    scale = tag_power_w / len(radios)
    turns = 2.0 * math.pi / headings * np.arange(headings) - 0.5 * math.pi
    waves = [
        np.exp(-1j * (lowest + np.arange(table.shape[2]))[:, None] * turns)
        for table, lowest in tables
    ]
    shared = [
        (2.0 * math.pi / radio.wavelength_m, table, lowest, wave, scale)
        for radio, (table, lowest), wave in zip(radios, tables, waves, strict=True)
    ]
    nodes = grid_points(plan.node_x_m, plan.node_y_m)
    mean = np.zeros((len(nodes), rows, headings))

    def work_mean(begin: int, end: int) -> None:
        for waves, rest in zip(paths.fields, shared, strict=True):
            _field_map_kernels.add_local_mean(
                nodes, begin, end, reader_z_m, paths.start, paths.image, waves, paths.images,
                *rest, mean,
            )  # fmt: skip

    run_blocks(work_mean, len(nodes), block_size=_BLOCK)
    # The coherent RSS of k equal paths is k times their sum, and hardly ever 12 dB more than that.
    top_dbm = 10.0 * math.log10(max(float(mean.max()), 1e-300)) + 42.0
    places = grid_points(plan.x_m, plan.y_m)
    levels = np.empty((len(places), rows, headings), dtype=np.uint8)
    low = np.array([plan.node_x_m[0], plan.node_y_m[0]])
    cell = np.array([plan.node_x_m[1] - plan.node_x_m[0], plan.node_y_m[1] - plan.node_y_m[0]])
    shape = np.array([len(plan.node_x_m), len(plan.node_y_m)])

    def work(begin: int, end: int) -> None:
        power = np.zeros((end - begin, rows, headings))
        for waves, rest in zip(paths.fields, shared, strict=True):
            _field_map_kernels.add_coherent(
                places, begin, end, low, cell, shape, reader_z_m, paths.start, paths.image, waves,
                paths.images, *rest, power,
            )  # fmt: skip
        levels[begin:end] = _codes(power, top_dbm)

    run_blocks(work, len(places), block_size=_BLOCK)
    azimuths = np.asarray(responses[0].azimuths_rad)
    ring = np.arange(n) % rows
    return FieldMap(
        x_m=plan.x_m,
        y_m=plan.y_m,
        levels=levels.reshape(1, len(plan.x_m), len(plan.y_m), rows, headings),
        node_x_m=plan.node_x_m,
        node_y_m=plan.node_y_m,
        means=_codes(mean, top_dbm).reshape(1, *shape, rows, headings),
        ring=ring,
        shift_rad=azimuths - azimuths[ring],
        top_dbm=np.array([top_dbm]),
    )


def _codes(power_w: FloatArray, top_dbm: float) -> Codes:
    with np.errstate(divide="ignore"):
        level_dbm = 10.0 * np.log10(power_w) + 30.0
    code = np.rint(255.0 + (level_dbm - top_dbm) / CODE_DB)
    codes: Codes = np.clip(code, 0.0, 255.0).astype(np.uint8)
    return codes


def _harmonics(response: ReaderResponse, rows: int) -> tuple[ComplexArray, int]:
    """Return (T, r, m, 2) coefficients of e^{j m phi} of the first antennas, and the lowest m."""
    pattern = response.pattern_at_centre[:rows]
    columns = pattern.shape[-1]
    spectrum = np.fft.fftshift(np.fft.fft(pattern, axis=-1), axes=-1) / columns
    size = np.abs(spectrum).max(axis=(0, 1, 2))
    orders = np.arange(columns) - columns // 2
    most = int(np.abs(orders[size > _SILENT * size.max()]).max())
    kept = np.abs(orders) <= most
    table = np.ascontiguousarray(np.moveaxis(spectrum[..., kept], (0, 1, 2, 3), (1, 3, 0, 2)))
    return table, -most
