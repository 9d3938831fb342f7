"""Every key of a study file is in the reference, with unit, default, range and meaning."""

import re

import list_keys
import msgspec
import pytest

from octant.reader_design.study_file.errors import unit_of
from octant.reader_design.study_file.schema import Study

ROW = re.compile(r"^\| `(\w+)` \| (.*?) \| (.*?) \| (.*) \| (.*) \|$")
UNIT_ENDS = ("_m", "_hz", "_w", "_deg", "_db", "_dbm", "_s", "_ohm", "_m_per_s", "_nw", "_rad")
TABLES = list(dict.fromkeys(list_keys.tables_of(Study)))


def rows_of(table, text):
    section = text.split(f"\n## {table.__name__}\n", 1)[1].split("\n## ", 1)[0]
    found = filter(None, map(ROW.match, section.splitlines()))
    return {row[1]: row.groups()[1:] for row in found}


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.__name__)
def test_each_key_has_its_unit_default_range_and_meaning(table):
    rows = rows_of(table, list_keys.PAGE.read_text("utf-8"))
    keys = [field.encode_name for field in msgspec.structs.fields(table)]
    assert list(rows) == keys
    for key, cells in rows.items():
        assert all(cell.strip() for cell in cells), f"{key}: {cells}"
        assert (cells[0] != "–") == bool(unit_of((key,))), key
        assert cells[0] != "–" or not key.endswith(UNIT_ENDS), f"{key} has no unit"


def test_a_key_without_a_meaning_is_found():
    table = type("Map", (), {})
    rows = rows_of(table, "\n## Map\n| `spacing_m` | m | `0.1` | a number |  |\n")
    assert rows == {"spacing_m": ("m", "`0.1`", "a number", "")}
