"""What many runs of a mission say together: shares and medians, each with how sure they are."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.csv_files import number_text, write_csv
from octant.navigation.missions.metrics import MissionMetrics

FloatArray = npt.NDArray[np.float64]

SUMMARY_COLUMNS = ("quantity", "unit", "runs", "value", "low", "high")
"""Columns of missions_summary.csv: the ends of the 95 % confidence interval are the last two."""

_Z_95 = 1.959963984540054
_RESAMPLES = 2000
_SEED = 20_261_122


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """Return a number with its 95 % confidence interval.

    Parameters
    ----------
    quantity : str
        What it is.
    unit : str
        Its unit, "1" for a share.
    runs : int
        Number of values that it comes from.
    value : float
        The number [in its unit]; NaN without values.
    low, high : float
        Ends of the interval [in its unit].
    """

    quantity: str
    unit: str
    runs: int
    value: float
    low: float
    high: float


def wilson_interval(successes: int, trials: int) -> tuple[float, float]:
    """Return the 95 % confidence interval of a probability.

    Parameters
    ----------
    successes : int
        Number of successes.
    trials : int
        Number of trials.

    Returns
    -------
    tuple of float
        Lower and upper end on [0, 1] [-].

    Raises
    ------
    NavigationError
        When there is no trial, or more successes than trials.

    Notes
    -----
    Wilson's score interval (1927): (p + z²/2n ± z sqrt(p(1 - p)/n + z²/4n²)) / (1 + z²/n). Unlike
    the normal approximation it is right for shares of 0 and 1: 100 of 100 gives 0.963 to 1.
    """
    if not (trials > 0 and 0 <= successes <= trials):
        msg = (
            f"{successes} successes of {trials} trials is no share: give one trial or more, and no "
            "more successes than trials."
        )
        raise NavigationError(msg)
    share, z2 = successes / trials, _Z_95**2
    middle = share + z2 / (2.0 * trials)
    half = _Z_95 * math.sqrt(share * (1.0 - share) / trials + z2 / (4.0 * trials**2))
    scale = 1.0 + z2 / trials
    return max(0.0, (middle - half) / scale), min(1.0, (middle + half) / scale)


def bootstrap_interval(
    values: npt.ArrayLike,
    statistic: Callable[[FloatArray], FloatArray],
    rng: np.random.Generator,
) -> tuple[float, float]:
    """Return the 95 % confidence interval of a statistic by the percentile bootstrap.

    Parameters
    ----------
    values : (m,) float64
        One value a run [in its unit].
    statistic : callable
        (..., m) values -> (...) numbers [in the same unit].
    rng : numpy.random.Generator
        Source of the 2000 resamples.

    Returns
    -------
    tuple of float
        2.5 % and 97.5 % percentile of the resampled statistic [in the unit]; too narrow below
        about 15 values.

    Raises
    ------
    NavigationError
        When there are no values.

    Notes
    -----
    Efron (1979).
    """
    given = np.asarray(values, dtype=np.float64)
    if not given.size:
        msg = "an interval needs values, but there are none: give one or more."
        raise NavigationError(msg)
    drawn = given[rng.integers(0, given.size, (_RESAMPLES, given.size))]
    low, high = np.percentile(statistic(drawn), [2.5, 97.5])
    return float(low), float(high)


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionSummary:
    """Return what many runs say together; made by `summarise`.

    Parameters
    ----------
    runs : int
        Number of runs.
    shares : tuple of Estimate
        Shares of the runs: success, captures, collisions, near misses.
    medians : tuple of Estimate
        Median and 90 % percentile of time [s], way, RMSE and errors [m], [deg] over the runs.
    arrivals : tuple of Estimate
        Median distance from each tag's point on arrival [m], in the order of the visit.
    outcomes : tuple of (str, int)
        How the runs ended, and how often, the most frequent first [runs].
    """

    runs: int
    shares: tuple[Estimate, ...]
    medians: tuple[Estimate, ...]
    arrivals: tuple[Estimate, ...]
    outcomes: tuple[tuple[str, int], ...]

    def named(self, quantity: str) -> Estimate:
        """Return one of the estimates.

        Parameters
        ----------
        quantity : str
            Its name.

        Returns
        -------
        Estimate
            The first one of that name.

        Raises
        ------
        NavigationError
            When there is none.
        """
        every = (*self.shares, *self.medians, *self.arrivals)
        for estimate in every:
            if estimate.quantity == quantity:
                return estimate
        msg = f"the summary has no {quantity!r}, it has {[e.quantity for e in every]}: take one."
        raise NavigationError(msg)


def summarise(metrics: Sequence[MissionMetrics]) -> MissionSummary:
    """Return what many runs of one mission say together.

    Parameters
    ----------
    metrics : sequence of MissionMetrics
        Of every run.

    Returns
    -------
    MissionSummary
        Shares with Wilson's intervals, medians with the bootstrap's; the same bits for the same
        runs.

    Raises
    ------
    NavigationError
        When there are no runs.
    """
    runs = len(metrics)
    rng = np.random.default_rng(_SEED)

    def share(quantity: str, flags: Sequence[bool]) -> Estimate:
        low, high = wilson_interval(sum(flags), runs)
        return Estimate(
            quantity=quantity, unit="1", runs=runs, value=sum(flags) / runs, low=low, high=high
        )

    def percentile(quantity: str, unit: str, values: FloatArray, percent: float) -> Estimate:
        kept = values[np.isfinite(values)]
        if not kept.size:
            nan = math.nan
            return Estimate(quantity=quantity, unit=unit, runs=0, value=nan, low=nan, high=nan)

        def statistic(drawn: FloatArray) -> FloatArray:
            return np.asarray(np.percentile(drawn, percent, axis=-1))

        low, high = bootstrap_interval(kept, statistic, rng)
        return Estimate(
            quantity=quantity,
            unit=unit,
            runs=len(kept),
            value=float(statistic(kept)),
            low=low,
            high=high,
        )

    shares = tuple(
        share(name, [bool(getattr(m, name)) for m in metrics])
        for name in ("success", "captured", "collided", "near_miss")
    )
    columns = (
        ("time", "s", np.array([m.time_s for m in metrics])),
        ("path", "m", np.array([m.path_m for m in metrics])),
        ("rmse", "m", np.array([m.rmse_m for m in metrics])),
        ("p90_position", "m", np.array([m.p90_position_m for m in metrics])),
        ("p90_heading", "deg", np.degrees([m.p90_heading_rad for m in metrics])),
    )
    arrivals = np.array([m.arrival_errors_m for m in metrics])
    ends = [m.outcome for m in metrics]
    return MissionSummary(
        runs=runs,
        shares=shares,
        medians=tuple(
            percentile(f"{name}_{label}", unit, values, percent)
            for name, unit, values in columns
            for label, percent in (("median", 50.0), ("p90", 90.0))
        ),
        arrivals=tuple(
            percentile(f"arrival_{k + 1}_median", "m", arrivals[:, k], 50.0)
            for k in range(arrivals.shape[1])
        ),
        outcomes=tuple(sorted(((e, ends.count(e)) for e in dict.fromkeys(ends)), key=_by_count)),
    )


def summary_sentences(summary: MissionSummary) -> Iterator[str]:
    """Yield sentences that say what the runs showed [m], [s].

    Parameters
    ----------
    summary : MissionSummary
        From `summarise`.

    Yields
    ------
    str
        One sentence each.
    """
    success, captured, collided, near = summary.shares
    yield (
        f"{round(success.value * summary.runs)} of {summary.runs} runs reached every tag "
        f"({_percent(success)})."
    )
    rmse, time, path = (summary.named(f"{name}_median") for name in ("rmse", "time", "path"))
    yield (
        f"The median RMSE to the straight segments is {rmse.value:.3f} m (95 % confidence "
        f"{rmse.low:.3f} to {rmse.high:.3f} m), the median run takes {time.value:.0f} s and "
        f"{path.value:.1f} m."
    )
    places = ", ".join(f"{a.value:.2f}" for a in summary.arrivals)
    yield f"The median distances from the tags' points on arrival are {places} m."
    yield (
        f"Captured by a wrong place: {_percent(captured)}; touched an obstacle: "
        f"{_percent(collided)}; near misses: {_percent(near)}."
    )
    yield "The runs ended: " + ", ".join(f"{n} x {end}" for end, n in summary.outcomes) + "."


def write_summary_csv(path: str | Path, summary: MissionSummary) -> None:
    """Write one row for each number of a summary; return nothing.

    Parameters
    ----------
    path : str or Path
        File to write; an existing one is replaced in one move.
    summary : MissionSummary
        From `summarise` [s], [m], [deg].
    """
    rows = [
        (e.quantity, e.unit, e.runs, number_text(e.value), number_text(e.low), number_text(e.high))
        for e in (*summary.shares, *summary.medians, *summary.arrivals)
    ]
    write_csv(Path(path), SUMMARY_COLUMNS, rows)


def _percent(share: Estimate) -> str:
    return (
        f"{100.0 * share.value:.0f} %, 95 % confidence {100.0 * share.low:.0f} to "
        f"{100.0 * share.high:.0f} %"
    )


def _by_count(end: tuple[str, int]) -> tuple[int, str]:
    return -end[1], end[0]
