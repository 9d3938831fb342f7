"""The report of ``octant sweep``: all designs in one table, with plots beside it."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from octant.reader_design.experiments.sweep.maps import design_maps
from octant.reader_design.experiments.sweep.results import SweepResults
from octant.reader_design.keeping.versions import versions
from octant.reader_design.showing.designs_view import Column, designs_table, designs_widget
from octant.reader_design.showing.pages import Report, ReportLink, ReportSection, ReportTable

if TYPE_CHECKING:
    import xarray as xr

FACTORS = {"rad": (math.degrees(1.0), "°"), "W": (1e9, "nW"), "m": (100.0, "cm")}
"""Factor and unit in which a page shows numbers, by the unit that they are kept in."""
FIRST = ("right_share", "vector_rms_rad", "margin_worst_db", "level_median_dbm")
"""Scores that come first, in the room where there is one."""
MOST_DESIGNS = 400
"""Designs that a page holds [-]."""
PARAMETER = 2
"""Place of the parameters' columns, after the scores that come first [-]."""
ROUNDING = 1e-9
"""Numbers that are nothing but rounding, in the unit in which they are shown [any]."""
PLACES = {"free_space": "in free space", "room": "in the room"}


def sweep_report(results: SweepResults, study_toml: str) -> Report:
    """Return the report of a sweep ([%], [°], [dB], [cm]).

    Parameters
    ----------
    results, study_toml : The sweep's table; the resolved study.
    """
    table = results.table
    status = table["status"].values.astype(str)
    every = np.flatnonzero(status == "done")
    share = table["right_share"].values[every].max(axis=1, initial=0.0)
    done = np.sort(every[np.argsort(-share, kind="stable")[:MOST_DESIGNS]])
    scored = table.isel(cell=done)
    labels = scored["label"].values.astype(str).tolist() if "label" in scored else []
    columns = sorted(_columns(scored, results.parameters), key=lambda one: one[0])
    ordered = [column for _, column in columns]
    failed = [
        (str(table["label"].values[k]), str(table["failed_because"].values[k]))
        for k in np.flatnonzero(status == "failed")
    ]
    widget = designs_widget(labels, ordered)
    all_done = sorted(_columns(table.isel(cell=every), results.parameters), key=lambda one: one[0])
    maps = design_maps(
        [column for (kind, _), column in all_done if kind == PARAMETER],
        [column for (kind, _), column in all_done if kind != PARAMETER],
    )
    found = "; ".join(f"{n.removesuffix('_version')} {v}" for n, v in versions().items())
    tables = [
        designs_table(
            labels,
            ordered,
            caption="All designs that have scores. Click a heading to sort; “Columns” has all "
            "other parameters and scores.",
        )
    ]
    if failed:
        tables.append(
            ReportTable(
                caption="Designs without scores.",
                header=("design", "reason"),
                rows=tuple(failed),
                words=True,
            )
        )
    return Report(
        title=f"{table.attrs.get('title', 'Sweep')}",
        subtitle=f"{len(every)} of {len(status)} designs have scores"
        + (
            f"; the {MOST_DESIGNS} that find the right antenna most often are shown"
            if len(every) > MOST_DESIGNS
            else ""
        ),
        summary=(),
        warnings=(),
        facts=(),
        sections=(
            ReportSection(
                heading="Designs",
                widgets=() if widget is None else (widget,),
                tables=tuple(tables) if len(done) else tuple(tables[1:]),
            ),
            *((ReportSection(heading="Maps", figures=maps),) if maps else ()),
            ReportSection(
                heading="Reproduce it",
                paragraphs=(f"Versions: {found}.",),
                links=(
                    ReportLink(file="sweep.csv", what="all designs with all scores"),
                    ReportLink(file="sweep.nc", what="the same with units"),
                    ReportLink(file="study.toml", what="the resolved study"),
                ),
                folded=(
                    ("The command", "octant sweep study.toml --out again"),
                    ("The study with every default resolved (study.toml)", study_toml),
                ),
            ),
        ),
    )


def _columns(
    table: "xr.Dataset", parameters: tuple[str, ...]
) -> Iterator[tuple[tuple[int, int], Column]]:
    """Yield a place in the order and a column for each parameter and score."""
    for number, name in enumerate(parameters):
        item = table[name]
        column = _column(_heading(name), item.values, str(item.attrs.get("units", "1")))
        yield (PARAMETER, number), column
    number = 0
    for key, item in table.data_vars.items():
        name = str(key)
        if "surrounding" not in item.dims or item.dtype.kind != "f" or len(item.dims) != 2:
            continue
        places = table["surrounding"].values.astype(str)
        for k in np.argsort(places)[::-1]:  # the room comes first
            values = item.isel(surrounding=int(k)).values
            if not np.isfinite(values).any():
                continue
            where = PLACES.get(str(places[k]), str(places[k]))
            unit = "share" if name.endswith("_share") else str(item.attrs.get("units", "1"))
            first = name in FIRST and places[k] == max(places)
            number += 1
            rank = FIRST.index(name) if first else number
            yield (
                (1 if first else 3, rank),
                _column(f"{_heading(name)}, {where}", values, unit),
            )


def _heading(name: str) -> str:
    for ending in ("_rad", "_dbm", "_db", "_w", "_m", "_hz", "_share", "_per_rad"):
        name = name.removesuffix(ending)
    return name.replace("_", " ")


def _column(heading: str, values: object, unit: str) -> Column:
    array = np.asarray(values)
    if array.dtype.kind not in "fi":
        return Column(heading=heading, texts=tuple(str(value) for value in array.tolist()))
    factor, shown = FACTORS.get(unit, (100.0, "%") if unit == "share" else (1.0, unit))
    scaled = factor * array.astype(np.float64)
    scaled = np.where(np.abs(scaled) < ROUNDING, 0.0, scaled)
    return Column(
        heading=heading if shown == "1" else f"{heading} [{shown}]",
        texts=tuple(f"{v:.4g}" if math.isfinite(v) else "–" for v in scaled.tolist()),
        values=tuple(scaled.tolist()),
    )
