"""Write ``sources.md`` and ``published.md`` in ``docs/evidence`` from ``docs/sources.toml``.

    python docs/make_sources.py                       write the pages anew from what is kept
    python docs/make_sources.py --check               say what is wrong; exit code 1 if anything is
    python docs/make_sources.py --run WORK [NAME...]  run the commands, read our values, write
    python docs/make_sources.py --run WORK --as-left  read what the commands left in WORK

``sources.toml`` has a row for each numbered method, experiment, figure and table of the three
documents. Every place in it is looked up: ``octant.module:name`` in the sources, ``octant verb``
among the verbs, ``[table] key`` in the study file, ``tests/file.py::name`` and other paths in the
tree. Values that are read off result files stand in ``sources_values.json``, by the command that
left them; a run that was interrupted goes on in the same folder WORK.
"""

import ast
import csv
import io
import json
import math
import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, get_args

import click
import msgspec

from octant.reader_design.cli import VERBS
from octant.reader_design.study_file.schema import Study

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
PAGES = DOCS / "evidence"
VALUES = DOCS / "sources_values.json"
LAYERS = ("geometries", "em", "navigation", "reader_design")
STATES = ("built", "not computed", "outlook")
"""``not computed``: nothing to compute, as photographs and drawings; ``outlook``: named by the
source itself as future work."""
OWN = frozenset(
    (
        "source", "chapter", "where", "what", "place", "run", "published", "ours", "better",
        "agrees", "open", "state",
    )
)  # fmt: skip
HEAD = """# The three documents, row by row

Written by `python docs/make_sources.py` from `docs/sources.toml`: every numbered method,
experiment, figure and table of the thesis, the docking paper and the textbook pages, where Octant
has it, how to see it, and how it agrees. *Ours* is read off the files that the command leaves;
where nothing is published the cell is empty. [Published against ours](published.md) sets the
numbers side by side, with what the documents leave open.
"""
PUBLISHED_HEAD = """# Published against ours

Written by `python docs/make_sources.py` from `docs/sources.toml` and from what the commands named
there leave. *As published* is the source's own method with its printed settings, as far as it
prints them; *better* is what Octant offers beside it, where it does. The last column names what the
source leaves open, what is chosen here, and what that moves.
"""


def rows_and_runs() -> tuple[list[dict[str, Any]], dict[str, str]]:
    """Return the rows, and the commands by name."""
    data = tomllib.loads((DOCS / "sources.toml").read_text("utf-8"))
    return data["row"], data["run"]


def key_of(reading: Mapping[str, Any]) -> str:
    """Return the name under which a reading's value is kept."""
    where = ",".join(f"{k}={v}" for k, v in sorted(reading.get("rows", {}).items()))
    return f"{reading['file']}[{where}].{reading['column']}"


