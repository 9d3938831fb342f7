"""What a replay leaves: a row a round, a row a tag, and the sentences that a person reads."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.navigation.csv_files import number_text, write_csv
from octant.reader_design.experiments.measured.replay import Replayed

FloatArray = npt.NDArray[np.float64]

REPLAY_COLUMNS = (
    "time_s",
    "id",
    "x_m",
    "y_m",
    "heading_deg",
    "heard",
    "bearing_deg",
    "true_bearing_deg",
    "bearing_error_deg",
    "believed_x_m",
    "believed_y_m",
    "place_error_m",
    "spread_m",
)
"""Columns of replay.csv: time [s], true pose [m], [deg], antennas that heard the tag [-], bearing
from the robot's front [deg], believed place [m]."""

SUMMARY_COLUMNS = (
    "id",
    "rounds",
    "heard_share",
    "bearing_share",
    "bearing_error_median_deg",
    "bearing_error_p90_deg",
    "bearing_bias_deg",
    "place_error_median_m",
    "place_error_final_m",
    "converged_s",
)
"""Columns of replay_summary.csv, a row a tag and one of all [-], [deg], [m], [s]."""

ALL = "all tags"


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """From when on an estimator has converged.

    Parameters
    ----------
    place_m : Error of the place that it then keeps below [m].
    bearing_rad : The same of the bearing, for those that know no place [rad].
    """

    place_m: float = 0.5
    bearing_rad: float = math.radians(30.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Summary:
    """How well an estimator did with one tag, or with all.

    Parameters
    ----------
    tag : Its id.
    rounds : Number of rounds.
    heard_share, bearing_share : Share of rounds in which any antenna heard it, and in which the
        estimator knew a bearing [-].
    median_deg, p90_deg, bias_deg : Of the bearing's error: median and 90th percentile of its size,
        and its mean direction [deg]; NaN: unknown.
    place_median_m, place_final_m : Error of the place over the second half, and at the end [m].
    converged_s : Time from the first reading until the error stays within the limit [s]; NaN:
        never, or unknown.
    """

    tag: str
    rounds: int
    heard_share: float
    bearing_share: float
    median_deg: float
    p90_deg: float
    bias_deg: float
    place_median_m: float
    place_final_m: float
    converged_s: float


def summary_of(one: Replayed, limits: Limits) -> Summary:
    """Return how well an estimator did with a tag.

    Parameters
    ----------
    one : What it said.
    limits : From when on it has converged.
    """
    error = one.bearing_error_rad
    place = one.place_error_m
    knows_place = bool(np.isfinite(place).any())
    settled = place <= limits.place_m if knows_place else np.abs(error) <= limits.bearing_rad
    half = place[len(place) // 2 :]
    return Summary(
        tag=one.tag,
        rounds=len(one.time_s),
        heard_share=float(np.mean(one.heard > 0)),
        bearing_share=float(np.mean(np.isfinite(one.bearing_rad))),
        **_errors(error),
        place_median_m=_median(half),
        place_final_m=float(place[-1]),
        converged_s=_converged_s(one.time_s, settled),
    )


def summary_of_all(found: Sequence[Replayed], limits: Limits) -> Summary:
    """Return the same over all tags: rounds together, times and ends of the tags' own medians.

    Parameters
    ----------
    found, limits : As for `summary_of`.
    """
    each = [summary_of(one, limits) for one in found]
    error = np.concatenate([one.bearing_error_rad for one in found])
    halves = [one.place_error_m[len(one.time_s) // 2 :] for one in found]
    times = np.array([one.converged_s for one in each])
    rounds = np.array([one.rounds for one in each])
    return Summary(
        tag=ALL,
        rounds=int(rounds.sum()),
        heard_share=float(np.average([one.heard_share for one in each], weights=rounds)),
        bearing_share=float(np.average([one.bearing_share for one in each], weights=rounds)),
        **_errors(error),
        place_median_m=_median(np.concatenate(halves)),
        place_final_m=_median(np.array([one.place_final_m for one in each])),
        converged_s=float(np.median(times)) if np.isfinite(times).all() else math.nan,
    )


def write_replay(path: Path, found: Sequence[Replayed]) -> None:
    """Write one row for each round, tag by tag.

    Parameters
    ----------
    path, found : The file; what was said.
    """
    rows = []
    for one in found:
        columns = np.column_stack(
            [
                one.poses[:, :2],
                np.degrees(one.poses[:, 2]),
                one.heard,
                np.degrees(one.bearing_rad),
                np.degrees(one.true_bearing_rad),
                np.degrees(one.bearing_error_rad),
                one.place_m,
                one.place_error_m,
                one.spread_m,
            ]
        )
        for time_s, row in zip(one.time_s, columns, strict=True):
            cells = [number_text(value) for value in row]
            cells[3] = f"{row[3]:.0f}"
            rows.append((number_text(time_s), one.tag, *cells))
    write_csv(path, REPLAY_COLUMNS, rows)


def write_summary(path: Path, summaries: Sequence[Summary]) -> None:
    """Write one row for each tag, and one of all.

    Parameters
    ----------
    path, summaries : The file; how well each went.
    """
    rows = (
        (
            one.tag,
            one.rounds,
            *(
                number_text(value)
                for value in (
                    one.heard_share,
                    one.bearing_share,
                    one.median_deg,
                    one.p90_deg,
                    one.bias_deg,
                    one.place_median_m,
                    one.place_final_m,
                    one.converged_s,
                )
            ),
        )
        for one in summaries
    )
    write_csv(path, SUMMARY_COLUMNS, rows)


def sentences(estimator: str, found: Sequence[Replayed], limits: Limits) -> tuple[str, ...]:
    """Return what came out, in words.

    Parameters
    ----------
    estimator, found, limits : Its name; what it said; from when on it has converged.
    """
    whole = summary_of_all(found, limits)
    each = [summary_of(one, limits) for one in found]
    first = (
        f"{estimator}: {whole.rounds} rounds of {len(found)} tags, "
        f"{100.0 * whole.heard_share:.0f} % of them heard, a bearing in "
        f"{100.0 * whole.bearing_share:.0f} %."
    )
    lines = [first]
    if math.isfinite(whole.median_deg):
        lines.append(
            f"Bearing: {whole.median_deg:.1f} deg off in the median, 90 % within "
            f"{whole.p90_deg:.0f} deg, bias {whole.bias_deg:+.1f} deg."
        )
    elif whole.bearing_share == 0.0:
        lines.append("Bearing: none; the readings do not tell directions apart.")
    else:
        lines.append("Bearing: the log has no true pose and heading to compare it with.")
    if math.isfinite(whole.place_median_m):
        what = "of the robot" if estimator == "map" else "of the tag"
        lines.append(
            f"Place {what}: {whole.place_median_m:.2f} m off in the median of the second half, "
            f"{whole.place_final_m:.2f} m at the end."
        )
    settled = [one.converged_s for one in each if math.isfinite(one.converged_s)]
    if math.isfinite(whole.median_deg) or math.isfinite(whole.place_median_m):
        limit = f"{math.degrees(limits.bearing_rad):.0f} deg"
        if any(np.isfinite(one.place_error_m).any() for one in found):
            limit = f"{limits.place_m:g} m"
        when = f", after {np.median(settled):.0f} s in the median" if settled else ""
        lines.append(f"{len(settled)} of {len(found)} tags stay within {limit} to the end{when}.")
    return tuple(lines)


def _errors(error_rad: FloatArray) -> dict[str, float]:
    known = error_rad[np.isfinite(error_rad)]
    if not known.size:
        return {"median_deg": math.nan, "p90_deg": math.nan, "bias_deg": math.nan}
    size = np.degrees(np.abs(known))
    mean = np.mean(np.exp(1j * known))
    return {
        "median_deg": float(np.median(size)),
        "p90_deg": float(np.quantile(size, 0.9)),
        "bias_deg": float(np.degrees(np.angle(mean))),
    }


def _median(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if known.size else math.nan


def _converged_s(time_s: FloatArray, settled: npt.NDArray[np.bool_]) -> float:
    """Return the time until it stays settled to the end [s]; NaN: it does not."""
    if not settled[-1]:
        return math.nan
    open_ = np.flatnonzero(~settled)
    first = int(open_[-1]) + 1 if open_.size else 0
    return float(time_s[first] - time_s[0])
