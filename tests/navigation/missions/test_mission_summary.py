import csv
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from thesis_robot import thesis_robot

from octant.geometries.errors import NavigationError
from octant.navigation.missions.metrics import measure
from octant.navigation.missions.run import run_missions
from octant.navigation.missions.summary import (
    bootstrap_interval,
    summarise,
    summary_sentences,
    wilson_interval,
    write_summary_csv,
)
from octant.navigation.robot.drive import DifferentialDrive


@pytest.mark.parametrize(("successes", "trials"), [(0, 10), (3, 10), (95, 100), (100, 100)])
def test_wilsons_interval_is_scipys(successes, trials):
    theirs = stats.binomtest(successes, trials).proportion_ci(0.95, method="wilson")
    assert wilson_interval(successes, trials) == pytest.approx((theirs.low, theirs.high), abs=1e-12)


def test_the_bootstrap_covers_the_median_about_as_often_as_it_says():
    rng = np.random.default_rng(0)
    covered = 0
    for _ in range(200):
        low, high = bootstrap_interval(
            rng.normal(1.0, 0.3, 40), lambda drawn: np.median(drawn, axis=-1), rng
        )
        covered += low <= 1.0 <= high
    assert 180 <= covered <= 198


def test_a_summary_says_what_the_runs_were(thesis_setup, tmp_path):
    mission, sensor = thesis_setup(noise_db=1.0)
    short = replace(mission, max_time_s=60.0)
    runs = run_missions(
        short, sensor, thesis_robot(short, sensor), DifferentialDrive(), runs=6, seed=1
    )
    metrics = [measure(run) for run in runs]
    summary = summarise(metrics)
    rmse = summary.named("rmse_median")
    assert rmse.value == np.median([m.rmse_m for m in metrics])
    assert rmse.low <= rmse.value <= rmse.high
    assert summary.named("success").value == 0.0
    assert summary.outcomes == (("time-out", 6),)
    assert summary.named("arrival_1_median").runs == 6
    assert (summary.arrivals[3].runs, np.isnan(summary.arrivals[3].value)) == (0, True)
    assert summarise(metrics).medians == summary.medians
    path = tmp_path / "missions_summary.csv"
    write_summary_csv(path, summary)
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert float(next(r for r in rows if r["quantity"] == "rmse_median")["high"]) == rmse.high
    text = " ".join(summary_sentences(summary))
    assert "0 of 6 runs reached every tag" in text
    assert "6 x time-out" in text


def test_what_cannot_be_summarised_is_refused():
    for successes, trials in ((0, 0), (3, 2)):
        with pytest.raises(NavigationError, match="is no share"):
            wilson_interval(successes, trials)
    with pytest.raises(NavigationError, match="no share"):
        summarise([])
    with pytest.raises(NavigationError, match="needs values"):
        bootstrap_interval([], np.median, np.random.default_rng(0))
