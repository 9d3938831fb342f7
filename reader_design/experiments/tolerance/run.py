"""``octant tolerance`` from the study to its files."""

from pathlib import Path

from octant.geometries.files import write_text
from octant.reader_design.experiments.tolerance.linear import single_steps
from octant.reader_design.experiments.tolerance.page import tolerance_section
from octant.reader_design.experiments.tolerance.results import FILES, write_results
from octant.reader_design.experiments.tolerance.study import (
    DERIVATIVES,
    planned,
    run_tolerance_study,
)
from octant.reader_design.keeping.keeper import RecordCodec
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.results import STUDY_FILE, refuse_another, write_once
from octant.reader_design.setting.cost import Cost, reader_cost
from octant.reader_design.study_file.loading import to_toml
from octant.reader_design.study_file.schema import Study

CASES = "cases"
OF_A_SOLUTION = 0.4
"""Time of the derivative by one antenna's or plate's error over that of a built reader [-]."""


def plan_lines(study: Study, out_dir: Path, *, samples: int | None = None) -> tuple[str, ...]:
    """Return what a tolerance study would do.

    Parameters
    ----------
    study : Reader, tag, room, ``[tolerance]``.
    out_dir : Folder of the results, where readers may be kept already.
    samples : Readers built; None: the study's.
    """
    kept = len(list((out_dir / CASES).glob(f"[!.]*{RecordCodec.suffix}")))
    plan = planned(study, samples=samples)
    return (
        f"{plan.text()}; {kept} are kept in {out_dir}.",
        f"expected: {tolerance_cost(study, samples=samples).text()}.",
    )


def tolerance_cost(study: Study, *, samples: int | None = None) -> Cost:
    """Return what a tolerance study takes; a reader with errors of its own has no symmetry left.

    Parameters
    ----------
    study, samples : As for `plan_lines`.
    """
    plan = planned(study, samples=samples)
    built = reader_cost(study, symmetric=False).times(plan.built, "readers", "tolerance.samples")
    cost = built.and_then(reader_cost(study).times(plan.readers - plan.built, "other readers"))
    if study.tolerance is None or study.tolerance.slopes != DERIVATIVES:
        return cost
    moves = OF_A_SOLUTION * len(single_steps(study.reader.antennas))
    own = reader_cost(study, symmetric=False).times(
        1 + round(moves), "readers' worth of derivatives"
    )
    return cost.and_then(own)


def run_tolerance(
    study: Study,
    out_dir: Path,
    *,
    samples: int | None = None,
    workers: int | None = 1,
    cluster: str | None = None,
    force: bool = False,
    progress: Progress | None = None,
) -> tuple[str, ...]:
    """Return what a person wants to read at the end, and leave results, figures and the report.

    Parameters
    ----------
    study : Reader, tag, room, ``[tolerance]``.
    out_dir : Folder of the results; made when missing.
    samples : Readers built; None: the study's. More of them keep the first ones.
    workers : Processes; None: one for each core.
    cluster : Address of a dask scheduler, or ``local:N``, in place of ``workers``.
    force : Replace the results of another study in that folder; else refused.
    progress : Shows what happens.
    """
    progress = progress or Progress()
    text = to_toml(study, relative_to=out_dir)
    refuse_another(out_dir, text, force=force, outputs=(*FILES, "figures/*.png"))
    write_text(out_dir / STUDY_FILE, text)
    result = run_tolerance_study(
        study, out_dir / CASES, samples=samples, workers=workers, cluster=cluster, progress=progress
    )

    def write() -> list[Path]:
        write_results(result, out_dir)
        return [*(out_dir / name for name in FILES), *sorted((out_dir / "figures").glob("*.png"))]

    built = (result.chosen, *result.rivals)
    write_once(
        out_dir / CASES / "finished.json",
        [text, [[one.name, one.nominal, one.samples] for one in built]],
        write,
        force=force,
        progress=progress,
    )
    return tolerance_section(result, ()).paragraphs
