"""The figures of a study's sweep, with the sentence that says what to see in each."""

import math
import textwrap
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna
from octant.reader_design.experiments.study.choice_plots import (
    ParallelAxis,
    ParetoScore,
    parallel_figure,
    pareto_figure,
)
from octant.reader_design.experiments.study.reader_plots import element_pattern_figure
from octant.reader_design.experiments.study.sweep_plots import (
    DistancePanel,
    MatrixColumn,
    rss_distance_figure,
    sweep_matrix_figure,
)
from octant.reader_design.setting.evaluation import Cell
from octant.reader_design.setting.ranking import Candidate, Choice, better_is_more
from octant.reader_design.setting.reasons import criterion_name
from octant.reader_design.showing.style import NamedFigure
from octant.reader_design.study_file.choice import Criterion
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.scores import Scores, score_unit

FloatArray = npt.NDArray[np.float64]

MOST_ROWS = 30
"""Designs that the sweep matrix shows at most [-]."""
PANEL_LETTERS = 32
"""Letters that fit above a panel [-]."""
MOST_PANELS = 12
"""Panels that one figure shows at most [-]."""


def comparison_figures(
    cells: Sequence[Cell], candidates: Sequence[Candidate], choice: Choice
) -> Iterator[NamedFigure]:
    """Yield the sweep's scores: a matrix, and what compares at least two designs ([dB], [deg]).

    Parameters
    ----------
    cells, candidates, choice : All cells, the scored ones, their ranking.
    """
    order = choice.ranking[:MOST_ROWS]
    yield NamedFigure(
        file="sweep_matrix.png",
        section="sweep",
        title="The designs side by side",
        caption="Designs from best to worst with the numbers that decide; dark is good, each "
        "column on its own scale, and the first row is the chosen design"
        + (f" (the best {MOST_ROWS} are shown)." if len(choice.ranking) > MOST_ROWS else "."),
        figure=sweep_matrix_figure(
            [candidates[i].label for i in order],
            _matrix_columns([candidates[i] for i in order]),
            title="The designs, best first",
        ),
    )
    if len(candidates) > 1:
        yield from _comparisons([c for c in cells if c.free is not None], candidates, choice)


def antenna_figures(cells: Sequence[Cell], *, frequency_hz: float) -> Iterator[NamedFigure]:
    """Yield by kind of antenna its pattern and the RSS [dBm] of its designs over distance [m].

    Parameters
    ----------
    cells, frequency_hz : All cells; the carrier [Hz].
    """
    good = [c for c in cells if c.free is not None]
    for kind in dict.fromkeys(c.design.antenna_kind for c in good):
        shown = [c for c in good if c.design.antenna_kind == kind][:MOST_PANELS]
        if shown[0].design.drawn:
            yield _element_figure(kind, shown[0].design.element(frequency_hz))
        yield _distance_figure(kind, shown)


def _comparisons(
    good: Sequence[Cell], candidates: Sequence[Candidate], choice: Choice
) -> Iterator[NamedFigure]:
    """Yield the parallel coordinates and the Pareto plot of at least two designs."""
    rank = np.empty(len(candidates), dtype=np.int64)
    rank[list(choice.ranking)] = np.arange(1, len(candidates) + 1)
    scores = _criterion_scores(candidates, choice)
    axes = [
        *parameter_axes([c.design for c in good]),
        *(ParallelAxis(title=s.title, values=tuple(s.values.tolist())) for s in scores),
    ]
    yield NamedFigure(
        file="sweep_parallel.png",
        section="sweep",
        title="Parameters and scores of all designs",
        caption="Each line is one design, from its swept parameters on the left to the scores that "
        "decide on the right; lines of one colour have similar places in the ranking, so a "
        "parameter that matters sorts the colours.",
        figure=parallel_figure(axes, rank, title=f"The sweep: {len(candidates)} designs"),
    )
    height = ParetoScore(
        title="height [cm]",
        values=100.0 * np.array([c.height_m for c in candidates]),
        maximise=False,
    )
    pairs = [(scores[i], scores[j]) for i, j in _pairs(len(scores))]
    if np.ptp(height.values) > 0.0:
        pairs.append((height, scores[0]))
    if pairs:
        yield NamedFigure(
            file="sweep_pareto.png",
            section="sweep",
            title="What one gains and gives up",
            caption="Each dot is a design; dark ones are dominated by none in all criteria "
            "together, the line joins the best in the panel's two scores, and numbers are places "
            "in the ranking.",
            figure=pareto_figure(
                pairs, np.array(choice.pareto), rank, title="The Pareto front of the sweep"
            ),
        )


def _pairs(count: int) -> list[tuple[int, int]]:
    """Return which criteria are drawn against each other: neighbours in weight, first and last."""
    pairs = [(k, k + 1) for k in range(count - 1)]
    return [*pairs, (0, count - 1)] if count > 2 else pairs


