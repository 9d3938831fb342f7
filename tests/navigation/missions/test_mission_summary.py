import csv
from dataclasses import replace

import numpy as np
import pytest
from thesis_robot import thesis_robot

from octant.geometries.errors import NavigationError
from octant.navigation.missions.metrics import measure
from octant.navigation.missions.run import run_missions
from octant.navigation.missions.summary import summarise, summary_sentences, write_summary_csv
from octant.navigation.robot.drive import DifferentialDrive


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


def test_no_runs_cannot_be_summarised():
    with pytest.raises(NavigationError, match="no share"):
        summarise([])
