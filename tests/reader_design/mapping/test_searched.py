"""Where tags' places are searched for: where it tells more of the fading than the maps know."""

import pytest

from octant.navigation.navigators.pose_particles import misplaced_share
from octant.reader_design.mapping.pose_filter import SEARCHED_PART, unknown_part

WAVELENGTH_M = 0.125


def searched(share, sd_m):
    survey = misplaced_share(sd_m, wavelength_m=WAVELENGTH_M)
    return unknown_part(share) < SEARCHED_PART * unknown_part(share + survey)


def test_all_fading_is_unknown_beside_an_error_field_that_covers_it():
    assert unknown_part(0.0) == 0.0
    assert unknown_part(1.0) == pytest.approx(0.75)
    assert unknown_part(1e9) == pytest.approx(1.0)


def test_places_are_searched_for_where_maps_are_better_than_the_survey():
    assert searched(0.04, 0.02)
    assert searched(0.04, 0.01)
    assert not searched(0.04, 0.004)
    # Among metal shelves the maps know little of the fading, wherever the tags hang.
    assert not searched(0.4, 0.02)
