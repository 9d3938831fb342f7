"""Radio maps: received power over a horizontal grid, in blocks, on all cores."""

from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna
from octant.em.blocks import Progress
from octant.em.medium.radio_scene import RadioScene
from octant.em.power.backscatter import Answers, BackscatterLink, Link
from octant.em.power.received_power import ReceivedPower, antenna_power
from octant.em.search.candidates import Candidates
from octant.em.search.ray_share import RayShare
from octant.geometries._arrays import frozen_array

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class RadioMap:
    """Power over a grid of places, x first.

    Parameters
    ----------
    x_m, y_m, z_m : (nx,), (ny,), () float64 — Coordinates of the grid, at one height [m].
    coherent_w, local_mean_w, path_count : (nx, ny, ...) — As in `ReceivedPower` [W].
    rays : What share of the power is missing, where rays have found the paths; None: none is.
    """

    x_m: FloatArray
    y_m: FloatArray
    z_m: float
    coherent_w: FloatArray
    local_mean_w: FloatArray
    path_count: npt.NDArray[np.int64]
    rays: RayShare | None = None


def grid_axis_m(low_m: float, high_m: float, *, spacing_m: float) -> FloatArray:
    """Return (n,) cell centres [m] that divide a length evenly into cells of at most the spacing.

    Parameters
    ----------
    low_m, high_m : Ends [m], high above low.
    spacing_m : Greatest distance between centres [m], > 0.
    """
    cells = max(1, int(np.ceil((high_m - low_m) / spacing_m - 1e-9)))
    width_m = (high_m - low_m) / cells
    return np.linspace(low_m + 0.5 * width_m, high_m - 0.5 * width_m, cells)


def _map(x_m: npt.ArrayLike, y_m: npt.ArrayLike, z_m: float) -> tuple[FloatArray, ...]:
    x = frozen_array(x_m, name="x_m", shape=(None,))
    y = frozen_array(y_m, name="y_m", shape=(None,))
    gx, gy = np.meshgrid(x, y, indexing="ij")
    return x, y, np.column_stack((gx.ravel(), gy.ravel(), np.full(gx.size, z_m)))


def _as_map(
    x: FloatArray, y: FloatArray, z_m: float, power: ReceivedPower, rays: RayShare | None
) -> RadioMap:
    shape = (len(x), len(y))
    return RadioMap(
        x_m=x,
        y_m=y,
        z_m=z_m,
        coherent_w=power.coherent_w.reshape(*shape, *power.coherent_w.shape[1:]),
        local_mean_w=power.local_mean_w.reshape(*shape, *power.local_mean_w.shape[1:]),
        path_count=power.path_count.reshape(shape),
        rays=rays,
    )


def map_antenna(
    radio: RadioScene,
    candidates: Candidates,
    *,
    x_m: npt.ArrayLike,
    y_m: npt.ArrayLike,
    z_m: float,
    transmitter: Antenna,
    receiver: Antenna,
    power_w: float,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> RadioMap:
    """Return the map of one receiving antenna, (nx, ny).

    Parameters
    ----------
    radio, candidates : The scene, and what was searched in it from the transmitter.
    x_m, y_m, z_m : (nx,), (ny,), () float — Coordinates of the grid in the room's frame [m].
    transmitter, receiver : Antennas in the room's frame.
    power_w : Transmitted power [W].
    executor, progress : As in `octant.em.blocks.run_blocks`.
    """
    x, y, places = _map(x_m, y_m, z_m)
    power = antenna_power(
        radio,
        candidates,
        places,
        transmitter=transmitter,
        receiver=receiver,
        power_w=power_w,
        executor=executor,
        progress=progress,
    )
    return _as_map(x, y, z_m, power, candidates.images.rays)


def map_reader(
    link: Link,
    *,
    x_m: npt.ArrayLike,
    y_m: npt.ArrayLike,
    heading_rad: float,
    progress: Progress | None = None,
) -> RadioMap:
    """Return the map of all n antennas of the reader, (nx, ny, n).

    Parameters
    ----------
    link, heading_rad : Tag, room and reader, and the robot's heading [rad].
    x_m, y_m : (nx,), (ny,) float — Coordinates of the grid [m].
    progress : Called after every block.
    """
    x, y, places = _map(x_m, y_m, link.reader_z_m)
    poses = places.copy()
    poses[:, 2] = heading_rad
    power = link.power(poses, progress=progress)
    return _as_map(x, y, link.reader_z_m, power, link.rays)


def map_backscatter(
    link: BackscatterLink,
    *,
    x_m: npt.ArrayLike,
    y_m: npt.ArrayLike,
    heading_rad: float,
    progress: Progress | None = None,
) -> tuple[RadioMap, Answers]:
    """Return the map of `map_reader` for a tag that answers, and its answers, (nx, ny, n) [W].

    Parameters
    ----------
    link, x_m, y_m, heading_rad, progress : As in `map_reader` [m], [rad].
    """
    x, y, places = _map(x_m, y_m, link.reader_z_m)
    poses = places.copy()
    poses[:, 2] = heading_rad
    found = link.answers(poses, progress=progress)
    power = _as_map(x, y, link.reader_z_m, found.rss, link.rays)
    shape = power.coherent_w.shape
    return power, Answers(
        rss=ReceivedPower(power.coherent_w, power.local_mean_w, power.path_count),
        chip_w=found.chip_w.reshape(shape),
        chip_mean_w=found.chip_mean_w.reshape(shape),
        margin=found.margin.reshape(shape),
        read=found.read.reshape(shape),
    )
