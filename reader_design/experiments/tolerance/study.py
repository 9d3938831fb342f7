"""A tolerance study from end to end: nominal design, samples, sensitivities, rivals."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.navigation.statistics import Interval, quantiles, wilson
from octant.reader_design.experiments.tolerance.cases import (
    Case,
    CaseScores,
    ToleranceContext,
    built_responses,
    run_cases,
)
from octant.reader_design.experiments.tolerance.draws import (
    Deviation,
    as_drawn,
    drawn_deviation,
    regressors,
)
from octant.reader_design.experiments.tolerance.linear import linear_estimate
from octant.reader_design.experiments.tolerance.ranking import RoomRss, wins, wins_over_places
from octant.reader_design.experiments.tolerance.sensitivity import (
    STEPS,
    Parameter,
    Slope,
    TangentCase,
    kept_tangent_scores,
    parameters_of,
    sensitivity_cases,
    slopes,
)
from octant.reader_design.experiments.tolerance.statistics import Explained, explained_variance
from octant.reader_design.experiments.tolerance.views import View, meets, values_of, views
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.design import FULLWAVE
from octant.reader_design.setting.evaluation import room_samples_w
from octant.reader_design.setting.samples import grid_azimuths_rad
from octant.reader_design.setting.setting import Sampling, build_setting
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.schema import Study
from octant.reader_design.study_file.tolerance import Rival, Tolerance

FloatArray = npt.NDArray[np.float64]

PROBABILITIES = (0.5, 0.05, 0.95)
"""Quantiles that a study gives of every score [-]."""

DERIVATIVES = "derivatives"
"""How slopes come without solving more readers than the drawing [-]."""

PLACE_RESAMPLES = 200
"""Resamples of the room's places [-]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BuiltDesign:
    """A design and what becomes of it when it is built many times.

    Attributes
    ----------
    name, design : Name in the results, and the drawing.
    nominal, samples : Scores of the drawing, and of the built readers.
    values : (s, v) float64 — Scores shown, a row a sample [units of the views].
    spreads : Median, 5 % and 95 % quantile of every score [units of the views].
    good, drawn_is_good : Share of readers that meet the limits; whether the drawing itself does.
    """

    name: str
    design: Reader
    nominal: CaseScores
    samples: tuple[CaseScores, ...]
    values: FloatArray
    spreads: tuple[tuple[Interval, ...], ...]
    good: Interval
    drawn_is_good: bool

    @property
    def not_built(self) -> int:
        """Number of samples that cannot be built."""
        return sum(1 for case in self.samples if case.reason)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ToleranceStudy:
    """The whole result.

    Attributes
    ----------
    study, tolerance : What was asked for; its table, or the defaults.
    shown : Scores, in the order of the columns of every ``values``.
    chosen, rivals : The study's reader; the other designs, built with the same errors.
    deviations : The samples' errors, as the chosen design has them.
    parameters, slopes : Slopes around the drawing of the chosen design, and what they are against.
    explained : For every score; None where nothing varies or samples are too few.
    confidence : Share of built readers in which the chosen design beats each rival.
    confidence_places : The same over resampled places of the room; empty without a room.
    linear : (d, v) float64 — Scores of readers with ports to first order, a row a draw of errors
        [units of the views], NaN in the room; None without derivatives.
    """

    study: Study
    tolerance: Tolerance
    shown: tuple[View, ...]
    chosen: BuiltDesign
    rivals: tuple[BuiltDesign, ...]
    deviations: tuple[Deviation, ...]
    parameters: tuple[Parameter, ...]
    slopes: tuple[Slope, ...]
    explained: tuple[Explained | None, ...]
    confidence: tuple[Interval, ...]
    confidence_places: tuple[Interval, ...]
    linear: FloatArray | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Planned:
    """How many readers a tolerance study solves.

    Parameters
    ----------
    drawings, slopes, built : As drawn; with one error that all antennas share; with drawn errors.
    designs, samples : Number of designs, and readers of each that are built with errors.
    """

    drawings: int
    slopes: int
    designs: int
    samples: int

    @property
    def built(self) -> int:
        """Readers that are built with errors."""
        return self.designs * self.samples

    @property
    def readers(self) -> int:
        """All of them."""
        return self.drawings + self.slopes + self.built

    def text(self) -> str:
        """Return it in words."""
        drawn = "1 drawing" if self.drawings == 1 else f"{self.drawings} drawings"
        around = "it" if self.drawings == 1 else "the first"
        of_each = "" if self.designs == 1 else f" of each of {self.designs} designs"
        return (
            f"{self.readers} readers are solved: {drawn}, {self.slopes} for the slopes around "
            f"{around}, {self.samples}{of_each} built with errors"
        )


