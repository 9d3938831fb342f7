"""Readers of any metal: ports, patterns and RSS from the command line, and what is refused."""

import csv

import numpy as np
import pytest
import trimesh
import xarray as xr

from octant.em.reader.fullwave.ported import strip
from octant.em.reader.fullwave.solve import solve_reader
from octant.reader_design.study_file.loading import load_study

METAL = """
name = "metal"
[radio]
frequency_hz = 2.4e9
[room]
free_space = true
[[tag]]
id = "a"
position_m = [3.0, 0.0, 1.3]
[reader]
response = "metal"
antennas = 3
cells_per_wavelength = 6
"""
RING = """
[[reader.body]]
kind = "dipole"
name = "arm"
length_m = 0.058
position_m = [0.08, 0.0, 0.0]
around = 3
[[reader.port]]
between = ["arm.low", "arm.high"]
"""


def mesh_study(unit="mm", refine="true", pair='"arms.low", "arms.high"'):
    return (
        METAL
        + f"refine = {refine}\n"
        + "\n".join(
            f"""
[[reader.body]]
kind = "mesh"
name = "{name}"
file = "arms.glb"
unit = "{unit}"
position_m = {place}
[[reader.port]]
between = [{pair.replace("arms", name)}]
"""
            for name, place in (
                ("one", [0.08, 0.0, 0.0]),
                ("two", [-0.04, 0.0692820323, 0.0]),
                ("three", [-0.04, -0.0692820323, 0.0]),
            )
        )
    )


@pytest.fixture
def arms(tmp_path):
    """Two parts that meet at z = 0, drawn in mm."""
    scene = trimesh.Scene()
    shape = {"width_m": 2.0, "across": (0, 1, 0), "rows": 4}
    for name, sign in (("low", -1.0), ("high", 1.0)):
        points, faces = strip((0, 0, 0), (0, 0, 29.0 * sign), **shape)
        mesh = trimesh.Trimesh(points, faces, process=False)
        scene.add_geometry(mesh, geom_name=name, node_name=name)
    scene.export(tmp_path / "arms.glb")
    return tmp_path


def test_a_ring_of_dipoles_has_ports_and_reads_as_bearing_sensitive(octant, study_file, tmp_path):
    study = study_file(METAL + RING)
    call = octant("reader", study, "--out", tmp_path / "out", "--step-deg", 10, "-q")
    assert call.code == 0, call.err
    assert "arm at 2.4 GHz" in call.out
    for name in ("reader.nc", "reader.s3p", "antenna_3.ffe", "report.html"):
        assert (tmp_path / "out" / name).exists()
    with xr.open_dataset(tmp_path / "out" / "reader.nc", engine="h5netcdf") as data:
        z = data["impedance_ohm"].values
        np.testing.assert_allclose(z, z[:1].repeat(3, axis=0), rtol=1e-6)
    poses = tmp_path / "poses.csv"
    poses.write_text("x_m,y_m,heading_deg\n0,0,90\n0,0,210\n")
    call = octant("rss", study, "--tag", "a", "--poses", poses, "--csv", tmp_path / "rss.csv")
    assert call.code == 0, call.err
    with (tmp_path / "rss.csv").open() as file:
        rows = [[float(row[f"rss_{i}_w"]) for i in (1, 2, 3)] for row in csv.DictReader(file)]
    # Heading 90 degrees: antenna 1 at room azimuth 0; a turn by 120 degrees moves it on by one.
    np.testing.assert_allclose(np.roll(rows[0], -1), rows[1], rtol=1e-3)


def test_two_dipoles_behind_a_hybrid_are_one_antenna(octant, study_file, tmp_path):
    crossed = RING.replace("length_m", "axis = [0.0, 1.0, 1.0]\nlength_m")
    other = (
        crossed.replace('"arm"', '"leg"').replace("0.08", "0.083").replace("1.0, 1.0", "-1.0, 1.0")
    )
    text = (
        METAL + crossed + 'second = ["leg.low", "leg.high"]\n' + other.split("[[reader.port]]")[0]
    )
    call = octant("reader", study_file(text), "--out", tmp_path / "out", "--step-deg", 30, "-q")
    assert call.code == 0, call.err
    line = next(line for line in call.out.splitlines() if line.startswith("Axial ratio"))
    ratios = [float(word) for word in line.rstrip(".").partition(": ")[2].split(", ")]
    assert len(ratios) == 3
    assert max(ratios) < 6.0
    assert (tmp_path / "out" / "reader.s3p").exists()


