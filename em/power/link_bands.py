"""Frequencies of a link that share their paths: searched and traced once, evaluated at each."""

import math
import warnings
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse, response_arrays
from octant.em.antennas.kinds import Antenna, antenna_channels
from octant.em.blocks import Progress, run_blocks
from octant.em.medium.radio_scene import RadioScene
from octant.em.paths.reach import CellImages
from octant.em.paths.tracing import checked_receivers, path_arrays, scene_arrays
from octant.em.power import _power_kernels
from octant.em.records import (
    AntennaChannels,
    ChannelArrays,
    EdgeTreeArrays,
    PatternChannels,
    ResponseArrays,
    SceneArrays,
)
from octant.em.search.candidates import SolverSettings, search_candidates
from octant.em.search.edges import wedge_frames
from octant.em.search.images import ImageTree
from octant.geometries.errors import AntennaError, GeometryError, PhysicsWarning

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]


PLACES_PER_BLOCK = (32, 256)
"""Places [-] that one call of the kernel takes: of few places, more would leave cores idle; of many
(`MANY`), an image is searched for all of them at once."""

MANY = 2048


class Channel(NamedTuple):
    """One frequency of a link."""

    radio: RadioScene
    tag: Antenna
    response: ReaderResponse


class LinkBand(NamedTuple):
    """Frequencies of a link whose paths are the same, ready for the kernels."""

    scene: SceneArrays
    walls: ChannelArrays
    images: CellImages
    ways: EdgeTreeArrays
    tag: AntennaChannels | PatternChannels
    response: ResponseArrays
    tree: ImageTree

    @property
    def channels(self) -> int:
        """Number of frequencies."""
        return len(self.walls.wavelength)

    def add_power(
        self,
        places_m: FloatArray,
        headings_rad: FloatArray,
        rows: tuple[FloatArray, FloatArray, IntArray],
        progress: Progress | None,
    ) -> None:
        """Add the channels' gains and local means (m, h, n), and fill (m,) counts of paths.

        Parameters
        ----------
        places_m, headings_rad : (m, 3), (m, h) float64 — Reader's centre [m], headings [rad].
        rows : Coherent gains, their local means (both [-]), numbers of paths.
        progress : Called after every block.
        """
        places = checked_receivers(self.tree, places_m)
        turns = np.ascontiguousarray(headings_rad - 0.5 * math.pi)
        images = self.images.at(places[0]) if len(places) == 1 else self.images.tree
        arrays = (self.scene, self.walls, images, self.ways, self.tag, self.response)

        def work(begin: int, end: int) -> None:
            _power_kernels.reader_power(*arrays, places, turns, begin, end, *rows)

        block_size = PLACES_PER_BLOCK[len(places) >= MANY]
        run_blocks(work, len(places), block_size=block_size, progress=progress)


def link_channels(
    radio: RadioScene | Sequence[RadioScene],
    tag: Antenna | Sequence[Antenna],
    response: ReaderResponse | Sequence[ReaderResponse],
) -> tuple[Channel, ...]:
    """Return the frequencies of a link, once scene, tag and reader fit each other at each [Hz].

    Parameters
    ----------
    radio, tag, response : Room, tag's antenna and reader, each at every frequency.
    """
    radios = (radio,) if isinstance(radio, RadioScene) else tuple(radio)
    tags = (tag,) if isinstance(tag, Antenna) else tuple(tag)
    responses = (response,) if isinstance(response, ReaderResponse) else tuple(response)
    if not radios or not len(radios) == len(tags) == len(responses):
        msg = (
            f"a link was given {len(radios)} scenes, {len(tags)} tag antennas and "
            f"{len(responses)} readers; give one of each for every frequency."
        )
        raise AntennaError(msg)
    channels = tuple(map(Channel, radios, tags, responses))
    for channel in channels:
        frequencies = [part.frequency_hz for part in channel]
        if max(frequencies) - min(frequencies) > 1e-9 * max(frequencies):
            given = ", ".join(f"{f / 1e9:g}" for f in frequencies)
            msg = f"scene, reader and tag are at {given} GHz; give one frequency for all three."
            raise AntennaError(msg)
        if channel.radio.scene is not radios[0].scene:
            msg = "the scenes of a link's frequencies are of different rooms; give one room."
            raise GeometryError(msg)
        if not np.array_equal(channel.response.azimuths_rad, responses[0].azimuths_rad):
            msg = "the readers of a link's frequencies have different antennas; give one reader."
            raise AntennaError(msg)
    return channels


