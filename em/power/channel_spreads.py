"""How far a channel spreads in delay and in direction, place by place, in blocks of receivers."""

import math
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna
from octant.em.blocks import Progress, run_blocks
from octant.em.fields.gains import PathGains, path_gains
from octant.em.medium.radio_scene import RadioScene
from octant.em.paths.tracing import checked_receivers, trace_paths
from octant.em.search.candidates import Candidates
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import AntennaError

FloatArray = npt.NDArray[np.float64]

RECEIVERS_PER_BLOCK = 256
"""Receivers [-] whose paths are held at once: some 10 MiB with 60 paths of order 3 each."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChannelSpreads:
    """Second moments of the power over delay and direction of arrival; NaN where nothing arrives.

    Parameters
    ----------
    delay_spread_s : (m,) float64 — Root mean square spread of the delay [s].
    azimuth_spread_rad : (m,) float64 — Circular standard deviation of the azimuth of arrival [rad];
        infinity where the powers around the horizon cancel.
    direction_spread_rad : (m,) float64 — Spread over the sphere [rad], 0 to 1: for small spreads
        the root mean square of the great-circle angle to the mean direction.
    """

    delay_spread_s: FloatArray
    azimuth_spread_rad: FloatArray
    direction_spread_rad: FloatArray

    def __post_init__(self) -> None:
        m = len(self.delay_spread_s)
        for name in ("delay_spread_s", "azimuth_spread_rad", "direction_spread_rad"):
            array = frozen_array(
                getattr(self, name), name=name, shape=(m,), finite=False, error=AntennaError
            )
            object.__setattr__(self, name, array)


def channel_spreads(
    radio: RadioScene,
    candidates: Candidates,
    places_m: npt.ArrayLike,
    *,
    transmitter: Antenna,
    receiver: Antenna,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> ChannelSpreads:
    """Return delay spread [s] and angular spreads [rad] of the channel to each of many places.

    Parameters
    ----------
    radio, candidates : The scene, and what was searched in it from the transmitter.
    places_m : (m, 3) float — Places of the receiver [m].
    transmitter, receiver : Antennas in the room's frame; their patterns weigh the paths.
    executor, progress : As in `octant.em.blocks.run_blocks`.

    Notes
    -----
    With the powers p_k of the paths between the two antennas, normalised to sum 1: delay spread
    (sum p_k tau_k^2 - (sum p_k tau_k)^2)^{1/2} [1]_; azimuth spread
    (-2 ln |sum p_k e^{j phi_k}|)^{1/2} [2]_; direction spread (1 - |sum p_k Omega_k|^2)^{1/2} with
    the unit vectors Omega_k [3]_. Paths only: what walls scatter diffusely is not in.

    References
    ----------
    .. [1] ITU-R P.1407-8 (2021), "Multipath propagation and parameterization of its
       characteristics", rms delay spread.
    .. [2] 3GPP TR 38.901, V17, Annex A, circular angle spread.
    .. [3] B. H. Fleury, "First- and second-order characterization of direction dispersion and space
       selectivity in the radio channel", IEEE Trans. Inf. Theory 46 (2000) 2027-2044.
    """
    places = checked_receivers(candidates.images, places_m)
    m = len(places)
    delay, azimuth, direction = (np.full(m, np.nan) for _ in range(3))

    def work(begin: int, end: int) -> None:
        found = trace_paths(radio, candidates, places[begin:end])
        gains = path_gains(radio, found, transmitter=transmitter, receiver=receiver)
        rows = slice(begin, end)
        delay[rows], azimuth[rows], direction[rows] = _spreads(found.receiver, gains, end - begin)

    run_blocks(work, m, block_size=RECEIVERS_PER_BLOCK, executor=executor, progress=progress)
    return ChannelSpreads(
        delay_spread_s=delay, azimuth_spread_rad=azimuth, direction_spread_rad=direction
    )


def _spreads(
    receiver: npt.NDArray[np.int64], gains: PathGains, count: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    power = np.abs(gains.gain) ** 2

    def total(values: FloatArray) -> FloatArray:
        return np.bincount(receiver, weights=values, minlength=count).astype(np.float64)

    with np.errstate(divide="ignore", invalid="ignore"):  # no power gives NaN
        share = power / total(power)[receiver]
        late = gains.delay_s - total(share * gains.delay_s)[receiver]
        delay = np.sqrt(total(share * late**2))
        ux, uy, uz = gains.arrival.T
        across = np.hypot(ux, uy)
        level = across > 0.0
        cosine = np.where(level, ux / np.where(level, across, 1.0), 1.0)
        sine = np.where(level, uy / np.where(level, across, 1.0), 0.0)
        resultant = np.hypot(total(share * cosine), total(share * sine))
        azimuth = np.sqrt(-2.0 * np.log(np.minimum(resultant, 1.0)))
        mean = np.stack([total(share * u) for u in (ux, uy, uz)], axis=1)
        # Centred, since 1 - |mean|^2 would lose the digits of small spreads.
        away = gains.arrival - mean[receiver]
        direction = np.sqrt(total(share * np.sum(away**2, axis=1)))
    silent = ~(total(power) > 0.0)
    for values in (delay, azimuth, direction):
        values[silent] = math.nan
    return delay, azimuth, direction
