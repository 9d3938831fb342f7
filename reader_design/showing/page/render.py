"""How a report's content becomes one HTML page: templates, style, scripts and their data."""

import base64
import importlib.resources
import json
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from octant.reader_design.showing.page.words import Explained, plain, slug, words

if TYPE_CHECKING:
    from jinja2 import Environment


@dataclass(frozen=True, slots=True, kw_only=True)
class _Entry:
    anchor: str
    heading: str


def page(report: Any, *, headings: Iterable[str], libraries: Iterable[str]) -> str:  # noqa: ANN401  # showing.pages.Report, which imports this
    """Return a report as one self-contained HTML page.

    Parameters
    ----------
    report, headings : Its content; the headings of its sections.
    libraries : Names of the libraries that its widgets need.
    """
    unique = _Unique()
    contents = [_Entry(anchor=unique(heading), heading=heading) for heading in headings]
    explained = Explained()
    template = _environment().get_template("page.html.j2")
    return template.render(
        report=report,
        contents=contents,
        explained=explained,
        unique=unique,
        libraries={name: _packed_library(name) for name in sorted(set(libraries))},
        script=_resource("page.min.js"),
    )


class _Unique:
    """Makes anchors that a page holds once."""

    def __init__(self) -> None:
        self.used: set[str] = {"report", "glossary", "meaning"}

    def __call__(self, text: str) -> str:
        base = found = slug(text)
        number = 2
        while found in self.used:
            found, number = f"{base}-{number}", number + 1
        self.used.add(found)
        return found


def _resource(name: str) -> str:
    return importlib.resources.files(__package__).joinpath(name).read_text("utf-8")


@cache
def _packed_library(name: str) -> str:
    """Return a script deflated, in base64: a page unpacks it when it first needs it."""
    return base64.b64encode(zlib.compress(_resource(f"{name}.min.js").encode(), 9)).decode("ascii")


def _json(data: Mapping[str, object]) -> Markup:
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return Markup(text.replace("<", "\\u003c"))  # noqa: S704  # nothing in it can end the script


@cache
def _environment() -> "Environment":
    """Return where the templates are, and how texts get into them."""
    from jinja2 import Environment, PackageLoader

    environment = Environment(
        loader=PackageLoader(__package__, "."),
        autoescape=True,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["plain"] = plain
    environment.filters["words"] = words
    environment.filters["json"] = _json
    environment.filters["columns"] = lambda header: range(len(header))
    environment.filters["base64"] = lambda data: base64.b64encode(data).decode("ascii")
    return environment
