"""``octant paths``: every image path of a box, its columns, and receivers that hear nothing."""

import csv
import io
import json
import math

import numpy as np
import pytest

CABINET = """
[[room.object]]
kind = "cabinet"
size_m = [1.5, 0.35, 1.0]
position_m = [1.75, 2.2, 0.0]
"""
ROOM = 'name = "box"\n[room]\nbox_m = [5.0, 5.0, 3.0]\nmaterial = "concrete"\n'
COLUMNS = [
    "rx",
    "path",
    "order",
    "interactions",
    "length_m",
    "delay_ns",
    "departure_theta_deg",
    "departure_phi_deg",
    "arrival_theta_deg",
    "arrival_phi_deg",
    "gain_db",
    "phase_deg",
    "vertices",
]
TX = (3.5, 2.0, 2.9)


def rows_of(text):
    return list(csv.DictReader(io.StringIO(text)))


def found(octant, study, *receivers, options=()):
    receivers = [part for rx in receivers for part in ("--rx", rx)]
    call = octant("paths", study, "--tx", "3.5,2,2.9", *receivers, "--csv", "-", *options)
    assert call.code == 0, call.err
    return rows_of(call.out), call


@pytest.mark.parametrize(("order", "count"), [(0, 1), (1, 7), (2, 25), (3, 63), (5, 231)])
def test_box_has_the_closed_form_number_of_paths(octant, study_file, order, count):
    rows, _ = found(octant, study_file(), "1.213,4.381,0.3", options=("--max-reflections", order))
    assert len(rows) == count
    assert list(rows[0]) == COLUMNS


def test_lengths_are_distances_to_the_images_of_the_box(octant, study_file):
    rows, _ = found(octant, study_file(), "1.213,4.381,0.3")

    def images(x, size):
        return [
            (abs(2 * k - s), 2 * k * size + (-x if s else x)) for k in range(-4, 5) for s in (0, 1)
        ]

    rx = (1.213, 4.381, 0.3)
    axes = [images(x, size) for x, size in zip(TX, (5.0, 5.0, 3.0), strict=True)]
    expected = sorted(
        math.dist((x, y, z), rx)
        for i, x in axes[0]
        for j, y in axes[1]
        for k, z in axes[2]
        if i + j + k <= 3
    )
    np.testing.assert_allclose(sorted(float(r["length_m"]) for r in rows), expected, atol=1e-9)


def test_columns_agree_with_each_other(octant, study_file):
    rows, _ = found(octant, study_file(), "1.213,4.381,0.3", "0.6,0.7,1.0")
    assert [int(r["path"]) for r in rows] == [*range(63), *range(63)]
    assert [int(r["rx"]) for r in rows] == [0] * 63 + [1] * 63
    for row in rows:
        vertices = np.array([[float(c) for c in v.split(":")] for v in row["vertices"].split(";")])
        assert len(vertices) == int(row["order"]) + 2
        assert row["interactions"] == ",".join(["R"] * int(row["order"]))
        np.testing.assert_array_equal(vertices[0], TX)
        legs = np.diff(vertices, axis=0)
        length = np.linalg.norm(legs, axis=1).sum()
        assert float(row["length_m"]) == pytest.approx(length, abs=1e-9)
        assert float(row["delay_ns"]) == pytest.approx(length / 0.299792458, rel=1e-12)
        for end, leg in (("departure", legs[0]), ("arrival", -legs[-1])):
            theta = math.radians(float(row[f"{end}_theta_deg"]))
            phi = math.radians(float(row[f"{end}_phi_deg"]))
            assert 0.0 <= phi < 2.0 * math.pi
            direction = leg / np.linalg.norm(leg)
            across = math.sin(theta)
            np.testing.assert_allclose(
                [across * math.cos(phi), across * math.sin(phi), math.cos(theta)],
                direction,
                atol=1e-9,
            )


def test_direct_gain_between_isotropic_antennas_is_friis(octant, study_file):
    options = ("--max-reflections", "0", "--tx-antenna", "isotropic_theta")
    rows, call = found(
        octant, study_file(), "1.0,1.0,2.9", options=(*options, "--rx-antenna", "isotropic_theta")
    )
    distance = math.dist((1.0, 1.0, 2.9), TX)
    wavelength = 299_792_458.0 / 2.4e9
    friis_db = 20 * math.log10(wavelength / (4 * math.pi * distance))
    assert float(rows[0]["gain_db"]) == pytest.approx(friis_db, abs=1e-9)
    phase = math.remainder(-2 * math.pi * distance / wavelength, 2 * math.pi)
    assert float(rows[0]["phase_deg"]) == pytest.approx(math.degrees(phase), abs=1e-6)
    assert f"{friis_db:.4f}" in call.err


