"""Running cases and whole studies: the same at any number of workers, resumed, judged right."""

import json
from dataclasses import replace

import msgspec
import numpy as np
import pytest

from octant.em.medium.materials import material
from octant.geometries.build_errors import common_errors
from octant.geometries.errors import ConfigError, GeometryError
from octant.reader_design.cli import run
from octant.reader_design.experiments.study.tolerance_stage import tolerance_stage
from octant.reader_design.experiments.tolerance import cases as cases_module
from octant.reader_design.experiments.tolerance.cases import (
    LEFT_OUT,
    Case,
    CaseScores,
    ToleranceContext,
    compute_case,
    run_cases,
    scaled_material,
)
from octant.reader_design.experiments.tolerance.draws import Deviation, as_drawn
from octant.reader_design.experiments.tolerance.results import write_results
from octant.reader_design.experiments.tolerance.study import run_tolerance_study
from octant.reader_design.keeping.keys import case_keys
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.evaluation import failed_cell
from octant.reader_design.setting.scores import score_rss
from octant.reader_design.setting.setting import Sampling, build_setting
from octant.reader_design.showing.netcdf import read_dataset
from octant.reader_design.study_file.loading import parse_study, to_toml

STUDY = """
name = "small"
seed = 4
[room]
free_space = true
[[tag]]
id = "A"
position_m = [0.0, 0.0, 3.0]
antenna = "dipole"
[reader]
antennas = 3
antenna_radius_m = 0.05
plate_height_m = 0.05
ground_plane_m = 0.12
cells_per_wavelength = 4.0
[sweep]
[tolerance]
samples = 40
[tolerance.limits]
least_margin_db = 4.0
[[tolerance.rival]]
name = "lower"
plate_height_m = 0.03
"""

SPARSE = Sampling(free_azimuths=4, room_azimuths=2, room_spacing_m=1.5)


def study_of(tmp_path, text=STUDY):
    return parse_study(text, source="small.toml", directory=tmp_path)


def context_of(study, *, room=False):
    setting = build_setting(study, sampling=SPARSE)
    return ToleranceContext(setting=setting, distances_m=(1.0, 3.0), room=room, reference="A")


def some_cases(study):
    design = study.reader
    wrong = (common_errors(3), common_errors(3, gap_m=1e-3), common_errors(3, gap_m=-0.01))
    return [Case(design=design, deviation=Deviation(build=e)) for e in wrong]


ELEMENTS = np.arange(3) * 2.0 * np.pi / 3.0
AZIMUTHS = np.arange(12) * np.pi / 6.0
BASE = score_rss(
    1e-6 * np.exp(2.0 * np.cos(AZIMUTHS[:, None] - ELEMENTS))[None], AZIMUTHS, ELEMENTS
)


def linear_model(_context, case):
    """Return scores that are linear in the errors: 5 dB + 2 dB/mm gap + 1 dB/° lean outwards."""
    build = case.deviation.build
    gap, lean = 1e3 * build.gap_m.mean(), np.degrees(np.arctan(build.lean[:, 0])).mean()
    if gap > 1.4:
        raise GeometryError("the gap is too wide.")
    rival = 1.0 if case.design.plate_height_m < 0.04 else 0.0
    free = replace(BASE, margin_worst_db=5.0 + 2.0 * gap + lean - 3.0 * rival)
    return CaseScores(free=free, levels_dbm=(-30.0, -31.0, -32.0 + gap))


@pytest.fixture
def model(monkeypatch):
    monkeypatch.setattr(cases_module, "compute_case", linear_model)


@pytest.fixture
def modelled(tmp_path, request):
    request.getfixturevalue("model")
    return run_tolerance_study(study_of(tmp_path), tmp_path / "cases")


def test_scores_are_the_same_at_any_number_of_workers(tmp_path):
    study = study_of(tmp_path)
    context, cases = context_of(study), some_cases(study)
    alone = run_cases(context, cases, tmp_path / "one")
    shared = run_cases(context, cases[::-1], tmp_path / "two", workers=2)[::-1]
    assert alone == shared
    assert alone[0].free != alone[1].free
    assert "gap_m of antenna 1 would be" in alone[2].reason


