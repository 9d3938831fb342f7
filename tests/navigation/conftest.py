"""A closed-form free-space link: two vertical half-wave dipoles and an idealised sector pattern."""

from dataclasses import dataclass

import numpy as np
import pytest
from thesis_robot import THESIS_POINTS_M, thesis_mission

from octant.navigation.navigators.arrival import arrival_tests
from octant.navigation.sensing.sensor import FieldSensor

WAVELENGTH_M = 299_792_458.0 / 2.4e9
DIPOLE_GAIN = 1.6409


@dataclass(frozen=True, slots=True, kw_only=True)
class FreeSpaceLink:
    """Friis' formula for one tag; antenna i sees it through |cos((φ - δ_i)/2)|^sector_power.

    sector_power 4 is the amplitude factor cos²((φ - δ)/2), 8 is cos⁴((φ - δ)/2).
    """

    tag_m: tuple[float, float, float]
    azimuths_rad: tuple[float, ...]
    sector_power: float = 8.0
    reader_height_m: float = 0.3
    tag_power_w: float = 1.0

    def rss_w(self, poses):
        dx = self.tag_m[0] - poses[:, 0]
        dy = self.tag_m[1] - poses[:, 1]
        height = self.tag_m[2] - self.reader_height_m
        range_m = np.sqrt(dx**2 + dy**2 + height**2)
        cosine = height / range_m
        sine = np.hypot(dx, dy) / range_m
        gain = np.zeros_like(sine)
        off = sine > 1e-9
        gain[off] = DIPOLE_GAIN * (np.cos(np.pi / 2 * cosine[off]) / sine[off]) ** 2
        bearing = np.arctan2(dy, dx) - (poses[:, 2] - np.pi / 2)
        away = bearing[:, None] - np.array(self.azimuths_rad)
        sector = np.abs(np.cos(away / 2)) ** self.sector_power
        friis = self.tag_power_w * (WAVELENGTH_M / (4 * np.pi * range_m)) ** 2
        return (friis * gain**2)[:, None] * sector


def even_azimuths(antennas):
    return tuple(2 * np.pi * np.arange(antennas) / antennas)


@pytest.fixture
def free_space_link():
    """Link of one tag; the tag stands off the 3 m ceiling by 5 cm."""

    def make(point_m=(0.0, 0.0), *, antennas=8, height_m=2.95, **options):
        return FreeSpaceLink(
            tag_m=(*point_m, height_m), azimuths_rad=even_azimuths(antennas), **options
        )

    return make


@pytest.fixture
def thesis_links(free_space_link):
    def make(**options):
        return {tag: free_space_link(point, **options) for tag, point in THESIS_POINTS_M.items()}

    return make


@pytest.fixture
def thesis_setup(thesis_links):
    """Mission and sensor of thesis 5.4 in free space."""

    def make(*, noise_db=0.0, antennas=8, radius_m=0.20, cruise_step_m=0.09, **options):
        links = thesis_links(antennas=antennas, **options)
        tests = arrival_tests(
            links, list(THESIS_POINTS_M), list(THESIS_POINTS_M.values()), radius_m=radius_m
        )
        sensor = FieldSensor(
            links=links, azimuths_rad=np.array(even_azimuths(antennas)), noise_db=noise_db
        )
        return thesis_mission(tests, cruise_step_m=cruise_step_m), sensor

    return make
