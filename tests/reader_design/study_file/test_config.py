"""A study file is read completely, or refused with the key, the value and what is allowed."""

from pathlib import Path

import pytest

from octant.geometries.errors import ConfigError
from octant.reader_design.setting.design import content_hash
from octant.reader_design.study_file.bodies import study_materials
from octant.reader_design.study_file.loading import load_study, parse_study, to_toml
from octant.reader_design.study_file.materials import material_label

MINIMAL = 'name = "x"\n[room]\nbox_m = [5, 5, 3]\n'
TAG = '[[tag]]\nid = "0xFFF9"\nposition_m = [2.0, 0.5, 3.0]\nantenna = "dipole"\n'
MISSION = '[mission]\nnavigator = "thesis"\nstart_m = [1, 1]\ntags = ["0xFFF9"]\n'


def parsed(text):
    return parse_study(text, source="s.toml", directory=Path.cwd())


def refusal(text):
    with pytest.raises(ConfigError) as caught:
        parsed(text)
    message = str(caught.value)
    assert message.startswith("s.toml")
    assert "\n" not in message
    return message


def test_minimal_study_gets_the_documented_defaults():
    study = parsed(MINIMAL)
    assert study.radio.frequencies_hz == (2.4e9,)
    assert study.reader.antenna_radius_m == 0.10
    assert study.reader.response == "fullwave"
    assert study.solver.max_reflections == 3
    assert study.solver.standoff_m == 0.05
    assert study.room.material == "concrete"


def test_map_height_follows_the_reader_unless_given():
    assert parsed(MINIMAL + "[reader]\nheight_m = 0.7\n").map.height_m == 0.7
    assert parsed(MINIMAL + "[map]\nheight_m = 1.2\n").map.height_m == 1.2


def test_channels_replace_the_carrier():
    study = parsed(MINIMAL + "[radio]\nchannels_hz = [2.402e9, 2.48e9]\n")
    assert study.radio.frequencies_hz == (2.402e9, 2.48e9)


