"""The cells of a comparison: the study of each combination, checked before any is driven."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.missions.comparison_file import (
    OWN,
    Comparison,
    LayoutEntry,
    LinkEntry,
)
from octant.reader_design.setting.links import mission_table
from octant.reader_design.study_file.loading import load_study, vary
from octant.reader_design.study_file.schema import Map, Study


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparisonCell:
    """One combination of a comparison.

    Attributes
    ----------
    layout, link, reader, controller : str
        Names.
    study : Study
        What is driven: the layout's study with the keys of the other three.
    published_rmse_m : float or None
        Published RMSE of the layout [m].
    """

    layout: str
    link: str
    reader: str
    controller: str
    study: Study
    published_rmse_m: float | None

    @property
    def label(self) -> str:
        """What tells the cell from the others of its layout."""
        names = (self.link, self.reader)
        return "; ".join((self.controller, *(name for name in names if name != OWN)))


def plan_comparison(comparison: Comparison) -> tuple[ComparisonCell, ...]:
    """Return the cells of a comparison, layout by layout; lengths in [m].

    Parameters
    ----------
    comparison : Comparison
        From `octant.reader_design.experiments.missions.comparison_file.load_comparison`.

    Returns
    -------
    tuple of ComparisonCell
        Layouts outermost, controllers innermost.
    """
    cells: list[ComparisonCell] = []
    for layout in comparison.layouts:
        found = list(_cells_of(comparison, layout))
        if any(cell.layout == found[0].layout for cell in cells):
            msg = (
                f"the study {layout.study} is called {found[0].layout!r} as another layout is; "
                "give each study file a name of its own."
            )
            raise ConfigError(msg)
        cells += found
    return tuple(cells)


def _cells_of(comparison: Comparison, layout: LayoutEntry) -> Iterator[ComparisonCell]:
    study = load_study(layout.study)
    mission_table(study)
    for link in comparison.links:
        for reader in comparison.readers:
            for controller in comparison.controllers:
                source = (
                    f"{Path(layout.study).name} with link {link.name!r}, reader {reader.name!r} "
                    f"and controller {controller.name!r}"
                )
                mission = {**controller.mission, "runs": comparison.runs}
                yield ComparisonCell(
                    layout=study.name,
                    link=link.name,
                    reader=reader.name,
                    controller=controller.name,
                    study=_combined(
                        msgspec.structs.replace(study, seed=comparison.seed),
                        link,
                        {"reader": reader.reader, "mission": mission},
                        source=source,
                    ),
                    published_rmse_m=layout.published_rmse_m,
                )


def _combined(
    study: Study, link: LinkEntry, others: dict[str, dict[str, Any]], *, source: str
) -> Study:
    """Return a study with keys of its tables replaced."""
    # What no mission looks at goes, for it may contradict the new keys.
    plain = msgspec.structs.replace(study, map=Map(), layouts=(), track=None, dock=None)
    tables = {"radio": link.radio, "sensor": link.sensor, "tag": link.tag, **others}
    values: dict[str, Any] = {"tag.axis": None} if "antenna" in link.tag else {}
    for table, keys in tables.items():
        values |= {f"{table}.{key}": value for key, value in keys.items()}
    try:
        return vary(plain, values)
    except ConfigError as exc:
        msg = f"{source}: {exc}"
        raise ConfigError(msg) from exc
