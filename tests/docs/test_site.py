"""The built site: every link leads somewhere, each task is two clicks away, nothing is fetched."""

import subprocess
import sys
from html.parser import HTMLParser
from urllib.parse import unquote, urlsplit

import make_files
import pytest
from doc_blocks import DOCS

pytestmark = pytest.mark.slow
TASKS = (
    "start/install", "howto/how_long", "gallery/index", "start/your_room", "howto/materials",
    "howto/turned_mesh", "howto/convert_cad", "howto/through_walls", "howto/rss_map",
    "howto/export_map", "howto/list_paths", "howto/s11_band", "howto/pattern_files",
    "howto/other_frequency", "howto/failing_mission", "howto/own_navigator", "howto/own_objective",
    "howto/read_results", "reference/study_file", "about/citing", "about/changelog",
    "about/contributing",
)  # fmt: skip
"""Pages that answer the twenty tasks of newcomers; the last one has three."""


class Page(HTMLParser):
    """What a page links to, what it loads, and the places on it that a link can name."""

    def __init__(self, path):
        super().__init__()
        self.links, self.loads, self.places = [], [], {""}
        self.without_text = []
        self.feed(path.read_text("utf-8"))

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.places |= {given[key] for key in ("id", "name") if given.get(key)}
        if tag == "a" and given.get("href"):
            self.links.append(given["href"])
        if tag in {"script", "img", "iframe"} and given.get("src"):
            self.loads.append(given["src"])
        if tag == "link" and given.get("rel") not in {"canonical", "next", "prev"}:
            self.loads.append(given.get("href", ""))
        if tag == "img" and not given.get("alt"):
            self.without_text.append(given.get("src", "")[:60])


@pytest.fixture(scope="module")
def site():
    pytest.importorskip("myst_nb", reason="the extra [docs] is not installed")
    folder = DOCS / "_build" / "html"
    call = [sys.executable, str(DOCS / "build.py"), str(folder)]
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return {path: Page(path) for path in sorted(folder.rglob("*.html"))}


def target(page, link):
    """Return the file and the place on it to which a link of this site leads; None: elsewhere."""
    parts = urlsplit(link)
    if parts.scheme or parts.netloc:
        return None
    file = (page.parent / unquote(parts.path)).resolve() if parts.path else page
    return file, unquote(parts.fragment)


def test_every_link_leads_somewhere(site):
    broken = []
    for path, page in site.items():
        for link in page.links:
            found = target(path, link)
            if found is None:
                continue
            file, place = found
            there = file in site and place in site[file].places
            if not there and not (file.exists() and file.suffix != ".html"):
                broken.append(f"{path.name}: {link}")
    assert broken == []


def test_nothing_comes_from_a_network(site):
    fetched = [
        f"{path.name}: {load}"
        for path, page in site.items()
        for load in page.loads
        if urlsplit(load).scheme in {"http", "https"} or load.startswith("//")
    ]
    assert fetched == []


def test_every_picture_has_a_text(site):
    assert [name for page in site.values() for name in page.without_text if name] == []


def test_each_task_is_two_clicks_away_at_most(site):
    root = next(iter(site)).parent
    while not (root / "searchindex.js").exists():
        root = root.parent
    seen, frontier = {root / "index.html"}, [root / "index.html"]
    for _ in range(2):
        links = [(page, link) for page in frontier for link in site[page].links]
        found = {t[0] for page, link in links if (t := target(page, link)) and t[0] in site}
        frontier = sorted(found - seen)
        seen |= found
    missing = [task for task in TASKS if root / f"{task}.html" not in seen]
    assert missing == []


def test_files_hold_what_the_reference_lists(tmp_path):
    kept = make_files.json.loads(make_files.VARIABLES.read_text("utf-8"))
    assert make_files.run_all(tmp_path) == kept, "python docs/make_files.py FOLDER"
