"""``octant reader --tilts``: what tags of unknown tilt lose."""

import csv

import numpy as np
import pytest

from octant.em.antennas.embedded import ReaderResponse
from octant.em.directions import angle_grid
from octant.reader_design.face.reader_tilts import TILT_COLUMNS, tilt_table

ANTENNAS = 4
SMALL = """
name = "small"
[room]
free_space = true
[reader]
antennas = 4
antenna_radius_m = 0.08
plate_height_m = 0.0
"""


def response_of(theta_part, phi_part):
    """Return four antennas of a given polarisation, each strongest towards its own azimuth."""
    theta, phi = angle_grid(61, 120)
    azimuths = np.arange(ANTENNAS) * 2.0 * np.pi / ANTENNAS
    beam = np.exp(np.cos(phi - azimuths[:, None]))
    grid = np.repeat(beam[:, None, :], len(theta), axis=1)
    return ReaderResponse.from_centre(
        np.stack((theta_part * grid, phi_part * grid), axis=1).astype(complex),
        model="isolated",
        frequency_hz=2.4e9,
        azimuths_rad=azimuths,
        phase_centres_m=np.zeros((ANTENNAS, 3)),
    )


def test_an_upright_reader_loses_by_the_cosine_and_a_circular_one_nothing():
    upright = tilt_table(response_of(1.0, 0.0), step_deg=15.0, elevation_deg=17.0)
    loss_db = upright.mean_gain_dbi - upright.mean_gain_dbi[0]
    kept = upright.tilts_deg != 90.0
    cosine = np.cos(np.radians(upright.tilts_deg[kept]))
    np.testing.assert_allclose(loss_db[kept], 20.0 * np.log10(np.abs(cosine)), atol=1e-9)
    circular = tilt_table(response_of(1.0, 1j), step_deg=15.0, elevation_deg=17.0)
    assert np.ptp(circular.mean_gain_dbi) < 1e-9
    assert (circular.right_share == 1.0).all()


def test_tags_lean_to_the_right_as_seen_from_the_reader():
    slanted = tilt_table(response_of(1.0, 1.0), step_deg=45.0, elevation_deg=0.0)
    assert slanted.mean_gain_dbi.argmax() == 1
    assert slanted.mean_gain_dbi[3] < -200.0


def test_an_antenna_that_stands_opposite_is_not_next_to_the_tag():
    table = tilt_table(response_of(1.0, 0.0), step_deg=90.0, elevation_deg=0.0)
    turned = response_of(1.0, 0.0)
    wrong = ReaderResponse.from_centre(
        turned.pattern_at_centre[[2, 3, 0, 1]],
        model="isolated",
        frequency_hz=2.4e9,
        azimuths_rad=turned.azimuths_rad,
        phase_centres_m=turned.phase_centres_m,
    )
    assert table.right_share[0] == 1.0
    assert tilt_table(wrong, step_deg=90.0, elevation_deg=0.0).right_share[0] == 0.0


def test_the_verb_prints_and_writes_the_table(octant, study_file, tmp_path):
    study = study_file(SMALL)
    arguments = ("--model", "isolated", "--out", tmp_path / "out", "--step-deg", "30")
    call = octant("reader", study, *arguments, "--tilts", "30", "--tilts-elevation", "0")
    assert call.code == 0, call.err
    assert "next to the tag [%]" in call.out
    with (tmp_path / "out" / "tilts.csv").open() as file:
        head, *rows = csv.reader(file)
    assert tuple(head) == TILT_COLUMNS
    assert [float(row[0]) for row in rows] == [0.0, 30.0, 60.0, 90.0, 120.0, 150.0]
    refused = octant("reader", study, *arguments, "--tilts", "50").refused()
    assert "--tilts is 50 degrees" in refused


@pytest.mark.parametrize("elevation", ["-1", "90"])
def test_elevations_beyond_the_sky_are_refused(octant, study_file, elevation):
    said = octant("reader", study_file(SMALL), "--tilts", "30", "--tilts-elevation", elevation)
    assert "--tilts-elevation" in said.refused()
