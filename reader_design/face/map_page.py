"""The report of ``octant map``: the map to explore, and every layer as a figure."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from octant.reader_design.keeping.versions import versions
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.map_view import FloorMaps, map_widget, symmetric_turn
from octant.reader_design.showing.pages import (
    Report,
    ReportFigure,
    ReportLink,
    ReportSection,
    Verdict,
    read_figure,
)
from octant.reader_design.showing.plan import plan_of
from octant.reader_design.showing.room_view import room_widget

if TYPE_CHECKING:
    import xarray as xr

TITLES = {
    "power": ("Received power", "Coherent, and its local means."),
    "strongest_antenna": ("Strongest antenna", "Which antenna receives most."),
    "bearing_error": ("Bearing error", "Error of the vector sum at this heading."),
    "path_count": ("Paths", "How many paths arrive."),
    "delay_spread": ("Delay spread", "Of the channel from the tag."),
    "azimuth_spread": ("Azimuth spread", "Of the directions of arrival."),
    "direction_spread": ("Direction spread", "Of the directions of arrival, over the sphere."),
    "wake_margin": ("Where tags wake", "Power at the chip over its threshold."),
}
"""Title and caption of each figure, by its file."""


def map_report(data: "xr.Dataset", setting: Setting, pages: Sequence[Path], out: Path) -> Report:
    """Return the report of a map [W], [deg].

    Parameters
    ----------
    data, setting, pages, out : The map, its room, its figures, its file.
    """
    tags = [str(name) for name in data["tag"].values]
    known = {tag.id for tag in setting.tags}
    drawn = tuple(_figure(page) for page in pages)
    explored = all(tag in known for tag in tags)
    widgets = []
    if explored:
        widgets.append(
            map_widget(
                _floor(data, setting),
                setting,
                plan_of(setting.scene, float(data["z"])),
                tags=tags,
                fallback=drawn[:1],
            )
        )
    room = room_widget(
        setting, start_m=None if setting.study.mission is None else setting.study.mission.start_m
    )
    found = "; ".join(f"{n.removesuffix('_version')} {v}" for n, v in versions().items())
    lines = data.attrs.get("summary", "").splitlines()
    receiver = "one isotropic antenna" if "antenna" not in data.dims else setting.reader.label()
    return Report(
        title=f"{setting.study.name}: received power over the floor",
        subtitle=f"{len(tags)} tag{'' if len(tags) == 1 else 's'}, received by {receiver} at "
        f"{float(data['z']):.2f} m height",
        summary=(),
        warnings=tuple(setting.notes),
        facts=(),
        verdict=Verdict(
            sentence=lines[0] if lines else "The map is computed.", further=tuple(lines[1:])
        ),
        sections=(
            ReportSection(
                heading="The map", widgets=tuple(widgets), figures=drawn[1:] if explored else drawn
            ),
            *(() if room is None else (ReportSection(heading="The room", widgets=(room,)),)),
            ReportSection(
                heading="Reproduce it",
                paragraphs=(f"Versions: {found}.",),
                links=(ReportLink(file=out.name, what="every layer, with units"),),
                folded=(
                    ("The command", f"octant map study.toml --out {out.name}"),
                    ("The study with every default resolved (study.toml)", data.attrs["study"]),
                ),
            ),
        ),
    )


def _figure(page: Path) -> ReportFigure:
    return read_figure(*TITLES.get(page.stem, (page.stem.replace("_", " "), "")), page)


def _floor(data: "xr.Dataset", setting: Setting) -> FloorMaps:
    power = data["rss_w"].values
    mean = data["rss_local_mean_w"].values if "rss_local_mean_w" in data else None
    whole = "antenna" in data.dims and data.sizes["antenna"] == setting.reader.antennas
    azimuths = np.zeros(1)
    if "antenna" in data.dims:
        numbers = np.asarray(data["antenna"].values, dtype=int) - 1
        azimuths = setting.responses[0].azimuths_rad[numbers]
    else:
        power = power[..., None]
        mean = None if mean is None else mean[..., None]
    heading = float(data["heading"]) if "heading" in data.coords else 90.0
    return FloorMaps(
        x_m=data["x"].values,
        y_m=data["y"].values,
        headings_rad=np.radians([heading]),
        coherent_w=power[None],
        mean_w=None if mean is None else mean[None],
        standing=data["open_floor"].values.astype(bool)
        if "open_floor" in data
        else np.ones((data.sizes["x"], data.sizes["y"]), dtype=bool),
        azimuths_rad=azimuths,
        turn=symmetric_turn(setting.responses[0]) if whole else 0,
    )