def test_built_in_study_is_the_thesis():
    study = load_study("thesis")
    assert [t.id for t in study.tags] == ["0xFFF9", "0xFFF2", "0xFFF5", "0xFFF4"]
    assert [t.position_m for t in study.tags] == [
        (2.0, 0.5, 3.0),
        (3.5, 2.0, 3.0),
        (2.0, 3.5, 3.0),
        (4.0, 3.5, 3.0),
    ]
    assert study.sweep == {
        "antenna": ("dipole", "monopole"),
        "antenna_radius_m": (0.05, 0.10),
        "plate_height_m": (0.0, 0.08, 0.15),
    }
    assert study.mission is not None
    assert (study.mission.start_m, study.mission.heading_deg) == ((0.0, 0.0), 90.0)


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        (
            MINIMAL + "[reader]\nantena_radius_m = 0.1\n",
            ["reader.antena_radius_m", "'antenna_radius_m'"],
        ),
        (MINIMAL + "[raeder]\n", ["raeder", "'reader'"]),
        (MINIMAL + "[sweep]\nplate_heigth_m = [0.1]\n", ["sweep", "'plate_height_m'"]),
        (
            MINIMAL + '[[room.object]]\nkind = "cabnet"\n',
            ["room.object[0].kind", "'cabnet'", "'cabinet'"],
        ),
        (
            MINIMAL + '[[room.object]]\nkind = "cylinder"\nradus_m = 1\n',
            ["room.object[0].radus_m", "'radius_m'"],
        ),
        (MINIMAL + '[room.materials]\n"a b" = {nme = "x"}\n', ["room.materials.'a b'", "'name'"]),
        (MINIMAL + 'material = {wals = "concrete"}\n', ["room.material.wals", "'walls'"]),
        (
            MINIMAL + '[reader]\nresponse = "fulwave"\n',
            ["reader.response", "'fulwave'", "did you mean 'fullwave'", "rays", "isolated"],
        ),
        (MINIMAL + TAG + MISSION.replace("9", "7"), ["mission.tags[0]", "'0xFFF7'", "'0xFFF9'"]),
    ],
)
def test_unknown_names_are_refused_with_the_nearest(text, parts):
    message = refusal(text)
    for part in parts:
        assert part in message


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        (MINIMAL.replace("[5, 5", "[5, -5"), ["room.box_m[1]", "-5 m", "from 0.0001 to 1000 m"]),
        (MINIMAL.replace("[5, 5", "[5, nan"), ["room.box_m[1]", "nan m", "finite"]),
        (MINIMAL.replace("[5, 5", "[inf, 5"), ["room.box_m[0]", "inf m", "finite"]),
        (MINIMAL.replace("[5, 5, 3]", "[5, 5]"), ["room.box_m", "list of 3"]),
        (MINIMAL + "[radio]\nfrequency_hz = -1.0\n", ["radio.frequency_hz", "-1.0 Hz"]),
        (MINIMAL + '[radio]\nfrequency_hz = "2.4 GHz"\n', ["radio.frequency_hz", "a number"]),
        (MINIMAL + "[radio]\nfrequency_hz = 1e15\n", ["radio.frequency_hz", "from 1e6 to 1e12 Hz"]),
        (MINIMAL + "[radio]\nfrequency_hz = 9e11\n", ["room.material", "concrete"]),
        (MINIMAL + "[reader]\nantennas = 2\n", ["reader.antennas", "from 3 to 100"]),
        (MINIMAL + "[reader]\nantenna_radius_m = 0.3\n", ["antenna_radius_m", "0.3 m", "0.1 m"]),
        (MINIMAL + "[sweep]\nplate_height_m = [0.1, 0.1]\n", ["sweep.plate_height_m[1]", "once"]),
        (MINIMAL + "[solver]\nmax_diffractions = 3\n", ["solver.max_diffractions", "3"]),
        (MINIMAL + '[solver]\nsearch = "guess"\n', ["solver.search", "guess"]),
        (MINIMAL + '[solver]\nfaces = "round"\n', ["solver.faces", "round"]),
        (MINIMAL + TAG + TAG, ["tag[1].id", "'0xFFF9'", "tag[0]"]),
        (MINIMAL + TAG + "axis = [0, 0, 0]\n", ["tag[0].axis", "direction"]),
        (MINIMAL + "[[tag]]\nposition_m = [1, 1, 1]\n", ["tag[0].id", "missing"]),
        (MINIMAL + "free_space = true\n", ["box_m and free_space", "exactly one"]),
        ('name = "x"\n[room]\n', ["room", "exactly one"]),
        (MINIMAL + 'unit = "m"\n', ["room.unit", "mesh"]),
        (
            'name = "x"\n[room]\noutline_m = [[0, 0], [4, 0], [1, 4], [4, 4]]\nheight_m = 3\n',
            ["room", "outline", "side"],
        ),
        ('name = "x"\n[room]\noutline_m = [[0, 0], [4, 0], [4, 4]]\n', ["room.height_m"]),
        (
            MINIMAL + "[[room.doorway]]\nwall = 1\noffset_m = 1\nwidth_m = 9\nheight_m = 2\n",
            ["room", "doorway", "wall 1"],
        ),
        (
            MINIMAL + '[[room.object]]\nkind = "mesh"\nfile = "a.stl"\nunit = "mile"\n'
            'position_m = [0, 0, 0]\nmaterial = "pec"\n',
            ["room.object[0].unit", "mile"],
        ),
        (MINIMAL + 'material = "concret"\n', ["room.material", "concret"]),
        (MINIMAL + "material = {thickness_m = 0.1}\n", ["room.material", "name and eps_r"]),
        (MINIMAL + 'material = {walls = "brick"}\n', ["room.material", "floor"]),
        ('name = "x"\n[room]\nmesh = "none.stl"\nmaterial = "metal"\n', ["none.stl", "not exist"]),
        ('name = "x"\nseed = -1\n[room]\n', ["seed", "-1"]),
    ],
)
def test_wrong_values_are_refused_with_key_value_and_what_is_allowed(text, parts):
    message = refusal(text)
    for part in parts:
        assert part in message


