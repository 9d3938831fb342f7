"""The report of ``octant navigate``: how the runs of one mission went, to be played back."""

import math
from collections.abc import Sequence

import numpy as np

from octant.navigation.missions.metrics import MissionMetrics, measure
from octant.navigation.missions.records import MissionResult
from octant.navigation.missions.summary import summarise, summary_sentences
from octant.reader_design.experiments.missions.advice import FAIR_SHARE, GOOD_SHARE, Advice
from octant.reader_design.keeping.versions import versions
from octant.reader_design.setting.robot import study_robot
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.drive_view import drive_widget, run_end, shown_runs
from octant.reader_design.showing.pages import (
    FigureFiles,
    Judgement,
    Mark,
    PasteAdvice,
    Report,
    ReportLink,
    ReportSection,
    ReportTable,
    Verdict,
    embedded_figures,
)
from octant.reader_design.showing.pattern_view import pattern_widget
from octant.reader_design.showing.plan import plan_of
from octant.reader_design.showing.reader_svg import reader_drawing
from octant.reader_design.showing.room_view import Way, room_widget


def mission_report(
    setting: Setting,
    results: Sequence[MissionResult],
    advice: Advice | None,
    figures: FigureFiles,
    *,
    files: Sequence[ReportLink],
    study_toml: str,
) -> Report:
    """Return the report of the runs of one mission ([m], [s], [deg]).

    Parameters
    ----------
    setting, results, advice : The room of run 0, all runs, and what to try; None: they arrive.
    figures, files, study_toml : By section; beside the report; the resolved study.
    """
    metrics = [measure(result) for result in results]
    study, design = setting.study, setting.reader
    held = shown_runs(metrics)
    ways = [Way(points_m=results[i].poses[:, :2], end=run_end(metrics[i])) for i in held]
    plan = plan_of(setting.scene, setting.reader_z_m)
    room = room_widget(setting, start_m=setting.mission.start_m, ways=ways)
    playback = drive_widget(
        setting,
        plan,
        results,
        radius_m=study_robot(study, "mission").radius_m,
        fallback=embedded_figures(figures, "mission", only="^trajectory"),
    )
    found = "; ".join(f"{n.removesuffix('_version')} {v}" for n, v in versions().items())
    return Report(
        title=f"{study.name}: the robot's missions",
        subtitle=f"{len(results)} runs with the navigator “{setting.mission.navigator}” and "
        f"{setting.mission.noise_db:g} dB of noise on each reading; reader: {design.label()}",
        summary=(),
        warnings=(),
        facts=(),
        verdict=_verdict(setting, metrics, advice),
        sections=(
            ReportSection(
                heading="The runs",
                paragraphs=tuple(summary_sentences(summarise(metrics)))[1:],
                widgets=(playback,),
                tables=(_runs_table(metrics, setting.mission.tags),),
                figures=embedded_figures(figures, "mission", without="^trajectory"),
            ),
            *(() if room is None else (ReportSection(heading="The room", widgets=(room,)),)),
            ReportSection(heading="The reader", widgets=(pattern_widget(setting.responses[0]),)),
            ReportSection(
                heading="Reproduce it",
                paragraphs=(
                    "Save the study below as study.toml, and run the command.",
                    f"Seed {study.seed}; versions: {found}.",
                ),
                points=tuple(setting.notes),
                links=tuple(files),
                folded=(
                    ("The command", "octant navigate study.toml --out again"),
                    ("The study with every default resolved (study.toml)", study_toml),
                ),
            ),
        ),
    )


def _verdict(setting: Setting, metrics: Sequence[MissionMetrics], advice: Advice | None) -> Verdict:
    reached = sum(m.success for m in metrics)
    share = reached / len(metrics)
    mark: Mark = "good" if share >= GOOD_SHARE else "fair" if share >= FAIR_SHARE else "poor"
    good = [m for m in metrics if m.success]
    errors = np.array([e for m in good for e in m.arrival_errors_m if math.isfinite(e)])
    judged = [
        Judgement(
            name="missions",
            value=f"{reached} of {len(metrics)} runs",
            said=f"{mark} (good from {100 * GOOD_SHARE:.0f} %, fair from {100 * FAIR_SHARE:.0f} %)",
            mark=mark,
        )
    ]
    if errors.size:
        judged += [
            Judgement(
                name="arrival error",
                value=f"{100.0 * np.median(errors):.1f} cm",
                said=f"median over the runs that arrived; 90 % within "
                f"{100.0 * np.quantile(errors, 0.9):.1f} cm",
            ),
            Judgement(
                name="duration",
                value=f"{np.median([m.time_s for m in good]):.0f} s",
                said=f"for {np.median([m.path_m for m in good]):.1f} m of way, medians",
            ),
        ]
    drawn = setting.reader.drawn
    carrier_hz = setting.study.radio.frequency_hz
    return Verdict(
        sentence=next(iter(summary_sentences(summarise(metrics)))),
        mark=mark,
        judgements=tuple(judged),
        advice=()
        if advice is None
        else (PasteAdvice(why=advice.sentence, lines="\n".join(advice.lines)),),
        drawing=reader_drawing(setting.reader, carrier_hz) if drawn else "",
        drawn="The reader to scale: from above, with its front up, and from the side.",
    )


def _runs_table(metrics: Sequence[MissionMetrics], tags: Sequence[str]) -> ReportTable:
    def cm(length_m: float) -> str:
        return f"{100.0 * length_m:.1f}" if math.isfinite(length_m) else "–"

    return ReportTable(
        caption="Every run. Errors are distances to the straight segment between tags, and on "
        "arrival to the tag's point.",
        header=(
            "run",
            "end",
            "time [s]",
            "way [m]",
            "RMSE [cm]",
            *(f"arrival error, {tag} [cm]" for tag in tags),
            "90 % position [cm]",
            "90 % heading [°]",
            "contacts",
        ),
        rows=tuple(
            (
                str(number),
                run_end(m) if not m.success else "every tag reached",
                f"{m.time_s:.0f}",
                f"{m.path_m:.1f}",
                cm(m.rmse_m),
                *(cm(e) for e in m.arrival_errors_m),
                cm(m.p90_position_m),
                f"{math.degrees(m.p90_heading_rad):.0f}",
                str(m.contacts),
            )
            for number, m in enumerate(metrics)
        ),
        first=8,
    )
