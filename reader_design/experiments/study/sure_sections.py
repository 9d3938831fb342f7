"""The report's sections on how sure the results are, and on how to get them again."""

from octant.reader_design.experiments.study.approximations import approximation_table
from octant.reader_design.experiments.study.content import StudyContent
from octant.reader_design.keeping.versions import versions
from octant.reader_design.showing.pages import ReportLink, ReportSection


def sure_section(content: StudyContent) -> ReportSection:
    """Return what limits the results: noise, placements, tolerances, models ([dB], [m]).

    Parameters
    ----------
    content : The results.
    """
    notes = dict.fromkeys(
        (
            content.choice.reason[-1],
            *(n for c in content.cells for n in c.notes),
            *(n for m in content.missions for n in m.notes),
            *content.notes,
        )
    )
    return ReportSection(
        heading="How sure this is",
        paragraphs=(*_chance(content), "What the models leave out, and what was changed:"),
        points=tuple(notes),
        tables=(approximation_table(content.approximations),) if content.approximations else (),
    )


def _chance(content: StudyContent) -> tuple[str, ...]:
    study, mission = content.setting.study, content.setting.study.mission
    said = []
    if mission is not None:
        where = (
            f", with the objects moved by up to {100.0 * mission.placement_m:.3g} cm in "
            f"{mission.placements} placements"
            if mission.placement_m > 0.0
            else ", with everything in its place"
        )
        said.append(
            f"Missions: {mission.noise_db:g} dB of noise on each reading{where}; between rooms "
            "that differ, results differ by more than between runs."
        )
    scoring = study.scoring
    said.append(
        f"Scores “as read”: {scoring.noise_db:g} dB of noise, "
        + (f"codes of {scoring.bits} bits." if scoring.bits else "exact codes.")
    )
    if content.as_built is None:
        quick = ", and this is a quick look, whose shares err by some per cent"
        said.append(
            "Readers are taken as drawn"
            + (quick if content.quick else "; a table [tolerance] tells what errors in making do")
            + "."
        )
    return tuple(said)


def reproduce_section(content: StudyContent) -> ReportSection:
    """Return the command, versions, times [s], files and the resolved study.

    Parameters
    ----------
    content : The results.
    """
    found = "; ".join(f"{n.removesuffix('_version')} {v}" for n, v in versions().items())
    quick = " --quick" if content.quick else ""
    tables = [m for m in content.missions if m.data is not None]
    endings = [".csv" if m.slug == "room" else f"-{m.slug}.csv" for m in tables]
    return ReportSection(
        heading="Reproduce it",
        paragraphs=(
            "Save the study below as study.toml, and run the command.",
            f"Seed {content.setting.study.seed}; versions: {found}.",
            (
                f"Computing time of the designs {sum(c.seconds for c in content.cells):.0f} s, of "
                f"this run of the study {content.seconds:.0f} s."
            ),
        ),
        links=(
            ReportLink(file="study.toml", what="the study with every default resolved"),
            ReportLink(file="results.nc", what="everything that was computed, with units"),
            ReportLink(file="designs.csv", what="all designs with all scores"),
            *(
                ReportLink(file=f"{stem}{ending}", what=what)
                for ending in endings
                for stem, what in (
                    ("missions", "every run of the mission"),
                    ("trajectory", "run 0, step by step"),
                )
            ),
        ),
        folded=(
            ("The command", f"octant study study.toml --out again{quick}"),
            ("The study with every default resolved (study.toml)", content.study_toml),
        ),
    )