@pytest.mark.parametrize(
    ("text", "line"),
    [("name =\n", 1), (MINIMAL + "[radio\n", 4), ('name = "x"\nname = "y"\n', 2)],
)
def test_toml_errors_name_file_and_line(text, line):
    assert refusal(text).startswith(f"s.toml:{line}: ")


def test_missing_file_directory_and_binary_are_refused(tmp_path):
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    for path in (tmp_path / "none.toml", tmp_path, binary):
        with pytest.raises(ConfigError, match=path.name):
            load_study(path)


def test_mesh_files_are_looked_for_beside_the_study_file(tmp_path):
    (tmp_path / "lab.stl").write_text("solid\nendsolid\n")
    text = 'name = "x"\n[room]\nmesh = "lab.stl"\nunit = "m"\nmaterial = "metal"\n'
    (tmp_path / "study.toml").write_text(text)
    study = load_study(tmp_path / "study.toml")
    assert study.room.mesh == str(tmp_path / "lab.stl")
    out = tmp_path / "out"
    out.mkdir()
    written = to_toml(study, relative_to=out)
    assert 'mesh = "../lab.stl"' in written
    (out / "study.toml").write_text(written)
    assert load_study(out / "study.toml") == study


NEAR = """
[[reader.object]]
kind = "box"
size_m = [0.3, 0.3, 0.1]
position_m = [-0.15, -0.15, -0.2]
material = "{material}"
"""


def test_metal_near_the_reader_reaches_its_design_and_changes_its_key():
    plain = parse_study(MINIMAL, source="s.toml", directory=Path())
    near = parse_study(MINIMAL + NEAR.format(material="pec"), source="s.toml", directory=Path())
    design = near.reader
    assert design.surroundings[0].bounds_m.tolist() == [[-0.15, -0.15, -0.2], [0.15, 0.15, -0.1]]
    assert content_hash(design.as_dict()) != content_hash(plain.reader.as_dict())


@pytest.mark.parametrize(
    ("place", "off"),
    [
        ("[-0.15, -0.15, -0.2]", None),
        ("[-0.2, -0.15, -0.2]", "5 cm off the reader's axis (x -5 cm, y +0 cm)"),
        ("[0.0, 0.0, -0.25]", "21.2 cm off the reader's axis (x +15 cm, y +15 cm)"),
        ("[1.0, 0.0, -0.25]", None),  # beside the reader, not under it
    ],
)
def test_metal_under_the_reader_that_is_not_in_its_middle_is_told(place, off):
    text = MINIMAL + NEAR.format(material="pec").replace("[-0.15, -0.15, -0.2]", place)
    notes = parsed(text).reader.notes()
    assert len(notes) == (off is not None)
    if off is not None:
        assert off in notes[0]
        assert "position_m of a box is its lowest corner: [-0.15, -0.15, " in notes[0]


def test_only_metal_may_stand_near_the_reader_and_only_full_wave_sees_it():
    assert "reader.object[0].material" in refusal(MINIMAL + NEAR.format(material="wood"))
    rays = '[reader]\nresponse = "rays"\n'
    assert "reader.response" in refusal(MINIMAL + rays + NEAR.format(material="pec"))


LAYERED = (
    "material = {layers = [{material = 'plasterboard', thickness_m = 0.0125}, "
    "{name = 'air', thickness_m = 0.07}, {eps_r = 4.0, sigma_s_per_m = 0.02}]}\n"
)


