"""Links to tags that the reader wakes: what it may send, what they need, how far that reaches."""

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import GRID_SHAPE, ReaderResponse
from octant.em.antennas.kinds import Antenna, make_antenna
from octant.em.directions import angle_grid
from octant.em.medium.radio_scene import RadioScene
from octant.em.power.backscatter import (
    BackscatterBudget,
    BackscatterLink,
    FixedGain,
    SeparateGain,
)
from octant.em.power.received_power import ReaderLink, antenna_power, reader_link
from octant.em.search.candidates import SolverSettings, search_candidates
from octant.geometries.errors import PhysicsWarning
from octant.reader_design.setting.antennas import named_antenna
from octant.reader_design.setting.placing import PlacedTag, place_antenna
from octant.reader_design.study_file.rfid import Band, Rfid, band_at, refuse_loud
from octant.reader_design.study_file.schema import Study, Tag

FloatArray = npt.NDArray[np.float64]

SENSITIVITY_DBM = {"passive": -18.0, "semi_passive": -31.0}
"""Power [dBm] at which usual chips work: passive ones as data sheets of the 2010s give it, battery-
assisted ones limited by their detector (EM4325: -31 dBm)."""


ISOTROPIC = "isotropic_theta"
"""Kind of antenna, and model of the reader that has it alone."""


def isotropic_responses(frequencies_hz: Sequence[float]) -> tuple[ReaderResponse, ...]:
    """Return a reader of one isotropic antenna at each frequency [Hz].

    Parameters
    ----------
    frequencies_hz : Frequencies of the study [Hz].
    """
    antennas = [make_antenna(ISOTROPIC, f) for f in frequencies_hz]
    return tuple(single_response(antenna, model=ISOTROPIC) for antenna in antennas)


