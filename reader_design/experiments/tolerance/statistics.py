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
    shares : (p,) float64 — Share of the variance [-]: coefficient times correlation; their sum is
        ``r_squared``. Small negative ones are noise.
    r_squared : Share explained by all together in the sample [-].
    r_squared_new : The same for samples left out of the fit, one at a time [-]: what the fit is
        worth. Below 0 it is worth nothing.
    """

    names: tuple[str, ...]
    coefficients: FloatArray
    shares: FloatArray
    r_squared: float
    r_squared_new: float

    def by_kind(self) -> dict[str, float]:
        """Return the shares added up over what stands before the colon of a name [-].

        Returns
        -------
        dict of str to float
            Kind of error -> share, in the order of the names [-].
        """
        out: dict[str, float] = {}
        for name, share in zip(self.names, self.shares, strict=True):
            kind = name.split(":")[0]
            out[kind] = out.get(kind, 0.0) + float(share)
        return out


def explained_variance(
    names: tuple[str, ...], columns: npt.ArrayLike, values: npt.ArrayLike
) -> Explained | None:
    """Return the shares of a score's variance by standardised linear regression.

    Parameters
    ----------
    names : Regressors.
    columns : (s, p) array_like — Their values, each in a unit of its own [-].
    values : (s,) array_like — The score [its unit].

    Returns
    -------
    Explained or None
        None when there are fewer than p + 2 samples, or nothing varies.

    Notes
    -----
    Shares are Pratt's product measure beta_j r_j: for independent regressors the squared
    standardised coefficients. The left-out error is the residual over one less the leverage.

    References
    ----------
    .. [1] J. W. Pratt, Proc. 2nd Tampere Conf. in Statistics (1987) 245-260.
    .. [2] D. M. Allen, Technometrics 16 (1974) 125-127 (PRESS).
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
