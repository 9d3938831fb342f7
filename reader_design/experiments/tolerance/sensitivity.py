"""How scores change with errors that all antennas share: differences around the drawing.

They are those of readers that are solved, or of one solution's tangent.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.geometries.build_errors import BuildErrors, common_errors
from octant.reader_design.experiments.tolerance.cases import (
    LEFT_OUT,
    Case,
    CaseScores,
    ToleranceContext,
    scores_of,
)
from octant.reader_design.experiments.tolerance.draws import Deviation, as_drawn
from octant.reader_design.experiments.tolerance.views import View, values_of
from octant.reader_design.keeping.keeper import RecordCodec, map_cases
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.tangents import BuildStep, built_along
from octant.reader_design.study_file.reader import Reader

FloatArray = npt.NDArray[np.float64]

STEPS = 4
"""Readers that are solved for the slopes against one parameter [-]."""

PARTS = (-1.0, 1.0, -0.5, 0.5)
"""Steps at which each parameter is probed [its step]."""

MOVED = 1e-3
"""Half of the difference over which derivatives by a parameter are taken [mm, deg]."""

SAME_SLOPE = 0.05
"""Share [-] of the steeper slope by which slopes of two steps may differ and count as one."""

SMALL = 1e-3
"""Change of a score [dB or deg] that is too small to matter."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """One way in which all antennas or plates can be off.

    Attributes
    ----------
    name : Name for people.
    field : Argument of :func:`octant.geometries.build_errors.common_errors`.
    unit, per_unit : Unit of slopes' denominators, ``mm`` or ``°``; the same in [m] or [rad].
    step : Step of the differences [unit].
    towards_rad : Where antennas lean, for a tilt [rad].
    """

    name: str
    field: str
    unit: str
    per_unit: float
    step: float
    towards_rad: float = 0.0

    def errors(self, antennas: int, amount: float) -> BuildErrors:
        """Return the errors of an amount, the same for all antennas.

        Parameters
        ----------
        antennas, amount : Number of antennas; amount [unit], of either sign.
        """
        value = amount * self.per_unit
        given = {self.field: value}
        if self.field == "tilt_rad":
            behind = np.pi if value < 0.0 else 0.0
            given = {"tilt_rad": abs(value), "tilt_azimuth_rad": self.towards_rad + behind}
        return common_errors(antennas, **given)


_MM, _DEG = 1e-3, np.pi / 180.0

PARAMETERS = (
    Parameter(name="r_a", field="radial_m", unit="mm", per_unit=_MM, step=0.2),
    Parameter(name="gap", field="gap_m", unit="mm", per_unit=_MM, step=0.2),
    Parameter(name="antenna length", field="length_m", unit="mm", per_unit=_MM, step=0.2),
    Parameter(name="h_p", field="plate_height_m", unit="mm", per_unit=_MM, step=0.2),
    Parameter(name="ground plane", field="ground_plane_m", unit="mm", per_unit=_MM, step=0.2),
    Parameter(name="antennas' azimuth", field="azimuth_rad", unit="°", per_unit=_DEG, step=0.4),
    Parameter(name="lean outwards", field="tilt_rad", unit="°", per_unit=_DEG, step=0.4),
    Parameter(
        name="lean sideways",
        field="tilt_rad",
        unit="°",
        per_unit=_DEG,
        step=0.4,
        towards_rad=0.5 * np.pi,
    ),
)
"""What is varied; the azimuth is that of the antennas against plates and ground plane."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Slope:
    """How fast one score changes with one parameter.

    Attributes
    ----------
    parameter, score : Names of the parameter and the view.
    unit : Unit of the slopes, e.g. ``dB/mm``.
    up, down : Slope for more, and for less, of the parameter [unit].
    central : Central difference of the smaller step [unit].
    doubt : Difference of the central slopes of both steps [unit].
    bends : True when ``up`` and ``down`` differ by more than curvature explains, as where the worst
        of several directions changes: the central slope then says little.
    """

    parameter: str
    score: str
    unit: str
    up: float
    down: float
    central: float
    doubt: float
    bends: bool


def parameters_of(design: Reader) -> tuple[Parameter, ...]:
    """Return the parameters that a design has.

    Parameters
    ----------
    design : Without plates it has no h_p; a monopole joined to the ground plane no gap.
    """
    plates = max(design.plate_height_m, design.plate_height_axis_m or 0.0) > 0.0
    joined = design.antenna == "monopole" and design.monopole_plane_m == 0.0
    absent = {"plate_height_m"} if not plates else set()
    absent |= {"gap_m"} if joined else set()
    return tuple(p for p in PARAMETERS if p.field not in absent)


