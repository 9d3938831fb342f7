"""Slopes by derivatives: against whole solutions, and beside readers that are built."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from octant.em.reader.cache import loaded_solution
from octant.em.reader.fullwave.basis import best_basis
from octant.em.reader.fullwave.far_field import band_limited, current_samples
from octant.em.reader.fullwave.linear_solve import solve_currents
from octant.em.reader.fullwave.loads import UnloadedReader
from octant.em.reader.fullwave.mesh import reader_meshes
from octant.em.reader.fullwave.rwg import impedance_matrix
from octant.em.reader.fullwave.solve import excitations
from octant.geometries.build_errors import common_errors, tilt_of_lean
from octant.reader_design.experiments.tolerance.cases import (
    ToleranceContext,
    compute_case,
    scores_of,
)
from octant.reader_design.experiments.tolerance.linear import STEPS, amounts_of, single_steps
from octant.reader_design.experiments.tolerance.page import tolerance_section
from octant.reader_design.experiments.tolerance.results import tolerance_dataset
from octant.reader_design.experiments.tolerance.run import tolerance_cost
from octant.reader_design.experiments.tolerance.sensitivity import (
    TangentCase,
    parameters_of,
    sensitivity_cases,
    slopes,
    tangent_scores,
)
from octant.reader_design.experiments.tolerance.study import planned, run_tolerance_study
from octant.reader_design.experiments.tolerance.views import views
from octant.reader_design.setting.setting import Sampling, build_setting
from octant.reader_design.study_file.loading import parse_study

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
[tolerance]
samples = 3
slopes = "derivatives"
distances_m = [1.0, 3.0]
position_m = 0.0002
angle_deg = 0.2
gap_m = 0.0002
antenna_length_m = 0.0002
plate_height_m = 0.0002
ground_plane_m = 0.0002
common = { antenna_length_m = 0.001, antenna_radius_m = 0.0, gap_m = 0.0, plate_height_m = 0.0 }
"""
SPARSE = Sampling(free_azimuths=4, room_azimuths=2, room_spacing_m=1.5)


@pytest.fixture
def study(tmp_path):
    return parse_study(STUDY, source="small.toml", directory=tmp_path)


def context_of(study):
    setting = build_setting(study, sampling=SPARSE)
    return ToleranceContext(setting=setting, distances_m=(1.0, 3.0), room=False, reference="A")


def whole_scores(context, drawn, mesh):
    """Return the scores of a whole solution on moved corners, integrated as the drawing is."""
    study = context.study
    frequency_hz = study.radio.frequency_hz
    basis = best_basis(drawn.vertices_m, drawn.faces, (1,))
    moved = replace(basis, vertices_m=mesh.vertices_m)
    driving = excitations(moved, mesh)
    matrix = impedance_matrix(moved, frequency_hz=frequency_hz, drawn=basis)
    currents = solve_currents(moved, matrix, driving)
    samples = current_samples(moved, moved.half_coefficients(currents), frequency_hz=frequency_hz)
    ports = UnloadedReader(
        frequency_hz=frequency_hz,
        admittance_s=np.einsum("ism,jsm->ij", driving, currents),
        heat_s=np.zeros((3, 3), dtype=complex),
        shorted_v=band_limited(samples, order=20),
        phase_centres_m=mesh.phase_centres_m,
        unknowns=0,
    )
    done = loaded_solution(ports, study.reader.body(), load_ohm=study.reader.load_ohm)
    return scores_of(context, (done.response,))


