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
    assert repr(summarise(metrics).medians) == repr(summary.medians)  # NaN is not NaN
    path = tmp_path / "missions_summary.csv"
    write_summary_csv(path, summary)
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert float(next(r for r in rows if r["quantity"] == "rmse_median")["high"]) == rmse.high
    text = " ".join(summary_sentences(summary))
    assert "0 of 6 runs reached every tag" in text
    assert "6 x tag" in text
    assert "nan" not in text
    assert text.count("reached every tag") == 1


def test_errors_of_failed_runs_stand_apart_and_the_verdicts_add_up(thesis_setup, tmp_path):
    """A robot that declares a tag reached where it stands has a small error, and has failed."""
    mission, sensor = thesis_setup(noise_db=1.0)
    (run,) = run_missions(
        mission, sensor, thesis_robot(mission, sensor), DifferentialDrive(), runs=1, seed=1
    )
    good = measure(run)
    false = measure(replace(run, arrival_points_m=np.zeros((4, 2))))
    late = replace(good, success=False, outcome="time-out", rmse_m=9.0)
    summary = summarise([good, replace(false, rmse_m=0.01), late])
    assert good.success
    assert summary.named("rmse_success_median").value == good.rmse_m
    assert summary.named("rmse_success_median").runs == 1
    assert summary.named("rmse_median").runs == 3
    assert summary.named("arrival_1_success_median").value == good.arrival_errors_m[0]
    assert sum(count for _, count in summary.outcomes) == 3
    assert {end for end, _ in summary.outcomes} == {
        "reached every tag",
        "declared reached elsewhere",
        "time-out",
    }
    assert "was declared reached elsewhere" in false.reason
    text = " ".join(summary_sentences(summary))
    assert text.index("over the 1 that reached") < text.index("over all 3")
    write_summary_csv(tmp_path / "s.csv", summary)
    rows = list(csv.DictReader((tmp_path / "s.csv").read_text().splitlines()))
    assert sum(int(r["value"]) for r in rows if r["quantity"].startswith("verdict: ")) == 3
    nothing = summarise([late])
    assert nothing.named("rmse_success_median").runs == 0
    assert "over all 1 run:" in " ".join(summary_sentences(nothing))


def test_no_runs_cannot_be_summarised():
    with pytest.raises(NavigationError, match="no share"):
        summarise([])