ROOM = STUDY.replace("free_space = true", 'box_m = [4.0, 4.0, 3.0]\nmaterial = "concrete"')
ROOM = ROOM.replace("[0.0, 0.0, 3.0]", "[2.0, 2.0, 2.9]") + "[solver]\nmax_reflections = 1\n"


def test_a_case_depends_on_everything_that_it_is_computed_from(tmp_path):
    def key(text=ROOM, *, case=1, **changes):
        study = study_of(tmp_path, text)
        context = replace(context_of(study, room=True), **changes)
        chosen = some_cases(study)[case]
        return case_keys(compute_case, [chosen], context=context, leave_out=LEFT_OUT)[0]

    solver = ("diffraction = true", "transmission = true", 'search = "rays"',
              'faces = "as_stored"', "max_diffractions = 2", "rays = 5000")  # fmt: skip
    texts = [ROOM + line + "\n" for line in solver]
    texts += [
        ROOM.replace("max_reflections = 1", "max_reflections = 2"),
        ROOM.replace("[reader]", "[radio]\ntag_power_w = 2.0\n[reader]"),
        ROOM.replace('"concrete"', '"wood"'),
        ROOM.replace("cells_per_wavelength = 4.0", "cells_per_wavelength = 5.0"),
    ]
    keys = [key(), key(case=0), key(case=2), key(distances_m=(1.0,)), key(room=False)]
    keys += [key(text) for text in texts]
    assert len(set(keys)) == len(keys)
    same = ROOM.replace('"small"', '"other"').replace("samples = 40", "samples = 50")
    assert key(same) == key()


def test_a_linear_model_gives_back_its_slopes_shares_and_yield(modelled):
    found = {(s.parameter, s.score): s for s in modelled.slopes}
    assert found["gap", "margin_worst_db"].central == pytest.approx(2.0, abs=1e-9)
    assert found["lean outwards", "margin_worst_db"].central == pytest.approx(1.0, abs=1e-9)
    assert found["lean sideways", "margin_worst_db"].central == pytest.approx(0.0, abs=1e-9)
    assert found["gap", "level_4m_dbm"].central == pytest.approx(1.0, abs=1e-9)
    assert not any(s.bends for s in modelled.slopes)
    index = [v.name for v in modelled.shown].index("margin_worst_db")
    explained = modelled.explained[index]
    assert explained.r_squared > 0.999
    assert explained.r_squared_new > 0.99
    # Means over three antennas: gap 2^2 (1/9 + 0.25/3), lean 4/9.
    kinds = explained.by_kind()
    gap, lean = 4.0 * (1.0 / 9.0 + 0.25 / 3.0), 4.0 / 9.0
    assert kinds["gap"] == pytest.approx(gap / (gap + lean), abs=0.15)
    chosen, rival = modelled.chosen, modelled.rivals[0]
    assert chosen.good.value == np.mean(chosen.values[:, index] >= 4.0)
    assert rival.good.value < 0.1
    assert np.allclose(chosen.values[:, index] - rival.values[:, index], 3.0)
    assert modelled.confidence[0].value == 1.0


def test_more_samples_keep_the_first_ones(tmp_path, modelled):
    study = study_of(tmp_path)
    more = run_tolerance_study(study, tmp_path / "cases", samples=50)
    assert np.array_equal(more.chosen.values[:40], modelled.chosen.values, equal_nan=True)
    assert len(more.chosen.samples) == 50


