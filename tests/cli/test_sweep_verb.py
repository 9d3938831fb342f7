"""``octant sweep``: plan, compute, resume, merge, query; bad input of every kind."""

import csv
import json

import numpy as np
import pytest

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.sweep import plan
from octant.reader_design.experiments.sweep.results import open_sweep
from octant.reader_design.showing.netcdf import read_dataset

STUDY = """
name = "small"
[room]
free_space = true
[[tag]]
id = "a"
position_m = [2.5, 1.5, 3.0]
antenna = "dipole"
[reader]
response = "isolated"
[sweep]
antenna = ["dipole", "monopole"]
gap_m = [0.005, 0.01]
"radio.channels_hz" = [[], [2.402e9, 2.48e9]]
"""
IMPOSSIBLE = STUDY.replace("gap_m = [0.005, 0.01]", "antenna_radius_m = [0.002, 0.10]")
"""Between eight plates, 2 mm from the axis, no monopole's plane fits."""


def rows_of(folder):
    with (folder / "sweep.csv").open() as file:
        return [{k: v for k, v in row.items() if k != "seconds"} for row in csv.DictReader(file)]


@pytest.fixture
def never(monkeypatch):
    def stop():
        def scored_cell(*_):
            raise AssertionError

        monkeypatch.setattr(plan, "scored_cell", scored_cell)

    return stop


def test_plan_is_shown_before_anything_is_computed(octant, study_file, tmp_path, never):
    never()
    call = octant("sweep", study_file(STUDY), "--out", tmp_path / "out", "--dry-run")
    assert call.code == 0, call.err
    lines = call.out.splitlines()
    assert lines[0] == "8 cells: antenna (2) x gap_m (2) x radio.channels_hz (2)"
    assert lines[1:3] == ["computed already: none", "to compute: 8, of them 0 that cannot be built"]
    assert lines[3].startswith("time: ")
    assert lines[5].startswith("memory: ")
    assert len(lines) == 6 + 8
    assert not (tmp_path / "out").exists()


def test_plan_of_full_wave_cells_tells_unknowns_and_what_is_refused(octant, study_file, tmp_path):
    text = STUDY.replace("isolated", "fullwave") + (
        "ground_plane_m = [0.2, 0.15]\nantenna_radius_m = [0.1, 0.07]\n"
    )
    call = octant("sweep", study_file(text), "--out", tmp_path / "out", "--dry-run")
    assert "to compute: 32, of them 8 that cannot be built" in call.out
    assert "unknowns, " in call.out
    assert "must stand on the ground plane" in call.out


def test_sweep_leaves_a_table_and_computes_nothing_twice(octant, study_file, tmp_path, never):
    study, out = study_file(STUDY), tmp_path / "out"
    call = octant("sweep", study, "--out", out, "--workers", "1")
    assert call.code == 0, call.err
    assert call.out.splitlines()[0] == "8 cells: 8 done."
    before = {path.name: path.read_bytes() for path in out.rglob("*.*") if path.is_file()}
    assert len(before) == 8 + 4
    never()
    again = octant("sweep", study, "--out", out)
    assert (again.code, again.out) == (0, call.out)
    assert "is complete already" in again.err
    for name in ("sweep.nc", "report.html"):
        (out / name).write_bytes(b"\xbe damaged")
    assert octant("sweep", study, "--out", out).code == 0
    assert {path.name: path.read_bytes() for path in out.rglob("*.*") if path.is_file()} == before
    assert "computed already: 8 done" in octant("sweep", study, "--out", out, "--dry-run").out
    (out / "study.toml").write_bytes(b"\xbe damaged")
    assert octant("sweep", study, "--out", out).code == 2
    assert octant("sweep", study, "--out", out, "--force").code == 0
    assert {path.name: path.read_bytes() for path in out.rglob("*.*") if path.is_file()} == before


