"""The chosen reader and the next best as built, where a study asks for tolerances."""

from pathlib import Path

from octant.em.blocks import cores
from octant.reader_design.experiments.tolerance.results import write_results
from octant.reader_design.experiments.tolerance.study import run_tolerance_study
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.evaluation import Cell
from octant.reader_design.showing.pages import ReportSection
from octant.reader_design.study_file.schema import Study


def tolerance_stage(
    study: Study,
    second: Cell | None,
    *,
    folder: Path,
    progress: Progress,
    workers: int | None = None,
) -> ReportSection | None:
    """Return the report's section on tolerances ([mm], [deg]); None where the study has none.

    Parameters
    ----------
    study, second : The chosen cell's own; the next best design, built with the same errors.
    folder, progress, workers : For results; shows readers; processes, None: one for each core.
    """
    if study.tolerance is None:
        return None
    result = run_tolerance_study(
        study,
        folder / "cases",
        rivals=() if second is None else ((f"the next best, {second.label}", second.design),),
        workers=cores() if workers is None else workers,
        progress=progress,
    )
    return write_results(result, folder)