def _criterion_scores(candidates: Sequence[Candidate], choice: Choice) -> list[ParetoScore]:
    """Return the deciding numbers as columns with titles and units."""

    def title(criterion: Criterion) -> tuple[str, float]:
        name = criterion.free or criterion.room
        unit, scale = score_unit(name), 1.0
        if unit == "rad":
            unit, scale = "°", math.degrees(1.0)
        elif name.endswith("_share"):
            unit, scale = "%", 100.0
        elif unit.startswith("W"):
            unit, scale = f"n{unit}", 1e9
        return f"{criterion_name(criterion)} [{unit if unit != '1' else '-'}]", scale

    columns = []
    for k, criterion in enumerate(choice.rules.criteria):
        text, scale = title(criterion)
        values = scale * np.array([choice.merits[i].values[k] for i in range(len(candidates))])
        columns.append(ParetoScore(title=text, values=values, maximise=better_is_more(criterion)))
    return columns


def parameter_axes(designs: Sequence[Reader]) -> list[ParallelAxis]:
    """Return an axis for each parameter in which designs differ, in field order; lengths in [cm].

    Parameters
    ----------
    designs : Any swept designs.
    """
    rows = [design.as_dict() for design in designs]
    axes = []
    for name in rows[0]:
        values = [row[name] for row in rows]
        if all(value == values[0] for value in values):
            continue
        short = {"antenna_radius_m": "r_a", "plate_height_m": "h_p"}.get(name)
        if all(isinstance(v, int | float) for v in values):
            length = name.endswith("_m")
            label = short or (name.removesuffix("_m") if length else name).replace("_", " ")
            unit = " [cm]" if length else " [ohm]" if name.endswith("_ohm") else ""
            numbers = tuple(float(v) * (100.0 if length else 1.0) for v in values)
            axes.append(ParallelAxis(title=label.removesuffix(" ohm") + unit, values=numbers))
        else:
            words = tuple("default" if v is None else str(v) for v in values)
            axes.append(ParallelAxis(title=name.replace("_", " "), values=words))
    return axes


def _element_figure(kind: str, element: Antenna) -> NamedFigure:
    """Return the pattern of one antenna of a kind."""
    cm = f"{100.0 * element.length_m:.3g} cm"
    return NamedFigure(
        file=f"pattern_{kind}.png",
        section="sweep",
        title=f"Pattern of one {kind}",
        caption=f"Gain of one {kind} of {cm} alone at {element.frequency_hz / 1e9:g} GHz: nothing "
        "along its axis, so that a reader right under a tag hears little"
        + (
            "; below its ground plane there is none."
            if kind == "monopole"
            else ", and most at the horizon."
        ),
        figure=element_pattern_figure(element, title=f"Gain of a {kind} of {cm}"),
    )


def _distance_figure(kind: str, shown: Sequence[Cell]) -> NamedFigure:
    """Return the RSS of the designs of one kind of antenna against distance."""
    heights = len({c.design.plate_height_m for c in shown})
    panels = [DistancePanel(title="\n".join(_panel_title(c)), rss_w=c.travel_rss_w) for c in shown]
    readers = f"readers from {kind}" if kind in {"files", "metal"} else f"{kind}s"
    designs = f"designs from {kind}" if kind in {"files", "metal"} else f"{kind} designs"
    return NamedFigure(
        file=f"rss_distance_{kind}.png",
        section="sweep",
        title=f"RSS against distance, {readers}",
        caption="What each antenna receives in free space while the robot moves away from the "
        "point under the tag with antenna 1 facing the tag; a good design keeps antenna 1 on top "
        "and the curves apart.",
        figure=rss_distance_figure(
            shown[0].travel_m,
            panels,
            columns=min(heights if heights > 1 else 3, len(shown), 4),
            title=f"RSS of the {designs}, antenna 1 towards the tag",
        ),
    )


def _panel_title(cell: Cell) -> Iterator[str]:
    """Yield the lines that tell a cell from others of its antenna, lengths in cm."""
    design = cell.design
    height = f", h_p = {100 * design.plate_height_m:.4g} cm" if design.drawn else ""
    yield f"r_a = {100 * design.antenna_radius_m:.4g} cm{height}"
    yield from textwrap.wrap(cell.label.removeprefix(design.label()).strip(), PANEL_LETTERS)


def _matrix_columns(rows: Sequence[Candidate]) -> list[MatrixColumn]:
    """Return the columns of the sweep matrix: the deciding scores, in free space and the room."""
    table: tuple[tuple[str, str, float, str, str], ...] = (
        ("right_share", "right antenna\n{} [%]", 100.0, "{:.0f}", "high"),
        ("vector_rms_rad", "vector sum\n{} rms [°]", math.degrees(1.0), "{:.1f}", "low"),
        ("vector_beyond_90_share", "beyond 90°\n{} [%]", 100.0, "{:.0f}", "low"),
        ("margin_mean_db", "mean margin\n{} [dB]", 1.0, "{:+.1f}", "high"),
        ("front_to_back_mean_db", "front-to-back\n{} [dB]", 1.0, "{:+.1f}", "high"),
        ("level_median_dbm", "median level\n{} [dBm]", 1.0, "{:.0f}", "high"),
    )
    columns = []
    for name, heading, scale, text, better in table:
        for place in ("free", "room"):
            scores: list[Scores | None] = [getattr(row, place) for row in rows]
            known = [s for s in scores if s is not None]
            if len(known) == len(scores):
                values = scale * np.array([getattr(s, name) for s in known])
                title = heading.format(place)
                columns.append(MatrixColumn(title=title, values=values, text=text, better=better))
    return columns
