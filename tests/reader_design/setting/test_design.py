"""Laws of a reader design: its name, its hash, its body and its response."""

import json
from pathlib import Path

import msgspec
import numpy as np
import pytest

from octant.geometries.errors import GeometryError
from octant.reader_design.setting.design import (
    canonical_json,
    content_hash,
    reader_responses,
    response_at,
)
from octant.reader_design.study_file.loading import parse_study
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.reader_feed import ReaderFeed
from octant.reader_design.study_file.reader_metal import DipoleBody, ReaderPort
from octant.reader_design.study_file.room import Box

THESIS = Reader(
    antenna="dipole",
    antenna_radius_m=0.10,
    plate_height_m=0.08,
    ground_plane_m=0.20,
    ground_plane_shape="square",
    antennas=8,
    gap_m=0.005,
    monopole_plane_m=0.04,
    height_m=0.3,
    load_ohm=50.0,
)
HOPPING = """
name = "hopping"
[radio]
frequency_hz = 2.4e9
channels_hz = [2.40e9, 2.48e9]
[room]
free_space = true
[reader]
response = "isolated"
"""


def test_label_names_antenna_and_the_two_lengths_of_the_thesis():
    assert THESIS.label() == "dipole r_a = 10 cm h_p = 8 cm"
    assert msgspec.structs.replace(THESIS, plate_height_m=0.0).label().endswith("h_p = 0 cm")


def test_equal_designs_have_equal_keys_and_every_parameter_changes_the_key():
    assert content_hash(THESIS.as_dict()) == content_hash(msgspec.structs.replace(THESIS).as_dict())
    changes = {
        "antenna": "monopole",
        "antenna_length_m": 0.06,
        "antenna_radius_m": 0.09,
        "plate_height_m": 0.0,
        "plate_height_axis_m": 0.04,
        "plate_profile_m": (0.07, 0.06),
        "plate_outer_radius_m": 0.08,
        "ground_plane_m": 0.22,
        "ground_plane_shape": "round",
        "antennas": 6,
        "gap_m": 0.01,
        "monopole_plane_m": 0.0,
        "height_m": 0.4,
        "load_ohm": 75.0,
        "wire_radius_m": 0.001,
        "feed_gap_m": 0.0,
        "line": ReaderFeed(),
        "objects": (Box(size_m=(0.1, 0.1, 0.1), material="pec", position_m=(0.0, 0.0, -0.3)),),
    }
    of_conductor = {
        "conductivity_s_per_m": 1e7,
        "sheet_thickness_m": 0.002,
        "roughness_factor": 1.5,
    }
    of_metal = {
        "bodies": (DipoleBody(name="arm", length_m=0.06),),
        "ports": (ReaderPort(between=("arm.low", "arm.high")),),
        "ground": "infinite",
        "refine": False,
    }
    how = {"cells_per_wavelength", "response", "pattern_files", "pattern_turn"}
    assert set(changes) | set(of_metal) | set(of_conductor) == set(Reader.__struct_fields__) - how
    metal = msgspec.structs.replace(THESIS, response="metal")
    varied = [msgspec.structs.replace(THESIS, **{n: v}) for n, v in changes.items()]
    varied += [msgspec.structs.replace(metal, **{n: v}) for n, v in of_metal.items()]
    copper = msgspec.structs.replace(THESIS, conductivity_s_per_m=5.8e7)
    varied += [msgspec.structs.replace(copper, **{n: v}) for n, v in of_conductor.items()]
    keys = {content_hash(reader.as_dict()) for reader in (THESIS, metal, copper, *varied)}
    assert len(keys) == len(varied) + 3


def test_canonical_json_does_not_depend_on_the_order_of_keys_and_reads_back():
    assert canonical_json({"b": 0.1, "a": [1, None]}) == canonical_json({"a": [1, None], "b": 0.1})
    assert json.loads(canonical_json({"x": 0.1 + 0.2}))["x"] == 0.1 + 0.2


def test_content_hash_is_the_sha256_of_the_canonical_text():
    # sha256 of the two characters {} by coreutils
    assert content_hash({}) == "44136fa355b3678a1146ad16f7e8649e94fb4fc21fe77e8310c060f61caaff8a"


def test_numbers_that_are_not_finite_have_no_hash():
    with pytest.raises(ValueError, match="JSON"):
        content_hash({"x": float("nan")})


def test_body_has_the_designs_lengths():
    body = THESIS.body()
    assert body.antenna_radius_m == 0.10
    assert body.plate_height_m == 0.08
    assert np.ptp(body.body.vertices_m[:, 0]) == pytest.approx(0.20)
    assert body.body.vertices_m[:, 2].max() == pytest.approx(0.08)


def test_antennas_beyond_the_ground_plane_cannot_be_built():
    with pytest.raises(GeometryError, match="antenna_radius_m"):
        msgspec.structs.replace(THESIS, antenna_radius_m=0.15).body()


