"""Every experiment with every table: read, or refused with the names of the verbs that read it."""

import itertools

import msgspec
import pytest

import octant
from octant.geometries.errors import ConfigError
from octant.reader_design import cli
from octant.reader_design.study_file.loading import load_study, to_toml
from octant.reader_design.study_file.schema import Study
from octant.reader_design.study_file.tables_read import (
    EXPERIMENTS,
    READ_BY,
    SHARE_A_STUDY,
    check_tables,
)

BASE = """
[room]
box_m = [5.0, 5.0, 3.0]
[[tag]]
id = "tag"
position_m = [2.0, 2.0, 2.9]
antenna = "dipole"
"""
TABLES = {
    "sweep": "[sweep]\nantenna_radius_m = [0.05, 0.10]",
    "scoring": "[scoring]\nnoise_db = 2.0",
    "choice": "[choice]\nmissions = 3",
    "map": "[map]\nspacing_m = 0.2",
    "mission": '[mission]\nnavigator = "thesis"\nstart_m = [1.0, 1.0]\ntags = ["tag"]',
    "robot": '[robot]\npreset = "scout"',
    "sensor": "[sensor]\nbits = 8",
    "tolerance": "[tolerance]\nsamples = 3",
    "layout": '[[layout]]\nname = "second"',
    "optimise": "[optimise]\nparameters = {antenna_length_m = [0.04, 0.07]}",
    "track": "[track]",
    "report": "[report]\nthesis = true",
    "rfid": '[[tag]]\nid = "p"\nposition_m = [1, 1, 2.9]\nkind = "passive"\n[rfid]\npower_w = 1.0',
    "truth": "[truth]\ntag_sd_m = 0.01",
    "dock": '[dock]\ntag = "tag"\nlandmark_position_m = [0.5, 2.0, 0.5]',
}
READ_BY_ALL = {"name", "seed", "radio", "room", "tag", "reader", "solver", "log", "calibration"}
QUESTIONS = {"paths", "explain", "scene", "map", "rss", "reader"}
LOGS = {"simulate-log", "replay", "compare", "calibrate"}
NO_STUDY = {"demo", "audit", "completion", "init", "materials", "warm-up"}


def test_every_verb_and_every_table_is_thought_of():
    assert set(cli.octant.list_commands(None)) == EXPERIMENTS | QUESTIONS | LOGS | NO_STUDY
    tables = {field.encode_name for field in msgspec.structs.fields(Study)}
    assert tables == READ_BY_ALL | set(TABLES)
    assert set(READ_BY) == set(TABLES)


@pytest.mark.parametrize(("verb", "table"), list(itertools.product(sorted(EXPERIMENTS), TABLES)))
def test_a_table_is_read_or_refused(verb, table, tmp_path):
    file = tmp_path / "study.toml"
    file.write_text(BASE + TABLES[table])
    study = load_study(file)
    shared = verb in SHARE_A_STUDY and table not in ("track", "dock")
    if verb in READ_BY[table] or shared:
        check_tables(study, verb)
    else:
        with pytest.raises(ConfigError) as refusal:
            check_tables(study, verb)
        named = {other for other in EXPERIMENTS if f"'octant {other}'" in str(refusal.value)}
        assert named == {verb, *READ_BY[table]} & EXPERIMENTS


@pytest.mark.parametrize("verb", sorted(EXPERIMENTS))
def test_defaults_that_are_written_out_say_nothing(verb, tmp_path):
    file = tmp_path / "study.toml"
    file.write_text(BASE)
    whole = tmp_path / "whole.toml"
    whole.write_text(to_toml(load_study(file)))
    assert "[sensor]" in whole.read_text()
    check_tables(load_study(whole), verb)


def test_the_command_and_python_refuse_alike(tmp_path, capsys):
    file = tmp_path / "study.toml"
    file.write_text(BASE + TABLES["mission"])
    for call in ("track", "dock"):
        with pytest.raises(ConfigError, match=r"\[mission\].*'octant study' and 'octant navigate'"):
            getattr(octant.Study.load(file), call)(tmp_path / "out", progress=False)
        assert cli.run([call, str(file), "--out", str(tmp_path / "out")]) == 2
        assert "[mission], which" in capsys.readouterr().err
