"""The code blocks and commands of README and the documentation: found, checked, carried out."""

import io
import re
import shlex
import tomllib
import warnings
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

import click

from octant.reader_design import cli

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
ELSEWHERE = ("_build", "generated")
"""Folders of docs whose pages are written by the build, from what is checked elsewhere."""
FENCE = re.compile(r"^(`{3,}|~{3,})\s*(.*)$")
CODE = ("{code-block}", "{code-cell}")
OPTION = re.compile(r"^:([\w-]+):\s*(.*)$")
NOT_RUN = "<!-- not run"
"""What stands above a block that is only checked, with the reason: it takes long, or installs."""
OTHER_PROGRAMS = ("python", "python3", "pip", "pytest", "git", "cd", "eval", "source", "mkdir")


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """A fenced block of a page.

    Parameters
    ----------
    page, line, language, text : Where it stands, what it is in, and what it says.
    caption : Name of the file that it is to be saved as; empty: none.
    run : Whether a reader who follows the page carries it out now.
    """

    page: Path
    line: int
    language: str
    text: str
    caption: str = ""
    run: bool = True

    def __str__(self) -> str:
        return f"{self.page.relative_to(ROOT)}:{self.line}"


def pages() -> list[Path]:
    """Return README and every page of the documentation that a person writes."""
    found = sorted(DOCS.rglob("*.md"))
    parts = [page.relative_to(DOCS).parts for page in found]
    kept = [page for page, p in zip(found, parts, strict=True) if p[0] not in ELSEWHERE]
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *kept]


def blocks(page: Path) -> Iterator[Block]:
    """Yield the fenced blocks of a page, from top to bottom."""
    lines = page.read_text("utf-8").splitlines()
    number, above = 0, ""
    while number < len(lines):
        found = FENCE.match(lines[number])
        if not found:
            above = lines[number] if lines[number].strip() else above
            number += 1
            continue
        rest = range(number + 1, len(lines))
        end = next(k for k in rest if lines[k].startswith(found[1]) and not lines[k].strip("`~ "))
        body, options = lines[number + 1 : end], {}
        while body and (option := OPTION.match(body[0])):
            options[option[1]] = option[2]
            body = body[1:]
        yield Block(
            page=page,
            line=number + 1,
            language=" ".join(word for word in found[2].split() if word not in CODE),
            text="\n".join(body).strip("\n") + "\n",
            caption=options.get("caption", ""),
            run=not above.startswith(NOT_RUN),
        )
        number, above = end + 1, ""


def all_blocks(*languages: str) -> list[Block]:
    """Return the blocks of all pages in some languages."""
    return [b for page in pages() for b in blocks(page) if b.language in languages]


def commands(text: str) -> Iterator[list[str]]:
    """Yield the commands of a block for the shell, each as its words; comments are left out."""
    for line in text.replace("\\\n", " ").splitlines():
        for part in re.split(r"&&|;", re.sub(r"(^|\s)#.*", "", line)):
            words = shlex.split(part)
            if words:
                yield words[: words.index(">")] if ">" in words else words


def checked(words: list[str]) -> None:
    """Refuse a command that the command line would refuse before it starts to compute."""
    program = Path(words[0]).name
    if program == "octant":
        check_call(words[1:])
    elif program not in OTHER_PROGRAMS and not (ROOT / words[0]).exists():
        msg = f"{program} is no program that the documentation may use"
        raise AssertionError(msg)
    for word in words[1:]:
        if word.startswith(("examples/", "docs/", "tools/", "benchmarks/", "tests/")):
            written = word.endswith((".gif", ".png"))
            assert written or (ROOT / word).exists(), f"{word} is not there"


def check_call(arguments: list[str]) -> None:
    """Refuse a call of ``octant`` with an unknown verb, option or value, by click itself."""
    root = click.Context(cli.octant, info_name="octant", **cli.CONTEXT)
    if not arguments or arguments[0].startswith("-"):
        cli.octant.make_context("octant", list(arguments), resilient_parsing=True)
        return
    command = cli.octant.get_command(root, arguments[0])
    assert command is not None
    with command.make_context(arguments[0], arguments[1:], parent=root):
        pass


def inline_calls(page: Path) -> Iterator[tuple[str, list[str]]]:
    """Yield the calls of ``octant`` in a page's running text: as written, and as words."""
    text = re.sub(r"^(```|~~~).*?^\1", "", page.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
    for span in re.findall(r"`(octant [a-z][^`]*)`", text):
        yield span, re.sub(r"[\[\]|]", " ", " ".join(span.split())).split()[1:]


def known_options(verb: str) -> set[str]:
    """Return the options of a verb."""
    command = cli.octant.get_command(click.Context(cli.octant), verb)
    assert command is not None
    context = click.Context(command, info_name=verb, **cli.CONTEXT)
    return {flag for p in command.get_params(context) for flag in (*p.opts, *p.secondary_opts)}


def carried_out(page: Path, folder: Path) -> None:
    """Do what a page says, from top to bottom, in a folder that looks like a clone.

    Parameters
    ----------
    page, folder : The page; the working folder.
    """
    names: dict[str, object] = {"__name__": "__main__"}
    for block in blocks(page):
        if not block.run:
            continue
        if block.caption:
            path = folder / block.caption
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text, "utf-8")
        elif block.language == "sh":
            for words in commands(block.text):
                _command(block, words)
        elif block.language == "python":
            # A file of its own, so that functions have a source that can be read.
            file = folder / f"block_{block.line}.py"
            file.write_text(block.text, "utf-8")
            with warnings.catch_warnings(), redirect_stdout(io.StringIO()):
                warnings.simplefilter("ignore")
                exec(compile(block.text, str(file), "exec"), names)  # noqa: S102


def _command(block: Block, words: list[str]) -> None:
    assert Path(words[0]).name == "octant", f"{block}: {words[0]} is not carried out"
    said = io.StringIO()
    with redirect_stderr(said), redirect_stdout(said):
        code = cli.run(words[1:])
    assert code == 0, f"{block}: {' '.join(words)}: {said.getvalue()[-1500:]}"


def tables(block: Block) -> dict[str, object]:
    """Return the tables of a TOML block."""
    try:
        return tomllib.loads(block.text)
    except tomllib.TOMLDecodeError as exc:
        msg = f"{block}: {exc}"
        raise AssertionError(msg) from exc