def test_monopoles_on_small_radius_say_that_their_planes_are_shrunk():
    # r sin(pi/8) / (sin(pi/8) + cos(pi/8)) = 14.6 mm half side at r = 50 mm, 1 mm to spare
    monopole = msgspec.structs.replace(THESIS, antenna="monopole", antenna_radius_m=0.05)
    (note,) = monopole.notes()
    assert "2.73 cm" in note
    assert msgspec.structs.replace(monopole, antenna_radius_m=0.10).notes() == ()
    assert msgspec.structs.replace(THESIS, antenna_radius_m=0.05).notes() == ()


@pytest.mark.parametrize(("antenna", "part"), [("dipole", 2), ("monopole", 4)])
def test_antennas_are_resonant_unless_told(antenna, part):
    design = msgspec.structs.replace(THESIS, antenna=antenna)
    assert design.element(2.4e9).length_m == pytest.approx(299792458.0 / 2.4e9 / part)
    longer = msgspec.structs.replace(design, antenna_length_m=0.05)
    assert longer.element(2.4e9).length_m == 0.05


def test_response_is_in_the_reader_frame_with_antenna_1_at_azimuth_0():
    response = response_at(THESIS, 2.4e9, "isolated")
    np.testing.assert_allclose(response.azimuths_rad, np.arange(8) * np.pi / 4)
    dipole_centre = 0.005 + 299792458.0 / 2.4e9 / 4
    np.testing.assert_allclose(response.phase_centres_m[0], [0.10, 0.0, dipole_centre], atol=1e-12)


@pytest.mark.parametrize(("own_plane_m", "height_m"), [(0.0, 0.0), (0.04, 0.005)])
def test_monopole_stands_on_its_own_plane_at_the_gap_or_without_one_on_the_ground_plane(
    own_plane_m, height_m
):
    monopole = msgspec.structs.replace(THESIS, antenna="monopole", monopole_plane_m=own_plane_m)
    assert response_at(monopole, 2.4e9, "isolated").phase_centres_m[0, 2] == height_m


def test_antennas_keep_their_length_over_the_hopping_channels():
    study = parse_study(HOPPING, source="test", directory=Path.cwd())
    design = study.reader
    first, second = reader_responses(design, study.radio)
    assert (first.frequency_hz, second.frequency_hz) == (2.40e9, 2.48e9)
    cut = msgspec.structs.replace(design, antenna_length_m=299792458.0 / 2.4e9 / 2)
    np.testing.assert_array_equal(second.pattern, response_at(cut, 2.48e9, "isolated").pattern)
    assert not np.array_equal(second.pattern, response_at(design, 2.48e9, "isolated").pattern)


def test_defaults_of_the_study_file_are_those_of_the_solver():
    from octant.em.reader.fullwave import mesh

    reader = parse_study(HOPPING, source="test", directory=Path.cwd()).reader
    assert reader.wire_radius_m == mesh.WIRE_RADIUS_M
    assert reader.feed_gap_m == mesh.FEED_GAP_M
    assert reader.cells_per_wavelength == mesh.CELLS_PER_WAVELENGTH


# Four antennas without plates on a coarse mesh: a second or two, which is all that is needed here.
SMALL = """
name = "small"
[room]
free_space = true
[reader]
antennas = 4
antenna_radius_m = 0.08
plate_height_m = 0.0
cells_per_wavelength = 6
"""


def test_full_wave_is_the_default_and_the_load_counts():
    study = parse_study(SMALL, source="test", directory=Path.cwd())
    (response,) = reader_responses(study.reader, study.radio)
    assert response.model == "fullwave"
    assert response.antennas == 4
    text = SMALL + "load_ohm = 200.0\n"
    other = parse_study(text, source="test", directory=Path.cwd())
    (loaded,) = reader_responses(other.reader, other.radio)
    assert not np.allclose(loaded.pattern, response.pattern, rtol=0.05)


def test_readers_that_differ_in_their_load_alone_are_solved_once(monkeypatch, tmp_path):
    from octant.em.reader import cache

    monkeypatch.setenv(cache.CACHE_VARIABLE, str(tmp_path))
    solved, solve = [], cache.solved_reader
    monkeypatch.setattr(cache, "solved_reader", lambda *a, **k: solved.append(k) or solve(*a, **k))
    study = parse_study(SMALL, source="test", directory=Path.cwd())
    patterns = [
        response_at(msgspec.structs.replace(study.reader, load_ohm=load), 2.4e9).pattern
        for load in (50.0, 75.0, 100.0, 150.0)
    ]
    assert len(solved) == 1
    assert not np.allclose(patterns[0], patterns[-1], rtol=0.05)


def test_antenna_that_touches_a_plate_is_refused_by_the_full_wave_model():
    design = msgspec.structs.replace(THESIS, antenna_radius_m=0.002)
    with pytest.raises(GeometryError, match="touches"):
        response_at(design, 2.4e9, "fullwave")
