"""The current density that figures show is the one that flows through the feed."""

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.reader.fullwave.response import solved_reader
from octant.geometries.reader_body import reader_body


def test_density_times_width_at_the_feed_is_the_current_of_the_port():
    body = reader_body(antennas=4, plate_height_m=0.0, antenna_radius_m=0.08)
    antenna = make_antenna("dipole", 2.4e9)
    result = solved_reader(body, antenna, cells_per_wavelength=6.0)
    density = np.linalg.norm(result.surface_currents(0), axis=1)
    middle = result.basis.corners_m.mean(axis=1)
    centre = np.array([0.08, 0.0, 0.005 + 0.5 * antenna.length_m])
    at_feed = np.linalg.norm(middle - centre, axis=1) < 0.0025
    assert at_feed.sum() >= 4
    # a source of 1 W available power, R = 50 ohm: sqrt(8 R) = 20 V peak behind 50 ohm
    current = 20.0 / abs(result.input_impedance_ohm[0] + 50.0)
    assert density[at_feed].mean() * 0.002 == pytest.approx(current, rel=0.05)
    assert density.argmax() in np.flatnonzero(np.hypot(*(middle - centre).T[:2]) < 0.002)
