"""What many runs of a mission say together: shares and medians, each with how sure they are."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import NavigationError
from octant.navigation.csv_files import number_text, write_csv
from octant.navigation.missions.metrics import MissionMetrics
from octant.navigation.statistics import Interval, bootstrap_rng, quantiles, wilson

FloatArray = npt.NDArray[np.float64]

SUMMARY_COLUMNS = ("quantity", "unit", "runs", "value", "low", "high")
"""Columns of missions_summary.csv: the ends of the 95 % confidence interval are the last two."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate(Interval):
    """A named number with its 95 % confidence interval; NaN without values.

    Parameters
    ----------
    value, low, high : As of `Interval` [its unit].
    quantity : What it is.
    unit : Its unit, "1" for a share.
    runs : Number of values that it comes from.
    """

    quantity: str
    unit: str
    runs: int


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionSummary:
    """What many runs say together; made by `summarise`.

    Parameters
    ----------
    runs : Number of runs.
    shares : Shares of the runs: success, captures, collisions, near misses.
    medians : Median and 90 % percentile of time [s], way, RMSE and errors [m], [deg]: over all
        runs, then over those that reached every tag (`success_` in the name).
    arrivals : Median distance from each tag's point on arrival [m], in the order of the visit; the
        same.
    outcomes : Verdicts on the runs, and how often, the most frequent first; they add up [runs].
    """

    runs: int
    shares: tuple[Estimate, ...]
    medians: tuple[Estimate, ...]
    arrivals: tuple[Estimate, ...]
    outcomes: tuple[tuple[str, int], ...]

    def named(self, quantity: str) -> Estimate:
        """Return the first estimate of a name.

        Parameters
        ----------
        quantity : Its name.
        """
        every = (*self.shares, *self.medians, *self.arrivals)
        for estimate in every:
            if estimate.quantity == quantity:
                return estimate
        msg = f"the summary has no {quantity!r}, it has {[e.quantity for e in every]}: take one."
        raise NavigationError(msg)


def summarise(metrics: Sequence[MissionMetrics]) -> MissionSummary:
    """Return what many runs of one mission show together; the same bits for the same runs.

    Parameters
    ----------
    metrics : Of every run.
    """
    runs = len(metrics)
    rng = bootstrap_rng()

    def estimate(quantity: str, unit: str, runs: int, interval: Interval) -> Estimate:
        return Estimate(quantity=quantity, unit=unit, runs=runs, **asdict(interval))

    def share(quantity: str, flags: Sequence[bool]) -> Estimate:
        return estimate(quantity, "1", runs, wilson(sum(flags), runs))

    def quantile(quantity: str, unit: str, values: FloatArray, probability: float) -> Estimate:
        kept = values[np.isfinite(values)]
        if not kept.size:
            nowhere = Interval(value=math.nan, low=math.nan, high=math.nan)
            return estimate(quantity, unit, 0, nowhere)
        (interval,) = quantiles(kept, (probability,), rng)
        return estimate(quantity, unit, len(kept), interval)

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
    among = (("", np.ones(runs, dtype=bool)), ("success_", np.array([m.success for m in metrics])))
    ends = [m.verdict for m in metrics]
    return MissionSummary(
        runs=runs,
        shares=shares,
        medians=tuple(
            quantile(f"{name}_{which}{label}", unit, values[counted], probability)
            for which, counted in among
            for name, unit, values in columns
            for label, probability in (("median", 0.5), ("p90", 0.9))
        ),
        arrivals=tuple(
            quantile(f"arrival_{k + 1}_{which}median", "m", arrivals[counted, k], 0.5)
            for which, counted in among
            for k in range(arrivals.shape[1])
        ),
        outcomes=tuple(sorted(((e, ends.count(e)) for e in dict.fromkeys(ends)), key=_by_count)),
    )


def summary_sentences(summary: MissionSummary) -> Iterator[str]:
    """Yield sentences that say what the runs showed [m], [s]; errors of successes come first.

    Parameters
    ----------
    summary : From `summarise`.
    """
    success, captured, collided, near = summary.shares
    reached = round(success.value * summary.runs)
    runs = f"{summary.runs} run{'' if summary.runs == 1 else 's'}"
    yield f"{reached} of {runs} reached every tag. Success: {_percent(success)}."
    if reached < summary.runs:
        ends = ", ".join(f"{n} x {end}" for end, n in summary.outcomes)
        yield f"The {runs}: {ends}."
    for counted, which in ((reached, "success_"), (summary.runs, "")):
        if which and not counted:
            yield "There is no error of successes, as there is no success."
            continue
        rmse, time, path, place, heading = (
            summary.named(f"{name}_{which}median")
            for name in ("rmse", "time", "path", "p90_position", "p90_heading")
        )
        over = f"the {counted} that reached every tag" if which else f"all {counted}"
        yield (
            f"Medians over {over}: RMSE to the straight segments {rmse.value:.3f} m (95 % "
            f"confidence {rmse.low:.3f} to {rmse.high:.3f} m), 90 % of the time within "
            f"{place.value:.3f} m and {heading.value:.1f} degrees; {time.value:.0f} s and "
            f"{path.value:.1f} m; from the tags' points on arrival "
            f"{_listed(summary.arrivals, which)} m."
        )
    yield (
        f"Captured by a wrong place: {_percent(captured)}; touched an obstacle: "
        f"{_percent(collided)}; near misses: {_percent(near)}."
    )


def _listed(arrivals: Sequence[Estimate], which: str) -> str:
    """Return the median of each tag, "-" where none of the runs declared it reached."""
    half = len(arrivals) // 2
    chosen = arrivals[half:] if which else arrivals[:half]
    return ", ".join("-" if math.isnan(a.value) else f"{a.value:.2f}" for a in chosen)


def write_summary_csv(path: str | Path, summary: MissionSummary) -> None:
    """Write one row for each number of a summary.

    Parameters
    ----------
    path : File to write; an existing one is replaced in one move.
    summary : From `summarise` [s], [m], [deg].
    """
    rows = [
        (e.quantity, e.unit, e.runs, number_text(e.value), number_text(e.low), number_text(e.high))
        for e in (*summary.shares, *summary.medians, *summary.arrivals)
    ]
    rows += [
        (f"verdict: {end}", "runs", summary.runs, str(count), "", "")
        for end, count in summary.outcomes
    ]
    write_csv(Path(path), SUMMARY_COLUMNS, rows)


def _percent(share: Estimate) -> str:
    return (
        f"{100.0 * share.value:.0f} %, 95 % confidence {100.0 * share.low:.0f} to "
        f"{100.0 * share.high:.0f} %"
    )


def _by_count(end: tuple[str, int]) -> tuple[int, str]:
    return -end[1], end[0]
