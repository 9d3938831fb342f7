"""Draw the house from its imports: ``python tools/draw_house.py`` writes docs/figures/house.svg.

A band is a layer, a box is a package (a folder) or a module that stands directly in a layer. A line
leads from a box down to one that it imports; lines that follow from others are left out, and so are
those between layers, where any box may import any other below. ``--check`` only says whether the
file is up to date.
"""

import argparse
import ast
import html
import math
import sys

import house
import networkx as nx

PICTURE = house.ROOT / "docs" / "figures" / "house.svg"
WIDTH, MARGIN, HEAD = 1240, 20, 34
BOX_HEIGHT, ROW_GAP, GAP, WIDEST_GAP = 26, 36, 14, 60
"""Sizes [px]."""
FONT = 'font-family="DejaVu Sans, Verdana, sans-serif"'
FILLS = {
    "octant": "#f3e9f7",
    "reader_design": "#e6eff9",
    "navigation": "#e7f5ea",
    "em": "#fdf3de",
    "geometries": "#f6e7e4",
}


def first_line(name: str) -> str:
    """Return the first line of the docstring of a package or module, empty if it has none."""
    module = next((m for m in house.modules() if m.name == name), None)
    text = module and ast.get_docstring(module.tree)
    return text.splitlines()[0] if text else ""


def rows_of(graph: nx.DiGraph) -> list[list[str]]:
    """Return the boxes of a layer in rows: each box above all that it imports."""
    groups = nx.condensation(graph)
    height: dict[int, int] = {}
    for group in reversed(list(nx.topological_sort(groups))):
        height[group] = 1 + max((height[below] for below in groups[group]), default=-1)
    rows: list[list[str]] = [[] for _ in range(1 + max(height.values()))]
    for group, members in groups.nodes(data="members"):
        rows[-1 - height[group]] += members
    place: dict[str, float] = {}
    for row in rows:  # below what imports it, so that the lines stay short
        row.sort()
        above = {b: [place[a] for a in graph.predecessors(b) if a in place] for b in row}
        row.sort(key=lambda b: math.fsum(above[b]) / len(above[b]) if above[b] else 0.5)
        place |= {box: (i + 0.5) / len(row) for i, box in enumerate(row)}
    return rows


def label(box: str) -> str:
    """Return what is written in a box: its name below the layer."""
    return box.partition(".")[2] or box


def width_of(box: str) -> float:
    """Return the width of a box [px]."""
    return 7.2 * len(label(box)) + 16


def split(row: list[str]) -> list[list[str]]:
    """Return a row as rows that fit into the picture's width."""
    lines: list[list[str]] = [[]]
    for box in row:
        if sum(width_of(b) + GAP for b in [*lines[-1], box]) > WIDTH - 2 * MARGIN:
            lines.append([])
        lines[-1].append(box)
    return lines


def band(layer: str, graph: nx.DiGraph, top: float) -> tuple[list[str], float]:
    """Return the drawing of one layer and where it ends.

    Parameters
    ----------
    layer : str
        Its name.
    graph : networkx.DiGraph
        Its boxes and their imports.
    top : float
        Where the band begins [px].
    """
    boxes: dict[str, tuple[float, float]] = {}
    y = top + HEAD
    for row in rows_of(graph):
        for line in split(row):
            room = WIDTH - 2 * MARGIN - sum(map(width_of, line))
            gap = min(WIDEST_GAP, room / max(1, len(line) - 1))
            x = (WIDTH - sum(map(width_of, line)) - gap * (len(line) - 1)) / 2
            for box in line:
                boxes[box] = (x, y)
                x += width_of(box) + gap
            y += BOX_HEIGHT + 8
        y += ROW_GAP - 8
    bottom = y - ROW_GAP + 14
    about = f'<tspan font-size="12" dx="10">{html.escape(first_line(layer))}</tspan>'
    drawn = [
        f'<rect x="4" y="{top:.0f}" width="{WIDTH - 8}" height="{bottom - top:.0f}" rx="8"',
        f' fill="{FILLS[layer]}"/>',
        f'<text x="{MARGIN}" y="{top + 21:.0f}" font-size="15">',
        f'<tspan font-weight="bold">{layer}</tspan>{about}</text>',
    ]
    lines = nx.transitive_reduction(graph) if nx.is_directed_acyclic_graph(graph) else graph
    for a, b in sorted(lines.edges):
        x1, y1 = boxes[a][0] + width_of(a) / 2, boxes[a][1] + BOX_HEIGHT
        x2, y2 = boxes[b][0] + width_of(b) / 2, boxes[b][1]
        bend = (y2 - y1) / 2
        drawn.append(
            f'<path d="M{x1:.1f} {y1:.1f}C{x1:.1f} {y1 + bend:.1f} {x2:.1f} {y2 - bend:.1f} '
            f'{x2:.1f} {y2:.1f}" fill="none" stroke="#777" stroke-width="0.9"/>'
        )
    for box, (x, y) in sorted(boxes.items()):
        folder = (house.ROOT / box.replace(".", "/")).is_dir()
        drawn += [
            f"<g><title>{box}: {html.escape(first_line(box))}</title>",
            f'<rect x="{x:.1f}" y="{y:.1f}" width="{width_of(box):.1f}" height="{BOX_HEIGHT}"',
            f' rx="4" fill="white" stroke="#444" stroke-width="{1.4 if folder else 0.6}"/>',
            f'<text x="{x + width_of(box) / 2:.1f}" y="{y + 17:.1f}" font-size="12"',
            f' text-anchor="middle">{label(box)}</text></g>',
        ]
    return drawn, bottom


def picture() -> str:
    """Return the whole picture as SVG, the highest layer on top."""
    graph = house.package_graph()
    filled = {m.package for m in house.modules() if m.path.stem != "__init__"}
    drawn: list[str] = []
    y = 4.0
    for layer in reversed(house.LAYERS):
        within = {b for b in graph if b.split(".")[0] == layer}
        part, y = band(layer, nx.DiGraph(graph.subgraph(within & filled or within)), y)
        drawn += part
        y += 8
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {y:.0f}" {FONT} '
        'fill="#222">\n<rect width="100%" height="100%" fill="white"/>'
    )
    return "\n".join([head, *drawn, "</svg>"]) + "\n"


def main() -> int:
    """Return 0; 1 where the picture is checked and not up to date."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing")
    drawn = picture()
    if parser.parse_args().check:
        if PICTURE.exists() and PICTURE.read_text(encoding="utf-8") == drawn:
            return 0
        sys.stderr.write(f"{PICTURE} is not up to date: run python tools/draw_house.py\n")
        return 1
    PICTURE.write_text(drawn, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
