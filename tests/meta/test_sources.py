"""The table of the three documents: places exist, pages are up to date, and the check can fail."""

import make_sources
import pytest

ROWS, RUNS = make_sources.rows_and_runs()


def test_every_row_of_the_sources_has_its_place_and_its_values():
    assert list(make_sources.complaints(ROWS, RUNS)) == []


@pytest.mark.parametrize(
    ("file", "page"),
    [("sources.md", make_sources.sources_page), ("published.md", make_sources.published_page)],
)
def test_the_pages_of_the_sources_are_up_to_date(file, page):
    found = (make_sources.PAGES / file).read_text("utf-8") == page(ROWS, RUNS)
    assert found, f"docs/evidence/{file}: python docs/make_sources.py"


@pytest.mark.parametrize(
    ("place", "there"),
    [
        ("octant.navigation.robot.drive", True),
        ("octant.navigation.robot.drive:DifferentialDrive.saturate", True),
        ("octant.navigation.sensing.bearing:FRONT_AZIMUTH_RAD", True),
        ("octant.navigation.robot.drive:Tricycle", False),
        ("octant track", True),
        ("octant swim", False),
        ("[mission] steering_input", True),
        ("[mission.tracker] trust", True),
        ("[[tag]] position_m", True),
        ("[mission] steering_wheel", False),
        ("[boat] sail", False),
        ("examples/layouts/open_space.toml", True),
        ("examples/layouts/sea.toml", False),
        ("tests/meta/test_sources.py::test_a_place_is_known_only_where_it_is", True),
        ("tests/meta/test_sources.py::test_nothing", False),
    ],
)
def test_a_place_is_known_only_where_it_is(place, there):
    assert make_sources.known_places(place) is there


def test_what_is_wrong_with_a_row_is_said():
    row = {"source": "a", "where": "b", "place": ["octant swim"], "state": "pending", "run": "x"}
    row |= {"colour": "red", "ours": [{"file": "a.csv", "column": "c"}]}
    said = "\n".join(make_sources.complaints([row], {"y": "octant swim sea.toml"}))
    for part in ("colour", "pending", "octant swim", "command 'x'", "no value", "sea.toml"):
        assert part in said
    bare = {"source": "a", "where": "b"}
    assert "names its place" in next(make_sources.complaints([bare], {}))
    assert list(make_sources.complaints([bare | {"state": "outlook"}], {})) == []


def test_values_are_read_off_tables_reports_and_attributes(tmp_path):
    (tmp_path / "a.csv").write_text("task,error_m\nline,0.25\nline again,0.5\n")
    reading = {"file": "a.csv", "rows": {"task": "line"}, "column": "error_m"}
    assert make_sources.read(reading, tmp_path) == 0.25
    reading["rows"] = {"task": "~line"}
    with pytest.raises(make_sources.click.ClickException, match="2 lines"):
        make_sources.read(reading, tmp_path)
    rows = "".join(
        f"<tr><td>{a}</td><td>{b}</td></tr>" for a, b in ((0.1, "1 / 2"), (0.3, "3 / 4"))
    )
    (tmp_path / "r.html").write_text(
        "<table><tr><td>x</td></tr></table>"
        f"<table><tr><th>noise</th><th>error [m]</th></tr>{rows}</table>"
    )
    reading = {"file": "r.html", "rows": {"noise": 0.3}, "column": "error [m]"}
    assert make_sources.read(reading, tmp_path) == "3 / 4"
    kept = {make_sources.key_of(reading): 0.0314}
    shown = make_sources.shown(reading | {"name": "n", "unit": "m", "digits": 3}, kept)
    assert shown == "n 0.031 m"
    kept = {make_sources.key_of(reading): "3 / 4"}
    assert make_sources.shown(reading | {"unit": "m"}, kept) == "3 / 4 m"


def test_figures_and_tables_without_a_row_are_named():
    wheres = {
        "thesis": ("7.6.1, Figs. 7.8, 7.9-7.11", "page 71, Fig. 5.9 (a)", "(6.1), Table 6.1"),
        "docking paper": ("VII A, Figs. 6-10", "Fig. 5, Table I"),
    }
    rows = [{"source": s, "where": w} for s, texts in wheres.items() for w in texts]
    missing = set(make_sources.without_row(rows))
    for named in ("Fig. 7.8", "Fig. 7.9", "Fig. 7.10", "Fig. 7.11", "Fig. 5.9", "Table 6.1"):
        assert f"thesis: {named}" not in missing
    assert {"thesis: Fig. 7.12", "thesis: Fig. 5.8", "textbook: Fig. 11.20"} <= missing
    paper = {line for line in missing if line.startswith("docking")}
    assert paper == {f"docking paper: Fig. {n}" for n in (*range(1, 5), *range(11, 20))}
