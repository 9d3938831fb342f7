"""``octant study``: from a study file to a report; interruption, resumption, failed designs."""

import signal
import subprocess
import sys
import time

import pytest

from octant.reader_design.showing.netcdf import read_dataset
from octant.reader_design.study_file.loading import load_study

SMALL = """
name = "small"
[room]
box_m = [4.0, 4.0, 3.0]
[[room.object]]
kind = "cabinet"
size_m = [1.0, 0.4, 1.0]
position_m = [1.5, 3.0, 0.0]
[[tag]]
id = "a"
position_m = [2.5, 1.5, 3.0]
antenna = "dipole"
[reader]
response = "isolated"
[sweep]
antenna_radius_m = [0.05, 0.10]
plate_height_m = [0.0]
[solver]
max_reflections = 1
[map]
spacing_m = 0.5
[mission]
navigator = "thesis"
start_m = [1.0, 1.0]
tags = ["a"]
max_time_s = 10.0
runs = 2
"""


def test_study_leaves_a_chosen_reader_and_a_report(octant, study_file, tmp_path):
    study, out = study_file(SMALL), tmp_path / "out"
    call = octant("study", study, "--out", out, "--quick")
    assert call.code == 0, call.err
    assert "chosen" in call.out.lower()
    assert f"Report: {out / 'report.html'}" in call.out
    assert "Mission in the study's room" in call.out
    for name in ("results.nc", "report.html", "missions.csv", "trajectory.csv", "study.toml"):
        assert (out / name).is_file(), name
    assert list((out / "figures").glob("*.png"))
    assert load_study(out / "study.toml") == load_study(study)
    data = read_dataset(out / "results.nc")
    assert all("units" in v.attrs and "long_name" in v.attrs for v in data.variables.values())
    assert data.attrs["seed"] == 1
    before = (out / "results.nc").read_bytes()
    again = octant("study", study, "--out", out, "--quick")
    assert again.code == 0
    assert again.out == call.out
    assert (out / "results.nc").read_bytes() == before
    other = study_file(SMALL + "[radio]\ntag_power_w = 2.0\n", "other.toml")
    assert "--force" in octant("study", other, "--out", out).refused()
    assert (out / "results.nc").read_bytes() == before


@pytest.mark.slow
def test_failed_designs_give_exit_code_3(octant, study_file, tmp_path):
    # Between eight plates, 2 mm from the axis, no monopole's plane fits.
    text = SMALL.replace("[0.05, 0.10]", '[0.002, 0.10]\nantenna = ["monopole"]')
    text = text.replace("plate_height_m = [0.0]", "plate_height_m = [0.05]")
    call = octant("study", study_file(text), "--out", tmp_path / "out", "--quick", "--quiet")
    assert call.code == 3, call.err
    assert "No scores for monopole r_a = 0.2 cm h_p = 5 cm: " in call.out
    assert (tmp_path / "out" / "report.html").is_file()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals differ")
def test_interrupted_studies_keep_what_was_computed(study_file, tmp_path):
    out = tmp_path / "out"
    text = SMALL.replace("[0.05, 0.10]", str([0.05 + 0.0005 * i for i in range(100)]))
    command = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler);"  # nohup
        "from octant.reader_design.cli import main; main()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", command, "study", study_file(text), "--out", out],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as child:
        deadline = time.monotonic() + 600
        while not list((out / "cells").glob("[!.]*.nc")) and time.monotonic() < deadline:
            assert child.poll() is None, child.stderr.read()
            time.sleep(0.05)
        child.send_signal(signal.SIGINT)
        _, error = child.communicate(timeout=60)
    assert child.returncode == 130
    assert error.splitlines()[-1].startswith("interrupted: what was computed is kept in")
    assert "Traceback" not in error
    cells = list((out / "cells").glob("[!.]*.nc"))
    assert cells
    for cell in cells:
        read_dataset(cell)