def test_metal_of_a_file_is_meshed_as_given_or_refined(octant, arms):
    study = arms / "study.toml"
    found = []
    for refine in ("false", "true"):
        study.write_text(
            mesh_study(unit="mm", refine=refine).replace("wavelength = 6", "wavelength = 30")
        )
        call = octant("reader", study, "--out", arms / refine, "--step-deg", 30, "-q")
        assert call.code == 0, call.err
        found.append(call.out)
    unknowns = [int(text.split(" unknowns")[0].split()[-1]) for text in found]
    assert unknowns[0] == 3 * 15
    assert unknowns[1] > 3 * unknowns[0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (METAL + RING.replace("arm.high", "arm.top"), "names the part 'arm"),
        (
            METAL + RING.replace("around = 3", "around = 4"),
            "make 4 ports, but",
        ),
        (METAL + RING + RING.split("[[reader.port]]", maxsplit=1)[0], "which is taken"),
        (METAL + RING.replace('"arm.low"', '"ground"'), "names the part 'ground'"),
        (METAL.replace("antennas = 3", 'antennas = 3\nground = "infinite"') + RING, "raise it"),
        (METAL.replace('"metal"\nant', '"fullwave"\nant') + RING, "leave them out"),
        (
            METAL.replace("= 3", "= 6") + RING + RING.split("around = 3\n")[1],
            "ports 1 and 2",
        ),
        (METAL + RING.replace("0.058", "58.0"), "look at its unit"),
    ],
)
def test_metal_that_cannot_be_is_refused(octant, study_file, tmp_path, text, said):
    call = octant("reader", study_file(text), "--out", tmp_path / "out", "-q")
    assert said in call.refused()


@pytest.mark.parametrize(
    ("unit", "pair", "said"),
    [
        ("m", '"arms.low", "arms.high"', "it would fit with mm instead of m"),
        ("mm", '"arms.low", "arms.low"', "is on no edge"),
    ],
)
def test_files_in_another_unit_and_ports_on_no_edge_are_noticed(octant, arms, unit, pair, said):
    study = arms / "study.toml"
    study.write_text(mesh_study(unit=unit, pair=pair))
    call = octant("reader", study, "--out", arms / "out", "-q")
    assert said in call.refused()


def ring(name, x_m, y_m=0.0, *, length_m=0.057, around=4, fed=True):
    """Return a ring of upright dipoles, and its port."""
    port = f'[[reader.port]]\nbetween = ["{name}.low", "{name}.high"]\n' if fed else ""
    return (
        f'[[reader.body]]\nkind = "dipole"\nname = "{name}"\nlength_m = {length_m}\n'
        f"position_m = [{x_m}, {y_m}, 0.0]\naround = {around}\n{port}"
    )


def solved_rings(study_file, text, antennas):
    study = load_study(study_file(METAL.replace("antennas = 3", f"antennas = {antennas}") + text))
    return solve_reader(study.reader.metal_mesh(2.4e9))


def test_antennas_of_two_staggered_rings_follow_each_other_around_the_axis(study_file):
    outer = ring("outer", 0.08 * np.cos(np.pi / 4), 0.08 * np.sin(np.pi / 4))
    result = solved_rings(study_file, ring("inner", 0.06) + outer, 8)
    centres = result.unloaded.phase_centres_m
    found = np.degrees(np.arctan2(centres[:, 1], centres[:, 0])) % 360.0
    np.testing.assert_allclose(found, np.arange(8) * 45.0, atol=1e-6)
    assert not result.warnings
    assert result.balance_error < 1e-3


def test_rings_fed_apart_at_the_same_azimuths_are_warned_of(study_file):
    result = solved_rings(study_file, ring("inner", 0.06) + ring("outer", 0.085), 8)
    assert "the port of antenna 2 stands at 0 deg" in result.warnings[0]
    assert "counts as one at 45 deg" in result.warnings[0]


def test_a_second_ring_without_ports_directs_the_first(study_file):
    alone = solved_rings(study_file, ring("arm", 0.06), 4)
    directed = solved_rings(
        study_file, ring("arm", 0.06) + ring("rod", 0.085, length_m=0.05, fed=False), 4
    )
    ratio = []
    for result in (alone, directed):
        field = result.far_field(np.full(2, np.pi / 2), np.array((0.0, np.pi)))[0]
        ahead, behind = (np.abs(field) ** 2).sum(axis=-1)
        ratio.append(10.0 * np.log10(ahead / behind))
    assert ratio[1] > ratio[0] + 3.0
