"""Bad input of every kind: one sentence, exit code 2, no traceback."""

import resource

import pytest

ROOM = '[room]\nbox_m = [7.0, 7.0, 3.0]\norigin_m = [-1, -1, 0]\nmaterial = "concrete"\n'
TAG = '[[tag]]\nid = "a"\nposition_m = [2.0, 0.5, 3.0]\nantenna = "dipole"\n'
MISSION = '[mission]\nstart_m = [0, 0]\ntags = ["a"]\n'
CABINET = (
    '[[room.object]]\nkind = "cabinet"\nsize_m = [1.5, 0.35, 1.0]\nposition_m = [1.0, 2.0, 0.0]\n'
)
STL = """solid s
facet normal 0 0 1
outer loop
vertex {0} 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
endsolid s
"""
VERBS = (
    ("study", "--out", "{out}"),
    ("map", "--out", "{out}/m.nc"),
    ("navigate", "--out", "{out}"),
    ("rss", "--tag", "a", "--poses", "{poses}"),
    ("paths", "--tx", "1,1,1", "--rx", "2,2,1"),
)


@pytest.fixture
def refusal(octant, study_file, tmp_path):
    """The sentence with which a verb refuses a study."""

    def call(text, verb=VERBS[1]):
        (tmp_path / "poses.csv").write_text("x_m,y_m,heading_deg\n1,1,90\n")
        fill = {"out": tmp_path / "out", "poses": tmp_path / "poses.csv"}
        name, *options = verb
        study = study_file('name = "bad"\n' + text)
        sentence = octant(name, study, *[o.format(**fill) for o in options]).refused()
        assert not (tmp_path / "out").exists()
        return sentence

    return call


@pytest.mark.parametrize("verb", VERBS, ids=lambda verb: verb[0])
@pytest.mark.parametrize(
    ("text", "part"),
    [
        (ROOM + TAG + MISSION + "[reader]\nantenna_radus_m = 0.1\n", "'antenna_radius_m'"),
        (ROOM.replace("concrete", "concret") + TAG + MISSION, "'concrete'"),
        (ROOM + TAG + MISSION + "[reader]\nantenna_radius_m = 0.3\n", "0.3 m"),
        (ROOM + TAG.replace("0.5, 3.0", "0.5, 4.0") + MISSION, "outside the room"),
        (ROOM + TAG + MISSION + "[radio]\nfrequency_hz = 300e9\n", "300 GHz"),
        (
            ROOM + CABINET + TAG.replace("2.0, 0.5, 3.0", "2.0, 2.2, 0.5") + MISSION,
            "inside a solid",
        ),
        (ROOM + TAG + MISSION.replace("[0, 0]", "[9, 0]"), "mission.start_m"),
        (ROOM + TAG + MISSION.replace("[0, 0]", "[-0.95, 0]"), "0.05 m from a wall"),
        (ROOM + CABINET + TAG + MISSION.replace("[0, 0]", "[2, 2.1]"), "inside an object"),
        (ROOM + TAG + MISSION + "[reader]\nheight_m = 3.5\n", "reader.height_m"),
        ('[room]\nmesh = "none.stl"\nmaterial = "metal"\n' + TAG + MISSION, "none.stl"),
        (ROOM + TAG + "position_m = [1, 1, 1]\n", "study.toml:10"),
    ],
    ids=[
        "unknown key",
        "unknown material",
        "r_a beyond the ground plane",
        "tag outside",
        "frequency outside the table",
        "tag inside the cabinet",
        "start outside",
        "antenna inside a wall",
        "start inside the cabinet",
        "reader above the ceiling",
        "missing mesh",
        "not TOML",
    ],
)
def test_bad_studies_are_refused_by_every_verb(refusal, text, part, verb):
    assert part in refusal(text, verb)


@pytest.mark.parametrize(
    ("content", "unit", "part"),
    [
        (STL.format(0), "", "unit"),
        (STL.format("nan"), 'unit = "m"\n', "NaN"),
        ("solid s\nendsolid s\n", 'unit = "m"\n', "no triangles"),
        ("", 'unit = "m"\n', "room.stl"),
        (STL.format(0), 'unit = "mile"\n', "mile"),
    ],
    ids=["no unit", "NaN vertices", "empty mesh", "empty file", "unknown unit"],
)
def test_bad_meshes_are_refused(refusal, tmp_path, content, unit, part):
    (tmp_path / "room.stl").write_text(content)
    assert part in refusal(f'[room]\nmesh = "room.stl"\n{unit}material = "metal"\n' + TAG)


@pytest.mark.parametrize(("name", "part"), [("none.stl", "does not exist"), ("mesh.xyz", "xyz")])
def test_audit_refuses_what_is_no_mesh(octant, tmp_path, name, part):
    if name != "none.stl":
        (tmp_path / name).write_text(STL.format(0))
    assert part in octant("audit", tmp_path / name).refused()


def test_layouts_are_named_when_they_are_wrong(refusal):
    layout = '[[layout]]\nname = "full"\n[[layout.object]]\nkind = "box"\nmaterial = "wood"\n'
    layout += "size_m = [7, 7, 1.5]\nposition_m = [-1, -1, 1.5]\n"
    sentence = refusal(ROOM + TAG + MISSION + layout, VERBS[0])
    assert "layout 'full'" in sentence
    assert "tag[0].position_m" in sentence


