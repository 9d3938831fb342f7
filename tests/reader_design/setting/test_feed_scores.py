"""Scores of many feeds from one solution, against those of a study, and what is proposed by them.

The other way round each feed is put into a study file, whose reader is then solved at each
frequency with a mesh of its own and sampled by the radio model.
"""

import tomllib

import numpy as np
import pytest

from octant.em.reader.ladders import Ladder
from octant.em.reader.matching import Match, OffState
from octant.reader_design.face.reader_band import band_of
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.design import solutions
from octant.reader_design.setting.evaluation import scored_cell
from octant.reader_design.setting.feed_scores import FeedScores
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import parse_study
from octant.reader_design.study_file.reader_feed import ReaderFeed
from octant.reader_design.study_file.toml import value_text

THESIS = """
name = "thesis-reader"
[radio]
frequency_hz = {frequency_hz}
[room]
free_space = true
[[tag]]
id = "A"
position_m = [0.0, 0.0, 2.95]
antenna = "dipole"
{tag}
[reader]
antenna_radius_m = 0.10
plate_height_m = 0.08
antenna_length_m = 0.0615
{reader}
"""
BAND_HZ = (2.402e9, 2.4215e9, 2.441e9, 2.4605e9, 2.480e9)


def study_at(frequency_hz, folder, *, tag="", reader="", feed=()):
    text = THESIS.format(frequency_hz=frequency_hz, tag=tag, reader=reader)
    return parse_study("\n".join((text, *feed)), source="thesis.toml", directory=folder)


def free_scores(study):
    return scored_cell(build_setting(study)).free


@pytest.mark.parametrize("tag", ["", "axis = [0.6, -0.5, 0.7]"])
def test_scores_of_a_feed_are_those_of_a_study_with_it(tmp_path, tag):
    coarse = "cells_per_wavelength = 5\nantennas = 5"
    plain = study_at(2.4e9, tmp_path, tag=tag, reader=coarse)
    ports = [found.ports for found in solutions(plain.reader, (2.4e9,))]
    scores = FeedScores.of(plain, ports)
    off = OffState(off_ohm=1e6)
    network = Ladder.of_text("0.62 pF across, 6.2 nH in series")
    match = Match(networks=(network,) * 5, source_ohm=50.0, off=off)
    feed = (
        "[reader.feed]",
        f'match = ["{network}"]',
        "multiplexer_loss_db = 1.5",
        "off_resistance_ohm = 1e6",
    )
    for feeding, lines in ((None, ()), (match.feeding(multiplexer_loss_db=1.5), feed)):
        expected = free_scores(study_at(2.4e9, tmp_path, tag=tag, reader=coarse, feed=lines))
        found = scores.behind(feeding)
        # The patterns that a study reads hold to 1e-4 of the maximum.
        assert found.vector_rms_rad[0] == pytest.approx(expected.vector_rms_rad, rel=1e-4)
        assert found.strongest_rms_rad[0] == pytest.approx(expected.strongest_rms_rad, rel=1e-4)
        assert found.wrong_share[0] == pytest.approx(1.0 - expected.right_share, abs=2e-3)


def test_the_thesis_reader_is_matched_and_keeps_its_bearing(tmp_path):
    band = band_of(study_at(2.441e9, tmp_path), BAND_HZ, progress=Progress(quiet=True))
    lines = list(band.lines())
    table = lines[lines.index("[reader.feed]") :]
    feed = tomllib.loads("\n".join(table))["reader"]["feed"]
    assert set(feed) <= set(ReaderFeed.__struct_fields__)
    assert any("this keeps the bearing best" in line for line in lines)
    assert not any("None of them is as good" in line for line in lines)
    for frequency_hz in BAND_HZ:
        before = study_at(frequency_hz, tmp_path)
        after = study_at(frequency_hz, tmp_path, feed=table)
        ports = solutions(after.reader, (frequency_hz,))[0].ports
        assert 10.0 * np.log10(ports.reflected_share.max()) <= -10.0
        assert solutions(before.reader, (frequency_hz,))[0].ports.reflected_share.min() > 0.3
        old, new = free_scores(before), free_scores(after)
        assert new.vector_rms_rad < 0.9 * old.vector_rms_rad
        assert new.strongest_rms_rad <= old.strongest_rms_rad
        assert new.right_share >= old.right_share
        assert new.margin_mean_db > old.margin_mean_db
        assert new.level_median_dbm > old.level_median_dbm + 2.0


def test_a_multiplexer_that_is_there_keeps_its_loss_and_ends(tmp_path):
    keys = {"multiplexer_loss_db": 0.8, "off_resistance_ohm": 1e6, "cable_m": 0.02, "coil_q": 40.0}
    feed = ["[reader.feed]", *(f"{key} = {value_text(value)}" for key, value in keys.items())]
    study = study_at(2.441e9, tmp_path, reader="cells_per_wavelength = 6", feed=feed)
    lines = list(band_of(study, BAND_HZ[::2], progress=Progress(quiet=True)).lines())
    table = tomllib.loads("\n".join(lines[lines.index("[reader.feed]") :]))["reader"]["feed"]
    assert table.pop("match")
    assert table == keys
