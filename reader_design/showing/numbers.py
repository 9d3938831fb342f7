"""Numbers rounded as a person would: as many digits as the unit deserves."""

import math

DECIMALS = {"dB": 2, "dBm": 1, "°": 1, "deg": 1, "m": 3, "mm": 1, "%": 0, "1": 3}
"""Decimals by unit [-]; other units get three significant digits."""


def rounded(value: float, unit: str) -> str:
    """Return a number as a person would write it, a dash where it is undefined.

    Parameters
    ----------
    value, unit : The number, and its unit.
    """
    if not math.isfinite(value):
        return "–"
    decimals = DECIMALS.get(unit)
    return f"{value:.3g}" if decimals is None else f"{value:.{decimals}f}"


def with_interval(value: float, *, low: float, high: float, unit: str) -> str:
    """Return a number with its interval, which is left out where it is narrower than the rounding.

    Parameters
    ----------
    value, low, high, unit : The number, the ends of its interval, and their unit.
    """
    shown, ends = rounded(value, unit), (rounded(low, unit), rounded(high, unit))
    return shown if set(ends) == {shown} else f"{shown} ({ends[0]} to {ends[1]})"


def with_doubt(value: float, doubt: float, *, decimals: int = 2) -> str:
    """Return a signed number with its doubt, which is left out where it rounds to nothing.

    Parameters
    ----------
    value, doubt, decimals : The number, how far off it may be, and the decimals of both [-].
    """
    off = f"{doubt:.{decimals}f}"
    return f"{value:+.{decimals}f}" + ("" if float(off) == 0.0 else f" ± {off}")
