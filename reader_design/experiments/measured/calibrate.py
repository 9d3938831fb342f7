"""A calibration: values fitted to a log, tried on what they were not fitted to, written as a study.

The whole fit and each fold are kept in files, so that a run that was stopped goes on.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import msgspec
import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna
from octant.geometries.errors import ConfigError
from octant.navigation.logs.records import Log
from octant.navigation.statistics import Z_95, Interval
from octant.reader_design.experiments.measured.agreement import pooled_sd_db
from octant.reader_design.experiments.measured.baselines import Baseline, baselines
from octant.reader_design.experiments.measured.calibrate_fit import (
    Fit,
    Task,
    Told,
    fit,
    refuse_untold,
    told,
)
from octant.reader_design.experiments.measured.calibrate_model import LevelModel
from octant.reader_design.experiments.measured.calibrate_names import (
    Parameter,
    material_paths,
    parameters_of,
    scene_material,
)
from octant.reader_design.experiments.measured.observations import (
    CELL_M,
    LEAST,
    Observations,
    observed,
)
from octant.reader_design.experiments.measured.predict import (
    PLACE_M,
    Predictor,
    Rows,
    predictable,
)
from octant.reader_design.experiments.measured.sight import straight_lines
from octant.reader_design.keeping.keeper import RecordCodec, map_cases
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.antennas import named_antenna
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.study_file.calibration import Calibration
from octant.reader_design.study_file.checks import check_study
from octant.reader_design.study_file.loading import resolved
from octant.reader_design.study_file.schema import Study

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

CASES = "cases"
"""Folder of what is kept of a run."""
BLOCK_M = 2.0
"""Side of the squares of the floor that a fold holds out whole, since neighbours resemble [m]."""
DEFAULT_FOLDS = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    """What a calibration is asked for.

    Parameters
    ----------
    names : What is fitted, as `octant calibrate --fit` takes it.
    priors : Mean and standard deviation by parameter's name, in its unit.
    antenna : The robot's antenna where the log numbers none: a kind, or a pattern file.
    folds : ``anchors``: one source held out at a time; or a number of folds over blocks of the
        floor; None: anchors where something is shared by three or more, else blocks.
    cell_m, least : Side of a cell [m], and readings that make a local mean.
    place_m : Side of the squares whose readings share one prediction [m].
    """

    names: tuple[str, ...]
    priors: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    antenna: str = "dipole"
    folds: Literal["anchors"] | int | None = None
    cell_m: float = CELL_M
    least: int = LEAST
    place_m: float = PLACE_M


@dataclass(kw_only=True)
class Problem:
    """A log, the room that should explain it, and what is fitted; traced when first needed.

    Parameters
    ----------
    study, log, wanted : The study, the log in the room's frame, what is asked for.
    progress : Shows the tracing; no part of what results depend on.
    """

    study: Study
    log: Log
    wanted: Wanted
    progress: Progress = field(default_factory=Progress)

    @cached_property
    def setting(self) -> Setting:
        """The room."""
        return build_setting(self.study)

    @cached_property
    def rows(self) -> Rows:
        """The readings that can be predicted."""
        return predictable(self.log, self.setting, place_m=self.wanted.place_m)

    @cached_property
    def observations(self) -> Observations:
        """The local means."""
        return observed(self.rows, cell_m=self.wanted.cell_m, least=self.wanted.least)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """What is fitted."""
        return parameters_of(self.wanted.names, self.setting, self.rows)

    @cached_property
    def predictor(self) -> Predictor:
        """The traced paths."""
        made = Predictor(
            self.setting,
            self.rows,
            receiver=receivers(self.setting, self.rows, self.wanted.antenna),
            progress=self.progress,
        )
        made.trace()
        return made

    @cached_property
    def task(self) -> Task:
        """What the fit compares."""
        model = LevelModel(
            predictor=self.predictor,
            observations=self.observations,
            parameters=self.parameters,
            power_w=self.study.radio.tag_power_w,
        )
        return Task(model=model, priors=self.priors)

    @cached_property
    def priors(self) -> dict[int, tuple[float, float]]:
        """Mean and standard deviation of a parameter by its number, in coordinates [any]."""
        names = [p.name for p in self.parameters]
        out = {}
        for name, (mean, sd) in self.wanted.priors.items():
            if name not in names:
                msg = f"--prior {name}: it is not fitted; --fit names {', '.join(names)}."
                raise ConfigError(msg)
            p = self.parameters[names.index(name)]
            if not (p.low <= mean <= p.high and sd > 0.0):
                msg = (
                    f"--prior {name} = {mean:g} : {sd:g} is not possible; give a mean from "
                    f"{p.low:g} to {p.high:g} {p.unit} and a deviation above 0."
                )
                raise ConfigError(msg)
            width = sd / mean if p.logarithmic else sd
            out[names.index(name)] = (p.inward(mean), width)
        return out

    @cached_property
    def held_out(self) -> tuple[str, npt.NDArray[np.int64]]:
        """How observations are held out: ``anchors`` or ``blocks``, and the fold of each, (o,)."""
        o, folds = self.observations, self.wanted.folds
        sources = np.unique(o.sources)
        shared = any(not p.own for p in self.parameters)
        if folds == "anchors" or (folds is None and shared and len(sources) >= 3):
            if len(sources) < 2:
                msg = "one anchor cannot be held out of one; give --folds a number instead."
                raise ConfigError(msg)
            return "anchors", np.searchsorted(sources, o.sources)
        count = int(folds) if isinstance(folds, int) else DEFAULT_FOLDS
        blocks = np.floor(o.places / BLOCK_M).astype(np.int64)
        _, block = np.unique(blocks, axis=0, return_inverse=True)
        number = int(block.max()) + 1
        if number < 2:
            msg = (
                f"the log covers one square of {BLOCK_M:g} m of the floor, so no part of it can be "
                "held out; give a log of a longer way, or --folds anchors."
            )
            raise ConfigError(msg)
        if number < count:
            msg = (
                f"the log covers {number} squares of {BLOCK_M:g} m of the floor, too few for "
                f"{count} folds; give --folds {number} or fewer."
            )
            raise ConfigError(msg)
        order = np.random.default_rng(self.study.seed).permutation(number)
        return "blocks", order[block.reshape(-1)] % count


def receivers(setting: Setting, rows: Rows, name: str) -> tuple[Antenna, ...] | None:
    """Return the robot's antenna at each frequency where the log numbers none, else None.

    Parameters
    ----------
    setting, rows : The room; the readings.
    name : Kind of antenna, or pattern file.
    """
    if rows.numbered:
        return None
    return tuple(
        named_antenna(name, radio.frequency_hz, key="--antenna") for radio in setting.radios
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """One fit of a run.

    Parameters
    ----------
    fold : Fold that is held out [-]; -1: none.
    start : Coordinates to begin with [any]; empty: the study's.
    model_error_db : Error of the model [dB]; None: estimated.
    """

    fold: int = -1
    start: tuple[float, ...] = ()
    model_error_db: float | None = None


def fitted_part(problem: Problem, part: Part) -> Fit:
    """Return one fit: of everything, or of all but a fold, with residuals of the fold [dB].

    Where anchors are held out, the shared values come from the others, and the anchor's own from
    its own readings.

    Parameters
    ----------
    problem, part : What is fitted; what is held out.
    """
    task, o = problem.task, problem.observations
    every = np.ones(len(o), dtype=bool)
    free = np.ones(len(problem.parameters), dtype=bool)
    if part.fold < 0:
        return fit(task, task.start(), free, every)
    how, fold = problem.held_out
    start, error = np.array(part.start), part.model_error_db
    out = fold == part.fold
    found = fit(task, start, free if how == "blocks" else _not_of(problem, out), ~out,
                model_error_db=error)  # fmt: skip
    if how == "blocks":
        return found
    return fit(task, found.theta, ~_not_of(problem, out) & free, out, model_error_db=error)


def _not_of(problem: Problem, out: BoolArray) -> BoolArray:
    """Return which parameters belong to no source that is held out, (p,)."""
    ids = problem.rows.log.ids
    held = {ids[s] for s in np.unique(problem.observations.sources[out])}
    return np.array([not (p.own and p.item in held) for p in problem.parameters])


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibrated:
    """The result of a calibration.

    Parameters
    ----------
    problem, whole : What was fitted; the fit of everything.
    values : Each parameter's value with its 95 % interval, in its unit; NaN ends: not told.
    how, held_out_db : What was held out, and its residuals, (o,) [dB].
    folds : Number of folds [-].
    before_db : Residuals of the study as it was, levels free, (o,) [dB].
    told : What the log tells of the parameters.
    baselines : Laws fitted in the same way.
    study : The study with the fitted values.
    """

    problem: Problem
    whole: Fit
    values: tuple[Interval, ...]
    how: str
    held_out_db: FloatArray
    folds: int
    before_db: FloatArray
    told: Told
    baselines: tuple[Baseline, ...]
    study: Study

    @property
    def held_out_sd_db(self) -> float:
        """The headline: root mean square of the residuals that were held out [dB]."""
        finite = self.held_out_db[np.isfinite(self.held_out_db)]
        return float(np.sqrt(np.mean(finite**2))) if finite.size else float("nan")

    @property
    def before_sd_db(self) -> float:
        """The same of the study as it was, with one level an anchor [dB]."""
        return pooled_sd_db(self.before_db, self.problem.observations.sources)


def calibrated(problem: Problem, out: Path, progress: Progress) -> Calibrated:
    """Return the calibration of a study by a log; what was computed before is not computed again.

    Parameters
    ----------
    problem, out, progress : What is fitted; folder of the results; shows how far it is.

    Raises
    ------
    ConfigError
        The log does not fit the study, or cannot tell some parameters apart.
    """
    task, o = problem.task, problem.observations
    start = task.start()
    every = np.ones(len(o), dtype=bool)
    found = told(task, start, every, 0.0)  # refused is what even a perfect model could not tell
    refuse_untold(found)
    before = o.level_dbm - task.model.local_means(_without_diffuse(problem, start))

    def parts(cases: Sequence[Part], label: str) -> list[Fit]:
        kept = map_cases(
            fitted_part,
            cases,
            context=problem,
            folder=out / CASES,
            codec=RecordCodec(Fit),
            leave_out=("Problem.progress", "Study.name"),
            workers=1,
            progress=progress,
            label=label,
            raises=(ConfigError,),
        )
        return [one.value for one in kept]

    whole = parts([Part()], "fit of all")[0]
    how, fold = problem.held_out
    count = int(fold.max()) + 1
    start_at = tuple(float(x) for x in whole.theta)
    cases = [
        Part(fold=k, start=start_at, model_error_db=whole.model_error_db) for k in range(count)
    ]
    held = np.full(len(o), np.nan)
    for k, one in enumerate(parts(cases, "folds")):
        held[fold == k] = one.residual_db[fold == k]
    distance_m, walls = straight_lines(problem.setting, problem.rows, o)
    return Calibrated(
        problem=problem,
        whole=whole,
        values=values_of(problem.parameters, whole),
        how=how,
        held_out_db=held,
        folds=count,
        before_db=before,
        told=told(task, whole.theta, every, whole.model_error_db),
        baselines=baselines(o.level_dbm, o.sources, distance_m, walls),
        study=fitted_study(problem, whole.theta),
    )


def _without_diffuse(problem: Problem, theta: FloatArray) -> FloatArray:
    """Return coordinates whose diffuse fields are the study's, which may have none."""
    given = (problem.study.calibration or Calibration()).diffuse_db
    return np.array(
        [
            given.get(p.item, p.low) if p.kind == "diffuse" else x
            for p, x in zip(problem.parameters, theta, strict=True)
        ]
    )