def test_layered_wall_is_read_and_written_back():
    study = parsed(MINIMAL + LAYERED)
    layers = study_materials(study)[material_label(study.room.material)].layers
    assert [layer.name for layer in layers[:2]] == ["plasterboard", "air"]
    assert [layer.thickness_m for layer in layers] == [0.0125, 0.07, None]
    assert layers[2].sigma_c_s_per_m == 0.02
    assert parsed(to_toml(study)) == study
    furniture = "[[room.object]]\nkind = 'box'\nsize_m = [1, 1, 1]\nposition_m = [1, 1, 0]\n"
    furnished = parsed(MINIMAL + furniture + LAYERED)
    assert parsed(to_toml(furnished)) == furnished


@pytest.mark.parametrize(
    ("layers", "words"),
    [
        ("[{name = 'wood', thickness_m = 0.1}]", "a list of at least 2 is needed"),
        ("[{name = 'wood', eps_r = 2.0}, {name = 'air'}]", "layers[0] gives name and eps_r"),
        ("[{thickness_m = 0.1}, {name = 'air'}]", "layers[0] gives neither"),
        ("[{name = 'wood'}, {name = 'air'}]", "no thickness_m"),
        ("[{material = 'wod', thickness_m = 0.1}, {name = 'air'}]", "did you mean 'wood'"),
        ("[{name = 'a', tickness_m = 0.1}, {name = 'air'}]", "thickness_m"),
    ],
)
def test_bad_layers_are_refused_with_their_path(layers, words):
    message = refusal(MINIMAL + f"material = {{layers = {layers}}}\n")
    assert words in message
    assert "room.material" in message


def test_a_layer_far_outside_its_frequencies_is_refused_with_its_path():
    layers = "material = {layers = [{name = 'brick', thickness_m = 0.1}, {name = 'air'}]}\n"
    message = refusal(MINIMAL + layers + "[radio]\nfrequency_hz = 0.3e9\n")
    assert "room.material" in message
    assert "1 to 40 GHz" in message


def test_layers_stand_alone():
    message = refusal(MINIMAL + LAYERED.replace("layers", "thickness_m = 0.1, layers"))
    assert "thickness_m beside layers" in message


PLAIN_ROOM = "[room]\nbox_m = [4.0, 4.0, 3.0]\n"


def with_rules(text):
    return parse_study(PLAIN_ROOM + text, source="test", directory=Path())


def test_rules_of_the_choice_are_data_of_the_study():
    study = with_rules(
        "[scoring]\nnoise_db = 2.0\nbits = 0\n[choice]\ngreatest_height_m = 0.1\nmissions = 3\n"
        '[[choice.criterion]]\nroom = "captured_share"\ntolerance = 0.05\n'
        '[[choice.criterion]]\nfree = "level_median_dbm"\n'
    )
    assert study.scoring.bits == 0
    assert [c.room or c.free for c in study.choice.criteria] == [
        "captured_share",
        "level_median_dbm",
    ]
    assert parse_study(to_toml(study), source="again", directory=Path()) == study


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[[choice.criterion]]\nroom = "captured_shar"\n', "captured_share"),
        ("[[choice.criterion]]\ntolerance = 1.0\n", "names no score"),
        (
            '[[choice.criterion]]\nfree = "right_share"\nroom = "vector_rms_rad"\n',
            "cannot be averaged",
        ),
        ("[choice]\ncriterion = []\n", "criterion"),
        ("[choice]\nmissions = 0\n", "missions"),
        ("[choice]\nby_missions = true\nmissions = 3\n", r"no \[mission\]"),
        ("[scoring]\nfloor_dbm = 0.0\n", "codes must rise"),
        ("[scoring]\nbits = 17\n", "bits"),
        ("[scoring]\nnoise_db = -1.0\n", "noise_db"),
    ],
)
def test_wrong_rules_are_refused_with_what_is_allowed(text, said):
    with pytest.raises(ConfigError, match=said):
        with_rules(text)
