"""A report in a real browser: no error, no network, every control acts, paper loses nothing."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from octant.em.reader.response import sector_response
from octant.reader_design.experiments.missions.compute import drive_missions
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.showing.drive_view import drive_widget
from octant.reader_design.showing.map_view import FloorMaps, map_widget, symmetric_turn
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
from octant.reader_design.showing.pattern_view import pattern_widget
from octant.reader_design.showing.plan import plan_of
from octant.reader_design.showing.reader_svg import reader_drawing
from octant.reader_design.showing.room_view import Way, room_widget
from octant.reader_design.showing.style import save_figure
from octant.reader_design.study_file.loading import parse_study

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
)
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed (apt install chromium)"),
    # Playwright's sockets are closed by its own process, after the test.
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
]
ARGUMENTS = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
)
STUDY = """
name = "browser"
[room]
box_m = [3.0, 3.0, 2.5]
[[room.object]]
kind = "box"
size_m = [0.4, 0.4, 0.5]
position_m = [2.4, 2.4, 0.0]
material = "metal"
[[tag]]
id = "A"
position_m = [1.0, 2.0, 2.4]
[[tag]]
id = "B"
position_m = [2.0, 1.0, 2.4]
[solver]
max_reflections = 0
[mission]
start_m = [0.6, 0.6]
tags = ["A", "B"]
max_time_s = 8.0
"""
WIDE = tuple(f"quality{k}" for k in range(36))
READY = "() => [...document.querySelectorAll('.widget')].every((w) => w.dataset.ready)"


def whole_report(folder):
    study = parse_study(STUDY, source="test", directory=Path())
    response = sector_response(np.arange(8) * np.pi / 4, frequency_hz=2.4e9, exponent=2.0)
    setting = build_setting(study).with_responses([response])
    plan = plan_of(setting.scene, setting.reader_z_m)
    x = y = np.linspace(0.3, 2.7, 9)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    headings = np.radians([90.0, 112.5])
    found = [setting.link(tag).power_by_heading(grid, headings) for tag in setting.tags]
    power = np.moveaxis(np.array([one.coherent_w for one in found]), 2, 0).reshape(2, 2, 9, 9, 8)
    standing = np.ones((9, 9), dtype=bool)
    standing[8, 8] = False
    results = drive_missions(setting, runs=2)
    maps = FloorMaps(
        x_m=x,
        y_m=y,
        headings_rad=headings,
        coherent_w=power,
        mean_w=0.5 * power,
        standing=standing,
        azimuths_rad=response.azimuths_rad,
        turn=symmetric_turn(response),
        rms_rad=np.full((2, 9, 9), 0.2),
        captured=np.full((2, 9, 9), 0.1),
    )
    picture = ReportFigure(title="A figure", caption="It shows.", png=png(folder))
    designs = ReportWidget(
        kind="designs",
        title="Designs compared",
        caption="c",
        alt="a",
        data={
            "columns": list(WIDE[:4]),
            "rows": [
                {"label": f"design {k}", "front": k < 2, "values": [k, 9 - k, k % 3, k * k]}
                for k in range(10)
            ],
            "x": 0,
            "y": 1,
            "axes": [0, 1, 2, 3],
        },
        fallback=(picture,),
    )
    table = ReportTable(
        caption="All designs.",
        header=("design", *WIDE),
        rows=tuple(
            (f"design {k}", *(f"{(k * 7) % 10 + c / 100:.2f}" for c in range(36)))
            for k in range(10)
        ),
        best=0,
        first=6,
    )
    ways = [Way(points_m=results[0].poses[:, :2], end="time-out")]
    explorer = map_widget(maps, setting, plan, tags=["A", "B"])
    room = room_widget(setting, start_m=(0.6, 0.6), ways=ways, fallback=(picture,))
    return Report(
        title="A report",
        subtitle="for a browser",
        summary=(),
        warnings=(),
        facts=(),
        verdict=Verdict(
            sentence="The robot reached no tag.",
            mark="poor",
            judgements=(Judgement(name="missions", value="0 of 2", said="poor", mark="poor"),),
            advice=(PasteAdvice(why="Because of the margin.", lines="[mission]\nruns = 3"),),
            drawing=reader_drawing(study.reader, 2.4e9),
        ),
        sections=(
            ReportSection(heading="The room", widgets=(room, explorer)),
            ReportSection(
                heading="Missions",
                widgets=(drive_widget(setting, plan, results, radius_m=0.15),),
            ),
            ReportSection(heading="Designs", widgets=(designs,), tables=(table,)),
            ReportSection(
                heading="The reader",
                widgets=(pattern_widget(response),),
                figures=(picture,),
                folded=(("open me", "seed = 1"),),
            ),
        ),
    )


def png(folder):
    from matplotlib.figure import Figure

    save_figure(Figure(figsize=(2.0, 1.0)), folder / "figure.png")
    return (folder / "figure.png").read_bytes()


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    (folder / "report.html").write_text(render_report(whole_report(folder)), "utf-8")
    return folder / "report.html"


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as driver:
        launched = driver.chromium.launch(executable_path=CHROMIUM, args=list(ARGUMENTS))
        yield launched
        launched.close()


@pytest.fixture(scope="module")
def opened(browser, file):
    """Return the page with all widgets started, and what was said and asked for meanwhile."""
    page = browser.new_page(viewport={"width": 1300, "height": 900})
    said, asked = [], []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.goto(file.as_uri())
    for widget in page.locator(".widget").all():
        widget.scroll_into_view_if_needed()
        page.wait_for_function("(w) => w.dataset.ready", arg=widget.element_handle())
    page.evaluate("document.documentElement.style.scrollBehavior = 'auto'")
    yield page, said, asked
    page.close()


def test_nothing_is_complained_about_and_nothing_is_asked_of_a_network(opened):
    page, said, asked = opened
    ready = page.eval_on_selector_all(".widget", "all => all.map((w) => w.dataset.ready)")
    assert ready == ["yes"] * 5
    assert [line for line in said if "GPU stall" not in line] == []
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []


CONTROLS = {
    "room": ("The room", "canvas"),
    "map": ("Map explorer", "canvas"),
    "drive": ("Playback", "canvas"),
    "designs": ("Designs compared", None),
    "pattern": ("Pattern of each antenna", "canvas"),
}


def shown(page, kind):
    """Return all that a widget shows: pixels, drawings and words."""
    page.wait_for_timeout(60)
    return page.eval_on_selector(
        f".widget[data-kind={kind}] .live",
        "box => [...box.querySelectorAll('canvas')].map((c) => c.toDataURL()).join()"
        " + [...box.querySelectorAll('svg')].map((s) => s.outerHTML).join() + box.innerText",
    )


@pytest.mark.parametrize("kind", CONTROLS)
def test_every_control_changes_what_is_shown(opened, kind):
    page = opened[0]
    box = page.locator(f".widget[data-kind={kind}]")
    box.scroll_into_view_if_needed()
    acted = 0
    for select in box.locator(".controls select").all():
        if select.evaluate("s => s.closest('label').textContent.startsWith('Speed')"):
            continue  # it shows only while a run is played
        before = shown(page, kind)
        count = select.locator("option").count()
        chosen = select.evaluate("s => s.selectedIndex")
        select.select_option(index=count - 1 if chosen != count - 1 else 0)
        assert shown(page, kind) != before, select.inner_text()
        select.select_option(index=chosen)
        acted += 1
    for slider in box.locator(".controls input[type=range]").all():
        before = shown(page, kind)
        slider.evaluate(
            "s => { const middle = (Number(s.min) + Number(s.max)) / 2;"
            " s.value = Number(s.value) > middle ? s.min : s.max;"
            " s.dispatchEvent(new Event('input')); }"
        )
        assert shown(page, kind) != before, slider.get_attribute("aria-label")
        acted += 1
    for button in box.locator(".controls button").all():
        if button.inner_text() in {"Clear choice", "Turn back"}:
            continue  # they undo what another did: below
        before = shown(page, kind)
        button.click()
        page.wait_for_timeout(150)
        assert shown(page, kind) != before, button.inner_text()
        acted += 1
    assert acted >= 2
    for undo in ("Clear choice", "Turn back"):
        if box.get_by_text(undo).count():
            if undo == "Clear choice":
                page.locator("section:has(.widget[data-kind=designs]) tbody tr").first.click()
            before = shown(page, kind)
            box.get_by_text(undo).click()
            assert shown(page, kind) != before, undo


def test_a_place_of_the_map_shows_its_antennas_by_mouse_and_by_keys(opened):
    page = opened[0]
    box = page.locator(".widget[data-kind=map]")
    canvas = box.locator(".canvas canvas")
    canvas.scroll_into_view_if_needed()
    size = canvas.bounding_box()
    canvas.click(position={"x": size["width"] / 2, "y": size["height"] / 2})
    first = box.locator(".value").inner_text()
    assert re.search(r"x 1\.50\u202fm, y 1\.50\u202fm: .* Strongest: antenna \d", first)
    assert box.locator(".rose path").count() == 8
    canvas.focus()
    page.keyboard.press("ArrowRight")
    assert "x 1.80" in box.locator(".value").inner_text()


def test_a_heading_turned_by_symmetry_shows_what_is_computed_there(opened):
    page = opened[0]
    study = parse_study(STUDY, source="test", directory=Path())
    response = sector_response(np.arange(8) * np.pi / 4, frequency_hz=2.4e9, exponent=2.0)
    setting = build_setting(study).with_responses([response])
    box = page.locator(".widget[data-kind=map]")
    box.locator("select").nth(1).select_option(value="coherent")
    box.locator("select").nth(0).select_option(value="0")
    for antenna, heading in ((2, 0.0), (5, 157.5)):
        box.locator("select").nth(2).select_option(index=antenna + 1)
        box.get_by_role("slider", name="Heading").evaluate(
            "(s, v) => { s.value = v; s.dispatchEvent(new Event('input')); }",
            str(round(heading / 22.5)),
        )
        canvas = box.locator(".canvas canvas")
        size = canvas.bounding_box()
        canvas.click(position={"x": size["width"] / 2, "y": size["height"] / 2})
        text = box.locator(".value").inner_text()
        level = float(re.search(r": ([−\d.]+)", text)[1].replace("−", "-"))
        pose = [[1.5, 1.5, np.radians(heading)]]
        exact = 10.0 * np.log10(setting.link(setting.tags[0]).rss_w(pose)[0, antenna] / 1e-3)
        assert level == pytest.approx(exact, abs=0.3)


def test_table_sorts_filters_and_chooses_columns(opened):
    page = opened[0]
    box = page.locator(".table").first
    names = "table tbody th"
    assert box.locator("thead th:visible").count() == 6
    box.locator("thead button").nth(1).click()
    values = [float(t) for t in box.locator(".scroll tbody td:nth-child(2)").all_inner_texts()]
    assert values == sorted(values)
    box.locator("thead button").nth(1).click()
    values = [float(t) for t in box.locator(".scroll tbody td:nth-child(2)").all_inner_texts()]
    assert values == sorted(values, reverse=True)
    box.get_by_label("Filter rows").fill("design 7")
    visible = box.locator(".scroll").locator(f"{names}:visible")
    assert visible.all_inner_texts() == ["design 7"]
    box.get_by_label("Filter rows").fill("")
    box.locator(".columns summary").click()
    box.get_by_text("All", exact=True).click()
    assert box.locator(".scroll thead th:visible").count() == 37
    box.get_by_text("First", exact=True).click()
    assert box.locator(".scroll thead th:visible").count() == 6


def test_a_range_of_a_parallel_axis_and_a_click_reach_the_table(opened):
    page = opened[0]
    box = page.locator(".widget[data-kind=designs]")
    rows = page.locator("section:has(.widget[data-kind=designs]) .scroll").last.locator("tbody tr")
    before = rows.evaluate_all("all => all.filter((row) => row.hidden).length")
    assert before == 0
    chart = box.locator(".chart").nth(1)
    chart.scroll_into_view_if_needed()
    place = chart.bounding_box()
    x, top = place["x"] + 64, place["y"] + 66
    height = place["height"] - 66 - 24
    page.mouse.move(x, top + 0.05 * height)
    page.mouse.down()
    page.mouse.move(x, top + 0.2 * height, steps=3)
    page.mouse.move(x, top + 0.45 * height, steps=3)
    page.mouse.up()
    page.wait_for_timeout(200)
    hidden = rows.evaluate_all("all => all.filter((row) => row.hidden).length")
    assert 3 <= hidden <= 8
    page.mouse.click(x, top + 0.9 * height)  # takes the range away
    page.wait_for_timeout(200)
    assert rows.evaluate_all("all => all.filter((row) => row.hidden).length") == 0
    box.get_by_text("Clear choice").click()
    for number in (0, 1):
        rows.nth(number).click()
    assert box.locator("table.compared thead th").count() == 3
    box.get_by_text("Clear choice").click()
    assert box.locator("table.compared").count() == 0


def test_terms_are_explained_at_the_keyboard(opened):
    page = opened[0]
    term = page.locator("dfn.term").first
    term.focus()
    assert page.locator("#meaning").is_visible()
    assert len(page.locator("#meaning").inner_text()) > 20
    page.keyboard.press("Escape")
    assert not page.locator("#meaning").is_visible()


def test_theme_changes_with_a_button(opened):
    page = opened[0]
    ground = "getComputedStyle(document.body).backgroundColor"
    before = page.evaluate(ground)
    page.locator("button.theme").click()
    assert page.evaluate(ground) != before
    page.locator("button.theme").click()
    assert page.evaluate(ground) == before


def test_a_phone_sees_no_page_that_is_wider_than_its_window(browser, file):
    page = browser.new_page(viewport={"width": 390, "height": 844})
    page.goto(file.as_uri())
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.close()


def test_without_scripts_figures_and_all_columns_are_there(browser, file):
    page = browser.new_context(java_script_enabled=False).new_page()
    page.goto(file.as_uri())
    assert page.locator(".fallback img:visible").count() == 2
    assert page.locator(".scroll thead th:visible").count() == 37
    assert page.get_by_text("seed = 1").is_visible()
    page.close()


def test_paper_holds_every_column_within_the_sheet_and_folds_are_open(browser, file):
    page = browser.new_page(viewport={"width": 700, "height": 990})  # A4 without its margins
    page.goto(file.as_uri())
    page.emulate_media(media="print")
    boxes = page.eval_on_selector_all(
        ".paper th[scope=col]",
        "all => all.map((c) => [c.textContent, c.getBoundingClientRect().left,"
        " c.getBoundingClientRect().right, c.getBoundingClientRect().width])",
    )
    assert {name for name, *_ in boxes} == {"design", *WIDE}
    assert all(left >= 0.0 and right <= 700.0 and width > 20.0 for _, left, right, width in boxes)
    assert page.locator(".fallback img:visible").count() == 2
    assert page.locator(".contents:visible").count() == 0
    text = page.pdf()
    assert text.startswith(b"%PDF")
    page.close()


def test_print_opens_folds_and_closes_them_again(opened):
    page = opened[0]
    fold = page.locator("details.fold").first
    assert not fold.evaluate("d => d.open")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert fold.evaluate("d => d.open")
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert not fold.evaluate("d => d.open")


def test_first_paint_is_measured(browser, file, record_property):
    page = browser.new_page()
    page.goto(file.as_uri())
    paint = page.evaluate(
        "new Promise((found) => new PerformanceObserver((list) => found(list.getEntries()"
        "[0].startTime)).observe({ type: 'paint', buffered: true }))"
    )
    record_property("first_paint_ms", paint)
    assert paint > 0.0
    page.close()
