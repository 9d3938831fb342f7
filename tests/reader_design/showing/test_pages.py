"""Laws of the report: one file, nothing from outside, every text escaped."""

import base64
import hashlib
import importlib.resources
import re
import zlib
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from octant.reader_design.showing.page.packing import packed
from octant.reader_design.showing.page.words import Explained, glossary, typeset
from octant.reader_design.showing.pages import (
    Judgement,
    PasteAdvice,
    Report,
    ReportFigure,
    ReportSection,
    ReportTable,
    ReportWidget,
    Verdict,
    render_report,
)

PNG = b"\x89PNG\r\n\x1a\n" + bytes(range(64))
EVIL = "<script>alert('x')</script> & \"quotes\""


def report(**changes):
    content = {
        "title": "A title",
        "subtitle": "below it",
        "summary": ("First of all.",),
        "warnings": ("Take care.",),
        "facts": (("share", "85%"),),
        "sections": (
            ReportSection(
                heading="Section",
                paragraphs=("Words.",),
                points=("a point",),
                tables=(
                    ReportTable(
                        caption="Table",
                        header=("design", "share [%]"),
                        rows=(("r_a = 5 cm", "1"), ("r_a = 10 cm", "2")),
                        best=1,
                    ),
                ),
                figures=(ReportFigure(title="Fig", caption="See.", png=PNG),),
                folded=(("open me", "seed = 1\n[room]"),),
            ),
        ),
    }
    return Report(**{**content, **changes})


