"""Kalman filters: prediction, gated update in Joseph form, and the tests of consistency.

Leading axes are a batch of filters. A linear filter gives its matrices; an extended one also gives
the moved mean or the predicted measurement.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle

_SYMMETRY = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True)
class Gaussian:
    """A belief: mean and covariance, or a batch of them.

    Parameters
    ----------
    mean : (..., n) float64 — Mean [unit of each state].
    covariance : (..., n, n) float64 — Covariance [product of the states' units].
    """

    mean: npt.NDArray[np.float64]
    covariance: npt.NDArray[np.float64]

    def __post_init__(self) -> None:
        mean = np.array(self.mean, dtype=np.float64)
        covariance = np.array(self.covariance, dtype=np.float64)
        if mean.ndim == 0 or covariance.shape != (*mean.shape, mean.shape[-1]):
            msg = (
                f"the mean has shape {mean.shape} and the covariance {covariance.shape}, but "
                "(..., n) and (..., n, n) are needed: give a covariance for each mean."
            )
            raise NavigationError(msg)
        if not (np.isfinite(mean).all() and np.isfinite(covariance).all()):
            msg = (
                "a belief holds NaN or infinite values, but its mean and covariance must be "
                "finite: check the noise covariances and the measurements."
            )
            raise NavigationError(msg)
        mean.setflags(write=False)
        covariance.setflags(write=False)
        object.__setattr__(self, "mean", mean)
        object.__setattr__(self, "covariance", covariance)


@dataclass(frozen=True, slots=True, kw_only=True)
class Innovation:
    """What a measurement says that the belief did not.

    Parameters
    ----------
    residual : (..., m) float64 — Measurement less prediction, angles wrapped [measurements' units].
    covariance, measurement_noise : (..., m, m) float64 — S = C P Cᵀ + R, and R [squared units].
    observation : (..., m, n) float64 — Observation matrix, or Jacobian, C [measurement per state].
    """

    residual: npt.NDArray[np.float64]
    covariance: npt.NDArray[np.float64]
    observation: npt.NDArray[np.float64]
    measurement_noise: npt.NDArray[np.float64]

    @property
    def nis(self) -> npt.NDArray[np.float64]:
        """Return the (...) normalised innovation squared, rᵀ S⁻¹ r [-]; m on average."""
        return squared_mahalanobis(self.residual, self.covariance)


def covariance_matrix(
    value: npt.ArrayLike, *, states: int, name: str, definite: bool = True
) -> npt.NDArray[np.float64]:
    """Return a covariance as a checked read-only matrix (n, n) [squared unit of the states].

    Parameters
    ----------
    value : One variance for all, the diagonal, or the matrix [squared unit of the states].
    states : Number n of states.
    name : Name that an error message uses.
    definite : Refuse singular matrices; otherwise zero variances are allowed.
    """
    given = np.asarray(value, dtype=np.float64)
    matrix = np.array(given if given.ndim == 2 else np.diag(np.broadcast_to(given, (states,))))
    if matrix.shape != (states, states) or not np.isfinite(matrix).all():
        msg = (
            f"{name} has shape {given.shape}, but a finite ({states}, {states}) covariance is "
            "needed: give one variance, the diagonal or the whole matrix."
        )
        raise NavigationError(msg)
    scale = max(float(np.abs(matrix).max()), np.finfo(np.float64).tiny)
    smallest = float(np.linalg.eigvalsh(0.5 * (matrix + matrix.T)).min())
    low = 0.0 if definite else -_SYMMETRY * scale
    if (
        np.abs(matrix - matrix.T).max() > _SYMMETRY * scale
        or smallest < low
        or (definite and smallest == 0.0)
    ):
        kind = "definite" if definite else "semidefinite"
        msg = (
            f"{name} is {matrix.tolist()}, but it must be symmetric and positive {kind}: "
            "give real variances."
        )
        raise NavigationError(msg)
    matrix.setflags(write=False)
    return matrix


def predict(
    belief: Gaussian,
    *,
    transition: npt.ArrayLike,
    process_noise: npt.ArrayLike,
    moved_mean: npt.ArrayLike | None = None,
) -> Gaussian:
    """Return the belief one step later, with Φ P Φᵀ + Q as in the docking paper's (8), (10).

    Parameters
    ----------
    belief : Belief before, (..., n).
    transition : (..., n, n) array_like — Φ, or the Jacobian of the motion [state per state].
    process_noise : (..., n, n) array_like — Q of the step [squared unit of the states].
    moved_mean : (..., n) array_like or None — Mean after [states' units]; None: Φ times the mean.
    """
    phi = np.asarray(transition, dtype=np.float64)
    mean = _apply(phi, belief.mean) if moved_mean is None else np.asarray(moved_mean)
    covariance = phi @ belief.covariance @ _transposed(phi) + np.asarray(process_noise)
    return Gaussian(mean=mean, covariance=_symmetric(covariance))


def innovate(
    belief: Gaussian,
    measurement: npt.ArrayLike,
    *,
    observation: npt.ArrayLike,
    measurement_noise: npt.ArrayLike,
    predicted: npt.ArrayLike | None = None,
    angles: tuple[int, ...] = (),
) -> Innovation:
    """Return the innovation of a measurement: residual and its covariance C P Cᵀ + R.

    Parameters
    ----------
    belief : Belief before, (..., n).
    measurement : (..., m) array_like — What was measured [unit of each measurement].
    observation : (..., m, n) array_like — Matrix, or Jacobian, C [measurement per state].
    measurement_noise : (..., m, m) array_like — R [squared unit of the measurements].
    predicted : (..., m) array_like or None — Predicted measurement [its units]; None: C times mean.
    angles : Which measurements are angles [rad]; their residuals are wrapped.
    """
    c = np.asarray(observation, dtype=np.float64)
    expected = _apply(c, belief.mean) if predicted is None else np.asarray(predicted)
    residual = np.array(np.asarray(measurement, dtype=np.float64) - expected)
    for row in angles:
        residual[..., row] = wrap_angle(residual[..., row])
    noise = np.asarray(measurement_noise, dtype=np.float64)
    covariance = _symmetric(c @ belief.covariance @ _transposed(c) + noise)
    return Innovation(
        residual=residual, covariance=covariance, observation=c, measurement_noise=noise
    )


def within_gate(innovation: Innovation, *, probability: float) -> npt.NDArray[np.bool_]:
    """Return whether the normalised innovation squared is at most the quantile of χ²(m), (...).

    Parameters
    ----------
    innovation : Of the measurement, (..., m).
    probability : Share of true measurements that pass, in (0, 1) [-].
    """
    limit = chi_squared_quantile(probability, degrees=innovation.residual.shape[-1])
    return np.asarray(innovation.nis <= limit)


def update(
    belief: Gaussian, innovation: Innovation, *, accept: npt.ArrayLike | None = None
) -> Gaussian:
    """Return mean + K r and (I - K C) P (I - K C)ᵀ + K R Kᵀ with K = P Cᵀ S⁻¹: the Joseph form.

    Docking paper (8), (9), (11), corrected: (9) prints the gain without R in the inverse, and the
    second factor of (11) must be (I - K C)ᵀ. It stays positive for any gain.

    Parameters
    ----------
    belief, innovation : Belief before, (..., n), and what the measurement says.
    accept : (...) array_like of bool or None — Where it counts [-]; None: everywhere.
    """
    c = innovation.observation
    cross = c @ belief.covariance
    gain = _transposed(np.linalg.solve(innovation.covariance, cross))
    kept = np.eye(belief.mean.shape[-1]) - gain @ c
    mean = belief.mean + _apply(gain, innovation.residual)
    covariance = _symmetric(
        kept @ belief.covariance @ _transposed(kept)
        + gain @ innovation.measurement_noise @ _transposed(gain)
    )
    if accept is not None:
        counts = np.asarray(accept, dtype=np.bool_)
        mean = np.where(counts[..., None], mean, belief.mean)
        covariance = np.where(counts[..., None, None], covariance, belief.covariance)
    return Gaussian(mean=mean, covariance=covariance)


def nees(
    belief: Gaussian, truth: npt.ArrayLike, *, angles: tuple[int, ...] = ()
) -> npt.NDArray[np.float64]:
    """Return the normalised estimation error squared (x̂ - x)ᵀ P⁻¹ (x̂ - x) [-]; n on average.

    Parameters
    ----------
    belief : Belief, (..., n).
    truth : (..., n) array_like — True state [unit of each state].
    angles : Which states are angles [rad]; their errors are wrapped.
    """
    error = np.array(belief.mean - np.asarray(truth, dtype=np.float64))
    for row in angles:
        error[..., row] = wrap_angle(error[..., row])
    return squared_mahalanobis(error, belief.covariance)


def squared_mahalanobis(
    residual: npt.ArrayLike, covariance: npt.ArrayLike
) -> npt.NDArray[np.float64]:
    """Return the squared Mahalanobis distance rᵀ S⁻¹ r [-].

    Parameters
    ----------
    residual, covariance : (..., m), (..., m, m) array_like — r and its S [components' units].
    """
    r = np.asarray(residual, dtype=np.float64)
    whitened = np.linalg.solve(np.asarray(covariance, dtype=np.float64), r[..., None])[..., 0]
    return np.asarray(np.sum(r * whitened, axis=-1))


def chi_squared_quantile(probability: float, *, degrees: int) -> float:
    """Return the quantile of the chi-squared distribution [-].

    Parameters
    ----------
    probability : In (0, 1) [-].
    degrees : Degrees of freedom, at least 1.
    """
    from scipy.special import chdtri

    if not 0.0 < probability < 1.0 or degrees < 1:
        msg = (
            f"probability is {probability} with {degrees} degrees of freedom, but it must lie "
            "strictly between 0 and 1 with at least one degree: 0.99 is usual for a gate."
        )
        raise NavigationError(msg)
    return float(chdtri(degrees, 1.0 - probability))


def consistency_band(
    *, degrees: int, samples: int, probability: float = 0.95
) -> tuple[float, float]:
    """Return the quantiles of χ²(N n)/N between which the mean NEES or NIS of a filter lies [-].

    Bar-Shalom, Li and Kirubarajan (2001), section 5.4.2. Values of one run at different times are
    not independent: average over runs at one time.

    Parameters
    ----------
    degrees : Size n of the state (NEES) or of the measurement (NIS).
    samples : Number N of independent runs that are averaged.
    probability : Probability of the band, two-sided [-].
    """
    if samples < 1:
        msg = f"samples is {samples}, but at least one run is needed: raise it."
        raise NavigationError(msg)
    tail = 0.5 * (1.0 - probability)
    total = degrees * samples
    low, high = (chi_squared_quantile(p, degrees=total) / samples for p in (tail, 1.0 - tail))
    return low, high


def _apply(
    matrix: npt.NDArray[np.float64], vector: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    return np.asarray((matrix @ vector[..., None])[..., 0])


def _transposed(matrix: npt.ArrayLike) -> npt.NDArray[np.float64]:
    return np.swapaxes(np.asarray(matrix, dtype=np.float64), -1, -2)


def _symmetric(matrix: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    return np.asarray(0.5 * (matrix + _transposed(matrix)))
