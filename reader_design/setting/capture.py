"""Capture: where a reflection of the tag is stronger than the tag itself."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse, one_antenna_fields
from octant.em.antennas.kinds import Antenna, make_antenna
from octant.em.fields.gains import path_gains
from octant.em.paths.tracing import trace_paths
from octant.reader_design.setting.placing import PlacedTag
from octant.reader_design.setting.samples import room_places_m
from octant.reader_design.setting.setting import Setting

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class ArrivingPaths:
    """The paths from one tag to places on the floor, as plane waves at the reader's centre.

    Attributes
    ----------
    place : (k,) int64 — Place of each path [-].
    bends : (k,) int64 — Reflections and diffractions of each path [-]; 0 is the direct ray.
    theta_rad, phi_rad : (k,) float64 — Direction that each comes from, in the room's frame [rad].
    field : (c, k, 2) complex128 — What a theta- and a phi-polarised isotropic antenna would receive
        of it at each frequency, for 1 W from the tag [-].
    """

    place: npt.NDArray[np.int64]
    bends: npt.NDArray[np.int64]
    theta_rad: FloatArray
    phi_rad: FloatArray
    field: npt.NDArray[np.complex128]


def _isotropic_phi(frequency_hz: float) -> Antenna:
    """Return an antenna that receives the azimuthal component equally from everywhere."""
    table = np.zeros((2, 5, 4), dtype=np.complex128)
    table[1] = 1.0
    return Antenna(
        kind="pattern",
        length_m=0.0,
        frequency_hz=frequency_hz,
        axis=np.array([0.0, 0.0, 1.0]),
        pattern=table,
    )


def arriving_paths(setting: Setting, tag: PlacedTag, places_m: FloatArray) -> ArrivingPaths:
    """Return the paths from a tag to places of the reader: those that their link sums up.

    Parameters
    ----------
    setting, tag : The room, and one of its tags.
    places_m : (p, 2) float64 — Places of the reader [m].
    """
    places = np.column_stack([places_m, np.full(len(places_m), setting.reader_z_m)])
    found = setting.candidates(tag.position_m, receivers_m=places)
    paths = trace_paths(setting.radios[0], found, places)
    fields = []
    for radio, antenna in zip(setting.radios, tag.antennas, strict=True):
        ends = (
            make_antenna("isotropic_theta", radio.frequency_hz),
            _isotropic_phi(radio.frequency_hz),
        )
        gains = [path_gains(radio, paths, transmitter=antenna, receiver=end) for end in ends]
        fields.append(np.stack([g.gain for g in gains], axis=-1))
    arrival = gains[0].arrival
    return ArrivingPaths(
        place=paths.receiver,
        bends=paths.order,
        theta_rad=np.arccos(np.clip(arrival[:, 2], -1.0, 1.0)),
        phi_rad=np.arctan2(arrival[:, 1], arrival[:, 0]),
        field=np.array(fields),
    )


def captured(
    paths: ArrivingPaths, towards_rad: FloatArray, responses: Sequence[ReaderResponse]
) -> npt.NDArray[np.bool_]:
    """Return where a single reflection beats the direct ray at the antenna that faces the tag [-].

    (p, n): for each antenna, turned so that it faces the tag, whether the strongest path with bends
    brings it more power, mean over the frequencies, than the direct ray. Also true where something
    hides the tag and a bent path arrives; false where nothing arrives.

    Parameters
    ----------
    paths : From a tag to the places.
    towards_rad : (p,) float64 — Room azimuth of the tag from each place [rad].
    responses : The reader's, one for each frequency.
    """
    elements = responses[0].azimuths_rad
    out = np.zeros((len(towards_rad), elements.size), dtype=np.bool_)
    for i, element in enumerate(elements):
        azimuth = paths.phi_rad - towards_rad[paths.place] + element
        around = azimuth % (2.0 * math.pi)
        patterns = one_antenna_fields(tuple(responses), i, paths.theta_rad, around)
        power = np.zeros(paths.place.size)
        for pattern, field in zip(patterns, paths.field, strict=True):
            power += np.abs((pattern * field).sum(axis=-1)) ** 2
        direct, bent = np.zeros(len(towards_rad)), np.zeros(len(towards_rad))
        np.maximum.at(direct, paths.place[paths.bends == 0], power[paths.bends == 0])
        np.maximum.at(bent, paths.place[paths.bends > 0], power[paths.bends > 0])
        out[:, i] = bent > direct
    return out


def captured_by_tag(setting: Setting) -> dict[str, npt.NDArray[np.bool_]]:
    """Return for each tag at which places of the floor a reflection beats its direct ray [-].

    Arrays by place within range and facing antenna; tags without a place in range are left out.

    Parameters
    ----------
    setting : The room with its reader; its sampling says which places count [m].
    """
    found = {}
    for tag, places in room_places_m(setting):
        towards = np.arctan2(*(tag.position_m[:2] - places).T[::-1])
        found[tag.id] = captured(arriving_paths(setting, tag, places), towards, setting.responses)
    return found


def captured_share(setting: Setting) -> float:
    """Return the share of places, tags and facing antennas where a reflection beats the ray [-].

    Parameters
    ----------
    setting : The room with its reader; its sampling says which places count [m].
    """
    shares = captured_by_tag(setting)
    return float(np.concatenate(list(shares.values())).mean())