def sensitivity_cases(design: Reader, parameters: tuple[Parameter, ...]) -> tuple[Case, ...]:
    """Return the drawing, then four cases a parameter: -h, +h, -h/2, +h/2.

    Parameters
    ----------
    design, parameters : The drawing, and what to vary.
    """
    count = design.antennas
    cases = [Case(design=design, deviation=as_drawn(count))]
    for parameter in parameters:
        for part in PARTS:
            errors = parameter.errors(count, part * parameter.step)
            cases.append(Case(design=design, deviation=Deviation(build=errors)))
    return tuple(cases)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TangentCase:
    """A drawing whose scores are wanted along its tangents.

    Attributes
    ----------
    design, parameters : The drawing, and what to vary.
    """

    design: Reader
    parameters: tuple[Parameter, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class TangentScores:
    """What came out, in the order of :func:`sensitivity_cases`.

    Attributes
    ----------
    around : Scores of the drawing and to its sides.
    """

    around: tuple[CaseScores, ...]


def tangent_scores(context: ToleranceContext, case: TangentCase) -> TangentScores:
    """Return the scores of a drawing and to its sides: one solution, whatever the parameters.

    The steps along the tangent are those of whole solutions, so that a bend beside the drawing,
    where the worst of several directions changes, is seen as it is by those.

    Parameters
    ----------
    context, case : What all cases share; the drawing and what to vary.
    """
    count, parameters = case.design.antennas, case.parameters
    steps = [
        BuildStep(
            before=parameter.errors(count, -MOVED),
            after=parameter.errors(count, MOVED),
            step=MOVED,
        )
        for parameter in parameters
    ]
    amounts = [tuple(part * parameter.step for part in PARTS) for parameter in parameters]
    amounts[0] = (0.0, *amounts[0])
    found = built_along(case.design, context.study.radio, steps, amounts)
    return TangentScores(
        around=tuple(scores_of(context, responses) for one in found for responses in one)
    )


def kept_tangent_scores(
    context: ToleranceContext, case: TangentCase, folder: Path, *, progress: Progress | None = None
) -> tuple[CaseScores, ...]:
    """Return the scores of `tangent_scores`, read from their file or computed and kept.

    Parameters
    ----------
    context, case : What all cases share; the drawing and what to vary.
    folder : Where the cases' files lie.
    progress : Shows files that cannot be used.
    """
    (kept,) = map_cases(
        tangent_scores,
        (case,),
        context=context,
        folder=folder,
        codec=RecordCodec(TangentScores),
        leave_out=LEFT_OUT,
        progress=progress,
        label="derivatives",
    )
    if kept.reason:
        return (CaseScores(reason=kept.reason),) * (1 + STEPS * len(case.parameters))
    found: TangentScores = kept.value
    return found.around


def slopes(
    parameters: tuple[Parameter, ...], shown: tuple[View, ...], results: tuple[CaseScores, ...]
) -> tuple[Slope, ...]:
    """Return the slopes of all scores, parameter by parameter; NaN where a case cannot be built.

    Parameters
    ----------
    parameters : What was varied.
    shown : Scores; shares are left out, as they change in steps.
    results : Of :func:`sensitivity_cases`, in their order, or of the tangent.
    """
    views = tuple(view for view in shown if not view.name.endswith("share"))
    table = values_of(views, results)
    out = []
    for p, parameter in enumerate(parameters):
        low, high, near_low, near_high = table[1 + STEPS * p : 1 + STEPS * (p + 1)]
        for v, view in enumerate(views):
            out.append(
                _slope(
                    parameter,
                    view,
                    (low[v], near_low[v], table[0, v], near_high[v], high[v]),
                )
            )
    return tuple(out)


def _slope(parameter: Parameter, view: View, five: tuple[float, ...]) -> Slope:
    """Return the slopes through a score at -h, -h/2, 0, h/2 and h."""
    low, near_low, middle, near_high, high = five
    step = parameter.step
    wide, central = (high - low) / (2.0 * step), (near_high - near_low) / step
    up, down = (near_high - middle) / (0.5 * step), (middle - near_low) / (0.5 * step)
    # A smooth score's one-sided slopes draw together with the step; those of a bend do not.
    gap = abs(up - down)
    wide_gap = abs((high - middle) - (middle - low)) / step
    steepest = max(abs(up), abs(down))
    bends = gap * step > SMALL and gap > SAME_SLOPE * steepest and gap > 0.75 * wide_gap
    return Slope(
        parameter=parameter.name,
        score=view.name,
        unit=f"{view.change_unit}/{parameter.unit}",
        up=float(up),
        down=float(down),
        central=float(central),
        doubt=float(abs(wide - central)),
        bends=bool(bends),
    )
