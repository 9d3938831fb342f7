"""The table of a study file for tags that the reader wakes, and what regions allow it to send."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

from msgspec import Meta

from octant.geometries.errors import ConfigError, NavigationError
from octant.navigation.sensing.inventory import Gen2
from octant.reader_design.study_file.quantities import (
    Direction,
    DistanceOrZero,
    FileName,
    Level,
    Point,
    Power,
)
from octant.reader_design.study_file.room import Table

if TYPE_CHECKING:
    from octant.reader_design.study_file.schema import Study, Tag

EIRP_PER_ERP = 10.0**0.215
"""Power over an isotropic antenna by that over a half-wave dipole, 2.15 dB [-]."""


class Rfid(Table, frozen=True, kw_only=True):
    """How the reader wakes tags and inventories them: table ``[rfid]``.

    For tags of the kinds ``passive`` and ``semi_passive``, whose own keys stand in ``[[tag]]``.

    Parameters
    ----------
    region : Whose limits hold: ``etsi`` (EN 302 208: 2 W ERP at 865 to 868 MHz, 4 W ERP at 915 to
        921 MHz; EN 300 440: 0.5 W EIRP at 2.446 to 2.454 GHz), ``fcc`` (47 CFR 15.247: 4 W EIRP
        and 1 W conducted at 902 to 928 MHz and 2.4 to 2.4835 GHz) or ``none``.
    power_w : Power [W] that the reader sends; None: as much as the region allows.
    power_as : What `power_w` counts: ``conducted`` power offered to the antenna, ``eirp`` (in its
        strongest direction, over an isotropic antenna) or ``erp`` (over a half-wave dipole).
    transmitter : Which antenna sends: ``each`` while it is read, the ``strongest`` for the tag
        while all are read, or a ``separate`` one.
    transmitter_antenna : Kind or pattern file of the separate antenna, as ``tag.antenna``.
    transmitter_axis : (3,) tuple of float or None — Direction of its axis; on the robot x counts
        from antenna 1 and y from the robot's front. None: up, patches down.
    transmitter_height_m : How high it stands over the middle of the reader's ground plane [m].
    transmitter_position_m : (3,) tuple of float or None — Its place in the room [m]; None: on the
        robot.
    reader_sensitivity_dbm : RSS [dBm] from which the reader decodes a tag; that of RSS detectors is
        ``sensor.sensitivity_dbm``.
    protocol : ``gen2``: tags that wake together answer in slots (EPC Gen2), which decides how
        probably one is read within ``sensor.dwell_s``, or the mean time of an inventory where that
        is 0; ``none``: every tag that wakes is read.
    other_tags : Tags besides those of the study that always answer.
    tari_s : Length of the reader's zero [s].
    one_per_zero : Length of its one by that of its zero [-].
    blf_hz : Backscatter link frequency [Hz].
    miller : Subcarrier cycles of a tag's bit; 1: FM0.
    pilot : Whether tags send the long preamble (TRext).
    epc_bits : Length of a tag's number [bit].
    q : First exponent of the frame size 2^q.
    q_step : Constant C of the Q algorithm [-].
    """

    region: Literal["none", "etsi", "fcc"] = "none"
    power_w: Power | None = None
    power_as: Literal["conducted", "eirp", "erp"] = "conducted"
    transmitter: Literal["each", "strongest", "separate"] = "each"
    transmitter_antenna: FileName = "dipole"
    transmitter_axis: Direction | None = None
    transmitter_height_m: DistanceOrZero = 0.1
    transmitter_position_m: Point | None = None
    reader_sensitivity_dbm: Level = -85.0
    protocol: Literal["gen2", "none"] = "gen2"
    other_tags: Annotated[int, Meta(ge=0, le=10_000)] = 0
    tari_s: Annotated[float, Meta(ge=6.25e-6, le=25e-6)] = 12.5e-6
    one_per_zero: Annotated[float, Meta(ge=1.5, le=2.0)] = 2.0
    blf_hz: Annotated[float, Meta(ge=40e3, le=640e3)] = 250e3
    miller: Literal[1, 2, 4, 8] = 4
    pilot: bool = False
    epc_bits: Annotated[int, Meta(ge=16, le=496)] = 96
    q: Annotated[int, Meta(ge=0, le=15)] = 4
    q_step: Annotated[float, Meta(ge=0.1, le=0.5)] = 0.3

    def air_interface(self) -> Gen2:
        """Return the inventory's protocol; times in [s]."""
        return Gen2(
            tari_s=self.tari_s,
            one_per_zero=self.one_per_zero,
            blf_hz=self.blf_hz,
            miller=self.miller,
            pilot=self.pilot,
            epc_bits=self.epc_bits,
            q=self.q,
            q_step=self.q_step,
        )

    @property
    def eirp_w(self) -> float | None:
        """The EIRP that the study asks for [W]; None where it asks for another quantity."""
        if self.power_w is None or self.power_as == "conducted":
            return None
        return self.power_w * (EIRP_PER_ERP if self.power_as == "erp" else 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Band:
    """What a region allows a reader to send at some frequencies.

    Parameters
    ----------
    low_hz, high_hz : The frequencies [Hz].
    eirp_w, conducted_w : Greatest EIRP; greatest conducted power, None: no limit of its own [W].
    rule : Where it says so.
    """

    low_hz: float
    high_hz: float
    eirp_w: float
    conducted_w: float | None = None
    rule: str

    def text(self) -> str:
        """Return the band and its limit in words; [MHz], [W]."""
        return (
            f"{self.low_hz / 1e6:g} to {self.high_hz / 1e6:g} MHz ({self.eirp_w:.3g} W EIRP, "
            f"{self.rule})"
        )


BANDS = {
    "etsi": (
        # at 865 MHz in the channels around 865.7, 866.3, 866.9 and 867.5 MHz; at 915 MHz in those
        # around 916.3, 917.5, 918.7 and, in some countries, 919.9 MHz
        Band(low_hz=865e6, high_hz=868e6, eirp_w=2.0 * EIRP_PER_ERP, rule="EN 302 208"),
        Band(low_hz=915e6, high_hz=921e6, eirp_w=4.0 * EIRP_PER_ERP, rule="EN 302 208"),
        # 4 W indoors for hopping readers that send 15 % of the time
        Band(low_hz=2.446e9, high_hz=2.454e9, eirp_w=0.5, rule="EN 300 440"),
    ),
    "fcc": (
        Band(low_hz=902e6, high_hz=928e6, eirp_w=4.0, conducted_w=1.0, rule="47 CFR 15.247"),
        Band(low_hz=2.4e9, high_hz=2.4835e9, eirp_w=4.0, conducted_w=1.0, rule="47 CFR 15.247"),
    ),
}
"""What the regions of ``rfid.region`` allow."""


def band_at(region: str, frequency_hz: float) -> Band | None:
    """Return the region's band next to a frequency [Hz]; None for a region without limits.

    Parameters
    ----------
    region, frequency_hz : As in ``[rfid]`` and ``[radio]``; a reader that is built with errors may
        lie a little outside the band.
    """
    bands = BANDS.get(region, ())
    return min(
        bands,
        key=lambda b: max(b.low_hz - frequency_hz, frequency_hz - b.high_hz, 0.0),
        default=None,
    )


_OF_THE_WOKEN = {
    "sensitivity_dbm": None,
    "mismatch_loss_db": 0.0,
    "modulation_loss_db": 6.0,
    "backscatter_loss_db": 0.0,
    "polarisation_loss_db": 0.0,
}
_OF_A_SEPARATE = {
    "transmitter_antenna": "dipole",
    "transmitter_axis": None,
    "transmitter_height_m": 0.1,
    "transmitter_position_m": None,
}


def woken_tags(tags: Sequence["Tag"]) -> list["Tag"]:
    """Return the tags that the reader must wake: the passive and semi-passive ones.

    Parameters
    ----------
    tags : Tags of a study.
    """
    return [tag for tag in tags if tag.kind != "active"]


def check_rfid(study: "Study") -> None:
    """Refuse tags that nothing wakes, a table for none, and more power than the region allows.

    Parameters
    ----------
    study : A study whose single values are within their ranges [Hz], [W].
    """
    for i, tag in enumerate(study.tags):
        if tag.kind == "active":
            for key, default in _OF_THE_WOKEN.items():
                if getattr(tag, key) != default:
                    msg = (
                        f"tag[{i}].{key} is {getattr(tag, key):g}, but the tag is active and is "
                        f'not woken by the reader; set tag.kind = "passive", or leave it out.'
                    )
                    raise ConfigError(msg)
        elif study.rfid is None:
            msg = (
                f"tag[{i}].kind is {tag.kind!r}, but the study has no table [rfid], which says "
                "what the reader sends; add it with region or power_w."
            )
            raise ConfigError(msg)
    if study.rfid is not None:
        _check_table(study, study.rfid)


def _check_table(study: "Study", rfid: Rfid) -> None:
    if not woken_tags(study.tags):
        msg = (
            "the study has a table [rfid], but all its tags are active and send by themselves; set "
            'tag.kind = "passive" or "semi_passive", or leave the table out.'
        )
        raise ConfigError(msg)
    if rfid.power_w is None and rfid.region == "none":
        msg = (
            "rfid.power_w is missing, but without a region nothing says how much the reader sends; "
            'give rfid.power_w, or rfid.region = "etsi" or "fcc".'
        )
        raise ConfigError(msg)
    if rfid.transmitter != "separate":
        for key, default in _OF_A_SEPARATE.items():
            if getattr(rfid, key) != default:
                msg = (
                    f"rfid.{key} is given, but rfid.transmitter is {rfid.transmitter!r}, so that "
                    'no other antenna sends; set rfid.transmitter = "separate", or leave it out.'
                )
                raise ConfigError(msg)
    try:
        rfid.air_interface()
    except NavigationError as exc:
        msg = f"rfid.blf_hz, rfid.tari_s: {exc}"
        raise ConfigError(msg) from exc
    for frequency_hz in study.radio.frequencies_hz:
        _check_band(rfid, frequency_hz)


def _check_band(rfid: Rfid, frequency_hz: float) -> None:
    band = band_at(rfid.region, frequency_hz)
    if band is None:
        return
    if not band.low_hz <= frequency_hz <= band.high_hz:
        allowed = ", ".join(one.text() for one in BANDS[rfid.region])
        msg = (
            f"the reader sends at {frequency_hz / 1e6:g} MHz, but rfid.region {rfid.region!r} "
            f"allows RFID at {allowed}; change radio.frequency_hz or radio.channels_hz, or set "
            'rfid.region = "none".'
        )
        raise ConfigError(msg)
    if rfid.eirp_w is not None:
        refuse_loud(band, rfid.eirp_w)
    if rfid.power_as == "conducted" and rfid.power_w is not None and band.conducted_w is not None:
        refuse_loud(band, rfid.power_w, limit_w=band.conducted_w, what="conducted power")


def refuse_loud(
    band: Band, power_w: float, *, limit_w: float | None = None, what: str = "EIRP"
) -> None:
    """Refuse more power than a band allows.

    Parameters
    ----------
    band, power_w : The band; EIRP, or another power that is named [W].
    limit_w, what : Its limit [W], None: that of the EIRP; its name.
    """
    limit = band.eirp_w if limit_w is None else limit_w
    if power_w > limit * (1.0 + 1e-9):
        msg = (
            f"rfid.power_w makes {power_w:.4g} W of {what}, but {band.rule} allows {limit:.4g} W "
            f"from {band.low_hz / 1e6:g} to {band.high_hz / 1e6:g} MHz; lower it, leave it out for "
            'the limit, or set rfid.region = "none" to study it all the same.'
        )
        raise ConfigError(msg)
