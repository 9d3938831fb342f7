"""Laws of the comparison with the thesis: verdicts follow the numbers, either way."""

import dataclasses

import numpy as np
import pytest

from octant.reader_design.experiments.choice.thesis_claims import (
    THESIS_LEVEL_W,
    claim_sentence,
    claim_table,
    thesis_claims,
)
from octant.reader_design.setting.design import content_hash
from octant.reader_design.setting.evaluation import Cell
from octant.reader_design.setting.ranking import Candidate, choose
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.scores import SCORE_NAMES, Scores

GOOD = {"right_share": 0.9, "vector_rms_rad": 0.1, "margin_worst_db": 1.0, "usable_share": 1.0}
BAD = {"right_share": 0.3, "vector_rms_rad": 1.2, "margin_worst_db": -2.0, "usable_share": 1.0}
TRAVEL = np.linspace(0.0, 5.0, 101)


def cell(antenna, radius_m, height_m, scores, *, level_w=1e-6, **design):
    base = Reader(
        antenna=antenna,
        antenna_radius_m=radius_m,
        plate_height_m=height_m,
        **{
            "ground_plane_m": 0.20,
            "ground_plane_shape": "square",
            "antennas": 8,
            "gap_m": 0.005,
            "monopole_plane_m": 0.04,
            "height_m": 0.3,
            "load_ohm": 50.0,
            **design,
        },
    )
    rss = np.full((TRAVEL.size, 8), 0.1 * level_w)
    rss[:, 0] = level_w
    rss[TRAVEL < 0.3] *= 1e-3
    return Cell(
        key=content_hash(base.as_dict()),
        design=base,
        free=Scores(**{**dict.fromkeys(SCORE_NAMES, 0.0), **scores}),
        distances_m=np.zeros(0),
        free_rss_w=np.zeros((0, 0, 8)),
        travel_m=TRAVEL,
        travel_rss_w=rss,
    )


def claims_of(cells, tag_power_w=1.0):
    candidates = [
        Candidate(label=c.design.label(), key=c.key, free=c.free, room=None) for c in cells
    ]
    choice = choose(candidates, model="fullwave")
    return thesis_claims(cells, candidates, choice, tag_power_w=tag_power_w)


def verdict(claims, words):
    (found,) = [c for c in claims if words in c.text]
    return found.agrees


def best(**better):
    return {**GOOD, "right_share": 0.99, **better}


def test_the_best_dipole_is_read_from_the_ranking():
    cells = [cell("dipole", 0.1, 0.08, best()), cell("dipole", 0.1, 0.15, GOOD)]
    assert verdict(claims_of(cells), "best dipole") is True
    cells = [cell("dipole", 0.1, 0.08, GOOD), cell("dipole", 0.1, 0.15, best())]
    claims = claims_of(cells)
    assert verdict(claims, "best dipole") is False
    assert "h_p = 15 cm" in next(c.found for c in claims if "best dipole" in c.text)


@pytest.mark.parametrize(("scores", "useless"), [(BAD, True), (GOOD, False)])
def test_designs_without_plates_are_judged_by_share_and_bearing(scores, useless):
    cells = [cell("dipole", 0.05, 0.0, scores), cell("monopole", 0.1, 0.0, scores)]
    claims = claims_of(cells)
    assert verdict(claims, "Dipoles at r_a = 5 cm without plates") is useless
    assert verdict(claims, "Monopoles at r_a = 10 cm without plates") is useless


def test_small_radii_confuse_when_a_facing_antenna_is_not_the_strongest():
    cells = [cell("dipole", 0.05, 0.08, BAD), cell("dipole", 0.1, 0.08, BAD)]
    claims = claims_of(cells)
    assert verdict(claims, "r_a = 5 cm, h_p = 8 cm") is True
    assert verdict(claims, "r_a = 10 cm, h_p = 8 cm the") is False


def test_dipoles_and_monopoles_are_compared_by_their_best_designs():
    dipole, monopole = cell("dipole", 0.1, 0.08, GOOD), cell("monopole", 0.1, 0.08, best())
    assert verdict(claims_of([dipole, monopole]), "better than monopoles") is False
    dipole = cell("dipole", 0.1, 0.08, best(level_median_dbm=1.0))
    assert verdict(claims_of([dipole, monopole]), "better than monopoles") is True


def test_level_is_compared_at_one_watt():
    same = cell("dipole", 0.1, 0.08, GOOD, level_w=2.0 * THESIS_LEVEL_W)
    assert verdict(claims_of([same], tag_power_w=2.0), "µW") is True
    claims = claims_of([same], tag_power_w=1.0)
    assert verdict(claims, "µW") is False
    assert "3.0 dB more" in next(c.found for c in claims if "µW" in c.text)
    assert verdict(claims, "under the tag") is True


def test_other_readers_are_not_compared_with_the_thesis():
    assert claims_of([cell("dipole", 0.1, 0.08, GOOD, ground_plane_shape="round")]) == ()
    assert claims_of([cell("dipole", 0.1, 0.08, GOOD, antennas=6)]) == ()
    failed = dataclasses.replace(cell("dipole", 0.1, 0.0, GOOD), free=None, reason="no")
    good = cell("dipole", 0.07, 0.03, GOOD)
    candidate = Candidate(label="a", key=good.key, free=good.free, room=None)
    choice = choose([candidate], model="fullwave")
    assert thesis_claims([failed, good], [candidate], choice, tag_power_w=1.0) == ()


def test_sentence_counts_and_names_what_does_not_hold():
    cells = [cell("dipole", 0.1, 0.08, GOOD), cell("monopole", 0.1, 0.08, best())]
    claims = claims_of(cells)
    text = claim_sentence(claims)
    assert "Dipoles perform better than monopoles" in text
    tested = [c for c in claims if c.agrees is not None]
    assert text.startswith(f"Of {len(tested)} claims")
    assert claim_sentence([c for c in tested if c.agrees]).endswith("all hold.")
    table = claim_table(claims)
    assert len(table.rows) == len(claims)
    assert {row[1] for row in table.rows} == {"yes", "no", "–"}
