"""The house keeps its own rules: imports run downward, numba stays in kernels, names are told."""

import ast
import itertools
import re
from pathlib import Path

import pytest

import octant.geometries

ROOT = Path(__file__).resolve().parents[2]
LAYERS = ("geometries", "em", "navigation", "reader_design")
MODULES = sorted(p for layer in LAYERS for p in (ROOT / layer).rglob("*.py"))
PUBLIC = [p for p in MODULES if not p.stem.startswith("_")]


def short(path):
    return str(path.relative_to(ROOT))


def imported(tree):
    """Yield every module name that a tree imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "relative imports hide the layer"
            yield node.module


def test_the_layers_are_installed_under_one_name():
    assert octant.geometries.__name__ == "octant.geometries"
    assert MODULES


@pytest.mark.parametrize("path", MODULES, ids=short)
def test_imports_run_only_downward(path):
    layer = path.relative_to(ROOT).parts[0]
    above = LAYERS[LAYERS.index(layer) + 1 :]
    for name in imported(ast.parse(path.read_text())):
        parts = name.split(".")
        assert parts[0] not in LAYERS, f"{name} is imported without octant."
        if parts[0] == "octant":
            assert parts[1] not in above, f"{layer} imports {name}"


@pytest.mark.parametrize("path", MODULES, ids=short)
def test_numba_is_imported_by_kernel_modules_only(path):
    names = {name.split(".")[0] for name in imported(ast.parse(path.read_text()))}
    listens = path == ROOT / "reader_design" / "compilation.py"  # to the compiler, and no more
    assert ("numba" in names) <= (listens or bool(re.fullmatch(r"_.*_kernels", path.stem)))


def documented(node):
    """Yield every public class and function of a module with its qualified name."""
    for child in node.body:
        if isinstance(child, ast.ClassDef | ast.FunctionDef) and not child.name.startswith("_"):
            yield child
            if isinstance(child, ast.ClassDef):
                yield from documented(child)


def parameters(function):
    a = function.args
    named = [*a.posonlyargs, *a.args, *a.kwonlyargs]
    return [arg for arg in named if arg.arg not in ("self", "cls")]


def section(docstring, title):
    """Return the body of a numpydoc section, dedented."""
    lines = ast.get_docstring(ast.parse(f'def f():\n    """{title}"""').body[0]) or ""
    assert lines == title
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
            for name in names:
                entries[name] = line
        else:
            for name in names:
                entries[name] += " " + line.strip()
    return entries


NUMERIC = re.compile(r"\b(float|ArrayLike|FloatArray|ComplexArray)\b|NDArray\[np\.(float|complex)")
UNIT = re.compile(r"\[[^\]]+\]|`[A-Z]\w+`")


def described_fields(node):
    """Return {name: text} of fields that a string literal follows."""
    return {
        field.target.id: text.value.value
        for field, text in itertools.pairwise(node.body)
        if isinstance(field, ast.AnnAssign)
        and isinstance(text, ast.Expr)
        and isinstance(text.value, ast.Constant)
    }


def is_command(node):
    """Whether click turns the docstring into help for people at a terminal."""
    return any(
        "command" in ast.unparse(d) or "group" in ast.unparse(d) for d in node.decorator_list
    )


@pytest.mark.parametrize("path", PUBLIC, ids=short)
def test_everything_public_is_documented_with_units(path):
    tree = ast.parse(path.read_text())
    assert ast.get_docstring(tree), "the module has no docstring"
    missing = []
    for node in documented(tree):
        text = ast.get_docstring(node)
        if not text:
            missing.append(f"{node.name}: no docstring")
            continue
        if isinstance(node, ast.ClassDef):
            fields = [
                (f.target.id, ast.unparse(f.annotation))
                for f in node.body
                if isinstance(f, ast.AnnAssign) and not f.target.id.startswith("_")
            ]
            is_data = any("dataclass" in ast.unparse(d) for d in node.decorator_list)
            wanted = fields if is_data else []
        else:
            if is_command(node):
                continue
            wanted = [(a.arg, ast.unparse(a.annotation)) for a in parameters(node)]
        entries = described(text)
        if isinstance(node, ast.ClassDef):
            entries |= described_fields(node)
        for name, kind in wanted:
            if name.startswith("_"):
                continue
            if name not in entries:
                missing.append(f"{node.name}: {name} is not described")
            elif "Callable" not in kind and NUMERIC.search(kind) and not UNIT.search(entries[name]):
                missing.append(f"{node.name}: {name} has no [unit]")
    assert not missing, "\n".join(missing)


@pytest.mark.parametrize("path", PUBLIC, ids=short)
def test_no_public_function_swallows_unknown_keywords(path):
    for node in documented(ast.parse(path.read_text())):
        if isinstance(node, ast.FunctionDef):
            assert node.args.kwarg is None, f"{node.name} takes **{node.args.kwarg.arg}"


@pytest.mark.parametrize("path", MODULES, ids=short)
def test_nothing_is_left_for_later(path):
    text = path.read_text()
    assert not re.search(r"\b(TODO|FIXME|XXX|NotImplementedError)\b", text)


@pytest.mark.parametrize("path", PUBLIC, ids=short)
def test_more_than_two_physical_floats_go_by_name(path):
    for node in documented(ast.parse(path.read_text())):
        if not isinstance(node, ast.FunctionDef):
            continue
        floats = [
            a.arg
            for a in (*node.args.posonlyargs, *node.args.args)
            if a.annotation is not None and ast.unparse(a.annotation) == "float"
        ]
        assert len(floats) <= 2, f"{node.name} takes {floats} by position"