def values_of(parameters: Sequence[Parameter], found: Fit) -> tuple[Interval, ...]:
    """Return values with their 95 % intervals after Student's t, in their units; NaN: not told.

    Those of logarithmic parameters are not even.

    Parameters
    ----------
    parameters, found : What was fitted; the fit [any].
    """
    from scipy.stats import t

    spare = max(1, found.used - len(parameters))
    factor = float(t.ppf(0.975, spare)) if spare < 10_000 else Z_95
    out = []
    for p, x, variance in zip(parameters, found.theta, np.diag(found.covariance), strict=True):
        half = factor * float(np.sqrt(variance)) if variance >= 0.0 else float("nan")
        low, high = p.inward(p.low), p.inward(p.high)
        if x - half <= low and x + half >= high:  # the bounds say more than the log
            half = float("nan")
        ends = (max(float(x) - half, low), min(float(x) + half, high))
        ends = ends if np.isfinite(half) else (half, half)
        out.append(
            Interval(value=p.outward(float(x)), low=p.outward(ends[0]), high=p.outward(ends[1]))
        )
    return tuple(out)


def fitted_study(problem: Problem, theta: FloatArray) -> Study:
    """Return the study with the fitted values in its own keys and in ``[calibration]``.

    Materials are written as permittivity and conductivity at the carrier.

    Parameters
    ----------
    problem, theta : What was fitted; coordinates [any].
    """
    study, setting = problem.study, problem.setting
    tables = msgspec.to_builtins(msgspec.structs.replace(study, sweep={}))
    given = study.calibration or Calibration()
    level, diffuse = dict(given.level_db), dict(given.diffuse_db)
    antenna = list(given.antenna_db)
    values = problem.task.model.values(theta)
    for label, found in values.materials.items():
        spec: dict[str, Any] = {
            "eps_r": found.eps_r_a,
            "sigma_s_per_m": found.sigma_c_s_per_m,
            "thickness_m": scene_material(label, setting).thickness_m and found.thickness_m,
        }
        for path in material_paths(setting)[label]:
            _put(tables, path, spec)
    for number, axis in values.axes.items():
        tables["tag"][number]["axis"] = list(axis)
    for number, place in values.places_m.items():
        tables["tag"][number]["position_m"] = list(place)
    if values.height_m is not None:
        tables["reader"]["height_m"] = values.height_m
    for p, x in zip(problem.parameters, theta, strict=True):
        if p.kind == "level":
            level[p.item] = float(x)
        elif p.kind == "diffuse":
            diffuse[p.item] = float(x)
        elif p.kind == "antenna_level":
            antenna += [0.0] * (int(p.item) - len(antenna))
            antenna[int(p.item) - 1] = float(x)
    tables["calibration"] = {"level_db": level, "diffuse_db": diffuse, "antenna_db": antenna}
    fitted = msgspec.convert(tables, Study)
    check_study(fitted)
    return resolved(fitted, directory=Path("/"))


def _put(tables: Any, path: str, spec: Mapping[str, Any]) -> None:  # noqa: ANN401  plain tables
    """Set the material at a key path such as ``room.object[0].material``."""
    node = tables
    steps: list[str | int] = []
    head, _, body = path.partition(".materials.")
    for word in head.split("."):
        name, _, number = word.partition("[")
        steps += [name, *([int(number[:-1])] if number else [])]
    steps += ["materials", body] if body else []
    for step in steps[:-1]:
        node = node[step]
    last = steps[-1]
    if isinstance(node[last], dict) and "walls" in node[last]:  # a room's own material
        kept = dict.fromkeys(node[last])
        node[last] = {**kept, **spec}
    else:
        node[last] = dict(spec)