def test_the_files_hold_the_study(tmp_path, modelled):
    lines = write_results(modelled, tmp_path).paragraphs
    assert lines[0].startswith("40 readers of dipole r_a = 5 cm h_p = 5 cm were built within")
    assert "the drawing itself" not in lines[1]
    assert "4 dB; the drawing itself does not" in lines[2]
    assert "confidence the study's reader is better than lower (40 built readers)" in lines[-1]
    data = read_dataset(tmp_path / "tolerance.nc")
    assert data["margin_worst_db"].dims == ("design", "sample")
    assert np.array_equal(data["margin_worst_db"].values[0], modelled.chosen.values[:, 1])
    assert data["error_gap_m"].attrs["units"] == "m"
    assert data["error_tilt_azimuth_rad"].attrs["units"] == "rad"
    assert all(v.attrs["units"] and v.attrs["long_name"] for v in data.variables.values())
    assert json.loads(data.attrs["confidence_by_rival"])[0][0] == 1.0
    rows = (tmp_path / "tolerance.csv").read_text().splitlines()
    assert len(rows) == 1 + 2 * len(modelled.shown)
    page = (tmp_path / "report.html").read_text()
    assert "As built" in page
    assert 'src="http' not in page
    assert {p.name for p in (tmp_path / "figures").iterdir()} == {
        "distributions.png",
        "sensitivity.png",
        "variance.png",
    }


@pytest.mark.usefixtures("model")
def test_a_study_says_with_what_confidence_its_choice_beats_the_next_best(tmp_path):
    study = study_of(tmp_path, STUDY.split("[[tolerance.rival]]", maxsplit=1)[0])
    design = msgspec.structs.replace(study.reader, plate_height_m=0.03)
    section = tolerance_stage(
        study,
        failed_cell(design, "key", ""),
        folder=tmp_path / "tolerance",
        progress=Progress(quiet=True),
        workers=1,  # the model stands in for the solver in this process only
    )
    assert "better than the next best, dipole r_a = 5 cm h_p = 3 cm" in section.paragraphs[-1]
    assert "100 % (91 to 100) confidence" in section.paragraphs[-1]
    assert (tmp_path / "tolerance" / "tolerance.csv").is_file()
    bare = msgspec.structs.replace(study, tolerance=None)
    assert tolerance_stage(bare, None, folder=tmp_path, progress=Progress(quiet=True)) is None


def test_the_room_is_scored_with_other_materials_and_another_frequency(tmp_path):
    study = study_of(tmp_path, ROOM)
    context, design = context_of(study, room=True), study.reader
    drawn = as_drawn(3)

    def scored(deviation):
        return compute_case(context, Case(design=design, deviation=deviation))

    plain_scores = scored(drawn)
    walls = scored(replace(drawn, permittivity_factor=1.3, conductivity_factor=0.7))
    assert walls.free == plain_scores.free
    assert walls.room != plain_scores.room
    higher = scored(replace(drawn, frequency_factor=1.01))
    assert higher.free != plain_scores.free
    assert higher.levels_dbm[0] == pytest.approx(plain_scores.levels_dbm[0], abs=1.0)


def test_materials_scale_but_conductors_and_air_stay():
    wall = scaled_material(material("concrete"), 1.1, 2.0)
    assert wall.eps_r_a == pytest.approx(1.0 + 1.1 * (5.24 - 1.0))
    assert wall.sigma_c_s_per_m == pytest.approx(2.0 * material("concrete").sigma_c_s_per_m)
    assert scaled_material(material("pec"), 1.1, 2.0) == material("pec")
    air = scaled_material(material("air"), 1.1, 2.0)
    assert (air.eps_r_a, air.sigma_c_s_per_m) == (1.0, 0.0)


def test_the_study_file_comes_back_with_its_tolerances(tmp_path):
    study = study_of(tmp_path)
    assert study_of(tmp_path, to_toml(study)) == study
    bare = msgspec.structs.replace(study, tolerance=None)
    assert study_of(tmp_path, to_toml(bare)) == bare


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (("samples = 40", "samples = 0"), "tolerance.samples"),
        (("samples = 40", "position_m = -0.001"), "tolerance.position_m"),
        (("samples = 40", "positions_m = 0.001"), "positions_m"),
        (("samples = 40", 'distribution = "gauss"'), "tolerance.distribution"),
        (("samples = 40", "distances_m = []"), "tolerance.distances_m"),
        (("samples = 40", "room = true"), "tolerance.room is true, but the study's room is free"),
        (("samples = 40", "permittivity_percent = 5.0"), "tolerance.room is false"),
        (('name = "lower"', 'name = "lower"\nheight = 1.0'), "tolerance.rival"),
    ],
    ids=str,
)
def test_bad_tables_are_refused_with_the_key(tmp_path, change, reason):
    with pytest.raises(ConfigError, match=reason):
        study_of(tmp_path, STUDY.replace(*change))


