"""Contour maps of a sweep: one table a combination, blank where no design is."""

import io

import numpy as np
from PIL import Image

from octant.reader_design.experiments.sweep import maps
from octant.reader_design.experiments.sweep.maps import design_maps, grid_of
from octant.reader_design.showing.designs_view import Column


def column(heading, values):
    numbers = () if isinstance(values[0], str) else tuple(values)
    return Column(heading=heading, texts=tuple(map(str, values)), values=numbers)


def designs():
    """Return r_a, h_p and kind of a grid of 4 x 3 x 2 designs in some order."""
    grid = np.array([(r, h, k) for r in range(4) for h in range(3) for k in range(2)])
    return np.random.default_rng(1).permutation(grid).T


def test_a_table_holds_each_design_at_its_place_and_nothing_elsewhere():
    r_a, h_p, kind = designs()
    some = (kind == 0) & ~((r_a == 1) & (h_p == 2))
    across, up, table = grid_of(r_a[some], h_p[some], (10.0 * r_a + h_p)[some])
    expected = 10.0 * across + up[:, None]
    expected[2, 1] = np.nan
    np.testing.assert_array_equal(table, expected)


def test_every_score_that_changes_has_a_panel_of_each_combination(monkeypatch):
    monkeypatch.setattr(maps, "PANELS", (1, 3))
    r_a, h_p, kind = designs()
    names = np.array(("dipole", "monopole"))[kind].tolist()
    parameters = [column("kind", names), column("r_a [cm]", r_a.tolist())]
    parameters.append(column("h_p [cm]", h_p.tolist()))
    scores = [column(f"score {i}", (r_a * h_p + i * r_a).tolist()) for i in range(4)]
    scores.append(column("constant", [1.0] * len(r_a)))
    found = design_maps(parameters, scores)
    first, second = names[0], ({"dipole", "monopole"} - {names[0]}).pop()
    over = "Scores over r_a [cm] and h_p [cm]"
    assert [figure.title for figure in found] == [
        f"{over}: kind {kind} ({page} of 2)" for kind in (first, second) for page in (1, 2)
    ]
    wide, one = (Image.open(io.BytesIO(figure.png)).size for figure in found[:2])
    assert wide[0] > 2 * one[0]  # three panels, then the fourth; the constant has none


def test_there_is_no_map_over_two_values():
    r_a, _, kind = designs()
    parameters = [column("r_a [cm]", r_a.tolist()), column("load [ohm]", kind.tolist())]
    assert design_maps(parameters, [column("score", r_a.tolist())]) == ()
