"""A reader given entirely by pattern files, through the command line."""

import csv

import numpy as np
import pytest
import xarray as xr

from octant.em.antennas.from_files import pattern_tables
from octant.em.antennas.kinds import make_antenna
from octant.em.antennas.pattern_files.ffe import write_ffe
from octant.em.reader.response import reader_response
from octant.geometries.reader_body import reader_body

STUDY = """
[room]
box_m = [5.0, 5.0, 3.0]
[[tag]]
id = "A"
position_m = [3.5, 2.0, 2.9]
antenna = "dipole"
[solver]
max_reflections = 1
[reader]
response = "{response}"
{more}
"""


@pytest.fixture
def files(tmp_path):
    """Eight .ffe files of isolated dipoles, phase at the reader's centre."""
    dipole = make_antenna("dipole", 2.4e9)
    response = reader_response(reader_body(), dipole, model="isolated", gap_m=0.005)
    names = []
    for i, table in enumerate(pattern_tables(response, step_deg=3.0)):
        names.append(f"antenna{i + 1}.ffe")
        write_ffe(tmp_path / names[-1], (table,))
    return names


def study_file(folder, name, response, more=""):
    path = folder / name
    path.write_text(STUDY.format(response=response, more=more))
    return str(path)


def rss(octant, folder, study):
    poses = folder / "poses.csv"
    poses.write_text("x_m,y_m,heading_deg\n1,1,90\n2,3.3,17\n")
    out = folder / "rss.csv"
    arguments = ["rss", study, "--tag", "A", "--poses", poses, "--csv", out, "--force"]
    assert octant(*arguments).code == 0
    with out.open() as file:
        rows = list(csv.DictReader(file))
    return np.array([[float(r[f"rss_{i}_w"]) for i in range(1, 9)] for r in rows])


def test_files_of_a_reader_give_its_rss(octant, tmp_path, files):
    given = study_file(tmp_path, "files.toml", "files", f"pattern_files = {files}")
    built = study_file(tmp_path, "isolated.toml", "isolated")
    expected = rss(octant, tmp_path, built)
    assert rss(octant, tmp_path, given) == pytest.approx(expected, rel=2e-3)


def test_the_file_of_one_antenna_turned_to_each_gives_the_reader(octant, tmp_path, files):
    more = f'pattern_files = {files[:1]}\npattern_turn = "each"'
    given = study_file(tmp_path, "files.toml", "files", more)
    built = study_file(tmp_path, "isolated.toml", "isolated")
    expected = rss(octant, tmp_path, built)
    assert rss(octant, tmp_path, given) == pytest.approx(expected, rel=2e-3)


def cardioid(folder):
    """A pattern of one antenna that faces +x, as measured alone."""
    rows = ["theta_deg,phi_deg,gain_theta_db,gain_phi_db"]
    for t in range(0, 181, 5):
        for p in range(0, 360, 5):
            cosine = np.sin(np.radians(t)) * np.cos(np.radians(p))
            rows.append(
                f"{t},{p},{10 * np.log10(max(5 * (0.5 + 0.5 * cosine) ** 4, 1e-6)):.3f},-60"
            )
    (folder / "panel.csv").write_text("\n".join(rows))


@pytest.mark.slow
@pytest.mark.parametrize("turn", ["none", "each"])
def test_a_reader_of_one_file_says_whether_its_antennas_face_their_way(octant, tmp_path, turn):
    cardioid(tmp_path)
    more = f'pattern_files = {["panel.csv"] * 8}\npattern_turn = "{turn}"'
    study = study_file(tmp_path, "s.toml", "files", more)
    done = octant("reader", study, "--out", tmp_path / "out", "--step-deg", "15")
    assert done.code == 0
    assert ("antennas 2, 3, 4, 5, 6, 7, 8 face away" in done.err) == (turn == "none")
    assert ("is the file of antennas 1, 2," in done.err) == (turn == "none")
    assert "files panel.csv r_a = 10 cm at 2.4 GHz" in done.out
    assert "dipole" not in done.out
    assert not (tmp_path / "out" / "figures" / "element.png").exists()
    with xr.open_dataset(tmp_path / "out" / "reader.nc") as data:
        horizon = (data["pattern"].to_numpy() ** 2).sum(axis=(1, 4))[:, 6]
    assert np.argmax(horizon, axis=1).tolist() == [3 * i * (turn == "each") for i in range(8)]


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize(
    ("response", "more", "words"),
    [
        ("files", 'pattern_files = ["antenna1.ffe"]', "has 8 antennas"),
        ("files", "", "names 0 files"),
        ("fullwave", 'pattern_files = ["antenna1.ffe"]', "reader.response"),
        ("fullwave", 'pattern_turn = "each"', "leave the turn out"),
        ("files", "pattern_files = ['antenna1.ffe']\npattern_turn = 'all'", "pattern_turn"),
        ("files", f"pattern_files = {['none.ffe'] * 8}", "'none.ffe' does not exist"),
    ],
)
def test_bad_lists_of_files_are_refused(octant, tmp_path, response, more, words):
    study = study_file(tmp_path, "s.toml", response, more)
    done = octant("paths", study, "--tx", "1,1,1", "--rx", "2,2,2")
    assert words in done.refused()


def test_a_malformed_file_is_named_with_its_line(octant, tmp_path, files):
    path = tmp_path / files[2]
    lines = path.read_text().splitlines()
    lines[60] = lines[60].replace(lines[60].split()[0], "abc", 1)
    path.write_text("\n".join(lines))
    study = study_file(tmp_path, "s.toml", "files", f"pattern_files = {files}")
    poses = tmp_path / "poses.csv"
    poses.write_text("x_m,y_m,heading_deg\n1,1,90\n")
    done = octant("rss", study, "--tag", "A", "--poses", str(poses), "--csv", str(tmp_path / "o"))
    assert f"{files[2]}, line 61" in done.refused()