def test_summary_sums_the_gains(octant, study_file, tmp_path):
    study, out = study_file(), tmp_path / "p.csv"
    call = octant("paths", study, "--tx", "3.5,2,2.9", "--rx", "0.537,0.623,0.3", "--csv", out)
    assert call.code == 0
    rows = rows_of(out.read_text())
    gain_db = np.array([float(r["gain_db"]) for r in rows])
    phase = np.radians([float(r["phase_deg"]) for r in rows])
    amplitude = 10 ** (gain_db / 20) * np.exp(1j * phase)
    line = call.out.splitlines()[1].split()
    assert line[4] == "63"
    assert float(line[5]) == pytest.approx(20 * np.log10(abs(amplitude.sum())), abs=1e-3)
    assert float(line[6]) == pytest.approx(10 * np.log10((abs(amplitude) ** 2).sum()), abs=1e-3)
    assert "63 paths to 1 receiver." in call.out
    assert "considered" not in call.out + call.err
    told = octant("paths", study, "--tx", "3.5,2,2.9", "--rx", "0.537,0.623,0.3", "-v")
    assert "order 3: " in told.err


# Counts from an independent closed-form box solution with the cabinet's occlusion.
@pytest.mark.parametrize(
    ("rx", "count"),
    [
        ("0.537,0.623,0.3", 60),
        ("1.213,4.381,0.3", 57),
        ("2.471,1.127,0.3", 52),
        ("2.519,3.163,0.3", 53),
        ("4.377,0.741,0.3", 59),
    ],
)
def test_metal_cabinet_blocks_and_adds_paths(octant, study_file, rx, count):
    rows, _ = found(octant, study_file(ROOM + CABINET), rx)
    assert len(rows) == count


@pytest.mark.parametrize("rx", ["2.1,2.41,0.37", "6.0,2.0,1.0"])
def test_receivers_that_nothing_reaches_are_results(octant, study_file, rx):
    rows, call = found(octant, study_file(ROOM + CABINET), rx)
    assert rows == []
    assert "0 paths to 1 receiver." in call.err
    assert "-inf" in call.err
    outside = rx.startswith("6")
    assert ("warning: receiver 0 at (6.0, 2.0, 1.0) m is outside the room" in call.err) == outside


def test_the_strongest_paths_are_listed_first_and_all_on_request(octant, study_file):
    ends = ("--tx", "3.5,2,2.9", "--rx", "0.537,0.623,0.3")
    rows, _ = found(octant, study_file(), ends[3])
    few = octant("paths", study_file(), *ends, "-q").out.splitlines()
    every = octant("paths", study_file(), *ends, "-q", "--all").out.splitlines()
    start = next(i for i, line in enumerate(few) if line.split()[:2] == ["path", "order"]) + 1
    strongest = sorted(rows, key=lambda row: -float(row["gain_db"]))
    assert few[start].split()[2:5] == ["line", "of", "sight"]
    for line, row in zip(few[start:-1], strongest, strict=False):
        assert f" {float(row['gain_db']):.2f} " in line
        assert f" {float(row['length_m']):.3f} " in line
    assert few[-1] == "... and 43 weaker ones; --all lists every one."
    assert len(every) - start == 63
    assert max(map(len, every)) <= 80


def test_a_tag_of_the_study_transmits_with_its_own_antenna(octant, study_file):
    text = (
        ROOM + '[[tag]]\nid = "desk"\nposition_m = [3.5, 2.0, 2.9]\nantenna = "isotropic_theta"\n'
    )
    study, rx = study_file(text), ("--rx", "1,1,1", "--csv", "-", "-q")
    named = octant("paths", study, "--tx", "desk", *rx)
    given = octant("paths", study, "--tx", "3.5,2,2.9", "--tx-antenna", "isotropic_theta", *rx)
    assert (named.code, named.out) == (0, given.out)
    assert "'desk'" in octant("paths", study, "--tx", "dek", *rx).refused()


def test_the_document_says_what_the_table_says(octant, study_file):
    ends = ("--tx", "3.5,2,2.9", "--rx", "1,1,1", "--rx", "6,2,1", "-q")
    document = json.loads(octant("paths", study_file(), *ends, "--json").out)
    rows, _ = found(octant, study_file(), "1,1,1", "6,2,1")
    assert [r["gain_db"] for r in document["paths"]] == [float(r["gain_db"]) for r in rows]
    assert [r["inside_room"] for r in document["receivers"]] == [True, False]
    assert document["receivers"][1]["coherent_db"] is None  # no path: no level
    first = document["paths"][0]
    assert len(first["vertices_m"]) == first["order"] + 2


def test_antennas_on_walls_stand_off_and_say_so(octant, study_file):
    call = octant("paths", study_file(), "--tx", "3.5,2,3", "--rx", "0,1,1", "--csv", "-")
    assert call.code == 0
    rows = rows_of(call.out)
    assert rows[0]["vertices"] == "3.5:2.0:2.95;0.05:1.0:1.0"
    assert "transmitter at (3.5, 2, 3) m lies on a surface and is moved 5 cm" in call.err
    assert "receiver 0 at [0.0, 1.0, 1.0] m lies on a surface" in call.err


