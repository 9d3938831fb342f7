"""Received power: at one antenna in many places, at all antennas of the reader for its poses."""

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.antennas.kinds import Antenna
from octant.em.blocks import Progress, run_blocks
from octant.em.medium.radio_scene import RadioScene
from octant.em.paths.tracing import checked_receivers, path_arrays
from octant.em.power import _power_kernels
from octant.em.power.link_bands import LinkBand, check_clearance, link_bands, link_channels
from octant.em.search.candidates import Candidates, SolverSettings
from octant.em.search.ray_share import RayShare
from octant.em.soundness import check_power
from octant.em.tiles import near_each_other, put_back
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import AntennaError

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


class ReceivedPower(NamedTuple):
    """Power at m places; the last axis of the powers counts antennas where there are several."""

    coherent_w: FloatArray  # [W], the squared magnitude of the sum over paths
    local_mean_w: FloatArray  # [W], the sum over paths of the squared magnitudes
    path_count: IntArray  # (m,) number of paths [-]; 0 paths give 0 W


def antenna_power(
    radio: RadioScene,
    candidates: Candidates,
    places_m: npt.ArrayLike,
    *,
    transmitter: Antenna,
    receiver: Antenna,
    power_w: float,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> ReceivedPower:
    """Return the power that one antenna receives at each of many places, (m,) [W].

    The local mean is that over a region so wide that the paths' phases are independent.

    Parameters
    ----------
    radio, candidates : The scene, and what was searched in it from the transmitter.
    places_m : (m, 3) float — Places of the receiver [m].
    transmitter, receiver : Antennas in the room's frame.
    power_w : Transmitted power [W].
    executor, progress : As in `octant.em.blocks.run_blocks`.
    """
    given = checked_receivers(candidates.images, places_m)
    order = near_each_other(given)
    places = given[order]
    m = len(places)
    coherent, mean, count = np.zeros(m), np.zeros(m), np.zeros(m, dtype=np.int64)
    arrays = (
        *path_arrays(radio, candidates),
        transmitter.kernel_arrays(),
        receiver.kernel_arrays(),
    )

    def work(begin: int, end: int) -> None:
        _power_kernels.antenna_power(*arrays, places, begin, end, coherent, mean, count)

    run_blocks(work, m, executor=executor, progress=progress)
    check_power(power_w * coherent, power_w, places)
    return ReceivedPower(
        put_back(order, power_w * coherent), put_back(order, power_w * mean), put_back(order, count)
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ReaderLink:
    """The link from one tag to the reader: RSS of all antennas for any pose of the robot.

    Paths are traced to the reader's centre, once for all frequencies, and arrive as plane waves,
    which the embedded patterns weigh. That holds while the tag and its images are farther than
    about 2 D^2 / lambda from a reader of diameter D that has no reflector in its near field.

    Parameters
    ----------
    bands : Frequencies over which RSS is averaged in power; those of one band share their paths.
    azimuths_rad : (n,) float64 — Azimuth of each antenna in the reader's frame [rad].
    tag_position_m, tag_power_w : (3,), () float64 — Place of the tag [m], and power it sends [W].
    reader_z_m : Height of the reader's centre in the room's frame [m].
    """

    bands: tuple[LinkBand, ...]
    azimuths_rad: FloatArray
    tag_position_m: FloatArray
    tag_power_w: float
    reader_z_m: float

    @property
    def antennas(self) -> int:
        """Number of antennas."""
        return len(self.azimuths_rad)

    @property
    def rays(self) -> RayShare | None:
        """What share of the power is missing, where rays have found the paths; None: none is."""
        return self.bands[0].tree.rays

    def power(self, poses: npt.ArrayLike, *, progress: Progress | None = None) -> ReceivedPower:
        """Return (m, n) powers [W] of all antennas, and (m,) path counts of the first channel.

        Parameters
        ----------
        poses : (m, 3) float — x [m], y [m] and heading h [rad] of the robot, which carries antenna
            i at room azimuth h - pi/2 + delta_i. A place that stands several times in a row is
            traced once where that holds for all.
        progress : Called after every block.
        """
        pose = frozen_array(poses, name="poses", shape=(None, 3))
        turns = _turns_at_each_place(pose)
        power = self._power(pose[::turns, :2], pose[:, 2].reshape(-1, turns), progress)
        return ReceivedPower(
            power.coherent_w.reshape(-1, self.antennas),
            power.local_mean_w.reshape(-1, self.antennas),
            np.repeat(power.path_count, turns),
        )

    def power_by_heading(
        self,
        places_m: npt.ArrayLike,
        headings_rad: npt.ArrayLike,
        *,
        progress: Progress | None = None,
    ) -> ReceivedPower:
        """Return (p, h, n) powers [W], to the bit those of :meth:`power`; a place is traced once.

        Parameters
        ----------
        places_m, headings_rad : (p, 2), (h,) float — x, y [m] of the robot, headings [rad].
        progress : Called after every block.
        """
        places = frozen_array(places_m, name="places_m", shape=(None, 2))
        headings = frozen_array(headings_rad, name="headings_rad", shape=(None,))
        return self._power(
            places, np.broadcast_to(headings, (len(places), len(headings))), progress
        )

    def _power(
        self, places_m: FloatArray, headings_rad: FloatArray, progress: Progress | None
    ) -> ReceivedPower:
        """Return (m, h, n) powers at (m, 2) places and (m, h) headings, and (m,) counts."""
        order = near_each_other(places_m)
        places = np.column_stack((places_m[order], np.full(len(places_m), self.reader_z_m)))
        headings = headings_rad[order]
        shape = (*headings_rad.shape, self.antennas)
        coherent, mean = np.zeros(shape), np.zeros(shape)
        counts = np.zeros((len(self.bands), len(places)), dtype=np.int64)
        for band, count in zip(self.bands, counts, strict=True):
            band.add_power(places, headings, (coherent, mean, count), progress)
        scale = self.tag_power_w / sum(band.channels for band in self.bands)
        check_power(scale * coherent, self.tag_power_w, places)
        return ReceivedPower(
            put_back(order, scale * coherent),
            put_back(order, scale * mean),
            put_back(order, counts[0]),
        )

    def rss_w(self, poses: npt.ArrayLike) -> FloatArray:
        """Return the coherent RSS of all antennas at each pose, (m, n) [W]; 0 without a path."""
        return self.power(poses).coherent_w

    def rss_by_heading_w(self, places_m: npt.ArrayLike, headings_rad: npt.ArrayLike) -> FloatArray:
        """Return the coherent RSS at each place and heading, (p, h, n) [W]; 0 without a path.

        Parameters
        ----------
        places_m, headings_rad : As in :meth:`power_by_heading` [m], [rad].
        """
        return self.power_by_heading(places_m, headings_rad).coherent_w


def _turns_at_each_place(poses: FloatArray) -> int:
    """Return the greatest number of which every place stands a multiple in a row."""
    if len(poses) == 1:
        return 1
    moves = np.flatnonzero((poses[1:, :2] != poses[:-1, :2]).any(axis=1)) + 1
    return max(1, int(np.gcd.reduce(moves, initial=len(poses))))


def reader_link(
    radio: RadioScene | Sequence[RadioScene],
    *,
    tag_position_m: npt.ArrayLike,
    tag_antenna: Antenna | Sequence[Antenna],
    tag_power_w: float,
    response: ReaderResponse | Sequence[ReaderResponse],
    reader_height_m: float,
    solver: SolverSettings,
    places_m: npt.ArrayLike | None = None,
) -> ReaderLink:
    """Return the link from a tag to a reader in a room, at one frequency or averaged over several.

    A PhysicsWarning says when the tag can be nearer than 2 D^2 / lambda, its wave not plane.

    Parameters
    ----------
    radio, response : Scene with resolved materials and reader, each at every frequency.
    tag_position_m : (3,) float — Place of the tag [m], off every wall.
    tag_antenna, tag_power_w : Antenna in the room's frame at each frequency; power sent [W], > 0.
    reader_height_m : Height of the reader's ground plane above the floor [m].
    solver : How paths are searched; edges diffract where the radio scene has wedges too.
    places_m : (m, 2) float, optional — The only x, y [m] that the robot will be at: among very many
        facets, images that reach none of them are left out.
    """
    if not (math.isfinite(tag_power_w) and tag_power_w > 0.0):
        msg = f"tag_power_w = {tag_power_w} W is not a power; give a number above 0 W."
        raise AntennaError(msg)
    channels = link_channels(radio, tag_antenna, response)
    first = channels[0]
    tag = frozen_array(tag_position_m, name="tag_position_m", shape=(3,))
    reader_z_m = first.radio.scene.floor_height_m + reader_height_m
    check_clearance(abs(float(tag[2]) - reader_z_m), tag, channels)
    receivers = None
    if places_m is not None:
        places = frozen_array(places_m, name="places_m", shape=(None, 2))
        receivers = np.column_stack((places, np.full(len(places), reader_z_m)))
    return ReaderLink(
        bands=link_bands(channels, tag, solver, receivers_m=receivers),
        azimuths_rad=first.response.azimuths_rad,
        tag_position_m=tag,
        tag_power_w=tag_power_w,
        reader_z_m=reader_z_m,
    )
