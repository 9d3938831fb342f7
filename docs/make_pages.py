"""Write the pages that come from the code into ``docs/generated``: verbs, glossary, drawings.

``conf.py`` calls `write_all` before each build. A file is touched only where its content changes,
so that a build does again only what it must.
"""

import inspect
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from octant.reader_design import cli
from octant.reader_design.terminal.schemas import SCHEMAS

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
GENERATED = DOCS / "generated"
GLOSSARY = ROOT / "reader_design" / "showing" / "glossary.toml"
VERBS_HEAD = """# Every verb

What `octant VERB --help` says, with the type and range of each value. Data goes to stdout,
progress and messages to stderr; [exit codes](../reference/exit_codes.md) are the same for all. `-h`
or `--help` works everywhere.
"""
JSON_HEAD = """# JSON on stdout

With `--json` a verb prints one document and nothing else on stdout; messages stay on stderr. `[]`
stands for each entry of a list, `*` for keys that the run decides, such as a table's columns. A
number that is infinite or undefined is `null`, a complex one is `{"re": ..., "im": ...}`.
"""
GLOSSARY_HEAD = """# Glossary

The words of the reports and of these pages; the reports explain them with the same sentences.
"""


def version() -> str:
    """Return the version that ``pyproject.toml`` states."""
    found = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
    return str(found)


def write_all() -> None:
    """Write every generated page and drawing that is not up to date."""
    import drawings
    import make_files

    write(GENERATED / "verbs.md", verbs_page())
    write(GENERATED / "files.md", make_files.page())
    write(GENERATED / "json.md", json_page())
    write(GENERATED / "glossary.md", glossary_page())
    write(GENERATED / "face.rst.txt", face_page())
    drawings.draw_all(GENERATED)


def write(path: Path, text: str) -> None:
    """Write a text file where it is not there already.

    Parameters
    ----------
    path, text : The file, and what it is to hold.
    """
    if not path.exists() or path.read_text("utf-8") != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")


def verbs_page() -> str:
    """Return the page of all verbs, from click."""
    root = click.Context(cli.octant, info_name="octant", **cli.CONTEXT)
    lines = [VERBS_HEAD]
    for name in cli.VERBS:
        command = cli.octant.get_command(root, name)
        assert command is not None  # noqa: S101  the table of verbs names commands only
        lines += verb_lines(name, command, root)
    return "\n".join(lines)


def json_page() -> str:
    """Return the page of what each verb prints with ``--json``, from its schema."""
    lines = [JSON_HEAD]
    for verb, keys in SCHEMAS.items():
        lines += [f"## octant {verb} --json", "", "| key | meaning |", "|---|---|"]
        lines += [f"| `{key}` | {text.replace('|', chr(92) + '|')} |" for key, text in keys.items()]
        lines.append("")
    return "\n".join(lines)


def verb_lines(name: str, command: click.Command, root: click.Context) -> Iterator[str]:
    """Yield the section of one verb.

    Parameters
    ----------
    name, command, root : Of the verb, and the context of ``octant``.
    """
    context = click.Context(command, info_name=name, parent=root)
    usage = " ".join(command.collect_usage_pieces(context))
    text = inspect.cleandoc((command.help or "").replace("\b", ""))
    text = re.sub(r"(?<![\w`-])(--[a-z][\w-]*)", r"`\1`", text)
    yield from (f"## octant {name}", "", text.replace("|", "\\|"), "")
    yield from ("```text", f"octant {name} {usage}", "```", "")
    yield from ("| option | value | default | meaning |", "|---|---|---|---|")
    for parameter in command.get_params(context):
        if isinstance(parameter, click.Option) and not parameter.hidden:
            flags = ", ".join(f"`{flag}`" for flag in (*parameter.opts, *parameter.secondary_opts))
            value = value_text(parameter, context)
            given = default_text(parameter)
            meaning = (parameter.help or "").replace("|", "\\|")
            yield f"| {flags} | {value} | {given} | {meaning} |"
    yield ""


def value_text(option: click.Option, context: click.Context) -> str:
    """Return what an option takes: nothing, a kind of value with its range, or a choice.

    Parameters
    ----------
    option, context : Of click.
    """
    if option.is_flag or option.count:
        return "–"
    kind = option.type
    if isinstance(kind, click.Choice):
        return " or ".join(f"`{choice}`" for choice in kind.choices)
    text = option.make_metavar(context).strip("[]")
    if isinstance(kind, click.IntRange | click.FloatRange):
        words = {"INTEGER RANGE": "whole number", "FLOAT RANGE": "number"}
        text = words.get(option.make_metavar(context).strip("[]"), text)
        if kind.min is not None and kind.max is not None and kind.max < 1e15:
            text += f", {kind.min:g} to {kind.max:g}"
        elif kind.min is not None:
            text += f", at least {kind.min:g}"
    more = ", several times" if option.multiple else ""
    return text.replace("|", "\\|") + more


def default_text(option: click.Option) -> str:
    """Return the default of an option as its help shows it.

    Parameters
    ----------
    option : Of click.
    """
    if option.required:
        return "must be given"
    if option.show_default and option.default is not None:
        shown = option.show_default if isinstance(option.show_default, str) else option.default
        return f"`{shown}`"
    return "–"


def face_page() -> str:
    """Return the names at ``octant.`` as autodoc documents them."""
    import octant

    lines = []
    for name in octant.__all__:
        if isinstance(getattr(octant, name), type):
            lines += [f".. autoclass:: octant.{name}", "   :members:", "   :inherited-members:", ""]
        else:
            lines += [f".. autofunction:: octant.{name}", ""]
    return "\n".join(lines)


def glossary_page() -> str:
    """Return the page of terms, from the file that the reports read too."""
    lines = [GLOSSARY_HEAD]
    if not GLOSSARY.exists():
        return GLOSSARY_HEAD
    terms: list[dict[str, Any]] = tomllib.loads(GLOSSARY.read_text("utf-8"))["term"]
    for term in sorted(terms, key=lambda one: str(one["term"]).casefold()):
        also = f" (also *{', '.join(term['also'])}*)" if term.get("also") else ""
        lines += [
            f"({anchor(term['term'])})=",
            f"**{term['term']}**{also}",
            f": {term['text']}",
            "",
        ]
    return "\n".join(lines)


def anchor(term: str) -> str:
    """Return the name of a term's place in the glossary.

    Parameters
    ----------
    term : Its name.
    """
    return "term-" + re.sub(r"\W+", "-", term.casefold()).strip("-")


SECTION = re.compile(r"^(\w+(?: \w+)*)\n-{3,}$", re.MULTILINE)
ENTRY = re.compile(r"^(\*{0,2}[A-Za-z_]\w*(?:, \*{0,2}[A-Za-z_]\w*)*) : (.*)$")


def read_docstring(
    _app: Any, _what: str, _name: str, _there: Any, _options: Any, lines: list[str]
) -> None:
    """Turn a docstring of the house's form into one that Sphinx reads: sections and their entries.

    Parameters
    ----------
    _app, _what, _name, _there, _options, lines : As Sphinx gives them; ``lines`` is changed.
    """
    text = SECTION.sub(r".. rubric:: \1\n", "\n".join(lines))
    made = []
    for line in text.splitlines():
        if found := ENTRY.match(line):
            names = found[1].replace("*", "\\*").split(", ")
            made += ["", ", ".join(f"**{name}**" for name in names), f"    {found[2]}"]
        else:
            made.append(line)
    lines[:] = made
