"""Ports and patterns over a band without currents, against the currents at each frequency."""

import numpy as np
import pytest

from octant.em.reader.fullwave.band import FullwaveBand, solve_band
from octant.em.reader.fullwave.band_ports import FAR_NODES, FAR_TOLERANCE, ports_over
from octant.em.reader.fullwave.conductor import Conductor
from octant.em.reader.fullwave.mesh import reader_mesh
from octant.em.reader.fullwave.result import FullwaveResult
from octant.em.reader.fullwave.single import dipole_mesh
from octant.geometries.reader_body import reader_body

BAND_HZ = np.linspace(2.3e9, 2.5e9, 21).tolist()
THETA = np.radians(np.arange(0.0, 181.0, 5.0))


@pytest.fixture(scope="module")
def lossy():
    mesh = reader_mesh(
        reader_body(antenna_radius_m=0.05),
        frequency_hz=BAND_HZ[-1],
        cells_per_wavelength=6.0,
        conductor=Conductor(conductivity_s_per_m=1e5),
    )
    return solve_band(mesh, BAND_HZ)


def counted(monkeypatch):
    """Count the far fields of currents that are made."""
    calls, at = [], FullwaveBand.at
    monkeypatch.setattr(
        FullwaveBand, "at", lambda self, f: calls.append(f) or at(self, f), raising=True
    )
    return calls


def test_few_far_fields_give_those_of_a_band(lossy, monkeypatch):
    calls = counted(monkeypatch)
    found = list(ports_over(lossy, BAND_HZ))
    assert len(calls) == FAR_NODES + 1
    for frequency_hz, ports in zip(BAND_HZ, found, strict=True):
        direct = lossy.at(frequency_hz)
        assert ports.frequency_hz == frequency_hz
        np.testing.assert_array_equal(ports.admittance_s, direct.admittance_s)
        ours, theirs = (one.pattern_grid(THETA, 24) for one in (ports, direct))
        limit = 2.0 * FAR_TOLERANCE * np.abs(theirs).max()
        np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=limit)
        for name in ("lost_share", "radiated_share"):
            np.testing.assert_allclose(getattr(ports, name), getattr(direct, name), rtol=1e-5)
        assert ports.lost_share.min() > 0.01


def test_a_band_that_is_too_wide_for_them_takes_each_from_its_currents(monkeypatch):
    wide_hz = np.linspace(1.0e9, 3.5e9, 15).tolist()
    mesh = dipole_mesh(frequency_hz=3.5e9, cells_per_wavelength=6.0, length_m=0.2)
    band = solve_band(mesh, wide_hz, nodes=12)
    calls = counted(monkeypatch)
    found = list(ports_over(band, wide_hz))
    assert all(isinstance(ports, FullwaveResult) for ports in found)
    assert calls[-len(wide_hz) :] == wide_hz


def test_few_frequencies_are_not_interpolated(lossy, monkeypatch):
    calls = counted(monkeypatch)
    found = list(ports_over(lossy, BAND_HZ[:3]))
    assert [ports.frequency_hz for ports in found] == calls == BAND_HZ[:3]


def test_patterns_towards_single_directions_are_those_of_the_currents(lossy):
    result = lossy.results[0]
    theta, phi = np.array([0.3, 1.0, 2.2, 0.5 * np.pi]), np.array([0.0, 2.7, -1.0, 6.9])
    found, expected = result.pattern_towards(theta, phi), result.far_field(theta, phi)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-7 * np.abs(expected).max())
