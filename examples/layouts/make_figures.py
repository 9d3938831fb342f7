"""Draw the figures of docs/evidence/navigation.md and print its numbers about the field.

    python examples/layouts/make_figures.py [FOLDER]

The links and readers are those of compare_links.toml. Bearing errors are those of
the RSS-weighted vector sum at the places of a grid on which the robot fits, in four headings each,
without noise.
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.decibels import power_dbm
from octant.navigation.angles import wrap_angle
from octant.navigation.navigators.arrival import arrival_threshold_w, rss_spread_w
from octant.navigation.sensing.bearing import room_azimuth, vector_sum_bearing
from octant.reader_design.experiments.missions.comparison import (
    ComparisonCell,
    plan_comparison,
)
from octant.reader_design.experiments.missions.comparison_table import load_comparison
from octant.reader_design.setting.samples import standing_room
from octant.reader_design.setting.setting import Setting, build_setting, mission_table
from octant.reader_design.showing.plan import MapPanel, draw_plan, draw_tags, map_figure, plan_of
from octant.reader_design.showing.style import figure_style, new_figure, save_figure
from octant.reader_design.study_file.loading import load_study
from octant.reader_design.study_file.schema import Study

Floats = npt.NDArray[np.float64]

LAYOUTS = Path(__file__).resolve().parent
SPACING_M = 0.1
CLEARANCE_M = 0.15
HEADINGS_RAD = np.radians([90.0, 101.25, 112.5, 123.75])
ARRIVAL_RADIUS_M = 0.2


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """A reader in its room."""

    setting: Setting

    def grid(self) -> tuple[Floats, Floats, npt.NDArray[np.bool_]]:
        """Return x [m], y [m] and where the robot fits, on the floor of the room or of 5 x 5 m."""
        low, high = np.array([0.0, 0.0]), np.array([5.0, 5.0])
        if self.setting.study.room.box_m is not None:
            low, high = self.setting.scene.bounds_m[:, :2]
        axes = [
            np.arange(a + 0.5 * SPACING_M, b, SPACING_M) for a, b in zip(low, high, strict=True)
        ]
        x, y = np.meshgrid(*axes)
        fits = standing_room(
            self.setting.scene,
            np.column_stack([x.ravel(), y.ravel()]),
            reader_z_m=self.setting.reader_z_m,
            clearance_m=CLEARANCE_M,
        )
        return axes[0], axes[1], fits.reshape(x.shape)

    def bearing_errors(self, tag_id: str) -> tuple[Floats, Floats, Floats]:
        """Return x [m], y [m] and (headings, ny, nx) signed errors of the bearing [rad]."""
        x_m, y_m, fits = self.grid()
        x, y = np.meshgrid(x_m, y_m)
        places = np.column_stack([x[fits], y[fits]])
        tag = self.setting.tag(tag_id)
        link = self.setting.link(tag)
        true = np.arctan2(*(np.asarray(tag.point_m) - places).T[::-1])
        rss = link.rss_by_heading_w(places, HEADINGS_RAD)
        bearing = vector_sum_bearing(rss, self.setting.responses[0].azimuths_rad)
        errors = np.full((len(HEADINGS_RAD), *fits.shape), np.nan)
        errors[:, fits] = wrap_angle(room_azimuth(HEADINGS_RAD, bearing) - true[:, None]).T
        return x_m, y_m, errors


def place_of(study: Study) -> Place:
    """Return a study's room and reader."""
    return Place(setting=build_setting(study))


def error_words(errors_rad: Floats) -> str:
    """Return median and 90th percentile of absolute errors in words [deg]."""
    known = np.degrees(np.abs(errors_rad[np.isfinite(errors_rad)]))
    return "median {:.1f}°, 90 % {:.1f}°".format(*np.percentile(known, [50.0, 90.0]))


def bearing_maps(cells: list[ComparisonCell], folder: Path) -> None:
    """Draw the bearing error over the floor for each link, and print the errors of all cells."""
    panels = []
    room = place_of(cells[0].study)
    for cell in cells:
        place = place_of(cell.study)
        tag_ids = mission_table(cell.study).tags
        every = [place.bearing_errors(tag_id)[2] for tag_id in tag_ids]
        words = error_words(np.array(every))
        print(f"{cell.layout} | {cell.link} | {cell.reader} | {words}", flush=True)
        if cell.reader == "thesis reader":
            first = tag_ids[0]
            middle = np.degrees(np.nanmedian(np.abs(every[0]), axis=0))
            tags = {first: place.setting.tag(first).point_m}
            title = f"{cell.link}\nall tags: {words}"
            panels.append(MapPanel(title=title, values=middle, tags=tags))
    figure = map_figure(
        *room.grid()[:2],
        panels,
        plan_of(room.setting.scene, room.setting.reader_z_m),
        title="Bearing error of the vector sum in a concrete room, median of four headings",
        bar_label="absolute bearing error [°]",
        limits=(0.0, 90.0),
        colours="magma_r",
    )
    save_figure(figure, folder / "navigation_bearing_error.png")


