"""Least squares with bounds, priors and a robust loss, and what its result is worth.

Residuals are local means less predictions, each over its own doubt: the fading's scatter over the
root of the number of readings, and besides a model error that is estimated from the residuals.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.measured.calibrate_model import LevelModel
from octant.reader_design.experiments.measured.calibrate_names import UNKNOWN_STEPS, Parameter

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

ROBUST = 2.5
"""Residual over its doubt from which it counts linearly only [-]: Huber's loss."""
FIRST_MODEL_ERROR_DB = 3.0
"""Error of the model [dB] that a fit begins with."""
PARTNER = 0.3
"""Share of a direction that the log does not tell, from which a parameter is named [-]."""
AT_BOUND = 1e-6
DARK = 0.2
"""Share of the places that are called dark [-]."""
SILENT = 0.05
"""Slope, in doubts by natural step, below which a fitted value is not told at all [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Fit:
    """The values that fit some observations best.

    Parameters
    ----------
    theta : (p,) float64 — Coordinates of all parameters, see `Parameter.inward` [any].
    free : (p,) bool — Which of them were fitted [-].
    covariance : (p, p) float64 — Of the coordinates; NaN where a value was not fitted or is at its
        bound [any].
    used : Observations that were fitted [-].
    scatter_db, model_error_db : Scatter of readings about their local mean, and error of the model
        besides [dB].
    residual_db : (o,) float64 — Measured less predicted, of all observations [dB].
    """

    theta: FloatArray
    free: BoolArray
    covariance: FloatArray
    used: int
    scatter_db: float
    model_error_db: float
    residual_db: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Task:
    """Which values are fitted to which observations, from where.

    Parameters
    ----------
    model : Predicts them.
    priors : Mean and standard deviation of a parameter by its number, in coordinates [any].
    """

    model: LevelModel
    priors: Mapping[int, tuple[float, float]]

    def start(self) -> FloatArray:
        """Return the study's values as coordinates, (p,) [any]; levels are found from the data.

        A diffuse field that the study does not give starts as strong as the paths are at the
        darkest fifth of a source's places.
        """
        parameters, rows = self.model.parameters, self.model.predictor.rows
        theta = np.array([p.inward(p.start) for p in parameters])
        waits = np.isnan(theta)
        theta[waits] = -150.0
        gains = self.model.predictor.gains(self.model.values(theta))
        for k in np.flatnonzero(waits).tolist():
            own = gains[rows.log.ids.index(parameters[k].item)]
            dark = np.nanquantile(own, DARK) if np.isfinite(own).any() else 0.0
            theta[k] = 10.0 * np.log10(max(float(dark), 1e-12))
        observed = self.model.observations
        rest = observed.level_dbm - self.model.local_means(theta)
        for k, p in enumerate(parameters):
            if p.kind == "level":
                mine = (observed.sources == rows.log.ids.index(p.item)) & np.isfinite(rest)
                if mine.any():
                    theta[k] += float(np.median(rest[mine]))
        return theta

    def bounds(self) -> tuple[FloatArray, FloatArray]:
        """Return least and greatest coordinates, (p,) each [any]."""
        low, high = (
            np.array([p.inward(getattr(p, end)) for p in self.model.parameters])
            for end in ("low", "high")
        )
        return low, high

    def doubts_db(self, model_error_db: float) -> FloatArray:
        """Return the standard deviation of each observation about the prediction, (o,) [dB].

        Parameters
        ----------
        model_error_db : Error of the model besides the scatter [dB].
        """
        o = self.model.observations
        readings = np.maximum(o.heard + o.censored, 1)
        out: FloatArray = np.sqrt(o.scatter_db**2 / readings + model_error_db**2)
        return out

    def residuals(self, predicted: FloatArray, doubt: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return residuals over their doubt, (o,), and their slopes to the prediction [1/dB].

        An observation without any heard reading has that of its likelihood, Φ((T - m) / s).

        Parameters
        ----------
        predicted, doubt : (o,) float64 — Predicted local means [dBm], and doubts [dB].
        """
        from scipy.special import log_ndtr

        o = self.model.observations
        heard = np.isfinite(o.level_dbm)
        residual = np.where(heard, o.level_dbm - predicted, 0.0) / doubt
        slope = -1.0 / doubt
        if o.threshold_dbm is not None and not heard.all():
            t = (o.threshold_dbm - predicted) / doubt
            log_share = log_ndtr(t)
            below = np.sqrt(-2.0 * log_share)
            mills = np.exp(-0.5 * t * t - 0.5 * np.log(2.0 * np.pi) - log_share)
            residual = np.where(heard, residual, -below)
            slope = np.where(heard, slope, -mills / np.maximum(below, 1e-9) / doubt)
        return residual, slope