def test_designs_that_cannot_be_built_and_other_models_are_refused(tmp_path, monkeypatch):
    text = STUDY.replace("cells_per_wavelength = 4.0", 'response = "rays"')
    with pytest.raises(ConfigError, match="only 'fullwave' knows build errors"):
        run_tolerance_study(study_of(tmp_path, text), tmp_path)
    text = STUDY.replace("plate_height_m = 0.03", "ground_plane_m = 0.08")
    monkeypatch.setattr(cases_module, "compute_case", unbuilt)
    with pytest.raises(ConfigError, match="lower cannot be built even without errors"):
        run_tolerance_study(study_of(tmp_path, text), tmp_path)


def unbuilt(context, case):
    """Refuse small ground planes, else compute by the linear model."""
    if case.design.ground_plane_m < 0.1:
        raise GeometryError("the antennas stand beyond it.")
    return linear_model(context, case)


def test_the_verb_runs_twice_refuses_another_study_and_is_interrupted(
    tmp_path, monkeypatch, capsys
):
    path, other = tmp_path / "s.toml", tmp_path / "other.toml"
    path.write_text(STUDY)
    other.write_text(STUDY.replace("seed = 4", "seed = 5"))
    out = tmp_path / "out"
    monkeypatch.setattr(cases_module, "compute_case", linear_model)
    assert run(["tolerance", str(path), "--out", str(out), "--workers", "1"]) == 0
    said = capsys.readouterr()
    assert "written:" in said.out
    files = {p: p.stat().st_mtime_ns for p in out.rglob("*.*") if p.name != "study.toml"}
    assert run(["tolerance", str(path), "--out", str(out), "--workers", "1"]) == 0
    again = capsys.readouterr()
    assert again.out == said.out
    assert "is complete already" in again.err
    assert files == {p: p.stat().st_mtime_ns for p in files}
    assert run(["tolerance", str(other), "--out", str(out), "-q"]) == 2
    assert "holds the results of another study" in capsys.readouterr().err
    assert run(["tolerance", str(path), "--out", str(out), "--dry-run"]) == 0
    assert "40 of each of 2 designs built with errors" in capsys.readouterr().out
    assert run(["tolerance", str(path), "--samples", "0", "--out", str(out)]) == 2

    monkeypatch.setattr(cases_module, "compute_case", stopped)
    fresh = tmp_path / "fresh"
    assert run(["tolerance", str(path), "--out", str(fresh), "-q", "--workers", "1"]) == 130
    assert "the same command goes on from there" in capsys.readouterr().err


def stopped(*_):
    """Behave as Ctrl-C does."""
    raise KeyboardInterrupt


SOLVED = []


def noted_model(context, case):
    """Return scores that are linear in the errors, and note the case."""
    SOLVED.append(case)
    return linear_model(context, case)


def test_the_forecast_counts_the_readers_that_are_solved(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(cases_module, "compute_case", noted_model)
    SOLVED.clear()
    file = tmp_path / "study.toml"
    file.write_text(STUDY)
    call = ["tolerance", str(file), "--samples", "3", "--out", str(tmp_path / "out")]
    assert run([*call, "--dry-run"]) == 0
    forecast = int(capsys.readouterr().out.split()[0])
    run_tolerance_study(study_of(tmp_path), tmp_path / "cases", samples=3)
    assert len(SOLVED) == forecast == 2 + 32 + 2 * 3