def leg_figure(cases: list[tuple[str, Study]], folder: Path) -> None:
    """Draw RSS and the spread that decides arrival along the first leg, past its tag."""
    with figure_style():
        figure, axes = new_figure(
            width_in=9.4,
            height_in=7.2,
            title="RSS along the first leg, heading along it",
            rows=2,
            columns=2,
        )
        for axis, spread_axis, (name, study) in zip(axes[0], axes[1], cases, strict=True):
            place = place_of(study)
            tag = place.setting.tag(mission_table(study).tags[0])
            link = place.setting.link(tag)
            start = np.array(mission_table(study).start_m)
            along = (np.asarray(tag.point_m) - start) / np.linalg.norm(tag.point_m - start)
            s = np.linspace(-1.5, 1.0, 501)
            heading = float(np.arctan2(along[1], along[0]))
            points = np.asarray(tag.point_m) + s[:, None] * along
            rss = link.rss_w(np.column_stack([points, np.full(len(s), heading)]))
            level = power_dbm(rss)
            axis.plot(s, level.max(axis=1), color="#332288", label="strongest antenna")
            axis.plot(s, level.min(axis=1), color="#88ccee", label="weakest antenna")
            axis.set_title(name)
            axis.set_ylabel("RSS [dBm]")
            axis.set_ylim(-90.0, 0.0)
            threshold = arrival_threshold_w(link, tag.point_m, radius_m=ARRIVAL_RADIUS_M)
            spread = rss_spread_w(rss)
            spread_axis.plot(s, power_dbm(spread), color="#332288", label="greatest - least RSS")
            spread_axis.axhline(
                float(power_dbm(np.array(threshold))),
                color="#cc6677",
                linestyle="--",
                label="arrival threshold, at 20 cm",
            )
            spread_axis.set_ylim(-70.0, 0.0)
            spread_axis.set_ylabel("spread [dBm]")
            spread_axis.set_xlabel("way past the tag's point [m]")
            inside = np.abs(s) <= ARRIVAL_RADIUS_M
            outside = np.abs(s) > 2.0 * ARRIVAL_RADIUS_M
            below = spread < threshold
            print(
                f"leg, {name}: threshold {float(power_dbm(np.array(threshold))):.1f} dBm, spread "
                f"within 20 cm {np.median(power_dbm(spread[inside])):.1f} dBm (median), below the "
                f"threshold on {np.mean(below[inside]):.0%} of the way within 20 cm and on "
                f"{np.mean(below[outside]):.0%} farther than 40 cm",
                flush=True,
            )
            for one in (axis, spread_axis):
                one.axvline(0.0, color="#cc3311", linewidth=1.0, linestyle=":")
                one.legend(loc="lower left", fontsize=8)
    save_figure(figure, folder / "navigation_leg.png")


def capture_figure(study: Study, tag_id: str, folder: Path) -> None:
    """Draw where the cabinet's reflection beats the direct ray, and where the bearing points."""
    place = place_of(study)
    x_m, y_m, errors = place.bearing_errors(tag_id)
    tag = place.setting.tag(tag_id)
    x, y = np.meshgrid(x_m, y_m)
    worst = np.degrees(np.nanmedian(np.abs(errors), axis=0))
    toward = np.arctan2(tag.point_m[1] - y, tag.point_m[0] - x) + errors[0]
    plan = plan_of(place.setting.scene, place.setting.reader_z_m)
    with figure_style():
        figure, axes = new_figure(
            width_in=6.8, height_in=5.8, title=f"Bearing near the cabinet, tag {tag_id}"
        )
        axis = axes[0, 0]
        axis.grid(visible=False)
        mesh = axis.pcolormesh(
            x_m, y_m, worst, shading="nearest", cmap="magma_r", vmin=0.0, vmax=180.0
        )
        figure.colorbar(mesh, ax=axis, label="absolute bearing error [°]", shrink=0.9)
        thin = (slice(1, None, 3), slice(1, None, 3))
        axis.quiver(
            x[thin],
            y[thin],
            np.cos(toward[thin]),
            np.sin(toward[thin]),
            scale=34.0,
            width=0.0028,
            color="#117733",
        )
        draw_plan(axis, plan, extra_m=np.array([[x_m[0], y_m[0]], [x_m[-1], y_m[-1]]]))
        draw_tags(axis, {tag_id: tag.point_m})
    save_figure(figure, folder / "navigation_capture.png")
    far = np.hypot(x - tag.point_m[0], y - tag.point_m[1]) > 0.4
    known = np.isfinite(worst) & far
    print(
        f"capture, {study.name}, tag {tag_id}: error above 90° on "
        f"{np.mean(worst[known] > 90.0):.1%} of the floor farther than 40 cm from the tag",
        flush=True,
    )


def main() -> None:
    """Write the figures into the folder given, or docs/figures."""
    given = sys.argv[1:]
    folder = Path(given[0]) if given else LAYOUTS.parents[1] / "docs" / "figures"
    cells = plan_comparison(load_comparison(LAYOUTS / "compare_links.toml"))
    first = [cell for cell in cells if cell.controller == cells[0].controller]
    open_space = load_study(LAYOUTS / "open_space.toml")
    lone = place_of(open_space)
    for tag_id in mission_table(open_space).tags[:1]:
        words = error_words(lone.bearing_errors(tag_id)[2])
        print(f"{open_space.name} | the study's | {words}", flush=True)
    bearing_maps(first, folder)
    concrete = load_study(LAYOUTS / "concrete_room.toml")
    leg_figure([("open space", open_space), ("concrete room", concrete)], folder)
    capture_figure(load_study(LAYOUTS / "open_cabinet.toml"), "0xFFF5", folder)


if __name__ == "__main__":
    main()
