"""The keywords of Touchstone files of version 2."""

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, get_args

from octant.em.antennas.pattern_files._lines import (
    HERTZ,
    number,
    read_lines,
    refusal,
    whole_number,
)

MatrixFormat = Literal["full", "lower", "upper"]
PortOrder = Literal["12_21", "21_12"]
_VERSIONS = ("2.0", "2.1")
_KEYWORD = re.compile(r"\[([^\]]+)\]\s*(.*)")
_MOST_PORTS = 999
_PASSED_OVER = ("begin information", "end information", "end", "noise data")


@dataclass(slots=True)
class Version2:
    """What a file of version 2 says of its numbers.

    Attributes
    ----------
    ports, frequencies : How many there are.
    unit_hz, form : Unit of the frequencies [Hz]; RI, MA or DB.
    reference_ohm : Of each port [ohm].
    matrix_format, two_port_order : Which part of the matrices is there; S12 or S21 first.
    lines : Line numbers and words of the network data.
    """

    ports: int = 0
    frequencies: int = 0
    unit_hz: float = 1e9
    form: str = "MA"
    reference_ohm: tuple[float, ...] = ()
    matrix_format: MatrixFormat = "full"
    two_port_order: PortOrder | None = None
    lines: list[tuple[int, list[str]]] = field(default_factory=list)


def is_version_2(path: Path) -> bool:
    """Return whether the first line that says something is the keyword [Version]."""
    for raw in read_lines(path):
        text = raw.split("!", 1)[0].strip()
        if text:
            return text.lower().startswith("[version]")
    return False


def version_2_content(path: Path) -> Version2:
    """Return what the keywords say, and the lines of the network data."""
    content, section, references_due = Version2(), "", 0
    option_ohm, references = 50.0, list[float]()
    for line, raw in enumerate(read_lines(path), start=1):
        text = raw.split("!", 1)[0].strip()
        found = _KEYWORD.match(text)
        if found:
            section, rest = found[1].strip().lower(), found[2].split()
            if section == "reference":
                references_due, references = _ports(path, line, content), []
                text = " ".join(rest)
            else:
                _keyword(path, line, section, rest, content)
                continue
        if not text or section in ("begin information", "noise data", "end"):
            continue
        if section == "reference" and references_due > 0:
            new = [number(path, line, word) for word in text.split()]
            references, references_due = references + new, references_due - len(new)
            if references_due < 0 or min(new) <= 0.0:
                what = f"[Reference] gives {len(references)} impedances [ohm] above 0 for each port"
                raise refusal(path, line, f"{what} of {content.ports}; correct it.")
        elif text.startswith("#"):
            option_ohm = _options(path, line, text, content)
        elif section == "network data":
            content.lines.append((line, text.split()))
        else:
            raise refusal(path, line, f"{text[:30]!r} stands outside [Network Data]; correct it.")
    last = len(read_lines(path))
    if references_due > 0:
        raise refusal(path, last, f"[Reference] lacks the impedances of {references_due} ports.")
    ports = _ports(path, last, content)
    if ports == 2 and content.two_port_order is None and content.matrix_format == "full":
        raise refusal(path, last, "[Two-Port Data Order] is missing; a two-port needs it.")
    content.reference_ohm = tuple(references) or (option_ohm,) * ports
    return content


def _ports(path: Path, line: int, content: Version2) -> int:
    if not content.ports:
        raise refusal(path, line, "[Number of Ports] is missing; it comes before what needs it.")
    return content.ports


def _keyword(path: Path, line: int, name: str, rest: list[str], content: Version2) -> None:
    """Take a keyword and its argument."""
    word = rest[0] if rest else ""
    if name == "version":
        if word not in _VERSIONS:
            what = f"Touchstone version {word[:10] or 'none'}; read are 1, {', '.join(_VERSIONS)}."
            raise refusal(path, line, what)
    elif name == "number of ports":
        content.ports = whole_number(path, line, word)
        if content.ports > _MOST_PORTS:
            raise refusal(path, line, f"{word} ports are too many; up to {_MOST_PORTS} are read.")
    elif name == "number of frequencies":
        content.frequencies = whole_number(path, line, word)
    elif name == "two-port data order":
        if word not in get_args(PortOrder):
            raise refusal(path, line, f"the order {word[:10]!r}; 12_21 and 21_12 are known.")
        content.two_port_order = "12_21" if word == "12_21" else "21_12"
    elif name == "matrix format":
        kinds = {kind: kind for kind in get_args(MatrixFormat)}
        if word.lower() not in kinds:
            raise refusal(path, line, f"the matrix format {word[:10]!r}; Full, Lower, Upper are.")
        content.matrix_format = kinds[word.lower()]
    elif name == "mixed-mode order":
        raise refusal(path, line, "mixed modes are not read; save the ports single-ended.")
    elif name not in (*_PASSED_OVER, "network data", "number of noise frequencies"):
        raise refusal(path, line, f"the keyword [{name[:30]}] is unknown; correct it.")


def _options(path: Path, line: int, text: str, content: Version2) -> float:
    """Take the option line; return its reference [ohm]."""
    reference_ohm, words = 50.0, iter(text[1:].upper().split())
    for word in words:
        if word in HERTZ:
            content.unit_hz = HERTZ[word]
        elif word in ("RI", "MA", "DB"):
            content.form = word
        elif word == "R":
            reference_ohm = number(path, line, next(words, ""))
        elif word != "S":
            what = f"option {word[:20]!r} is not read; S-parameters as RI, MA or DB are."
            raise refusal(path, line, what)
    if reference_ohm <= 0.0:
        raise refusal(path, line, f"reference {reference_ohm:g} ohm; give more than 0 ohm.")
    return reference_ohm