def planned(study: Study, *, samples: int | None = None, rivals: int = 0) -> Planned:
    """Return how many readers `run_tolerance_study` solves.

    Parameters
    ----------
    study, samples, rivals : As there; number of rivals besides those of the study.
    """
    tolerance = study.tolerance or Tolerance()
    designs = 1 + len(tolerance.rivals) + rivals
    return Planned(
        drawings=designs,
        slopes=2 if tolerance.slopes == DERIVATIVES else STEPS * len(parameters_of(study.reader)),
        designs=designs,
        samples=samples or tolerance.samples,
    )


def run_tolerance_study(
    study: Study,
    folder: Path,
    *,
    rivals: Sequence[tuple[str, Reader]] = (),
    samples: int | None = None,
    workers: int | None = 1,
    cluster: str | None = None,
    sampling: Sampling | None = None,
    progress: Progress | None = None,
) -> ToleranceStudy:
    """Return what tolerances do to a study's reader and its rivals; resumes from a folder.

    The same bits at any number of workers. Refuses models other than ``fullwave``, a study without
    a tag, and designs that cannot be built even as drawn.

    Parameters
    ----------
    study : Reader, tag, room, ``[tolerance]``.
    folder : Where the cases' files lie; made when missing.
    rivals : Names and designs to compare with besides those of the study.
    samples : Readers built; None: the study's.
    workers : Processes; None: one for each core.
    cluster : Address of a dask scheduler, or ``local:N``, in place of ``workers``.
    sampling : How densely designs are probed; default: that of Sampling.
    progress : Shows cases.
    """
    tolerance = study.tolerance or Tolerance()
    _refuse_other_models(study)
    count = samples or tolerance.samples
    setting = build_setting(study, sampling=sampling)
    context = ToleranceContext(
        setting=setting,
        distances_m=tolerance.distances_m,
        room=tolerance.room,
        reference=setting.reference_tag.id,
    )
    designs = [("the study's reader", study.reader)]
    designs += [(rival.name, _rival_design(study, rival)) for rival in tolerance.rivals]
    designs += rivals
    drawing = designs[0][1]
    parameters = parameters_of(drawing)
    if tolerance.slopes == DERIVATIVES:
        cases = [Case(design=drawing, deviation=as_drawn(drawing.antennas))]
    else:
        cases = list(sensitivity_cases(drawing, parameters))
    around = len(cases)
    cases += [Case(design=d, deviation=as_drawn(d.antennas)) for _, d in designs[1:]]
    first_sample = len(cases)
    for _, design in designs:
        cases += [
            Case(
                design=design,
                deviation=drawn_deviation(
                    tolerance,
                    antennas=design.antennas,
                    antenna_radius_m=design.antenna_radius_m,
                    seed=study.seed,
                    index=index,
                ),
            )
            for index in range(count)
        ]
    results = run_cases(context, cases, folder, workers=workers, cluster=cluster, progress=progress)
    nominal = (results[0], *results[around:first_sample])
    for (name, _), case in zip(designs, nominal, strict=True):
        _refuse_unbuilt(name, case)
    shown = views(tolerance.distances_m, room=tolerance.room)
    built = [
        _built(
            name,
            design,
            nominal[i],
            results[first_sample + i * count : first_sample + (i + 1) * count],
            shown=shown,
            tolerance=tolerance,
            seed=study.seed,
        )
        for i, (name, design) in enumerate(designs)
    ]
    deviations = [case.deviation for case in cases[first_sample : first_sample + count]]
    beside = results[:around]
    if tolerance.slopes == DERIVATIVES:
        tangent = TangentCase(design=drawing, parameters=parameters)
        beside = kept_tangent_scores(context, tangent, folder, progress=progress)
    found = slopes(parameters, shown, beside)
    linear = None
    if tolerance.slopes == DERIVATIVES:
        linear = linear_estimate(
            context, drawing, tolerance, shown, folder=folder, progress=progress
        )
    return ToleranceStudy(
        study=study,
        tolerance=msgspec.structs.replace(tolerance, samples=count),
        shown=shown,
        chosen=built[0],
        rivals=tuple(built[1:]),
        deviations=tuple(deviations),
        parameters=parameters,
        slopes=found,
        linear=linear,
        explained=_explained(built[0], deviations),
        confidence=tuple(wins(built[0].samples, rival.samples) for rival in built[1:]),
        confidence_places=_over_places(context, built) if tolerance.room else (),
    )


