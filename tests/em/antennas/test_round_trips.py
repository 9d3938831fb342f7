"""What is written comes back."""

import re
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from octant.em.antennas.pattern_files.common import PatternTable
from octant.em.antennas.pattern_files.cuts import write_csv
from octant.em.antennas.pattern_files.ffe import write_ffe
from octant.em.antennas.pattern_files.reading import read_pattern
from octant.geometries.errors import ConfigError, PatternFileError, PhysicsWarning


def table(seed=0, rows=7, columns=8, **changes):
    rng = np.random.default_rng(seed)
    field = rng.normal(size=(2, rows, columns, 2)) @ np.array([1.0, 1.0j])
    made = PatternTable(
        frequency_hz=2.4123e9,
        theta_rad=np.radians(np.arange(rows) * 180 / (rows - 1)),
        phi_rad=np.radians(np.arange(columns) * 360 / columns),
        field=field,
        kind="realised_gain",
        name='antenna, "1"',
        origin_m=(0.1, 0.2, 0.3),
    )
    return replace(made, **changes)


def same_grid(a, b):
    np.testing.assert_allclose(a.theta_rad, b.theta_rad, rtol=1e-15, atol=1e-15)
    np.testing.assert_allclose(a.phi_rad, b.phi_rad, rtol=1e-15, atol=1e-15)
    assert (a.frequency_hz, a.kind, a.phase_known) == (b.frequency_hz, b.kind, b.phase_known)
    np.testing.assert_array_equal(a.origin_m, b.origin_m)


def columns_by_name(path):
    """A plain reader of .ffe by FEKO's description: #Key: value, one line of names, numbers."""
    lines = path.read_text().splitlines()
    keys = dict(line[1:].split(": ", 1) for line in lines if re.match(r"#\w[^\"]*: ", line))
    (names,) = (re.findall(r'"([^"]+)"', line) for line in lines if line.startswith('#  "'))
    rows = [line.split() for line in lines if line and line[0] not in "#*"]
    return keys, dict(zip(names, np.array(rows, dtype=float).T, strict=True))


def test_another_reader_of_ffe_finds_the_same_field_and_gains(tmp_path):
    made = table(3)
    write_ffe(tmp_path / "a.ffe", (made,))
    keys, found = columns_by_name(tmp_path / "a.ffe")
    assert float(keys["Frequency"]) == made.frequency_hz
    samples = [int(keys[f"No. of {angle} Samples"]) for angle in ("Theta", "Phi")]
    assert samples == [7, 9]  # the last azimuth is the first again
    field = np.moveaxis(np.concatenate((made.field, made.field[:, :, :1]), axis=2), 2, 1)
    np.testing.assert_allclose(found["Theta"], np.tile(np.arange(7) * 30.0, 9), atol=1e-12)
    np.testing.assert_allclose(found["Phi"], np.repeat(np.arange(9) * 45.0, 7), atol=1e-12)
    gain = np.abs(field) ** 2
    for part, (name, wave) in enumerate((("Gain(Theta)", "Etheta"), ("Gain(Phi)", "Ephi"))):
        np.testing.assert_allclose(found[name], 10.0 * np.log10(gain[part]).reshape(-1), atol=1e-9)
        volt = found[f"Re({wave})"] + 1j * found[f"Im({wave})"]
        # peak r E of a watt of isotropic power: sqrt(2 eta / 4 pi) V
        scale = np.sqrt(2.0 * 376.730313668 / (4.0 * np.pi))
        np.testing.assert_allclose(volt, scale * field[part].reshape(-1), rtol=1e-9)
    np.testing.assert_allclose(
        found["Gain(Total)"], 10.0 * np.log10(gain.sum(axis=0)).reshape(-1), atol=1e-9
    )


@given(
    seed=st.integers(0, 99),
    rows=st.integers(2, 9),
    columns=st.integers(3, 10),
    kind=st.sampled_from(["directivity", "gain", "realised_gain"]),
    level=st.floats(-5, 5),
)
def test_csv_and_ffe_come_back(tmp_path, seed, rows, columns, kind, level):
    first = table(seed, rows, columns, kind=kind)
    first = replace(first, field=first.field * 10.0**level / 1e5)
    both = (first, replace(first, frequency_hz=2.45e9, field=first.field[::-1]))
    write_csv(tmp_path / "a.csv", both)
    write_ffe(tmp_path / "a.ffe", both)
    for path, exact in (("a.csv", True), ("a.ffe", False)):
        back = read_pattern(tmp_path / path)
        assert len(back) == 2
        for old, new in zip(both, back, strict=True):
            same_grid(old, new)
            if exact:
                np.testing.assert_array_equal(old.field, new.field)
            scale = np.abs(old.field).max()
            np.testing.assert_allclose(old.field, new.field, rtol=1e-13, atol=1e-14 * scale)


@pytest.mark.parametrize("name", ["a.csv", "a.ffe"])
def test_amplitudes_without_phase_come_back_without_phase(name, tmp_path):
    first = table(phase_known=False)
    first = replace(first, field=np.abs(first.field))
    (write_csv if name == "a.csv" else write_ffe)(tmp_path / name, [first])
    with pytest.warns(PhysicsWarning, match="holds no phase"):
        (back,) = read_pattern(tmp_path / name)
    same_grid(first, back)
    np.testing.assert_allclose(back.field, first.field, rtol=1e-13)


def test_half_a_sphere_comes_back_as_half_a_sphere(tmp_path):
    first = table(theta_rad=np.radians(np.arange(7) * 15.0))
    write_ffe(tmp_path / "a.ffe", [first])
    (back,) = read_pattern(tmp_path / "a.ffe")
    same_grid(first, back)


def test_a_name_keeps_its_commas_and_quotes(tmp_path):
    write_csv(tmp_path / "a.csv", [table()])
    assert read_pattern(tmp_path / "a.csv")[0].name == 'antenna, "1"'


def test_what_cannot_be_written_is_refused(tmp_path):
    for write in (write_csv, write_ffe):
        with pytest.raises(PatternFileError, match="table"):
            write(tmp_path / "a.out", [])
        with pytest.raises(ConfigError, match="cannot be written"):
            write(Path(__file__) / "a.out", [table()])
    with pytest.raises(PatternFileError, match="frequency"):
        write_ffe(tmp_path / "a.ffe", [table(frequency_hz=None)])
    with pytest.raises(PatternFileError, match="realised gain"):
        write_ffe(tmp_path / "a.ffe", [table(), table(kind="gain")])
    with pytest.raises(PatternFileError, match="differ"):
        write_csv(tmp_path / "a.csv", [table(), table(frequency_hz=None)])
    assert list(tmp_path.iterdir()) == []


def test_a_file_is_replaced_whole(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("old")
    write_csv(path, [table()])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_pattern(path)
    assert [p.name for p in tmp_path.iterdir()] == ["a.csv"]
