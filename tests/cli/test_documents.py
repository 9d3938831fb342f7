"""``--json``: one document a call, whose every key is documented, without NaN."""

import json
import math

import pytest
from small_study import SMALL

from octant.geometries.furniture import box
from octant.geometries.mesh_files import save_bodies
from octant.reader_design.cli import VERBS
from octant.reader_design.terminal.documents import csv_rows, json_text
from octant.reader_design.terminal.schemas import SCHEMAS

STUDY = SMALL + "runs = 2\nmax_time_s = 10.0\n"
CALLS = {
    "paths": ("STUDY", "--tx", "A", "--rx", "1,1,1", "--rx", "9,9,9"),
    "explain": ("STUDY", "--tx", "A", "--rx", "1,1,1", "--strongest"),
    "rss": ("STUDY", "--tag", "A", "--poses", "poses.csv", "--readings", "2"),
    "scene": ("STUDY", "--tx", "A", "--rx", "1,1,1"),
    "map": ("STUDY", "--threshold-dbm", "-30"),
    "reader": ("STUDY", "--step-deg", "45"),
    "navigate": ("STUDY",),
    "materials": ("--frequency-ghz", "0.3"),
    "audit": ("box.obj", "--unit", "m"),
}


def key_paths(value, at=""):
    """Yield the path of every value of a document, as `SCHEMAS` writes it."""
    if isinstance(value, dict) and value:
        for key, each in value.items():
            yield from key_paths(each, f"{at}.{key}" if at else key)
    elif isinstance(value, list) and value:
        for each in value:
            yield from key_paths(each, f"{at}[]")
    else:
        yield at


def is_documented(path, known):
    """Return whether a path stands in a schema, or within a key that the run decides."""
    if any(other == path or other.startswith((f"{path}[]", f"{path}.")) for other in known):
        return True
    parts = path.split(".")
    return any(
        len(pattern) == len(parts)
        and all(a in (b, "*", "*[]") or (a == "*[]" and b.endswith("[]")) for a, b in pairs)
        for other in known
        for pattern in [other.split(".")]
        for pairs in [list(zip(pattern, parts, strict=False))]
    )


@pytest.mark.parametrize("verb", list(CALLS))
def test_every_key_of_a_document_is_documented(octant, study_file, tmp_path, monkeypatch, verb):
    monkeypatch.chdir(tmp_path)
    study_file(STUDY)
    (tmp_path / "poses.csv").write_text("x_m,y_m,heading_deg\n1,1,90\n")
    save_bodies([box((1.0, 2.0, 3.0), material="wood")], tmp_path / "box.obj")
    words = [{"STUDY": "study.toml"}.get(word, word) for word in CALLS[verb]]
    call = octant(verb, *words, "--json", "-q")
    assert call.code == 0, call.err
    document = json.loads(call.out, parse_constant=pytest.fail)
    assert document["verb"] == verb
    found = set(key_paths(document))
    assert {path for path in found if not is_documented(path, SCHEMAS[verb])} == set()
    promised = {key for key in SCHEMAS[verb] if "*" not in key and key != "dry_run"}
    assert {key for key in promised if key.split("[")[0].split(".")[0] not in document} == set()


def test_every_verb_with_results_has_a_schema():
    assert set(SCHEMAS) <= set(VERBS)


def test_infinite_numbers_are_null_and_complex_ones_pairs(tmp_path):
    text = json_text({"a": math.nan, "b": [-math.inf, 1.5], "c": 1 - 2j, "d": tmp_path})
    assert json.loads(text) == {
        "a": None,
        "b": [None, 1.5],
        "c": {"re": 1.0, "im": -2.0},
        "d": str(tmp_path),
    }


def test_columns_of_a_table_keep_one_type(tmp_path):
    file = tmp_path / "t.csv"
    file.write_text("run,share,name\n0,0.5,A\n1,,7\n")
    assert csv_rows(file) == [
        {"run": 0, "share": 0.5, "name": "A"},
        {"run": 1, "share": None, "name": "7"},
    ]