def test_receivers_come_from_a_file_after_those_of_the_line(octant, study_file, tmp_path):
    table = tmp_path / "rx.csv"
    table.write_text("z_m,x_m,y_m\n0.3,1.0,2.0\n0.4,2.0,3.0\n")
    rows, _ = found(
        octant, study_file(), "4,4,1", options=("--rx-file", table, "--max-reflections", "0")
    )
    assert [r["vertices"].split(";")[-1] for r in rows] == [
        "4.0:4.0:1.0",
        "1.0:2.0:0.3",
        "2.0:3.0:0.4",
    ]


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["--tx", "2,2.3,0.5", "--rx", "1,1,1"], "inside a solid object"),
        (["--tx", "2,2,5", "--rx", "1,1,1"], "outside the room"),
        (["--tx", "2,2", "--rx", "1,1,1"], "not a point"),
        (["--tx", "2,2,nan", "--rx", "1,1,1"], "not a point"),
        (["--tx", "2,2,1", "--rx", "2,2,1"], "own place"),
        (["--tx", "2,2,1"], "no receiver"),
        (["--tx", "2,2,1", "--rx-file", "none.csv"], "none.csv"),
        (["--tx", "2,2,1", "--rx", "1,1,1", "--max-reflections", "-1"], "max-reflections"),
        (["--tx", "2,2,1", "--rx", "1,1,1", "--tx-antenna", "dipol"], "dipole"),
    ],
)
def test_ends_that_cannot_be_used_are_refused(octant, study_file, arguments, part):
    assert part in octant("paths", study_file(ROOM + CABINET), *arguments).refused()


def test_existing_csv_is_kept_without_force(octant, study_file, tmp_path):
    out = tmp_path / "p.csv"
    out.write_text("mine")
    arguments = ("paths", study_file(), "--tx", "1,1,1", "--rx", "2,2,2", "--csv", out)
    assert "--force" in octant(*arguments).refused()
    assert out.read_text() == "mine"
    assert octant(*arguments, "--force").code == 0
    assert len(rows_of(out.read_text())) == 63


EDGES = """
[[room.object]]
kind = "box"
size_m = [0.6, 0.4, 0.9]
position_m = [1.2, 1.6, 0.0]
material = { name = "glass", thickness_m = 0.01 }
[solver]
max_reflections = 2
"""


def test_interactions_are_letters_and_the_order_counts_bends(octant, study_file):
    study = study_file(ROOM + EDGES + "diffraction = true\ntransmission = true\n")
    rows, _ = found(octant, study, "0.7,1.9,0.5")
    words = [row["interactions"].replace("-", "").split(",") for row in rows]
    assert {letter for word in words for letter in word} >= {"R", "T", "D"}
    for row, word in zip(rows, words, strict=True):
        assert int(row["order"]) == sum(letter in {"R", "D"} for letter in word)
    assert any(word.count("D") == 1 and "T" in word for word in words)


@pytest.mark.parametrize(
    ("setting", "letters"),
    [("", "R"), ("diffraction = true", "RD"), ("transmission = true", "RT")],
)
def test_solver_settings_say_what_paths_do(octant, study_file, setting, letters):
    rows, _ = found(octant, study_file(ROOM + EDGES + setting + "\n"), "0.7,1.9,0.5")
    assert {x for row in rows for x in row["interactions"] if x.isalpha()} == set(letters)


@pytest.mark.parametrize(
    ("setting", "says"),
    [
        ("max_diffractions = 3", "max_diffractions"),
        ('search = "some"', "search"),
        ("rays = 0", "rays"),
        ('faces = "round"', "faces"),
        ("diffraction = 1", "diffraction"),
    ],
)
def test_bad_solver_settings_are_refused_by_name(octant, study_file, setting, says):
    study = study_file(ROOM + EDGES + setting + "\n")
    assert says in octant("paths", study, "--tx", "1,1,1", "--rx", "2,2,1").refused()


def test_rays_say_what_share_of_the_power_they_found(octant, study_file):
    text = ROOM + CABINET + '[solver]\nmax_reflections = 2\nsearch = "rays"\nrays = 800\n'
    call = octant("paths", study_file(text), "--tx", "3.5,2,2.9", "--rx", "1,1,0.3")
    assert call.code == 0, call.err
    last = [line for line in call.out.splitlines() if "rays found" in line]
    assert len(last) == 1
    assert "allowed: 0.1 dB" in last[0]
    made = octant("paths", study_file(text), "--tx", "3.5,2,2.9", "--rx", "1,1,0.3", "--json")
    share = json.loads(made.out)
    assert 0.0 < share["missing_share"] < share["missing_share_at_most"] < 0.0228
    assert share["rays"] in {800, 1600, 3200, 6400}


def test_a_map_by_rays_keeps_what_they_missed(octant, study_file, tmp_path):
    import xarray as xr

    text = ROOM + '[solver]\nmax_reflections = 1\nsearch = "rays"\nrays = 800\n'
    text += '[[tag]]\nid = "a"\nposition_m = [3.5, 2.0, 2.9]\n'
    call = octant(
        "map", study_file(text), "--isotropic", "--spacing-m", "1", "--out", tmp_path / "map.nc"
    )
    assert call.code == 0, call.err
    assert "800 rays found all but" in call.out
    with xr.open_dataset(tmp_path / "map.nc") as data:
        assert data.attrs["rays"] == 800
        assert data.attrs["missing_at_most_db"] <= 0.1