def fit(
    task: Task,
    theta: FloatArray,
    free: BoolArray,
    rows: BoolArray,
    *,
    model_error_db: float | None = None,
) -> Fit:
    """Return the best values of the free parameters for some observations.

    Parameters
    ----------
    task, theta : What is fitted; (p,) coordinates to begin with, which others keep [any].
    free, rows : (p,), (o,) bool — Parameters that are fitted, observations that count [-].
    model_error_db : Error of the model [dB]; None: estimated from the residuals.
    """
    error = FIRST_MODEL_ERROR_DB if model_error_db is None else model_error_db
    if free.any():
        theta = _solved(task, theta, free, rows, error)
    if model_error_db is None:
        error = _model_error_db(task, theta, free, rows)
        if free.any():
            theta = _solved(task, theta, free, rows, error)
    predicted = task.model.local_means(theta)
    return Fit(
        theta=theta,
        free=free,
        covariance=_covariance(task, theta, free, rows, error),
        used=int(rows.sum()),
        scatter_db=task.model.observations.scatter_db,
        model_error_db=error,
        residual_db=task.model.observations.level_dbm - predicted,
    )


def _solved(
    task: Task, theta: FloatArray, free: BoolArray, rows: BoolArray, error_db: float
) -> FloatArray:
    """Return coordinates whose free ones are the best for some observations."""
    from scipy.optimize import least_squares

    which = np.flatnonzero(free)
    doubt = task.doubts_db(error_db)
    steps = np.array([task.model.parameters[k].step for k in which])
    low, high = (end[which] for end in task.bounds())
    prior = [k for k in which.tolist() if k in task.priors]

    def whole(some: FloatArray) -> FloatArray:
        out = theta.copy()
        out[which] = some
        return out

    def residuals(some: FloatArray) -> FloatArray:
        here = whole(some)
        r, _ = task.residuals(task.model.local_means(here), doubt)
        return np.concatenate([r[rows], _prior_residuals(task, here, prior)])

    def slopes(some: FloatArray) -> FloatArray:
        return _slopes(task, whole(some), which, rows, doubt)

    margin = 1e-9 * (high - low)
    found = least_squares(
        residuals,
        np.clip(theta[which], low + margin, high - margin),
        jac=slopes,
        bounds=(low, high),
        x_scale=steps,
        loss="huber",
        f_scale=ROBUST,
        xtol=1e-3,  # far below the intervals; ridges of what the log hardly tells take for ever
        ftol=1e-4,
        gtol=1e-6,
        max_nfev=40,
    )
    return whole(found.x)


def _prior_residuals(task: Task, theta: FloatArray, prior: list[int]) -> FloatArray:
    return np.array([(theta[k] - task.priors[k][0]) / task.priors[k][1] for k in prior])


def _slopes(
    task: Task, theta: FloatArray, which: npt.NDArray[np.intp], rows: BoolArray, doubt: FloatArray
) -> FloatArray:
    """Return slopes of the residuals and of the priors to the coordinates that are asked for."""
    predicted = task.model.local_means(theta)
    _, slope = task.residuals(predicted, doubt)
    of_levels = task.model.slopes(theta, which.tolist())
    prior = [k for k in which if k in task.priors]
    extra = np.zeros((len(prior), len(which)))
    for i, k in enumerate(prior):
        extra[i, int(np.flatnonzero(which == k)[0])] = 1.0 / task.priors[k][1]
    return np.concatenate([(slope[:, None] * of_levels)[rows], extra])


def _model_error_db(task: Task, theta: FloatArray, free: BoolArray, rows: BoolArray) -> float:
    """Return what residuals scatter more than fading explains [dB], by their moments."""
    o = task.model.observations
    residual = (o.level_dbm - task.model.local_means(theta))[rows]
    heard = np.isfinite(residual)
    spare = max(1, int(heard.sum()) - int(free.sum()))
    # Of the median, so that a few wild cells do not make the whole model bad.
    spread = 1.4826 * float(np.median(np.abs(residual[heard]))) if heard.any() else 0.0
    total = min(float(np.sum(residual[heard] ** 2)) / spare, 4.0 * spread**2 + 1e-12)
    fading = o.scatter_db**2 / np.maximum(o.heard + o.censored, 1)[rows][heard]
    return float(np.sqrt(max(total - float(np.mean(fading)), 0.0))) if heard.any() else 0.0