@pytest.mark.parametrize(
    ("verb", "part"),
    [
        (("map", "--out", "{out}/m.nc", "--antenna", "9"), "1 to 8"),
        (("map", "--out", "{out}/m.nc", "--antenna", "1", "--isotropic"), "--isotropic"),
        (("map", "--out", "{out}/m.nc", "--tag", "b"), "'b'"),
        (("rss", "--tag", "A", "--poses", "{poses}"), "'a'"),
        (("rss", "--tag", "a", "--poses", "{out}"), "cannot be read"),
        (("navigate", "--out", "{out}", "--runs", "0"), "runs"),
        (("navigate", "--out", "{out}", "--noise-db", "-1"), "noise-db"),
    ],
)
def test_bad_options_are_refused(refusal, verb, part):
    assert part in refusal(ROOM + TAG + MISSION, verb)


def test_driving_needs_a_mission_and_maps_need_a_tag(refusal):
    assert "[mission]" in refusal(ROOM + TAG, VERBS[2])
    assert "[[tag]]" in refusal(ROOM, VERBS[1])


def test_maps_that_would_not_fit_into_memory_are_refused(refusal):
    assert "map.spacing_m" in refusal(ROOM + TAG + "[map]\nspacing_m = 1e-6\n")


def test_a_disk_that_is_full_is_one_sentence(octant, study_file, tmp_path):
    """A limit on the size of files stands for the disk's end; HDF5 took the process with it."""
    study, out = study_file(ROOM + TAG + MISSION), tmp_path / "map.nc"
    before = tmp_path / "before.nc"  # nothing is left to compile, which writes files too
    assert octant("map", study, "--out", before, "--isotropic").code == 0
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, limits[1]))
    try:
        call = octant("map", study, "--out", out, "--isotropic", "--quiet")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    said = call.refused()
    assert str(out) in said
    assert "make room" in said
    assert sorted(path.name for path in tmp_path.iterdir()) == ["before.nc", "study.toml"]


def test_output_that_exists_is_kept(octant, study_file, tmp_path):
    study = study_file('name = "x"\n' + ROOM + TAG + MISSION)
    out = tmp_path / "missions.csv"
    out.write_text("mine")
    assert "--force" in octant("navigate", study, "--out", tmp_path).refused()
    assert "--force" in octant("map", study, "--out", out).refused()
    assert out.read_text() == "mine"


def test_output_under_a_file_is_refused(octant, study_file):
    study = study_file('name = "x"\n' + ROOM + TAG + "[map]\nspacing_m = 3.0\n")
    octant("map", study, "--out", study / "m.nc", "--isotropic").refused()


@pytest.mark.parametrize("frequency", ["0", "-1", "nan", "inf"])
def test_materials_need_a_frequency(octant, frequency):
    assert "--frequency-ghz" in octant("materials", "--frequency-ghz", frequency).refused()


def test_poses_with_bad_numbers_name_the_line(octant, study_file, tmp_path):
    poses = tmp_path / "poses.csv"
    poses.write_text("x_m,y_m,heading_deg\n1,1,90\n1,one,90\n")
    study = study_file('name = "x"\n' + ROOM + TAG)
    sentence = octant("rss", study, "--tag", "a", "--poses", poses).refused()
    assert "poses.csv:3: y_m is 'one'" in sentence


@pytest.mark.parametrize(
    ("keys", "part"),
    [
        ("sample_time_s = 0\n", "mission.sample_time_s"),
        ("sample_time_s = -1.0\n", "mission.sample_time_s"),
        ('navigator = "thesys"\n', "'thesis'"),
        ("starts = [[1.5, 2.1, 0.0]]\n", "mission.starts[0]"),
        (
            (
                "[mission.membership]\ninput = { Z = [1, 0, -1] }\nspeed = { M = [0, 0.5, 1] }\n"
                'rules = { Z = ["M", "M"] }\n'
            ),
            "must not decrease",
        ),
        (
            (
                "[mission.membership]\ninput = { N = [-1, -1, 1], P = [-1, 1, 1] }\n"
                'speed = { M = [0, 0, 1, 1] }\nrules = { N = ["M", "M"] }\n'
            ),
            "incomplete",
        ),
    ],
    ids=[
        "no time",
        "time backwards",
        "unknown navigator",
        "start in an object",
        "unordered terms",
        "a term without a rule",
    ],
)
def test_missions_that_cannot_be_driven_are_refused(refusal, keys, part):
    reader = '[reader]\nresponse = "isolated"\n'
    assert part in refusal(ROOM + CABINET + TAG + reader + MISSION + keys, VERBS[2])


def test_ends_so_close_that_more_would_arrive_than_was_sent_are_refused(octant, study_file):
    # Friis: (1.64 lambda / (4 pi d))^2 is above 1 nearer than 1.63 cm at 2.4 GHz.
    study = study_file('name = "x"\n[room]\nfree_space = true\n')
    near, far = ("1.0162,1,1", "1.0164,1,1")
    octant("paths", study, "--tx", "1,1,1", "--rx", far)
    assert "(1.0162, 1, 1) m" in octant("paths", study, "--tx", "1,1,1", "--rx", near).refused()


@pytest.mark.parametrize("given", ["x" * 5000, "1" * 5000 + "x"])
def test_what_was_given_is_repeated_only_in_part_where_it_is_long(octant, study_file, given):
    options = ("room.glb", "--azimuth-deg", given)
    sentence = octant("scene", study_file(), *options).refused()
    assert "--azimuth-deg" in sentence
    assert len(sentence) < 400


def test_a_long_name_of_a_file_is_repeated_only_in_part(octant):
    sentence = octant("explain", "x" * 5000, "--tx", "1,1,1", "--rx", "2,1,1").refused()
    assert "does not exist" in sentence or "name too long" in sentence.lower()
    assert len(sentence) < 400
