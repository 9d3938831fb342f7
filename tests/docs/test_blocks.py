"""Whatever README and the documentation tell a reader to type is right: parsed here, run by hand.

The quick tests check every command by click, every table by the reader of study files and every
script by its names. The slow one follows each page word by word.
"""

import ast
import shutil

import doc_blocks
import make_files
import pytest
from doc_blocks import ROOT

import octant
from octant.geometries.errors import ConfigError
from octant.reader_design.cli import VERBS
from octant.reader_design.experiments.missions.comparison_table import load_comparison
from octant.reader_design.study_file.loading import study_of_tables

FOLLOWED = ["start", "concepts", "howto", "reference"]
"""Folders of docs whose pages are done word by word; tutorials are run by the build of the site."""
BARE = {
    "room": {"box_m": [8.0, 8.0, 3.0], "material": "concrete"},
    "tag": [{"id": "1", "position_m": [1.0, 1.0, 2.0]}],
}


def ids(blocks):
    return [str(block) for block in blocks]


SHELL = doc_blocks.all_blocks("sh", "bash", "console", "shell")
TOML = doc_blocks.all_blocks("toml")
PYTHON = doc_blocks.all_blocks("python", "ipython3")


@pytest.mark.parametrize("block", SHELL, ids=ids(SHELL))
def test_every_command_is_one_that_octant_takes(block):
    for words in doc_blocks.commands(block.text):
        doc_blocks.checked(words)


def test_options_in_running_text_exist():
    wrong = []
    for page in [*doc_blocks.pages(), ROOT / "CHANGELOG.md"]:
        for span, words in doc_blocks.inline_calls(page):
            verb, given = words[0], {w.split("=")[0] for w in words if w.startswith("--")}
            if verb not in VERBS or given - doc_blocks.known_options(verb) - {"--help"}:
                wrong.append(f"{page.name}: {span}")
    assert wrong == []


@pytest.mark.parametrize("block", TOML, ids=ids(TOML))
def test_every_table_is_one_that_a_study_takes(block, tmp_path):
    tables = doc_blocks.tables(block)
    if any("study" in layout for layout in tables.get("layout", ())):
        return read_as_comparison(block, tmp_path)
    tables = tables if block.caption else BARE | tables
    try:
        study_of_tables(tables, source=str(block), directory=ROOT)
    except ConfigError as exc:
        if "does not exist in" not in str(exc):  # what an earlier step of the page writes
            raise
    return None


def read_as_comparison(block, folder):
    (folder / "comparison.toml").write_text(block.text, "utf-8")
    for layout in doc_blocks.tables(block)["layout"]:
        (folder / layout["study"]).write_text('[room]\nbox_m = [4, 4, 3]\nmaterial = "brick"\n')
    load_comparison(folder / "comparison.toml")


@pytest.mark.parametrize("block", PYTHON, ids=ids(PYTHON))
def test_every_script_uses_names_that_are_there(block):
    for node in ast.walk(ast.parse(block.text)):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            assert node.value.id != "octant" or hasattr(octant, node.attr), node.attr


def test_a_wrong_command_is_found():
    for text in (
        "octant study --runs 3",
        "octant swim room.toml",
        "octant map examples/nothing.toml --out map.nc",
        "octant paths s.toml --tx 1,2 --rx 1,1,1",
        "octant explain",
        "rm -r octant-study",
    ):
        words = next(doc_blocks.commands(text))
        with pytest.raises((AssertionError, doc_blocks.click.ClickException)):
            doc_blocks.checked(words)


PAGES = [
    page
    for page in doc_blocks.pages()
    if page.name == "README.md" or page.parent.name in FOLLOWED
    if any(doc_blocks.blocks(page))
]


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_followed_word_by_word(page, tmp_path, monkeypatch):
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    doc_blocks.carried_out(page, tmp_path)


def test_every_name_of_python_is_in_its_table():
    text = (ROOT / "docs" / "reference" / "python.md").read_text("utf-8").split("```", 1)[0]
    assert [name for name in octant.__all__ if f"`{name}`" not in text] == []


def test_the_readme_is_one_page():
    text = (ROOT / "README.md").read_text("utf-8")
    assert len(text.split()) <= 500
    assert text.count("![") == 1


def test_every_column_of_an_output_file_is_explained():
    meanings, used, missing = make_files.known_meanings(), set(), []
    for _, file, place in make_files.CSV_FILES:
        for column in make_files.columns(place):
            used |= {column, make_files.unit_and_stem(column)[1]}
            if make_files.meaning(column, meanings) is None:
                missing.append(f"{file}: {column}")
    assert missing == [], "docs/columns.toml"
    assert set(meanings) - used == set(), "docs/columns.toml explains what is not there"