def _covariance(
    task: Task, theta: FloatArray, free: BoolArray, rows: BoolArray, error_db: float
) -> FloatArray:
    """Return the covariance of the coordinates, robust to unequal doubts (HC3)."""
    size = len(theta)
    covariance = np.full((size, size), np.nan)
    low, high = task.bounds()
    span = high - low
    inside = (theta - low > AT_BOUND * span) & (high - theta > AT_BOUND * span)
    which = np.flatnonzero(free & inside)
    if not which.size:
        return covariance
    doubt = task.doubts_db(error_db)
    residual, _ = task.residuals(task.model.local_means(theta), doubt)
    jacobian = _slopes(task, theta, which, rows, doubt)
    r = np.concatenate([residual[rows], np.zeros(len(jacobian) - int(rows.sum()))])
    weight = np.minimum(1.0, ROBUST / np.maximum(np.abs(r), 1e-12))
    steps = np.array([task.model.parameters[k].step for k in which])
    heard = np.linalg.norm(jacobian * steps, axis=0) > SILENT
    which, steps, jacobian = which[heard], steps[heard], jacobian[:, heard]
    scaled = jacobian * steps
    bread = np.linalg.pinv((scaled * weight[:, None]).T @ scaled, rcond=1e-12, hermitian=True)
    lever = np.einsum("ij,jk,ik->i", scaled, bread, scaled * weight[:, None])
    score = weight * r / np.maximum(1.0 - lever, 1e-3)
    n_prior = len(jacobian) - int(rows.sum())
    if n_prior:
        score[-n_prior:] = 1.0  # what a prior says is as uncertain as it states
    meat = (scaled * score[:, None]).T @ (scaled * score[:, None])
    found = bread @ meat @ bread * np.outer(steps, steps)
    covariance[np.ix_(which, which)] = found
    return covariance


@dataclass(frozen=True, slots=True, kw_only=True)
class Told:
    """What a log tells of the parameters.

    Parameters
    ----------
    unknown : Groups of parameters that it cannot tell apart, or one that it says nothing of.
    weak : The same, where it tells little.
    """

    unknown: tuple[tuple[str, ...], ...]
    weak: tuple[tuple[str, ...], ...]


def told(task: Task, theta: FloatArray, rows: BoolArray, error_db: float) -> Told:
    """Return which combinations of parameters the observations do not tell, by singular values.

    The slopes of the residuals, each over its doubt, with each parameter in its natural steps: a
    singular value s says that the combination of its vector is known to 1 / s steps.

    Parameters
    ----------
    task, theta, rows : What is fitted, where, to which observations [any].
    error_db : Error of the model [dB].
    """
    parameters = task.model.parameters
    which = np.arange(len(parameters))
    slopes = _slopes(task, theta, which, rows, task.doubts_db(error_db))
    _, size, vectors = np.linalg.svd(slopes * np.array([p.step for p in parameters]))
    size = np.concatenate([size, np.zeros(len(vectors) - len(size))])
    groups: dict[bool, list[tuple[str, ...]]] = {True: [], False: []}
    for s, vector in zip(size, vectors, strict=True):
        if s < 1.0:
            names = _partners(parameters, vector)
            groups[s * UNKNOWN_STEPS < 1.0].append(names)
    return Told(unknown=tuple(groups[True]), weak=tuple(groups[False]))


def _partners(parameters: tuple[Parameter, ...], vector: FloatArray) -> tuple[str, ...]:
    size = np.abs(vector)
    return tuple(parameters[k].name for k in np.argsort(-size) if size[k] >= PARTNER * size.max())


def refuse_untold(found: Told) -> None:
    """Refuse a fit of parameters that the log cannot tell apart.

    Parameters
    ----------
    found : From `told`.
    """
    if not found.unknown:
        return
    names = found.unknown[-1]
    if len(names) == 1:
        msg = (
            f"the log says next to nothing of {names[0]}: its predictions hardly depend on it; "
            "leave it out of --fit, or give a --prior of it."
        )
    else:
        msg = (
            f"the log cannot tell {' and '.join(names)} apart: changes of one are made up for by "
            "the other; fit one of them, or give a --prior of one."
        )
    raise ConfigError(msg)
