"""Readers at other bands: the same in wavelengths, and told of where nothing has been compared."""

import tomllib

import msgspec
import numpy as np
import pytest

import octant as face
from octant.em.reader.fullwave.response import solved_reader
from octant.geometries.errors import ConfigError
from octant.reader_design.setting.scale import (
    LENGTHS_OF_READER,
    PRESETS_HZ,
    preset_keys,
    reader_preset,
    scale_note,
    scaled,
)
from octant.reader_design.study_file.loading import study_of_tables
from octant.reader_design.study_file.reader import Reader

EXAMPLE = "examples/best_reader.toml"


@pytest.mark.slow
def test_a_scaled_reader_has_the_same_ports_at_the_scaled_frequency():
    # Maxwell's equations with perfect metal have no length of their own.
    def s_matrix(design, frequency_hz):
        return solved_reader(
            design.body(),
            design.element(frequency_hz),
            cells_per_wavelength=5.0,
            **design.feed(),
        ).s_matrix

    drawn = Reader(antennas=4, antenna_radius_m=0.08, plate_height_m=0.05)
    other = s_matrix(scaled(drawn, 3.0), 0.8e9)
    np.testing.assert_allclose(other, s_matrix(drawn, 2.4e9), atol=1e-6)


def test_every_length_of_the_reader_scales_but_its_height():
    lengths = {f.name for f in msgspec.structs.fields(Reader) if f.name.endswith("_m")}
    others = {"height_m", "plate_profile_m", "conductivity_s_per_m", "sheet_thickness_m"}
    assert set(LENGTHS_OF_READER) == lengths - others
    assert scaled(Reader(plate_profile_m=(0.04, 0.05)), 2.0).plate_profile_m == (0.08, 0.1)


@pytest.mark.parametrize("band", [*PRESETS_HZ, 433e6])
def test_presets_are_the_best_reader_in_wavelengths_and_inside_the_range(band, request):
    with (request.config.rootpath / EXAMPLE).open("rb") as file:
        best = tomllib.load(file)["reader"]
    frequency_hz = PRESETS_HZ.get(band, band)
    keys = preset_keys(band)
    for name in set(best) & set(LENGTHS_OF_READER):
        assert keys[name] == pytest.approx(best[name] * 2.4e9 / frequency_hz, rel=1e-3), name
    assert keys["load_ohm"] == best["load_ohm"]
    raw = {"room": {"free_space": True}, "radio": {"frequency_hz": frequency_hz}, "reader": keys}
    study = study_of_tables(raw, source="test", directory=".")
    assert study.reader == reader_preset(band)
    assert scale_note(study.reader, frequency_hz) is None


def test_the_geometry_of_another_band_is_told_of_with_keys_to_paste():
    note = scale_note(Reader(), 915e6)
    assert "at 915 MHz the reader is outside the range" in note
    assert "antenna_radius_m is 0.31 wavelengths (compared: 0.4 to 0.8)" in note
    keys = note.partition("in wavelengths is ")[2]
    given = tomllib.loads(keys.replace(", ", "\n"))
    assert given["antenna_radius_m"] == pytest.approx(0.1 * 2.4e9 / 915e6, rel=1e-3)
    assert scale_note(Reader(**given), 915e6) is None
    assert scale_note(Reader(), 2.45e9) is None
    assert scale_note(Reader(antenna_radius_m=0.3, ground_plane_m=0.7), 2.4e9)
    assert scale_note(Reader(response="isolated"), 915e6) is None


def test_python_has_the_presets_and_refuses_other_names():
    assert face.Reader.preset("868 MHz").table == reader_preset("868 MHz")
    for band in ("900 MHz", -1.0):
        with pytest.raises(ConfigError, match="band is"):
            face.Reader.preset(band)