def test_table_has_parameters_scores_and_units(octant, study_file, tmp_path):
    octant("sweep", study_file(STUDY), "--out", tmp_path / "out", "--workers", "1", "--quiet")
    table = read_dataset(tmp_path / "out" / "sweep.nc")
    assert all("units" in v.attrs and "long_name" in v.attrs for v in table.variables.values())
    assert table["gap_m"].attrs["units"] == "m"
    assert table.sizes == {"cell": 8, "surrounding": 2}
    rows = rows_of(tmp_path / "out")
    for i, row in enumerate(rows):
        assert row["antenna"] == table["antenna"].values[i]
        assert float(row["gap_m"]) == table["gap_m"].values[i]
        assert json.loads(row["radio.channels_hz"]) in ([], [2.402e9, 2.48e9])
        assert float(row["free_level_median_dbm"]) == table["level_median_dbm"].values[i, 0]
        assert row["room_level_median_dbm"] == ""
    cell = next(open_sweep(tmp_path / "out").query({"antenna": "monopole"}).cells())
    assert cell["free_rss_w"].dims == ("distance", "azimuth", "antenna")


def test_query_takes_values_ranges_and_lists(octant, study_file, tmp_path):
    octant("sweep", study_file(STUDY), "--out", tmp_path / "out", "--workers", "1", "--quiet")
    sweep = open_sweep(tmp_path / "out")
    assert sweep.parameters == ("antenna", "gap_m", "radio.channels_hz")
    assert len(sweep.query({})) == 8
    assert len(sweep.query({"antenna": "dipole", "gap_m": (0.006, 0.01)})) == 2
    assert len(sweep.query({"gap_m": [0.005, 0.01], "status": "done"})) == 8
    assert len(sweep.query({"gap_m": 0.007})) == 0
    hopping = sweep.query({"radio.channels_hz": [[2.402e9, 2.48e9]], "gap_m": 0.01})
    assert hopping.table["cell"].values.tolist() == [3, 7]
    assert np.isfinite(hopping.table["right_share"].values[:, 0]).all()
    with pytest.raises(ConfigError, match="'gap_m'"):
        sweep.query({"gapm": 1.0})
    with pytest.raises(ConfigError, match="--merge"):
        open_sweep(tmp_path)


def test_infeasible_cells_give_exit_code_3_and_are_not_tried_again(
    octant, study_file, tmp_path, never
):
    study, out = study_file(IMPOSSIBLE), tmp_path / "out"
    call = octant("sweep", study, "--out", out, "--workers", "1")
    assert call.code == 3, call.err
    assert call.out.splitlines()[0] == "8 cells: 6 done, 2 infeasible."
    assert "No scores for monopole r_a = 0.2 cm" in call.out
    assert [row["status"] for row in rows_of(out)].count("infeasible") == 2
    never()
    again = octant("sweep", study, "--out", out, "--workers", "1")
    assert (again.code, again.out) == (3, call.out)


def test_a_value_with_which_no_reader_can_be_built_is_a_cell_with_that_result(
    octant, study_file, tmp_path
):
    text = STUDY.replace("gap_m = [0.005, 0.01]", "antenna_radius_m = [0.1, 0.3]")
    call = octant("sweep", study_file(text), "--out", tmp_path / "out")
    assert call.code == 3, call.err
    told = {
        row["antenna_radius_m"]: (row["status"], row["reason"]) for row in rows_of(tmp_path / "out")
    }
    assert told["0.1"] == ("done", "")
    assert told["0.3"][0] == "infeasible"
    assert "must stand on the ground plane" in told["0.3"][1]


