"""The house keeps its own laws: where imports may run, what is documented, what is installed."""

import ast
import itertools
import re
from collections import defaultdict
from functools import cache
from xml.etree import ElementTree as ET

import draw_house
import house
import list_keys
import networkx as nx
import pytest

EXPERIMENTS = "reader_design.experiments"
STUDY_MAY_USE = {"sweep", "choice", "missions", "tolerance"}
KNOW_NUMBA = (
    "geometries.kernel_list",
    "geometries.kernel_target",
    "geometries.kernels",
    "geometries.kept_code",
    "reader_design.compilation",
)


def public():
    return [m for m in house.modules() if not m.path.stem.startswith("_")]


def ours():
    """Yield (importing module, the dotted name below octant that it imports)."""
    for module, name in house.imports():
        if name.startswith("octant."):
            yield module, name.removeprefix("octant.")


def below(name, package):
    return name == package or name.startswith(f"{package}.")


def complain(offenders, law):
    offenders = sorted(set(offenders))
    assert not offenders, f"{law}:\n" + "\n".join(offenders)


# Imports ------------------------------------------------------------------------------------------


def test_imports_are_absolute_and_below_octant():
    complain(
        (
            f"{module.place}: {name}"
            for module, name in house.imports()
            if name.startswith(".") or name.split(".")[0] in house.LAYERS[:-1]
        ),
        "an import must read 'from octant.<layer>...'",
    )


def test_imports_run_only_downward():
    rank = {layer: i for i, layer in enumerate(house.LAYERS)}
    complain(
        (
            f"{module.place} imports octant.{name}"
            for module, name in ours()
            if rank[name.split(".")[0]] > rank[module.layer]
        ),
        "a layer imports one above it",
    )


def experiment_of(name):
    return name.removeprefix(f"{EXPERIMENTS}.").split(".")[0] if below(name, EXPERIMENTS) else ""


def test_experiments_stand_apart():
    complain(
        (
            f"{module.place} imports octant.{name}"
            for module, name in ours()
            if (mine := experiment_of(module.name))
            and (theirs := experiment_of(name)) not in ("", mine)
            and not (mine == "study" and theirs in STUDY_MAY_USE)
        ),
        f"an experiment imports another; only 'study' may, and only {sorted(STUDY_MAY_USE)}",
    )


@pytest.mark.parametrize(
    ("package", "unknown"),
    [
        ("showing", ["experiments", "commands", "cli"]),
        ("keeping", ["experiments", "commands", "cli", "setting", "study_file", "showing"]),
        ("study_file", ["setting", "keeping", "showing", "commands", "cli"]),
        ("setting", ["experiments", "commands", "cli"]),
    ],
)
def test_what_experiments_share_does_not_know_them(package, unknown):
    complain(
        (
            f"{module.place} imports octant.{name}"
            for module, name in ours()
            if below(module.name, f"reader_design.{package}")
            and any(below(name, f"reader_design.{other}") for other in unknown)
            and not (package == "study_file" and name.endswith(".table"))
        ),
        f"{package} must not know {', '.join(unknown)}",
    )


@pytest.mark.parametrize("layer", house.LAYERS)
def test_no_packages_import_each_other_in_a_circle(layer):
    graph = house.package_graph()
    graph = graph.subgraph(package for package in graph if below(package, layer))
    lines = []
    for circle in nx.strongly_connected_components(graph):
        edges = sorted(graph.subgraph(circle).edges(data="why"))
        if edges:
            lines.append(f"circle: {', '.join(sorted(circle))}")
        lines += [f"    {reason}" for _, _, why in edges for reason in why]
    assert not lines, "\n".join(lines)


def test_numba_is_imported_by_kernel_modules_only():
    complain(
        (
            module.place
            for module, name in house.imports()
            if name.split(".")[0] == "numba" and not (module.is_kernel or module.name in KNOW_NUMBA)
        ),
        "numba belongs into _*_kernels.py",
    )


# Documentation ------------------------------------------------------------------------------------


def documented(module):
    """Yield (class or None, node) of every public class and function of a module."""

    def inside(node, owner):
        for child in node.body:
            if isinstance(child, ast.ClassDef | ast.FunctionDef) and child.name[0] != "_":
                yield owner, child
                if isinstance(child, ast.ClassDef):
                    yield from inside(child, child)

    yield from inside(module.tree, None)


