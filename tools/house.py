"""The source tree as the meta-tests and the drawing read it: one parse, and who imports whom."""

import ast
import re
import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import networkx as nx

ROOT = Path(__file__).resolve().parents[1]
LAYERS = ("geometries", "em", "navigation", "reader_design", "octant")
"""From the lowest to the highest; a layer imports only itself and those before it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Module:
    """One module of the house.

    Parameters
    ----------
    name : str
        Dotted name below ``octant``, such as ``em.paths.tracing``.
    path : Path
        Its file.
    tree : ast.Module
        Its parsed text.
    """

    name: str
    path: Path
    tree: ast.Module

    @property
    def layer(self) -> str:
        """The layer it stands in."""
        return self.name.split(".")[0]

    @property
    def is_kernel(self) -> bool:
        """Whether it may compile with numba."""
        return bool(re.fullmatch(r"_.*_kernels", self.path.stem))

    @property
    def place(self) -> str:
        """Its file, relative to the root."""
        return self.path.relative_to(ROOT).as_posix()

    @property
    def package(self) -> str:
        """The folder it stands in; a module directly in a layer stands for itself."""
        if self.path.stem == "__init__":
            return self.name
        folder = self.name.rpartition(".")[0]
        return folder if "." in folder else self.name


@cache
def modules() -> tuple[Module, ...]:
    """Return every module of every layer, sorted by name."""
    found = []
    for layer in LAYERS:
        for path in (ROOT / layer).rglob("*.py"):
            name = ".".join(path.relative_to(ROOT).with_suffix("").parts)
            tree = ast.parse(path.read_text(encoding="utf-8"))
            found.append(Module(name=name.removesuffix(".__init__"), path=path, tree=tree))
    return tuple(sorted(found, key=lambda module: module.name))


@cache
def imports() -> tuple[tuple[Module, str], ...]:
    """Return (module, absolute dotted name it imports), one pair an imported name."""
    known = {f"octant.{module.name}" for module in modules()}
    pairs: list[tuple[Module, str]] = []
    for module in modules():
        for node in ast.walk(module.tree):
            if isinstance(node, ast.Import):
                pairs += [(module, alias.name) for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                source = "." * node.level + (node.module or "")
                for alias in node.names:
                    whole = f"{source}.{alias.name}"
                    pairs.append((module, whole if whole in known else source))
    return tuple(dict.fromkeys(pairs))


@cache
def package_graph() -> nx.DiGraph:
    """Return the packages, an edge for each that imports another; its `why` lists the imports."""
    by_name = {f"octant.{module.name}": module for module in modules()}
    graph = nx.DiGraph()
    graph.add_nodes_from(module.package for module in modules())
    for module, name in imports():
        target = by_name.get(name)
        if target is not None and target.package != module.package:
            graph.add_edge(module.package, target.package)
            why = graph.edges[module.package, target.package].setdefault("why", [])
            why.append(f"{module.name} -> {target.name}")
    return graph


def project() -> dict:
    """Return the content of pyproject.toml."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
