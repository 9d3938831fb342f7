"""Rooms and antennas that several tests of the radio model share."""

import pytest

from octant.em.antennas.kinds import make_antenna
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene

FREQUENCY_HZ = 2.4e9


@pytest.fixture(scope="session")
def box_scene():
    return build_scene(box_room((5.0, 5.0, 3.0), material="concrete"))


@pytest.fixture(scope="session")
def dipole():
    return make_antenna("dipole", FREQUENCY_HZ)


@pytest.fixture(scope="session")
def isotropic():
    return make_antenna("isotropic_theta", FREQUENCY_HZ)