def _refuse_other_models(study: Study) -> None:
    if study.reader.response != FULLWAVE:
        msg = (
            f"reader.response is {study.reader.response!r}, but only 'fullwave' knows build "
            'errors; set reader.response = "fullwave".'
        )
        raise ConfigError(msg)


def _refuse_unbuilt(name: str, case: CaseScores) -> None:
    if case.reason:
        msg = f"{name} cannot be built even without errors: {case.reason}"
        raise ConfigError(msg)


def _rival_design(study: Study, rival: Rival) -> Reader:
    changes = {
        name: value
        for name in Rival.__struct_fields__
        if name != "name" and (value := getattr(rival, name)) is not None
    }
    return msgspec.structs.replace(study.reader, **changes)


def _built(
    name: str,
    design: Reader,
    nominal: CaseScores,
    samples: tuple[CaseScores, ...],
    *,
    shown: tuple[View, ...],
    tolerance: Tolerance,
    seed: int,
) -> BuiltDesign:
    values = values_of(shown, samples)
    there = ~np.isnan(values).any(axis=1)
    if not there.any():
        msg = (
            f"none of {len(samples)} readers of {name} can be built with these tolerances: "
            f"{samples[0].reason} Give smaller ones."
        )
        raise ConfigError(msg)
    random = np.random.default_rng([seed, len(samples)])
    return BuiltDesign(
        name=name,
        design=design,
        nominal=nominal,
        samples=samples,
        values=values,
        spreads=tuple(quantiles(column, PROBABILITIES, random) for column in values[there].T),
        good=wilson(sum(meets(tolerance.limits, case) for case in samples), len(samples)),
        drawn_is_good=meets(tolerance.limits, nominal),
    )


def _explained(chosen: BuiltDesign, deviations: list[Deviation]) -> tuple[Explained | None, ...]:
    """Return the explained variance of every score, over the readers that can be built."""
    there = ~np.isnan(chosen.values).any(axis=1)
    kept = [deviations[i] for i in np.flatnonzero(there)]
    names, columns = regressors(kept, chosen.design.antenna_radius_m)
    return tuple(explained_variance(names, columns, values) for values in chosen.values[there].T)


def _over_places(context: ToleranceContext, built: list[BuiltDesign]) -> tuple[Interval, ...]:
    """Return the confidence over places of the room of the chosen design against each rival."""
    probed = []
    for one in built if len(built) > 1 else []:
        case = Case(design=one.design, deviation=as_drawn(one.design.antennas))
        setting = context.setting.with_responses(built_responses(context.study, case))
        elements = np.asarray(setting.responses[0].azimuths_rad, dtype=np.float64)
        azimuths = grid_azimuths_rad(elements.size, setting.sampling.room_azimuths)
        rss = room_samples_w(setting, azimuths)
        probed.append(
            (one.nominal, RoomRss(rss_w=rss, azimuths_rad=azimuths, element_azimuths_rad=elements))
        )
    random = np.random.default_rng([context.study.seed, PLACE_RESAMPLES])
    return tuple(
        wins_over_places(probed[0], other, random=random, resamples=PLACE_RESAMPLES)
        for other in probed[1:]
    )
