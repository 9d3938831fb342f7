"""The room of a draft from above, where a mesh is too dense for a view of every face."""

from typing import TYPE_CHECKING

import numpy as np

from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.plan import draw_plan, draw_tags, plan_of, plan_shape
from octant.reader_design.showing.style import figure_style, math_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_DRAWN = 5000
"""Triangles of a room that is drawn in three dimensions [-]; with more it is drawn from above."""
_WIDTH_IN = 8.0


def plan_picture(setting: Setting) -> "Figure":
    """Return the room's plan with tags and start, axes in [m].

    Parameters
    ----------
    setting : A study with a mission, and its room.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    plan = plan_of(setting.scene, setting.reader_z_m)
    tags = {tag.id: tag.position_m[:2] for tag in setting.tags}
    x, y = setting.mission.start_m
    places = np.array([(x, y), *tags.values()])
    shape = plan_shape(plan, places[:, 0], places[:, 1])
    with figure_style():
        figure = Figure(figsize=(_WIDTH_IN, 1.0 + _WIDTH_IN * shape), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        draw_plan(axes, plan, extra_m=places)
        draw_tags(axes, tags)
        axes.plot(x, y, "o", color="#444444", markersize=7, label="start")
        axes.set_title(math_text(f"{setting.study.name}, cut at the reader's height"))
        axes.legend(loc="upper right")
    return figure