class Outline(HTMLParser):
    """Checks nesting and collects what the page holds."""

    VOID = frozenset({"meta", "img", "br", "hr"})

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.tags, self.attributes, self.words = [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if not {"style", "script", "svg"} & set(self.open):
            self.words.append(data)

    @property
    def text(self):
        return " ".join("".join(self.words).split())


def test_page_is_well_formed_and_says_everything_in_order():
    text = Outline(render_report(report())).text
    assert "Contents Section" in text
    text = text[text.index("Skip to the report") :].replace("Contents Section", "")
    parts = ["A title", "below it", "First of all.", "85 %", "Take care.", "Section", "Words."]
    parts += ["a point", "Table", "share [%]", "Fig", "See.", "open me", "seed = 1"]
    places = [text.index(part) for part in parts]
    assert places == sorted(places)


def test_page_needs_no_network():
    page = render_report(report())
    outline = Outline(page)
    assert not {"link", "iframe", "object", "embed"} & set(outline.tags)
    assert not re.findall(r"https?://(?!www\.w3\.org/(?:2000/svg|1999/xhtml))", page)
    assert "@import" not in page
    assert "url(" not in page
    assert all(not name.startswith("on") for name, _ in outline.attributes)
    sources = [value for name, value in outline.attributes if name in {"src", "href"}]
    assert all(value.startswith(("data:image/png;base64,", "#")) for value in sources)


def test_every_anchor_that_is_linked_exists_once():
    outline = Outline(render_report(report(sections=2 * report().sections)))
    anchors = [value for name, value in outline.attributes if name == "id"]
    assert len(set(anchors)) == len(anchors)
    links = [value[1:] for name, value in outline.attributes if name == "href"]
    assert set(links) <= set(anchors)
    assert {"section", "section-2"} <= set(links)


def test_image_inside_is_the_image_given():
    outline = Outline(render_report(report()))
    (source,) = [value for name, value in outline.attributes if name == "src"]
    assert base64.b64decode(source.split(",")[1]) == PNG
    assert ("alt", "Fig. See.") in outline.attributes


@pytest.mark.parametrize(
    "changes",
    [
        {"title": EVIL},
        {"subtitle": EVIL},
        {"summary": (EVIL,)},
        {"verdict": Verdict(sentence=EVIL, advice=(PasteAdvice(why=EVIL, lines=EVIL),))},
        {"verdict": Verdict(sentence="s", judgements=(Judgement(name="n", value="v", said=EVIL),))},
        {"warnings": (EVIL,)},
        {"facts": ((EVIL, EVIL),)},
        {"sections": (ReportSection(heading=EVIL, paragraphs=(EVIL,), points=(EVIL,)),)},
        {"sections": (ReportSection(heading="h", warnings=(EVIL,), folded=((EVIL, EVIL),)),)},
        {
            "sections": (
                ReportSection(
                    heading="h",
                    tables=(ReportTable(caption=EVIL, header=(EVIL,), rows=((EVIL,),)),),
                    figures=(ReportFigure(title=EVIL, caption=EVIL, png=PNG),),
                ),
            )
        },
    ],
)
def test_every_text_is_escaped(changes):
    page = render_report(report(**changes))
    assert "<script>alert" not in page
    assert EVIL in Outline(page).text


def test_symbols_become_subscripts_in_text_but_not_in_the_study_file():
    section = ReportSection(heading="r_a and h_p", folded=(("s", "r_a = 1"),))
    page = render_report(report(sections=(section,)))
    assert "<i>r</i><sub>a</sub> and <i>h</i><sub>p</sub>" in page
    assert "r_a = 1</pre>" in page


def test_best_row_is_set_off():
    page = render_report(report())
    assert page.count('<tr class="best">') == 1
    assert page.index('<tr class="best">') > page.index("= 5")


def test_empty_parts_leave_no_empty_elements():
    page = render_report(report(warnings=(), facts=(), sections=(ReportSection(heading="h"),)))
    body = page[page.index("<body>") : page.rindex("<script>")]
    for element in ("<ul>", "<table", "<figure", "<dl", 'class="warn"'):
        assert element not in body


def test_page_follows_light_and_dark_themes():
    assert "prefers-color-scheme: dark" in render_report(report())


@pytest.mark.parametrize(
    ("given", "set_"),
    [
        ("95% and 95 %", "95\u202f% and 95\u202f%"),
        ("from -3.5 dB to -.5", "from −3.5\u202fdB to −.5"),
        ("x-3, 2026-11-29, a - b", "x-3, 2026-11-29, a - b"),
        ("3 m/s is 3 metres", "3 m/s is 3 metres"),
    ],
)
def test_numbers_are_set_as_in_print(given, set_):
    assert typeset(given) == set_


def test_powers_of_ten_are_no_programmers_numbers():
    section = ReportSection(heading="h", paragraphs=("from 1.43e+04 to 1e-06 and 2e+09",))
    page = render_report(report(sections=(section,)))
    assert "from 14300 to 1 × 10<sup>−6</sup> and 2 × 10<sup>9</sup>" in page


def test_terms_are_explained_where_they_stand_first_and_at_the_end():
    section = ReportSection(heading="h", paragraphs=("A margin, a margin.", "The margin."))
    page = render_report(report(sections=(section, section)))
    meaning = next(one.text for one in glossary() if one.term == "margin")
    assert page.count('class="term"') == 2  # once a section
    assert page.count(f'title="{typeset(meaning)}"') == 2
    assert page.count('class="terms"') == 1
    assert 'id="term-margin"' in page
    assert 'id="term-rss"' not in page


def test_glossary_names_each_term_once_and_meanings_are_sentences():
    names = [name.casefold() for one in glossary() for name in (one.term, *one.also)]
    assert len(set(names)) == len(names)
    assert all(one.text.endswith(".") for one in glossary())
    assert Explained().terms("no word of ours") == "no word of ours"


def test_wide_table_is_printed_in_parts_that_hold_every_column_once():
    header = tuple(f"c{k}" for k in range(36))
    table = ReportTable(caption="wide", header=header, rows=(header,), first=6)
    assert sorted(k for part in table.parts for k in part if k) == list(range(1, 36))
    assert all(part[0] == 0 and len(part) <= 9 for part in table.parts)
    page = render_report(report(sections=(ReportSection(heading="h", tables=(table,)),)))
    assert page.count("<td>c35</td>") == 2
    assert page.count("<td>c1</td>") == 2


def test_data_of_a_widget_cannot_end_its_script():
    widget = ReportWidget(kind="map", title="t", caption="c", alt="a", data={"x": "</script>"})
    page = render_report(report(sections=(ReportSection(heading="h", widgets=(widget,)),)))
    assert '{"x":"\\u003c/script>"}' in page


def test_packed_arrays_come_back_within_half_a_step_and_keep_holes():
    values = np.array([[-80.2, -3.0], [np.nan, -np.inf]])
    one = packed(values, step=0.5)
    whole = np.frombuffer(zlib.decompress(base64.b64decode(one["data"])), np.uint8)
    back = np.where(whole == one["none"], np.nan, one["low"] + one["step"] * whole)
    np.testing.assert_allclose(back[:2], values[0], atol=0.25)
    assert np.isnan(back[2:]).all()


def test_scripts_are_those_that_their_sources_make():
    folder = importlib.resources.files("octant.reader_design.showing.page")
    root = Path(__file__).resolve().parents[3]
    sources = sorted((root / "reader_design/showing/page/js").glob("*.js"))
    assert sources
    digest = hashlib.sha256(b"".join(one.read_bytes() for one in sources)).hexdigest()[:16]
    for name in ("page", "charts", "space"):
        first = folder.joinpath(f"{name}.min.js").read_text("utf-8").splitlines()[0]
        assert first.startswith(f"/* sources {digest};"), f"{name}: run tools/vendor_js.sh"
