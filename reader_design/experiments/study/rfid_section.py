"""The report's section on tags that the reader wakes: power, range, inventory, where they wake."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from octant.em.decibels import power_dbm
from octant.navigation.sensing.inventory import Gen2, read_probability, round_s
from octant.reader_design.setting.inventory import competing_tags, dwell_time_s
from octant.reader_design.setting.read_range import read_range
from octant.reader_design.setting.rfid import is_woken, sent_by, study_tag, tag_budget
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.pages import ReportFigure, ReportSection, ReportTable
from octant.reader_design.showing.plan import MapPanel, map_figure, plan_of
from octant.reader_design.showing.style import NamedFigure
from octant.reader_design.showing.wake import MARGIN_DB, range_text
from octant.reader_design.study_file.rfid import Rfid

if TYPE_CHECKING:
    import xarray as xr


def rfid_section(setting: Setting, figures: tuple[ReportFigure, ...]) -> ReportSection | None:
    """Return the section, numbers with their units; None where all tags are active.

    Parameters
    ----------
    setting, figures : The chosen reader in its room; figures of the section.
    """
    study, rfid = setting.study, setting.study.rfid
    if rfid is None:
        return None
    sent = sent_by(rfid, setting.responses)
    limit = "no limit" if sent.band is None else f"limit of {sent.band.text()}"
    who = {
        "each": "each antenna sends while it is read",
        "strongest": "the antenna that the tag hears best sends while all are read",
        "separate": "a separate antenna sends while all are read",
    }[rfid.transmitter]
    rows, points = [], []
    for tag in setting.tags:
        if not is_woken(study, tag):
            continue
        table = study_tag(study, tag)
        budget = tag_budget(rfid, table, sent.conducted_w)
        rows.append(
            (
                tag.id,
                table.kind.replace("_", "-"),
                f"{float(power_dbm(budget.wakes_w)):.1f}",
                f"{table.mismatch_loss_db + table.polarisation_loss_db:.1f}",
                f"{table.modulation_loss_db:.1f}",
                f"{table.backscatter_loss_db + 2.0 * table.polarisation_loss_db:.1f}",
            )
        )
        found = read_range(setting, tag)
        if found is not None:
            points.append(f"tag {tag.id}: {range_text(found)}")
    return ReportSection(
        heading="Tags that the reader wakes",
        paragraphs=(
            (
                f"The reader offers its antenna {sent.conducted_w:.3g} W, which makes "
                f"{sent.eirp_w:.3g} W EIRP ({limit}); {who}. It decodes from "
                f"{rfid.reader_sensitivity_dbm:g} dBm. RSS in this report is what comes back from "
                "a tag that is awake, through the room both ways."
            ),
        ),
        points=tuple(points),
        tables=(
            ReportTable(
                caption="Link budget of the tags, besides the paths and both antennas.",
                header=(
                    "tag",
                    "kind",
                    "wakes at [dBm]",
                    "loss into the chip [dB]",
                    "modulation [dB]",
                    "further loss both ways [dB]",
                ),
                rows=tuple(rows),
            ),
            *((_inventory_table(setting, rfid),) if rfid.protocol == "gen2" else ()),
        ),
        figures=figures,
    )


def _inventory_table(setting: Setting, rfid: Rfid) -> ReportTable:
    protocol, most = rfid.air_interface(), competing_tags(setting.study)
    dwell_s = dwell_time_s(setting.study)
    counts = sorted({1, 2, 5, 10, 20, 50, 100, most})
    rows = tuple(_inventory_row(protocol, count, dwell_s) for count in counts)
    empty, read, collided = (1e3 * protocol.slot_s(k) for k in range(3))
    return ReportTable(
        caption=f"Inventory (EPC Gen2): a slot takes {empty:.3g} ms empty, {read:.3g} ms with one "
        f"tag, {collided:.3g} ms with a collision. {most} tags answer here at most; each antenna "
        f"has {1e3 * dwell_s:.3g} ms.",
        header=(
            "tags that answer",
            "mean time of an inventory [ms]",
            f"read in {1e3 * dwell_s:.3g} ms [%]",
        ),
        rows=rows,
        best=counts.index(most),
    )


def _inventory_row(protocol: Gen2, tags: int, dwell_s: float) -> tuple[str, str, str]:
    share = read_probability(protocol, tags, dwell_s)
    return str(tags), f"{1e3 * round_s(protocol, tags):.3g}", f"{100.0 * share:.1f}"


def rfid_figures(setting: Setting, room_map: "xr.Dataset") -> Iterator[NamedFigure]:
    """Yield the map of where tags wake [dB].

    Parameters
    ----------
    setting, room_map : The chosen reader in its room, and its maps; not all tags are active.
    """
    blocked = room_map["standing"].values == 0
    margins = np.clip(room_map["wake_margin_db"].values, -MARGIN_DB, MARGIN_DB)
    panels = [
        MapPanel(
            title=f"tag {tag.id}",
            values=np.where(blocked, np.nan, margins[i]).T,
            tags={tag.id: tag.point_m},
        )
        for i, tag in enumerate(setting.tags)
        if is_woken(setting.study, tag)
    ]
    yield NamedFigure(
        file="map_wake.png",
        section="rfid",
        title="Where the tags wake",
        caption="Power at the tag's chip over its threshold with the antenna and the channel that "
        "reach it best: blue where the tag wakes, red where it sleeps and nothing is read; grey is "
        "where the reader does not fit.",
        figure=map_figure(
            room_map["x"].values,
            room_map["y"].values,
            panels,
            plan_of(setting.scene, setting.reader_z_m),
            title=f"Where tags wake (blue), heading {float(room_map.attrs['heading_deg']):g}°",
            bar_label="chip's power over its threshold [dB]",
            limits=(-MARGIN_DB, MARGIN_DB),
            colours="RdBu",
        ),
    )
