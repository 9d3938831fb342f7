"""Laws of the report: one file, nothing from outside, every text escaped."""

import base64
from html.parser import HTMLParser

import pytest

from octant.reader_design.showing.pages import (
    Report,
    ReportFigure,
    ReportSection,
    ReportTable,
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
        if "style" not in self.open:
            self.words.append(data)

    @property
    def text(self):
        return " ".join("".join(self.words).split())


def test_page_is_well_formed_and_says_everything_in_order():
    text = Outline(render_report(report())).text
    parts = ["A title", "below it", "First of all.", "85%", "Take care.", "Section", "Words."]
    parts += ["a point", "Table", "share [%]", "Fig", "See.", "open me", "seed = 1"]
    places = [text.index(part, 7 if part == "A title" else 0) for part in parts]
    assert places == sorted(places)


def test_page_needs_no_network_and_no_script():
    page = render_report(report())
    outline = Outline(page)
    assert not {"script", "link", "iframe", "object", "embed"} & set(outline.tags)
    assert "http" not in page
    assert "@import" not in page
    assert "url(" not in page
    assert all(not name.startswith("on") for name, _ in outline.attributes)
    sources = [value for name, value in outline.attributes if name in {"src", "href"}]
    assert all(value.startswith("data:image/png;base64,") for value in sources)


def test_image_inside_is_the_image_given():
    outline = Outline(render_report(report()))
    (source,) = [value for name, value in outline.attributes if name == "src"]
    assert base64.b64decode(source.split(",")[1]) == PNG
    assert ("alt", "Fig") in outline.attributes


@pytest.mark.parametrize(
    "changes",
    [
        {"title": EVIL},
        {"subtitle": EVIL},
        {"summary": (EVIL,)},
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
    assert "<script" not in page
    assert EVIL in Outline(page).text


def test_symbols_become_subscripts_in_text_but_not_in_the_study_file():
    section = ReportSection(heading="h", paragraphs=("r_a and h_p",), folded=(("s", "r_a = 1"),))
    page = render_report(report(sections=(section,)))
    assert "<i>r</i><sub>a</sub> and <i>h</i><sub>p</sub>" in page
    assert "<pre>r_a = 1</pre>" in page


def test_best_row_is_set_off():
    page = render_report(report())
    assert page.count('<tr class="best">') == 1
    assert page.index('<tr class="best">') > page.index("= 5 cm")


def test_empty_parts_leave_no_empty_elements():
    page = render_report(report(warnings=(), facts=(), sections=(ReportSection(heading="h"),)))
    body = page[page.index("<body>") :]
    for element in ("<ul>", "<table", "<figure", "<dl", 'class="warn"'):
        assert element not in body


def test_page_follows_light_and_dark_themes():
    assert "prefers-color-scheme: dark" in render_report(report())
