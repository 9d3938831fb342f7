"""The inventory of the tags that a study's reader wakes: who answers, and how soon one is read."""

from collections.abc import Mapping
from dataclasses import dataclass

from octant.em.power.backscatter import BackscatterLink, Link
from octant.geometries.errors import ConfigError
from octant.navigation.sensing.inventory import ReadRates, read_rates, round_s
from octant.reader_design.setting.rfid import is_woken
from octant.reader_design.setting.setting import Setting
from octant.reader_design.study_file.schema import Study


@dataclass(frozen=True, slots=True, kw_only=True)
class Inventory:
    """How tags that the reader wakes answer together.

    The reader's wave goes from antenna to antenna; where it ceases, tags forget that they were read
    (session S0), so that each antenna begins a new inventory.

    Parameters
    ----------
    crowd : Link of every tag that may answer.
    rates, dwell_s : How probably a tag is read in the time that each antenna has; that time [s].
    """

    crowd: Mapping[str, BackscatterLink]
    rates: ReadRates
    dwell_s: float


def dwell_time_s(study: Study) -> float:
    """Return the time that each antenna has [s]: the sensor's, or that of an inventory of all tags.

    Parameters
    ----------
    study : A study with a table ``[rfid]``.
    """
    if study.rfid is None or study.sensor.dwell_s > 0.0:
        return study.sensor.dwell_s
    return round_s(study.rfid.air_interface(), competing_tags(study))


def competing_tags(study: Study) -> int:
    """Return how many tags answer where the reader wakes all of them [-].

    Parameters
    ----------
    study : A study with a table ``[rfid]``.
    """
    woken = sum(tag.kind != "active" for tag in study.tags)
    return woken + (0 if study.rfid is None else study.rfid.other_tags)


def study_inventory(
    setting: Setting, links: Mapping[str, Link], *, key: str, period_s: float
) -> Inventory | None:
    """Return the inventory of a study; None where all tags are active, or none collide.

    Parameters
    ----------
    setting, links : The reader in its room; links that are made already.
    key, period_s : What says how often all antennas are read, and that time [s].
    """
    study, rfid = setting.study, setting.study.rfid
    if rfid is None or rfid.protocol == "none":
        return None
    crowd = {}
    for tag in setting.tags:
        if is_woken(study, tag):
            link = links.get(tag.id) or setting.link(tag)
            if isinstance(link, BackscatterLink):
                crowd[tag.id] = link
    dwell_s, antennas = dwell_time_s(study), setting.reader.antennas
    if antennas * dwell_s > period_s * (1.0 + 1e-12):
        msg = (
            f"an inventory of {competing_tags(study)} tags takes {dwell_s:.3g} s on each of "
            f"{antennas} antennas, but {key} is {period_s:g} s; give sensor.dwell_s (fewer tags "
            "are read then), a faster rfid.blf_hz and rfid.miller, or a longer period."
        )
        raise ConfigError(msg)
    rates = read_rates(rfid.air_interface(), len(crowd), dwell_s, others=rfid.other_tags)
    return Inventory(crowd=crowd, rates=rates, dwell_s=dwell_s)