def base_names(node):
    """Return the last names of the bases of a class, without what stands in brackets."""
    plain = (base.value if isinstance(base, ast.Subscript) else base for base in node.bases)
    return [ast.unparse(base).split(".")[-1] for base in plain]


@cache
def classes():
    """Every class of the house by its name, read when a test asks for it."""
    found = defaultdict(list)
    for module in house.modules():
        for node in ast.walk(module.tree):
            if isinstance(node, ast.ClassDef):
                found[node.name].append(node)
    return found


def methods(node):
    return {child.name for child in node.body if isinstance(child, ast.FunctionDef)}


def descends(node, name):
    """Whether a class has an ancestor of this name, in the tree or outside it."""
    bases = [base for base in base_names(node) if base != node.name]
    return name in bases or any(
        descends(parent, name) for b in bases for parent in classes().get(b, ())
    )


def is_table(node):
    """Whether a class holds the fields of a table: a dataclass, or a table of the study file."""
    decorated = any("dataclass" in ast.unparse(d) for d in node.decorator_list)
    return decorated or descends(node, "Struct")


@cache
def protocols():
    return [n for nodes in classes().values() for n in nodes if "Protocol" in base_names(n)]


def is_implementation(owner, function):
    """Whether a method does what its class's base or a protocol already describes."""
    if owner is None or owner in protocols():
        return False
    for base in base_names(owner):
        for parent in classes().get(base, ()):
            if function.name in methods(parent) or is_implementation(parent, function):
                return True
    return any(function.name in methods(p) and methods(p) <= methods(owner) for p in protocols())


def section(docstring, title):
    """Return the body of a numpydoc section, dedented."""
    pattern = rf"^{title}\n-+\n(.*?)(?=^\w[\w ]*\n-+\n|\Z)"
    found = re.search(pattern, docstring, re.DOTALL | re.MULTILINE)
    return found.group(1) if found else ""


def described(docstring):
    """Return {name: text} of the Parameters and Attributes; 'a, b : type' describes both."""
    entries, names = {}, []
    text = section(docstring, "Parameters") + "\n" + section(docstring, "Attributes")
    for line in text.splitlines():
        head = re.match(r"^([A-Za-z_*][\w*]*(?:, [A-Za-z_*][\w*]*)*)(?: :(.*))?$", line)
        if head:
            names = [n.strip("*") for n in head.group(1).split(", ")]
            entries |= dict.fromkeys(names, line)
        else:
            entries |= {name: f"{entries[name]} {line.strip()}" for name in names}
    return entries


def described_fields(node):
    """Return {name: text} of fields that a string literal follows."""
    return {
        field.target.id: text.value.value
        for field, text in itertools.pairwise(node.body)
        if isinstance(field, ast.AnnAssign)
        and isinstance(text, ast.Expr)
        and isinstance(text.value, ast.Constant)
    }


def described_above(node):
    """Return {name: text} of what the tables above a table in the study file describe."""
    entries = {}
    for base in base_names(node):
        for parent in classes().get(base, ()):
            entries |= described_above(parent) | described(ast.get_docstring(parent) or "")
    return entries


def is_command(node):
    """Whether click turns the docstring into help for people at a terminal."""
    return any(
        "command" in ast.unparse(d) or "group" in ast.unparse(d) for d in node.decorator_list
    )


def wanted(owner, node):
    """Return {name: annotation} of what the docstring of a class or function must describe."""
    if isinstance(node, ast.ClassDef):
        fields = {
            f.target.id: ast.unparse(f.annotation)
            for f in node.body
            if isinstance(f, ast.AnnAssign) and "ClassVar" not in ast.unparse(f.annotation)
        }
        named = fields if is_table(node) else {}
    elif is_command(node) or is_implementation(owner, node):
        named = {}
    else:
        a = node.args
        named = {
            p.arg: ast.unparse(p.annotation)
            for p in (*a.posonlyargs, *a.args, *a.kwonlyargs)
            if p.arg not in ("self", "cls")
        }
    return {name: kind for name, kind in named.items() if not name.startswith("_")}


NUMERIC = re.compile(
    r"\b(float|ArrayLike|FloatArray|ComplexArray|Positive|NotNegative)\b|NDArray\[np\.(float|complex)"
)
UNIT = re.compile(r"\[[^\]]+\]|`[A-Z]\w+`|\b(unit|share)\b")


