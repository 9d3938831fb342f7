"""A reader from files is the reader that the files were made from."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pattern_texts import msi_text, nec_text

from octant.em.antennas.from_files import pattern_tables, reader_from_pattern_files
from octant.em.antennas.kinds import make_antenna
from octant.em.antennas.pattern_files.common import PatternTable
from octant.em.antennas.pattern_files.cuts import write_csv
from octant.em.antennas.pattern_files.ffe import write_ffe
from octant.em.antennas.pattern_files.resample import resample, turned
from octant.em.reader.response import reader_response, sector_response
from octant.geometries.errors import PatternFileError, PhysicsWarning
from octant.geometries.reader_body import reader_body

F_HZ = 2.4e9
AZIMUTHS = np.arange(8) * np.pi / 4
READER = reader_response(reader_body(), make_antenna("dipole", F_HZ), model="isolated", gap_m=0.005)
RING = 0.1 * np.column_stack((np.cos(AZIMUTHS), np.sin(AZIMUTHS), np.zeros(8)))


def tables(response, step_deg=4.0, frequency_hz=F_HZ):
    theta = np.radians(np.arange(0.0, 180.1, step_deg))
    phi = np.radians(np.arange(0.0, 360.0, step_deg))
    field = np.moveaxis(response.far_field(theta[:, None], phi[None, :]), -1, 1)
    return [
        PatternTable(
            frequency_hz=frequency_hz, theta_rad=theta, phi_rad=phi, field=f, kind="realised_gain"
        )
        for f in field
    ]


def directions(n=300):
    rng = np.random.default_rng(1)
    return np.arccos(rng.uniform(-1, 1, n)), rng.uniform(0, 2 * np.pi, n)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reader")
    for i, made in enumerate(tables(READER)):
        (write_ffe if i % 2 else write_csv)(folder / f"a{i}.{'ffe' if i % 2 else 'csv'}", [made])
    return [folder / f"a{i}.{'ffe' if i % 2 else 'csv'}" for i in range(8)]


def test_eight_files_give_the_reader_they_were_written_from(files):
    back = reader_from_pattern_files(
        files, azimuths_rad=AZIMUTHS, frequency_hz=F_HZ, phase_centres_m=READER.phase_centres_m
    )
    at = directions()
    assert np.abs(back.far_field(*at) - READER.far_field(*at)).max() < 1e-3
    assert back.model == "files"
    assert back.warnings == ()
    np.testing.assert_array_equal(back.azimuths_rad, AZIMUTHS)


@pytest.mark.slow
def test_moving_the_phase_to_the_antennas_smooths_what_is_interpolated(files):
    at = directions()
    errors = [
        np.abs(
            reader_from_pattern_files(
                files, azimuths_rad=AZIMUTHS, frequency_hz=F_HZ, phase_centres_m=centres
            ).far_field(*at)
            - READER.far_field(*at)
        ).max()
        for centres in (None, READER.phase_centres_m)
    ]
    assert errors[1] < 0.2 * errors[0] < 0.02


@pytest.mark.slow
def test_the_own_grid_comes_back_exactly(tmp_path):
    sector = sector_response(AZIMUTHS, frequency_hz=F_HZ)
    paths = []
    for i, made in enumerate(tables(sector, step_deg=3.0)):
        paths.append(tmp_path / f"{i}.csv")
        write_csv(paths[-1], [made])
    back = reader_from_pattern_files(
        paths,
        azimuths_rad=AZIMUTHS,
        frequency_hz=F_HZ,
        phase_centres_m=sector.phase_centres_m,
        step_deg=3.0,
    )
    np.testing.assert_allclose(back.pattern, sector.pattern[:, :, ::2, ::2], atol=1e-12)


def test_between_two_tables_of_a_file_patterns_are_interpolated(tmp_path):
    made = tables(READER)[0]
    low, high = (
        replace(made, frequency_hz=f, field=made.field * s)
        for f, s in ((2.40e9, 1.0), (2.48e9, 2.0))
    )
    write_csv(tmp_path / "a.csv", [low, high])
    options = {"azimuths_rad": [0.0], "phase_centres_m": [[0, 0, 0.0]]}
    with pytest.warns(PhysicsWarning, match="radiates"):
        middle = reader_from_pattern_files([tmp_path / "a.csv"], frequency_hz=2.42e9, **options)
    alone = reader_from_pattern_files([tmp_path / "a.csv"], frequency_hz=2.4001e9, **options)
    np.testing.assert_allclose(middle.pattern, 1.25 * alone.pattern, atol=1e-9)
    for missing in (2.3e9, 2.6e9):
        with pytest.raises(PatternFileError, match=r"a\.csv, line 2: patterns at 2\.4e\+09, 2\.48"):
            reader_from_pattern_files([tmp_path / "a.csv"], frequency_hz=missing, **options)
    write_csv(tmp_path / "b.csv", [low, replace(high, frequency_hz=2.7e9)])
    with pytest.raises(PatternFileError, match="at most 5 % apart"):
        reader_from_pattern_files([tmp_path / "b.csv"], frequency_hz=2.5e9, **options)


def test_two_patterns_of_one_frequency_are_refused(tmp_path):
    made = tables(READER)[0]
    write_csv(tmp_path / "a.csv", [made, made])
    with pytest.raises(PatternFileError, match="keep one pattern of one antenna a file"):
        reader_from_pattern_files([tmp_path / "a.csv"], azimuths_rad=[0.0], frequency_hz=F_HZ)


def test_gain_becomes_realised_by_the_impedance_that_the_file_tells(write):
    loss = {}
    for z in (50.0 + 0j, 240.0 - 50.0j):
        path = write("a.out", nec_text(zin=(z.real, z.imag)))
        one = reader_from_pattern_files([path], azimuths_rad=[0.0], frequency_hz=F_HZ)
        assert one.warnings == ()
        loss[z] = np.abs(one.pattern).max() ** 2
    mismatch = 1 - abs((190.0 - 50.0j) / (290.0 - 50.0j)) ** 2
    assert loss[240.0 - 50.0j] / loss[50.0] == pytest.approx(mismatch, rel=1e-9)


@pytest.mark.parametrize(
    ("zin", "says"),
    [((1e200, 1.0), "not a finite number"), ((-50.0, 0.0), "gives power away")],
)
def test_impedances_that_no_fed_antenna_has_are_refused(zin, says, write):
    path = write("a.out", nec_text(zin=zin))
    with pytest.raises(PatternFileError, match=says):
        reader_from_pattern_files([path], azimuths_rad=[0.0], frequency_hz=F_HZ)


def test_files_without_phase_are_loud_and_centred_on_their_antennas(write):
    path = write("a.msi", msi_text())
    with pytest.warns(PhysicsWarning) as caught:
        reader = reader_from_pattern_files(
            [path] * 8, azimuths_rad=AZIMUTHS, frequency_hz=F_HZ, phase_centres_m=RING
        )
    text = " ".join(str(w.message) for w in caught)
    assert "holds no phase" in text
    assert "not realised gain" in text
    assert "is the file of antennas 1, 2, 3, 4, 5, 6, 7, 8" in text
    assert len(caught) == len(reader.warnings) == 4
    f = reader.far_field(np.pi / 2, np.radians(20.0))[:, 0]
    k = 2 * np.pi * F_HZ / 299792458.0
    turn = np.exp(1j * k * 0.1 * np.cos(AZIMUTHS - np.radians(20.0)))
    np.testing.assert_allclose(f / turn, abs(f[0]), rtol=1e-6)


@pytest.mark.parametrize("origin_m", [(0.0, 0.0, 0.0), (0.1, 0.02, 0.03)])
def test_one_file_turned_to_each_azimuth_is_the_whole_reader(origin_m, tmp_path):
    first = tables(READER)[0]
    k = 2 * np.pi * F_HZ / 299792458.0
    sine, cosine = np.sin(first.theta_rad)[:, None], np.cos(first.theta_rad)[:, None]
    across = (sine * np.cos(first.phi_rad), sine * np.sin(first.phi_rad))
    unit = np.stack((*across, cosine + 0.0 * across[0]), axis=-1)
    about = first.field * np.exp(-1j * k * unit @ np.array(origin_m))
    write_csv(tmp_path / "a.csv", [replace(first, field=about, origin_m=origin_m)])
    back = reader_from_pattern_files(
        [tmp_path / "a.csv"] * 8,
        azimuths_rad=AZIMUTHS,
        frequency_hz=F_HZ,
        phase_centres_m=READER.phase_centres_m,
        turns_rad=AZIMUTHS,
    )
    assert back.warnings == ()
    at = directions()
    assert np.abs(back.far_field(*at) - READER.far_field(*at)).max() < 1e-3


@given(
    steps=st.integers(-100, 100), phi_from=st.floats(0.0, 4.99), more=st.sampled_from([0.0, 0.7])
)
def test_a_turned_table_is_the_pattern_seen_from_the_turned_direction(steps, phi_from, more):
    theta = np.radians(np.arange(0.0, 181.0, 15.0))
    phi = np.radians(phi_from + np.arange(0.0, 360.0, 5.0))
    rng = np.random.default_rng(3)
    field = rng.normal(size=(2, len(theta), len(phi))) + 0j
    table = PatternTable(
        frequency_hz=F_HZ, theta_rad=theta, phi_rad=phi, field=field, kind="gain", source="a"
    )
    turn_rad = np.radians(5.0 * steps + more)
    got = resample(turned(table, turn_rad), theta, phi + turn_rad)
    np.testing.assert_allclose(got, field, atol=1e-9)


def test_patterns_that_face_away_from_their_antenna_are_warned_of(tmp_path):
    sector = sector_response(AZIMUTHS, frequency_hz=F_HZ)
    paths = [tmp_path / f"{i}.csv" for i in range(8)]
    for path, made in zip(paths, tables(sector, step_deg=9.0), strict=True):
        write_csv(path, [made])
    options = {"azimuths_rad": AZIMUTHS, "frequency_hz": F_HZ}
    right = reader_from_pattern_files(paths, phase_centres_m=sector.phase_centres_m, **options)
    assert right.warnings == ()
    paths[1], paths[4] = paths[4], paths[1]
    with pytest.warns(PhysicsWarning, match=r"antennas 2, 5 face away .* azimuth 45 deg, .*4\.csv"):
        reader_from_pattern_files(paths, **options)


def test_a_reader_that_radiates_too_much_is_warned_of(tmp_path):
    made = tables(READER)[0]
    write_csv(tmp_path / "a.csv", [replace(made, field=2.0 * made.field)])
    with pytest.warns(PhysicsWarning, match=r"radiates 4 times"):
        reader_from_pattern_files([tmp_path / "a.csv"], azimuths_rad=[0.0], frequency_hz=F_HZ)


@pytest.mark.parametrize("step_deg", [None, 3.0])
def test_tables_of_a_reader_go_to_files_and_back(step_deg, tmp_path):
    made = pattern_tables(READER, step_deg=step_deg)
    write_ffe(tmp_path / "a3.ffe", [made[2]])
    back = reader_from_pattern_files(
        [tmp_path / "a3.ffe"],
        azimuths_rad=AZIMUTHS[2:3],
        frequency_hz=F_HZ,
        phase_centres_m=READER.phase_centres_m[2:3],
        step_deg=step_deg or 1.5,
    )
    skip = slice(None, None, 1 if step_deg is None else 2)
    np.testing.assert_allclose(back.pattern[0], READER.pattern[2, :, skip, skip], atol=1e-12)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"azimuths_rad": [0.0, 1.0]}, "1 pattern files for 2 antennas"),
        ({"frequency_hz": 0.0}, "frequency_hz"),
        ({"load_ohm": -50.0}, "load_ohm"),
        ({"step_deg": 7.0}, "does not divide 180"),
        ({"phase_centres_m": [[0.0, 0.0]]}, "phase_centres_m"),
        ({"outside": "guess"}, "outside"),
    ],
)
def test_wrong_arguments_are_refused(change, says, files):
    options = {"azimuths_rad": [0.0], "frequency_hz": F_HZ} | change
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(PatternFileError, match=says):
            reader_from_pattern_files(files[:1], **options)
