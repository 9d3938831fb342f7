"""The thesis' Figs. 5.9 and 5.11: watts over the line of sight, one figure an antenna."""

import numpy as np

from octant.reader_design.experiments.choice.thesis_setup import ThesisDrive, ThesisSetup
from octant.reader_design.experiments.study.thesis_plots import thesis_figures
from octant.reader_design.setting.evaluation import failed_cell
from octant.reader_design.study_file.reader import Reader


def test_designs_of_the_thesis_are_drawn_by_antenna_and_others_are_not():
    travel = np.linspace(0.0, 5.0, 11)
    drive = ThesisDrive(
        travel_m=travel,
        rss_w=np.outer(travel, np.arange(1.0, 9.0)) * 1e-6,
        start_rss_w=np.zeros(8),
    )
    cells = [
        failed_cell(Reader(antenna=kind, plate_height_m=height), f"{kind}{height}", "")
        for kind, height in (("dipole", 0.0), ("dipole", 0.08), ("monopole", 0.0))
    ]
    drives = {cell.key: drive for cell in cells[:2]}
    (figure,) = thesis_figures(ThesisSetup(drives=drives, antennas={}), cells)
    assert figure.file == "thesis_rss_dipole.png"
    assert "5.9" in figure.caption
    panels = [ax for ax in figure.figure.axes if ax.get_visible()]
    assert len(panels) == 2
    first = panels[0].lines[0]
    np.testing.assert_allclose(first.get_xdata()[[0, -1]], [3.0, np.sqrt(34.0)])
    np.testing.assert_allclose(first.get_ydata(), travel)
    assert panels[0].get_ylabel() == "RSS [µW]"
