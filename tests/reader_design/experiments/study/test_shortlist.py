"""Laws of the short list: sizes, missions beside scores, reasons."""

import dataclasses
from pathlib import Path

import msgspec
import numpy as np
import pytest
import xarray as xr

from octant.reader_design.experiments.missions.stage import RoomMission
from octant.reader_design.experiments.study.mission_sections import shortlist_table
from octant.reader_design.experiments.study.shortlist import DrivenDesign, ranked_by_missions
from octant.reader_design.setting.ranking import Candidate, choose
from octant.reader_design.setting.reasons import MISSIONS
from octant.reader_design.setting.scores import score_rss
from octant.reader_design.study_file.choice import Choice
from octant.reader_design.study_file.reader import Reader

DESIGN = Reader(
    antenna="dipole",
    antenna_length_m=0.06,
    antenna_radius_m=0.08,
    plate_height_m=0.05,
    ground_plane_m=0.2,
    ground_plane_shape="round",
    antennas=8,
    gap_m=0.02,
    monopole_plane_m=0.04,
    height_m=0.3,
    load_ohm=50.0,
)
ELEMENTS = np.arange(8) * np.pi / 4
AZIMUTHS = np.arange(48) * np.pi / 24
SCORES = score_rss(
    (1e-6 * (1 + 0.8 * np.cos(AZIMUTHS[:, None] - ELEMENTS)))[None], AZIMUTHS, ELEMENTS
)


@pytest.mark.parametrize(
    ("changed", "size"),
    [
        ({}, (0.2, 0.08)),  # the dipole's upper end: gap + length
        ({"plate_height_m": 0.1}, (0.2, 0.1)),
        ({"plate_height_axis_m": 0.12}, (0.2, 0.12)),
        ({"plate_outer_radius_m": 0.15}, (0.3, 0.08)),
        ({"antenna_radius_m": 0.11}, (0.22, 0.08)),
    ],
)
def test_size_is_the_farthest_that_metal_reaches(changed, size):
    assert msgspec.structs.replace(DESIGN, **changed).size_m(2.4e9) == pytest.approx(size)


def mission(success, reason=""):
    runs = np.array(success)
    data = xr.Dataset({"success": ("run", runs), "rmse_m": ("run", 0.1 * np.ones(runs.size))})
    return RoomMission(
        name="hall",
        slug="hall",
        reason=reason,
        notes=(),
        data=None if reason else data,
        folder=Path(),
    )


def test_short_list_shows_missions_beside_scores_and_says_why():
    pool = [
        Candidate(
            label=label,
            key=label,
            free=SCORES,
            room=dataclasses.replace(SCORES, right_share=share, captured_share=0.125),
            width_m=0.2,
            height_m=0.08,
        )
        for label, share in (("worse", 0.5), ("best", 0.9), ("third", 0.3), ("fourth", 0.1))
    ]
    choice = choose(pool, model="fullwave", rules=Choice(shortlist=3, missions=2))
    driven = (
        DrivenDesign(index=1, missions=(mission([1, 1, 1, 0]),)),
        DrivenDesign(index=0, missions=(mission([], reason="the reader is deaf"),)),
    )
    table = shortlist_table(pool, choice, driven)
    assert [row[0] for row in table.rows] == ["1. best", "2. worse", "3. third"]
    assert all(len(row) == len(table.header) for row in table.rows)
    cells = dict(zip(table.header, table.rows[0], strict=True))
    assert cells["width x height [cm]"] == "20 x 8"
    assert cells["captured by a reflection"] == "12.5 %"
    # Wilson (1927) at z = 1.96: 3 of 4 is 30 % to 95 %
    assert cells["mission, hall"] == "3 of 4 (30 % to 95 %), RMSE 0.10 / 0.10 m"
    assert "95.0 % against 75.0 %" in cells["why it stands here"]
    assert table.rows[1][6] == "could not be driven"
    assert table.rows[2][6] == "not driven"


def pool_of(*shares):
    return [
        Candidate(
            label=f"reader {share:g}",
            key=f"{share:g}",
            free=SCORES,
            room=dataclasses.replace(SCORES, right_share=share),
        )
        for share in shares
    ]


def test_missions_rank_the_designs_that_drove_and_the_reason_says_what_they_changed():
    pool = pool_of(0.9, 0.7, 0.5, 0.3)
    rules = Choice(missions=3, by_missions=True)
    choice = choose(pool, model="fullwave", rules=rules)
    driven = (
        DrivenDesign(index=0, missions=(mission([1, 0, 0, 0]),)),
        DrivenDesign(index=1, missions=(mission([], reason="the reader is deaf"),)),
        DrivenDesign(index=2, missions=(mission([1, 1, 1, 0]),)),
    )
    ranked, order = ranked_by_missions(choice, pool, driven)
    assert choice.ranking == (0, 1, 2, 3)
    assert ranked.ranking == (2, 0, 1, 3)
    assert [one.index for one in order] == [2, 0, 1]
    assert ranked.decided[:2] == (MISSIONS, MISSIONS)
    assert "3 against 1 of 4 runs" in ranked.comparisons[0]
    assert len(ranked.comparisons) == len(ranked.decided) == 4
    told = " ".join(ranked.reason)
    assert "By the scores alone reader 0.9 would have been chosen" in told


def test_of_as_many_missions_the_better_scores_decide():
    pool = pool_of(0.9, 0.5)
    choice = choose(pool, model="fullwave", rules=Choice(missions=2, by_missions=True))
    driven = tuple(DrivenDesign(index=k, missions=(mission([1, 1]),)) for k in range(2))
    ranked, _ = ranked_by_missions(choice, pool, driven)
    assert (ranked.ranking, ranked.decided) == (choice.ranking, choice.decided)
    assert "did not change the choice" in " ".join(ranked.reason)