def test_slopes_by_derivatives_are_those_of_whole_solutions(study):
    context, design = context_of(study), study.reader
    parameters = tuple(
        replace(p, step=0.02)  # what is left of third order is 1e-6
        for p in parameters_of(design)
        if p.name in {"antenna length", "h_p"}
    )
    around = tangent_scores(context, TangentCase(design=design, parameters=parameters)).around
    shown = views((1.0, 3.0), room=False)
    found = {(s.parameter, s.score): s.central for s in slopes(parameters, shown, around)}
    fields = {"antenna length": "length_m", "h_p": "plate_height_m"}
    step_m = 1e-5
    bodies = [design.body()] + [
        design.body(common_errors(3, **{fields[p.name]: s}))
        for p in parameters
        for s in (-step_m, step_m)
    ]
    feed = design.feed()
    drawn, *moved = reader_meshes(
        bodies,
        frequency_hz=study.radio.frequency_hz,
        length_m=design.element(study.radio.frequency_hz).length_m,
        gap_m=design.gap_m,
        cells_per_wavelength=design.cells_per_wavelength,
        wire_radius_m=feed["wire_radius_m"],
        feed_gap_m=feed["feed_gap_m"],
    )
    for i, parameter in enumerate(parameters):
        low, high = (whole_scores(context, drawn, mesh) for mesh in moved[2 * i : 2 * i + 2])
        for view in shown:
            if view.name.startswith("level"):
                slope = (view.of(high) - view.of(low)) / (2.0 * step_m / 1e-3)
                assert found[parameter.name, view.name] == pytest.approx(slope, rel=1e-5)


def test_a_bend_beside_the_drawing_is_seen_as_whole_solutions_see_it(study):
    # Where two directions are nearly worst, within some hundredths of a degree.
    design = msgspec.structs.replace(
        study.reader,
        antennas=8,
        antenna_radius_m=0.10,
        plate_height_m=0.08,
        ground_plane_m=0.20,
        cells_per_wavelength=5.0,
    )
    context = context_of(msgspec.structs.replace(study, reader=design))
    parameters = tuple(p for p in parameters_of(design) if p.name == "lean sideways")
    around = tangent_scores(context, TangentCase(design=design, parameters=parameters)).around
    whole = tuple(compute_case(context, case) for case in sensitivity_cases(design, parameters))
    shown = views((1.0, 3.0), room=False)
    pairs = zip(*(slopes(parameters, shown, one) for one in (around, whole)), strict=True)
    (found, expected), *_ = [pair for pair in pairs if pair[0].score == "margin_worst_db"]
    assert expected.bends
    assert found.bends
    assert expected.down > 0.1 > -0.1 > expected.up
    assert (found.up, found.down) == pytest.approx((expected.up, expected.down), rel=0.02)


def test_errors_of_single_antennas_come_back_from_their_steps():
    random = np.random.default_rng(3)
    steps = single_steps(3)
    amounts = random.uniform(-1e-3, 1e-3, len(steps))
    whole = common_errors(3)
    for step, amount in zip(steps, amounts, strict=True):
        share = amount / step.step
        one = step.after
        tilt, towards = tilt_of_lean(share * one.lean)
        scaled = {name: share * getattr(one, name) for name in STEPS}
        whole = whole.plus(
            replace(
                common_errors(3),
                **scaled,
                tilt_rad=tilt,
                tilt_azimuth_rad=towards,
                ground_plane_m=share * one.ground_plane_m,
            )
        )
    np.testing.assert_allclose(amounts_of(whole), amounts, rtol=1e-9)


def test_the_forecast_counts_the_derivatives_by_every_error(study):
    table = msgspec.structs.replace(study.tolerance, slopes="differences")
    plain = tolerance_cost(msgspec.structs.replace(study, tolerance=table))
    assert planned(study).slopes == 2
    assert "11 readers' worth of derivatives" in tolerance_cost(study).text()
    assert "derivatives" not in plain.text()


@pytest.mark.slow
def test_a_linear_estimate_is_that_of_built_readers_where_errors_are_small(study, tmp_path):
    result = run_tolerance_study(study, tmp_path / "cases", samples=6, sampling=SPARSE)
    assert len(list((tmp_path / "cases").glob("*.msgpack"))) == 9
    for at, view in enumerate(result.shown):
        linear, built = result.linear[:6, at], result.chosen.values[:, at]
        if not view.name.endswith("share"):
            assert np.ptp(built) > 0.01
            off = np.abs(linear - built).max()
            assert off < 0.1 * np.abs(built - view.of(result.chosen.nominal)).max(), view.name
    assert "linear_level_3m_dbm" in tolerance_dataset(result)
    (table,) = [t for t in tolerance_section(result).tables if "linear in" in t.caption]
    assert any("level at 3 m" in row[0] for row in table.rows)
