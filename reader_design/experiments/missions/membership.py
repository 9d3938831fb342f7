"""The fuzzy controller as a figure: its membership functions, and what they come to."""

from typing import TYPE_CHECKING

import numpy as np

from octant.navigation.control.fuzzy import FuzzyVariable, RuleBase
from octant.reader_design.showing.style import ANTENNA_COLOURS, figure_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def membership_figure(rules: RuleBase, *, title: str) -> "Figure":
    """Return the terms of the input, of a wheel's speed, and the controller's two outputs.

    Parameters
    ----------
    rules : RuleBase
        One input, two outputs: right and left wheel.
    title : str
        Above the figure.
    """
    with figure_style():
        figure, axes = new_figure(columns=3, width_in=11.0, height_in=3.6, title=title)
        first, second, third = axes.ravel()
        _draw_terms(first, rules.input_variable, "steering input, right minus left [-]")
        _draw_terms(second, rules.outputs[0], "wheel speed, 0.5 = cruise [-]")
        low, high = rules.input_variable.low, rules.input_variable.high
        x = np.linspace(low, high, 401)
        speeds = rules.infer(x)
        third.plot(x, speeds[:, 0], color=ANTENNA_COLOURS[0], label="right wheel")
        third.plot(x, speeds[:, 1], color=ANTENNA_COLOURS[4], linestyle="--", label="left wheel")
        third.set_xlabel("steering input, right minus left [-]")
        third.set_ylabel("wheel speed, 0.5 = cruise [-]")
        third.set_ylim(0.0, 1.0)
        third.legend()
    return figure


def _draw_terms(axes: "Axes", variable: FuzzyVariable, label: str) -> None:
    x = np.linspace(variable.low, variable.high, 801)
    for number, term in enumerate(variable.terms):
        axes.plot(x, term.membership(x), color=ANTENNA_COLOURS[number % 8], label=term.name)
    axes.set_xlabel(label)
    axes.set_ylabel("membership [-]")
    axes.set_ylim(0.0, 1.15)
    axes.legend(ncols=len(variable.terms), loc="upper center", fontsize=7, handlelength=1.0)
