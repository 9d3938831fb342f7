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
    reasons : Why runs did not reach every tag, each with its tag, and how often, likewise [runs].
    """

    runs: int
    shares: tuple[Estimate, ...]
    medians: tuple[Estimate, ...]
    arrivals: tuple[Estimate, ...]
    outcomes: tuple[tuple[str, int], ...]
    reasons: tuple[tuple[str, int], ...]

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
        outcomes=_counted([m.verdict for m in metrics]),
        reasons=_counted([m.reason for m in metrics if not m.success]),
    )


def summary_sentences(summary: MissionSummary) -> Iterator[str]:
    """Yield sentences that say what the runs showed [cm], [m], [s]; errors of successes come first.

    Parameters
    ----------
    summary : From `summarise`.
    """
    success, captured, collided, near = summary.shares
    reached = round(success.value * summary.runs)
    runs = f"{summary.runs} run{'' if summary.runs == 1 else 's'}"
    yield f"{reached} of {runs} reached every tag ({_percent(success)})."
    if reached:
        yield f"{_medians(summary, 'success_', f'the {reached} that reached every tag')}."
    if reached < summary.runs:
        reasons = ", ".join(f"{count} x {reason}" for reason, count in summary.reasons)
        yield f"{'The others' if reached else 'What happened'}: {reasons}."
        yield f"{_medians(summary, '', f'all {runs}')}."
    flags = (
        (captured, "took a wrong place for a tag, or were held there"),
        (collided, "touched an obstacle"),
        (near, "passed a tag that they missed"),
    )
    for share, what in flags:
        if share.value > 0.0:
            count = round(share.value * summary.runs)
            yield f"{count} of {runs} {what} ({_percent(share)})."


def _medians(summary: MissionSummary, which: str, over: str) -> str:
    """Return the medians over some runs, numbers with their units, without the full stop."""
    rmse, time, path, place, heading = (
        summary.named(f"{name}_{which}median")
        for name in ("rmse", "time", "path", "p90_position", "p90_heading")
    )
    half = len(summary.arrivals) // 2
    arrivals = summary.arrivals[half:] if which else summary.arrivals[:half]
    off, low, high, within = (
        length_text(value) for value in (rmse.value, rmse.low, rmse.high, place.value)
    )
    text = (
        f"Medians over {over}: {off} (rms) from the straight way (95 % confidence: {low} to "
        f"{high}), 90 % of the time within {within} and {heading.value:.0f}°; "
        f"{time.value:.0f} s for {path.value:.1f} m"
    )
    if all(math.isnan(a.value) for a in arrivals):
        return f"{text}; no tag was declared reached"
    places = ", ".join("–" if math.isnan(a.value) else length_text(a.value) for a in arrivals)
    return f"{text}; from the tags' points on arrival {places}"


def length_text(length_m: float) -> str:
    """Return a length as a person would say it: in centimetres, from a metre on in metres.

    Parameters
    ----------
    length_m : The length [m].
    """
    if length_m >= 1.0:
        return f"{length_m:.2f} m"
    return f"{100.0 * length_m:.2g} cm" if length_m < 0.1 else f"{100.0 * length_m:.0f} cm"


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
    return f"95 % confidence: {100.0 * share.low:.0f} to {100.0 * share.high:.0f} %"


def _counted(words: Sequence[str]) -> tuple[tuple[str, int], ...]:
    """Return each text once and how often it stands there, the most frequent first."""
    counts = ((word, words.count(word)) for word in dict.fromkeys(words))
    return tuple(sorted(counts, key=lambda counted: (-counted[1], counted[0])))
