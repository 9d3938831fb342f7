"""A search for a reader by an objective of one's own."""

import math
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from octant.geometries.errors import ConfigError, SweepStateError
from octant.reader_design.experiments.optimise.evaluation import Evaluation
from octant.reader_design.experiments.optimise.search import Search, search
from octant.reader_design.face.reader import Reader
from octant.reader_design.face.room import Room, link_study
from octant.reader_design.face.shown import progress_of, text_html
from octant.reader_design.face.study import Study
from octant.reader_design.face.sweep import code_of
from octant.reader_design.face.tables import Tag
from octant.reader_design.keeping.keeper import Kept, RecordCodec, map_cases
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.showing.netcdf import variable
from octant.reader_design.study_file.loading import vary
from octant.reader_design.study_file.reader import Reader as ReaderTable
from octant.reader_design.study_file.schema import Study as StudyTables
from octant.reader_design.study_file.sweep import parameter_unit

if TYPE_CHECKING:
    import xarray as xr

Objective = Callable[[Study], float]
Method = Literal["nelder-mead", "cobyqa", "differential-evolution"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Judge:
    """The functions that judge designs, with the study that is varied.

    Parameters
    ----------
    study : What is varied.
    objective, subject_to : What is to be small; what must not be negative [-].
    code : What the functions compute: results are found again only while it is the same.
    """

    study: StudyTables
    objective: Objective
    subject_to: tuple[Objective, ...]
    code: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """What the functions returned for one design.

    Parameters
    ----------
    objective, constraints : In the functions' own units [-]; the objective is NaN where a
        constraint is missed, since it was not asked for then.
    """

    objective: float
    constraints: tuple[float, ...]


def judged_case(judge: Judge, values: dict[str, Any]) -> Verdict:
    """Return the verdict on one design.

    Parameters
    ----------
    judge, values : What judges it, and its keys of ``[reader]`` [m], [ohm].
    """
    study = Study.of(vary(judge.study, {f"reader.{name}": v for name, v in values.items()}))
    constraints = tuple(float(function(study)) for function in judge.subject_to)
    held = all(value >= 0.0 for value in constraints)
    return Verdict(
        objective=float(judge.objective(study)) if held else math.nan, constraints=constraints
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class JudgedDesign(Evaluation):
    """A design with the verdict of functions of one's own in place of Octant's scores.

    Parameters
    ----------
    objective, constraints : As in `Verdict` [-].
    """

    objective: float = math.nan
    constraints: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Optimised:
    """What a search found.

    Parameters
    ----------
    study, names, found : What was varied, in which keys of ``[reader]``, and every trial.
    """

    study: StudyTables
    names: tuple[str, ...]
    found: Search

    @property
    def reader(self) -> Reader:
        """The best design."""
        return Reader.of(self.found.winner.evaluation.design)

    @property
    def objective(self) -> float:
        """Its objective, in the function's own unit."""
        return _judged(self.found.winner.evaluation).objective

    @property
    def data(self) -> "xr.Dataset":
        """Every design in order: keys of ``[reader]``, objective and constraints."""
        import xarray as xr

        tried = [_judged(trial.evaluation) for trial in self.found.trials]
        data = {
            name: variable(
                ["trial"],
                [_plain(getattr(one.design, name)) for one in tried],
                units=parameter_unit(name) or "1",
                long_name=f"varied: {name}",
                missing="the default of other keys",
            )
            for name in self.names
        }
        data["objective"] = variable(
            ["trial"],
            [one.objective for one in tried],
            units="1",
            long_name="objective",
            missing="infeasible",
        )
        count = max((len(one.constraints) for one in tried), default=0)
        for i in range(count):
            values = [one.constraints[i] if one.constraints else math.nan for one in tried]
            data[f"constraint_{i + 1}"] = variable(
                ["trial"],
                values,
                units="1",
                long_name="kept where it is not negative",
                missing="no score",
            )
        for name, texts in (
            ("stage", [trial.stage for trial in self.found.trials]),
            ("infeasible_because", [one.reason for one in tried]),
        ):
            data[name] = variable(["trial"], texts, units="1", long_name=name.replace("_", " "))
        numbers = variable(["trial"], np.arange(len(tried)), units="1", long_name="trial")
        return xr.Dataset(data, coords={"trial": numbers})

    def __repr__(self) -> str:
        design = self.found.winner.evaluation.design
        keys = ", ".join(f"{name} = {getattr(design, name)}" for name in self.names)
        return f"<Optimised: {self.objective:.6g} after {len(self.found.trials)} designs, {keys}>"

    def _repr_html_(self) -> str:
        return text_html(repr(self))


def optimise(
    reader: Reader,
    parameters: Mapping[str, Sequence[float]],
    *,
    objective: Objective,
    subject_to: Sequence[Objective] = (),
    choices: Mapping[str, Sequence[Any]] | None = None,
    room: Room | None = None,
    tags: Sequence[Tag] = (),
    survey: int = 8,
    budget: int = 60,
    method: Method = "nelder-mead",
    seed: int = 1,
    store: str | Path | None = None,
    frequency_hz: float = 2.4e9,
    channels_hz: Sequence[float] = (),
    solver: Mapping[str, Any] | None = None,
    tables: Mapping[str, Any] | None = None,
    workers: int | None = 1,
    progress: bool | Progress = True,
) -> Optimised:
    """Return the reader for which a function of one's own is smallest, and all that were tried.

    A survey spread over the bounds, then a refinement of the best design found, as ``octant
    optimise`` does with Octant's own scores. Designs that cannot be built, for which a function
    fails or a constraint is negative, are infeasible. It promises a local minimum only.

    Parameters
    ----------
    reader : The reader that is varied; its own values are tried first.
    parameters : Least and greatest value by key of the reader that varies [m], [ohm]: those of
        ``optimise.parameters`` in a study file.
    objective : Takes each varied `Study` and returns a number; less is better. Return minus what
        is to be large.
    subject_to : Functions of the same kind; a design is feasible where none is negative. They are
        asked before the objective.
    choices : Values by key of which every combination is surveyed, as ``optimise.choices``.
    room, tags : The room (free space where it is left out) and its tags.
    survey, budget : Designs of the survey and of the refinement, for each combination of choices
        and for the best one.
    method : ``nelder-mead``, ``cobyqa`` or ``differential-evolution``.
    seed : Of everything that is drawn.
    store : Folder in which every design is kept: the same call again goes on where it stopped.
    frequency_hz, channels_hz : Carrier and hopping frequencies [Hz].
    solver, tables : Keys of ``[solver]``, and further tables of a study file by name.
    workers : Processes that share the survey; None: one for each core. As in `sweep`.
    progress : False silences it.

    Examples
    --------
    >>> import octant
    >>> def off_nine_cm(study):
    ...     return abs(study.reader.antenna_radius_m - 0.09)
    >>> reader = octant.Reader(response="isolated", plate_height_m=0.0)
    >>> bounds = {"antenna_radius_m": (0.05, 0.10)}
    >>> found = octant.optimise(reader, bounds, objective=off_nine_cm, progress=False)
    >>> round(found.reader.antenna_radius_m, 3)
    0.09
    """
    table = {
        "parameters": dict(parameters),
        "choices": {name: list(values) for name, values in (choices or {}).items()},
        "survey": survey,
        "evaluations": budget if parameters else 0,
        "method": method,
    }
    study = link_study(
        Room.free_space() if room is None else room,
        tags,
        reader,
        {**(tables or {}), "solver": solver, "optimise": table, "seed": seed},
        frequency_hz=frequency_hz,
        channels_hz=channels_hz,
    )
    asked = study.optimise
    assert asked is not None  # noqa: S101  it has just been given
    names = (*asked.choices.given(), *asked.parameters.given())
    functions = (objective, *subject_to)
    judge = Judge(
        study=study,
        objective=objective,
        subject_to=tuple(subject_to),
        code=tuple(code_of(function) for function in functions),
    )
    shown = progress_of(progress)
    with ExitStack() as stack:
        folder = Path(store or stack.enter_context(tempfile.TemporaryDirectory()))

        def judged(designs: Sequence[ReaderTable], workers: int | None = 1) -> list[Evaluation]:
            kept = map_cases(
                judged_case,
                [{name: _plain(getattr(design, name)) for name in names} for design in designs],
                context=judge,
                folder=folder,
                codec=RecordCodec(Verdict),
                leave_out=("Judge.objective", "Judge.subject_to", "Study.optimise", "Study.name"),
                workers=workers,
                progress=shown if len(designs) > 1 else Progress(quiet=True),
                label="designs",
            )
            return [
                _evaluation(design, one, frequency_hz=study.radio.frequency_hz)
                for design, one in zip(designs, kept, strict=True)
            ]

        try:
            found = search(
                study,
                asked,
                evaluate=lambda design: judged([design])[0],
                prepare=lambda designs: judged(designs, workers),
                attainment=lambda one: -one.objective if one.feasible else -math.inf,
            )
        except SweepStateError as exc:
            msg = str(exc).replace(
                "Change optimise.parameters, choices or limits.", "Change parameters or functions."
            )
            raise ConfigError(msg) from exc
    return Optimised(study=study, names=names, found=found)


def _evaluation(design: ReaderTable, kept: Kept[Verdict], *, frequency_hz: float) -> JudgedDesign:
    width_m, height_m = design.size_m(frequency_hz)
    verdict = kept.record or Verdict(objective=math.nan, constraints=())
    reason, none = kept.reason, np.zeros(0)
    if not reason and math.isnan(verdict.objective):
        reason = "the objective is not a number."
        missed = [str(i + 1) for i, value in enumerate(verdict.constraints) if not value >= 0.0]
        if missed:
            reason = f"constraint {', '.join(missed)} is negative."
    return JudgedDesign(
        design=design,
        reason=reason,
        footprint_m=width_m,
        height_m=height_m,
        objective=verdict.objective,
        constraints=verdict.constraints,
        right_share=none,
        margin_db=none,
        bearing_error_deg=none,
        front_to_back_db=none,
        level_w=none,
    )


def _judged(evaluation: Evaluation) -> JudgedDesign:
    assert isinstance(evaluation, JudgedDesign)  # noqa: S101  `optimise` makes no others
    return evaluation


def _plain(value: Any) -> Any:  # noqa: ANN401  a key's value
    return math.nan if value is None else value
