"""Figures of ``octant map``: every layer of its dataset as plan views of the room."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.reader_design.face.rss_map import open_places
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.showing.plan import (
    MapPanel,
    Plan,
    draw_plan,
    draw_tags,
    map_figure,
    plan_of,
    plan_shape,
)
from octant.reader_design.showing.rasters import Raster
from octant.reader_design.showing.style import (
    ANTENNA_COLOURS,
    figure_style,
    new_figure,
    save_figure,
)
from octant.reader_design.showing.wake import MARGIN_DB
from octant.reader_design.study_file.loading import parse_study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]

PAGES = (
    "power.png",
    "strongest_antenna.png",
    "bearing_error.png",
    "path_count.png",
    "delay_spread.png",
    "azimuth_spread.png",
    "direction_spread.png",
    "wake_margin.png",
)
MOST_TAGS = 4
FEW_COUNTS = 12
"""Different numbers of paths [-] up to which each gets a colour of its own."""

_POWERS = (
    ("rss_w", "coherent"),
    ("rss_local_mean_w", "local mean (power sum over paths)"),
    ("rss_disc_mean_w", "local mean (disc of one wavelength)"),
)
_SPREADS = (
    ("delay_spread", "RMS delay spread", "delay spread [ns]"),
    ("azimuth_spread", "Azimuth spread of arrival (circular)", "azimuth spread [°]"),
    ("direction_spread", "Direction spread of arrival (over the sphere)", "direction spread [°]"),
)


def save_pages(
    data: "xr.Dataset", setting: Setting, folder: Path, *, threshold_dbm: float | None = None
) -> list[Path]:
    """Return the figures of `PAGES` that are written, one for each layer, four tags a page at most.

    Grey is outside the room and inside objects.

    Parameters
    ----------
    data : From `octant.reader_design.face.rss_map.map_dataset`.
    setting, folder : The room; where the figures go.
    threshold_dbm : Level whose contour is drawn in the figure of powers [dBm].
    """
    written: list[Path] = []
    for name, figure in _pages(_Pages(data, setting, threshold_dbm)):
        save_figure(figure, folder / name)
        written.append(folder / name)
    return written


def raster_figure(
    data: "xr.Dataset",
    raster: Raster,
    *,
    limits: tuple[float, float] | None,
    colours: str,
    contour: float | None,
) -> "Figure":
    """Return one layer of a map as a plan view of the room of its study.

    Parameters
    ----------
    data : The map, whose attribute ``study`` holds the room.
    raster, limits, colours, contour : The layer; as of `map_figure` [its unit].
    """
    setting = build_setting(
        parse_study(data.attrs["study"], source="the map's study", directory=Path.cwd())
    )
    pages = _Pages(data, setting, contour)
    title, _, tag = raster.name.rpartition(", tag ")
    return pages.map(
        [replace(pages.panel(f"tag {tag}", raster.values, tag), contour=contour)],
        title=f"{title[:1].upper()}{title[1:]}\n{pages.where}",
        bar_label=f"{title} [{'°' if raster.unit == 'degree' else raster.unit}]",
        limits=limits,
        colours=colours,
    )


def _pages(pages: "_Pages") -> "Iterator[tuple[str, Figure]]":
    yield "power.png", pages.power()
    if "strongest_antenna" in pages.data:
        yield "strongest_antenna.png", pages.strongest()
        yield "bearing_error.png", pages.bearing_error()
    yield "path_count.png", pages.path_count()
    for name, title, bar in _SPREADS:
        if name in pages.data:
            yield f"{name}.png", pages.layer(name, title=title, bar_label=bar)
    if "wake_margin_db" in pages.data:
        yield "wake_margin.png", pages.wake_margin()


class _Pages:
    """The figures of one dataset, which share its grid, plan, tags and mask."""

    def __init__(
        self, data: "xr.Dataset", setting: Setting, threshold_dbm: float | None = None
    ) -> None:
        self.data = data
        self.threshold_dbm = threshold_dbm
        self.x, self.y = data["x"].to_numpy(), data["y"].to_numpy()
        self.plan = plan_of(setting.scene, float(data["z"]))
        x, y = np.meshgrid(self.x, self.y, indexing="ij")
        places = np.column_stack((x.ravel(), y.ravel(), np.full(x.size, float(data["z"]))))
        self.open = open_places(setting, places).reshape(x.shape)
        self.ids = [str(tag) for tag in data["tag"].to_numpy()][:MOST_TAGS]
        self.points = {tag.id: tag.position_m[:2] for tag in setting.tags}
        receiver = data.attrs["receiver"]
        if receiver == "reader":
            receiver += f", heading {float(data['heading']):g}°"
        self.where = f"z = {float(data['z']):g} m, {receiver}"

    def panel(self, title: str, values: FloatArray, tag: str) -> MapPanel:
        shown = np.where(self.open & np.isfinite(values), values, np.nan)
        return MapPanel(title=title, values=shown.T, tags={tag: self.points[tag]})

    def map(self, panels: Sequence[MapPanel], **options: Any) -> "Figure":  # noqa: ANN401
        return map_figure(self.x, self.y, panels, self.plan, **options)

    def power(self) -> "Figure":
        present = [(name, what) for name, what in _POWERS if name in self.data]
        what_of = "strongest antenna" if "antenna" in self.data.dims else "antenna"
        panels = []
        for i, tag in enumerate(self.ids):
            for name, what in present:
                values = self.data[name].to_numpy()[i].astype(np.float64)
                best = values.max(axis=-1) if values.ndim == 3 else values
                panel = self.panel(f"{what}, tag {tag}", power_dbm(best), tag)
                panels.append(replace(panel, contour=self.threshold_dbm))
        line = "" if self.threshold_dbm is None else f"; line at {self.threshold_dbm:g} dBm"
        return self.map(
            panels,
            title=f"Received power of the {what_of}\n{self.where}{line}",
            bar_label="received power [dBm]",
            columns=len(present),
        )

    def bearing_error(self) -> "Figure":
        errors = np.abs(self.data["bearing_error"].to_numpy())
        panels = [self.panel(f"tag {tag}", errors[i], tag) for i, tag in enumerate(self.ids)]
        return self.map(
            panels,
            title=f"Bearing error of the RSS-weighted vector sum\n{self.where}",
            bar_label="absolute bearing error [°]",
            limits=(0.0, 180.0),
            colours="magma_r",
        )

    def layer(self, name: str, *, title: str, bar_label: str) -> "Figure":
        values = self.data[name].to_numpy()
        panels = [self.panel(f"tag {tag}", values[i], tag) for i, tag in enumerate(self.ids)]
        where = f"z = {float(self.data['z']):g} m, isotropic_theta"
        return self.map(panels, title=f"{title}\n{where}", bar_label=bar_label, colours="cividis")

    def wake_margin(self) -> "Figure":
        margins = np.clip(self.data["wake_margin_db"].to_numpy(), -MARGIN_DB, MARGIN_DB)
        panels = [self.panel(f"tag {tag}", margins[i], tag) for i, tag in enumerate(self.ids)]
        return self.map(
            panels,
            title=f"Where the tag wakes (blue) and by how much\n{self.where}",
            bar_label="chip's power over its threshold [dB]",
            limits=(-MARGIN_DB, MARGIN_DB),
            colours="RdBu",
        )

    def path_count(self) -> "Figure":
        counts = self.data["path_count"].to_numpy().astype(np.float64)
        panels = [self.panel(f"tag {tag}", counts[i], tag) for i, tag in enumerate(self.ids)]
        seen = np.concatenate([p.values[np.isfinite(p.values)] for p in panels])
        low, high = (int(seen.min()), int(seen.max())) if seen.size else (0, 1)
        return self.map(
            panels,
            title=f"Number of paths\n{self.where}",
            bar_label="paths [-]",
            limits=(low - 0.5, high + 0.5),
            colours="viridis",
            levels=high - low + 1 if high - low < FEW_COUNTS else None,
        )

    def strongest(self) -> "Figure":
        values = self.data["strongest_antenna"].to_numpy().astype(np.float64)
        values = np.where(values > 0, values, np.nan)
        panels = [self.panel(f"tag {tag}", values[i], tag) for i, tag in enumerate(self.ids)]
        heading = float(self.data["heading"])
        count = self.data.sizes["antenna"]
        turn = heading - 90.0 + np.arange(count) * 360.0 / count
        return category_figure(
            self.x,
            self.y,
            panels,
            self.plan,
            names=[f"{i + 1}: {azimuth % 360.0:g}°" for i, azimuth in enumerate(turn)],
            title=f"Strongest antenna\n{self.where}",
            legend_title="antenna: azimuth\nin the room",
        )


def category_figure(
    x_m: FloatArray,
    y_m: FloatArray,
    panels: Sequence[MapPanel],
    plan: Plan,
    *,
    names: Sequence[str],
    title: str,
    legend_title: str,
) -> "Figure":
    """Return plan views of numbered categories with one colour each, two in a row, axes in [m].

    Parameters
    ----------
    x_m, y_m : (nx,), (ny,) float64 — Grid [m].
    panels, names : Numbers from 1 (NaN is grey), and what they mean.
    plan : Walls and objects.
    title, legend_title : Above the figure and its legend.
    """
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    colours = [ANTENNA_COLOURS[i % len(ANTENNA_COLOURS)] for i in range(len(names))]
    columns = min(len(panels), 2)
    rows = -(-len(panels) // columns)
    extent = plan_shape(plan, x_m, y_m)
    with figure_style():
        figure, axes = new_figure(
            width_in=1.7 + 4.1 * columns,
            height_in=0.6 + 0.25 * title.count("\n") + (0.85 + 3.35 * extent) * rows,
            title=title,
            rows=rows,
            columns=columns,
        )
        for ax, panel in zip(axes.ravel(), panels, strict=False):
            ax.set_facecolor("#d8d8d8")
            ax.grid(visible=False)
            ax.pcolormesh(
                x_m,
                y_m,
                panel.values,
                shading="nearest",
                cmap=ListedColormap(colours),
                vmin=0.5,
                vmax=len(names) + 0.5,
                rasterized=True,
            )
            draw_plan(ax, plan, extra_m=np.array([[x_m[0], y_m[0]], [x_m[-1], y_m[-1]]]))
            draw_tags(ax, panel.tags)
            ax.set_title(panel.title)
        for ax in axes.ravel()[len(panels) :]:
            ax.set_visible(False)
        handles = [Patch(color=c, label=n) for c, n in zip(colours, names, strict=True)]
        figure.legend(handles=handles, loc="outside right center", title=legend_title)
    return figure
