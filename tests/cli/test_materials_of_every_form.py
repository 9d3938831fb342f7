"""Every form of a material in every verb that makes a room: a name, a slab, own numbers, layers."""

import pytest
from part_of_study import part_for

FORMS = {
    "name": '"brick"',
    "slab": '{name = "concrete", thickness_m = 0.1}',
    "own numbers": "{eps_r = 5.24, sigma_s_per_m = 0.04}",
    "layers": '{layers = [{material = "plasterboard", thickness_m = 0.0125}, '
    '{material = "wood", thickness_m = 0.05}]}',
    "pec": '"pec"',
    "metal": '"metal"',
}
STUDY = """
name = "w"
[radio]
frequency_hz = {frequency_hz}
[room]
box_m = [4.0, 3.5, 2.2]
material = {material}
[[room.object]]
kind = "box"
size_m = [0.4, 0.3, 0.5]
position_m = [3.0, 2.8, 0.0]
material = {material}
[[tag]]
id = "a"
position_m = [1.5, 1.2, 2.1]
antenna = "dipole"
[solver]
max_reflections = 1
[reader]
antennas = 4
response = "{response}"
cells_per_wavelength = 5.0
[map]
spacing_m = 1.0
[mission]
navigator = "thesis"
start_m = [1.0, 1.0]
tags = ["a"]
runs = 1
max_time_s = 5.0
[dock]
tag = "a"
landmark_position_m = [3.9, 1.2, 0.5]
landmark_heading_deg = 0.0
runs = 1
start_low_m = [0.8, 0.8]
start_high_m = [1.0, 1.0]
[optimise]
parameters = {{antenna_length_m = [0.04, 0.07]}}
survey = 1
starts = 1
evaluations = 1
[[optimise.goal]]
score = "right_share"
value = 1.0
[tolerance]
room = true
samples = 1
"""
QUICK = (
    "paths STUDY --tx 1.5,1.2,1.9 --rx 1,1,0.3",
    "explain STUDY --tx 1.5,1.2,1.9 --rx 1,1,0.3",
    "sweep STUDY --out OUT --dry-run",
    "navigate STUDY --out OUT --dry-run",
    "dock STUDY --out OUT --dry-run",
    "optimise STUDY --out OUT --dry-run",
    "tolerance STUDY --out OUT --dry-run",
    "study STUDY --out OUT --dry-run",
)
WHOLE = (
    "sweep STUDY --out OUT --workers 1",
    "map STUDY --out OUT/map.nc --isotropic",
    "navigate STUDY --out OUT --workers 1",
)


def called(octant, study_file, tmp_path, call, form, **changes):
    """Return what a verb says to a study whose room is of one form of material."""
    keys = {"frequency_hz": "2.4e9", "response": "isolated", "material": FORMS[form]} | changes
    study = study_file(part_for(call.split()[0], STUDY.format(**keys)))
    words = call.replace("STUDY", str(study)).replace("OUT", str(tmp_path / "out")).split()
    return octant(*words)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("call", QUICK, ids=lambda call: call.split()[0])
def test_every_verb_takes_every_form(octant, study_file, tmp_path, call, form):
    full = {"response": "fullwave"} if call.startswith("tolerance") else {}
    done = called(octant, study_file, tmp_path, call, form, **full)
    assert done.code == 0, done.err
    assert not done.problems


@pytest.mark.slow
@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("call", WHOLE, ids=lambda call: call.split()[0])
def test_every_verb_computes_with_every_form(octant, study_file, tmp_path, call, form):
    assert called(octant, study_file, tmp_path, call, form).code == 0


@pytest.mark.parametrize("form", FORMS)
def test_every_form_makes_a_room_for_uhf(octant, study_file, tmp_path, form):
    done = called(octant, study_file, tmp_path, QUICK[0], form, frequency_hz="868e6")
    assert done.code == 0
    fitted_from_1_ghz = form in ("name", "slab", "layers")
    assert ("is extrapolated" in done.err) == fitted_from_1_ghz
