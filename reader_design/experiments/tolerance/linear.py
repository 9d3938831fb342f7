"""Readers as built, to first order in their ports: many draws of errors from one solution."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.geometries.build_errors import BuildErrors, common_errors, tilt_of_lean
from octant.reader_design.experiments.tolerance.cases import (
    LEFT_OUT,
    CaseScores,
    ToleranceContext,
    scores_of,
)
from octant.reader_design.experiments.tolerance.draws import drawn_deviation
from octant.reader_design.experiments.tolerance.views import View
from octant.reader_design.keeping.keeper import RecordCodec, map_cases
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.tangents import BuildStep, built_readers
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.tolerance import Tolerance

FloatArray = npt.NDArray[np.float64]

DRAWS = 100
"""Readers of a linear estimate [-]."""

STEPS = {
    "radial_m": 1e-6,
    "azimuth_rad": 1e-5,
    "gap_m": 1e-6,
    "length_m": 1e-6,
    "plate_azimuth_rad": 1e-5,
    "plate_height_m": 1e-6,
}
"""Errors of single antennas and plates, and half of the differences of their derivatives ([m],
[rad]); leans of either direction, and the ground plane, follow."""

LEAN, PLANE_M = 2e-5, 1e-6
"""The same of leans [-] and of the ground plane [m]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LinearCase:
    """A drawing, and the errors of readers that are estimated.

    Attributes
    ----------
    design : The drawing.
    amounts : (d, k) float64 — A row of :func:`amounts_of` for each reader ([m], [rad], [-]).
    """

    design: Reader
    amounts: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearScores:
    """What came out.

    Attributes
    ----------
    readers : Scores of each reader.
    """

    readers: tuple[CaseScores, ...]


def single_steps(antennas: int) -> tuple[BuildStep, ...]:
    """Return a step for each error of each antenna and plate, in the order of `amounts_of`.

    Parameters
    ----------
    antennas : Number of antennas.
    """
    none = common_errors(antennas)

    def built(name: str, i: int, amount: float) -> BuildErrors:
        if name.startswith("lean"):
            lean = np.zeros((antennas, 2))
            lean[i, int(name[-1])] = amount
            tilt, towards = tilt_of_lean(lean)
            return replace(none, tilt_rad=tilt, tilt_azimuth_rad=towards)
        return replace(none, **{name: amount * (np.arange(antennas) == i)})

    sizes = {**STEPS, "lean 0": LEAN, "lean 1": LEAN}
    steps = [
        BuildStep(before=built(name, i, -size), after=built(name, i, size), step=size)
        for name, size in sizes.items()
        for i in range(antennas)
    ]
    ends = (replace(none, ground_plane_m=sign * PLANE_M) for sign in (-1.0, 1.0))
    return (*steps, BuildStep(before=next(ends), after=next(ends), step=PLANE_M))


def amounts_of(errors: BuildErrors) -> FloatArray:
    """Return (k,) how far along each of `single_steps` a built reader is ([m], [rad], [-]).

    Parameters
    ----------
    errors : Of the reader.
    """
    parts = [getattr(errors, name) for name in STEPS]
    return np.concatenate((*parts, errors.lean.T.ravel(), [errors.ground_plane_m]))


def linear_scores(context: ToleranceContext, case: LinearCase) -> LinearScores:
    """Return the scores of readers along the tangent: one solution, whatever their number.

    Parameters
    ----------
    context, case : What all cases share; the drawing and the errors.
    """
    steps = single_steps(case.design.antennas)
    found = built_readers(case.design, context.study.radio, steps, case.amounts)
    return LinearScores(readers=tuple(scores_of(context, responses) for responses in found))


def linear_estimate(
    context: ToleranceContext,
    design: Reader,
    tolerance: Tolerance,
    shown: tuple[View, ...],
    *,
    folder: Path,
    progress: Progress | None = None,
) -> FloatArray | None:
    """Return (d, v) the scores of readers whose ports are linear in their errors [views' units].

    The first have the errors of the readers that are built. Scores follow from the ports without
    further approximation, so that the worst of several directions may change; what is left out is
    of second order in the ports. NaN for scores in the room, None where the drawing cannot be
    moved. Errors of frequency and materials are left out.

    Parameters
    ----------
    context, design : What all cases share; the drawing.
    tolerance : How errors are drawn.
    shown : Scores.
    folder : Where the cases' files lie.
    progress : Shows files that cannot be used.
    """
    amounts = [
        amounts_of(
            drawn_deviation(
                tolerance,
                antennas=design.antennas,
                antenna_radius_m=design.antenna_radius_m,
                seed=context.study.seed,
                index=index,
            ).build
        )
        for index in range(DRAWS)
    ]
    (kept,) = map_cases(
        linear_scores,
        (LinearCase(design=design, amounts=np.array(amounts)),),
        context=replace(context, room=False),
        folder=folder,
        codec=RecordCodec(LinearScores),
        leave_out=LEFT_OUT,
        progress=progress,
        label="linear estimate",
    )
    if kept.reason:
        return None
    rows = [
        [np.nan if view.where == "room" else view.of(case) for view in shown]
        for case in kept.value.readers
    ]
    return np.array(rows)