def test_everything_public_is_documented_with_units():
    missing = []
    for module in public():
        if not ast.get_docstring(module.tree):
            missing.append(f"{module.place}: the module has no docstring")
        for owner, node in documented(module):
            where = f"{module.place}:{node.lineno}: {node.name}"
            text = ast.get_docstring(node)
            if not text:
                missing.append(f"{where}: no docstring")
                continue
            entries = described(text)
            if isinstance(node, ast.ClassDef):
                entries = described_above(node) | entries | described_fields(node)
            for name, kind in wanted(owner, node).items():
                number = "Callable" not in kind and NUMERIC.search(kind)
                if name not in entries:
                    missing.append(f"{where}: {name} is not described")
                elif number and not UNIT.search(entries[name]):
                    missing.append(f"{where}: {name} has no [unit]")
    complain(missing, "undocumented")


def test_a_class_is_described_by_a_noun():
    complain(
        (
            f"{module.place}:{node.lineno}: {node.name}"
            for module in public()
            for _, node in documented(module)
            if isinstance(node, ast.ClassDef)
            and re.match(r"Returns?\b", ast.get_docstring(node) or "")
        ),
        "a class is a thing; its docstring must not begin with 'Return'",
    )


# Signatures ---------------------------------------------------------------------------------------


def functions():
    for module in public():
        for _, node in documented(module):
            if isinstance(node, ast.FunctionDef):
                yield f"{module.place}:{node.lineno}: {node.name}", node.args


def test_no_public_function_swallows_unknown_keywords():
    complain((f"{w} takes **{a.kwarg.arg}" for w, a in functions() if a.kwarg), "name the keywords")


def test_more_than_two_physical_floats_go_by_name():
    def floats(arguments):
        positional = (*arguments.posonlyargs, *arguments.args)
        return [a for a in positional if a.annotation and ast.unparse(a.annotation) == "float"]

    complain(
        (where for where, arguments in functions() if len(floats(arguments)) > 2),
        "three floats by position are mixed up one day",
    )


def test_nothing_is_left_for_later():
    later = re.compile(r"\b(TODO|FIXME|XXX|NotImplementedError)\b")
    complain(
        (m.place for m in house.modules() if later.search(m.path.read_text(encoding="utf-8"))),
        "something is left for later",
    )


# Installation -------------------------------------------------------------------------------------


def test_every_package_is_installed_with_its_data():
    tools = house.project()["tool"]["setuptools"]
    folders = {"octant"}
    for module in house.modules():
        folder = module.path.parent.relative_to(house.ROOT).as_posix()
        folders.add("octant" if folder == "octant" else "octant." + folder.replace("/", "."))
    assert sorted(tools["packages"]) == sorted(folders)
    for package, patterns in tools["package-data"].items():
        place = house.ROOT / "/".join(package.split(".")[1:] or ["octant"])
        assert all(list(place.glob(pattern)) for pattern in patterns), f"{package}: {patterns}"


# The picture --------------------------------------------------------------------------------------


def test_the_picture_of_the_house_shows_every_package():
    drawn = ET.fromstring(draw_house.picture())  # noqa: S314  our own text
    titles = "\n".join(element.text for element in drawn.findall(".//{*}title"))
    packages = {m.package for m in house.modules() if m.path.stem != "__init__"}
    complain((p for p in packages if f"{p}: " not in titles), "not in the picture")


# What stands beside the house ---------------------------------------------------------------------


def names_of(module):
    """Return the names at the top of a module; None if it makes them when they are asked for."""
    names = set()
    for node in ast.walk(module.tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            names.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            names |= {alias.asname or alias.name for alias in node.names}
    return None if "__getattr__" in names else names


@pytest.mark.parametrize("folder", ["benchmarks", "examples", "tests/regression", "tests/support"])
def test_what_scripts_import_is_there(folder):
    known = {f"octant.{m.name}".replace("octant.octant", "octant"): m for m in house.modules()}
    missing = []
    for path in sorted((house.ROOT / folder).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.ImportFrom) or not (node.module or "").startswith("octant"):
                continue
            names = names_of(known[node.module]) if node.module in known else set()
            missing += [
                f"{path.name}:{node.lineno}: {node.module}.{alias.name}"
                for alias in node.names
                if names is not None
                and alias.name not in names
                and f"{node.module}.{alias.name}" not in known
            ]
    complain(missing, "imported, but not there")


def test_the_list_of_keys_is_up_to_date():
    found = list_keys.PAGE.read_text("utf-8") == list_keys.page()
    assert found, "docs/reference/study_file.md: python tools/list_keys.py"
