"""Paths as people and programs read them: the strongest as a table, all as a document."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from octant.em.decibels import decibels
from octant.reader_design.face.paths import (
    BUDGET_COLUMNS,
    PATH_COLUMNS,
    Block,
    Explanation,
    PathLink,
    path_rows,
    receiver_sums,
)
from octant.reader_design.terminal.documents import rows_of
from octant.reader_design.terminal.tables import text_table

HEADER = (
    "path",
    "order",
    "interactions",
    "length [m]",
    "gain [dB]",
    "departs [deg]",
    "arrives [deg]",
)
"""Of the table that people read; a direction is theta from +z and phi from +x."""


def path_lines(block: Block, *, most: int | None) -> Iterator[str]:
    """Yield a table of the strongest paths of each receiver of a block, the strongest first.

    Parameters
    ----------
    block : From `PathLink.blocks`.
    most : Paths of each receiver; None: all.
    """
    rows = rows_of(PATH_COLUMNS, list(path_rows(block)))
    first, found, gains = block
    order = np.lexsort((-np.abs(gains.gain), found.receiver))
    for receiver in range(len(found.receivers_m)):
        mine = [rows[k] for k in order if found.receiver[k] == receiver]
        if not mine:
            continue
        shown = mine[:most]
        yield ""
        yield f"paths to receiver {first + receiver}, the strongest first:"
        yield from text_table(HEADER, [_cells(row) for row in shown], words=("interactions",))
        if len(shown) < len(mine):
            yield (f"... and {len(mine) - len(shown)} weaker ones; --all lists every one.")


def _cells(row: dict[str, Any]) -> tuple[str, ...]:
    angles = [
        f"{row[f'{end}_theta_deg']:.1f}, {row[f'{end}_phi_deg']:5.1f}"
        for end in ("departure", "arrival")
    ]
    return (
        str(row["path"]),
        str(row["order"]),
        row["interactions"] or "line of sight",
        f"{row['length_m']:.3f}",
        f"{row['gain_db']:.2f}",
        *angles,
    )


def search_lines(link: PathLink) -> Iterator[str]:
    """Yield what the search for the paths considered and left out, counts without unit.

    Parameters
    ----------
    link : What was traced.
    """
    tree, edges = link.candidates.images, link.candidates.edges
    for order in range(tree.max_order + 1):
        yield (
            f"order {order}: {tree.considered[order]} sequences considered, "
            f"{tree.pruned[order]} pruned, {tree.merged[order]} merged, "
            f"{tree.kept[order]} images kept."
        )
    if edges is not None:
        yield (
            f"edges: {edges.considered} sequences over {len(link.radio.wedges)} wedges "
            f"considered, {edges.considered - edges.kept} pruned, "
            f"{edges.kept} kept."
        )


def paths_document(
    link: PathLink, blocks: Sequence[Block], *, study: Path | None
) -> dict[str, Any]:
    """Return all paths and the sums of each receiver as plain values, units in the names.

    Parameters
    ----------
    link, blocks, study : What was traced, from `PathLink.blocks`; the study's file.
    """
    sums = np.concatenate([receiver_sums(block) for block in blocks])
    inside = link.setting.scene.inside_room(link.receivers_m)
    receivers = [
        {
            "rx": i,
            "position_m": place,
            "inside_room": bool(inside[i]),
            "paths": int(sums[i, 0]),
            "coherent_db": decibels(sums[i, 1]),
            "power_sum_db": decibels(sums[i, 2]),
        }
        for i, place in enumerate(link.receivers_m.tolist())
    ]
    rows = []
    for block in blocks:
        found = block[1]
        for k, row in enumerate(rows_of(PATH_COLUMNS, list(path_rows(block)))):
            del row["vertices"]
            rows.append({**row, "vertices_m": found.vertices_of(k)})
    return {
        "verb": "paths",
        "study": study,
        "frequency_hz": link.radio.frequency_hz,
        "transmitter_m": link.candidates.images.source_m,
        **link.ray_attributes(),
        "receivers": receivers,
        "paths": rows,
    }


def explanation_document(explanation: Explanation | None, *, study: Path | None) -> dict[str, Any]:
    """Return the budget of one path as plain values, units in the names.

    Parameters
    ----------
    explanation, study : The path (None: no path arrives); the study's file.
    """
    if explanation is None:
        return {"verb": "explain", "study": study, "path": None, "steps": []}
    chosen, gains = explanation.path, explanation.gains
    return {
        "verb": "explain",
        "study": study,
        "frequency_hz": explanation.link.radio.frequency_hz,
        "path": chosen,
        "paths": len(explanation.found),
        "order": int(explanation.found.order[chosen]),
        "interactions": ",".join(explanation.found.letters_of(chosen)),
        "length_m": gains.length_m[chosen],
        "delay_ns": 1e9 * gains.delay_s[chosen],
        "vertices_m": explanation.found.vertices_of(chosen),
        "gain_db": explanation.budget.gain_db,
        "phase_deg": float(np.degrees(np.angle(explanation.budget.gain))),
        "steps": rows_of(BUDGET_COLUMNS, list(explanation.rows())),
    }