def tag_budget(rfid: Rfid, tag: Tag, sent_w: float) -> BackscatterBudget:
    """Return what happens to the reader's power at a tag [W].

    Parameters
    ----------
    rfid, tag : The tables ``[rfid]`` and ``[[tag]]`` of a tag that is not active.
    sent_w : Power that the reader offers the sending antenna [W].
    """
    sensitivity_dbm = tag.sensitivity_dbm
    if sensitivity_dbm is None:
        sensitivity_dbm = SENSITIVITY_DBM[tag.kind]
    backward_db = tag.modulation_loss_db + tag.backscatter_loss_db + 2.0 * tag.polarisation_loss_db
    return BackscatterBudget(
        sent_w=sent_w,
        forward=10.0 ** (-(tag.mismatch_loss_db + tag.polarisation_loss_db) / 10.0),
        backward=10.0 ** (-backward_db / 10.0),
        wakes_w=10.0 ** ((sensitivity_dbm - 30.0) / 10.0),
        decodes_w=10.0 ** ((rfid.reader_sensitivity_dbm - 30.0) / 10.0),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Sent:
    """What a reader sends.

    Parameters
    ----------
    conducted_w : Power that it offers its antenna [W].
    eirp_w : The same in the antenna's strongest direction, over an isotropic one [W].
    band : The band whose limit holds; None without one.
    """

    conducted_w: float
    eirp_w: float
    band: Band | None


def sent_power(rfid: Rfid, frequency_hz: float, peak_gain: float, *, real: bool = True) -> Sent:
    """Return what the reader sends at a frequency [Hz]; refuse more than its region allows.

    A PhysicsWarning says where an EIRP that is given needs more conducted power than the region
    allows; without ``power_w`` the smaller of both limits holds.

    Parameters
    ----------
    rfid, frequency_hz : The table ``[rfid]``.
    peak_gain : Greatest realised gain of the antennas that send [-]. All are fed alike.
    real : False: an isotropic antenna, of which only the EIRP counts.
    """
    band = band_at(rfid.region, frequency_hz)
    limited = real and band is not None and band.conducted_w is not None
    most_w = (band.conducted_w if band and limited else None) or math.inf
    eirp_w = rfid.eirp_w
    if rfid.power_w is None:
        conducted_w = min(band.eirp_w / peak_gain if band else math.inf, most_w)
    elif eirp_w is None:
        conducted_w = rfid.power_w
    else:
        conducted_w = eirp_w / peak_gain
        if band is not None and conducted_w > most_w * (1.0 + 1e-9):
            msg = (
                f"an EIRP of {eirp_w:.4g} W takes {conducted_w:.4g} W into an antenna of "
                f"{10.0 * math.log10(peak_gain):.1f} dBi, but {band.rule} allows {most_w:g} W of "
                "conducted power; leave rfid.power_w out for what is allowed"
            )
            warnings.warn(msg, PhysicsWarning, stacklevel=2)
    if band is not None:
        refuse_loud(band, conducted_w * peak_gain)
    return Sent(conducted_w=conducted_w, eirp_w=conducted_w * peak_gain, band=band)


def peak_gain(pattern: npt.NDArray[np.complex128]) -> float:
    """Return the greatest gain of patterns over their grid [-].

    Parameters
    ----------
    pattern : (..., 2, T, P) complex128 — F_theta and F_phi [-].
    """
    return float((np.abs(pattern) ** 2).sum(axis=-3).max())


def antenna_pattern(antenna: Antenna) -> npt.NDArray[np.complex128]:
    """Return the pattern of an antenna on the readers' grid, (2, T, P) [-].

    Parameters
    ----------
    antenna : In the frame of the grid.
    """
    theta, phi = angle_grid(*GRID_SHAPE)
    return np.moveaxis(antenna.far_field(theta[:, None], phi), -1, 0)


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkPlace:
    """Where a link is, and how it is traced.

    Parameters
    ----------
    radios : The room, or free space, at each frequency.
    tag_m : (3,) float64 — Place of the tag there [m].
    height_m : Reader's ground plane above the floor [m].
    solver : How paths are searched.
    standoff_m : How far a transmitter that lies on a surface is moved off it [m].
    places_m : (m, 2) array_like — The only x, y of the robot [m]; None: any.
    """

    radios: Sequence[RadioScene]
    tag_m: FloatArray
    height_m: float
    solver: SolverSettings
    standoff_m: float
    places_m: npt.ArrayLike | None = None


def transmitters(rfid: Rfid, frequencies_hz: Sequence[float]) -> tuple[Antenna, ...]:
    """Return the separate antenna that sends at each frequency [Hz]; none where the reader's do.

    Parameters
    ----------
    rfid, frequencies_hz : The table ``[rfid]``; frequencies of the study.
    """
    if rfid.transmitter != "separate":
        return ()
    return tuple(
        named_antenna(
            rfid.transmitter_antenna,
            frequency_hz,
            key="rfid.transmitter_antenna",
            axis=rfid.transmitter_axis,
        )
        for frequency_hz in frequencies_hz
    )


def sent_by(rfid: Rfid, responses: Sequence[ReaderResponse]) -> Sent:
    """Return what a reader sends, on all channels alike [W]; see `sent_power`.

    Parameters
    ----------
    rfid, responses : The table ``[rfid]``; the reader at each frequency.
    """
    frequencies_hz = [one.frequency_hz for one in responses]
    separate = transmitters(rfid, frequencies_hz)
    patterns = [antenna_pattern(antenna) for antenna in separate]
    gains = [peak_gain(p) for p in patterns or [one.pattern for one in responses]]
    real = bool(separate) or responses[0].model != ISOTROPIC
    found = [sent_power(rfid, f, g, real=real) for f, g in zip(frequencies_hz, gains, strict=True)]
    return min(found, key=lambda sent: sent.conducted_w)


def woken_link(
    study: Study, tag: PlacedTag, place: LinkPlace, responses: Sequence[ReaderResponse]
) -> BackscatterLink:
    """Return the link of a reader to a passive or semi-passive tag, through the paths of both ways.

    Parameters
    ----------
    study, tag : The study with a table ``[rfid]``; the tag as it is placed.
    place, responses : Where the link is [m]; the reader at each frequency.
    """
    rfid, table = rfid_table(study), study_tag(study, tag)
    ways = tuple(
        _way(radio, antenna, response, place)
        for radio, antenna, response in zip(place.radios, tag.antennas, responses, strict=True)
    )
    return BackscatterLink(
        ways=ways,
        budget=tag_budget(rfid, table, sent_by(rfid, responses).conducted_w),
        sender=rfid.transmitter,
        separate=_separate(rfid, tag, place),
    )


def is_woken(study: Study, tag: PlacedTag) -> bool:
    """Return whether a tag must be woken by the reader: a passive or semi-passive one.

    Parameters
    ----------
    study, tag : The study, one of its tags.
    """
    return study_tag(study, tag).kind != "active"


def rfid_table(study: Study) -> Rfid:
    """Return the study's table ``[rfid]``; `check_rfid` has refused woken tags without one.

    Parameters
    ----------
    study : A checked study.
    """
    return study.rfid or Rfid()


def study_tag(study: Study, tag: PlacedTag) -> Tag:
    """Return a placed tag's table ``[[tag]]``.

    Parameters
    ----------
    study, tag : The study, one of its tags.
    """
    return next(one for one in study.tags if one.id == tag.id)


def _way(
    radio: RadioScene, antenna: Antenna, response: ReaderResponse, place: LinkPlace
) -> ReaderLink:
    return reader_link(
        radio,
        tag_position_m=place.tag_m,
        tag_antenna=antenna,
        tag_power_w=1.0,
        response=response,
        reader_height_m=place.height_m,
        solver=place.solver,
        places_m=place.places_m,
    )


def _separate(rfid: Rfid, tag: PlacedTag, place: LinkPlace) -> tuple[SeparateGain, ...]:
    """Return the gain from the separate antenna to the tag at each frequency."""
    antennas = transmitters(rfid, [radio.frequency_hz for radio in place.radios])
    links = zip(place.radios, tag.antennas, antennas, strict=False)
    if rfid.transmitter_position_m is None:
        on_robot = replace(place, height_m=place.height_m + rfid.transmitter_height_m)
        return tuple(
            _way(radio, at_tag, single_response(antenna), on_robot)
            for radio, at_tag, antenna in links
        )
    scene = place.radios[0].scene
    there = np.array(rfid.transmitter_position_m) + place.tag_m - tag.position_m
    if scene.has_room:
        there, _ = place_antenna(
            scene,
            there,
            place.standoff_m,
            name="the transmitter",
            key="rfid.transmitter_position_m",
        )
    return tuple(_fixed(radio, at_tag, antenna, there, place) for radio, at_tag, antenna in links)


def _fixed(
    radio: RadioScene, at_tag: Antenna, antenna: Antenna, there_m: FloatArray, place: LinkPlace
) -> FixedGain:
    found = search_candidates(radio, place.tag_m, place.solver)
    power = antenna_power(
        radio, found, there_m[None], transmitter=at_tag, receiver=antenna, power_w=1.0
    )
    return FixedGain(coherent=float(power.coherent_w[0]), local_mean=float(power.local_mean_w[0]))


def single_response(antenna: Antenna, *, model: str = "isolated") -> ReaderResponse:
    """Return one antenna on the robot as a reader with that antenna alone [-].

    Parameters
    ----------
    antenna, model : In the reader's frame; what its model is called.
    """
    return ReaderResponse(
        model=model,
        frequency_hz=antenna.frequency_hz,
        azimuths_rad=np.zeros(1),
        phase_centres_m=np.zeros((1, 3)),
        pattern=antenna_pattern(antenna)[None],
    )