def readings(row: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """Yield what is read off result files for a row; plain text is not."""
    for part in (*row.get("ours", ()), *row.get("better", ())):
        if isinstance(part, Mapping):
            yield part


def read(reading: Mapping[str, Any], folder: Path) -> float | str:
    """Return one value: of a CSV file, a report's table, or a list in an attribute of netCDF."""
    name, _, inside = reading["file"].partition("#")
    path, column = folder / name, reading["column"]
    wanted = reading.get("rows", {})
    if path.suffix == ".csv":
        with path.open(newline="", encoding="utf-8") as file:
            table = list(csv.DictReader(file))
    elif path.suffix == ".html":
        import pandas as pd

        # set as in print: narrow spaces before units, true minus before digits
        plain = re.sub("−(?=[.0-9])", "-", path.read_text("utf-8").replace("\u202f", " "))
        tables = pd.read_html(io.StringIO(plain), converters=dict.fromkeys((*wanted, column), str))
        table = [
            line
            for one in tables
            if {*wanted, column} <= set(one.columns)
            for line in one.to_dict("records")
        ]
    else:
        import xarray as xr

        with xr.open_dataset(path, engine="h5netcdf") as data:
            table = json.loads(data.attrs[inside])
    found = [line for line in table if all(_fits(v, line[k]) for k, v in wanted.items())]
    if len(found) != 1:
        msg = f"{key_of(reading)}: {len(found)} lines instead of one"
        raise click.ClickException(msg)
    value = found[0][column]
    try:
        return float(value)
    except (TypeError, ValueError):
        return str(value)


def _fits(wanted: object, cell_text: object) -> bool:
    """Return whether a cell holds a value, or begins with what stands behind ``~``."""
    text = str(wanted)
    return str(cell_text).startswith(text[1:]) if text[0] == "~" else str(cell_text) == text


def shown(part: Mapping[str, Any] | str, kept: Mapping[str, Any]) -> str:
    """Return a reading as the pages show it: what it is, its value and its unit."""
    if isinstance(part, str):
        return part
    value, unit = kept.get(key_of(part)), part.get("unit", "")
    if isinstance(value, float):
        value = value * part.get("scale", 1.0)
        value = "–" if math.isnan(value) else f"{value:.{part.get('digits', 2)}f}"
    gap = "" if unit in {"°", ""} else " "
    return f"{part.get('name', '')} {value}{gap}{unit}".strip()


def cell(parts: list[Any], kept: Mapping[str, Any]) -> str:
    """Return the readings of one cell."""
    return "; ".join(shown(part, kept) for part in parts)


def known_places(place: str) -> bool:
    """Return whether a place exists."""
    if place.startswith("octant."):
        return _in_sources(place)
    if place.startswith("octant "):
        return place.split()[1] in VERBS
    if place.startswith("["):
        return _in_study_file(place)
    file, _, name = place.partition("::")
    path = ROOT / file
    return path.exists() and (not name or name in _names(path))


def _names(path: Path) -> dict[str, ast.AST]:
    """Return what a module defines at its top, and in its classes as ``Class.name``."""
    found: dict[str, ast.AST] = {}
    for node in ast.parse(path.read_text("utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found[node.name] = node
            found |= {
                f"{node.name}.{getattr(inner, 'name', None) or _target(inner)}": inner
                for inner in (node.body if isinstance(node, ast.ClassDef) else ())
            }
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            found |= dict.fromkeys(_targets(node), node)
    return found


def _targets(node: ast.AST) -> list[str]:
    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
    names = [t.elts if isinstance(t, ast.Tuple) else [t] for t in targets]
    return [n.id for group in names for n in group if isinstance(n, ast.Name)]


def _target(node: ast.AST) -> str:
    return next(iter(_targets(node)), "")


def _in_sources(place: str) -> bool:
    module, _, name = place.partition(":")
    path = ROOT.joinpath(*module.split(".")[1:])
    file = path.with_suffix(".py")
    if not name:
        return file.exists() or (path / "__init__.py").exists()
    return file.exists() and name in _names(file)


def _in_study_file(place: str) -> bool:
    table, _, key = place.strip("[").replace("]]", "]").partition("]")
    kind: type | None = Study
    for part in (*table.split("."), *key.split()):
        if kind is None:
            return False
        fields = {field.encode_name: field.type for field in msgspec.structs.fields(kind)}
        if part not in fields:
            return False
        kind = next(_structs(fields[part]), None)
    return True


def _structs(kind: Any) -> Iterator[type]:
    if isinstance(kind, type) and issubclass(kind, msgspec.Struct):
        yield kind
    for part in get_args(kind):
        yield from _structs(part)


def complaints(rows: list[dict[str, Any]], runs: Mapping[str, str]) -> Iterator[str]:
    """Yield what is wrong with the rows, in a sentence each."""
    kept = kept_values()
    for row in rows:
        for text in _wrong_with(row, runs, kept.get(row.get("run", ""), {})):
            yield f"{row.get('source')} {row.get('where')}: {text}"
    for name, text in runs.items():
        words = shlex.split(text)
        if words[0] == "octant" and words[1] not in VERBS:
            yield f"[run] {name}: there is no verb {words[1]}"
        for word in words[1:]:
            if word.endswith((".toml", ".py")) and not (ROOT / word).exists():
                yield f"[run] {name}: {word} does not exist"


def _wrong_with(
    row: Mapping[str, Any], runs: Mapping[str, str], kept: Mapping[str, Any]
) -> Iterator[str]:
    state, run, places = row.get("state", "built"), row.get("run"), row.get("place", ())
    if unknown := set(row) - OWN:
        yield f"unknown {sorted(unknown)}"
    if state not in STATES:
        yield f"state {state!r} is none of {STATES}"
    if state == "built" and not (places and row.get("agrees")):
        yield "a row that is built names its place and how it agrees"
    yield from (f"{place} does not exist" for place in places if not known_places(place))
    if run is not None and run not in runs:
        yield f"no command {run!r}"
    if any(key_of(reading) not in kept for reading in readings(row)):
        yield f"no value yet: --run WORK {run}"


NUMBERED = {
    "thesis": (
        "Fig. 1.1 3.1-3.3 4.1-4.5 5.1-5.14 6.1-6.5 7.1-7.15 A.1",
        "Table 5.1 6.1 8.1",
    ),
    "docking paper": ("Fig. 1-19", "Table I"),
    "textbook": ("Fig. 11.19-11.21",),
}
"""Numbers of all figures and tables of each document."""


def _numbers(text: str) -> Iterator[str]:
    """Yield the numbers in a list such as ``5.9 (a), 5.11-5.13``."""
    for first, last in re.findall(r"([A-Z\d]+(?:\.\d+)?)(?:-([A-Z\d]+(?:\.\d+)?))?", text):
        head, _, low = first.rpartition(".")
        ends = (int(low), int(last.rpartition(".")[2])) if last else None
        if ends is None:
            yield first
        else:
            yield from (f"{head}.{n}".lstrip(".") for n in range(ends[0], ends[1] + 1))


def without_row(rows: list[dict[str, Any]]) -> Iterator[str]:
    """Yield the figures and tables of the documents that no row names."""
    for source, lists in NUMBERED.items():
        mine = " ; ".join(row["where"] for row in rows if row["source"] == source)
        for kind, text in (entry.split(" ", 1) for entry in lists):
            word = kind.rstrip(".").upper()
            named = {
                number
                for found in re.findall(
                    rf"{word}S?\.? ([A-Z\d][^;]*?)(?= ;|$|, [A-Z]{{2,}}|, \()", mine.upper()
                )
                for number in _numbers(re.sub(r"\([A-F]\)", "", found))
            }
            yield from (f"{source}: {kind} {n}" for n in _numbers(text) if n not in named)


def kept_values() -> dict[str, dict[str, Any]]:
    """Return what was read, by command and reading."""
    if not VALUES.exists():
        return {}
    found: dict[str, dict[str, Any]] = json.loads(VALUES.read_text("utf-8"))
    return found


def run_and_read(
    rows: list[dict[str, Any]], runs: Mapping[str, str], work: Path, *, as_left: bool
) -> None:
    """Run commands in folders of their own and keep the values that the rows read there."""
    values = kept_values()
    for name, text in runs.items():
        folder = work / name
        words = [str(folder) if word == "OUT" else word for word in shlex.split(text)]
        start = {
            "octant": ["-c", "from octant.reader_design.cli import main; main()"],
            "python": [],
        }
        click.echo(f"{name}: {text}", err=True)
        command = [sys.executable, *start[words[0]], *words[1:]]
        if not as_left:
            subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
        mine = [r for row in rows if row.get("run") == name for r in readings(row)]
        values[name] = {key_of(reading): read(reading, folder) for reading in mine}
    text = json.dumps(values, indent=1, ensure_ascii=False, sort_keys=True)
    VALUES.write_text(f"{text}\n", encoding="utf-8")


def chapters(rows: list[dict[str, Any]]) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    """Yield the rows by heading, in their order."""
    for heading in dict.fromkeys(f"{row['source']}: {row['chapter']}" for row in rows):
        yield heading, [r for r in rows if f"{r['source']}: {r['chapter']}" == heading]


def table(header: tuple[str, ...], lines: Iterator[tuple[str, ...]]) -> Iterator[str]:
    """Yield the lines of a table in Markdown."""
    yield f"| {' | '.join(header)} |"
    yield f"|{'---|' * len(header)}"
    for line in lines:
        yield f"| {' | '.join(c.replace('|', chr(92) + '|') for c in line)} |"


def sources_page(rows: list[dict[str, Any]], runs: Mapping[str, str]) -> str:
    """Return the text of ``sources.md``."""
    kept = kept_values()
    lines = [HEAD]
    header = ("where", "what", "in Octant", "command", "published", "ours", "agreement")
    for heading, mine in chapters(rows):
        lines += [f"## {heading}", ""]
        lines += table(
            header,
            (
                (
                    row["where"],
                    row["what"],
                    ", ".join(f"`{place}`" for place in row.get("place", ())),
                    f"`{runs[row['run']]}`" if "run" in row else "",
                    row.get("published", ""),
                    cell(row.get("ours", []), kept.get(row.get("run", ""), {})),
                    row.get("agrees") or row.get("state", ""),
                )
                for row in mine
            ),
        )
        lines.append("")
    return "\n".join(lines)


def published_page(rows: list[dict[str, Any]], runs: Mapping[str, str]) -> str:
    """Return the text of ``published.md``: rows with published numbers and ours."""
    kept = kept_values()
    lines = [PUBLISHED_HEAD]
    header = ("where", "what", "published", "as published, here", "better, here")
    header = (*header, "agreement", "left open")
    numbers = [r for r in rows if r.get("published") and (r.get("ours") or r.get("better"))]
    for heading, mine in chapters(numbers):
        lines += [f"## {heading}", ""]
        lines += table(
            header,
            (
                (
                    row["where"],
                    row["what"],
                    row["published"],
                    cell(row.get("ours", []), kept.get(row.get("run", ""), {})),
                    cell(row.get("better", []), kept.get(row.get("run", ""), {})),
                    row.get("agrees", ""),
                    row.get("open", ""),
                )
                for row in mine
            ),
        )
        used = dict.fromkeys(runs[row["run"]] for row in mine if "run" in row)
        lines += ["", f"From {'; '.join(f'`{text}`' for text in used)}.", ""]
    return "\n".join(lines)


@click.command()
@click.option("--check", is_flag=True, help="Only say what is wrong.")
@click.option("--run", "work", type=click.Path(path_type=Path), help="Run the commands here.")
@click.option("--as-left", is_flag=True, help="Do not run them: read what they left.")
@click.argument("names", nargs=-1)
def main(*, check: bool, work: Path | None, as_left: bool, names: tuple[str, ...]) -> None:
    """Write both pages of docs/evidence; NAMES choose among the commands to run."""
    rows, runs = rows_and_runs()
    if unknown := set(names) - set(runs):
        msg = f"no command {sorted(unknown)}; there are {', '.join(runs)}"
        raise click.ClickException(msg)
    if work is not None:
        run_and_read(rows, {n: runs[n] for n in names or runs}, work.resolve(), as_left=as_left)
    if missing := list(without_row(rows)):
        click.echo(f"without a row: {'; '.join(missing)}", err=True)
    wrong = list(complaints(rows, runs))
    for name, text in (
        ("sources.md", sources_page(rows, runs)),
        ("published.md", published_page(rows, runs)),
    ):
        page = PAGES / name
        if not check:
            page.write_text(text, encoding="utf-8")
        elif not page.exists() or page.read_text("utf-8") != text:
            wrong.append(f"docs/{name} is not up to date: python docs/make_sources.py")
    for line in wrong:
        click.echo(line, err=True)
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