def test_unexpected_failures_are_in_the_table_and_pass(octant, study_file, tmp_path, monkeypatch):
    real = plan.scored_cell

    def broken(setting):
        if setting.reader.antenna == "monopole":
            raise MemoryError
        return real(setting)

    monkeypatch.setattr(plan, "scored_cell", broken)
    study, out = study_file(STUDY), tmp_path / "out"
    call = octant("sweep", study, "--out", out, "--workers", "1")
    assert (call.code, call.out.splitlines()[0]) == (3, "8 cells: 4 done, 4 failed.")
    assert "MemoryError" in rows_of(out)[-1]["reason"]
    monkeypatch.undo()
    assert octant("sweep", study, "--out", out, "--workers", "1").code == 0


def test_interruption_keeps_the_table_of_what_is_there(octant, study_file, tmp_path, monkeypatch):
    real, done = plan.scored_cell, []

    def interrupted(setting):
        if len(done) == 3:
            raise KeyboardInterrupt
        done.append(setting)
        return real(setting)

    monkeypatch.setattr(plan, "scored_cell", interrupted)
    study, out = study_file(STUDY), tmp_path / "out"
    call = octant("sweep", study, "--out", out, "--workers", "1", "--quiet")
    assert call.code == 130
    assert "goes on from there" in call.err
    assert [row["status"] for row in rows_of(out)] == ["done"] * 3 + ["missing"] * 5
    monkeypatch.undo()
    (out / "sweep.nc").unlink()
    merged = octant("sweep", study, "--out", out, "--merge")
    assert (merged.code, merged.out.splitlines()[0]) == (0, "8 cells: 5 missing, 3 done.")
    assert octant("sweep", study, "--out", out, "--workers", "1").code == 0


def test_folder_of_another_sweep_is_taken_by_force_only(octant, study_file, tmp_path, monkeypatch):
    out = tmp_path / "out"
    octant("sweep", study_file(STUDY), "--out", out, "--workers", "1", "--quiet")
    wider = study_file(STUDY.replace("[0.005, 0.01]", "[0.005, 0.01, 0.02]"), "wider.toml")
    assert "--force" in octant("sweep", wider, "--out", out).refused()
    computed = []
    real = plan.scored_cell
    monkeypatch.setattr(plan, "scored_cell", lambda *a: computed.append(a) or real(*a))
    assert octant("sweep", wider, "--out", out, "--workers", "1", "--force").code == 0
    assert len(computed) == 4
    assert len(rows_of(out)) == 12


@pytest.mark.parametrize(
    ("options", "part"),
    [
        (("--cluster", "127.0.0.1:9"), "does not answer"),
        (("--cluster", "nowhere"), "HOST:PORT"),
        (("--cluster", "local:many"), "local:2"),
        (("--cluster", "local:2", "--workers", "2"), "one of them"),
        (("--workers", "0"), "--workers"),
    ],
)
def test_wrong_crews_are_refused_before_anything_is_written(
    octant, study_file, tmp_path, options, part
):
    if part in ("does not answer", "HOST:PORT", "local:2"):
        pytest.importorskip("distributed")
    out = tmp_path / "out"
    assert part in octant("sweep", study_file(STUDY), "--out", out, *options).refused()
    assert not out.exists()


def test_missing_dask_names_the_extra(octant, study_file, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    call = octant("sweep", study_file(STUDY), "--out", tmp_path / "out", "--cluster", "local:2")
    assert "octant[cluster]" in call.refused()


@pytest.mark.parametrize(
    ("sweep", "part"),
    [("gapm = [1]", "'gap_m'"), ("gap_m = []", "empty list"), ("gap_m = [-1]", "a number from")],
)
def test_wrong_sweeps_are_refused(octant, study_file, tmp_path, sweep, part):
    text = STUDY[: STUDY.index("antenna = [")] + sweep
    assert part in octant("sweep", study_file(text), "--out", tmp_path / "out").refused()


def test_output_that_is_a_file_is_refused(octant, study_file, tmp_path):
    (tmp_path / "out").write_text("mine")
    call = octant("sweep", study_file(STUDY), "--out", tmp_path / "out", "--workers", "1")
    assert "is a file" in call.refused()
