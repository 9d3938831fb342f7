"""``octant sweep``: plan, compute what is missing, and one table of it all in a folder."""

from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from octant.em.blocks import cores
from octant.geometries.errors import OctantError
from octant.geometries.files import write_text
from octant.reader_design.experiments.sweep.cells import label_of
from octant.reader_design.experiments.sweep.plan import (
    LEFT_OUT,
    SweepPlan,
    compute_cell,
    plan_sweep,
)
from octant.reader_design.experiments.sweep.table import (
    CELLS_FOLDER,
    CSV_FILE,
    MISSING,
    CellRow,
    known_rows,
    missing_cells,
    row_of,
    score_codec,
    write_table,
)
from octant.reader_design.keeping.keeper import map_cases
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.results import STUDY_FILE, complete_line, refuse_another
from octant.reader_design.keeping.workers import open_crew
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import to_toml
from octant.reader_design.study_file.schema import Study

MOST_LINES = 40
"""Cells that are listed one by one at most [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepOutcome:
    """What a sweep leaves.

    Attributes
    ----------
    plan, rows : All its cells; what is computed, by key.
    folder : Where everything lies.
    """

    plan: SweepPlan
    rows: Mapping[str, CellRow]
    folder: Path

    @property
    def failed(self) -> tuple[tuple[str, str], ...]:
        """Label and reason of every cell without scores that was tried."""
        tried = ((cell.label, self.rows.get(cell.key)) for cell in self.plan.cells)
        return tuple((label, row.reason) for label, row in tried if row is not None and row.reason)

    @property
    def scored_count(self) -> int:
        """Number of cells with scores [-]."""
        return sum(row.free is not None for row in self.rows.values())

    def lines(self) -> tuple[str, ...]:
        """Return what a person wants to read at the end, counts without unit."""
        ends = Counter(
            row.status if (row := self.rows.get(cell.key)) is not None else MISSING
            for cell in self.plan.cells
        )
        counts = ", ".join(f"{count} {status}" for status, count in ends.most_common())
        reasons = [f"No scores for {label}: {reason}" for label, reason in self.failed]
        if len(reasons) > MOST_LINES:
            more = f"... and {len(reasons) - MOST_LINES} more: see {self.folder / CSV_FILE}."
            reasons = [*reasons[:MOST_LINES], more]
        return (
            f"{len(self.plan.cells)} cells: {counts}.",
            *reasons,
        )


def study_plan(study: Study) -> SweepPlan:
    """Return the cells of a study's sweep with the sampling of final figures; lengths in [m].

    Parameters
    ----------
    study : From :func:`octant.reader_design.study_file.loading.load_study`.
    """
    return plan_sweep(build_setting(study))


def sweep_study(
    study: Study,
    out_dir: Path,
    *,
    workers: int | None = 1,
    cluster: str | None = None,
    merge_only: bool = False,
    force: bool = False,
    progress: Progress | None = None,
) -> SweepOutcome:
    """Return the outcome of a study's sweep and leave its cells and tables in a folder.

    An interrupt is passed on; the same call then goes on from what is kept.

    Parameters
    ----------
    study : From :func:`octant.reader_design.study_file.loading.load_study`.
    out_dir : Folder of the sweep; made when missing.
    workers : Processes, no more than there are cells; 1: this one; None: one for each core. A
        script that starts processes must guard its main part with ``if __name__ == "__main__"``.
    cluster : Address of a dask scheduler, or ``local:N``; instead of ``workers``.
    merge_only : Only make the tables of what is computed already.
    force : Go on in a folder that holds another sweep, keeping the cells that fit; else refused.
    progress : Shows what happens.
    """
    progress = progress or Progress()
    text = to_toml(study, relative_to=out_dir)
    refuse_another(out_dir, text, force=force)
    plan = study_plan(study)
    for note in plan.setting.notes:
        progress.say(note)
    rows = known_rows(plan, out_dir, progress=Progress() if not merge_only else progress)
    missing = 0 if merge_only else len(missing_cells(plan, rows))
    at_most = min(cores() if workers is None else workers, max(1, missing))
    with open_crew(workers=at_most, cluster=cluster if missing else None) as crew:
        write_text(out_dir / STUDY_FILE, text)
        try:
            kept = (
                ()
                if merge_only
                else map_cases(
                    compute_cell,
                    plan.cells,
                    context=None,
                    folder=out_dir / CELLS_FOLDER,
                    codec=score_codec(out_dir),
                    leave_out=LEFT_OUT,
                    crew=crew,
                    progress=progress,
                    label="cells",
                    name=label_of,
                )
            )
        except KeyboardInterrupt:
            with suppress(OctantError):
                write_table(plan, known_rows(plan, out_dir, progress=Progress()), out_dir, text)
            raise
    pairs = zip(plan.cells, kept, strict=not merge_only)
    rows |= {planned.key: row_of(planned, one) for planned, one in pairs}
    if not write_table(plan, rows, out_dir, text) and not missing:
        progress.say(complete_line(out_dir))
    return SweepOutcome(plan=plan, rows=rows, folder=out_dir)
