"""Texts of a page: escaped, set as in print, and with the glossary's terms explained."""

import html
import importlib.resources
import re
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cache

from markupsafe import Markup

_SHOWING = "octant.reader_design.showing"
_NARROW = "\u202f"
_UNITS = "dBm|dBi|dB|mm|cm|m|km|ms|s|min|GHz|MHz|kHz|Hz|Ω|ohm|nW|µW|mW|W|ns|µs"
_SYMBOL = re.compile(r"\b([rh])_([ap])\b")
_POWER_OF_TEN = re.compile(r"(\d(?:\.\d+)?)e([+-])0*(\d*)\b")


@dataclass(frozen=True, slots=True, kw_only=True)
class Term:
    """A term of the glossary.

    Attributes
    ----------
    term, also, text : Its name, other words for it, and what it means.
    """

    term: str
    text: str
    also: tuple[str, ...] = ()

    @property
    def slug(self) -> str:
        """Its anchor."""
        return f"term-{slug(self.term)}"


@cache
def glossary() -> tuple[Term, ...]:
    """Return all terms, in the alphabet's order."""
    text = importlib.resources.files(_SHOWING).joinpath("glossary.toml").read_text("utf-8")
    found = [
        Term(term=one["term"], text=one["text"], also=tuple(one.get("also", ())))
        for one in tomllib.loads(text)["term"]
    ]
    return tuple(sorted(found, key=lambda one: one.term.casefold()))


def slug(text: str) -> str:
    """Return a text as an anchor: small letters, digits and hyphens.

    Parameters
    ----------
    text : A heading.
    """
    return re.sub(r"[^a-z0-9]+", "-", text.casefold()).strip("-") or "part"


def typeset(text: str) -> str:
    """Return a text as it is printed: true minus, narrow spaces before units and per cent.

    Parameters
    ----------
    text : Plain, not yet escaped.
    """
    text = re.sub(r"(?<![\w.)\]-])-(?=\.?\d)", "−", text)
    text = re.sub(r"(?<=\d)[ \u00a0]?%", f"{_NARROW}%", text)
    return re.sub(rf"(?<=\d) (?=(?:{_UNITS})\b(?!/))", _NARROW, text)


def plain(text: str) -> Markup:
    """Return escaped text as it was given.

    Parameters
    ----------
    text : Any text.
    """
    return Markup(html.escape(text))  # noqa: S704  # escaped here


def words(text: str) -> Markup:
    """Return escaped text, typeset, with r_a and h_p and powers of ten as symbols.

    Parameters
    ----------
    text : Any text.
    """
    return Markup(_symbols(html.escape(typeset(text))))  # noqa: S704  # escaped here


def _symbols(escaped: str) -> str:
    marked = _SYMBOL.sub(r"<i>\1</i><sub>\2</sub>", escaped)
    return _POWER_OF_TEN.sub(_power, marked)


def _power(found: "re.Match[str]") -> str:
    power = int(found[3] or 0) * (-1 if found[2] == "-" else 1)
    if -4 < power < 7:
        decimals = max(0, len(found[1].partition(".")[2]) - power)
        return f"{float(found[1]) * 10.0**power:.{decimals}f}"
    return f"{found[1]} × 10<sup>{str(power).replace('-', '−')}</sup>"


@cache
def _pattern() -> tuple["re.Pattern[str]", dict[str, Term]]:
    names = {html.escape(typeset(n)): t for t in glossary() for n in (t.term, *t.also)}
    longest = sorted(names, key=len, reverse=True)
    either = "|".join(re.escape(name) for name in longest)
    return re.compile(rf"(?<![\w-])({either})(?![\w-])", re.IGNORECASE), {
        name.casefold(): term for name, term in names.items()
    }


@dataclass(slots=True)
class Explained:
    """Which terms a page has explained so far; one for each page.

    Attributes
    ----------
    met : Every term that the page uses, in order.
    here : Terms that are marked in this part of the page already.
    first : Terms that this section uses first on the page.
    """

    met: dict[str, Term] = field(default_factory=dict)
    here: set[str] = field(default_factory=set)
    first: list[Term] = field(default_factory=list)

    def part(self) -> str:
        """Begin a part of the page, in which each term is marked once."""
        self.here.clear()
        return ""

    def section(self) -> str:
        """Begin a section, which explains the terms that no earlier one used."""
        self.first.clear()
        return self.part()

    def terms(self, text: str) -> Markup:
        """Return a text as `words` does, with its terms marked.

        Parameters
        ----------
        text : Any text.
        """
        pattern, known = _pattern()
        escaped = html.escape(typeset(text))
        pieces, end = [], 0
        for found in pattern.finditer(escaped):
            term = known[found[0].casefold()]
            if term.term not in self.met:
                self.met[term.term] = term
                self.first.append(term)
            if term.term in self.here:
                continue
            self.here.add(term.term)
            pieces += [_symbols(escaped[end : found.start()]), _marked(found[0], term)]
            end = found.end()
        pieces.append(_symbols(escaped[end:]))
        return Markup("".join(pieces))  # noqa: S704  # escaped above

    def used(self) -> Iterable[Term]:
        """Return the terms that the page uses, in the alphabet's order."""
        return sorted(self.met.values(), key=lambda one: one.term.casefold())


def _marked(escaped: str, term: Term) -> str:
    meaning = html.escape(typeset(term.text))
    return f'<dfn class="term" tabindex="0" title="{meaning}">{_symbols(escaped)}</dfn>'
