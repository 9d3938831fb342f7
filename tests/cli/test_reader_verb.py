"""``octant reader``: what it prints and leaves, and what it refuses."""

import csv
import os
import re
import subprocess
import sys
import tomllib
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from octant import Reader
from octant.em.antennas.pattern_files.ffe import read_ffe
from octant.em.antennas.pattern_files.touchstone import read_touchstone

# Four antennas without plates on a coarse mesh, so that a solution takes a second.
SMALL = """
name = "small"
[room]
free_space = true
[reader]
antennas = 4
antenna_radius_m = 0.08
plate_height_m = 0.0
cells_per_wavelength = 6
load_ohm = 60.0
"""

FEED = "[reader.feed]\n"
METAL = "conductivity_s_per_m = 1e5\nroughness_factor = 1.2\n"
PROGRAM = [sys.executable, "-c", "from octant.reader_design.cli import main; main()"]


@pytest.mark.slow
def test_files_are_the_same_bytes_at_any_number_of_threads_of_linear_algebra(tmp_path):
    study, left = tmp_path / "study.toml", []
    study.write_text(SMALL.replace("plate_height_m = 0.0", "plate_height_m = 0.06"))
    for threads in ("1", "2"):
        out = tmp_path / threads
        threaded = dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), threads)
        arguments = ["reader", study, "--out", out, "--step-deg", "10", "--band", "2.3:2.5:9"]
        done = subprocess.run(
            [*PROGRAM, *map(str, arguments)],
            env={**os.environ, **threaded},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        said = done.stdout.replace(str(out), "")
        kept = {
            f.name: f.read_bytes() for f in out.iterdir() if f.suffix in {".ffe", ".s4p", ".csv"}
        }
        assert len(kept) == 6
        left.append((said, kept))
    assert left[0] == left[1]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("reader")


@pytest.fixture(scope="module")
def done(folder):
    """One call whose files all tests of this module read."""
    import contextlib
    import io

    from octant.reader_design.cli import run

    study = folder / "study.toml"
    study.write_text(SMALL)
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = run(["reader", str(study), "--out", str(folder / "out"), "--step-deg", "10"])
    assert code == 0, err.getvalue()
    return out.getvalue()


@pytest.fixture
def data(done, folder):
    assert done
    with xr.open_dataset(folder / "out" / "reader.nc", engine="h5netcdf") as data:
        yield data


def complex_of(variable):
    return variable.values[..., 0] + 1j * variable.values[..., 1]


def test_file_has_the_shape_that_the_design_document_fixes(data):
    assert data["pattern"].dims == ("antenna", "component", "theta", "phi", "part")
    assert data["impedance_ohm"].dims == ("antenna", "part")
    assert data["s_matrix"].dims == ("antenna", "antenna_2", "part")
    np.testing.assert_allclose(data["theta_deg"], np.arange(0.0, 181.0, 10.0))
    np.testing.assert_allclose(data["phi_deg"], np.arange(0.0, 361.0, 10.0))
    assert list(data["component"].values) == ["theta", "phi"]
    assert list(data["part"].values) == ["re", "im"]
    for name, item in data.variables.items():
        assert item.attrs["units"], name
        assert item.attrs["long_name"], name
    assert data.attrs["model"] == "fullwave"
    assert 'name = "small"' in data.attrs["study"]


def test_power_of_the_pattern_is_what_ports_and_balance_say(data):
    # gain integrated over the sphere = radiated share = 1 - reflected - coupled
    gain = np.abs(complex_of(data["pattern"])) ** 2
    theta = np.radians(data["theta_deg"].values)
    ring = gain.sum(axis=1)[:, :, :-1].mean(axis=2)
    share = np.trapezoid(ring * np.sin(theta), theta, axis=1) / 2.0
    s = complex_of(data["s_matrix"])
    np.testing.assert_allclose(share, 1.0 - (np.abs(s) ** 2).sum(axis=0), rtol=0.01)
    assert data.attrs["balance_error"] < 1e-3
    np.testing.assert_allclose(s, s.T, atol=1e-6)


def test_pattern_is_symmetric_and_its_phase_is_at_the_centre(data):
    # a square reader of four antennas: antenna i + 1 is antenna i turned by 90 degrees
    pattern = complex_of(data["pattern"])[..., :-1]
    np.testing.assert_allclose(pattern[1], np.roll(pattern[0], 9, axis=-1), atol=1e-6)


def test_impedance_and_s_matrix_belong_together(data):
    z = complex_of(data["impedance_ohm"])
    reflection = np.diagonal(complex_of(data["s_matrix"]))
    np.testing.assert_allclose((z - 60.0) / (z + 60.0), reflection, atol=1e-6)


def test_other_formats_hold_the_same_numbers(data, folder):
    written = read_touchstone(folder / "out" / "reader.s4p")
    np.testing.assert_allclose(written.s_matrices[0], complex_of(data["s_matrix"]), atol=1e-9)
    assert written.reference_ohm == 60.0
    assert written.frequencies_hz == [2.4e9]
    pattern = complex_of(data["pattern"])[..., :-1]
    for i in range(4):
        (table,) = read_ffe(folder / "out" / f"antenna_{i + 1}.ffe")
        np.testing.assert_allclose(table.field[:, 1:-1], pattern[i][:, 1:-1], atol=1e-6)
        assert table.kind == "realised_gain"


def test_table_tells_impedance_s_matrix_power_and_unknowns(done, data):
    z = complex_of(data["impedance_ohm"])[0]
    assert f"{z.real:.1f}{z.imag:+.1f}j" in done
    assert f"{data.attrs['unknowns']} unknowns" in done
    assert "|S| [dB]" in done
    assert "Power balance" in done
    assert "A single dipole alone" in done


def test_figures_are_there(done, folder):
    assert "figures" in done
    names = {p.name for p in (folder / "out" / "figures").iterdir()}
    assert names == {
        "element.png",
        "cuts.png",
        "gain_antenna_1.png",
        "s_matrix.png",
        "currents_antenna_1.png",
    }


@pytest.fixture(scope="module")
def band(folder):
    """The same reader over a band, the carrier in its middle."""
    from octant.reader_design.cli import run

    study = folder / "band.toml"
    study.write_text(SMALL)
    call = ["reader", str(study), "--out", str(folder / "band"), "--step-deg", "45", "-q"]
    assert run([*call, "--band", "2.3:2.5:9"]) == 0
    return folder / "band"


@pytest.mark.slow
def test_a_band_has_the_ports_at_every_frequency(band):
    written = read_touchstone(band / "reader.s4p")
    np.testing.assert_allclose(written.frequencies_hz, np.linspace(2.3e9, 2.5e9, 9), rtol=1e-12)
    with (band / "band.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 9 * 4
    z = np.array([complex(float(r["resistance_ohm"]), float(r["reactance_ohm"])) for r in rows])
    reflection = np.diagonal(written.s_matrices, axis1=1, axis2=2).ravel()
    np.testing.assert_allclose((z - 60.0) / (z + 60.0), reflection, atol=1e-6)
    level = [float(r["reflection_db"]) for r in rows]
    np.testing.assert_allclose(level, 20.0 * np.log10(np.abs(reflection)), atol=1e-6)
    shares = [float(r["radiated_share"]) + float(r["other_loads_share"]) for r in rows]
    np.testing.assert_allclose(shares, 1.0 - np.abs(reflection) ** 2, atol=2e-3)
    figures = {p.name for p in (band / "figures").iterdir()}
    over_band = {"return_loss", "smith", "isolation", "efficiency_and_gain"}
    assert {f"{name}.png" for name in over_band} <= figures


@pytest.mark.slow
def test_a_band_has_standing_waves_efficiency_and_gain(band):
    with (band / "band.csv").open() as file:
        rows = list(csv.DictReader(file))
    with xr.open_dataset(band / "reader.nc", engine="h5netcdf") as data:
        data.load()
    np.testing.assert_allclose(data["band_frequency"], np.linspace(2.3e9, 2.5e9, 9), rtol=1e-12)
    s = complex_of(data["band_s_matrix"])
    for number, row in enumerate(rows):
        at, antenna = divmod(number, 4)
        size = abs(s[at, antenna, antenna])
        assert float(row["vswr"]) == pytest.approx((1 + size) / (1 - size))
        total, taken = float(row["radiated_share"]), 1 - size**2
        assert float(row["embedded_efficiency"]) == pytest.approx(total / taken)
        assert float(row["greatest_gain_dbi"]) >= float(row["own_gain_dbi"]) - 0.05
        for column, name in (("vswr", "band_vswr"), ("margin_db", "band_margin_db")):
            assert float(row[column]) == float(data[name][at, antenna])
    # At the carrier, 2.4 GHz, it is what the patterns of reader.nc say, solved on another mesh.
    gain = (np.abs(complex_of(data["pattern"])) ** 2).sum(axis=1)[:, 2, :-1]  # horizon, by 45 deg
    own = np.array([gain[i, 2 * i] for i in range(4)])
    others = np.array([max(gain[j, 2 * i] for j in range(4) if j != i) for i in range(4)])
    found = data.sel(band_frequency=2.4e9, method="nearest")
    np.testing.assert_allclose(found["band_own_gain_dbi"], 10 * np.log10(own), atol=0.1)
    np.testing.assert_allclose(found["band_margin_db"], 10 * np.log10(own / others), atol=0.1)


def test_it_says_whether_it_is_matched_and_what_would_match(done, data):
    s = complex_of(data["s_matrix"])
    level = 20 * np.log10(np.abs(np.diagonal(s)).max())
    assert level > -10.0
    assert f"Not matched to 60 ohm: reflection up to {level:.1f} dB" in done
    assert "The best real load at that frequency is" in done
    assert "L-network at each antenna" in done
    assert "off by 5 % in the worst sense" in done


def test_the_networks_that_it_proposes_match_behind_cable_and_switch(done, folder, data):
    """What is proposed does it, and the losses behind it are in the gains."""
    line = next(line for line in done.splitlines() if "match = " in line)
    proposed = tomllib.loads(line.partition("[reader.feed] ")[2])
    keys = tomllib.loads(SMALL)["reader"]
    behind = {"cable_m": 0.5, "cable_loss_db_per_m": 1.2, "multiplexer_loss_db": 0.7}
    loss_db = 0.5 * 1.2 + 0.7
    matched = Reader(**keys, feed={**proposed, **behind, "cable_ohm": 60.0})
    solved = matched.solve(2.4e9, step_deg=10, progress=False)
    text = "\n".join(solved.lines())
    assert "Matched to 60 ohm behind matching networks, 0.5 m of cable, a multiplexer" in text
    result = solved.result()
    lossless = replace(matched.table.feeding(), cable=None, multiplexer=None).on(result)
    swing = np.abs((lossless.input_impedance_ohm - 60.0) / (lossless.input_impedance_ohm + 60.0))
    np.testing.assert_allclose(lossless.reflected_share, swing**2, rtol=1e-9)
    assert swing.max() < 0.1
    # The switch is one of 50 ohm between ends of 60: that and the losses are all that is taken.
    factor = result.radiated_share / lossless.radiated_share
    np.testing.assert_allclose(10.0 * np.log10(factor), -loss_db, atol=0.15)
    assert (lossless.radiated_share > data["radiated_share"].values).all()
    again = solved.to_touchstone(folder / "again")  # the antennas' own ports
    bare = read_touchstone(folder / "out" / "reader.s4p")
    np.testing.assert_allclose(read_touchstone(again).s_matrices, bare.s_matrices, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("place", [3, 8])
def test_a_band_is_what_single_solutions_say(band, place):
    # at the highest frequency the mesh is the same, between nodes it is interpolated
    reader = Reader(
        antennas=4,
        antenna_radius_m=0.08,
        plate_height_m=0.0,
        cells_per_wavelength=6.0,
        load_ohm=60.0,
        antenna_length_m=0.5 * 299792458.0 / 2.4e9,
    )
    written = read_touchstone(band / "reader.s4p")
    solved = reader.solve(written.frequencies_hz[place], step_deg=45.0, progress=False)
    off = np.abs(written.s_matrices[place] - solved.s.to_numpy()[0]).max()
    assert off < (1e-6 if place == 8 else 0.02)


@pytest.mark.slow
def test_the_channels_of_a_study_are_its_band(octant, study_file, tmp_path):
    text = SMALL + "[radio]\nchannels_hz = [2.48e9, 2.402e9, 2.44e9]\n"
    call = octant("reader", study_file(text), "--out", tmp_path / "out", "--step-deg", "45")
    assert call.code == 0
    assert "band.csv" in call.out
    written = read_touchstone(tmp_path / "out" / "reader.s4p")
    assert written.frequencies_hz.tolist() == [2.402e9, 2.44e9, 2.48e9]


def test_what_is_there_is_not_overwritten(octant, done, folder):
    assert "reader.nc" in done
    line = octant("reader", folder / "study.toml", "--out", folder / "out").refused()
    assert "--force" in line


@pytest.mark.slow
def test_the_same_command_finishes_what_was_interrupted(octant, done, folder):
    there = {path: path.read_bytes() for path in (folder / "out").rglob("*") if path.is_file()}
    for path in there:
        if path.name != "reader.nc":
            path.unlink()
    again = octant("reader", folder / "study.toml", "--out", folder / "out", "--step-deg", "10")
    assert (again.code, again.out) == (0, done)
    assert {path: path.read_bytes() for path in there} == there


def test_approximate_models_give_patterns_only(octant, study_file, tmp_path):
    out = tmp_path / "out"
    call = octant(
        "reader",
        study_file(SMALL),
        "--out",
        out,
        "--model",
        "isolated",
        "--step-deg",
        15,
        *("--export", "svg", "--export", "dxf", "--export", "mat"),
    )
    assert call.code == 0
    assert "patterns only" in call.out
    assert "isolated antennas" in call.err
    assert not list(out.glob("*.s4p"))
    with xr.open_dataset(out / "reader.nc", engine="h5netcdf") as data:
        assert "s_matrix" not in data
        gain = np.abs(complex_of(data["pattern"])) ** 2
    assert gain.sum(axis=1).max() == pytest.approx(1.641, abs=0.001)  # Balanis (4-91)
    assert 'response = "isolated"' in (out / "study.toml").read_text()
    for name in ("drawing.svg", "drawing.dxf", "reader.mat"):
        assert name in call.out
        assert (out / name).stat().st_size > 1000


@pytest.mark.slow
def test_convergence_solves_finer_meshes_and_says_what_changes(
    octant, study_file, tmp_path, monkeypatch
):
    from octant.reader_design.face import reader

    assert reader.DENSITIES == (8.0, 10.0, 14.0)
    monkeypatch.setattr(reader, "DENSITIES", (4.0, 5.0, 6.0))
    call = octant(
        "reader", study_file(SMALL), "--out", tmp_path / "o", "--convergence", "--step-deg", 30
    )
    assert call.code == 0
    assert "1/4 wavelength" in call.out
    assert "1/6 wavelength" in call.out
    assert " dB where strong" in call.out


@pytest.mark.parametrize(
    ("text", "options", "words"),
    [
        (SMALL, ["--step-deg", "7"], "must divide 180"),
        (SMALL, ["--model", "rays", "--convergence"], "no mesh"),
        (SMALL, ["--model", "rays", "--frequencies", "2.3e9:2.5e9:9"], "patterns only"),
        (SMALL, ["--frequencies", "2.5e9:2.3e9:9"], "is no band"),
        (SMALL, ["--frequencies", "2.3e9:2.5e9:1"], "is no band"),
        (SMALL, ["--frequencies", "2.3e9:2.5e9:9999999999"], "is no band"),
        (SMALL, ["--frequencies", "2.3e9,nan"], "is no band"),
        (SMALL, ["--band", "2.5:2.3:9"], "in GHz, such as 2.3:2.5:41"),
        (SMALL, ["--band", "2.3:2.5:9", "--frequencies", "2.3e9:2.5e9:9"], "give one"),
        (SMALL.replace("0.08", "0.001").replace("= 0.0\n", "= 0.08\n"), [], "touches"),
        (SMALL + "feed_gap_m = 0.07\n", [], "feed_gap_m"),
        (SMALL, ["--measured", __file__], "names 1 pattern files"),
        (SMALL + FEED + 'match = ["3 nH"]\n', [], "reader.feed.match[0]: '3 nH' is no network"),
        (SMALL + FEED + "reactance_ohm = [5.0, 6.0]\n", [], "2 entries, but the reader has 4"),
        (SMALL + FEED + "off_resistance_ohm = 0.0\n", [], "there is no multiplexer"),
        (SMALL + FEED + "multiplexer_loss_db = 0\nmultiplexer_leakage_db = -9\n", [], "raise its"),
        (SMALL + FEED + 'network_files = ["no.s2p"]\n', [], "no.s2p"),
        (SMALL + FEED + "cable_m = 1.0\n", ["--model", "rays"], "count as matched"),
        (
            SMALL + FEED + 'load_file = "a.s1p"\nreactance_ohm = [1.0]\n',
            [],
            "the receiver has one impedance",
        ),
    ],
)
def test_bad_calls_are_refused_in_one_sentence(octant, study_file, tmp_path, text, options, words):
    call = octant("reader", study_file(text), "--out", tmp_path / "out", "-q", *options)
    assert words in call.refused()
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_measured_reader_is_compared_in_the_report(octant, folder, done, study_file, tmp_path):
    """Files of another reader: its ports and patterns beside those of the study's."""
    assert done
    given = SMALL.replace("0.08", "0.083")
    other = Reader(**tomllib.loads(given)["reader"]).solve(2.4e9, step_deg=5, progress=False)
    files = [other.to_touchstone(tmp_path / "measured"), *other.to_ffe(tmp_path)]
    named = [word for file in files for word in ("--measured", file)]
    call = octant("reader", study_file(SMALL), "--out", tmp_path / "out", "--step-deg", 30, *named)
    assert call.code == 0, call.err
    own = read_touchstone(folder / "out" / "reader.s4p").s_matrices[0]
    off = np.abs(own - other.s.values[0])
    line = next(line for line in call.out.splitlines() if line.startswith("Measured ports"))
    found = [float(x) for x in re.findall(r"by up to ([\d.]+)[, ]", line)]
    coupled = off - np.diag(np.diagonal(off))
    assert found[:2] == pytest.approx([np.diagonal(off).max(), coupled.max()], abs=6e-4)
    assert "Measured patterns beside computed ones" in call.out
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert "Measured beside computed" in page
    assert (tmp_path / "out" / "figures" / "measured.png").exists()


@pytest.mark.slow
def test_lossy_metal_is_said_and_kept(octant, study_file, tmp_path):
    text = SMALL.replace("antennas = 4", "antennas = 3") + METAL
    call = octant("reader", study_file(text), "--out", tmp_path / "out", "--step-deg", "30")
    assert call.code == 0, call.err
    said = re.search(
        r"Metal of 100000 S/m \(skin depth 32 um, roughness factor 1\.2\): radiation efficiency "
        r"(\S+) to",
        call.out,
    )
    with xr.open_dataset(tmp_path / "out" / "reader.nc", engine="h5netcdf") as data:
        own = data["radiation_efficiency"].to_numpy()
    assert float(said[1]) == pytest.approx(100.0 * own.min(), abs=0.006)
    assert 0.8 < own.min() < 0.999


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        ("roughness_factor = 1.5", "without reader.conductivity_s_per_m the metal is perfect"),
        ('conductivity_s_per_m = 5.8e7\nresponse = "rays"', "'rays', which knows no metal"),
        ("conductivity_s_per_m = 100.0", "a number from 10000 to 1e9"),
    ],
)
def test_keys_of_metal_that_nothing_reads_are_refused(octant, study_file, lines, reason):
    assert reason in octant("reader", study_file(SMALL + lines)).refused()
