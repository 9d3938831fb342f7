"""Every figure of a docking study, made and written."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from octant.navigation.control.docking_law import DockingLaw
from octant.navigation.docking.task import DockingResult
from octant.reader_design.experiments.docking.experiments import (
    FilterExperiment,
    figure_4_law,
    figure_4_loops,
    regulator_loops,
)
from octant.reader_design.experiments.docking.filter_figures import (
    consistency_figure,
    error_histogram_figure,
    filter_path_figure,
    filter_states_figure,
    slips_figure,
)
from octant.reader_design.experiments.docking.law_figures import (
    docking_law_figure,
    gain_region_figure,
    regulators_figure,
)
from octant.reader_design.experiments.docking.mission_figures import (
    docking_errors_figure,
    docking_figure,
    docking_ways_figure,
    stall_figure,
)
from octant.reader_design.setting.scene import StudyScene
from octant.reader_design.showing.plan import plan_of
from octant.reader_design.showing.style import save_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def law_figures(law: DockingLaw) -> dict[str, "Figure"]:
    """Return the figures of the laws without noise [m], [s], [rad].

    Parameters
    ----------
    law : DockingLaw
        The study's docking law, marked among the published ones.

    Returns
    -------
    dict of str to Figure
        By file name.
    """
    return {
        "dock_law": docking_law_figure(figure_4_loops(), figure_4_law()),
        "dock_regulators": regulators_figure(regulator_loops()),
        "dock_gains": gain_region_figure(
            {
                "paper, Fig. 4": figure_4_law(),
                "paper, Fig. 18": DockingLaw(),
                "textbook, Fig. 11.20": DockingLaw(gamma_per_s=1.0, k_per_s=2.5, h=3.0),
                "this study": law,
            }
        ),
    }


def filter_figures(experiment: FilterExperiment, straight: FilterExperiment) -> dict[str, "Figure"]:
    """Return the figures of the landmark filters, figures 6 to 17 of the paper [m], [s], [rad].

    Parameters
    ----------
    experiment : FilterExperiment
        Many drives.
    straight : FilterExperiment
        The simpler drive.

    Returns
    -------
    dict of str to Figure
        By file name.
    """
    drives, made = experiment.drives, experiment.estimates
    return {
        "dock_filter_path": filter_path_figure(
            drives,
            {"estimate": made["slips"], "estimate 2 (wrong start)": made["wrong start"]},
            title="Ground truth and estimates (Fig. 6)",
        ),
        "dock_filter_no_slips": filter_states_figure(
            drives, made["no slips"], title="Slips not estimated (Fig. 7 to 9)"
        ),
        "dock_filter_slips": filter_states_figure(
            drives, made["slips"], title="Slips estimated (Fig. 11 to 13)"
        ),
        "dock_slips": slips_figure(
            drives, made["slips"], title="Estimated slips, b = -0.01 m/s (Fig. 14 to 16)"
        ),
        "dock_filter_straight": filter_path_figure(
            straight.drives,
            {
                "estimate (no slips)": straight.estimates["no slips"],
                "estimate 2 (slips)": straight.estimates["slips"],
            },
            title="A drive at constant speed (Fig. 17)",
        ),
        "dock_histograms": error_histogram_figure(
            drives,
            {"slips": made["slips"], "no slips": made["no slips"]},
            at_s=float(drives.time_s[drives.blackout_end(30.0).max()]),
        ),
        "dock_consistency": consistency_figure(
            drives, {"coupled filter": made["slips"], "the paper's pair": made["pair"]}
        ),
    }


def mission_figures(
    rooms: Mapping[str, tuple[StudyScene, Sequence[DockingResult]]],
    dockings: Mapping[bool, Sequence[DockingResult]],
    *,
    tag_id: str,
) -> dict[str, "Figure"]:
    """Return the figures of the missions and of the dockings on estimates [m], [s], [rad].

    Parameters
    ----------
    rooms : mapping of str to (StudyScene, sequence of DockingResult)
        Room and runs by name.
    dockings : mapping of bool to sequence of DockingResult
        By whether slips were compensated.
    tag_id : str
        The station's tag.

    Returns
    -------
    dict of str to Figure
        By file name.
    """
    built = next(iter(rooms.values()))[0]
    shown = next((r for r in dockings[True] if r.success), dockings[True][0])
    task = shown.task
    return {
        "dock_ways": docking_ways_figure(
            [
                (name, runs, plan_of(scene.scene, scene.reader_z_m))
                for name, (scene, runs) in rooms.items()
            ],
            (tag_id, built.tag(tag_id).point_m),
            title="From random starts to the dock",
        ),
        "dock_errors": docking_errors_figure({name: runs for name, (_, runs) in rooms.items()}),
        "dock_run": docking_figure(shown, title="Docking on estimates (Fig. 18, 19)"),
        "dock_stall": stall_figure(dockings, task.fine.law, slip_m_per_s=task.slip.linear_m_per_s),
    }


def save_figures(figures: Mapping[str, "Figure"], folder: Path) -> dict[str, Path]:
    """Return the PNG files of figures, once written.

    Parameters
    ----------
    figures : mapping of str to Figure
        By file name.
    folder : Path
        Where they go.

    Returns
    -------
    dict of str to Path
        By file name.
    """
    paths = {name: folder / f"{name}.png" for name in figures}
    for name, figure in figures.items():
        save_figure(figure, paths[name])
    return paths
