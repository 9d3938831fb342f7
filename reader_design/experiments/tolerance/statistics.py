"""Shares of explained variance."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Explained:
    """How much of a score's variance goes with each regressor.

    Attributes
    ----------
    names : Regressors.
    coefficients : (p,) float64 — Standardised regression coefficients [-].
    shares : (p,) float64 — Share of the variance [-]: coefficient times correlation, adding up to
        ``r_squared``. Small negative ones are noise.
    r_squared : Share explained by all together in the sample [-].
    r_squared_new : The same for samples left out of the fit one at a time [-]; worthless below 0.
    """

    names: tuple[str, ...]
    coefficients: FloatArray
    shares: FloatArray
    r_squared: float
    r_squared_new: float

    def by_kind(self) -> dict[str, float]:
        """Return the shares added up by what stands before the colon of a name [-]."""
        out: dict[str, float] = {}
        for name, share in zip(self.names, self.shares, strict=True):
            kind = name.split(":")[0]
            out[kind] = out.get(kind, 0.0) + float(share)
        return out


def explained_variance(
    names: tuple[str, ...], columns: npt.ArrayLike, values: npt.ArrayLike
) -> Explained | None:
    """Return shares of variance by standardised linear regression, or None.

    None where nothing varies, or below p + 2 samples. Shares are J. W. Pratt's product measure
    beta_j r_j (Proc. 2nd Tampere Conf. in Statistics (1987) 245-260): for independent regressors
    the squared standardised coefficients. The left-out error is the residual over one less the
    leverage (PRESS; D. M. Allen, Technometrics 16 (1974) 125-127).

    Parameters
    ----------
    names, columns : (s, p) array_like — Regressors and their values, each in its own unit.
    values : (s,) array_like — The score [its unit].
    """
    x, y = np.asarray(columns, dtype=np.float64), np.asarray(values, dtype=np.float64)
    count, parameters = x.shape
    # A score in floating point that "varies" by rounding only does not vary.
    flat = np.ptp(y) <= 1e-12 * max(1.0, float(np.abs(y).max(initial=0.0)))
    if not parameters or count < parameters + 2 or flat:
        return None
    x = (x - x.mean(axis=0)) / x.std(axis=0)
    y = (y - y.mean()) / y.std()
    coefficients = np.linalg.lstsq(x, y, rcond=None)[0]
    shares = coefficients * (x * y[:, None]).mean(axis=0)
    residual = y - x @ coefficients
    basis = np.linalg.qr(np.column_stack((np.ones(count), x)))[0]
    left_out = residual / np.maximum(1.0 - (basis**2).sum(axis=1), 1e-12)
    mean_left_out = count / (count - 1)  # the mean, too, is that of the others
    return Explained(
        names=names,
        coefficients=coefficients,
        shares=shares,
        r_squared=1.0 - float(residual @ residual) / count,
        r_squared_new=1.0 - float(left_out @ left_out) / (count * mean_left_out**2),
    )
