"""``octant explain``: the budget of one path adds up to what ``octant paths`` says of it."""

import csv
import io
import math

import pytest

ENDS = ("--tx", "3.5,2,2.9", "--rx", "1.213,4.381,0.3")
ANTENNAS = ("--tx-antenna", "patch", "--rx-antenna", "dipole", "--rx-axis", "1,0,1")


def table(call):
    assert call.code == 0, call.err
    return list(csv.DictReader(io.StringIO(call.out)))


@pytest.mark.parametrize("number", [0, 7, 40, 62])
def test_the_lines_add_up_to_the_gain_of_octant_paths(octant, study_file, number):
    study = study_file()
    path = table(octant("paths", study, *ENDS, *ANTENNAS, "--csv", "-"))[number]
    lines = table(octant("explain", study, *ENDS, *ANTENNAS, "--path", number, "--csv", "-"))
    total = sum(float(line["change_db"]) for line in lines)
    assert total == pytest.approx(float(path["gain_db"]), abs=1e-9)
    assert float(lines[-1]["level_db"]) == pytest.approx(total, abs=1e-9)
    steps = ["transmitter", "free space", *["reflection"] * int(path["order"])]
    assert [line["step"] for line in lines] == [*steps, "polarisation", "receiver"]
    places = [tuple(float(line[f"{a}_m"]) for a in "xyz") for line in lines if line["x_m"]]
    vertices = [tuple(float(c) for c in v.split(":")) for v in path["vertices"].split(";")]
    assert places == vertices


def test_without_a_number_the_strongest_path_is_explained(octant, study_file):
    study = study_file()
    rows = table(octant("paths", study, *ENDS, "--csv", "-"))
    best = max(rows, key=lambda row: float(row["gain_db"]))
    call = octant("explain", study, *ENDS, "--strongest")
    assert call.code == 0
    assert call.out.startswith(
        f"path {best['path']} of 63 (line of sight; rank 1 by power), 2.4 GHz"
    )
    assert f"gain {float(best['gain_db']):.3f} dB" in call.out
    assert octant("explain", study, *ENDS).out == call.out


def test_a_conductor_turns_te_by_half_a_turn_and_loses_nothing(octant, study_file):
    study = study_file('[room]\nbox_m = [5, 5, 3]\nmaterial = "pec"\n')
    (line,) = [
        row
        for row in table(octant("explain", study, *ENDS, "--path", 1, "--csv", "-"))
        if row["step"] == "reflection"
    ]
    assert float(line["change_db"]) == pytest.approx(0.0, abs=1e-9)
    assert abs(float(line["te_phase_deg"])) == pytest.approx(180.0)
    assert float(line["tm_phase_deg"]) == pytest.approx(0.0, abs=1e-9)
    assert line["material"] == "pec"
    cosine = math.cos(math.radians(float(line["incidence_deg"])))
    assert 0.0 < cosine < 1.0


def test_no_path_is_a_result(octant, study_file):
    cabinet = (
        '[[room.object]]\nkind = "cabinet"\n'
        "size_m = [1.5, 0.35, 1.0]\nposition_m = [1.75, 2.2, 0]\n"
    )
    study = study_file("[room]\nbox_m = [5, 5, 3]\n" + cabinet)
    call = octant("explain", study, "--tx", "3.5,2,2.9", "--rx", "2.1,2.41,0.37")
    assert call.code == 0
    assert "no path arrives" in call.out


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--path", 99), "numbered 0 to 62"),
        (("--path", 1, "--strongest"), "give one"),
        (("--path", -1), "--path"),
        (("--rx-antenna", "helix"), "helix"),
    ],
)
def test_what_cannot_be_explained_is_refused(octant, study_file, arguments, says):
    assert says in octant("explain", study_file(), *ENDS, *arguments).refused()


def test_existing_csv_is_kept_without_force(octant, study_file, tmp_path):
    out = tmp_path / "budget.csv"
    out.write_text("mine")
    arguments = ("explain", study_file(), *ENDS, "--csv", out)
    assert "--force" in octant(*arguments).refused()
    assert out.read_text() == "mine"
    assert octant(*arguments, "--force").code == 0
    assert out.read_text().startswith("step,change_db,level_db,")