def check_clearance(clearance_m: float, tag_m: FloatArray, channels: Sequence[Channel]) -> None:
    """Refuse a reader level with the tag; warn where the tag's wave is not plane across the reader.

    Parameters
    ----------
    clearance_m, tag_m : (), (3,) float64 — Tag's height above or below the reader, its place [m].
    channels : Frequencies of the link.
    """
    if clearance_m == 0.0:
        msg = (
            f"the tag at z = {tag_m[2]:g} m is level with the reader's centre, so a pose could "
            "coincide with it; move the tag or change height_m."
        )
        raise GeometryError(msg)
    limit_m = 0.0
    for radio, _, response in channels:
        diameter_m = 2.0 * float(np.linalg.norm(response.phase_centres_m, axis=1).max())
        limit_m = max(limit_m, 2.0 * diameter_m**2 / radio.wavelength_m)
    if clearance_m < limit_m:
        msg = (
            f"the tag can come within {clearance_m:.2f} m of the reader, but its wave is plane "
            f"across the reader only beyond 2 D^2/lambda = {limit_m:.2f} m"
        )
        warnings.warn(msg, PhysicsWarning, stacklevel=3)


def link_bands(
    channels: Sequence[Channel],
    source_m: FloatArray,
    solver: SolverSettings,
    *,
    receivers_m: FloatArray | None = None,
) -> tuple[LinkBand, ...]:
    """Return the channels of a link in bands, in as few as their paths allow: nearly always one.

    Walls that let only some frequencies through keep channels apart, and so do other pattern grids.

    Parameters
    ----------
    channels, solver : Frequencies in one room, and how paths are searched.
    source_m : (3,) float64 — Place of the tag [m].
    receivers_m : (m, 3) float64 — The only places [m] of the reader's centre; None: any.
    """
    groups: dict[tuple[object, ...], list[Channel]] = {}
    for channel in channels:
        groups.setdefault(_what_paths_share(channel), []).append(channel)
    bands = []
    for group in groups.values():
        # How far past an edge's end paths lead over it grows with the wavelength.
        radio = max((channel.radio for channel in group), key=lambda radio: radio.wavelength_m)
        found = search_candidates(radio, source_m, solver, receivers_m=receivers_m)
        scene, images, ways = path_arrays(radio, found)
        scenes = [scene_arrays(channel.radio) for channel in group]
        bands.append(
            LinkBand(
                scene=scene,
                walls=ChannelArrays(
                    wavelength=np.array([scene.wavelength for scene in scenes]),
                    layer_permittivity=np.stack([scene.layer_permittivity for scene in scenes]),
                    layer_thickness=np.stack([scene.layer_thickness for scene in scenes]),
                ),
                images=CellImages(scene, images),
                ways=ways,
                tag=antenna_channels([channel.tag for channel in group]),
                response=response_arrays(tuple(channel.response for channel in group)),
                tree=found.images,
            )
        )
    return tuple(bands)


def _what_paths_share(channel: Channel) -> tuple[object, ...]:
    radio, tag, response = channel
    return (
        radio.facet_transmits.tobytes(),
        radio.facet_layers.tobytes(),
        np.isinf(radio.layer_thickness_m).tobytes(),
        wedge_frames(radio.wedges).tobytes(),
        response.pattern.shape,
        None if tag.pattern is None else tag.pattern.shape,
    )
