"""Patches and pattern files as tags and as the ends of paths, through the command line."""

import csv
import io

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.antennas.pattern_files.common import PatternTable
from octant.em.antennas.pattern_files.ffe import write_ffe
from octant.reader_design.study_file.loading import load_study, parse_study, to_toml

STUDY = """
[room]
box_m = [5.0, 5.0, 3.0]
[[tag]]
id = "A"
position_m = [3.5, 2.0, 2.9]
{tag}
[solver]
max_reflections = 1
[reader]
response = "isolated"
[map]
spacing_m = 1.0
"""
ENDS = ("--tx", "3.5,2,2.9", "--rx", "1,1,0.5", "--csv", "-")


@pytest.fixture
def dipole_file(tmp_path):
    """A vertical dipole, as FEKO would write it."""
    theta = np.radians(np.arange(0.0, 181.0, 2.0))
    phi = np.radians(np.arange(0.0, 360.0, 4.0))
    field = np.moveaxis(make_antenna("dipole", 2.4e9).far_field(theta[:, None], phi), -1, 0)
    table = PatternTable(
        frequency_hz=2.4e9, theta_rad=theta, phi_rad=phi, field=field, kind="realised_gain"
    )
    write_ffe(tmp_path / "dipole.ffe", (table,))
    return tmp_path / "dipole.ffe"


def rows_of(call):
    assert call.code == 0, call.err
    return list(csv.DictReader(io.StringIO(call.out)))


@pytest.mark.parametrize(
    "options", [("--tx-antenna",), ("--rx-antenna",), ("--tx-antenna", "--rx-antenna")]
)
def test_a_pattern_file_at_either_end_is_the_antenna_in_it(
    octant, study_file, dipole_file, options
):
    study = study_file(STUDY.format(tag='antenna = "dipole"'))
    files = [part for option in options for part in (option, dipole_file)]
    given, exact = (
        rows_of(octant("paths", study, *ENDS, *files)),
        rows_of(octant("paths", study, *ENDS)),
    )
    assert len(given) == len(exact) == 7
    for column, tolerance in (("gain_db", 1e-3), ("phase_deg", 1e-2)):
        values = [[float(row[column]) for row in rows] for rows in (given, exact)]
        np.testing.assert_allclose(values[0], values[1], atol=tolerance)


def test_an_end_lies_along_its_axis(octant, study_file):
    study = study_file(STUDY.format(tag='antenna = "dipole"'))
    lying = rows_of(octant("paths", study, *ENDS, "--rx-antenna", "patch", "--rx-axis", "0,0,1"))
    turned = rows_of(
        octant(
            "paths",
            study,
            *ENDS,
            "--rx-antenna",
            "patch",
            "--rx-axis",
            "0,0,1",
            "--rx-azimuth-deg",
            90,
        )
    )
    assert np.isfinite(float(lying[0]["gain_db"]))
    assert float(lying[0]["gain_db"]) != pytest.approx(float(turned[0]["gain_db"]), abs=0.1)
    behind = rows_of(octant("paths", study, *ENDS, "--rx-antenna", "patch"))
    assert float(behind[0]["gain_db"]) == -np.inf  # a patch that faces down hears nothing above


@pytest.mark.usefixtures("dipole_file")
def test_a_tag_of_a_pattern_file_gives_the_rss_of_its_antenna(octant, study_file, tmp_path):
    poses = tmp_path / "poses.csv"
    poses.write_text("x_m,y_m,heading_deg\n1,1,90\n2,3.3,17\n")
    levels = []
    for tag in ('antenna = "dipole"', 'antenna = "dipole.ffe"'):
        study = study_file(STUDY.format(tag=tag))
        rows = rows_of(octant("rss", study, "--tag", "A", "--poses", poses, "-q"))
        levels.append([[float(r[f"rss_{i}_w"]) for i in range(1, 9)] for r in rows])
    np.testing.assert_allclose(levels[1], levels[0], rtol=2e-4)


def test_a_patch_as_tag_hangs_face_down_and_maps(octant, study_file, tmp_path):
    study = study_file(STUDY.format(tag='antenna = "patch"\nazimuth_deg = 45'))
    (tag,) = load_study(study).tags
    assert (tag.axis, tag.azimuth_deg) == ((0.0, 0.0, -1.0), 45.0)
    out = tmp_path / "map.nc"
    assert octant("map", study, "--out", out, "--isotropic").code == 0


def test_tags_keep_their_files_when_a_study_is_written(tmp_path, dipole_file):
    text = STUDY.format(tag='antenna = "dipole.ffe"\naxis = [0, 1, 0]')
    study = parse_study(text, source="s", directory=tmp_path)
    assert study.tags[0].antenna == str(dipole_file)
    again = parse_study(to_toml(study, relative_to=tmp_path), source="s", directory=tmp_path)
    assert again == study


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("dipol", None, "did you mean 'dipole'"),
        ("none.ffe", None, "none.ffe"),
        ("bad.ffe", "no pattern", "bad.ffe"),
    ],
)
def test_antennas_that_do_not_exist_are_refused(octant, study_file, tmp_path, name, content, says):
    if content:
        (tmp_path / name).write_text(content)
    study = study_file(STUDY.format(tag=f'antenna = "{name}"'))
    assert says in octant("paths", study, *ENDS).refused()
    plain = study_file(STUDY.format(tag='antenna = "dipole"'), "plain.toml")
    path = tmp_path / name if "." in name else name
    assert says in octant("paths", plain, *ENDS, "--tx-antenna", path).refused()


def test_an_end_without_direction_is_refused(octant, study_file):
    study = study_file(STUDY.format(tag='antenna = "dipole"'))
    assert "no direction" in octant("paths", study, *ENDS, "--tx-axis", "0,0,0").refused()
    refused = octant("paths", study, *ENDS, "--tx-azimuth-deg", "nan").refused()
    assert "'--tx-azimuth-deg': nan is not in the range" in refused
