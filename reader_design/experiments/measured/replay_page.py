"""The report of ``octant replay``."""

import math
from collections.abc import Sequence

from octant.reader_design.experiments.measured.replay import Replayed
from octant.reader_design.experiments.measured.replay_results import (
    Limits,
    Summary,
    sentences,
    summary_of,
    summary_of_all,
)
from octant.reader_design.experiments.measured.replay_run import Replay
from octant.reader_design.keeping.versions import versions
from octant.reader_design.showing.pages import (
    FigureFiles,
    Judgement,
    Report,
    ReportLink,
    ReportSection,
    ReportTable,
    Verdict,
    embedded_figures,
)

_WHAT = {
    "strongest": "the azimuth of the strongest antenna",
    "vector_sum": "the first harmonic of the RSS over the antennas' azimuths",
    "pattern": "the bearing whose patterns fit the readings best",
    "tracker": "a particle filter of the tag's place, by patterns and odometry",
    "map": "a particle filter of the robot's pose, by field maps of the room",
}


def replay_report(
    replay: Replay,
    found: Sequence[Replayed],
    limits: Limits,
    figures: FigureFiles,
    *,
    log: str,
    command: str,
    files: Sequence[ReportLink],
    study_toml: str,
) -> Report:
    """Return the report of a replay [deg], [m], [s].

    Parameters
    ----------
    replay, found, limits : What was replayed; what the estimator said; when it has converged.
    figures, files : By section; beside the report.
    log, command, study_toml : Name of the log; what was typed; the resolved study.
    """
    estimator = replay.options.estimator
    said = sentences(estimator, found, limits)
    found_versions = "; ".join(f"{n.removesuffix('_version')} {v}" for n, v in versions().items())
    where = ", ".join(f"{math.degrees(a):.0f}°" for a in replay.azimuths_rad)
    return Report(
        title=f"{replay.setting.study.name}: a recorded drive replayed",
        subtitle=f"{log}, through {_WHAT[estimator]}; antennas at {where} from the front",
        summary=(),
        warnings=replay.notes,
        facts=(),
        verdict=Verdict(
            sentence=said[1],
            further=(said[0], *said[2:]),
            judgements=_judgements(summary_of_all(found, limits)),
        ),
        sections=(
            ReportSection(
                heading="How it went",
                tables=(_table(found, limits),),
                figures=embedded_figures(figures, "replay"),
            ),
            ReportSection(
                heading="Reproduce it",
                paragraphs=(
                    "Save the study below as study.toml, and run the command.",
                    f"Seed {replay.setting.study.seed}; versions: {found_versions}.",
                ),
                points=tuple(replay.setting.notes),
                links=tuple(files),
                folded=(
                    ("The command", command),
                    ("The study with every default resolved (study.toml)", study_toml),
                ),
            ),
        ),
    )


def _judgements(whole: Summary) -> tuple[Judgement, ...]:
    judged = []
    if math.isfinite(whole.median_deg):
        judged.append(
            Judgement(
                name="bearing error",
                value=f"{whole.median_deg:.1f}°",
                said=f"median of all rounds; 90 % within {whole.p90_deg:.0f}°; by chance 90°",
            )
        )
    if math.isfinite(whole.place_median_m):
        judged.append(
            Judgement(
                name="place error",
                value=f"{whole.place_median_m:.2f} m",
                said=f"median of each tag's second half; {whole.place_final_m:.2f} m at the end",
            )
        )
    return tuple(judged)


def _table(found: Sequence[Replayed], limits: Limits) -> ReportTable:
    def cell(value: float, digits: int = 1) -> str:
        return f"{value:.{digits}f}" if math.isfinite(value) else "–"

    each = [summary_of(one, limits) for one in found]
    return ReportTable(
        caption="Every tag. A tag has converged when its error stays below the limit to the end; "
        "the place counts over the second half of its rounds.",
        header=(
            "tag",
            "rounds",
            "heard [%]",
            "bearing error, median [°]",
            "90 % [°]",
            "bias [°]",
            "place error [m]",
            "at the end [m]",
            "converged after [s]",
        ),
        rows=tuple(
            (
                one.tag,
                str(one.rounds),
                cell(100.0 * one.heard_share, 0),
                cell(one.median_deg),
                cell(one.p90_deg),
                cell(one.bias_deg),
                cell(one.place_median_m, 2),
                cell(one.place_final_m, 2),
                cell(one.converged_s, 0),
            )
            for one in (*each, summary_of_all(found, limits))
        ),
    )
